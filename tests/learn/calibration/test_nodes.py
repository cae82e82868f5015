"""Nodes from LaserTracer lengths: d, the instrument's share and one approach against what was drawn; the test of the law; files and command."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import UsageError
from vcmm.face.cli import run as command
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.calibration.field_process import fit_process, support
from vcmm.learn.calibration.multilateration import nearest_pose
from vcmm.learn.calibration.nodes import chi_squared_statistics, node_scatter, t_tests
from vcmm.physics.structure.residual import ResidualField
from vcmm.task.instruments.laying import join_layouts
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
    whole = join_layouts("t", parts)
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
    assert chi_squared_statistics(split) == pytest.approx([8.0])
    assert chi_squared_statistics(even) == pytest.approx([0.0])


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
    assert one.nodes[:12] == pytest.approx(np.array([n["place_mm"] for n in found["nodes"]]))
    wanted = {
        key: np.array([n[f"{key}_um"] for n in found["nodes"]])
        for key in ("deviation_u", "single", "instrument")
    }
    assert one.reading_u * 1e3 == pytest.approx(wanted["deviation_u"], abs=6e-5)
    assert one.scatter * 1e3 == pytest.approx(np.maximum(wanted["single"], wanted["instrument"]), abs=6e-5)
    laws = {i.parameter: (i.redraw, i.law) for i in field.inputs if i.effect == one.name}
    assert (laws["random"][0], laws["random"][1].dof, laws["random"][1].scale) == ("touch", 11, 1.0)
    assert laws["systematic"][0] == "machine"
    known = np.sqrt(np.diag(laws["systematic"][1].covariance)).reshape(-1, 3)[:12]
    assert (known <= one.reading_u).all()  # the neighbours add to what a node's own readings tell
    assert found["process"]["length_scales_mm"] == pytest.approx(one.process["length_scales_mm"], rel=1e-4)


def _made_up(lengths, amplitude, seed, u=0.15e-3):
    """Nodes on a grid of 4 x 4 x 4 with deviations drawn from a process and read with u; approaches whose X and Y go together by 0.8."""
    rng = np.random.default_rng(seed)
    axes = (np.linspace(0, 800, 4), np.linspace(0, 600, 4), np.linspace(0, 400, 4))
    place = np.array(np.meshgrid(*axes, indexing="ij")).reshape(3, -1).T
    q = np.sqrt(5 * (((place[:, None] - place) / lengths) ** 2).sum(axis=2))
    root = np.linalg.cholesky((1 + q + q**2 / 3) * np.exp(-q) + 1e-9 * np.eye(64))
    deviation = amplitude * (root @ rng.standard_normal((64, 3))) + u * rng.standard_normal((64, 3))
    at = rng.standard_normal((64, 14, 3)) @ np.linalg.cholesky([[1, 0.8, 0], [0.8, 1, 0], [0, 0, 1]]).T * 1e-3
    at -= at.mean(axis=1, keepdims=True)
    return SimpleNamespace(
        place=place, deviation=deviation, deviation_u=np.full((64, 3), u), at=at, d=at.std(axis=1, ddof=1), dof=np.full(64, 13)
    )  # fmt: skip


@pytest.mark.thorough
def test_length_scales_amplitude_and_correlation_are_found():
    """Drawn with 300, 300, 150 mm and 1 um: on six draws the 95 % ranges hold at least 14 of 18 lengths (P = 1e-3 for fewer at 95 %)."""
    true, held, means = np.array([300.0, 300.0, 150.0]), 0, []
    for seed in range(6):
        fit = fit_process(_made_up(true, 1e-3, seed))
        held += int(((fit.lengths_range[0] <= true) & (true <= fit.lengths_range[1])).sum())
        means.append([*np.log(fit.lengths / true), *np.log(fit.amplitude / 1e-3)])
        assert fit.correlation[0, 1] == pytest.approx(0.8, abs=4 * 0.36 / np.sqrt(832))
        assert abs(fit.correlation[0, 2]) < 4 / np.sqrt(832)
    assert held >= 14
    u = np.std(means, axis=0, ddof=1) / np.sqrt(6)
    assert (np.abs(np.mean(means, axis=0)) < 5.89 * u).all()  # t of 5 degrees of freedom: 0.2 % each
    assert (u < 0.15).all()


def test_places_are_filled_in_no_further_apart_than_the_length():
    """800 x 600 x 400 mm, lengths 300: between 64 nodes 267 x 200 x 133 mm apart few are missing; every place has one within 0.7 lengths."""
    made = _made_up(np.full(3, 300.0), 1e-3, 0)
    nodes = support(made.place, np.full(3, 300.0))
    assert (nodes[:64] == made.place).all()
    rng = np.random.default_rng(1)
    anywhere = rng.uniform([0, 0, 0], [800, 600, 400], (500, 3))
    assert (np.linalg.norm(anywhere[:, None] - nodes, axis=2).min(axis=1) < 0.7 * 300).all()
    few = support(made.place[[0, 3, 12, 15, 48, 51, 60, 63]], np.full(3, 200.0))
    assert 8 < len(few) <= 240


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
