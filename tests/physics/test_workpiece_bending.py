"""The workpiece that gives way: numbers by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.workpiece_bending import WorkpieceBending


def run(z: list[float]) -> Run:
    n = len(z)
    columns = {"part_x_mm": np.zeros(n), "part_y_mm": np.zeros(n), "part_z_mm": np.array(z)}
    columns |= {"force_x_N": np.full(n, 200.0), "force_y_N": np.full(n, -50.0), "force_z_N": np.zeros(n)}
    return Run({"X": np.zeros(n)}, np.zeros((n, 3)), columns)


def test_a_wall_gives_way_by_the_cube_of_its_height():
    """200 N at the top of a wall of 0.1 um/N: 20 um; at half its height an eighth of it; at its foot and below nothing."""
    wall = WorkpieceBending("x", compliance=1e-4, foot=-30.0, height=30.0)
    moved = wall.error_motion(run([0.0, -15.0, -30.0, -40.0]))
    assert moved[:, 0] == pytest.approx([20e-3, 2.5e-3, 0.0, 0.0])
    assert not moved[:, 1:].any()


def test_a_soft_fixture_gives_way_alike_everywhere():
    """-50 N in Y and 0.1 um/N: the part goes 5 um the other way, and the tool leaves as much on the side it pushes at."""
    moved = WorkpieceBending("y", compliance=1e-4).error_motion(run([0.0, -30.0]))
    assert moved[:, 1] == pytest.approx([-5e-3, -5e-3])


def test_what_is_no_direction_or_height_is_refused():
    with pytest.raises(UsageError, match='direction and over must be "x", "y" or "z"'):
        WorkpieceBending("X")
    with pytest.raises(UsageError, match=r"height = -3 mm is negative"):
        WorkpieceBending("x", height=-3.0)
