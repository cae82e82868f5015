"""The tool and the touches by hand: bodies along the shaft, gaps they keep, start and retract of every touch."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.placing.placing_independent import DOWN, HEAD, job
from vcmm.answer.placing.tool import NAMES, Tooling, _round_quill, shaft_radius, tool_bodies, touch_sequence
from vcmm.task.measuring.obstacles import Head, Surroundings
from vcmm.task.measuring.plan import Plan, Step, Stylus, Touch

LONG = Stylus("long", np.array([0.0, 0.0, -90.0]), 2.0, 60.0)


def test_shafts():
    assert shaft_radius(HEAD, DOWN) == 1.0  # stated: 2 mm
    assert shaft_radius(HEAD, LONG) == pytest.approx(1.4)  # 0.7 of the tip
    assert shaft_radius(Head(shafts={"long": 10.0}), LONG) == 2.0  # never thicker than the tip


def test_bodies_by_hand():
    """Shaft 0 to 60 mm, extension on to 90 (begun a radius higher), head of 60 mm on top of it, then 200 mm of quill."""
    b = tool_bodies(HEAD, DOWN)
    assert b.centre[NAMES.index("shaft"), 2] == 30.0
    assert np.abs(b.edges[NAMES.index("shaft")]).max() == 30.0
    radius = 0.5 * HEAD.extension
    assert b.centre[NAMES.index("extension"), 2] == pytest.approx(0.5 * (60.0 + radius + 90.0))
    assert b.centre[NAMES.index("head"), 2] == pytest.approx(90.0 + 30.0)
    assert b.round[NAMES.index("head")] == 20.0
    assert b.centre[NAMES.index("quill"), 2] == pytest.approx(90.0 + 60.0 + 100.0)
    half = np.linalg.norm(b.edges[NAMES.index("quill")], axis=1)
    assert half == pytest.approx([25.0, 25.0, 100.0, 0.0])
    wide = _round_quill(b)
    assert wide.round[NAMES.index("quill")] == pytest.approx(25.0 * np.sqrt(2.0))
    assert np.linalg.norm(wide.edges[NAMES.index("quill")], axis=1)[:2] == pytest.approx(25.0 * np.sqrt(2.0))


def sequence():
    """Two touches on a face with one stylus, then one with another: approach 3 mm along a slant."""
    points, up = np.array([[1.0, 0, 0], [2.0, 0, 0]]), np.tile([0.0, 0, 1.0], (2, 1))
    slant = np.tile([0.6, 0.0, -0.8], (2, 1))
    steps = (Step("face", "long", points, up, slant), Step("rim", "fine", points[:1], up[:1]))
    fine = Stylus("fine", np.array([0.0, 0.0, -50.0]), 0.5, 50.0)
    return touch_sequence(Plan(steps, {"long": LONG, "fine": fine}, Touch(approach=3.0)))


def test_touches_by_hand():
    s = sequence()
    assert s.names == ("point 1 on face", "point 2 on face", "point 1 on rim")
    assert s.tip[:, 2].tolist() == [2.0, 2.0, 0.5]
    assert s.start[0] == pytest.approx([1.0 - 1.8, 0.0, 2.0 + 2.4])  # against the slant
    assert s.end[0] == pytest.approx([1.0, 0.0, 5.0])  # along the normal
    assert s.start[2] == pytest.approx([1.0, 0.0, 3.5])
    assert s.pairs().tolist() == [[0, 1]]
    assert s.ends.tolist() == [0, 1, 2]


def test_gaps_that_are_kept():
    """The shaft keeps what is asked for, but no more than half of what the tip is thicker."""
    rows = sequence()
    tooling = Tooling(rows, Surroundings(head=HEAD, shaft=0.25, safe=1.5))
    # long: 0.5 (2 - 1.4) = 0.3; fine: 0.5 (0.5 - 0.35) = 0.075
    assert tooling.need(0) == pytest.approx([0.25, 0.25, 0.075])
    assert tooling.need(2).tolist() == [1.5, 1.5, 1.5]


def test_turning_about_a_vertical_stylus_shows_the_same_side():
    tooling = Tooling(touch_sequence(job(both=False).plan), job().surroundings)
    c, s = np.cos(0.7), np.sin(0.7)
    about_z = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])
    about_x = np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])
    assert tooling.key(about_z) == tooling.key(np.eye(3))
    assert tooling.key(about_x) != tooling.key(np.eye(3))
