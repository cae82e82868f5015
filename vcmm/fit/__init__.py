"""Elements through points: association by every criterion, and its sensitivities.

Imports core.
"""

from __future__ import annotations

from vcmm.fit.constrained import held, normal_matrix
from vcmm.fit.criteria import CRITERIA, Association, associate
from vcmm.fit.elements import ELEMENTS, MINIMUM_POINTS, Fitted
from vcmm.fit.gauss import gauss
from vcmm.fit.local_sizes import sphere_radii, two_point_radii
from vcmm.fit.profile import profile_line
from vcmm.fit.sensitivity import Sensitivity, linear_fit, sensitivity

__all__ = [
    "CRITERIA", "ELEMENTS", "MINIMUM_POINTS", "Association", "Fitted", "Sensitivity", "associate", "gauss", "held",
    "linear_fit", "normal_matrix", "profile_line", "sensitivity", "sphere_radii", "two_point_radii",
]  # fmt: skip
