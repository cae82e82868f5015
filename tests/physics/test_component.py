"""Component errors: tables, splines, polynomials, and the sign on an axis that carries the workpiece."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.effect import required
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run, Series
from vcmm.physics.structure.component import (
    ComponentPolynomial,
    ComponentSpline,
    ComponentTable,
    ComponentWarming,
)


def _run(**q: list[float]) -> Run:
    n = len(next(iter(q.values())))
    return Run({a: np.array(v) for a, v in q.items()}, np.zeros((n, 3)))


def test_table_is_linear_between_its_nodes():
    # 0 at 0 mm, 2 um at 400 mm: at 100 mm 2 x 100 / 400 = 0.5 um, in the column of Y
    table = ComponentTable("EYX", ("X",), (np.array([0.0, 400.0]),), np.array([0.0, 2e-3]))
    motion = table.error_motion(_run(X=[0.0, 100.0, 400.0]))
    assert motion[:, 1] == pytest.approx([0.0, 0.5e-3, 2e-3], abs=1e-18)
    assert np.all(np.delete(motion, 1, axis=1) == 0.0)


def test_table_over_two_axes_is_bilinear():
    # corners (Z, X): 0, 1, 2, 5 urad; in the middle (0 + 1 + 2 + 5) / 4 = 2; at Z = -50 of -200..0, X = 100 of 0..400:
    # share of Z 0.75, of X 0.25: 0.25 (0.75 x 0 + 0.25 x 1) + 0.75 (0.75 x 2 + 0.25 x 5) = 0.0625 + 2.0625 = 2.125
    grids = (np.array([-200.0, 0.0]), np.array([0.0, 400.0]))
    table = ComponentTable("EBX", ("Z", "X"), grids, np.array([[0.0, 1e-6], [2e-6, 5e-6]]))
    motion = table.error_motion(_run(Z=[-100.0, -50.0], X=[200.0, 100.0]))
    assert motion[:, 4] == pytest.approx([2e-6, 2.125e-6], abs=1e-18)


def test_outside_the_table_is_refused():
    table = ComponentTable("EXX", ("X",), (np.array([0.0, 400.0]),), np.zeros(2))
    with pytest.raises(ModelLimit, match=r"EXX: X = 401 lies outside its table \(0 to 400\)"):
        table.error_motion(_run(X=[401.0]))


@pytest.mark.parametrize(
    ("grid", "values", "message"),
    [
        ([0.0, 100.0, 100.0], [0.0, 0.0, 0.0], "do not increase: 100 after 100"),
        ([0.0, 200.0, 100.0], [0.0, 0.0, 0.0], "do not increase: 100 after 200"),
        ([0.0, np.nan], [0.0, 0.0], "do not increase"),
        ([0.0, 100.0], [0.0, 0.0, 0.0], "3 values for 2 nodes"),
    ],
)
def test_tables_that_are_no_tables(grid, values, message):
    with pytest.raises(UsageError, match=message):
        ComponentTable("EXX", ("X",), (np.array(grid),), np.array(values))


def test_spline_is_the_natural_cubic():
    # nodes 0, 100, 200 mm with 0, 1, 0 um: second derivative in the middle M = -3 (4 M = 6 (0 - 2 + 0)), ends 0;
    # half way in the first piece: M/6 x^3 + (1 - M/6) x = -0.5 x 0.125 + 1.5 x 0.5 = 0.6875 um
    spline = ComponentSpline("EZY", np.array([0.0, 100.0, 200.0]), np.array([0.0, 1e-3, 0.0]))
    assert spline.error_motion(_run(Y=[50.0, 100.0]))[:, 2] == pytest.approx([0.6875e-3, 1e-3], abs=1e-15)


def test_spline_needs_three_nodes():
    with pytest.raises(UsageError, match="3 nodes or more"):
        ComponentSpline("EZY", np.array([0.0, 1.0]), np.zeros(2))


def test_polynomial_counts_in_metres_and_radians():
    # linear axis: s = 0.2: 1 + 2 x 0.2 + 3 x 0.04 = 1.52 um; rotary axis: s = 0.5 rad: 1 + 2 x 0.5 + 3 x 0.25 = 2.75 um
    c = np.array([1e-3, 2e-3, 3e-3])
    assert ComponentPolynomial("EXX", c).error_motion(_run(X=[200.0]))[0, 0] == pytest.approx(1.52e-3)
    assert ComponentPolynomial("EXC", c).error_motion(_run(C=[0.5]))[0, 0] == pytest.approx(2.75e-3)


def test_a_table_axis_moves_the_workpiece_the_other_way():
    # the table's own +2 um in X moves the tip, seen from the workpiece, by -2 um; a slide's own +2 um by +2 um
    axes = {a: Axis(a, (-500.0, 500.0)) for a in "XYZ"}
    run = Run({a: np.array([100.0]) for a in "XYZ"}, np.zeros((1, 3)))
    table = ComponentTable("EXY", ("Y",), (np.array([0.0, 400.0]),), np.array([2e-3, 2e-3]))
    for structure, expected in (("w Y' b X Z t", -2e-3), ("w b Y X Z t", 2e-3)):
        machine = Machine("m", "cmm", parse_structure(structure), axes, (table,))
        assert machine.tip_error(run)[0] == pytest.approx([expected, 0.0, 0.0], abs=1e-15)


def test_names_are_checked():
    with pytest.raises(UsageError, match="is not a component error"):
        ComponentPolynomial("XEX")


def test_a_component_that_goes_with_a_temperature():
    """EAZ of 2 urad/K + 1 urad/(K m): spindle at 25 degC, Z at -500 mm: (2 - 0.5) 5 = 7.5 urad; behind a lag of its own time 1 - 1/e of it."""
    one = ComponentWarming("EAZ", sensor="spindle", coefficients=np.array([2e-6, 1e-6]))
    place = {"Z": np.array([-500.0])}
    run = Run(place, np.zeros((1, 3)), {"temp_spindle_C": np.array([25.0])})
    assert one.error_motion(run)[0].tolist() == pytest.approx([0, 0, 0, 7.5e-6, 0, 0])
    late = ComponentWarming("EAZ", sensor="spindle", coefficients=np.array([2e-6, 1e-6]), tau=60.0)
    step = Series(np.array([-1e-6, 0.0, 100.0]), np.array([20.0, 25.0, 25.0]))
    after = Run(place, np.zeros((1, 3)), {"time_s": np.array([60.0])}, {}, {"spindle": step})
    assert late.error_motion(after)[0, 3] == pytest.approx(7.5e-6 * (1 - np.exp(-1.0)), rel=1e-6)
    assert required(late) == ("temp_spindle_C",)
    with pytest.raises(UsageError, match="negative"):
        ComponentWarming("EAZ", tau=-1.0)
