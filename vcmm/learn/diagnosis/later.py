"""Steps after the names: written back, compared, reported. A failure there is named, and the findings stay."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from vcmm.core.errors import VcmmError

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
