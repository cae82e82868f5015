"""A worse certificate never gives a shorter interval or a better decision, whatever is asked of the part.

Readings are made here: surfaces with waves of their own, scatter and a lobed tip, by arithmetic that shares nothing with vcmm. The
same readings are evaluated under a certificate and under worse ones. An end may move by three of its own printed standard
uncertainties, or by 3 % of the length, whichever is more.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

from vcmm.face.cli import run

LIMITS = {"E0": 1.9, "R0": 1.5, "P_Form": 1.8, "P_Size": 0.9}  # um
CERTIFICATE = """vcmm = "machine/1"
kind = "cmm"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[certificate]
E0_MPE = "{E0} um + L/{K}"
R0_MPL = "{R0} um"
P_Form_Sph_1x25 = "{P_Form} um"
P_Size_Sph_1x25 = "{P_Size} um"
"""
PART = """vcmm = "scenario/1"
machine = "machine.toml"
[pose]
shift = "300 250 -200 mm"
[plan]
styli.down = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
[part.features]
"""
FEATURES = {
    "top": 'type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], u = [1, 0, 0], size = "80 80 mm"',
    "low": 'type = "plane", point = "0 0 0 mm", normal = [0, 0, -1], u = [1, 0, 0], size = "80 80 mm"',
    "side": 'type = "plane", point = "40 0 10 mm", normal = [1, 0, 0], u = [0, 1, 0], size = "80 20 mm"',
    "edge": 'type = "line", point = "-40 0 20 mm", direction = [1, 0, 0], normal = [0, 0, 1], length = "80 mm"',
    "arc": 'type = "circle", point = "0 0 10 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true',
    "ring": 'type = "circle", point = "0 0 10 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true',
    "bore": 'type = "cylinder", point = "0 0 0 mm", axis = [0, 0, 1], diameter = "30 mm", length = "20 mm", inside = true',
    "collar": 'type = "cylinder", point = "0 0 20 mm", axis = [0, 0, 1], diameter = "50 mm", length = "20 mm"',
}
PLACES = 'strategy = "{}", {}'
STEPS = {
    "top": PLACES.format("grid", "n = [5, 5]"),
    "low": PLACES.format("grid", "n = [5, 5]"),
    "side": PLACES.format("grid", "n = [5, 5]"),
    "edge": PLACES.format("even", "n = 15"),
    "arc": PLACES.format("even", 'n = 30, start = "0 deg", sweep = "120 deg"'),
    "ring": PLACES.format("even", "n = 24"),
    "bore": PLACES.format("levels", 'at = ["3 mm", "10 mm", "17 mm"], n = 16'),
    "collar": PLACES.format("levels", 'at = ["3 mm", "10 mm", "17 mm"], n = 16'),
}
LENGTH = 'limits = ["-0.006 mm", "0.006 mm"]'
ASKED = {  # name: keys, and the features that it needs
    "size on an arc": (f'type = "size"\nof = "arc"\n{LENGTH}', "arc"),
    "size": (f'type = "size"\nof = "ring"\n{LENGTH}', "ring"),
    "size GX": (f'type = "size"\ncriterion = "GX"\nof = "ring"\n{LENGTH}', "ring"),
    "distance": (f'type = "distance"\nbetween = ["top", "low"]\n{LENGTH}', "top low"),
    "angle": ('type = "angle"\nbetween = ["top", "side"]\nlimits = ["-0.01 deg", "0.01 deg"]', "top side"),
    "straightness": ('type = "straightness"\nof = "edge"', "edge"),
    "flatness": ('type = "flatness"\nof = "top"', "top"),
    "roundness": ('type = "roundness"\nof = "ring"', "ring"),
    "cylindricity": ('type = "cylindricity"\nof = "bore"', "bore"),
    "parallelism": ('type = "parallelism"\nof = "top"\ndatums = ["low"]', "top low"),
    "perpendicularity": ('type = "perpendicularity"\nof = "bore"\ndatums = ["top"]', "bore top"),
    "position": ('type = "position"\nof = "bore"\ndatums = ["top", "side"]', "bore top side"),
    "coaxiality": ('type = "coaxiality"\nof = "collar"\ndatums = ["bore"]', "collar bore"),
    "circular run-out": ('type = "circular_runout"\nof = "ring"\ndatums = ["bore"]', "ring bore"),
    "total run-out": ('type = "total_runout"\nof = "collar"\ndatums = ["bore"]', "collar bore"),
    "surface profile": ('type = "surface_profile"\nof = "top"\ndatums = ["low"]', "top low"),
    "line profile": ('type = "line_profile"\nof = "edge"\ndatums = ["low"]', "edge low"),
}
SCATTER, TIP, WAVE = 0.5e-3, 0.4e-3, 0.4e-3  # mm: of a touch; three lobes of the tip; form of the surfaces


def round_places(name: str) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Angles, heights, radius, and the side of the material (1: outside the surface)."""
    if name == "arc":
        return np.radians(np.linspace(0, 120, 30)), np.full(30, 10.0), 15.0, 1.0
    if name == "ring":
        return 2 * np.pi * np.arange(24) / 24, np.full(24, 10.0), 15.0, 1.0
    angle, height = np.meshgrid(2 * np.pi * np.arange(16) / 16, [3.0, 10.0, 17.0])
    return angle.ravel(), height.ravel() + (20.0 if name == "collar" else 0.0), 25.0 if name == "collar" else 15.0, -1.0 if name == "collar" else 1.0  # fmt: skip


def points_of(name: str, rng: np.random.Generator) -> np.ndarray:
    """(n, 3): the surface with its waves, touched with scatter and a tip of three lobes."""
    if name in ("arc", "ring", "bore", "collar"):
        t, z, radius, _ = round_places(name)
        phases = rng.uniform(0, 2 * np.pi, 4)
        height = WAVE * sum(rng.normal() * np.cos(m * t + f) for m, f in zip((2, 3, 4, 5), phases))
        r = radius + height + TIP * np.cos(3 * t) + SCATTER * rng.normal(size=len(t))
        return np.stack([r * np.cos(t), r * np.sin(t), z], 1)
    if name == "edge":
        a, b = np.linspace(-40, 40, 15), np.zeros(15)
    else:
        a, b = (v.ravel() for v in np.meshgrid(np.linspace(-38, 38, 5), np.linspace(-38, 38, 5)))
    height = WAVE * (
        rng.normal() * np.cos(np.pi * (a + 40) / 40) + rng.normal() * np.cos(np.pi * (b + 40) / 40)
    )
    height = height + SCATTER * rng.normal(size=len(a))
    if name == "side":
        return np.stack([40.0 + height, a, 10.0 + b / 4], 1)
    if name == "edge":
        return np.stack([a, b, 20.0 + height], 1)
    return np.stack([a, b, (20.0 if name == "top" else 0.0) + (height if name == "top" else -height)], 1)


def write_case(folder: Path, names: Sequence[str], seeds: Sequence[int], trials: int) -> None:
    """scenario.toml of some characteristics, and points.csv of as many parts as seeds."""
    needed = dict.fromkeys(f for name in names for f in ASKED[name][1].split())
    lines = [f"{f} = {{ {FEATURES[f]} }}" for f in needed]
    for name in names:
        keys = ASKED[name][0]
        zone = "" if "limits" in keys else '\nzone = "0.006 mm"'
        lines += ["[[part.characteristics]]", f'name = "{name}"', keys + zone]
    for f in needed:
        lines += ["[[plan.steps]]", f'feature = "{f}"', 'stylus = "down"', f"points = {{ {STEPS[f]} }}"]
    job = ["[job]", f"trials = {trials}", 'known_bias = "corrected"']
    (folder / "scenario.toml").write_text(PART + "\n".join([*lines, *job]), encoding="utf-8")
    rows = ["part,feature,x_mm,y_mm,z_mm"]
    for seed in seeds:
        rng = np.random.default_rng(seed)
        for f in needed:
            rows += [f"p{seed},{f}," + ",".join(f"{v:.7f}" for v in p) for p in points_of(f, rng)]
    (folder / "points.csv").write_text("\n".join(rows), encoding="utf-8")


def answers(folder: Path, capsys: pytest.CaptureFixture[str], **limits: float) -> list[dict[str, dict]]:
    """Per part, by characteristic: what is said of it under these limits, um."""
    values = {**LIMITS, **limits}
    text = CERTIFICATE.format(**values, K=570.0 / values["E0"])
    (folder / "machine.toml").write_text(text, encoding="utf-8")
    words = ["evaluate", str(folder / "scenario.toml"), "--points", str(folder / "points.csv")]
    code = run([*words, "--seed", "5", "--json"])
    out, err = capsys.readouterr()
    assert code in (0, 1), err
    document = json.loads(out)
    return [{c["name"]: c for c in p["characteristics"]} for p in document.get("parts", [document])]


def interval(c: dict) -> tuple[float, float]:
    low, high = (c.get("true_value") or c)["interval_mm" if "interval_mm" in c else "interval_rad"]
    return -math.inf if low is None else low, math.inf if high is None else high


def breach(first: dict, second: dict) -> str:
    """What the answer under a worse limit has that it may not have; empty where it is no better."""
    a, b = (e[1] - e[0] for e in (interval(first), interval(second)))
    own = [
        u or 0.0
        for c in (first, second)
        for u in ((c.get("true_value") or {}).get("interval_u_mm") or [0.0, 0.0])
    ]
    if b < a - max(0.03 * a, 3.0 * float(np.linalg.norm(own))):
        return f"{first['name']}: {b * 1e3:.3f} um, {a * 1e3:.3f} um under the better limit"
    better = {"undecided": ("undecided",)}.get(first["decision"], (first["decision"], "undecided"))
    return (
        ""
        if second["decision"] in better
        else f"{first['name']}: {second['decision']}, {first['decision']} before"
    )


def breaches(
    folder: Path, ask: Callable[..., list[dict[str, dict]]], times: Sequence[tuple[str, float]]
) -> list[str]:
    first, out = ask(), []
    for limit, factor in times:
        second = ask(**{limit: factor * LIMITS[limit]})
        for number, (before, after) in enumerate(zip(first, second)):
            said = [breach(before[name], after[name]) for name in before]
            out += [f"part {number}, {limit} x {factor:g}: {w}" for w in said if w]
    return out


@pytest.mark.thorough
def test_forms_under_a_worse_repeatability(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What residuals show is form or scatter: a larger R0 must not turn form into scatter and so shorten the interval, nor excuse a
    point that contradicts the others. (Parts on which it did: 1.6 to 21 um of 30 to 52 um shorter, and one point.)
    """
    write_case(tmp_path, ["size on an arc"], (6, 15, 20, 24, 29, 37), 2000)
    found = breaches(tmp_path, lambda **k: answers(tmp_path, capsys, **k), [("R0", 2.0)])
    assert not found


@pytest.mark.count
@pytest.mark.parametrize("name", ASKED)
def test_every_characteristic_under_every_worse_limit(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_case(tmp_path, [name], range(8), 12_000)
    times = [(limit, factor) for limit in LIMITS for factor in (1.4, 2.0, 5.0)]
    assert not breaches(tmp_path, lambda **k: answers(tmp_path, capsys, **k), times)
