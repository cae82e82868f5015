"""Probing programs of four controls, read back by what reads programs."""

import re

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.program.interpret import interpret
from vcmm.program.probing_program import CONTROLS, PlannedTouch, ProbingJob, probing_texts
from vcmm.program.setup import Setup, Tool

WAYS = ((1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, -1))
TURNED = {"A": -30.0, "C": 60.0}
JOB = ProbingJob(tuple(PlannedTouch(2, (37.5, 20.0, -5.0), w, TURNED) for w in WAYS), 100.0, 10.0, 3.0)
SETUP = Setup(
    tools={20: Tool(20, length=150.0, diameter=6.0, shape="probe")},
    offsets={"G54": (1.0, 2.0, 3.0)},
    strict=False,
)


@pytest.mark.parametrize("control", CONTROLS)
def test_every_control_touches_where_it_should(control):
    text = next(iter(probing_texts(JOB, control).values()))
    read = interpret(text, control, SETUP, "touch")
    # G54 at 1 2 3. Along +X the middle of the ball of 3 mm stops at 37.5 - 3 = 34.5, machine 35.5; beside the surface its lowest
    # point is at -5 - 3 = -8, machine -5; from above it meets at -5, machine -2
    due = [(35.5, 22, -5), (41.5, 22, -5), (38.5, 19, -5), (38.5, 25, -5), (38.5, 22, -2)]
    assert [t.tip for t in read.touches] == [pytest.approx(d, abs=1e-9) for d in due]
    assert [t.along for t in read.touches] == [pytest.approx(w, abs=1e-9) for w in WAYS]
    assert read.touches[0].rotary == pytest.approx((np.radians(-30), 0, np.radians(60)))
    # nothing turns below the height where it may
    turns = [m for m in read.moves if m.rotary_start != m.rotary_end]
    assert turns
    assert all(m.start[2] == m.end[2] == 103.0 for m in turns)


def test_a_line_of_the_log_is_printed_with_the_measured_value():
    fanuc = probing_texts(JOB, "fanuc")["TOUCH.nc"]
    assert "DPRNT[TOUCH*F2*I1*J0*K0*X#135[44]*Y20.*Z-5.*A-30.*C60.]" in fanuc
    assert "G65 P9811 X37.5\n" in fanuc
    assert "Z#137[44]" in fanuc
    assert "X#185[44]" in probing_texts(JOB, "haas")["TOUCH.nc"]
    assert (
        '"TOUCH F2 I1 J0 K0 X"<<_OVR[4]<<" Y20. Z-5. A-30. C60."'
        in probing_texts(JOB, "sinumerik")["TOUCH.mpf"]
    )
    texts = probing_texts(JOB, "heidenhain")
    assert "FN 0: Q5 = +Q160" in texts["TOUCH.h"]
    assert '"TOUCH F%1.0F I%2.0F' in texts["TOUCH.a"]
    assert re.search(r"Q261=-5.0000", texts["TOUCH.h"])  # the middle of the ball, as HEIDENHAIN states it


def test_the_spindle_is_turned_and_printed():
    touches = tuple(PlannedTouch(1, (0.0, 0.0, 0.0), (1, 0, 0), TURNED, s) for s in (0.0, 180.0))
    job = ProbingJob(touches, 50.0, 10.0, 3.0)
    assert "M19 R180." in probing_texts(job, "fanuc")["TOUCH.nc"]
    assert "*S180.]" in probing_texts(job, "fanuc")["TOUCH.nc"]
    assert "M19 P180." in probing_texts(job, "haas")["TOUCH.nc"]
    assert "SPOS=180." in probing_texts(job, "sinumerik")["TOUCH.mpf"]
    assert "CYCL DEF 13.1 ANGLE 180" in probing_texts(job, "heidenhain")["TOUCH.h"]
    for control in CONTROLS:
        assert (
            len(interpret(next(iter(probing_texts(job, control).values())), control, SETUP, "t").touches) == 2
        )


def test_another_control_is_refused():
    with pytest.raises(UsageError, match='--control "okuma" is not written'):
        probing_texts(JOB, "okuma")
