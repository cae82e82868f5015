"""A spiral or raster scan of a face: positions of the probe, and its readings above the programmed surface."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from vcmm.core.run import Array

Level = Literal["plane", "offset"]


@dataclass(frozen=True, eq=False)
class FaceScan:
    """x, across (n,): X mm and C rad of a spiral, or X and Y mm of a raster; reading (n,) mm above the programmed surface along +Z.

    run (n,): which scan a row belongs to. radius: of the nominal sphere, mm, + convex, 0 a plane.
    """

    name: str
    spiral: bool
    x: Array
    across: Array
    reading: Array
    run: np.ndarray
    level: Level = "plane"
    radius: float = 0.0
