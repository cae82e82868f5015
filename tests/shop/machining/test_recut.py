"""Points cut again with the tools really displaced: a scale, and what is left out of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import vcmm
from tests.shop.machining import lathe, shop
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.tool_bending import ToolDeflection
from vcmm.shop.machining.contact_path import surface_at
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.recut import POINTS, _around, _whole_tool, recut


def points(job):
    (step,) = gauge_plan(job.scenario.part, None).steps
    return surface_at(job, step.points, step.normals, exact=False)


def test_contacts_follow_a_scale_to_second_order(tmp_path):
    """100 um/m at X 360: e = 36 um; contacts and envelope of a cutter of R 10 differ by e^2 / 2R = 0.065 um at most."""
    job = set_up(vcmm.load_cut(shop.write(tmp_path)))
    machine = replace(job.machine, effects=(ScaleFactor(axis="X", k=1e-4),))
    bent = replace(job, scenario=replace(job.scenario, machine=machine))
    found = recut(bent, points(bent))
    assert found.points == POINTS
    assert 1e-6 < found.largest < 6.5e-5
    nothing = recut(job, points(job))
    assert nothing.largest < 1e-9


def test_points_in_the_side_of_a_gouge_are_left_out(tmp_path):
    job = set_up(vcmm.load_cut(shop.write(tmp_path)))
    surface = points(job)
    deep = replace(surface, contact_s=surface.contact_s - 1.0)
    assert recut(job, deep) is None


def test_all_passes_of_a_turned_part(tmp_path):
    job = lathe.shop(lathe.plain(tmp_path))
    found = recut(job, points(job))
    assert found.points == POINTS
    assert found.largest < 1e-9


def test_what_is_no_displacement_of_a_whole_tool_is_left_out(tmp_path):
    job = set_up(vcmm.load_cut(shop.write(tmp_path)))
    effects = (ScaleFactor(axis="X", k=1e-4), Backlash(axis="X", gap=1e-3), ToolDeflection(compliance=1e-4))
    assert [e.name for e in _whole_tool(replace(job.machine, effects=effects)).effects] == ["scale_factor"]


def test_rows_beside_those_that_touch_are_feeds():
    """Row 5 touches: with two feeds before and after; 4 is a rapid."""
    feed = np.array([True] * 10)
    feed[4] = False
    assert _around(np.array([[5, -1]]), feed).tolist() == [3, 5, 6, 7]
