"""Form deviation of a real feature: the departure of the surface from its nominal shape, known or assumed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.part.part import Feature, frame

ROUND = ("circle", "cylinder", "cone", "sphere")


@dataclass(frozen=True)
class Lobes:
    """amplitude cos(lobes (theta - phase)) along the outward normal; peak to valley = 2 amplitude. mm, rad.

    phase None: any; it counts as 0 until it is sampled. lobes 0: the shape is unknown, and counts as none.
    """

    lobes: int
    amplitude: float
    phase: float | None = 0.0

    @property
    def has_phase(self) -> bool:
        return bool(self.lobes) and self.phase is not None

    def deviation(self, feature: Feature, points: Array) -> Array:
        """Return the deviation (n,) mm along the outward normal at points (n, 3) on a round feature, theta from u of the feature."""
        if not self.lobes:
            return np.zeros(len(points))
        if feature.kind not in ROUND:
            raise UsageError(
                f"{feature.name}: lobes are a form of {', '.join(ROUND)}, not of a {feature.kind}"
            )
        u, v, _ = frame(feature)
        arm = points - feature.point
        return np.asarray(
            self.amplitude * np.cos(self.lobes * (np.arctan2(arm @ v, arm @ u) - (self.phase or 0.0)))
        )
