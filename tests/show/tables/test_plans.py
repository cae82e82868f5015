"""The curve of a plan: the present one first, the chosen one marked."""

from __future__ import annotations

import math
from types import SimpleNamespace

from vcmm.answer.placing.planning import PlanPoint
from vcmm.show.tables.plans import curve
from vcmm.show.tables.table import in_terminal, on_page


def test_curve():
    first = PlanPoint(90.0, 4, {"bore": 4}, {}, {"bore": 1e-3, "lean": 2e-6}, 1.0)
    second = PlanPoint(150.0, 8, {"bore": 8}, {}, {"bore": 5e-4, "lean": 1e-6}, 0.5)
    found = SimpleNamespace(present=first, choice=second, pareto=(second,), styli={"bore": "down"})
    kinds = (SimpleNamespace(name="bore", type="size"), SimpleNamespace(name="lean", type="angle"))
    scenario = SimpleNamespace(part=SimpleNamespace(characteristics=kinds))
    table = curve(scenario, found)
    assert in_terminal(table).heads == ["", "minutes", "points", "U bore", "U lean"]
    assert in_terminal(table).rows == [
        ["present", "1.50", "bore 4", "1.00 µm", "2.00 µrad"],
        ["chosen", "2.50", "bore 8", "0.50 µm", "1.00 µrad"],
    ]
    assert on_page(table).rows[1][3:] == ["0.500", "1.00 µrad"]
    assert table.caption == "styli: bore down"
    assert math.isclose(table.rows[0].plan.minutes, 1.5)
