"""Forces while an edge makes the wall: by pencil for straight edges, by a sum over slices for a helix."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from vcmm.program.setup import linear_edge
from vcmm.shop.cutting.force import immersion, milling_force
from vcmm.shop.cutting.runout import chip_at
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


def running_out(helix: float, teeth: int, climb: bool, radial: float, amplitude: float) -> ToothCuts:
    return replace(cut(helix, teeth, climb, radial), runout=amplitude * np.ones(1))


def test_a_tooth_behind_the_one_that_stands_out_cuts_less_by_pencil():
    """A slot, 4 straight edges, 5 um of run-out, 0.1 mm per tooth, 10 mm deep. While tooth 0 makes the wall on the right (phi = pi: no chip, 277 N
    along the feed and 308 N away from the wall), tooth 1 stands ahead (phi = pi/2) behind one that stands out by 5 um more: its chip is 0.095 mm,
    (168.8 0.095 + 30.8) 10 = 468.4 N against the feed, (796.1 0.095 + 27.7) 10 = 1033.3 N to the left. Tooth 2 (phi = 0, 5 um smaller than the mean, 5 um
    smaller than the one before it) does not touch. Together 277 - 468.4 = -191.4 and 308 + 1033.3 = 1341.3 N. Running true tooth 2 rubs along the other
    wall, -277 and -308 N, and tooth 1 cuts 0.1 mm: -476.8 and 1073.1 N in all."""
    slot = running_out(0.0, 4, True, 10.0, 0.005)
    found = slot.generating(np.array([math.pi]), np.array([4.0]))[0]
    assert found[:2] == pytest.approx([277 - 468.36, 308 + 1033.295], abs=1e-6)
    true = replace(slot, runout=np.zeros(1)).generating(np.array([math.pi]), np.array([4.0]))[0]
    assert true[:2] == pytest.approx([-476.8, 1073.1], abs=1e-6)


def left_by_teeth(phi: np.ndarray, tooth: int, teeth: int, amplitude: float) -> np.ndarray:
    """Chip of a tooth: its own circle less the outermost that one of the teeth before it, each fed less, has left; written out here."""
    circle = lambda i: amplitude * math.cos(2 * math.pi * i / teeth)  # noqa: E731
    left = np.max([circle(tooth - back) - back * CHIP * np.sin(phi) for back in range(1, teeth + 1)], axis=0)
    return np.asarray(circle(tooth) - left)


def slices_out(helix, teeth, climb, radial, angle, height, amplitude) -> np.ndarray:
    start, exit_ = (float(v) for v in immersion(radial, RADIUS, climb))
    total, n = np.zeros(3), 20000
    zeta = (np.arange(n) + 0.5) * DEPTH / n
    for tooth in range(teeth):
        phi = np.remainder(
            angle - 2 * math.pi * tooth / teeth - math.tan(helix) / RADIUS * (zeta - height), 2 * math.pi
        )
        h = left_by_teeth(phi, tooth, teeth, amplitude)
        on = (phi >= start) & (phi <= exit_) & (h >= 0.0)
        ft, fr, fa = 796.1 * h + 27.7, 168.8 * h + 30.8, 222.0 * h + 1.4
        x, y = -ft * np.cos(phi) - fr * np.sin(phi), ft * np.sin(phi) - fr * np.cos(phi)
        total += [v[on].sum() * DEPTH / n for v in (x, y, fa)]
    return total


@pytest.mark.parametrize("climb", [True, False])
@pytest.mark.parametrize("height", [0.0, 3.0, 10.0])
@pytest.mark.parametrize(
    ("helix", "teeth", "radial", "amplitude"),
    [(0.5, 2, 2.0, 0.01), (0.7, 4, 6.0, 0.02), (1.2, 3, 2.0, 0.005), (0.5, 3, 6.0, 0.2)],
)
def test_a_helix_that_runs_out_is_the_sum_of_its_slices(helix, teeth, radial, amplitude, climb, height):
    angle = math.pi if climb else 0.0
    mill = running_out(helix, teeth, climb, radial, amplitude)
    found = mill.generating(np.array([angle]), np.array([height]))[0]
    assert found == pytest.approx(slices_out(helix, teeth, climb, radial, angle, height, amplitude), abs=1.0)


def test_the_chips_of_a_turn_add_up_to_the_feed_whatever_the_run_out():
    """Nothing is left uncut: K_c takes its share of N c sin(phi), and only edges that do not touch are missing from the mean."""
    phi, teeth = np.linspace(0.01, math.pi - 0.01, 500), np.full(500, 5)
    for amplitude in (0.0, 0.01, 0.3):
        chips = [
            np.maximum(chip_at(phi, i, teeth, np.full(500, CHIP), np.full(500, amplitude)), 0.0)
            for i in range(5)
        ]
        assert np.sum(chips, axis=0) == pytest.approx(5 * CHIP * np.sin(phi), abs=1e-12)


@pytest.mark.parametrize("amplitude", [0.0, 0.01, 0.2])
def test_the_mean_of_a_mill_that_runs_out_is_that_of_all_moments(amplitude):
    mill = running_out(0.6, 3, True, 2.0, amplitude)
    angle = (np.arange(7200) + 0.5) * 2 * math.pi / 7200
    every = mill.take(np.zeros(7200, int))
    assert mill.mean()[0] == pytest.approx(every.force(angle, np.full(7200, 2.0)).mean(axis=0), abs=0.5)
    if not amplitude:
        assert mill.mean()[0] == pytest.approx(milling_force(mill.start[0], mill.exit[0], DEPTH, CHIP, 3, AL))


def test_of_tools_beside_each_other_only_the_one_that_runs_out_changes():
    two = cut(0.5).take(np.array([0, 0]))
    both = replace(two, runout=np.array([0.0, 0.01]))
    found = both.generating(np.full(2, math.pi), np.zeros(2))
    assert found[0] == pytest.approx(two.generating(np.full(2, math.pi), np.zeros(2))[0], abs=1e-9)
    assert found[1] == pytest.approx(slices_out(0.5, 2, True, 2.0, math.pi, 0.0, 0.01), abs=1.0)
