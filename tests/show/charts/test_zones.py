"""Zones of a decision."""

from __future__ import annotations

import math

import pytest

from vcmm.core.errors import UsageError
from vcmm.show.charts import ChartSheet, zones
from vcmm.show.charts.zones import zone_list, zone_of

NAN = math.nan


def test_zone_list():
    found = zone_list(10.0, 20.0, 1.0)
    assert [(z.low, z.high, z.kind) for z in found] == [
        (-math.inf, 9.0, "bad"),
        (9.0, 11.0, "warning"),
        (11.0, 19.0, "good"),
        (19.0, 21.0, "warning"),
        (21.0, math.inf, "bad"),
    ]
    assert zone_of(11.0, found).kind == "good"
    assert zone_of(20.5, found).kind == "warning"
    assert [z.kind for z in zone_list(None, 5.0, 1.0)] == ["good", "warning", "bad"]
    assert [z.kind for z in zone_list(0.0, 1.0, 0.6)] == ["bad", "warning", "warning", "bad"]


def test_zones_limits_and_result_are_drawn_at_their_place():
    ax = zones(10.0, 20.0, 12.5, 1.0, 1.0, unit="mm", title="t", ax=ChartSheet())
    # what is shown reaches from 9 to 21, and 14 % of 12 beyond on both sides
    assert ax.get_xlim() == pytest.approx((7.32, 22.68))
    assert [p.get_x() for p in ax.patches] == pytest.approx([7.32, 9.0, 11.0, 19.0, 21.0])
    assert ax.patches[-1].get_x() + ax.patches[-1].get_width() == pytest.approx(22.68)
    dotted = [line.get_xdata()[0] for line in ax.get_lines() if line.get_linestyle() == ":"]
    assert dotted == [9.0, 11.0, 19.0, 21.0]
    assert [t.get_text() for t in ax.get_xticklabels()] == ["10", "20"]
    ((bar,),) = [c.get_segments() for c in ax.collections]
    assert bar[:, 0].tolist() == pytest.approx([11.5, 13.5])
    assert [t.get_text() for t in ax.texts] == ["12.5 ± 1.0 mm"]
    assert ax.get_title(loc="left") == "t\nThe result lies in the conformance zone."


def test_a_decision_that_the_zone_does_not_show_is_said():
    """A known bias that is not corrected: in the conformance zone, and undecided."""
    ax = zones(10.0, 20.0, 12.5, 1.0, 1.0, unit="mm", title="t", decision="undecided", ax=ChartSheet())
    assert ax.get_title(loc="left") == "t\nDecision: undecided. The result lies in the conformance zone."


def test_no_result_is_said_and_wrong_limits_are_refused():
    said = zones(None, 1.0, NAN, 0.1, 0.1, unit="mm", title="t", ax=ChartSheet()).get_title(loc="left")
    assert said.endswith("The result is not available.")
    for lower, upper, guard in ((None, None, 0.1), (2.0, 1.0, 0.1), (0.0, 1.0, -1.0), (0.0, 1.0, NAN)):
        with pytest.raises(UsageError):
            zones(lower, upper, 0.5, 0.1, guard, unit="mm", title="t", ax=ChartSheet())


@pytest.mark.parametrize(
    ("span", "where"),
    [((7.4, 15.7), "within the limits"), ((15.0, 21.0), "on both sides of a limit"), ((20.5, 24.0), "beyond the limit")],
)  # fmt: skip
def test_the_interval_of_the_true_value_is_drawn_where_it_lies(span, where):
    """Indicated 13.5 with U = 4.2 would be drawn from 9.3 to 17.7; the true value lies from 7.4 to 15.7."""
    ax = zones(None, 20.0, 13.5, 4.2, 0.0, unit="um", title="t", decision="x", span=span, ax=ChartSheet())
    assert ax.get_title(loc="left") == f"t\nDecision: x. The interval of the true value lies {where}."
    (bar,) = next(c for c in ax.collections if len(c.get_segments()) == 1).get_segments()
    assert bar[:, 0].tolist() == pytest.approx(list(span))
    assert [t.get_text() for t in ax.texts] == [f"true value {span[0]:.3g} to {span[1]:.3g} um"]
    assert [line.get_xdata()[0] for line in ax.get_lines() if line.get_marker() == "D"] == [13.5]
