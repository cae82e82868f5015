"""Fit geometric elements through points by every association criterion, with their sensitivities."""

from __future__ import annotations

from vcmm.part.fit.criteria import CRITERIA, Association, associate
from vcmm.part.fit.elements import ELEMENTS, MINIMUM_POINTS, FittedElement
from vcmm.part.fit.fixed_orientation import hold_axis, normal_matrix
from vcmm.part.fit.gauss import gauss
from vcmm.part.fit.local_sizes import sphere_radii, two_point_radii
from vcmm.part.fit.profile import profile_line
from vcmm.part.fit.sensitivity import Sensitivity, linear_fit, sensitivity

__all__ = [
    "CRITERIA", "ELEMENTS", "MINIMUM_POINTS", "Association", "FittedElement", "Sensitivity", "associate", "gauss", "hold_axis",
    "linear_fit", "normal_matrix", "profile_line", "sensitivity", "sphere_radii", "two_point_radii",
]  # fmt: skip
