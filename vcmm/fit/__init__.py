"""Association of geometric elements with points: criterion(kind, points, start) -> Fitted."""

from __future__ import annotations

from vcmm.fit.elements import ELEMENTS, MINIMUM_POINTS, Fitted
from vcmm.fit.gauss import gauss
from vcmm.fit.sensitivity import Sensitivity, linear_fit, sensitivity

__all__ = ["ELEMENTS", "MINIMUM_POINTS", "Fitted", "Sensitivity", "gauss", "linear_fit", "sensitivity"]
