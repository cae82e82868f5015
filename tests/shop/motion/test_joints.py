"""Where the control stops, waits or runs through."""

from __future__ import annotations

import numpy as np
import pytest

from tests.programs import AT, corner, line, mill
from vcmm.program.limits import Control
from vcmm.program.moves import Move
from vcmm.shop.motion.timing import plan_motion


@pytest.mark.parametrize(
    "moves",
    [
        corner(0.0),
        [corner()[0]._replace(exact_stop=True), corner()[1]],
        [corner()[0], Move("dwell", AT, (50, 0, 0), (50, 0, 0), seconds=0.0), corner()[1]],
        [line((0, 0, 0), (50, 0, 0)), line((50, 0, 0), (0, 0, 0))],
        [line((0, 0, 0), (50, 0, 0)), Move("rapid", AT, (50, 0, 0), (50, 0, 9))],
        [line((0, 0, 0), (50, 0, 0)), Move("thread", AT, (50, 0, 0), (50, 0, 9), feed=100.0)],
        [line((0, 0, 0), (50, 0, 0)), line((50, 0, 0), (50, 0, 0), rotary_end=(0, 0, 1.0))],
    ],
    ids=["tolerance 0", "exact stop", "dwell", "back", "rapid", "thread", "rotary alone"],
)
def test_the_control_stops(moves):
    timing = plan_motion(moves, mill())
    assert len(timing.first) == 2
    at = timing.state(timing.stretch_ends[:1])
    assert np.abs(at.speed).max() < 1e-9
    assert at.position[0, :3] == pytest.approx([50, 0, 0], abs=1e-9)


def test_axes_that_were_moved_unseen_start_again_from_rest():
    moves = [line((0, 0, 0), (50, 0, 0)), line((60, 0, 0), (90, 0, 0))]
    timing = plan_motion(moves, mill())
    assert len(timing.first) == 2
    assert timing.stretch_starts[1] > timing.stretch_ends[0]
    assert timing.state(timing.stretch_starts[1:]).position[0, 0] == pytest.approx(60.0)


def test_two_lines_that_go_on_straight_are_one():
    halves = [line((0, 0, 0), (40, 0, 0)), line((40, 0, 0), (100, 0, 0))]
    assert plan_motion(halves, mill()).seconds == pytest.approx(1.2, abs=1e-12)


def test_dwell_and_tool_change_take_their_time():
    moves = [
        line((0, 0, 0), (100, 0, 0), tool=1),
        Move("dwell", AT, (100, 0, 0), (100, 0, 0), seconds=2.5, tool=1),
        line((100, 0, 0), (200, 0, 0), tool=2),
    ]
    timing = plan_motion(moves, mill(), Control(tool_change=4.0))
    assert timing.seconds == pytest.approx(1.2 + 2.5 + 4.0 + 1.2, abs=1e-9)
    assert timing.joints.tool_changes == 1
