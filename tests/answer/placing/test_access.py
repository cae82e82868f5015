"""Blocked moves: drawing back along the shaft and crossing there, past clamps on the table that the straight move never meets.

A face at x = 0 is touched with a stylus of 120 mm along +x, from the side. A boss of 20 mm stands between touches 2 and 3, so
that the tool draws back in -x until the tip is 20 mm + 20 mm clearance + 2 mm before the face: x = -42. The quill is a
square of 80 mm, 56.6 mm in its round, about the mount at tip - 120 mm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.answer.placing.reach import CONSTRAINTS, Feasibility
from vcmm.core.pose import Pose
from vcmm.files.own.scenario import load_scenario

HERE = np.zeros((1, 6))


POST = 'clamps.post = { centre = "-195 0 300 mm", size = "10 10 600 mm" }'


SCENARIO = """vcmm = "scenario/1"
[machine]
name = "m"
kind = "cmm"
structure = "w b Y X Z t"
axes.X = { travel = ["LOW mm", "2000 mm"] }
axes.Y = { travel = ["-2000 mm", "2000 mm"] }
axes.Z = { travel = ["-2000 mm", "2000 mm"] }
repeatability = { law = "normal", u = "1 um" }
[part.features]
face = { type = "plane", point = "0 0 25 mm", normal = [-1, 0, 0], size = "300 50 mm" }
boss = { type = "cylinder", point = "-20 0 25 mm", axis = [1, 0, 0], diameter = "30 mm", length = "20 mm" }
[[part.characteristics]]
name = "f"
type = "flatness"
of = "face"
zone = "0.1 mm"
[pose]
shift = "0 0 0 mm"
turn = "0 0 0 deg"
[plan]
touch = { speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }
styli.side = { offset = "120 0 0 mm", tip_diameter = "4 mm" }
[[plan.steps]]
feature = "face"
stylus = "side"
points = "points.csv"
[surroundings]
"""


def check(folder: Path, ys: tuple[float, ...], around: str = POST, low: float = -2000.0) -> Feasibility:
    rows = "".join(f"0,{y},25,-1,0,0\n" for y in ys)
    (folder / "points.csv").write_text("x_mm,y_mm,z_mm,nx,ny,nz\n" + rows, encoding="utf-8")
    text = SCENARIO.replace("LOW", f"{low:g}") + around + "\n"
    (folder / "side.toml").write_text(text, encoding="utf-8")
    return Feasibility.of(load_scenario(folder / "side.toml"))


def places(found: Feasibility) -> set[str]:
    return {p.point for p in found.problems(Pose.identity()) if p.constraint == "moves"}


def test_without_a_clamp_the_tool_draws_back_and_crosses(tmp_path):
    found = check(tmp_path, (-120.0, -30.0, 30.0, 120.0), "")
    direct = found.room(np.eye(3)).direct
    assert (direct > 0.0).tolist() == [False, True, False]  # the boss
    assert found.feasible(HERE)[0]


def test_a_post_behind_the_quill_blocks_drawing_back(tmp_path):
    """Only the part blocks the straight move, only the post blocks drawing back: both must be looked at together.

    Drawn back, the mount stands at x = -162 and y = -30: the quill reaches to x = -202 and y = +10, the post begins at -190.
    """
    found = check(tmp_path, (-120.0, -30.0, 30.0, 120.0))
    table = found.table_room(Pose.identity())
    assert table is not None
    assert table.room.direct.max() == 0.0
    assert not found.feasible(HERE)[0]
    assert places(found) == {"point 2 on face - point 3 on face"}
    assert found.amounts(HERE)[0, CONSTRAINTS.index("moves")] > 1.0


def test_the_crossing_is_looked_at_too(tmp_path):
    """At y = -100 and 100 the quill draws back beside the post (100 - 57 - 5 = 38 mm); crossing at x = -162 it meets it.

    With travel to spare the tool goes back beyond the post, to x = -200 - 22 of the tip (axis: -342), and crosses there.
    """
    assert check(tmp_path, (-140.0, -100.0, 100.0, 140.0)).feasible(HERE)[0]
    short = check(tmp_path, (-140.0, -100.0, 100.0, 140.0), low=-330.0)
    assert not short.feasible(HERE)[0]
    assert places(short) == {"point 2 on face - point 3 on face"}
    assert check(tmp_path, (-140.0, -100.0, 100.0, 140.0), low=-345.0).feasible(HERE)[0]


def test_drawing_back_for_a_blocked_move_needs_travel(tmp_path):
    """The axis must reach -162."""
    assert check(tmp_path, (-30.0, 30.0, 120.0), "", low=-163.0).feasible(HERE)[0]
    short = check(tmp_path, (-30.0, 30.0, 120.0), "", low=-160.0)
    assert not short.feasible(HERE)[0]
    assert short.amounts(HERE)[0, CONSTRAINTS.index("moves")] == pytest.approx(2.0)
