"""Documents of what speaks beside the names: next measurements, parts of the rows, a second opinion, transfer to other recordings."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vcmm.learn.diagnosis.cross_checks import CrossChecks
    from vcmm.learn.diagnosis.result import NextStep, Transfer


def next_step_json(n: NextStep) -> dict[str, Any]:
    return {
        "separates": list(n.separates),
        "do": n.do,
        "minutes": n.minutes,
        "expected_probability": n.expected,
    }


def stable_json(checks: CrossChecks | None) -> dict[str, Any]:
    """null where a part of the rows could not be asked."""
    if checks is None:
        return {"halves": None, "alternate_rows": None, "changes": []}
    return {**checks.stable.same, "changes": list(checks.stable.text)}


def second_opinion_json(checks: CrossChecks | None) -> dict[str, Any] | None:
    if checks is None:
        return None
    other = checks.opinion
    return {
        "method": "EBIC",
        "names": list(other.names),
        "agrees": other.agrees,
        "probability": other.for_ours,
    }


def transfer_json(t: Transfer, micro: float) -> dict[str, Any]:
    return {
        "recording": t.recording,
        "from": t.source,
        "rms_before": t.before * micro,
        "rms_after": t.after * micro,
    }
