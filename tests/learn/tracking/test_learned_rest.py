"""A learned residual: its value by pencil, its gate, its files, its line in a budget, and what diagnose makes of it."""

import json
import math

import numpy as np
import pytest

import vcmm
from tests.learn.tracking.small_folder import write_check, write_machine
from tests.learn.tracking.test_track import TASK
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.face.cli import run
from vcmm.physics import find

Learned = find("learned_residual")
Q = np.linspace(0.0, 500.0, 26)


def at_x(*x, **columns):
    x = np.array(x, dtype=float)
    return vcmm.Run({"X": x}, np.zeros((len(x), 3)), {k: np.array(v) for k, v in columns.items()})


def test_between_two_nodes_by_pencil():
    # nodes 100 mm apart: l = 200; k(0, 100) = e^(-1/8) = 0.882497; half way k = e^(-1/32) = 0.969233 to either:
    # each weighs 0.969233 / 1.882497 = 0.514866, so that values of 2 and 4 um are 3.0892 um
    effect = Learned("EXX", nodes=np.array([0.0, 100.0]), values=np.array([2e-3, 4e-3]))
    six = effect.error_motion(at_x(0.0, 50.0, 100.0))
    assert six[:, 0] == pytest.approx([2e-3, 6e-3 * 0.514866, 4e-3], rel=1e-5)
    assert not six[:, 1:].any()


def test_over_a_column_both_kernels_multiply():
    # levels 18 and 22 degC, l = 8 K: half way (20 degC) again 0.514866 each
    effect = Learned(
        "EYX", "temp_air_C", np.array([0.0, 100.0]), "18 22", values=np.array([1.0, 1.0, 3.0, 3.0]) * 1e-3
    )
    (six,) = effect.error_motion(at_x(0.0, temp_air_C=[20.0]))
    assert six[1] == pytest.approx(4e-3 * 0.514866, rel=1e-5)


def test_outside_what_was_seen_it_is_refused():
    effect = Learned("EXX", "temp_air_C", np.array([0.0, 100.0]), "18 22", values=np.zeros(4))
    with pytest.raises(ModelLimit, match=r"X = 120 lies outside what it was learned from \(0 to 100\)"):
        effect.error_motion(at_x(120.0, temp_air_C=[20.0]))
    with pytest.raises(ModelLimit, match="temp_air_C = 25 lies outside"):
        effect.error_motion(at_x(50.0, temp_air_C=[25.0]))
    with pytest.raises(UsageError, match="3 values for 1 levels of 2 nodes"):
        Learned("EXX", nodes=np.array([0.0, 100.0]), values=np.zeros(3))
    with pytest.raises(UsageError, match="two levels or more where it has a column"):
        Learned("EXX", "temp_air_C", np.array([0.0, 100.0]), values=np.zeros(2))


def test_its_response_is_that_of_unit_steps():
    from vcmm.core.effect import basis, stepped_basis

    effect = Learned("EBX", nodes=np.array([0.0, 70.0, 100.0]), values=np.zeros(3))
    rows = at_x(3.0, 64.0, 99.0)
    assert basis(effect, "values", rows) == pytest.approx(stepped_basis(effect, "values", rows))


def write_waves(folder, sizes, seed=4, high=500.0):
    """Weekly lasers along X of a wave of 300 mm, um: indicated - true = -error."""
    rng = np.random.default_rng(seed)
    machine = write_machine(folder)
    q = np.linspace(0.0, high, 26)
    for week, size in enumerate(sizes):
        date = str(np.datetime64("2026-01-05") + 7 * week)
        write_check(folder / "checks", date, q, -size * np.sin(2 * np.pi * q / 300.0) + rng.normal(size=26))
    return machine


def learn(folder, machine, capsys):
    words = [
        "track",
        str(machine),
        str(folder / "checks"),
        "--out",
        str(folder / "out"),
        "--no-explain",
        "--learn-rest",
        "--json",
    ]
    run(words)
    return json.loads(capsys.readouterr().out)["learned"]


@pytest.mark.thorough
def test_a_wave_without_a_name_is_learned_and_stands_in_budget_and_diagnosis(tmp_path, capsys):
    machine = write_waves(tmp_path, [6.0] * 8)
    found = learn(tmp_path, machine, capsys)
    assert found["passed"]
    assert found["component"] == "EXX"
    # without it the later recordings have 6 / sqrt 2 = 4.2 um beside 1 um of noise; foretold: the noise, near one
    assert found["rms_before"] == pytest.approx(math.hypot(6 / math.sqrt(2), 1.0), rel=0.1)
    assert found["rms_after"] < 1.15
    read = vcmm.load_machine(tmp_path / "out" / "machine_learned.toml")
    effect = next(e for e in read.effects if e.name == "learned_residual")
    # a table's zero is a convention: mean of the wave taken away
    true = 6e-3 * np.sin(2 * np.pi * Q / 300.0)
    away = effect.error_motion(at_x(*Q))[:, 0] - true
    assert float(np.ptp(away)) < 2.5e-3
    assert "LEARNED, no physics" in (tmp_path / "out" / "machine_learned.toml").read_text()
    assert (tmp_path / "out" / "learned_residual.csv").read_text().startswith("X_mm,value_um,u_um\n0,")
    # a line of the budget with its name
    (tmp_path / "task.toml").write_text(TASK.replace("out/machine.toml", "out/machine_learned.toml"))
    result = vcmm.uncertainty(tmp_path / "task.toml")["length"]
    line = next(b for b in result.budget if "learned_residual" in b.input)
    assert 0.05e-3 < line.u < 1e-3
    # diagnose: a later recording of the same machine is as the file has it, and of a changed one the change is named, not the learned term
    rng = np.random.default_rng(9)
    for k, name in ((0.0, "same"), (80.0, "changed")):
        readings = -6 * np.sin(2 * np.pi * Q / 300.0) - k * Q * 1e-3 + rng.normal(size=26)
        (tmp_path / "later").mkdir(exist_ok=True)
        path = write_check(tmp_path / "later", "2026-04-01", Q, readings, name)
        said = vcmm.diagnose(path, machine=tmp_path / "out" / "machine_learned.toml")
        names = [a.effect for a in said.answer]
        assert "learned_residual" not in names
        assert bool(names) == (k > 0)


@pytest.mark.thorough
def test_what_does_not_foretell_is_not_written(tmp_path, capsys):
    noise = learn(tmp_path / "noise", write_waves(tmp_path / "noise", [0.0] * 6), capsys)
    assert not noise["passed"]
    # what turned round after the first half foretells the later half wrongly
    turned = learn(tmp_path / "turned", write_waves(tmp_path / "turned", [6.0] * 3 + [-6.0] * 3), capsys)
    assert not turned["passed"]
    assert "nothing is written" in turned["said"]
    assert not (tmp_path / "turned" / "out" / "machine_learned.toml").exists()


def test_three_recordings_are_too_few(tmp_path, capsys):
    machine = write_waves(tmp_path, [6.0] * 3)
    assert run(["track", str(machine), str(tmp_path / "checks"), "--no-explain", "--learn-rest"]) == 2
    assert "expected 4 or more recordings, found 3" in capsys.readouterr().err


def test_its_uncertainty_grows_where_no_row_lay(tmp_path, capsys):
    """Rows up to 500 mm in the first and only to 300 mm in all other recordings: beyond 300 mm it is less well known."""
    machine = write_waves(tmp_path, [6.0] * 7, high=300.0)
    rng = np.random.default_rng(2)
    write_check(
        tmp_path / "checks",
        "2026-01-01",
        Q[::5],
        -6 * np.sin(2 * np.pi * Q[::5] / 300.0) + rng.normal(size=6),
    )
    u = np.array(learn(tmp_path, machine, capsys)["u"])  # nodes 0, 62.5 ... 500
    assert u[7:].min() > 2 * u[1:4].max()  # 437.5 and 500 mm: six rows against 7 x 26
