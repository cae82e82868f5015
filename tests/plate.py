"""A complete scenario as text, and edits of it: what a person types, line by line."""

from __future__ import annotations

from pathlib import Path

PLATE = """\
vcmm = "scenario/1"
[machine]
name = "bridge CMM"
kind = "cmm"
structure = "w b Y X Z t"
[machine.axes.X]
travel = ["0 mm", "600 mm"]
[machine.axes.Y]
travel = ["0 mm", "500 mm"]
[machine.axes.Z]
travel = ["-400 mm", "0 mm"]
[machine.repeatability]
law = "t"
scale = "0.7 um"
dof = 6
[machine.environment]
scales = { expansion = "8.0 um/(m K)", u_expansion = "0.5 um/(m K)", compensated = true, u_sensor = "0.05 K" }
[[machine.effects]]
effect = "squareness"
pair = "C0Y"
angle = "3 urad"
[[machine.inputs]]
effect = "squareness"
pair = "C0Y"
parameter = "angle"
u = "1 urad"
redraw = "machine"
[part]
expansion = "11.5 um/(m K)"
u_expansion = "1 um/(m K)"
[part.features]
top   = { type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], size = "80 80 mm" }
front = { type = "plane", point = "0 -40 10 mm", normal = [0, -1, 0], size = "80 20 mm" }
bore  = { type = "cylinder", point = "0 0 0 mm", axis = [0, 0, 1], diameter = "30 mm", length = "20 mm", inside = true }
[[part.characteristics]]
name = "bore diameter"
type = "size"
of = "bore"
limits = ["0 mm", "0.021 mm"]
[[part.characteristics]]
name = "bore square to top"
type = "perpendicularity"
of = "bore"
datums = ["top"]
zone = "0.01 mm"
[[part.characteristics]]
name = "bore to front"
type = "distance"
between = ["front", "bore"]
[pose]
shift = "300 250 -300 mm"
turn = "0 0 30 deg"
[plan]
alignment = { plane = "top", line = "front", origin = "bore" }
touch = { speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }
styli.down = { offset = "0 0 -120 mm", tip_diameter = "4 mm" }
[[plan.steps]]
feature = "top"
stylus = "down"
points = { strategy = "grid", n = [3, 3], margin = "5 mm" }
[[plan.steps]]
feature = "bore"
stylus = "down"
points = { strategy = "levels", at = ["5 mm", "15 mm"], n = 8 }
[[plan.steps]]
feature = "front"
stylus = "down"
points = { strategy = "grid", n = [3, 2], margin = "4 mm" }
[environment]
temperature = { part = "21.2 degC", scale_x = "20.4 degC" }
u_temperature = { part = "0.1 K" }
[job]
trials = 20000
rule = "probability 95 %"
"""


def line_of(text: str, needle: str) -> int:
    """1-based number of the only line that holds a text."""
    found = [i for i, line in enumerate(text.splitlines(), 1) if needle in line]
    assert len(found) == 1, (needle, found)
    return found[0]


def edited(folder: Path, *edits: tuple[str, str], name: str = "plate.toml") -> Path:
    """The scenario with (old, new) replacements, each of a text that occurs once."""
    text = PLATE
    for old, new in edits:
        assert text.count(old) == 1, (old, text.count(old))
        text = text.replace(old, new)
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path
