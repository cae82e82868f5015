"""What the drives and the control can do, and what was assumed of them."""

from __future__ import annotations

import pytest

from tests.programs import mill
from vcmm.core.errors import UsageError
from vcmm.program.limits import axis_limits, control_from


def test_limits_state_what_was_assumed():
    limits = axis_limits(mill(gain=50.0))
    assert limits.lag[:3] == pytest.approx([0.02] * 3)
    assert limits.feed_forward[:3] == pytest.approx([0.0] * 3)
    said = " / ".join(limits.assumptions)
    assert (
        "axis C: speed 2.1 rad/s, acceleration 10 rad/s^2, jerk 200 rad/s^3 (typical of kind machine-tool"
        in said
    )
    assert "axis X: no feed_forward stated" in said
    assert "axis C: no gain stated" in said


def test_control_table():
    control = control_from({"tolerance": "25 um", "tool_change": "3 s", "rapid_stop": False})
    assert (control.tolerance, control.tool_change, control.rapid_stop) == (0.025, 3.0, False)
    with pytest.raises(UsageError, match="has no unit"):
        control_from({"tolerance": 0.01})
    with pytest.raises(UsageError, match='Did you mean "tolerance"'):
        control_from({"tolerence": "10 um"})
