"""vcmm diagnose FOLDER: a row of every recording, what changed, the same document whoever does the work."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from vcmm.face.cli import run
from vcmm.files.learned import fleet
from vcmm.show.tables.fleet import trend_text

MACHINE = """vcmm = "machine/1"
name = "mill {number}"
kind = "machine-tool"
structure = "w b X t"
[axes.X]
travel = ["0 mm", "100 mm"]
[repeatability]
law = "normal"
u = "0.02 um"
"""
RECORDING = """vcmm = "recording/1"
date = "{date}"
data = "data.csv"
machine = "machine.toml"
format = "iso230"
kind = "displacement"
[line]
axis = "X"
[nuisance]
zero = ""
"""


def put(folder: Path, number: int, date: str, gap: float) -> None:
    """A positioning run of three times five targets there and back, play `gap` (um)."""
    folder.mkdir()
    (folder / "machine.toml").write_text(MACHINE.format(number=number))
    (folder / "recording.toml").write_text(RECORDING.format(date=date))
    rng = np.random.default_rng(number)
    rows = ["target_mm,run,direction,actual_mm"]
    for lap in (1, 2, 3):
        for way, sign in (("up", -0.5), ("down", 0.5)):
            for target in (15, 25, 35, 45, 55)[:: 1 if way == "up" else -1]:
                read = target + 1e-3 * (sign * gap + 0.02 * rng.standard_normal())
                rows.append(f"{target},{lap},{way},{read:.5f}")
    (folder / "data.csv").write_text("\n".join(rows) + "\n")


@pytest.fixture(scope="module")
def shop(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One machine whose play grows, one measured once, a file that cannot be read, and a file that is no recording."""
    folder = tmp_path_factory.mktemp("shop")
    put(folder / "b_later", 1, "2026-10-05", 2.5)
    put(folder / "c_first", 1, "2026-03-02", 1.0)
    put(folder / "d_other", 2, "", 1.5)
    (folder / "a_bad.toml").write_text(
        'vcmm = "recording/1"\nkind = "displacement"\ndata = "nowhere.csv"\nmachine = "m.toml"\n'
    )
    (folder / "job.toml").write_text('vcmm = "scenario/1"\n')
    return folder


@pytest.fixture(autouse=True)
def own_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def document(words: list[str], capsys: pytest.CaptureFixture[str]) -> dict:
    assert run(words) == 0
    return json.loads(capsys.readouterr().out)


def test_every_recording_has_its_row_and_changes_are_told(shop, tmp_path, capsys):
    found = document(["diagnose", str(shop), "--json", "--out", str(tmp_path / "out")], capsys)
    assert found["schema"] == "vcmm.diagnosis-folder/1"
    rows = {r["file"]: r for r in found["recordings"]}
    assert list(rows) == [
        "a_bad.toml",
        "c_first/recording.toml",
        "b_later/recording.toml",
        "d_other/recording.toml",
    ]
    assert "nowhere.csv" in rows["a_bad.toml"]["problem"] or "m.toml" in rows["a_bad.toml"]["problem"]
    (play,) = rows["b_later/recording.toml"]["answer"]
    assert play["effect"] == "backlash"
    assert play["parameters"]["gap"]["value"] == pytest.approx(2.5, abs=0.05)
    (change,) = found["changes"]  # the other machine was measured once: nothing to compare
    assert (change["machine"], change["name"], change["found_in"]) == ("mill 1", "backlash X", "2 of 2")
    assert change["change"] == pytest.approx(1.5, abs=0.05)
    assert change["deviations"] > 20
    assert change["first"] == "2026-03-02 (c_first/recording.toml)"
    assert (change["trend"], change["trend_from"], change["trend_to"]) == (
        "step",
        "2026-03-02",
        "2026-10-05",
    )
    assert change["trend_amount"] == pytest.approx(change["change"])
    assert change["presence"] == "always"
    with (tmp_path / "out" / "recordings.csv").open() as file:
        table = list(csv.DictReader(file))
    assert [t["problem"] != "" for t in table] == [True, False, False, False]
    assert float(table[2]["value"]) == pytest.approx(play["parameters"]["gap"]["value"], rel=1e-5)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "What changed" in page
    assert "b_later/recording.toml" in page


@pytest.mark.thorough
def test_shards_put_together_are_the_job(shop, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    whole = document(["diagnose", str(shop), "--json"], capsys)
    for k in (1, 2):
        assert run(["diagnose", str(shop), "--shard", f"{k}/2"]) == 0
    merged = document(["merge", *map(str, sorted(tmp_path.glob("*.shard-*.json"))), "--json"], capsys)
    for key in ("recordings", "changes", "inputs", "seed", "schema"):
        assert merged[key] == whole[key]


@pytest.mark.thorough
def test_an_interrupted_job_goes_on_where_it_was(shop, capsys, monkeypatch):
    whole = document(["diagnose", str(shop), "--json"], capsys)
    plain, done = fleet.record_of, []

    def stopped(asked, file):
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(file)
        return plain(asked, file)

    monkeypatch.setattr(fleet, "record_of", stopped)
    assert run(["diagnose", str(shop), "--json"]) == 130
    capsys.readouterr()
    monkeypatch.setattr(fleet, "record_of", lambda asked, file: done.append(file) or plain(asked, file))
    again = document(["diagnose", str(shop), "--json"], capsys)
    assert len(done) == len(set(done)) == 4  # two before, the two others after
    assert again["recordings"] == whole["recordings"]


def test_a_fault_of_ours_is_told_and_does_not_end_the_others(shop, capsys, monkeypatch):
    def broken(*_, **__):
        raise ZeroDivisionError("oh")

    monkeypatch.setattr(fleet, "diagnose", broken)
    assert run(["diagnose", str(shop), "--json"]) == 70
    rows = json.loads(capsys.readouterr().out)["recordings"]
    assert sum("internal error (ZeroDivisionError: oh)" in r["problem"] for r in rows) == 3


def test_words_that_make_no_sense_here(shop, tmp_path, capsys):
    (tmp_path / "empty").mkdir()
    for words, said in (
        ([str(tmp_path / "empty")], "holds no recording"),
        ([str(shop), str(shop)], "name one folder"),
        ([str(shop), "--report", "x.html"], "a folder has --out"),
        ([str(shop / "b_later" / "recording.toml"), "--workers", "2"], "share the recordings of a folder"),
    ):
        assert run(["diagnose", *words]) == 2
        assert said in capsys.readouterr().err


@pytest.mark.thorough
def test_workers_give_the_same_document(shop, capsys):
    one = document(["diagnose", str(shop), "--json"], capsys)
    two = document(["diagnose", str(shop), "--json", "--workers", "2"], capsys)
    assert {k: v for k, v in one.items() if k != "created"} == {
        k: v for k, v in two.items() if k != "created"
    }


def test_what_drifts_and_what_appears_is_said():
    """A year of three machines: one as it was, one that drifts, one that is hit in summer."""

    def record(machine, month, name, value, u):
        found = [{"effect": name, "where": {}, "doubtful": False, "alias_of": None, "parameters": {"k": {"value": value, "u": u, "unit": "um"}}}]  # fmt: skip
        date = f"2026-{month:02d}-15"
        return {
            "machine": machine,
            "date": date,
            "file": date,
            "problem": None,
            "answer": found if value else [],
        }

    months = range(1, 13)
    records = [record("old", m, "play", 2.0 + 0.01 * (-1) ** m, 0.1) for m in months]
    records += [record("worn", m, "play", 0.1 * m, 0.1) for m in months]
    records += [record("hit", m, "scale", 4.0 if m > 7 else None, 0.1) for m in months]
    found = {c.machine: c for c in fleet.changes(records)}
    assert {m: c.steady for m, c in found.items()} == {"old": True, "worn": False, "hit": False}
    said = {m: trend_text(c) for m, c in found.items()}
    assert said["old"] == "steady"
    assert said["worn"] == "drifts by +1.098 ± 0.092 um"  # 0.1 sqrt(12 / 143) / month, 11 of them: 0.092
    assert said["hit"] == "appears between 2026-07-15 and 2026-08-15; steady"


def test_a_change_by_hand():
    """1.0 +- 0.3 and 2.0 +- 0.4: change 1.0, u = 0.5, two deviations."""
    change = fleet.Change("m", "play X", "gap", "um", ("a", ""), ("b", ""), (1.0, 0.3), (2.0, 0.4), 2, 2)
    assert (change.change, change.deviations) == (1.0, pytest.approx(2.0))
