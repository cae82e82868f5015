"""Settings of an uncertainty evaluation: seed, trials, coverage probability, engine, decision rule."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from vcmm.core.errors import OptionError, UsageError
from vcmm.part.gps.decision import RULES

ENGINES = ("auto", "montecarlo", "exact")
MOST_TRIALS = 100_000_000_000  # five hours of two cores for a task of 28 inputs
LARGEST_P = 0.999999  # beyond it no law of an Input is known
REPORTED, CORRECTED = "reported", "corrected"


@dataclass(frozen=True)
class Settings:
    """trials: Monte Carlo trials (JCGM 101 suggests 10^6); p: coverage probability; kind: symmetric | shortest.

    production: characteristic -> (mean from the middle of the tolerance, u) of what the process makes, for risks.
    digits > 0: adaptive Monte Carlo to this many digits of u (JCGM 101, 7.9). certify: exact trials for the check.
    """

    seed: int = 0
    trials: int = 1_000_000
    p: float = 0.95
    kind: str = "symmetric"
    engine: str = "auto"
    rule: str = RULES[0]
    digits: int = 0
    known_bias: str = REPORTED
    certify: int = 200
    production: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.engine not in ENGINES:
            raise UsageError(f'engine = "{self.engine}"; allowed: {", ".join(ENGINES)}')
        if self.trials < 1000:
            raise UsageError(
                f"{self.trials} trials are too few for a coverage interval; use at least 1000 (10^6 is usual)"
            )
        if self.trials > MOST_TRIALS:
            raise UsageError(
                f"{self.trials:,} trials would take days, and at most {MOST_TRIALS:,} are run; 10^6 give U to three digits"
            )
        if not 0 <= self.seed < 2**63:
            raise UsageError(f"seed = {self.seed}; a seed is a whole number from 0 to 2^63 - 1")
        if self.known_bias not in (REPORTED, CORRECTED):
            raise UsageError(f'known_bias = "{self.known_bias}"; allowed: {REPORTED}, {CORRECTED}')
        if self.digits not in (0, 1, 2, 3):
            raise UsageError(
                f"{self.digits} digits cannot be reached by Monte Carlo in sensible time; use 1, 2 or 3"
            )
        if not 0.5 <= self.p <= LARGEST_P:
            raise UsageError(
                f"coverage probability p = {self.p:g} must lie between 0.5 and {LARGEST_P}, for example 0.95"
            )

    def with_changes(self, **changes: Any) -> Settings:
        """Return these settings with the arguments of a call in their place; None: not given. OptionError for an impossible value."""
        try:
            return replace(self, **{name: value for name, value in changes.items() if value is not None})
        except UsageError as error:
            raise OptionError(str(error)) from None
