"""A scenario around a part of another system: a machine with a certificate to fill in, a pose, styli, a plan.

Everything that the other file does not state is a default that its comment names; `vcmm check` passes on the result.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from vcmm.core.run import Array
from vcmm.core.text import csv_of
from vcmm.files.foreign.drawing import DrawnPart, comment, mm, toml_value

TRAVELS = (600.0, 500.0, 400.0)  # mm, of the placeholder machine, until its own file replaces it
TRAVEL_MARGIN_MM = 200.0  # mm that travels keep beyond the part: styli, clearance
REACH = 120.0  # mm, length of the styli
STEEP = 0.3  # vertical share of an axis from which on a straight stylus enters a bore from above (73 deg)
TIPS = (4.0, 2.0, 1.0, 0.5)  # mm, usual tip diameters


def scenario_toml(drawn: DrawnPart, machine: str | None = None, centre: Sequence[float] | None = None) -> str:
    """Return the text of a scenario/1 file. machine: name of a machine file; centre: mm, of its volume, where the part is put."""
    low, high = _box(drawn.features)
    travels = [max(t, float(h - b) + TRAVEL_MARGIN_MM) for t, b, h in zip(TRAVELS, low, high)]
    middle = (
        np.array([travels[0] / 2, travels[1] / 2, -travels[2] / 2]) if centre is None else np.asarray(centre)
    )
    lines = [
        f"# {comment(drawn.name)}, from {comment(drawn.source)}: what that file does not say is a default; correct it"
    ]
    lines += [f"# {comment(note)}" for note in drawn.notes]
    lines += ['vcmm = "scenario/1"', f"name = {toml_value(drawn.name)}", ""]
    lines += [f"machine = {toml_value(machine or 'machine.toml')}"]
    lines += ['part = "part.toml"', "", "[pose]                                    # where the part lies"]
    lines += [f"shift = {toml_value(mm(*np.round(middle - 0.5 * (low + high), 3)))}", ""]
    lines += _plan(drawn)
    lines += ["", "[environment]", 'room = "20 degC"', 'half_width = "1.5 K"', ""]
    return "\n".join([*lines, "[job]", "trials = 20000", "seed = 1"]) + "\n"


def machine_toml(drawn: DrawnPart) -> str:
    """Return a machine that is known by its certificate only, with travels that hold the part."""
    low, high = _box(drawn.features)
    x, y, z = (max(t, float(h - b) + TRAVEL_MARGIN_MM) for t, b, h in zip(TRAVELS, low, high))
    return f"""# a placeholder: write the values of the certificate of your machine
vcmm = "machine/1"
name = "stand-in, certificate of ISO 10360-2"
kind = "cmm"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", {toml_value(mm(x))}]
[axes.Y]
travel = ["0 mm", {toml_value(mm(y))}]
[axes.Z]
travel = [{toml_value(mm(-z))}, "0 mm"]
[certificate]
E0_MPE = "1.8 um + L/350"
P_Form_Sph_1x25 = "1.8 um"
prior = "limit"
[environment]
scales = {{ expansion = "8.0 um/(m K)", u_expansion = "0.5 um/(m K)", compensated = true, u_sensor = "0.05 K" }}
"""


def target_file(feature: str) -> str:
    """Name of the file with the touches of a feature."""
    return "points_" + "".join(c if c.isalnum() or c in "-_" else "_" for c in feature) + ".csv"


def target_csv(targets: Array) -> str:
    """Return the touches (n, 6) as a point list of a plan: x_mm, y_mm, z_mm, nx, ny, nz."""
    rows = [[f"{v:.12g}" for v in row] for row in targets]
    return csv_of([["x_mm", "y_mm", "z_mm", "nx", "ny", "nz"], *rows])


def _plan(drawn: DrawnPart) -> list[str]:
    """Return styli and steps: every feature that a characteristic needs, as often as its kind requires."""
    used = _used_features(drawn)
    steps = [_step(name, drawn.features[name], drawn.tip_radius) for name in used]
    for step in steps:
        if step["feature"] in drawn.targets:
            step["points"] = target_file(step["feature"])
    styli = dict.fromkeys((s["stylus"], s["tip"]) for s in steps)
    out = ["[plan]", 'touch = { speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }']
    for stylus, tip in styli:
        out += [f"[plan.styli.{stylus}]", f"offset = {toml_value(mm(*_offset(stylus)))}", f"tip_diameter = {toml_value(mm(tip))}"]  # fmt: skip
    for step in steps:
        out += ["[[plan.steps]]", f"feature = {toml_value(step['feature'])}", f'stylus = "{step["stylus"]}"']
        out += [f"points = {toml_value(step['points'])}"]
    return out


def features_of(characteristic: Mapping[str, Any]) -> list[str]:
    """Return the names of the features that a characteristic needs, datums last."""
    out: list[str] = []
    for key in ("of", "between", "datums"):
        value = characteristic.get(key, [])
        for name in [value] if isinstance(value, str) else value:
            out += [name] if isinstance(name, str) else name
    return out


def _used_features(drawn: DrawnPart) -> list[str]:
    """Return the features of the characteristics in the order of the drawing."""
    named = {n for c in drawn.characteristics for n in features_of(c)}
    return [n for n in drawn.features if n in named]


def _step(name: str, table: Mapping[str, Any], tip_radius: float | None) -> dict[str, Any]:
    kind, axis = table["type"], np.array(table.get("axis", table.get("normal", (0.0, 0.0, 1.0))), float)
    bore = bool(table.get("inside")) and kind != "sphere"
    sideways = bore and abs(axis[2]) < STEEP
    tip = next((t for t in TIPS if not bore or t <= 0.5 * _number(table["diameter"])), TIPS[-1])
    tip = tip if tip_radius is None else 2.0 * tip_radius
    way = "down" if not sideways else _side(axis)
    stylus = way if tip == TIPS[0] or tip_radius is not None else f"{way}_{tip:g}".replace(".", "_")
    return {"feature": name, "stylus": stylus, "tip": tip, "points": _points(kind, table)}


def _points(kind: str, table: Mapping[str, Any]) -> dict[str, Any]:
    """Return twice the points that define the element and more: those of ISO 10360-5 on a sphere, 8 on a circle."""
    if kind == "plane":
        side = min(_number(part) for part in table["size"].removesuffix(" mm").split())
        return {"strategy": "grid", "n": [3, 3], "margin": mm(0.1 * side)}
    if kind == "line":
        return {"strategy": "even", "n": 5, "margin": mm(0.1 * _number(table["length"]))}
    if kind == "circle":
        return {"strategy": "even", "n": 8}
    if kind == "sphere":
        return {"strategy": "iso10360"}
    if kind in ("cylinder", "cone"):
        length = _number(table["length"])
        return {"strategy": "levels", "at": [mm(0.2 * length), mm(0.8 * length)], "n": 8}
    return {"strategy": "grid", "n": [4, 4]} if kind == "torus" else {"strategy": "even", "n": 1}


def _side(axis: Array) -> str:
    """Name of the stylus that points along the axis of a lying bore."""
    i = int(np.argmax(np.abs(axis[:2])))
    return f"{'plus' if axis[i] > 0 else 'minus'}_{'xy'[i]}"


def _offset(stylus: str) -> tuple[float, float, float]:
    if stylus.startswith("down"):
        return (0.0, 0.0, -REACH)
    sign = 1.0 if stylus.startswith("plus") else -1.0
    return (sign * REACH / 2, 0.0, -REACH) if "_x" in stylus else (0.0, sign * REACH / 2, -REACH)


def _box(features: Mapping[str, Mapping[str, Any]]) -> tuple[Array, Array]:
    """Return the corners of the box around the places of all features, grown by half their largest size."""
    places, sizes = [], []
    for table in features.values():
        places.append([_number(v) for v in table["point"].removesuffix(" mm").split()])
        own_sizes = [table[k] for k in ("size", "length", "diameter") if k in table]
        sizes.append(
            max((_number(v) for text in own_sizes for v in text.removesuffix(" mm").split()), default=0.0)
        )
    p, s = np.array(places), np.array(sizes)[:, None]
    return (p - s / 2).min(axis=0), (p + s / 2).max(axis=0)


def _number(text: str) -> float:
    return float(text.removesuffix(" mm"))
