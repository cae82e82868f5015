"""vcmm/physics/catalogue/map_interpolation.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.map_interpolation import MapInterpolation
from vcmm.physics.structure.component import ComponentTable


def _run(x: list[float], offset: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Run:
    n = len(x)
    return Run({"X": np.array(x), "Y": np.zeros(n), "Z": np.zeros(n)}, np.tile(offset, (n, 1)))


GRID = np.array([0.0, 400.0])


TABLES = (
    ComponentTable("EBX", ("X",), (GRID,), np.array([0.0, 10e-6])),
    ComponentTable("ECX", ("X",), (np.array([0.0, 100.0, 400.0]),), np.array([0.0, 4e-6, 0.0])),
    ComponentTable("EYX", ("X",), (GRID,), np.array([0.0, 2e-3])),
)


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
