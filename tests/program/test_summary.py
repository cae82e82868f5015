"""What a program amounts to, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.program.moves import Move, Program, Source
from vcmm.program.setup import Setup
from vcmm.program.summary import arc_angle, move_length, summary

AT = Source(1, 1, 2)
ARC = Move("arc", AT, (10.0, 0.0, 0.0), (0.0, 10.0, 3.0), centre=(0.0, 0.0, 0.0), clockwise=False, feed=60.0)


def test_lengths():
    assert arc_angle(ARC) == pytest.approx(math.pi / 2)
    assert arc_angle(ARC._replace(clockwise=True, turns=2)) == pytest.approx(3.5 * math.pi)
    assert move_length(ARC) == pytest.approx(math.hypot(5 * math.pi, 3.0))
    assert move_length(Move("line", AT, (0.0, 0.0, 0.0), (3.0, 4.0, 0.0))) == 5.0


def test_times_and_extents():
    # 30 mm at 60 mm/min are 30 s; 2 s of dwell; the half circle bulges to X 10, the offset is taken off
    moves = [
        Move("rapid", AT, (-500.0, 0.0, 0.0), (0.0, -10.0, 0.0)),
        Move("arc", AT, (0.0, -10.0, 0.0), (0.0, 10.0, 0.0), centre=(0.0, 0.0, 0.0), clockwise=False, feed=math.pi * 60.0),
        Move("line", AT, (0.0, 10.0, 0.0), (0.0, 40.0, 0.0), feed=60.0), Move("dwell", AT, (0.0, 40.0, 0.0), (0.0, 40.0, 0.0), seconds=2.0),
    ]  # fmt: skip
    total = summary(moves, Setup(offsets={"G54": (0.0, 0.0, 100.0)}))
    assert total.cutting_time == pytest.approx(10.0 + 30.0)
    assert total.dwell_time == 2.0
    assert total.machine is not None and total.work is not None  # noqa: PT018
    for box, z in ((total.machine, 0.0), (total.work, -100.0)):  # the start of the first move is not known
        assert box[0] == pytest.approx((0.0, -10.0, z), abs=1e-12)
        assert box[1] == pytest.approx((10.0, 40.0, z), abs=1e-12)
    assert total.counts == {"rapid": 1, "arc": 1, "line": 1, "dwell": 1}
    assert dict(total.rows(Program("fanuc", tuple(moves))))["dwells"] == "2.0 s"
