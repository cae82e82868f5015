"""What is inspected of the finished part: points that were cut, gouges, offsets that readings count from."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import ModelLimit
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.inspection import cut_points, measuring_world
from vcmm.shop.machining.preparation import set_up

TALL = 'boss = { type = "cylinder", point = "0 0 -8 mm", axis = [0, 0, 1], diameter = "100 mm", length = "6 mm" }'
# its lower half stands 3 mm over the boss that is cut: 50 mm of radius there, drawn 47
STEP = 'collar = { type = "cylinder", point = "0 0 -8 mm", axis = [0, 0, 1], diameter = "94 mm", length = "6 mm" }'


def prepared(tmp_path, scenario=shop.SCENARIO):
    return set_up(vcmm.load_cut(shop.write(tmp_path, scenario=scenario)))


def test_every_point_of_a_boss_is_cut(tmp_path):
    job = prepared(tmp_path)
    plan, surface, notes = cut_points(job, gauge_plan(job.scenario.part, None))
    assert len(plan.steps[0].points) == len(surface.points) == 72
    assert notes == ()
    assert surface.s == pytest.approx(np.zeros(72), abs=1e-9)


def test_a_feature_of_which_nothing_is_cut_is_named(tmp_path):
    """3 mm of material are left over the collar, more than the 2 mm that are looked at."""
    job = prepared(tmp_path, shop.SCENARIO.replace(TALL, STEP).replace('"boss"', '"collar"'))
    with pytest.raises(
        ModelLimit, match="feature collar: the program cuts 0 of its 72 inspection points within 2 mm"
    ):
        cut_points(job, gauge_plan(job.scenario.part, None))


def test_a_gouge_is_told_with_depth_and_line(tmp_path):
    """Drawn 0.4 mm larger in diameter than it is cut: the program gouges by 0.2 mm, in the line of its arc."""
    job = prepared(tmp_path, shop.SCENARIO.replace('diameter = "100 mm"', 'diameter = "100.4 mm"'))
    _, _, (note,) = cut_points(job, gauge_plan(job.scenario.part, None))
    assert "gouges 72 of its 72 inspection points deeper than 10 um, by 0.200 mm at most (line 10)" in note


def test_the_ideal_gauge_errs_nowhere(tmp_path):
    job = prepared(tmp_path)
    plan, surface, _ = cut_points(job, gauge_plan(job.scenario.part, None))
    world = measuring_world(job, plan, surface)
    assert not world.errors().any()
    assert world.influences() == ()
