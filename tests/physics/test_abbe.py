"""vcmm/physics/structure/abbe.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.structure.abbe import AbbeCountedTwice, AbbeOffset, rotation_tables
from vcmm.physics.structure.component import ComponentSpline, ComponentTable

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


def test_abbe_without_tables_is_refused():
    with pytest.raises(UsageError, match="axis Y has no rotation tables"):
        AbbeOffset.from_tables("Y", TABLES)
    with pytest.raises(UsageError, match="needs the rotation tables of axis X"):
        AbbeOffset("X").error_motion(_run([0.0]))
    with pytest.raises(ModelLimit, match="X = 401 lies outside"):
        AbbeOffset.from_tables("X", TABLES).error_motion(_run([401.0]))


def test_rotation_tables_of_a_spline_are_sampled_between_its_nodes():
    # natural spline through 0, 1, 0 at 0, 100, 200: half way up 0.6875 (see test_component), a straight line 0.5
    spline = ComponentSpline("EBX", np.array([0.0, 100.0, 200.0]), np.array([0.0, 1e-6, 0.0]))
    effect = AbbeOffset.from_tables("X", (spline,))
    assert len(effect.grids[0]) == 17
    assert effect._interpolate(_run([50.0]))[0, 1] == pytest.approx(0.6875e-3, abs=1e-12)
