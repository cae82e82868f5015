"""Machine files: short forms become effects and Inputs; what belongs together is added, what is said twice refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.conftest import data_file
from vcmm.core.errors import DataError
from vcmm.core.laws import MultivariateNormal
from vcmm.files.own.machine import load_machine
from vcmm.physics.catalogue.map_interpolation import MapInterpolation

HEAD = """\
vcmm = "machine/1"
structure = "w C' b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
dynamics = { speed = "500 mm/s", gain = "40 1/s" }
[axes.Y]
travel = ["0 mm", "500 mm"]
measured_at = ["0 mm", "0 mm", "-120 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[axes.C]
travel = ["-180 deg", "180 deg"]
centre = "300 250 0 mm"
error_frame = "fixed"
"""
TABLE = "X EXX EBX\n0 0 0\n300 0.001 0.000002\n600 0 0\n#\nC0Y\n3e-6\n#\nX0C A0C\n0.005 1e-6\n"


def _machine(tmp_path, text: str = "", table: str = TABLE):
    (tmp_path / "errors.csv").write_text(table)
    path = tmp_path / "m.toml"
    path.write_text(HEAD + text)
    return load_machine(path)


def test_axes_in_canonical_units(tmp_path):
    machine = _machine(tmp_path)
    assert machine.name == "m"
    assert machine.axes["X"].travel == (0.0, 600.0)
    assert machine.axes["X"].dynamics == {"speed": 500.0, "gain": 40.0}
    assert machine.axes["Y"].measured_at == (0.0, 0.0, -120.0)
    assert machine.axes["C"].travel == pytest.approx((-math.pi, math.pi))
    assert machine.axes["C"].centre == (300.0, 250.0, 0.0)
    assert machine.axes["C"].error_frame == "fixed"


def test_error_table_to_effects(tmp_path):
    machine = _machine(tmp_path, '[errors]\ntable = "errors.csv"\nstate = "raw"\ncompensation = ["CAA"]\n')
    assert [e.id for e in machine.effects] == [
        "component_table[EXX]", "component_table[EBX]", "squareness[C0Y]", "rotary_location[X0C]", "rotary_location[A0C]",
    ]  # fmt: skip
    assert machine.effects[2].angle == 3e-6
    assert (machine.effects[3].offset, machine.effects[4].tilt) == (0.005, 1e-6)
    assert machine.state == "raw"
    assert machine.compensation == ("CAA",)


def test_cubic_interpolation_makes_splines(tmp_path):
    machine = _machine(tmp_path, '[errors]\ntable = "errors.csv"\ninterpolation = "cubic"\n')
    assert [e.name for e in machine.effects[:2]] == ["component_spline"] * 2


def test_short_form_of_the_uncertainty(tmp_path):
    machine = _machine(
        tmp_path,
        '[errors]\ntable = "errors.csv"\n'
        'uncertainty = { translation = "0.4 um", rotation = "0.8 urad", squareness = "1 urad", correlation_length = "150 mm" }\n',
    )
    known = {i.id: i.law for i in machine.inputs}
    table = known["component_table[EXX].values"]
    assert isinstance(table, MultivariateNormal)
    # nodes 300 mm apart, l = 150 mm: exp(-300^2 / (2 x 150^2)) = exp(-2) = 0.135335; 600 mm: exp(-8) = 0.000335
    expected = 0.16e-6 * np.array([[1, 0.135335, 0.000335], [0.135335, 1, 0.135335], [0.000335, 0.135335, 1]])
    nodes = machine.effects[0].grids[0]
    given = np.flatnonzero(np.isin(nodes, [0.0, 300.0, 600.0]))
    assert table.covariance[np.ix_(given, given)] == pytest.approx(expected, abs=1e-12)
    # nodes are added where the process needs them, on the table itself: 0 ... 1 um at 300 mm, half of it at 150 mm
    assert np.diff(nodes).max() <= 50.0 + 1e-9
    assert np.interp(150.0, nodes, machine.effects[0].values) == pytest.approx(0.5e-3)
    # what lies between the nodes of the table is asked between those that were measured
    assert MapInterpolation.from_table(machine.effects[0]).nodes.tolist() == [0.0, 300.0, 600.0]
    assert known["component_table[EBX].values"].u == pytest.approx(0.8e-6)
    assert known["squareness[C0Y].angle"].u == pytest.approx(1e-6)


def test_repeatability_is_drawn_per_touch(tmp_path):
    machine = _machine(tmp_path, '[repeatability]\nlaw = "t"\nscale = "0.7 um"\ndof = 6\n')
    (one,) = machine.inputs
    assert (one.id, one.redraw) == ("scatter.value", "touch")
    assert one.law.u == pytest.approx(0.7e-3 * math.sqrt(6 / 4))


@pytest.mark.parametrize("dof", [1, 2])
def test_two_degrees_of_freedom_are_accepted(tmp_path, dof):
    machine = _machine(tmp_path, f'[repeatability]\nlaw = "t"\nscale = "0.7 um"\ndof = {dof}\n')
    assert machine.inputs[0].law.u == math.inf


def test_scales_share_one_coefficient_and_have_a_sensor_each(tmp_path):
    machine = _machine(
        tmp_path,
        '[environment]\nscales = { expansion = "8 um/(m K)", u_expansion = "0.5 um/(m K)", u_sensor = "0.05 K" }\n',
    )
    assert {e.where for e in machine.effects} == {"X", "Y", "Z"}
    assert all((e.alpha, e.corrected) == (8e-6, 8e-6) for e in machine.effects)
    ids = [i.id for i in machine.inputs]
    assert ids[0] == "scale_expansion[*].alpha"
    assert sum("temp_scale" in i for i in ids) == 3


def test_uncompensated_scales(tmp_path):
    machine = _machine(
        tmp_path, '[environment]\nscales = { expansion = "8 um/(m K)", compensated = false }\n'
    )
    assert all(e.corrected == 0.0 for e in machine.effects)


def test_a_further_known_error_is_added_to_the_table(tmp_path):
    # errors.csv holds C0Y = 3 urad; a further 2 urad make one effect of 5 urad, so that one Input moves it once
    machine = _machine(
        tmp_path,
        '[errors]\ntable = "errors.csv"\nuncertainty = { squareness = "1 urad" }\n'
        '[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "2 urad"\n',
    )
    found = [e for e in machine.effects if e.name == "squareness"]
    assert len(found) == 1
    assert found[0].angle == pytest.approx(5e-6)


def test_effects_that_differ_in_more_than_numbers_stay_apart(tmp_path):
    two = '[[effects]]\neffect = "screw_pitch"\naxis = "X"\namplitude = "1 um"\nperiod = "{} mm"\n'
    machine = _machine(tmp_path, two.format(5) + two.format(10))
    assert [e.period for e in machine.effects] == [5.0, 10.0]


def test_one_quantity_has_one_input(tmp_path):
    text = (
        '[errors]\ntable = "errors.csv"\nuncertainty = { squareness = "1 urad" }\n'
        '[[inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "2 urad"\n'
    )
    with pytest.raises(
        DataError, match=r"squareness\[C0Y\].angle has an input already \(calibration of the error table\)"
    ):
        _machine(tmp_path, text)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            '[[effects]]\neffect = "backlash"\naxis = "W"\n',
            ["backlash[W] acts on axis W", "the axes are C, X, Y, Z"],
        ),
        ('[[effects]]\neffect = "squareness"\npair = "C0Z"\n', ["C0Z"]),
        ('[[effects]]\neffect = "squareness"\npair = "COY"\n', ["allowed are C0Y, B0Z, A0Z"]),
        ('[[effects]]\neffect = "component_table"\ncomponent = "EXQ"\n', ["is not a component error"]),
        ('[[effects]]\neffect = "rotary_location"\ncomponent = "X0A"\n', ["acts on axis A"]),
        (
            '[[effects]]\neffect = "rotary_location"\ncomponent = "A0C"\noffset = "1 um"\n',
            ["offset does nothing", "X0C"],
        ),
        ('[repeatability]\nlaw = "t"\nu = "1 um"\ndof = 6\n', ["takes scale", "rename u to scale"]),
        ('[repeatability]\nu = "1 um"\ndof = 6\n', ['dof goes with law = "t"']),
        ('[repeatability]\nlaw = "t"\nscale = "1 um"\ndof = 0.5\n', ["dof"]),
        ("[repeatability]\n", ["needs u"]),
        ('[certificate]\nE0_MPE = "1.9"\n', ["has no unit"]),
        ('[errors]\ntable = "error.csv"\n', ["error.csv does not exist", 'Did you mean "errors.csv"']),
        ('[axes.Q]\ntravel = ["0 mm", "1 mm"]\n', ['unknown axis "Q"']),
        ('[axes.A]\ntravel = ["0 deg", "1 deg"]\n', ["axis A is not in structure"]),
    ],
)
def test_what_is_refused(tmp_path, text, words):
    with pytest.raises(DataError) as caught:
        _machine(tmp_path, text)
    message = str(caught.value)
    assert message.startswith(f"{tmp_path}/m.toml:")
    assert all(word in message for word in words), message


def test_the_table_must_fit_the_machine(tmp_path):
    with pytest.raises(DataError, match="holds EXB of axis B, which structure"):
        _machine(tmp_path, '[errors]\ntable = "errors.csv"\n', "B EXB\n0 0\n1 0\n")


def test_errors_of_the_table_name_the_table(tmp_path):
    with pytest.raises(DataError) as caught:
        _machine(tmp_path, '[errors]\ntable = "errors.csv"\n', "X EXX\n5 0\n0 0\n")
    assert str(caught.value).startswith(f"{tmp_path}/errors.csv:3: column X is not increasing")


def test_every_reference_machine_loads():
    folder = data_file("reference/machines")
    found = sorted(folder.glob("*/machine.toml"))
    assert len(found) >= 58
    assert all(load_machine(path).axes for path in found)


def test_a_correlated_table_keeps_its_uncertainty_between_the_nodes(tmp_path):
    """u = 1 um everywhere: linear interpolation between nodes l / 8 apart loses (1 - exp(-1 / 128)) / 4 = 0.2 % of u."""
    from vcmm.core.effect import basis
    from vcmm.core.knowledge import targets
    from vcmm.core.run import Run

    (tmp_path / "errors.csv").write_text("X EXX\n0 0\n600 0\n")
    path = tmp_path / "m.toml"
    path.write_text(
        'vcmm = "machine/1"\nstructure = "w b Y X Z t"\n'
        + "".join(
            f'[axes.{a}]\ntravel = ["{"-400" if a == "Z" else "0"} mm", "{"0" if a == "Z" else "600"} mm"]\n'
            for a in "XYZ"
        )
        + '[errors]\ntable = "errors.csv"\nuncertainty = { translation = "1 um", correlation_length = "150 mm" }\n'
    )
    machine = load_machine(path)
    one = next(i for i in machine.inputs if i.where == "EXX")
    (effect,) = targets(machine, one)
    q = np.linspace(0.0, 600.0, 241)
    run = Run({a: q if a == "X" else np.zeros(241) for a in "XYZ"}, np.zeros((241, 3)))
    moved = basis(effect, one.parameter, run)[:, 0, :] @ one.law.factor
    u = np.linalg.norm(moved, axis=1)
    assert u.max() == pytest.approx(1e-3, rel=1e-3)
    assert u.min() > 0.9975e-3


ENDLESS = """vcmm = "machine/1"
kind = "machine-tool"
structure = "w C' X' Y' b Z t"
[axes.X]
travel = ["-500 mm", "500 mm"]
[axes.Y]
travel = ["-500 mm", "500 mm"]
[axes.Z]
travel = ["-500 mm", "500 mm"]
[axes.C]
travel = "endless"
"""


def test_a_rotary_axis_may_turn_on_and_on(tmp_path):
    """10 turns are inside; where the axis is looked at, it is over one turn. It is written as it was read."""
    from vcmm.core.machine import check_travel
    from vcmm.files.learned.calibrated_machine import bare_text

    path = tmp_path / "m.toml"
    path.write_text(ENDLESS)
    axis = load_machine(path).axes["C"]
    check_travel(axis, np.array([20 * np.pi, -20 * np.pi]))
    assert axis.travel == pytest.approx((0.0, 2 * np.pi))
    assert axis.limits == (-np.inf, np.inf)
    path.write_text(bare_text(load_machine(path)))
    assert load_machine(path).axes["C"] == axis
    path.write_text(ENDLESS.replace('travel = ["-500 mm", "500 mm"]', 'travel = "endless"', 1))
    with pytest.raises(DataError, match='travel of X is "endless": only rotary axes turn on and on'):
        load_machine(path)
    path.write_text(ENDLESS.replace('"endless"', '"endles"'))
    with pytest.raises(DataError, match='a rotary axis that turns on and on has travel = "endless"'):
        load_machine(path)


def test_a_number_where_a_name_is_asked_is_quoted_in_the_example(tmp_path):
    with pytest.raises(DataError, match=r'tool = 1 must be a text in quotes; write for example tool = "1"'):
        _machine(tmp_path, '[[effects]]\neffect = "tool_runout"\ntool = 1\namplitude = "5 um"\n')
