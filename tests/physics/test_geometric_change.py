"""vcmm/physics/structure/geometric_change.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.structure.geometric_change import GeometricChange

GRID = np.array([0.0, 400.0])


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
