"""Angles of engagement of a mill by pencil, for tests of forces."""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array


def immersion(radial: float, radius: float, climb: bool = True) -> tuple[Array, Array]:
    """Return the angles (rad) at which an edge enters and leaves, for a radial depth (mm) of a mill of the given radius."""
    angle = np.arccos(1.0 - np.asarray(radial) / radius)
    return (np.pi - angle, np.full_like(angle, np.pi)) if climb else (np.zeros_like(angle), angle)
