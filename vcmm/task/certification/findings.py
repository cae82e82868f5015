"""Results of the acceptance test of a machine: observations beside the limits of its certificate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array


@dataclass(frozen=True)
class Finding:
    """One figure of the test as found, mm, with its standard uncertainty."""

    error: float
    u: float = 0.0

    @property
    def highest(self) -> float:
        """Upper bound of the true value: the figure and two standard uncertainties."""
        return self.error + 2.0 * self.u


@dataclass(frozen=True)
class LimitShare:
    """Largest |error| over its limit, as found; its standard uncertainty as a length u (mm) at that length, or as such a share."""

    share: float
    u: float = 0.0
    u_share: float = 0.0

    def u_at(self, limit: Array) -> Array:
        """Return the standard uncertainty of the share (m,), where the limit (m,) mm is that of the length with the largest share."""
        return np.hypot(self.u / limit, self.u_share)

    def highest(self, limit: Array) -> Array:
        """Return the upper bound of the errors (n,) mm on lengths of these limits: the share and two standard uncertainties."""
        return np.asarray((self.share + 2.0 * self.u_at(limit)) * limit)


@dataclass(frozen=True)
class Findings:
    """lengths: (length mm, error as found there); largest: largest |error| of all lengths; worst: largest |error| over its limit; None
    where it is not stated.
    """

    lengths: tuple[tuple[float, Finding], ...] = ()
    worst: LimitShare | None = None
    largest: Finding | None = None
    R0: Finding | None = None
    form: Finding | None = None
    size: Finding | None = None

    def __bool__(self) -> bool:
        single = self.worst, self.largest, self.R0, self.form, self.size
        return bool(self.lengths) or any(x is not None for x in single)

    def words(self) -> str:
        """Describe the results, as evidence of an Input; empty where there are none."""
        named = {"E0_largest": self.largest, "R0": self.R0, "P_Form": self.form, "P_Size": self.size}
        parts = [f"{n} {_um(x)}" for n, x in named.items() if x is not None]
        if self.lengths:
            worst = max((f for _, f in self.lengths), key=lambda f: abs(f.error))
            parts.insert(0, f"E0 on {len(self.lengths)} lengths, at most {_um(worst)}")
        if self.worst is not None:
            parts.insert(0, f"largest E0 {self.worst.share:.0%} of its limit")
        return ", ".join(parts)


def _um(finding: Finding) -> str:
    return f"{abs(finding.error) * 1e3:g} um" + (f" (u {finding.u * 1e3:g} um)" if finding.u else "")


def over_the_limit(
    findings: Findings, e0: Callable[[float], float] | None, short: Mapping[str, float | None]
) -> None:
    """Raise UsageError for a finding above the limit of the certificate, by name, and for lengths without one."""
    if (findings.lengths or findings.largest or findings.worst) and e0 is None:
        raise UsageError("measured E0 needs its limit E0_MPE beside it; state E0_MPE")
    problems = (
        [f"measured E0_largest: {findings.worst.share:.0%} of E0_MPE is more than it allows"]
        if findings.worst is not None and findings.worst.share > 1.0
        else []
    )
    problems += [
        f"measured E0 at {length:g} mm: {abs(f.error) * 1e3:g} um is more than E0_MPE allows there ({e0(length) * 1e3:g} um)"
        for length, f in findings.lengths
        if e0 is not None and abs(f.error) > e0(length)
    ]
    named = {"R0": findings.R0, "P_Form": findings.form, "P_Size": findings.size}
    problems += [
        f"measured {n}: {f.error * 1e3:g} um is more than its limit of {limit * 1e3:g} um"
        for n, f in named.items()
        if f is not None and (limit := short.get(n)) is not None and f.error > limit
    ]
    if problems:
        raise UsageError(
            f"{'; '.join(problems)}: such a machine did not pass. Correct the value, or state the limit that it was held to"
        )
