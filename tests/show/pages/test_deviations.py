"""The picture of deviations: needles by hand, and a surface through nominal points."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import BORE, scenario
from vcmm.part.nominal import NominalPoints
from vcmm.part.part import Feature
from vcmm.show.pages.uncertainty import deviation_items, deviations_block, magnification
from vcmm.show.pages.view import feature_mesh
from vcmm.show.report.blocks import Lines, Points

UP = np.array([[0.0, 0, 1]] * 4)
SQUARE = np.array([[0.0, 0, 0], [10, 0, 0], [10, 10, 0], [0, 10, 0]])


def surface(normals: np.ndarray) -> Feature:
    nominal = NominalPoints(SQUARE, normals)
    return Feature("s", "points", np.zeros(3), np.zeros(3), np.zeros(0), nominal=nominal)


def test_needles_stand_on_the_touches_along_their_normals():
    """A bore of radius 15 mm: 5 um more metal towards the axis at the first touch, 2 um less at the second; the others are perfect."""
    task = scenario().task()
    assert deviations_block(task) == []
    t, form = task.touches, np.zeros(task.touches.run.n)
    first, second = t.rows[BORE.name][:2]
    form[first], form[second] = 5e-3, -2e-3
    items = deviation_items(replace(task, form=form), 1000.0)
    more, less = (i for i in items if isinstance(i, Lines))
    assert (more.name, less.name) == ("material left over", "material missing")
    for needle, row, length in ((more, first, 5.0), (less, second, -2.0)):
        (foot, tip), outward = np.asarray(needle.points)[0], t.pose.turn(t.normals[row])
        assert foot == pytest.approx(t.pose.apply(t.points[row]))
        assert tip - foot == pytest.approx(length * outward)
    dots = [i for i in items if isinstance(i, Points)]
    assert dots[0].hover[0].endswith("deviation +5.00 µm")
    assert dots[1].hover[0].endswith("deviation -2.00 µm")
    assert "from -2.00 to +5.00" in deviations_block(replace(task, form=form))[0]


def test_the_longest_needle_is_a_twelfth_of_the_part_or_less():
    """120 mm / 12 / 6 um = 1667: 1000."""
    points = np.array([[0.0, 0, 0], [120, 0, 0]])
    assert magnification(points, np.array([2e-3, -6e-3])) == 1000.0


def test_a_surface_through_nominal_points():
    found = feature_mesh(surface(UP))
    assert found is not None
    assert sorted(set(np.asarray(found.faces).ravel())) == [0, 1, 2, 3]
    assert len(found.faces) == 2
    around = np.array([[0.0, 0, 1], [0, 0, 1], [0, 0, 1], [0, 0.1, -1]])
    assert feature_mesh(surface(around)) is None  # goes round an edge: seen from nowhere as a whole
