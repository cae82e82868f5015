"""--simulate on the command line: a plan and a machine to recordings, and from them back to the machine."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vcmm.core.laws import StudentT
from vcmm.face.cli import run
from vcmm.files.own.machine import load_machine
from vcmm.files.own.setups import MAKERS
from vcmm.task.instruments import ALL

STRUCTURE = "w C' b Y X Z t"
TRUTH = f"""vcmm = "machine/1"
structure = "{STRUCTURE}"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[axes.C]
travel = ["0 deg", "360 deg"]
centre = ["300 mm", "250 mm", "0 mm"]
[[effects]]
effect = "scale_factor"
axis = "X"
k = "10 um/m"
[[effects]]
effect = "backlash"
axis = "X"
gap = "3 um"
[[effects]]
effect = "squareness"
pair = "C0Y"
angle = "20 urad"
[[effects]]
effect = "rotary_location"
component = "X0C"
offset = "15 um"
"""
AT = 'at = { X = "100 mm", Y = "50 mm", Z = "-200 mm", C = "0 deg" }\n'
PLAN = f"""vcmm = "design/1"
machine = "truth.toml"
[[setups]]
name = "six X"
instrument = "6-D laser"
axis = "X"
{AT}offset = "0 0 -100 mm"
n = 7
u = "0.2 um"
own = {{ scale = "0.3 um/m" }}
minutes = 30
[[setups]]
name = "square"
instrument = "square"
axis = "X"
across_axis = "Y"
{AT}radius = "300 mm"
n = 5
u = "0.2 um"
own = {{ angle = "1 urad" }}
minutes = 20
[[setups]]
name = "nest"
instrument = "R-test"
axis = "C"
ball = "400 300 -200 mm"
n = 24
u = "0.2 um"
minutes = 10
[[setups]]
name = "circle"
instrument = "ball bar"
centre = "300 250 -200 mm"
radius = "150 mm"
plane = "XY"
u = "0.2 um"
minutes = 5
"""


@pytest.fixture(scope="module")
def plan(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("plan")
    (folder / "truth.toml").write_text(TRUTH)
    (folder / "plan.toml").write_text(PLAN)
    return folder


def simulate(folder: Path, out: str, seed: int = 0) -> list[str]:
    words = ["--simulate", str(folder / "plan.toml"), "--machine", str(folder / "truth.toml")]
    assert run(["calibrate", *words, "--out", str(folder / out), "--seed", str(seed)]) == 0
    return sorted(str(p) for p in (folder / out).glob("*.toml"))


def test_what_is_simulated_is_found_again(plan, capsys):
    files = simulate(plan, "read")
    assert len(files) == 6 + 3
    assert 'name = "square"' in (plan / "read" / "square.toml").read_text()
    assert 'u = { scale = "0.3 um/m" }' in (plan / "read" / "six_X_EXX.toml").read_text()
    capsys.readouterr()
    bare = str(plan / "read" / "machine" / "bare.toml")
    errors = ["--errors", "EXX BX C0Y X0C Y0C"]
    assert run(["calibrate", *files, "--machine", bare, *errors, "--json"]) == 0
    found = {f["error"]: f for f in json.loads(capsys.readouterr().out)["identified"]}
    # EXX without its mean goes from -3 to +3 um; X = 300 mm stands 3 um further, so that C is 15 - 3 um off
    for name, key, expected in (
        ("EXX", "high", 3.0),
        ("C0Y", "value", 20.0),
        ("X0C", "value", 12.0),
        ("Y0C", "value", 0.0),
    ):
        assert abs(found[name][key] - expected) < 4 * found[name]["u"] + 0.05, name
        assert found[name]["u"] < 1.0
    assert found["BX"]["low"] == pytest.approx(3.0, abs=0.4)
    assert run(["test", str(plan / "read" / "circle.toml"), "--iso", "230-4", "--json"]) == 0
    figures = {f["name"]: f["value_um"] for f in json.loads(capsys.readouterr().out)["figures"]}
    # 3 um of backlash: the senses of rotation differ by 3 um |cos| where X turns round, and noise of 0.2 um
    assert figures["H XY"] == pytest.approx(3.0, abs=0.8)


def test_nothing_is_left_of_a_plan_that_fails_on_the_way(tmp_path, capsys):
    """Two names that make one file are found after six recordings were written."""
    (tmp_path / "truth.toml").write_text(TRUTH)
    (tmp_path / "plan.toml").write_text(PLAN.replace('name = "circle"', 'name = "six X EXX"'))
    before = sorted(p.name for p in tmp_path.iterdir())
    words = ["--simulate", str(tmp_path / "plan.toml"), "--machine", str(tmp_path / "truth.toml")]
    assert run(["calibrate", *words, "--out", str(tmp_path / "deep" / "read")]) == 2
    assert "two set-ups would be written as six_X_EXX.toml" in capsys.readouterr().err
    assert sorted(p.name for p in tmp_path.iterdir()) == before


def test_one_instrument_has_one_error_in_all_of_its_set_ups(tmp_path):
    """A laser wrong by some of 1 mm/m, without errors of the machine: both lines of one serial show the same, another laser does not."""
    (tmp_path / "truth.toml").write_text(TRUTH.split("[[effects]]")[0])
    one = f"""[[setups]]
instrument = "laser linear"
axis = "X"
{AT}n = 3
u = "0.001 um"
own = {{ scale = "1 mm/m" }}
minutes = 1
"""
    named = [("a", "L-1"), ("b", "L-1"), ("c", "L-2"), ("d", "")]
    (tmp_path / "plan.toml").write_text(
        'vcmm = "design/1"\nmachine = "truth.toml"\n'
        + "".join(f'{one}name = "{n}"\nserial = "{s}"\n' for n, s in named)
    )
    simulate(tmp_path, "read")
    rows = [(tmp_path / "read" / f"{n}.csv").read_text().splitlines() for n, _ in named]
    at = [r[0].split(",").index("d_um") for r in rows]
    slope = [float(r[3].split(",")[k]) - float(r[1].split(",")[k]) for r, k in zip(rows, at)]
    assert slope[0] == pytest.approx(slope[1], abs=0.01)
    assert min(abs(slope[2] - slope[0]), abs(slope[3] - slope[0])) > 1
    assert 'serial = "L-1"' in (tmp_path / "read" / "a.toml").read_text()


def test_the_seed_decides(plan):
    first, again, other = (simulate(plan, n, s) for n, s in (("a", 1), ("b", 1), ("c", 2)))
    same, new = (Path(f[0]).with_suffix(".csv").read_text() for f in (again, other))
    assert Path(first[0]).with_suffix(".csv").read_text() == same
    assert same != new


def test_what_cannot_be_simulated(plan, capsys, tmp_path):
    words = ["calibrate", "--simulate", str(plan / "plan.toml")]
    assert run(words) == 2
    assert "--machine truth.toml --out readings" in capsys.readouterr().err
    (plan / "other.toml").write_text(TRUTH.replace("w C' b Y X Z t", "w C' b X Y Z t"))
    assert run([*words, "--machine", str(plan / "other.toml"), "--out", str(tmp_path)]) == 2
    assert "plan for that machine" in capsys.readouterr().err
    (plan / "moved.toml").write_text(
        TRUTH.replace('"300 mm", "250 mm", "0 mm"', '"310 mm", "250 mm", "0 mm"')
    )
    assert run([*words, "--machine", str(plan / "moved.toml"), "--out", str(tmp_path)]) == 2
    assert "turns about" in capsys.readouterr().err


def test_every_instrument_has_a_set_up(plan, capsys):
    assert set(MAKERS) == {i.name for i in ALL}
    # the plan says beforehand what it identifies: EXX of X by the laser, the location of C by the R-test
    assert run(["calibrate", "--design", str(plan / "plan.toml"), "--json"]) in (0, 1)
    document = json.loads(capsys.readouterr().out)
    assert document["setups"] == 4
    assert {"EBX", "ECX"} <= set(document["all"]["identified"])
    assert np.isfinite(document["all"]["volume_um"])


def test_the_bare_machine_keeps_the_dynamics(tmp_path):
    """Those of the plan's machine, else of the measured one: X of the second file does not count, C of it does."""
    moving = 'travel = ["0 mm", "600 mm"]\ndynamics = { speed = "30 m/min", acceleration = "3 m/s^2", jerk = "50 m/s^3", gain = "40 1/s", feed_forward = 0.9 }'
    turning = 'travel = ["0 deg", "360 deg"]\ndynamics = { speed = "20 rpm", acceleration = "10 rad/s^2" }'
    planned = TRUTH.replace('travel = ["0 mm", "600 mm"]', moving)
    (tmp_path / "planned.toml").write_text(planned)
    measured = planned.replace("30 m/min", "60 m/min").replace('travel = ["0 deg", "360 deg"]', turning)
    (tmp_path / "truth.toml").write_text(measured)
    (tmp_path / "plan.toml").write_text(PLAN.replace("truth.toml", "planned.toml"))
    simulate(tmp_path, "read")
    axes = load_machine(tmp_path / "read" / "machine" / "bare.toml").axes
    assert dict(axes["X"].dynamics) == pytest.approx(
        {"speed": 500.0, "acceleration": 3e3, "jerk": 5e4, "gain": 40.0, "feed_forward": 0.9}
    )
    assert dict(axes["C"].dynamics) == pytest.approx({"speed": 20 * 2 * np.pi / 60, "acceleration": 10.0})
    assert not axes["Y"].dynamics


def test_the_bare_machine_repeats_as_the_true_one(tmp_path, capsys):
    """Repeatability is no error of geometry. And what a rotary axis is asked for is an angle."""
    (tmp_path / "truth.toml").write_text(TRUTH + '[repeatability]\nlaw = "t"\nscale = "0.7 um"\ndof = 6\n')
    (tmp_path / "plan.toml").write_text(PLAN)
    simulate(tmp_path, "read")
    (stated,) = load_machine(tmp_path / "read" / "machine" / "bare.toml").inputs
    assert stated.law == StudentT(0.7e-3, 6.0)
    (tmp_path / "plan.toml").write_text(PLAN.replace(', C = "0 deg"', "", 1))
    capsys.readouterr()
    words = [
        "calibrate",
        "--simulate",
        str(tmp_path / "plan.toml"),
        "--machine",
        str(tmp_path / "truth.toml"),
    ]
    assert run([*words, "--out", str(tmp_path / "again")]) == 2
    assert 'does not say where C stood; add at = { C = "0 deg" }' in capsys.readouterr().err
