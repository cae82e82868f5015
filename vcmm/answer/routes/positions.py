"""The route by several positions: the part itself, not calibrated, measured in several places and orientations.

In the manner of the draft ISO/TS 15530-2: errors of the machine's geometry differ from position to position, so their mean is
nearly free of them, and their scatter says how nearly. No position shows the scale of the machine and the size of its
tip. Standards show both, and they are corrected:

    error of a standard i = L_i e_L + t_i delta               t = 0: centres, 2: outer faces (length) and spheres, -2: rings
    (e_L, delta) by weighted least squares, covariance C, times chi^2 / nu where the standards differ by more than they may
    y = mean of the means of the positions - c . (e_L, delta)
    u^2 = s^2 / m + c C c + (|T - 20 degC| u_alpha L)^2

s: standard deviation of the m means (repeats within a position are in it); e_L: relative error of lengths; delta: how far the tip
is too large, mm; c: change of the characteristic for points scaled by 1 (mm) and moved outwards by 1 mm.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from vcmm.answer.routes.calibrated_part import Warmth
from vcmm.answer.routes.estimate import (
    PART_EXPANSION,
    Contribution,
    RouteEstimate,
    coverage_factor,
    effective_dof,
)
from vcmm.core.errors import UsageError
from vcmm.core.run import Array

POSITIONS = "several positions"
LEAST_POSITIONS, USUAL_POSITIONS = 2, 4
LENGTH, CENTRES, RING, SPHERE = "length", "centres", "ring", "sphere"
PER_TIP = {
    LENGTH: 2.0,
    CENTRES: 0.0,
    RING: -2.0,
    SPHERE: 2.0,
}  # t: mm of reading per mm by which the tip is too large
STANDARDS = tuple(PER_TIP)
BY_STANDARDS = "scale and tip, by the standards"


@dataclass(frozen=True, eq=False)
class StandardReadings:
    """A standard: calibrated value and u mm, readings (n,) mm.

    kind: length (outer faces, a gauge block), centres (of balls, or faces that look the same way), ring (bore) or sphere.
    """

    kind: str
    calibrated: float
    u: float
    readings: Array

    @property
    def error(self) -> tuple[float, float]:
        """Mean reading - calibrated value, and its standard uncertainty, mm."""
        return float(np.mean(self.readings)) - self.calibrated, math.hypot(self.u, self.scatter)

    @property
    def scatter(self) -> float:
        """Standard uncertainty of the mean of the readings; 0 for a single one."""
        n = len(self.readings)
        return float(np.std(self.readings, ddof=1)) / math.sqrt(n) if n > 1 else 0.0

    @property
    def dof(self) -> float:
        """Effective degrees of freedom of its error: those of the scatter, and a calibration that is known for sure."""
        return effective_dof(
            [
                Contribution("readings", self.scatter, max(len(self.readings) - 1, 1)),
                Contribution("calibration", self.u),
            ]
        )


@dataclass(frozen=True, eq=False)
class Corrections:
    """(e_L, delta in mm) and their covariance (2, 2); is_shown: which of the two the standards show; dof: of the worst standard."""

    value: Array = field(default_factory=lambda: np.zeros(2))
    covariance: Array = field(default_factory=lambda: np.zeros((2, 2)))
    is_shown: tuple[bool, bool] = (False, False)
    dof: float = math.inf


def corrections(standards: Sequence[StandardReadings]) -> Corrections:
    """Scale and tip from standards. Without a ring or sphere all of it is scale, without a length all of it is tip."""
    if not standards:
        return Corrections()
    kinds = {s.kind for s in standards}
    is_known = (bool(kinds & {LENGTH, CENTRES}), bool(kinds & {RING, SPHERE}))
    errors, us = np.array([s.error for s in standards]).T
    design = np.array([[s.calibrated, PER_TIP[s.kind]] for s in standards])[:, is_known]
    weighted = design / us[:, None]
    covariance = np.linalg.inv(weighted.T @ weighted)
    numbers = covariance @ weighted.T @ (errors / us)
    over = len(standards) - len(numbers)
    if over > 0:
        covariance = covariance * max(1.0, float((((errors - design @ numbers) / us) ** 2).sum()) / over)
    at = np.flatnonzero(is_known)
    value, whole = np.zeros(2), np.zeros((2, 2))
    value[at], whole[np.ix_(at, at)] = numbers, covariance
    return Corrections(value, whole, is_known, min(s.dof for s in standards))


def several_positions(
    readings: Mapping[str, Array],
    shows: tuple[float, float],
    corrections_known: Corrections,
    warmth: Warmth | None = None,
) -> RouteEstimate:
    """Return the result of the route. readings: position -> repeats there (n,), mm or rad. shows: c of the characteristic, mm and 1.

    UsageError for a single position.
    """
    m = len(readings)
    if m < LEAST_POSITIONS:
        raise UsageError(
            f"the part was measured in {m} position; errors that stay with the position are seen from {LEAST_POSITIONS} on, {USUAL_POSITIONS} are usual"
        )
    means, c = np.array([float(np.mean(v)) for v in readings.values()]), np.array(shows)
    between = Contribution("from position to position", float(np.std(means, ddof=1)) / math.sqrt(m), m - 1)
    contributions = (
        between,
        Contribution(
            BY_STANDARDS, float(np.sqrt(c @ corrections_known.covariance @ c)), corrections_known.dof
        ),
        Contribution(PART_EXPANSION, (warmth or Warmth()).u),
    )
    remarks = [
        f"no {word} was measured: the error of {what} is in the value and not in U, so no E_n is given"
        for word, what, error, is_shown in zip(
            ("standard of length", "ring or sphere"), ("the scale", "the tip"), c, corrections_known.is_shown
        )
        if not is_shown and abs(error) > 1e-6
    ]
    kept = tuple(
        contribution for contribution in contributions if contribution.u > 0 or contribution is between
    )
    k = coverage_factor(effective_dof(kept))
    value = float(means.mean() - c @ corrections_known.value)
    return RouteEstimate(POSITIONS, value, kept, k, tuple(remarks), not remarks)
