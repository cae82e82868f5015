"""What the stored tables do not say: change since calibration, Abbe arms, and what lies between the nodes."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.map_interpolation import MapInterpolation
from vcmm.physics.structure.abbe import AbbeCountedTwice, AbbeOffset, rotation_tables
from vcmm.physics.structure.component import ComponentSpline, ComponentTable
from vcmm.physics.structure.geometric_change import GeometricChange

GRID = np.array([0.0, 400.0])
TABLES = (
    ComponentTable("EBX", ("X",), (GRID,), np.array([0.0, 10e-6])),
    ComponentTable("ECX", ("X",), (np.array([0.0, 100.0, 400.0]),), np.array([0.0, 4e-6, 0.0])),
    ComponentTable("EYX", ("X",), (GRID,), np.array([0.0, 2e-3])),
)


def _run(x: list[float], offset: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Run:
    n = len(x)
    return Run({"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}, np.tile(offset, (n, 1)))


def _machine(*effects, structure: str = "w b Y X Z t", **measured_at) -> Machine:
    axes = {a: Axis(a, (-1000.0, 1000.0), measured_at=measured_at.get(a)) for a in "XYZ"}
    return Machine("m", "cmm", parse_structure(structure), axes, effects)


def test_geometric_change_by_hand():
    # X = 300 of 0..400: s = 0.5, P = 1, 0.5, (3 x 0.25 - 1) / 2 = -0.125: 1 + 2 x 0.5 - 3 x 0.125 = 1.625 um
    change = GeometricChange("EXX", GRID, np.array([1e-3, 2e-3, 3e-3]))
    assert _machine(change).tip_error(_run([300.0]))[0] == pytest.approx([1.625e-3, 0, 0], abs=1e-15)
    # the same motion of a table axis moves the workpiece: the tip, seen from it, goes the other way
    table = _machine(change, structure="w X' b Y Z t")
    assert table.tip_error(_run([300.0]))[0, 0] == pytest.approx(-1.625e-3, abs=1e-15)


def test_geometric_change_keeps_its_value_beyond_the_ends():
    # s = 1 at X = 400: 1 + 2 + 3 = 6 um; s = -1 at X = 0: 1 - 2 + 3 = 2 um. At X = 600 the polynomial would give
    # s = 2: 1 + 2 x 2 + 3 x (3 x 4 - 1) / 2 = 21.5 um
    change = GeometricChange("EXX", GRID, np.array([1e-3, 2e-3, 3e-3]))
    for exact in (False, True):
        beyond = _machine(change).tip_error(_run([400.0, 600.0, 0.0, -300.0]), exact)[:, 0]
        assert beyond == pytest.approx([6e-3, 6e-3, 2e-3, 2e-3], abs=1e-12)


def test_geometric_change_rms_is_that_over_the_travel():
    # sqrt(1 + 4 / 3 + 9 / 5) = 2.033060 um, and the same from many points
    change = GeometricChange("EXX", GRID, np.array([1e-3, 2e-3, 3e-3]))
    assert change.rms == pytest.approx(2.033060e-3, abs=1e-9)
    many = change.error_motion(_run(list((np.arange(4000) + 0.5) / 10)))[:, 0]
    assert np.sqrt((many**2).mean()) == pytest.approx(change.rms, rel=1e-6)


def test_geometric_change_needs_two_ends_in_order():
    with pytest.raises(UsageError, match="two ends of the travel"):
        GeometricChange("EXX", np.array([100.0, 0.0]))


def test_map_interpolation_is_zero_at_the_nodes():
    nodes = np.array([0.0, 100.0, 400.0])
    for shape, size in (("smooth", 3), ("ripple", 2), ("cells", 2)):
        motion = MapInterpolation("EYX", nodes, shape, np.full(size, 1e-3)).error_motion(_run(list(nodes)))
        assert motion == pytest.approx(np.zeros((3, 6)), abs=1e-18)


def test_map_interpolation_by_hand():
    nodes = np.array([0.0, 100.0, 400.0])
    # half way between nodes 4 x 0.5 x 0.5 = 1; at 175 mm u = 75 / 300 = 0.25: 4 x 0.25 x 0.75 = 0.75, times 2 um
    bow = MapInterpolation("EYX", nodes, "smooth", np.array([2e-3]))
    assert bow.error_motion(_run([50.0, 175.0]))[:, 1] == pytest.approx([2e-3, 1.5e-3], abs=1e-18)
    # second term: at 250 mm u = 0.5, s = 2 x 250 / 400 - 1 = 0.25: 1 um x 0.25
    tilt = MapInterpolation("EYX", nodes, "smooth", np.array([0.0, 1e-3]))
    assert tilt.error_motion(_run([250.0]))[0, 1] == pytest.approx(0.25e-3, abs=1e-18)
    # ripple at u = 0.25: sin(90 deg) = 1; cells: the second interval has its own height
    ripple = MapInterpolation("EYX", nodes, "ripple", np.array([2e-3]))
    assert ripple.error_motion(_run([25.0, 75.0]))[:, 1] == pytest.approx([2e-3, -2e-3], abs=1e-15)
    cells = MapInterpolation("EYX", nodes, "cells", np.array([1e-3, 3e-3]))
    assert cells.error_motion(_run([50.0, 250.0]))[:, 1] == pytest.approx([1e-3, 3e-3], abs=1e-18)
    # rms of 4 u (1 - u): 16 (1/3 - 1/2 + 1/5) = 8/15, root 0.730297, times 2 um
    assert bow.rms == pytest.approx(2e-3 * 0.730297, rel=1e-4)


def test_map_interpolation_of_a_stored_table():
    assert np.array_equal(MapInterpolation.from_table(TABLES[1]).nodes, [0.0, 100.0, 400.0])
    assert len(MapInterpolation.from_table(TABLES[1], "cells").coefficients) == 2
    with pytest.raises(UsageError, match="allowed: smooth, ripple, cells"):
        MapInterpolation("EXX", GRID, "cubic")
    with pytest.raises(UsageError, match="2 coefficients for 1 intervals"):
        MapInterpolation("EXX", GRID, "cells", np.zeros(2))
    with pytest.raises(ModelLimit, match="row 2 at 401 lies outside"):
        MapInterpolation("EXX", GRID).error_motion(_run([0.0, 401.0]))


def test_abbe_offset_by_hand():
    # EBX = 10 urad at X = 400, arm 100 mm down: w x r = (B z, 0, 0) = 10e-6 x (-100) = -1 um in X;
    # ECX = 4 urad at X = 100 with EBX = 2.5 urad, arm 50 mm in +Y: (-C y, 0, 0) = -4e-6 x 50 = -0.2 um in X
    effect = AbbeOffset.from_tables("X", TABLES)
    for x, arm, expected in ((400.0, (0.0, 0.0, -100.0), -1e-3), (100.0, (0.0, 50.0, 0.0), -0.2e-3)):
        moved = _machine(AbbeOffset("X", effect.arguments, effect.grids, effect.deviation, np.array(arm)))
        assert moved.tip_error(_run([x]))[0] == pytest.approx([expected, 0, 0], abs=1e-15)


@pytest.mark.parametrize("structure", ["w b Y X Z t", "w X' b Y Z t"])
def test_abbe_counted_twice_is_what_a_forgotten_measured_at_leaves(structure: str):
    # E acts about the point where the translations were observed; a model without it is wrong by -w x measured_at:
    # tool side at X = 400, measured 120 mm below: -10e-6 x (-120) = +1.2 um in X
    arm = (30.0, -40.0, -120.0)
    run = _run([0.0, 100.0, 250.0, 400.0], (0.0, 0.0, -80.0))
    true = _machine(*TABLES, structure=structure, X=arm).tip_error(run)
    model = _machine(*TABLES, structure=structure)
    twice = AbbeCountedTwice.from_tables("X", model.effects, arm)
    assert twice.share == 1.0
    assert model.with_effect(twice).tip_error(run) == pytest.approx(true, abs=1e-15)
    if structure == "w b Y X Z t":
        assert (true - model.tip_error(run))[3, 0] == pytest.approx(1.2e-3, abs=1e-15)


def test_rotation_tables_share_their_nodes():
    arguments, grids, rotations = rotation_tables("X", TABLES)
    assert arguments == ("X",)
    assert np.array_equal(grids[0], [0.0, 100.0, 400.0])
    assert rotations == pytest.approx(np.array([[0, 0, 0], [0, 2.5e-6, 4e-6], [0, 10e-6, 0]]), abs=1e-18)


def test_rotation_tables_of_a_spline_are_sampled_between_its_nodes():
    # natural spline through 0, 1, 0 at 0, 100, 200: half way up 0.6875 (see test_component), a straight line 0.5
    spline = ComponentSpline("EBX", np.array([0.0, 100.0, 200.0]), np.array([0.0, 1e-6, 0.0]))
    effect = AbbeOffset.from_tables("X", (spline,))
    assert len(effect.grids[0]) == 17
    assert effect._interpolate(_run([50.0]))[0, 1] == pytest.approx(0.6875e-3, abs=1e-12)


def test_abbe_without_tables_is_refused():
    with pytest.raises(UsageError, match="axis Y has no rotation tables"):
        AbbeOffset.from_tables("Y", TABLES)
    with pytest.raises(UsageError, match="needs the rotation tables of axis X"):
        AbbeOffset("X").error_motion(_run([0.0]))
    with pytest.raises(ModelLimit, match="X = 401 lies outside"):
        AbbeOffset.from_tables("X", TABLES).error_motion(_run([401.0]))
