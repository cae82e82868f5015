"""Further evidence beside the names, as values and documents: next measurements, parts of the rows, a second opinion, transfer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class NextStep:
    """An add-on measurement that separates tied answers."""

    separates: tuple[str, ...]
    do: str
    minutes: float
    gain: float
    expected: float | None = None  # probability of what is right, expected after it; None where no rows say


@dataclass(frozen=True)
class Transfer:
    """rms (mm or rad) of a recording, without and with the file that was written from another one."""

    recording: str
    source: str
    before: float
    after: float


@dataclass(frozen=True)
class Stability:
    """kind -> True where every tested part finds the same names, None where none could be tested; text: the changes.

    most: of every term the largest probability that the parts allow.
    """

    same: dict[str, bool | None]
    text: tuple[str, ...]
    most: tuple[float, ...]


@dataclass(frozen=True)
class SecondOpinion:
    """names: ids that EBIC chooses; agrees: has it all of ours and no more; for_ours: its probability of our names."""

    names: tuple[str, ...]
    agrees: bool
    for_ours: float
    lacks: tuple[bool, ...]  # of our names, those that it does not have


@dataclass(frozen=True, eq=False)
class CrossChecks:
    """Results of the cross-checks; texts: disagreements, in words."""

    stable: Stability
    opinion: SecondOpinion

    @property
    def texts(self) -> tuple[str, ...]:
        other = self.opinion
        if other.agrees:
            return self.stable.text
        names = ", ".join(other.names) or "nothing"
        return (
            *self.stable.text,
            f"a second opinion (EBIC over the same columns) names {names}; its probability of the names here is {other.for_ours:.2g}",
        )


def next_step_json(n: NextStep) -> dict[str, Any]:
    return {
        "separates": list(n.separates),
        "do": n.do,
        "minutes": n.minutes,
        "expected_probability": n.expected,
    }


def stable_json(checks: CrossChecks | None) -> dict[str, Any]:
    """Return the document; null where a part of the rows could not be tested."""
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
