"""Nodes from LaserTracer lengths: d, the instrument's share and one approach against what was drawn; the test of the law; files and command."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import UsageError
from vcmm.face.cli import run as command
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.calibration.multilateration import nearest_pose
from vcmm.learn.calibration.nodes import chi_squared, node_scatter, t_tests
from vcmm.physics.structure.residual import ResidualField
from vcmm.task.instruments.laying import joined
from vcmm.task.instruments.tracker import lengths_to

STATIONS = ((-300, -300, 50), (900, -300, 100), (900, 800, 0), (-300, 800, 150), (300, 250, 900))
PLACES = np.array([[x, y, z] for x in (0.0, 250, 500) for y in (0.0, 400) for z in (-300.0, -50)])
LINES = np.array(
    [[x, y, z] for x, y in ((100.0, 100.0), (300, 400), (500, 100)) for z in (-300.0, -200, -100)]
)
U = 0.1e-3
HEAD = 'vcmm = "machine/1"\nname = "m"\nkind = "cmm"\nstructure = "w b Y X Z t"\n[axes.X]\ntravel = ["0 mm", "600 mm"]\n'
HEAD += '[axes.Y]\ntravel = ["0 mm", "500 mm"]\n[axes.Z]\ntravel = ["-400 mm", "0 mm"]\n'


def bare():
    return machine()


def recording(approaches=12, fixed=0.0, changing=0.0, seed=0, places=PLACES):
    """fixed, changing (3,) mm: standard deviation of what comes back at every station, and of what does not."""
    rng = np.random.default_rng(seed)
    tips = np.repeat(places, approaches, axis=0)
    free = {"station": "setup", "zero": "setup"}
    parts = [
        lengths_to(bare(), "t", tips, s, (0, 0, 0), nuisance=free, u=U, label=f"{k}")
        for k, s in enumerate(STATIONS)
    ]
    whole = joined("t", parts)
    names = np.tile([f"a{i:02d}" for i in range(approaches)], len(STATIONS) * len(places))
    same = np.tile(fixed * rng.standard_normal(tips.shape), (len(STATIONS), 1))
    moved = same + changing * rng.standard_normal(same.shape)
    value = whole.sign * (whole.direction * moved).sum(axis=1) + U * rng.standard_normal(whole.m)
    return replace(
        whole, value=value, run=replace(whole.run, labels={**whole.run.labels, "repeat": names})
    ), same[: len(tips)]


def test_what_comes_back_is_found_approach_by_approach():
    """Coordinates less their mean are the drawn ones less theirs, but for the lengths' noise of 0.1 um."""
    seen, drawn = recording(fixed=np.array([2e-3, 1e-3, 0.5e-3]))
    found = node_scatter(seen, bare())
    true = drawn.reshape(len(PLACES), -1, 3)
    true = true - true.mean(axis=1, keepdims=True)
    assert (found.at - true).std() < 0.12e-3
    assert found.d == pytest.approx(true.std(axis=1, ddof=1), abs=0.15e-3)
    assert found.u == pytest.approx(U, rel=0.1)
    assert (found.dof == 11).all()


def test_what_changes_between_stations_is_told_apart():
    """1 um that does not come back: d is smaller by the mean over the beams; one approach has its 1 um again."""
    several = [node_scatter(recording(changing=1e-3, seed=s)[0], bare()) for s in range(4)]
    d, single = (np.sqrt(np.mean([getattr(f, name) ** 2 for f in several])) for name in ("d", "single"))
    assert 0.7e-3 < d < 0.95e-3
    assert single == pytest.approx(1e-3, rel=0.06)
    assert np.sqrt(np.mean([f.u**2 for f in several])) == pytest.approx(np.hypot(1e-3, U), rel=0.05)


def test_the_instruments_share_is_that_of_a_machine_without_scatter():
    several = [node_scatter(recording(seed=s)[0], bare()) for s in range(4)]
    assert np.sqrt(np.mean([f.d**2 for f in several])) == pytest.approx(
        np.sqrt(np.mean([f.instrument**2 for f in several])), rel=0.05
    )


def test_chi_squared_by_hand():
    """Eight values, four cells of 2 expected, quartiles of the t-law of 7 degrees of freedom at +-0.711: all eight in the outer cells, four
    each, is (4 - 2)^2 / 2 * 2 + 2^2 / 2 * 2 = 8; two in each cell is 0.
    """
    split = np.array([[-1.0, -1, -1, -1, 1, 1, 1, 1]])
    even = np.array([[-1.5, -1.5, -0.2, -0.2, 0.2, 0.2, 1.5, 1.5]])
    assert chi_squared(split) == pytest.approx([8.0])
    assert chi_squared(even) == pytest.approx([0.0])


def test_the_test_keeps_its_level_and_sees_two_values():
    rng = np.random.default_rng(5)
    count = np.full(300, 14)
    null = t_tests(rng.standard_t(13, (300, 14, 3)), count)
    assert 0.01 < (null < 0.05).mean() < 0.075  # 900 tests; the cells are few, so that p jumps
    two = t_tests(
        np.sign(rng.standard_normal((300, 14, 3))) + 0.05 * rng.standard_normal((300, 14, 3)), count
    )
    assert (two < 0.05).mean() > 0.8


def test_command_writes_a_field_that_is_read_back(tmp_path, capsys):
    save_recording(recording(fixed=1e-3)[0], tmp_path / "tracer.toml", "m.toml")
    (tmp_path / "m.toml").write_text(HEAD)
    files = [str(tmp_path / name) for name in ("tracer.toml", "m.toml", "field.toml")]
    asked = ["calibrate", files[0], "--machine", files[1], "--nodes", "--json", "--out", files[2]]
    assert command(asked) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["schema"] == "vcmm.nodes/1"
    assert found["degrees_of_freedom"] == 5 * 144 - 3 * 144 - 4 * 5 + 6
    assert [n["approaches"] for n in found["nodes"]] == [12] * 12
    field = load_machine(tmp_path / "field.toml")
    one = next(e for e in field.effects if isinstance(e, ResidualField))
    assert one.nodes == pytest.approx(np.array([n["place_mm"] for n in found["nodes"]]))
    mean, u = (np.array([n[key] for n in found["nodes"]]) for key in ("deviation_um", "deviation_u_um"))
    assert one.values * 1e3 == pytest.approx(np.where(np.abs(mean) > 2 * u, mean, 0.0), abs=1e-6)
    law = next(i for i in field.inputs if i.effect == one.name)
    wanted = np.array([n["single_um"] for n in found["nodes"]]).ravel() * np.sqrt(13 / 12)
    assert (law.law.dof, law.redraw) == (11, "touch")
    assert law.scale * 1e3 == pytest.approx(wanted, abs=6e-4)


def test_a_field_is_not_stated_twice(tmp_path, capsys):
    save_recording(recording(fixed=1e-3)[0], tmp_path / "tracer.toml", "m.toml")
    (tmp_path / "m.toml").write_text(HEAD)
    names = [str(tmp_path / n) for n in ("tracer.toml", "m.toml", "a.toml", "b.toml")]
    assert command(["calibrate", names[0], "--machine", names[1], "--nodes", "--out", names[2]]) == 0
    assert "instrument's share" in capsys.readouterr().out
    assert command(["calibrate", names[0], "--machine", names[2], "--nodes", "--out", names[3]]) == 2
    assert "already; take it out of the file" in capsys.readouterr().err


def test_readings_that_do_not_fit_are_refused():
    seen, _ = recording(approaches=4)
    labels = {k: v for k, v in seen.run.labels.items() if k != "repeat"}
    assert (
        node_scatter(replace(seen, run=replace(seen.run, labels=labels)), bare()).dof.tolist() == [3] * 12
    )  # told by their order
    same = replace(seen, run=replace(seen.run, labels={**labels, "repeat": np.full(seen.run.n, "a")}))
    with pytest.raises(UsageError, match="is read 4 times from one station"):
        node_scatter(same, bare())
    with pytest.raises(UsageError, match="has 2 approaches"):
        node_scatter(recording(approaches=2)[0], bare())
    with pytest.raises(UsageError, match="lengths of a LaserTracer"):
        node_scatter(replace(seen, kind="displacement"), bare())


def test_nodes_on_three_lines_tell_the_scatter_and_the_mean_less_well():
    """Three columns and five stations leave the whole soft: d is what was drawn, and what the stations add to u of the means is told."""
    seen, drawn = recording(fixed=np.array([2e-3, 1e-3, 0.5e-3]), places=LINES)
    found = node_scatter(seen, bare())
    true = drawn.reshape(len(LINES), -1, 3)
    assert found.d == pytest.approx(true.std(axis=1, ddof=1), abs=0.15e-3)
    stiff = node_scatter(recording(fixed=1e-3)[0], bare())
    soft, hard = (np.sqrt((f.deviation_u**2 - f.d**2 / 12).max()) for f in (found, stiff))
    assert soft > 5 * hard


def test_a_mean_deviation_lies_within_its_u():
    rng, out = np.random.default_rng(4), []
    for seed in range(12):
        seen, _ = recording(fixed=0.3e-3, seed=seed)
        systematic = 2e-3 * rng.standard_normal(PLACES.shape)
        each = np.tile(np.repeat(systematic, 12, axis=0), (5, 1))
        seen = replace(seen, value=seen.value + seen.sign * (seen.direction * each).sum(axis=1))
        found = node_scatter(seen, bare())
        turn, shift = nearest_pose(PLACES + systematic, PLACES)
        true = (PLACES + systematic) @ turn.T + shift - PLACES
        out.append((found.deviation - true) / found.deviation_u)
    assert np.sqrt((np.array(out) ** 2).mean()) == pytest.approx(
        1.0, abs=0.15
    )  # one machine scatters by 0.18
