"""The carrier: how six numbers of a link show along a direction; by hand, and as the transpose of tip_motion."""

from __future__ import annotations

import numpy as np
import pytest

from tests import build
from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, Motion, link_frames, parse_structure, tip_motion, turn_sensitivity
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.physics.structure.squareness import Squareness
from vcmm.physics.structure.tip import TipOffset
from vcmm.task.response.carrier import Carrier, Sight, responses, runs_one_step_apart, shift_channel

X, Y, Z = np.eye(3)
PITCH = ComponentTable("EBX", ("X",), (np.array([-1e3, 1e3]),), np.zeros(2))  # the tilt of X about Y


def run_at(*places: tuple[float, float, float], **columns: float) -> Run:
    position = dict(zip("XYZ", np.array(places, dtype=float).T))
    n = len(places)
    return Run(position, np.tile([0.0, 0.0, -100.0], (n, 1)), {k: np.full(n, v) for k, v in columns.items()})


def carrier(direction, *effects, run=None, **sight) -> Carrier:
    machine = build.machine(*effects)
    run = run_at((100.0, 50.0, -20.0)) if run is None else run
    return Carrier(machine, machine.prepare(run), Sight(np.tile(direction, (run.n, 1)), **sight))


def test_a_tilt_is_carried_by_its_lever():
    # structure w b Y X Z t: the tip hangs 20 + 100 mm below the link of X; w x d = (0, 1, 0) x (0, 0, -120) = (-120, 0, 0)
    # per rad, and indicated - true is the opposite: +120 mm/rad along x, nothing along z
    assert carrier(X, PITCH).weights(PITCH)[0] == pytest.approx([-1, 0, 0, 0, 120, 0])
    assert carrier(Z, PITCH).weights(PITCH)[0] == pytest.approx([0, 0, -1, 0, 0, 0])
    assert carrier(X, PITCH).through(PITCH, np.array([[0, 0, 0, 0, 1e-3, 0]])) == pytest.approx([0.12])


def test_a_sight_that_turns_sees_rotations():
    # s = +1: a turn of 2 mrad about y seen about y is 2 mrad, about x nothing
    six = np.array([[1.0, 1.0, 1.0, 0, 2e-3, 0]])
    assert carrier(Y, PITCH, motion=1.0, turning=True).through(PITCH, six) == pytest.approx([2e-3])
    assert carrier(X, PITCH, motion=1.0, turning=True).through(PITCH, six) == pytest.approx([0.0])


def test_a_reading_is_not_carried_and_has_a_sign_of_its_own():
    offset = TipOffset("", np.array([3e-3, 0.0, 4e-3]))
    along = np.array([0.6, 0.0, 0.8])  # 0.6 x 3 + 0.8 x 4 = 5 um
    eye = carrier(along, offset)
    assert eye.through(offset, offset.error_motion(eye.run)) == pytest.approx([5e-3])
    eye = carrier(along, offset, reading=-1.0)
    assert eye.through(offset, offset.error_motion(eye.run)) == pytest.approx([-5e-3])


def test_an_axis_that_carries_the_work_moves_the_other_way():
    machine = Machine("m", "cmm", parse_structure("w X' b Y Z t"), build.machine().axes)
    table = ComponentTable("EXX", ("X",), (np.array([-1e3, 1e3]),), np.array([2e-3, 2e-3]))
    run = machine.prepare(run_at((0.0, 0.0, 0.0)))
    eye = Carrier(machine, run, Sight(X[None]))
    # the table's own motion of +2 um takes the tip back by 2 um on the work: indicated - true = +2 um
    assert eye.through(table, table.error_motion(run)) == pytest.approx([2e-3])


def test_observations_may_name_rows():
    # three observations of two rows: x of row 1, x of row 0, nothing of row 1
    run = run_at((100.0, 0.0, 0.0), (300.0, 0.0, 0.0))
    machine = build.machine(ScaleFactor("X", 1e-5))
    eye = Carrier(machine, machine.prepare(run), Sight(np.array([X, X, 0 * X]), np.array([1, 0, 1])))
    assert eye.parameter(machine.effects[0], "k")[:, 0] == pytest.approx([-300.0, -100.0, 0.0])


def test_an_input_on_a_column_by_its_difference():
    # alpha = 1e-5 /K, X = 200 mm: a scale that is 1 K warmer is 2 um longer, and the machine indicates 2 um too little
    effect = ScaleExpansion("X", 1e-5)
    run = run_at((200.0, 0.0, 0.0), temp_scale_x_C=23.0, reading_scale_x_C=20.0)
    eye = carrier(X, effect, run=run)
    one = Input("channel", "", "temp_scale_x_C", Normal(0.1))
    slope = eye.of_input(one, [effect])[0, 0]
    assert slope == pytest.approx(-200.0 * 1e-5)
    higher, lower, step = runs_one_step_apart(eye.run, "temp_scale_x_C")
    ends = [build.machine(effect).indication_error(r)[0, 0] for r in (higher, lower)]
    assert slope == pytest.approx((ends[0] - ends[1]) / (2 * step))
    assert eye.of_input(one, []).tolist() == [[0.0]]
    # what both do together: minus 200 mm per (1/K) K
    both = eye.product(Input("scale_expansion", "X", "alpha", Normal(1e-6)), one)
    assert both[0] == pytest.approx(-200.0)
    assert both == pytest.approx(eye.product(one, Input("scale_expansion", "X", "alpha", Normal(1e-6))))


def test_several_carriers_share_the_unit_motions():
    effects = (Backlash("X", 0.0), Backlash("Y", 0.0))
    run = run_at((0.0, 0.0, 0.0), sense_X=1.0, sense_Y=-1.0)
    first = carrier(X, *effects, run=run)
    every = Input("backlash", "*", "gap", Normal(1e-3))
    along_x, along_y = responses([first, first.along(Y[None])], every, effects)
    # the tip stays half the gap behind: -0.5 after going up in X, +0.5 after going down in Y; indicated - true is the opposite
    assert (along_x[0, 0], along_y[0, 0]) == (pytest.approx(0.5), pytest.approx(-0.5))


def test_a_shifted_column_takes_its_log_along():
    run = run_at((0.0, 0.0, 0.0), temp_air_C=20.0)
    run = Run(
        run.position,
        run.offset,
        run.columns,
        {},
        {"air": Series(np.array([0.0, 1.0]), np.array([20.0, 21.0]))},
    )
    out = shift_channel(run, "temp_air_C", np.array([0.5]))
    assert out.column("temp_air_C")[0] == 20.5
    assert out.series["air"].value.tolist() == [20.5, 21.5]


@pytest.mark.parametrize("structure", ["w b Y X Z t", "w C' Y' b X Z B t"])
def test_turns_are_the_transpose_of_tip_motion(structure):
    rng = np.random.default_rng(2)
    chain = parse_structure(structure)
    axes = {a: Axis(a, (-1e3, 1e3), error_frame="fixed" if a == "X" else "moving") for a in chain.letters}
    run = Run({a: rng.uniform(-1, 1, 4) for a in chain.letters}, rng.normal(size=(4, 3)) * 100)
    about = rng.normal(size=(4, 3))
    links = [(a, "motion") for a in chain.letters] + [
        ("tip", "motion"),
        ("tool", "motion"),
        ("command", "motion"),
    ]
    links += [(a, "location" if a in "ABC" else "travel") for a in chain.letters]
    for link in links:
        six = rng.normal(size=(4, 6))
        turned = tip_motion(chain, axes, run, [Motion(*link, six)])[:, 3:]
        weights = turn_sensitivity(link_frames(chain, axes, run), axes, run, link, about)
        assert (weights * six).sum(axis=1) == pytest.approx((turned * about).sum(axis=1), abs=1e-12), link


def test_squareness_turns_the_travel_only():
    # C0Y of +1 mrad at Y = 50 takes the tip by -50 x 1e-3 along x: indicated - true = +0.05 mm; a turn of the tip is not seen
    square = Squareness("C0Y", 1e-3)
    eye = carrier(X, square)
    assert eye.through(square, square.error_motion(eye.run)) == pytest.approx([0.05])
    turned = carrier(Z, square, motion=1.0, turning=True)
    assert turned.through(square, square.error_motion(turned.run)).tolist() == [0.0]
