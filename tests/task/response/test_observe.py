"""Observe: every kind and sign by hand; what calibration and noise contribute."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests import build
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import MultivariateNormal, MultivariateSamples, Normal, StudentT
from vcmm.core.machine import Machine
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.clamping import Clamping
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.physics.structure.scatter import Reindexing, Scatter
from vcmm.physics.structure.squareness import Squareness
from vcmm.physics.structure.tip import TipOffset, TipRadius
from vcmm.task.response.observe import (
    Observer,
    baseline,
    calibration_columns,
    left_out,
    missing_columns,
    noise_u,
    observe,
)
from vcmm.task.response.recording import Recording

X, Y, Z = np.eye(3)
SCALE = ScaleFactor("X", 1e-5)  # 10 um/m: the tip goes 1 um too far at X = 100


def recording(places, directions, kind="probe", measuring=True, second=None, **columns) -> Recording:
    """Observations at places (n, 3) of the axes along directions; second: run rows of the second ends."""
    places, directions = np.array(places, dtype=float), np.array(directions, dtype=float)
    m = len(directions)
    labels = {k: np.array(v) for k, v in columns.items() if isinstance(v[0], str)}
    numbers = {k: np.array(v, dtype=float) for k, v in columns.items() if k not in labels}
    if len(places) == m:
        numbers = {f"n{c}": directions[:, i] for i, c in enumerate("xyz")} | numbers
    run = Run(dict(zip("XYZ", places.T)), np.zeros((len(places), 3)), numbers, labels)
    other = np.full(m, -1) if second is None else np.array(second)
    return Recording("r", kind, run, np.zeros(m), measuring, np.arange(m), directions, other)


# signs of every kind ------------------------------------------------------------------------------------------------


def test_a_part_clamped_bent_springs_back_to_the_other_side():
    """Clamped, its middle bulges by c P2(0) = -c / 2 in z, and is cut flat; free it is off by +c / 2, as vcmm cut has it."""
    seen = recording(
        [[0, 0, 0]],
        [Z],
        "path",
        False,
        feature=["top"],
        clamp=["1"],
        part_x_mm=[0.0],
        part_y_mm=[0.0],
        part_z_mm=[0.0],
    )
    bent = Clamping("z", np.array([4e-3, 0.0, 0.0]))
    assert baseline(seen, build.machine(bent)) == pytest.approx([2e-3])
    assert Observer(seen, build.machine()).of_parameter(bent, "coefficients")[0, 0] == pytest.approx(0.5)
    clamped = replace(seen, run=replace(seen.run, labels={}))
    assert baseline(clamped, build.machine(bent)) == pytest.approx([-2e-3])


@pytest.mark.parametrize("kind", ["probe", "displacement", "path"])
def test_a_scale_that_is_too_long_in_both_senses(kind):
    """Tip error (1e-3, 0, 0) at X = 100: indicated - true = -1e-3 along +x, +1e-3 along -x, -0.6e-3 along (0.6 0.8 0)."""
    seen = [X, -X, [0.6, 0.8, 0.0]]
    rec = recording([[100, 50, 0]] * 3, seen, kind)
    assert baseline(rec, build.machine(SCALE)) == pytest.approx([-1e-3, 1e-3, -0.6e-3])
    cut = replace(rec, measuring=False)
    assert baseline(cut, build.machine(SCALE)) == pytest.approx([1e-3, -1e-3, 0.6e-3])


def test_a_length_is_the_difference_of_its_ends():
    """From (0, 0) to (300, 400): the far end errs by (3e-3, 0), 0.6 of it along the line; the near end by nothing.

    From X = 100 to X = 400 the ends err by 1e-3 and 4e-3: the machine travels 3e-3 too far and indicates as much less.
    """
    places = [[300, 400, 0], [400, 0, 0], [0, 0, 0], [100, 0, 0]]
    rec = recording(places, [[0.6, 0.8, 0.0], X], "length", second=[2, 3])
    assert baseline(rec, build.machine(SCALE)) == pytest.approx([-1.8e-3, -3e-3])
    assert baseline(replace(rec, measuring=False), build.machine(SCALE)) == pytest.approx([1.8e-3, 3e-3])
    fixed = replace(rec, other=np.array([2, -1]))
    assert baseline(fixed, build.machine(SCALE)) == pytest.approx([-1.8e-3, -4e-3])


def test_an_angle_sees_the_rotation():
    """EBX = 2e-7 X: at X = 200 the tip turns by 4e-5 about +y; an autocollimator shows -4e-5 as indicated - true."""
    pitch = ComponentTable("EBX", ("X",), (np.array([0.0, 500.0]),), np.array([0.0, 1e-4]))
    rec = recording([[200, 0, 0], [200, 0, 0]], [Y, X], "angle")
    assert baseline(rec, build.machine(pitch)) == pytest.approx([-4e-5, 0.0])
    assert baseline(replace(rec, measuring=False), build.machine(pitch)) == pytest.approx([4e-5, 0.0])


def test_the_rotation_of_a_table_turns_the_tip_the_other_way():
    """A table that turns by +4e-5 about y turns the tip, seen from the workpiece, by -4e-5."""
    pitch = ComponentTable("EBX", ("X",), (np.array([0.0, 500.0]),), np.array([0.0, 1e-4]))
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    table = Machine("t", "machine-tool", parse_structure("w X' b Y Z t"), axes, (pitch,))
    rec = recording([[200, 0, 0]], [Y], "angle", measuring=False)
    assert baseline(rec, table) == pytest.approx([-4e-5])


@pytest.mark.parametrize(
    ("kind", "measuring", "value"),
    [
        ("probe", True, 2e-3),
        ("probe", False, 2e-3),  # a CMM measures what another machine made: its reading adds in either sense
        ("path", False, 2e-3),
        ("displacement", True, 2e-3),
        ("displacement", False, -2e-3),  # the instrument is the reference: it would show the actual too small
        ("angle", True, 0.0),
    ],
)
def test_readings(kind, measuring, value):
    rec = recording([[0, 0, 0]], [Z], kind, measuring)
    assert baseline(rec, build.machine(TipRadius("", 2e-3))) == pytest.approx([value])


def test_readings_of_a_length_cancel_between_its_ends():
    rec = recording([[100, 0, 0], [0, 0, 0]], [X], "length", second=[1], nx=[1, 1], ny=[0, 0], nz=[0, 0])
    assert baseline(rec, build.machine(TipRadius("", 2e-3))) == pytest.approx([0.0])


def test_observe_by_hand():
    """Two rows, one direction each; tip (1, 2, 3) um and rotation, reading (10, 0, 0) um, two columns at once."""
    rec = recording([[0, 0, 0], [0, 0, 0]], [X, Y])
    motion, reading = np.zeros((2, 6, 2)), np.zeros((2, 3, 2))
    motion[:, :3, 0], reading[:, :, 1] = [1.0, 2.0, 3.0], [10.0, 0.0, 0.0]
    assert observe(rec, motion, reading) == pytest.approx(np.array([[-1.0, 10.0], [-2.0, 0.0]]))


# any effect, any parameter ------------------------------------------------------------------------------------------

EFFECTS = (
    SCALE,
    Squareness("C0Y", 3e-6),
    TipOffset("", np.array([1e-3, -2e-3, 3e-3])),
    Reindexing(np.array([2e-3, 1e-3, -1e-3])),
    ComponentTable("EAY", ("Y",), (np.array([0.0, 200.0, 400.0]),), np.array([0.0, 2e-6, 5e-6])),
    Backlash("X", 2e-3),
)


@pytest.mark.parametrize("kind", ["probe", "length", "angle", "displacement"])
@pytest.mark.parametrize("measuring", [True, False])
def test_the_observer_agrees_with_the_machine(kind, measuring):
    """Sum of the single effects = machine.tip_motion and machine.reading seen by `observe`."""
    rng = np.random.default_rng(3)
    d = rng.standard_normal((4, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    places = rng.uniform(0.0, 300.0, (8, 3))
    columns = {f"n{c}": np.tile(d[:, i], 2) for i, c in enumerate("xyz")} | {"sense_X": [1, -1] * 4}
    second = [4, 5, -1, 7] if kind == "length" else None
    rec = recording(places, d, kind, measuring, second, **columns)
    machine = build.machine(*EFFECTS)
    run = machine.prepare(rec.run)
    motion, reading = machine.tip_motion(run)[:, :, None], machine.reading(run)[:, :, None]
    eye = Observer(rec, machine)
    assert sum(eye.through(e, e.error_motion(eye.run)) for e in EFFECTS) == pytest.approx(
        observe(rec, motion, reading)[:, 0]
    )
    assert baseline(rec, machine) == pytest.approx(observe(rec, motion, reading)[:, 0])


def test_derivatives_of_parameters_are_those_of_the_baseline():
    rec = recording([[100, 50, -20], [300, 200, -100]], [X, Z], sense_X=[1, -1])
    eye = Observer(rec, build.machine())
    offset = TipOffset("", np.zeros(3))
    assert eye.of_parameter(offset, "d") == pytest.approx(np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    assert eye.of_parameter(SCALE, "k") == pytest.approx(np.array([[-100.0], [0.0]]))
    assert eye.of_parameter(Backlash("X", 0.0), "gap") == pytest.approx(np.array([[0.5], [0.0]]))


def test_effects_without_their_columns_are_left_out_and_named():
    rec = recording([[100, 0, 0]], [X])
    machine = build.machine(SCALE, Backlash("X", 2e-3), Scatter())
    assert left_out(rec, machine) == (("backlash[X]", ("sense_X",)),)
    assert baseline(rec, machine) == pytest.approx([-1e-3])
    assert baseline(
        replace(rec, run=rec.run.with_columns({"sense_X": np.ones(1)})), machine
    ) == pytest.approx([0])


def test_a_log_stands_for_a_column():
    run = recording([[0, 0, 0]], [X]).run
    effect = ScaleExpansion("X", 1e-5)
    assert missing_columns(effect, run) == ("temp_scale_x_C",)
    assert missing_columns(effect, replace(run, series={"scale_x": Series(np.zeros(1), np.zeros(1))})) == ()


def test_rows_outside_the_travel_are_refused():
    with pytest.raises(ModelLimit, match="row 1: axis X = 2000"):
        baseline(recording([[2000, 0, 0]], [X]), build.machine())


# calibration and noise ----------------------------------------------------------------------------------------------


def covariance(rec, *effects, inputs) -> np.ndarray:
    columns = calibration_columns(rec, build.machine(*effects, inputs=inputs))
    return sum(c @ c.T for _, c in columns)


def test_calibration_of_a_table_by_hand():
    """Nodes 0 and 100 with u = 2 um each: at X = 25 the weights are 0.75 and 0.25, so u^2 = 4 (0.5625 + 0.0625) um^2."""
    table = ComponentTable("EXX", ("X",), (np.array([0.0, 100.0]),), np.zeros(2))
    known = Input("component_table", "EXX", "values", MultivariateNormal(np.eye(2) * 4e-6))
    found = covariance(recording([[25, 0, 0], [0, 0, 0]], [X, X]), table, inputs=[known])
    assert found == pytest.approx(np.array([[2.5e-6, 3e-6], [3e-6, 4e-6]]))


def test_columns_are_scaled_by_the_standard_uncertainty():
    """t with 6 dof: u = scale sqrt(6 / 4). The sign is that of the derivative."""
    rec = recording([[100, 0, 0]], [X])
    known = Input("scale_factor", "X", "k", StudentT(1e-6, 6))
    ((name, columns),) = calibration_columns(rec, build.machine(SCALE, inputs=[known]))
    assert name == "scale_factor[X].k"
    assert columns == pytest.approx(np.array([[-100e-6 * np.sqrt(1.5)]]))
    with pytest.raises(ModelLimit, match=r"scale_factor\[X\].k.*no standard uncertainty"):
        calibration_columns(
            rec, build.machine(SCALE, inputs=[Input("scale_factor", "X", "k", StudentT(1e-6, 2))])
        )


def test_every_copy_of_a_redrawn_input_has_its_own_column():
    rec = recording([[100, 0, 0]] * 3, [X] * 3, pose=["a", "b", "a"])
    known = Input("scale_factor", "X", "k", Normal(1e-5), "pose")
    ((_, columns),) = calibration_columns(rec, build.machine(SCALE, inputs=[known]))
    assert columns == pytest.approx(np.array([[-1e-3, 0.0], [0.0, -1e-3], [-1e-3, 0.0]]))
    without = replace(rec, run=replace(rec.run, labels={}))  # no such label: one pose
    ((_, columns),) = calibration_columns(without, build.machine(SCALE, inputs=[known]))
    assert columns == pytest.approx(np.full((3, 1), -1e-3))


def test_copies_of_both_ends_of_a_length():
    """Redrawn per touch, the two ends have draws of their own: u^2 = (4e-3)^2 + (1e-3)^2 by hand."""
    rec = recording([[400, 0, 0], [100, 0, 0]], [X], "length", second=[1])
    known = [Input("scale_factor", "X", "k", Normal(1e-5), "touch")]
    assert covariance(rec, SCALE, inputs=known) == pytest.approx(np.array([[17e-6]]))
    once = [Input("scale_factor", "X", "k", Normal(1e-5))]
    assert covariance(rec, SCALE, inputs=once) == pytest.approx(np.array([[9e-6]]))


def test_draws_of_every_touch_need_no_more_columns_than_touches():
    """Three numbers per touch, seen along n only: independent, u^2 = |n|^2 u^2; 4 columns instead of 12."""
    rec = recording([[0, 0, 0]] * 4, [X, Y, [0.6, 0.8, 0.0], Z])
    known = Input("reindexing", "", "d", Normal(1e-3), "touch")
    ((_, columns),) = calibration_columns(rec, build.machine(Reindexing(), inputs=[known]))
    assert columns.shape == (4, 4)
    assert columns @ columns.T == pytest.approx(np.eye(4) * 1e-6)


def test_a_temperature_sensor():
    """Column + 0.1 K on a scale of 1e-5/K at X = 100: -1e-4 mm; corrected from a reading, the truth alone moves."""
    rec = recording([[100, 0, 0]], [X], temp_scale_x_C=[22.0])
    known = [Input("channel", "", "temp_scale_x_C", Normal(0.1))]
    ((name, columns),) = calibration_columns(rec, build.machine(ScaleExpansion("X", 1e-5), inputs=known))
    assert name == "channel.temp_scale_x_C"
    assert columns == pytest.approx(np.array([[-1e-4]]))
    corrected = build.machine(ScaleExpansion("X", 1e-5, 1e-5), inputs=known)
    assert calibration_columns(rec, corrected) == []
    told = replace(rec, run=rec.run.with_columns({"reading_scale_x_C": np.array([22.0])}))
    assert calibration_columns(told, corrected)[0][1] == pytest.approx(np.array([[-1e-4]]))


def test_samples_of_a_calibration_enter_by_their_covariance():
    table = ComponentTable("EXX", ("X",), (np.array([0.0, 100.0]),), np.zeros(2))
    draws = np.array([[1e-3, 1e-3], [-1e-3, -1e-3]])
    known = Input("component_table", "EXX", "values", MultivariateSamples(draws))
    found = covariance(recording([[25, 0, 0], [100, 0, 0]], [X, X]), table, inputs=[known])
    assert found == pytest.approx(np.full((2, 2), 1e-6))


def test_scatter_is_noise_and_inputs_without_effect_here_are_left_out():
    rec = recording([[100, 0, 0]], [Y])
    known = [
        Input("scatter", "", "value", Normal(1e-3), "touch"),
        Input("scale_factor", "X", "k", Normal(1e-5)),
    ]
    known.append(Input("backlash", "X", "gap", Normal(1e-3)))
    assert calibration_columns(rec, build.machine(SCALE, Scatter(), Backlash("X"), inputs=known)) == []


def test_noise_in_order_of_precedence():
    machine = build.machine(Scatter(), inputs=[Input("scatter", "", "value", StudentT(0.7e-3, 6), "touch")])
    rec = recording([[0, 0, 0]] * 2, [X, Y])
    assert noise_u(rec, machine) == pytest.approx([0.7e-3 * np.sqrt(1.5)] * 2)
    stated = replace(rec, u=np.array([1e-3, 2e-3]))
    assert noise_u(stated, machine).tolist() == [1e-3, 2e-3]
    assert noise_u(replace(stated, noise=Normal(3e-3)), machine).tolist() == [3e-3, 3e-3]


def test_noise_that_is_not_known():
    rec = recording([[0, 0, 0]], [X])
    with pytest.raises(ModelLimit, match=r"no \[repeatability\]; add \[noise\]"):
        noise_u(rec, build.machine())
    scatter = build.machine(Scatter(), inputs=[build.SCATTER])
    with pytest.raises(ModelLimit, match="u_d_urad"):
        noise_u(replace(rec, kind="angle"), scatter)
    with pytest.raises(ModelLimit, match="dof above 2"):
        noise_u(replace(rec, noise=StudentT(1e-3, 2)), scatter)


def test_a_displacement_counts_from_the_first_row_of_its_set_up():
    rec = recording(
        [[10, 0, 0], [30, 0, 0], [0, 5, 0], [0, 9, 0]], [X, X, Y, Y], "displacement", setup=list("aabb")
    )
    run = Observer(rec, build.machine()).run
    assert run.column("counted_x_mm").tolist() == [0.0, 20.0, 0.0, 0.0]
    assert run.column("counted_y_mm").tolist() == [0.0, 0.0, 0.0, 4.0]
    assert "counted_x_mm" not in Observer(replace(rec, kind="probe"), build.machine()).run.columns
