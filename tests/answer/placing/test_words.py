"""A placement as text: units, shares, rows of tables, the region in words."""

from __future__ import annotations

from types import SimpleNamespace as Made

import numpy as np

from vcmm.answer.placing.words import (
    amount,
    changes,
    goal_text,
    pose_text,
    region_text,
)
from vcmm.show.tables.placement import compared_poses, why
from vcmm.show.tables.table import in_terminal
from vcmm.task.measuring.fixture import Goal

SIX = np.array([100.0, 20.5, -0.0001, 0.0, 0.0, np.pi / 2])


def result(name: str, u: float, budget: dict[str, float]):
    return Made(name=name, unit="mm", u=u, budget=[Made(input=k, u=v) for k, v in budget.items()])


def placed():
    at = lambda value: Made(pose=SIX, value=value)  # noqa: E731
    region = Made(
        convenient=SIX,
        convenient_value=1.6e-3,
        within=0.02,
        share=0.125,
        box={"x": (90.0, 110.0)},
        pose_count=150,
    )
    before, after = (
        result("gap", 5e-3, {"a": 4e-3, "b": 3e-3}),
        result("gap", 3.2e-3, {"a": 1e-3, "b": 3e-3}),
    )
    return Made(
        objective=Made(unit="mm", weights={"gap": 1.0}, goal=Goal()), confirmation=None, best=at(1.5e-3), present=at(2.0e-3), median=at(3e-3),
        worst=at(4e-3), region=region, before=Made(characteristics=[before]), after=Made(characteristics=[after]),
    )  # fmt: skip


def test_amounts_and_poses():
    assert amount(1.5e-3, placed()) == "1.5 µm"
    assert amount(0.25, Made(objective=Made(unit="1"))) == "0.25"
    assert pose_text(SIX) == "shift (100 20.5 0) mm, turn (0 0 90) deg"


def test_rows_of_the_poses():
    rows = in_terminal(compared_poses(placed())).rows
    assert [r[0] for r in rows] == [
        "found",
        "convenient",
        "present",
        "median of the scan",
        "worst of the scan",
    ]
    assert [r[-1] for r in rows] == ["-25.00%", "-20.00%", "+0.00%", "+50.00%", "+100.00%"]
    none = placed()
    none.present = None
    assert in_terminal(compared_poses(none)).rows[0][-1] == "–"


def test_why_rows_by_hand():
    """a: (1^2 - 4^2) / 5^2 = -60 %; b does not change."""
    assert in_terminal(why(placed())).rows == [
        ["gap", "a", "4 µm", "1 µm", "-60.0%"],
        ["", "b", "3 µm", "3 µm", "+0.0%"],
    ]
    assert in_terminal(why(placed(), most=1)).rows == [["gap", "a", "4 µm", "1 µm", "-60.0%"]]


def test_what_is_rounding_is_left_out():
    one = placed()
    one.after.characteristics[0].budget.append(Made(input="c", u=1e-7))
    assert [line[0] for line in changes(one)[0][2]] == ["a", "b"]


def test_the_region_and_the_goal_in_words():
    one = placed()
    whole = "12.5% of the poses of the fixture lie within 2% of the value found"
    assert region_text(one) == f"{whole}; all 150 poses tried in the box x 90 mm to 110 mm do"
    one.region.pose_count = 0
    assert region_text(one) == f"{whole}; no box around the pose found stays within it"
    one.region.box = {}
    assert region_text(one) == whole
    goal = Goal({"U/T": 0.75, "risk": 0.25}, {"a": 0.5, "b": 0.5, "c": 0.0})
    assert goal_text(goal) == "0.75 U/T + 0.25 risk over 0.5 a, 0.5 b"
