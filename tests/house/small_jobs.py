"""Files of one small machine and the commands on them, for a catalogue of effects that was changed.

python -m tests.house.small_jobs          runs all of them once without each file of physics/catalogue/
"""

from __future__ import annotations

import contextlib
import importlib
import io
import json
import sys
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from tests.house.other_effects import LIBRARIES, apart_from_effects, each_without, files, without
from tests.shop.machining import shop

AXES = """\
structure = "w X' Y' b Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-500 mm", "0 mm"]
"""
KNOWN = '[[effects]]\neffect = "{0}"\n{1} = "{2}"\n{3} = "{4}"\n[[inputs]]\neffect = "{0}"\n{1} = "{2}"\nparameter = "{3}"\nu = "{5}"\n'
SQUARENESS = KNOWN.format("squareness", "pair", "C0Y", "angle", "20 urad", "2 urad")
MEASURING = """\
vcmm = "scenario/1"
machine = "mill.toml"
[part.features]
ring = { type = "circle", point = "0 0 0 mm", axis = [0, 0, 1], diameter = "100 mm", inside = true }
[[part.characteristics]]
name = "diameter"
type = "size"
of = "ring"
limits = ["-0.1 mm", "0.1 mm"]
[pose]
shift = "300 250 -300 mm"
[plan]
styli.down = { offset = "0 0 -100 mm", tip_diameter = "4 mm" }
[[plan.steps]]
feature = "ring"
stylus = "down"
points = { strategy = "even", n = 8 }
[job]
trials = 2000
"""
RECORDING = """\
vcmm = "recording/1"
data = "touches.csv"
machine = "bare.toml"
kind = "probe"
[nuisance]
rigid = "pose"
[noise]
law = "normal"
u = "0.5 um"
"""
ROWS = 120
Tip = Callable[[np.ndarray], np.ndarray]  # positions (n, 3) mm -> error of the tip (n, 3) mm, workpiece axes


def write(folder: Path, known: str, tip: Tip) -> None:
    """mill.toml with `known`, the same machine bare, a measurement, a cut, a program, and touches that hold `tip`."""
    setup = shop.SETUP + "[control]\ncompensation = []\n"
    shop.write(folder, setup=setup, scenario=shop.SCENARIO.replace('work_offset = { u = "2 um" }\n', ""))
    machine = f'vcmm = "machine/1"\nname = "mill"\nkind = "machine-tool"\n{AXES}'
    (folder / "mill.toml").write_text(machine + known)
    (folder / "bare.toml").write_text(machine)
    (folder / "ring.toml").write_text(MEASURING)
    (folder / "touches.toml").write_text(RECORDING)
    (folder / "touches.csv").write_text(_touches(tip))


def _touches(tip: Tip) -> str:
    """Touches in three placements, noise of 0.5 um; indicated - true = -(error of the tip) along the normal."""
    rng = np.random.default_rng(3)
    position = rng.uniform([50, 50, -450], [550, 450, -50], (ROWS, 3))
    normal = rng.normal(size=(ROWS, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    d = -1e3 * (tip(position) * normal).sum(axis=1) + 0.5 * rng.normal(size=ROWS)
    rows = [
        ",".join(f"{v:.6f}" for v in (*position[i], *normal[i], d[i])) + f",{'abc'[3 * i // ROWS]}"
        for i in range(ROWS)
    ]
    return "\n".join(["X_mm,Y_mm,Z_mm,nx,ny,nz,d_um,pose", *rows]) + "\n"


def command(*words: object) -> str:
    """What a command prints. Raises AssertionError with its message where it could not do its job (1: it did, with bad news)."""
    from vcmm.face.cli import run

    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = run([str(w) for w in words])
    assert code in (0, 1), f"vcmm {' '.join(str(w) for w in words)} ended with {code}:\n{err.getvalue()}"
    return out.getvalue()


def all_jobs_without(stem: str) -> None:
    """Every job works; the known effect is the squareness, and what the touches hold the scale."""
    without(stem).install()
    with TemporaryDirectory() as name:
        folder = Path(name)
        write(folder, SQUARENESS, lambda at: 40e-6 * np.array([1.0, 0.0, 0.0]) * at)
        for verb in ("measure", "uncertainty"):
            found = json.loads(command(verb, folder / "ring.toml", "--json"))
            assert [c["name"] for c in found["characteristics"]] == ["diameter"]
        command("field", folder / "mill.toml", "--json")
        cut = json.loads(command("cut", folder / "boss.toml", "--json", "--trials", 2000))
        assert [c["name"] for c in cut["characteristics"]] == ["diameter", "form"]
        said = json.loads(command("diagnose", folder / "touches.toml", "--json"))
        assert stem == "scale" or [a["effect"] for a in said["answer"]] == ["scale_factor"]
    names = [e["effect"] for e in json.loads(command("list", "effects", "--json"))["items"]]
    for effect in names:
        command("explain", effect, "--json")
    assert set(names) == {e["effect"] for e in json.loads(command("list", "effects", "--json"))["items"]}
    json.loads(command("schema", "machine"))


def main() -> int:
    for name in (*LIBRARIES, *apart_from_effects()):
        importlib.import_module(name)
    failed = {stem: said for stem, said in each_without(all_jobs_without).items() if said}
    for stem, said in failed.items():
        print(f"without vcmm/physics/catalogue/{stem}.py:\n{said}")
    print(
        f"the small jobs work without {len(files()) - len(failed)} of {len(files())} files of vcmm/physics/catalogue/"
    )
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
