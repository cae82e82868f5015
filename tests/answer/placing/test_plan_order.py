"""The order of touches: short ways, and drift that does not look like the measurand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.answer.placing.test_design import on_plane
from tests.build import DIAMETER, scenario
from vcmm.answer.placing.candidates import problem_of
from vcmm.answer.placing.design import Design, Target
from vcmm.answer.placing.plan_order import (
    Visit,
    _changes_before,
    _steps,
    _visit,
    order_touches,
    readable,
    ways,
)


def test_there_and_back_takes_drift_out_of_a_distance():
    """Two faces, four touches each, drift along the distance: A B ... A again leaves less than a tenth of A A A A B B B B."""
    group = np.repeat([0, 1], 4)
    tips = np.concatenate(
        [on_plane(*((0, y) for y in range(0, 40, 10))), on_plane(*((100, y) for y in range(0, 40, 10)))]
    )
    pull = np.where(group == 0, -0.25, 0.25)[None, :, None]
    visit = Visit(group, 1.2, ways(tips, group, group * 0, 100.0, 20.0, 0.0), pull)
    plain, careful = order_touches(visit, 0.0), order_touches(visit, 1e3)
    assert visit.drift(careful) < 0.01 * visit.drift(plain)
    assert sorted(careful) == list(range(8))
    assert visit.times(plain)[-1] <= visit.times(careful)[-1]


def test_ways_and_times_by_hand():
    """30 mm at 10 mm/s; between features 2 x 5 mm up and down; 20 s for another stylus. A touch takes 1.2 s."""
    tips = on_plane((0, 0), (30, 0), (30, 40))
    way = ways(tips, np.array([0, 0, 1]), np.array([0, 0, 1]), 10.0, 5.0, 20.0)
    assert way[0, 1] == pytest.approx(3.0)
    assert way[1, 2] == pytest.approx((40.0 + 10.0) / 10.0 + 20.0)
    visit = Visit(np.array([0, 0, 1]), 1.2, way, np.array([[[1.0], [0.0], [-2.0]]]))
    assert visit.times(np.array([0, 1, 2])) == pytest.approx([1.2, 5.4, 31.6])
    assert visit.drift(np.array([0, 1, 2])) == pytest.approx((1.2 - 2.0 * 31.6) ** 2)
    assert visit.cost(np.array([0, 1, 2]), 0.1) == pytest.approx(31.6 + 0.1 * 62.0**2)


def test_a_crossing_way_is_untangled():
    """Four corners of a rectangle of 40 x 10 mm: along a side is 10 + 40 + 10 mm, across would be more."""
    tips = on_plane((0, 0), (40, 10), (40, 0), (0, 10))
    visit = Visit(
        np.zeros(4, dtype=int), 0.0, ways(tips, np.zeros(4), np.zeros(4), 1.0, 0.0, 0.0), np.zeros((0, 4, 0))
    )
    assert visit.times(order_touches(visit))[-1] == pytest.approx(60.0)


@pytest.fixture(scope="module")
def bore_and_face():
    """The bore of tests/build.py (15 mm radius) and its left face, six and four touches, drift along x, two styli."""
    job = scenario(characteristics=(DIAMETER,))
    touch = replace(job.plan.touch, approach=3.0, speed=5.0, positioning=50.0, clearance=20.0)
    styli = {**job.plan.styli, "other": replace(job.plan.styli["down"], name="other")}
    job = replace(job, plan=replace(job.plan, touch=touch, styli=styli))
    places = {
        s.feature: s.points[::3] if s.feature == "bore" else s.points
        for s in job.plan.steps
        if s.feature != "right"
    }
    return problem_of(job, {"bore": "down", "left": "other"}, places, {}, drift=(1e-3, 0.0, 0.0))


def test_a_visit_by_hand(bore_and_face):
    """Approach and retract of 3 mm at 5 mm/s: 1.2 s. Drift of 1 um/s along x reads n_x of each touch."""
    problem, which = bore_and_face, np.arange(10)
    target = Target(np.array([[0.0, 0, 0, 0, 2.0, 0, 0, 0]]), np.array([4.0]))
    design = Design(problem.candidates, target, np.ones(10, dtype=int))
    visit = _visit(problem, design, which, target, 20.0)
    assert visit.seconds == pytest.approx(1.2)
    assert visit.way[5, 6] > 20.0 + 2 * 20.0 / 50.0  # another feature and another stylus
    assert visit.way[0, 1] < 1.0
    read = 2.0 * design.sensitivities(target.rows)  # the root of the weight
    normal = problem.candidates.normals[:, 0]
    assert visit.pull[0, :, 0] == pytest.approx(read[0] * 1e-3 * normal)
    assert _changes_before(problem.candidates.feature, problem).tolist() == [0.0] * 6 + [1.0] * 4
    steps = _steps(problem, which)
    assert [(s.feature, s.stylus, len(s.points)) for s in steps] == [
        ("bore", "down", 6),
        ("left", "other", 4),
    ]


def test_visits_too_short_for_a_fit_are_joined(bore_and_face):
    # visits of one touch are joined with the others of their feature; the bore keeps its place before the face
    order = np.array([0, 1, 2, 3, 4, 6, 5, 7, 8, 9])
    assert readable(bore_and_face, order).tolist() == list(range(10))
