"""Placements as tables, from outcomes made by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np

from vcmm.answer.placing.planning import PlanPoint
from vcmm.show.tables import placement
from vcmm.show.tables.table import in_terminal, on_page, records


def at(value, x=0.0, deviations=()):
    return SimpleNamespace(
        pose=np.array([x, 0.0, 0.0, 0.0, 0.0, np.pi / 2]), value=value, deviations=deviations
    )


def outcome(present):
    goal = SimpleNamespace(mixture={"U": 1}, weights={"bore": 1.0})
    return SimpleNamespace(
        confirmation=None, objective=SimpleNamespace(goal=goal, unit="mm"), best=at(0.8e-3, 10.5), present=present,
        median=at(1.1e-3), worst=at(2e-3), region=SimpleNamespace(convenient=np.zeros(6), convenient_value=0.81e-3),
    )  # fmt: skip


def test_poses_against_the_present_one():
    """0.8 against 1.0 µm: 20 % less; the worst doubles it."""
    table = placement.compared_poses(outcome(at(1e-3)))
    rows = in_terminal(table).rows
    assert [r[0] for r in rows] == [
        "found",
        "convenient",
        "present",
        "median of the scan",
        "worst of the scan",
    ]
    assert rows[0][1:] == ["10.5 0 0", "0 0 90", "0.8 µm", "-20.00%"]
    assert rows[-1][-1] == "+100.00%"
    assert on_page(table).heads == [
        "pose",
        "shift x y z / mm",
        "turn x y z / °",
        "objective",
        "against present",
    ]


def test_without_a_present_pose_there_is_nothing_to_compare():
    rows = in_terminal(placement.compared_poses(outcome(None))).rows
    assert [r[-1] for r in rows] == ["–"] * 4


def test_a_cut_part():
    c = SimpleNamespace(name="bore", type="size")
    decided = SimpleNamespace(decision=SimpleNamespace(p_conform=0.9))
    open_ = SimpleNamespace(decision=None)
    one = SimpleNamespace(
        best=at(0.25, 5.0, (1e-3,)), present=at(0.5, 0.0, (-2e-3,)), median=at(0.4), worst=at(1.0), characteristics=(c,),
        before=SimpleNamespace(characteristics=(open_,)), after=SimpleNamespace(characteristics=(decided,)),
    )  # fmt: skip
    poses = placement.compared_cut_poses(one)
    assert in_terminal(poses).rows[0] == ["found", "5 0 0", "0.25", "-50.0%"]
    assert on_page(poses).rows[0] == ["found", "5 0 0", "0.2500"]
    gains = placement.gains(one)
    assert in_terminal(gains).rows == [["bore", "-2.00 µm", "+1.00 µm", "–", "90.0 %"]]
    assert records(gains.columns, gains.rows) == [{"name": "bore", "p_present": None, "p_best": 0.9}]


def test_a_choice_of_machines():
    found = {
        m: {"name": m.upper(), "words": ["10.5 0 0", f"{v} µm"], "value": v}
        for m, v in (("c", None), ("b", 1.2e-3), ("a", 0.8e-3))
    }
    table = placement.ranking(["a", "b"], found)
    rows = in_terminal(table).rows
    assert [r[-1] for r in rows] == ["+0.0%", "+50.0%", "–"]
    assert rows[2][2] == "cannot take the part"
    assert records(table.columns, table.rows)[2] == {"machine": "c", "name": "C", "value": None}


def test_plans_over_time():
    first = PlanPoint(90.0, 4, {"bore": 4}, {}, {"bore": 1e-3, "lean": 2e-6}, 1.0)
    second = PlanPoint(150.0, 8, {"bore": 8}, {}, {"bore": 5e-4, "lean": 1e-6}, 0.5)
    found = SimpleNamespace(present=first, choice=second, pareto=(second,), styli={"bore": "down"})
    kinds = (SimpleNamespace(name="bore", type="size"), SimpleNamespace(name="lean", type="angle"))
    scenario = SimpleNamespace(part=SimpleNamespace(characteristics=kinds))
    table = placement.curve(scenario, found)
    assert in_terminal(table).heads == ["", "minutes", "points", "U bore", "U lean"]
    assert in_terminal(table).rows == [
        ["present", "1.50", "bore 4", "1.00 µm", "2.00 µrad"],
        ["chosen", "2.50", "bore 8", "0.50 µm", "1.00 µrad"],
    ]
    assert on_page(table).rows[1][3:] == ["0.500", "1.00 µrad"]
    assert table.caption == "styli: bore down"
    assert math.isclose(table.rows[0].plan.minutes, 1.5)
