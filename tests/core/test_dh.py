"""vcmm/core/dh.py: centres and directions of joints by pencil."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.dh import LinkOfArm, arm_of_links


def test_two_joints_at_right_angles():
    # distal: d1 = 400, a1 = 150, alpha1 = -90 deg: joint 2 at (150, 0, 400) turns about turn_x(-90) z = +y; its link of 600 mm along x
    arm = arm_of_links([LinkOfArm(150.0, -np.pi / 2, 400.0), LinkOfArm(600.0, 0.0, 0.0)])
    assert arm.structure == "w b C1 B2 t"
    assert arm.axes["B2"].centre == pytest.approx((150.0, 0.0, 400.0))
    assert arm.axes["B2"].direction is None
    assert arm.flange[:3, 3] == pytest.approx([750.0, 0.0, 400.0])


def test_a_joint_about_minus_y_keeps_its_direction():
    # proximal: alpha2 = +90 deg turns z into turn_x(90) z = -y
    arm = arm_of_links([LinkOfArm(0.0, 0.0, 300.0), LinkOfArm(50.0, np.pi / 2, 0.0)], proximal=True)
    assert arm.axes["B2"].centre == pytest.approx((50.0, 0.0, 300.0))
    assert arm.axes["B2"].direction == pytest.approx((0.0, -1.0, 0.0))
    assert "direction = [0, -1, 0]" in arm.text
