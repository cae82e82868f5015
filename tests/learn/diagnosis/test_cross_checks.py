"""Parts of the rows, a second opinion, transfer to another recording, what a next measurement will decide; data by numpy alone."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from vcmm.face.cli import run
from vcmm.learn.diagnosis.cross_checks import lower_claim
from vcmm.learn.diagnosis.next_measurement import expected_probability

MACHINE = """vcmm = "machine/1"
structure = "w b X t"
[axes.X]
travel = ["0 mm", "600 mm"]
[repeatability]
law = "normal"
u = "1 um"
"""
RECORDING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "displacement"
observed = "actual - commanded"
history = "none"
[nuisance]
zero = ""
"""


def written(
    folder: Path, seed: int, scale: float, gap: float, only_odd: bool = False
) -> tuple[Path, np.ndarray]:
    """160 rows: scale um/m times X, and -gap / 2 times the sense, scatter 1 um; what was written too. only_odd: the gap in every second row."""
    rng = np.random.default_rng(seed)
    x, sense = np.sort(rng.uniform(0, 600, 160)), rng.choice([-1, 1], 160)
    share = np.arange(160) % 2 if only_odd else np.ones(160)
    d = scale * 1e-3 * x - 0.5 * gap * share * sense + rng.normal(0, 1, 160)
    rows = [f"{a:.4f},{s},1,0,0,{v:.4f}" for a, s, v in zip(x, sense, d)]
    folder.mkdir(exist_ok=True)
    (folder / "data.csv").write_text("\n".join(["X_mm,sense_X,nx,ny,nz,d_um", *rows]) + "\n")
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml", d


def document(capsys: pytest.CaptureFixture[str], *files: Path) -> dict:
    assert run(["diagnose", *map(str, files), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


@pytest.mark.thorough
def test_what_every_part_of_the_rows_finds_is_stable(tmp_path, capsys):
    found = document(capsys, written(tmp_path, 1, scale=40.0, gap=5.0)[0])
    assert {a["effect"] for a in found["answer"] if not a["doubtful"]} == {"backlash", "scale_factor"}
    assert found["stable"] == {
        "halves": None,
        "alternate_rows": True,
        "changes": [],
    }  # no clock, no halves in time
    assert found["second_opinion"]["agrees"]
    assert len(found["second_opinion"]["names"]) == 2, found["second_opinion"]


@pytest.mark.thorough
def test_what_half_of_the_parts_lacks_is_unstable_and_claimed_with_one_half(tmp_path, capsys):
    # half of a play of 6 um fits all rows and leaves as much as it explains: delta sqrt(80) = 8.9 in a half, above 7, so both are asked;
    # found in 1 of 2: at most (1 + 1) / (2 + 2) = 0.5; something is left, and odds of 1.42 for a mechanism outside leave
    # 0.5 / 2.42 = 0.2066 of that
    found = document(capsys, written(tmp_path, 2, scale=0.0, gap=6.0, only_odd=True)[0])
    assert found["stable"]["alternate_rows"] is False
    assert found["stable"]["changes"] == ["backlash[X] is not found in odd rows, where it should show"]
    (play,) = [a for a in found["answer"] if a["effect"] == "backlash"]
    assert play["family_probability"] == pytest.approx(0.2066, abs=1e-4)


def test_two_opinions_that_disagree_leave_even_odds(tmp_path):
    assert lower_claim(0.998, 0.0) == pytest.approx(0.5)  # (0.998 + 0) / 2 = 0.499 is less than even
    assert lower_claim(0.9, 0.5) == pytest.approx(0.7)
    assert lower_claim(0.3, 0.0) == pytest.approx(0.3)  # what was improbable is not raised


@pytest.mark.parametrize(("odds", "more"), [(0.0, 6.0), (1.5, 2.0), (-1.0, 12.0)])
def test_what_a_next_measurement_is_expected_to_decide(odds, more):
    """p of the right one: its ln BF is normal about +more / 2 with variance more; integrated by scipy."""
    first = 1 / (1 + np.exp(-odds))

    def right(at: float) -> float:
        return quad(lambda z: norm.pdf(z) / (1 + np.exp(-at - 0.5 * more - np.sqrt(more) * z)), -8, 8)[0]

    due = first * right(odds) + (1 - first) * right(-odds)
    assert expected_probability(odds, more) == pytest.approx(due, abs=0.003)


def test_what_adds_nothing_decides_nothing():
    assert expected_probability(0.0, 0.0) == pytest.approx(0.5)
    assert expected_probability(0.0, 400.0) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.thorough
def test_the_file_from_one_recording_predicts_the_other(tmp_path, capsys):
    one, d_one = written(tmp_path / "a", 3, scale=40.0, gap=6.0)
    two, d_two = written(tmp_path / "b", 4, scale=40.0, gap=6.0)
    found = document(capsys, one, two)
    said = {Path(t["recording"]).parent.name: t for t in found["transfer"]}
    for name, d in (("a", d_one), ("b", d_two)):
        assert said[name]["rms_before"] == pytest.approx(float(np.std(d)), rel=1e-6)  # the zero is free
        assert said[name]["rms_after"] == pytest.approx(1.0, rel=0.15)  # the scatter
        assert Path(said[name]["from"]).parent.name == {"a": "b", "b": "a"}[name]


@pytest.mark.thorough
def test_folds_in_which_nothing_is_seen_are_left_out(tmp_path, capsys):
    found = document(capsys, written(tmp_path, 5, scale=0.0, gap=6.0)[0])
    assert [a["effect"] for a in found["answer"]] == ["backlash"]
    assert not [h for h in found["fit"]["held_out"] if h["effect_energy_left"] == 1.0 and h["log_score_gain_nats"] == 0.0]  # fmt: skip


@pytest.mark.thorough
def test_transfer_is_said_first(tmp_path, capsys):
    files = [written(tmp_path / n, s, scale=40.0, gap=6.0)[0] for n, s in (("a", 3), ("b", 4))]
    assert run(["diagnose", *map(str, files)]) == 0
    assert capsys.readouterr().out.lstrip().startswith("the file from one recording predicts another")


@pytest.mark.thorough
def test_two_bad_readings_are_told_beside_nothing_missing(tmp_path, capsys):
    file, _ = written(tmp_path, 7, scale=0.0, gap=0.0)
    lines = (tmp_path / "data.csv").read_text().splitlines()
    for k, far in (
        (30, 10.0),
        (90, -11.0),
    ):  # lines 31 and 91 of the file: 10 and 11 standard deviations of 1 um
        cells = lines[k].split(",")
        lines[k] = ",".join([*cells[:-1], f"{far:.3f}"])
    (tmp_path / "data.csv").write_text("\n".join(lines) + "\n")
    found = document(capsys, file)
    assert [a for a in found["answer"] if not a["doubtful"]] == []
    assert any(
        "lines 31 and 91 lie" in w["text"] and "standard deviations" in w["text"] for w in found["warnings"]
    )


@pytest.mark.thorough
def test_without_bad_readings_none_is_told(tmp_path, capsys):
    found = document(capsys, written(tmp_path, 7, scale=0.0, gap=0.0)[0])
    assert found["verdict"] == "nothing missing"
    assert not any("standard deviations from what is predicted" in w["text"] for w in found["warnings"])
