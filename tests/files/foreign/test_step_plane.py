"""A plane of a STEP file as a feature: its point is the middle of its reach."""

from __future__ import annotations

import numpy as np

from vcmm.files.foreign.step import _table
from vcmm.files.foreign.step_faces import SurfaceFace


def test_the_point_of_a_plane_is_the_middle_of_its_reach():
    """u from 0 to 10 along x, v from 2 to 6 along y, from (1, 1, 5): (1 + 5, 1 + 4, 5), 10 mm by 4 mm."""
    face = SurfaceFace(1, "plane", np.array([1.0, 1.0, 5.0]), np.eye(3), (), (0.0, 10.0, 2.0, 6.0), False)
    table = _table(face)
    assert [float(x) for x in table["point"].removesuffix(" mm").split()] == [6.0, 5.0, 5.0]
    assert [float(x) for x in table["size"].removesuffix(" mm").split()] == [10.0, 4.0]
