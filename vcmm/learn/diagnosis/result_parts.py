"""Parts of a diagnosis beside the names, as values and documents.

Next measurements, names searched again in parts of the rows, a second opinion, what a file from one recording leaves of another, and steps that failed: a failure after the names is
reported, and the findings stay.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from vcmm.core.errors import VcmmError


@dataclass(frozen=True)
class NextStep:
    """An add-on measurement that separates tied answers."""

    separates: tuple[str, ...]
    do: str
    minutes: float
    gain: float
    expected_probability: float | None = (
        None  # probability of what is right, expected after it; None where no rows say
    )


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

    probability_limits: of every term the largest probability that the parts allow.
    """

    same: dict[str, bool | None]
    text: tuple[str, ...]
    probability_limits: tuple[float, ...]


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
        "expected_probability": n.expected_probability,
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


T = TypeVar("T")


@dataclass(frozen=True)
class Failure:
    """A step that did not succeed, and why."""

    step: str
    text: str


@dataclass(frozen=True, eq=False)
class Attempt:
    """failures: of VcmmError and of the operating system, in words; bugs: what else was raised, to be raised again once
    everything is printed.
    """

    failures: list[Failure]
    bugs: list[Exception]

    @classmethod
    def none(cls) -> Attempt:
        return cls([], [])

    def __call__(self, step: str, work: Callable[[], T], otherwise: T) -> T:
        """Run the work and return its result; `otherwise` where it fails."""
        try:
            return work()
        except (VcmmError, OSError) as error:
            self.failures.append(Failure(step, str(error)))
        except Exception as error:
            self.failures.append(Failure(step, f"{type(error).__name__}: {error}"))
            self.bugs.append(error)
        return otherwise

    def raise_bugs(self) -> None:
        for bug in self.bugs:
            raise bug
