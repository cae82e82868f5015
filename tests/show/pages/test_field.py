"""The picture of an error map: grid or arrows, and how much it is magnified."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.show.pages.field import _segments, field_page, magnification_of
from vcmm.task.response.volumetric import field


def test_magnification_is_round_and_shows_an_eighth_of_the_size():
    """0.12 x 1000 mm / 10 um = 12 000: rounded down to 10 000."""
    points = np.array([[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0]])
    assert magnification_of(points, np.array([[0.0, 0.0, 0.01]])) == pytest.approx(10_000.0)
    assert magnification_of(points, np.zeros((1, 3))) == 1.0


def test_edges_of_a_grid():
    """A cube of 2 x 2 x 2 nodes has 12 edges of length 1."""
    grid = np.stack(np.meshgrid(*[[0.0, 1.0]] * 3, indexing="ij"), axis=-1)
    edges = _segments(grid)
    assert edges.shape == (12, 2, 3)
    assert np.linalg.norm(edges[:, 1] - edges[:, 0], axis=1) == pytest.approx([1.0] * 12)


def test_given_positions_have_arrows():
    cmm = machine(ScaleFactor("X", 1e-5))
    run = Run({a: np.array([0.0, 10.0, 500.0]) for a in "XYZ"}, np.zeros((3, 3)))
    assert "Tip errors at the given positions" in field_page(cmm, field(cmm, run))
    assert "Deformed volume" in field_page(cmm, field(cmm, nodes=3))
