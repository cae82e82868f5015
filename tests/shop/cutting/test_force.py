"""Cutting forces: hand-computed numbers, and the mean of the model by summing over a turn."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.program.setup import kienzle, linear_edge
from vcmm.shop.cutting.force import (
    at_chip,
    immersion,
    mean_chip,
    milling_force,
    to_workpiece,
    turning_force,
)


def test_kienzle_by_hand() -> None:
    """42CrMo4, b 2 mm, h 0.2 mm: 2 x 2526 x 0.2^0.75 = 5052 x 0.299070 = 1510.90 N."""
    assert turning_force(np.array(2.0), np.array(0.2), kienzle("42CrMo4")) == pytest.approx(1510.90, abs=0.01)


def test_slot_by_hand() -> None:
    """Full slot, Al7075, N 2, a 2 mm, c 0.1: from 0 to pi cos 2phi cancels, so
    Fx = 4/2pi (0.025 x -168.8 x 2pi - 2 x 30.8) = -16.88 - 39.216 = -56.096 N,
    Fy = 4/2pi (0.025 x 796.1 x 2pi + 2 x 27.7) = 79.61 + 35.269 = 114.879 N,
    Fz = 4/2pi (2 x 22.2 + 1.4 pi) = 28.266 + 2.8 = 31.066 N.
    """
    got = milling_force(
        np.array(0.0), np.array(np.pi), np.array(2.0), np.array(0.1), np.array(2), linear_edge("Al7075")
    )
    assert got == pytest.approx([-56.096, 114.879, 31.066], abs=2e-3)


@pytest.mark.parametrize("climb", [True, False])
def test_mean_of_the_model_by_summing_over_a_turn(climb: bool) -> None:
    of = linear_edge("Al7075")
    start, end = immersion(np.array(1.5), np.array(5.0), climb)
    phi = (np.arange(200_000) + 0.5) * 2 * np.pi / 200_000
    inside = (phi > start) & (phi < end)
    h = 0.08 * np.sin(phi)
    t, r, a = (
        (kc * h + ke) * inside * 3.0
        for kc, ke in (
            (of.tangential, of.edge_tangential),
            (of.radial, of.edge_radial),
            (of.axial, of.edge_axial),
        )
    )
    summed = 4 * np.array(
        [(-t * np.cos(phi) - r * np.sin(phi)).mean(), (t * np.sin(phi) - r * np.cos(phi)).mean(), a.mean()]
    )
    got = milling_force(start, end, np.array(3.0), np.array(0.08), np.array(4), of)
    assert got == pytest.approx(summed, rel=1e-4)


def test_climb_pushes_the_tool_away_from_the_wall() -> None:
    """Light climb cut, material on the right (-y): the part pushes the tool to the left, material is left on the wall."""
    start, end = immersion(np.array(0.5), np.array(5.0))
    assert end == pytest.approx(np.pi)
    assert math.cos(start) == pytest.approx(-0.9)  # 1 - 0.5 / 5
    force = milling_force(start, end, np.array(10.0), np.array(0.05), np.array(3), linear_edge("Al7075"))
    assert force[1] > 0
    turned = to_workpiece(
        force[None], np.array([[0.0, 1.0, 0.0]]), np.array([[0.0, 0.0, 1.0]])
    )  # feed +y: left is -x
    assert turned[0] == pytest.approx([-force[1], force[0], force[2]])


def test_unknown_material_is_explained() -> None:
    with pytest.raises(UsageError, match="42CrMo4"):
        kienzle("42CrMo")


def test_steel_is_milled_by_the_tangent_of_kienzles_law() -> None:
    """42CrMo4, slot: chip 0.1 mm per tooth is 2 x 0.1 / pi = 0.063662 mm thick on average. There h^0.75 = 0.126737:
    K_c = 0.75 x 2526 x 0.063662^-0.25 = 1894.5 x 1.990778 = 3771.5, K_e = 0.25 x 2526 x 0.126737 = 80.034; at the mean chip
    K_c h + K_e = 240.10 + 80.03 = 320.14 = 2526 x 0.126737, the law itself. Along y of a slot (N 2, a 2 mm):
    Fy = 4/2pi (0.025 x 3771.5 x 2pi + 2 x 80.034) = 377.15 + 101.90 = 479.05 N, Fx = -0.3 x 479.05 = -143.72 N.
    """
    start, stop, chip = np.array([0.0]), np.array([np.pi]), np.array([0.1])
    thickness = mean_chip(start, stop, chip)
    assert thickness == pytest.approx([0.0636620], abs=1e-6)
    edges = at_chip(kienzle("42CrMo4"), thickness)
    assert edges.tangential == pytest.approx([3771.5], rel=1e-4)
    assert edges.edge_tangential == pytest.approx([80.034], rel=1e-4)
    assert edges.tangential * thickness + edges.edge_tangential == pytest.approx(
        turning_force(np.array([1.0]), thickness, kienzle("42CrMo4"))
    )
    force = milling_force(start, stop, np.array([2.0]), chip, np.array([2]), edges)
    assert force[0] == pytest.approx([-143.72, 479.05, 0.0], rel=1e-3)
    assert mean_chip(np.array([1.0]), np.array([1.0]), chip) == pytest.approx([0.0])
