"""Plans of growing number: standard strategies that fit a number of touches, the farthest place, thinning."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.placing.test_design import PLANE, candidates, on_plane
from vcmm.answer.placing.design import Design, Target
from vcmm.answer.placing.growing_plans import _farthest, _thin, _touching, standard_points
from vcmm.part.part import Feature

AXIS = np.array([0.0, 0.0, 1.0])
TALL = Feature("pin", "cylinder", np.zeros(3), AXIS, np.array([5.0]), extent=(30.0,))


def test_standards_of_a_plane():
    found = dict(standard_points(PLANE, 4, 5.0))
    assert {"grid 4", "hammersley 3", "hammersley 4"} <= set(found)
    assert all(len(p) <= 4 for p in found.values())
    assert np.abs(found["grid 4"][:, :2]) == pytest.approx(35.0)  # 40 mm less the margin


def test_levels_of_a_cylinder_keep_the_margin():
    found = list(standard_points(TALL, 8, 4.0))
    names = [n for n, _ in found]
    assert {"levels 6", "levels 8", "staggered 6", "helix 6", "helix 8"} <= set(names)
    two = next(p for n, p in found if n == "levels 6")
    assert sorted(set(two[:, 2].round(9))) == [4.0, 26.0]  # 30 mm, 4 mm from each end
    assert all(4.0 - 1e-9 <= z <= 26.0 + 1e-9 for _, p in found for z in p[:, 2])


@pytest.mark.parametrize(("kind", "sizes", "extent", "name"), [
    ("line", (), (40.0,), "even 10"), ("circle", (10.0,), (), "even 10"), ("sphere", (8.0,), (), "spiral 10"),
    ("torus", (20.0, 4.0), (), "grid 9"),
])  # fmt: skip
def test_other_kinds_have_standards(kind, sizes, extent, name):
    axis = np.array([1.0, 0, 0]) if kind == "line" else AXIS if kind != "sphere" else np.zeros(3)
    feature = Feature("f", kind, np.zeros(3), axis, np.array(sizes), extent=extent)
    assert name in dict(standard_points(feature, 10, 1.0))


def test_the_farthest_candidate():
    points = on_plane((-30, -30), (30, -30), (-30, 30), (0, 0), (40, 40))
    counts = np.array([1, 1, 1, 0, 0])
    design = Design(candidates(PLANE, points), Target(np.zeros((0, 3)), np.zeros(0), "D"), counts)
    assert _farthest(design, 0) == 4  # 41 mm from its neighbours, the middle only 42... from the corners
    assert _touching(design) == 3.0  # three touches of a second each


def test_thinning_keeps_ends_and_more_of_the_small():
    kept = _thin(list(range(1, 201)), 20)  # type: ignore[arg-type]
    assert kept[0] == 1
    assert kept[-1] == 200
    assert len(kept) <= 20
    assert sum(n <= 14 for n in kept) >= len(kept) // 2 - 1  # geometric: half of them below sqrt(200)
    assert _thin([1, 2], 20) == [1, 2]  # type: ignore[list-item]
