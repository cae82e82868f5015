"""What must not matter moves no end: order of rows, units, names, the seed, the frame, the number of threads.

An end may move by 3 % of the length, or by three of the standard uncertainties that are printed for it (of both answers together). The
surfaces are made here: lobes and waves of 1 um, 0.4 um of scatter.
"""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from vcmm.face.cli import run

pytestmark = pytest.mark.thorough  # whole jobs, minutes of processor

MACHINE = """vcmm = "machine/1"
kind = "cmm"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[repeatability]
u = "0.4 um"
[[effects]]
effect = "squareness"
pair = "B0Z"
angle = "0 urad"
[[inputs]]
effect = "squareness"
pair = "B0Z"
parameter = "angle"
u = "4 urad"
"""
SHIFT = np.array([300.0, 250.0, -200.0])
PLANES = {  # point, normal, direction u, size
    "top": ((0, 0, 20), (0, 0, 1), (1, 0, 0), (80, 80)),
    "low": ((0, 0, 0), (0, 0, -1), (1, 0, 0), (80, 80)),
}
ASKED = {
    "diameter": 'type = "size"\nof = "bore"\nlimits = ["-0.006 mm", "0.006 mm"]',
    "height": 'type = "distance"\nbetween = ["top", "low"]\nlimits = ["-0.006 mm", "0.006 mm"]',
    "flat": 'type = "flatness"\nof = "top"\nzone = "0.006 mm"',
    "round": 'type = "roundness"\nof = "ring"\nzone = "0.006 mm"',
    "cylindrical": 'type = "cylindricity"\nof = "bore"\nzone = "0.006 mm"',
    "square": 'type = "perpendicularity"\nof = "bore"\ndatums = ["top"]\nzone = "0.006 mm"',
    "parallel": 'type = "parallelism"\nof = "top"\ndatums = ["low"]\nzone = "0.006 mm"',
}
QUARTER = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # 90 deg about z


def row(v: object) -> str:
    return " ".join(f"{x:g}" for x in np.ravel(np.asarray(v, dtype=float)))


def places() -> dict[str, np.ndarray]:
    """Points (n, 3) of one part, as touched."""
    rng, out = np.random.default_rng(3), {}
    for name, (point, normal, _, _) in PLANES.items():
        a, b = (v.ravel() for v in np.meshgrid(np.linspace(-35, 35, 6), np.linspace(-35, 35, 6)))
        height = 1e-3 * np.cos(np.pi * (a + 40) / 40) + 0.4e-3 * rng.normal(size=len(a))
        out[name] = np.stack([a, b, 0 * a + point[2] + height * normal[2]], 1)
    for name, heights, count in (("ring", [10.0], 36), ("bore", [3.0, 10.0, 17.0], 16)):
        t, z = (v.ravel() for v in np.meshgrid(2 * np.pi * np.arange(count) / count, heights))
        r = 15.0 + 1e-3 * np.cos(3 * t + 0.4) + 0.4e-3 * rng.normal(size=len(t))
        out[name] = np.stack([r * np.cos(t), r * np.sin(t), z], 1)
    return out


def write(folder: Path, *, turn: bool = False, names: dict[str, str] | None = None) -> dict[str, np.ndarray]:
    """machine.toml and scenario.toml; the drawing turned by 90 deg, and the part on the table by as much the other way round."""
    called, way = names or {}, QUARTER if turn else np.eye(3)
    features = [
        f'{called.get(n, n)} = {{ type = "plane", point = "{row(way @ np.array(p))} mm", normal = [{row(way @ np.array(d)).replace(" ", ", ")}], '
        f'u = [{row(way @ np.array(u)).replace(" ", ", ")}], size = "{row(s)} mm" }}'
        for n, (p, d, u, s) in PLANES.items()
    ]
    round_ = 'point = "{} mm", axis = [0, 0, 1], diameter = "30 mm", inside = true'
    features += [
        f'{called.get("ring", "ring")} = {{ type = "circle", {round_.format("0 0 10")} }}',
        f'{called.get("bore", "bore")} = {{ type = "cylinder", {round_.format("0 0 0")}, length = "20 mm" }}',
    ]
    asked = []
    for name, keys in ASKED.items():
        for old, new in called.items():
            keys = keys.replace(f'"{old}"', f'"{new}"')
        asked += ["[[part.characteristics]]", f'name = "{name}"', keys]
    points = {
        "top": '{ strategy = "grid", n = [6, 6], margin = "5 mm" }', "low": '{ strategy = "grid", n = [6, 6], margin = "5 mm" }',
        "ring": '{ strategy = "even", n = 36 }', "bore": '{ strategy = "levels", at = ["3 mm", "10 mm", "17 mm"], n = 16 }',
    }  # fmt: skip
    steps = [
        f'[[plan.steps]]\nfeature = "{called.get(n, n)}"\nstylus = "down"\npoints = {text}'
        for n, text in points.items()
    ]
    text = ['vcmm = "scenario/1"', 'machine = "machine.toml"', "[part.features]", *features, *asked, "[pose]"]
    text += [f'shift = "{row(SHIFT)} mm"', 'turn = "0 0 -90 deg"' if turn else ""]
    text += ["[plan]", 'styli.down = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }', *steps]
    text += ["[job]", "trials = 8000"]
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "scenario.toml").write_text("\n".join(text))
    return {called.get(n, n): p @ way.T for n, p in places().items()}


def write_points(
    folder: Path, points: dict[str, np.ndarray], unit: str = "mm", shuffle: bool = False
) -> None:
    scale, rows = {"mm": 1.0, "um": 1000.0, "in": 1 / 25.4}[unit], []
    for name, found in points.items():
        rows += [f"{name}," + ",".join(f"{v:.12g}" for v in p) for p in found * scale]
    if shuffle:
        rows = [rows[i] for i in np.random.default_rng(8).permutation(len(rows))]
    (folder / "points.csv").write_text("\n".join([f"feature,x_{unit},y_{unit},z_{unit}", *rows]))


def ends(document: dict) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    out = {}
    for c in document["characteristics"]:
        true = c["true_value"]
        u = [0.0 if v is None else v for v in true.get("interval_u_mm") or (0.0, 0.0)]
        out[c["name"]] = np.array(true["interval_mm"], dtype=float), np.array(u, dtype=float)
    return out


def ask(folder: Path, capsys: pytest.CaptureFixture[str], *words: str) -> dict:
    code = run(
        ["evaluate", str(folder / "scenario.toml"), "--points", str(folder / "points.csv"), "--json", *words]
    )
    out, err = capsys.readouterr()
    assert code in (0, 1), err
    return ends(json.loads(out))


def moved(first: dict, second: dict) -> list[str]:
    """Ends that moved by more than 3 % of the length and than three of their u, in words."""
    assert first.keys() == second.keys()
    out = []
    for name, (low_high, u) in first.items():
        other, u_other = second[name]
        allowed = np.maximum(0.03 * np.ptp(low_high), 3.0 * np.hypot(u, u_other))
        for end, by, most in zip(("lower", "upper"), np.abs(other - low_high), allowed):
            if not by <= most + 1e-12:
                out.append(f"{end} end of {name}: by {1e3 * by:.3f} um, {1e3 * most:.3f} um allowed")
    return out


@pytest.fixture(scope="module")
def base(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """As a process of its own with one thread, which the others are compared with."""
    folder = tmp_path_factory.mktemp("base")
    write_points(folder, write(folder))
    return ask_with_threads(folder, 1)


def ask_with_threads(folder: Path, threads: int) -> dict:
    names = "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "MKL_NUM_THREADS"
    words = [sys.executable, "-m", "vcmm", "evaluate", "scenario.toml", "--points", "points.csv", "--json"]
    done = subprocess.run(
        words,
        cwd=folder,
        env={**os.environ, **dict.fromkeys(names, str(threads))},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode in (0, 1), done.stderr
    return ends(json.loads(done.stdout))


def test_what_is_compared_has_lengths(base: dict) -> None:
    """Every end is finite, and something is drawn for each but sizes, whose ends are exact."""
    assert list(base) == list(ASKED)
    assert all(np.isfinite(e).all() and np.ptp(e) > 1e-5 for e, _ in base.values())
    assert moved(base, {n: (e + 0.2 * np.ptp(e), u) for n, (e, u) in base.items()}) != []
    assert not math.isnan(sum(float(u.sum()) for _, u in base.values()))


def test_order_of_the_rows(base: dict, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_points(tmp_path, write(tmp_path), shuffle=True)
    assert moved(base, ask(tmp_path, capsys)) == []


@pytest.mark.parametrize("unit", ["um", "in"])
def test_units(base: dict, unit: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_points(tmp_path, write(tmp_path), unit=unit)
    assert moved(base, ask(tmp_path, capsys)) == []


def test_names(base: dict, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    called = {"top": "zenith", "low": "a", "ring": "k9", "bore": "hole_1"}
    write_points(tmp_path, write(tmp_path, names=called))
    assert moved(base, ask(tmp_path, capsys)) == []


def test_seed(base: dict, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write_points(tmp_path, write(tmp_path))
    assert moved(base, ask(tmp_path, capsys, "--seed", "77")) == []


def test_frame_of_the_points(base: dict, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    points = write(tmp_path)
    write_points(tmp_path, {n: p + SHIFT for n, p in points.items()})
    assert moved(base, ask(tmp_path, capsys, "--frame", "machine")) == []


def test_frame_of_the_drawing(base: dict, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Turned by 90 deg, and laid down turned by as much the other way: the machine stands where it stood."""
    write_points(tmp_path, write(tmp_path, turn=True))
    assert moved(base, ask(tmp_path, capsys)) == []


def test_threads(base: dict, tmp_path: Path) -> None:
    write_points(tmp_path, write(tmp_path))
    assert moved(base, ask_with_threads(tmp_path, 2)) == []
