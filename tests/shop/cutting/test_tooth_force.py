"""Forces while an edge makes the wall: by pencil for straight edges, by a sum over slices for a helix."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.shop.cutting.force import immersion, linear_edge, milling_force
from vcmm.shop.cutting.tooth_force import ToothCuts

AL = linear_edge("Al7075")
RADIUS, DEPTH, CHIP = 5.0, 10.0, 0.1


def cut(helix: float, teeth: int = 2, climb: bool = True, radial: float = 2.0) -> ToothCuts:
    start, exit_ = (np.atleast_1d(v) for v in immersion(radial, RADIUS, climb))
    one = np.ones(1)
    return ToothCuts(
        start, exit_, DEPTH * one, CHIP * one, teeth * np.ones(1, int), math.tan(helix) / RADIUS * one, AL
    )


@pytest.mark.parametrize(("climb", "angle", "sign"), [(True, math.pi, 1), (False, 0.0, -1)])
def test_a_straight_edge_bends_the_tool_by_its_edge_forces_alone(climb, angle, sign):
    """h = c sin(phi) = 0 at the wall. Radial 30.8 N/mm x 10 mm = 308 N away from it, tangential 27.7 x 10 = 277 N along it. The other of two
    teeth stands half a turn away, outside the cut of 53 deg. The mean over a turn is less than 300 N, and no measure of the wall."""
    found = cut(0.0, climb=climb).generating(np.array([angle]), np.array([4.0]))[0]
    assert found[:2] == pytest.approx([sign * 277.0, sign * 308.0], abs=1e-9)
    start, exit_ = immersion(2.0, RADIUS, climb)
    assert abs(float(milling_force(start, exit_, DEPTH, CHIP, 2, AL)[1])) < 300.0


def slices(helix: float, teeth: int, climb: bool, radial: float, angle: float, height: float) -> np.ndarray:
    """The sum over 20000 slices, written out here."""
    start, exit_ = (float(v) for v in immersion(radial, RADIUS, climb))
    total, n = np.zeros(3), 20000
    zeta = (np.arange(n) + 0.5) * DEPTH / n
    for tooth in range(teeth):
        phi = np.remainder(
            angle - 2 * math.pi * tooth / teeth - math.tan(helix) / RADIUS * (zeta - height), 2 * math.pi
        )
        h = np.where((phi >= start) & (phi <= exit_), CHIP * np.sin(phi), np.nan)
        on = ~np.isnan(h)
        ft, fr, fa = 796.1 * h + 27.7, 168.8 * h + 30.8, 222.0 * h + 1.4
        x, y = -ft * np.cos(phi) - fr * np.sin(phi), ft * np.sin(phi) - fr * np.cos(phi)
        total += [v[on].sum() * DEPTH / n for v in (x, y, fa)]
    return total


@pytest.mark.parametrize("climb", [True, False])
@pytest.mark.parametrize("height", [0.0, 3.0, 10.0])
@pytest.mark.parametrize(("helix", "teeth", "radial"), [(0.5, 2, 2.0), (0.7, 4, 6.0), (1.2, 3, 2.0)])
def test_a_helix_is_the_sum_of_its_slices(helix, teeth, radial, climb, height):
    angle = math.pi if climb else 0.0
    found = cut(helix, teeth, climb, radial).generating(np.array([angle]), np.array([height]))[0]
    assert found == pytest.approx(
        slices(helix, teeth, climb, radial, angle, height), abs=1.0
    )  # N of some 1000: one slice


def test_a_wall_has_a_shape_along_its_depth():
    """Climb: while the foot is made the edge above it lags inside the cut; at the top all of the edge has left it. Conventional: the other
    way round. So climb bends the foot of the wall most, and its top by one point of the edge, by nothing."""
    climb, conventional = cut(0.5), cut(0.5, climb=False)
    heights = np.array([0.0, 5.0, 10.0])
    y = [climb.generating(np.array([math.pi]), np.array([z]))[0, 1] for z in heights]
    assert y[0] > y[1] > y[2] == pytest.approx(0.0, abs=1e-9)
    up = [abs(conventional.generating(np.zeros(1), np.array([z]))[0, 1]) for z in heights]
    assert up[0] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("helix", [0.0, 0.6])
def test_the_mean_over_a_turn_is_the_mean_force(helix):
    one = cut(helix, teeth=3)
    angle = (np.arange(7200) + 0.5) * 2 * math.pi / 7200
    mean = one.take(np.zeros(7200, int)).force(angle, np.full(7200, 2.0)).mean(axis=0)
    wanted = milling_force(one.start[0], one.exit[0], DEPTH, CHIP, 3, AL)
    assert mean == pytest.approx(wanted, abs=0.5)


def test_no_stock_no_force():
    one = cut(0.5)
    none = ToothCuts(one.start, one.exit, 0 * one.axial, one.chip, one.teeth, one.lag, AL)
    assert not none.generating(np.array([math.pi]), np.array([1.0])).any()
