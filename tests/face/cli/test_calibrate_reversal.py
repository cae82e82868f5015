"""Files with [reversal] by the command line: what a user writes, sees, and what the machine file gives back."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vcmm.face.cli import run as command
from vcmm.files.own.machine import load_machine
from vcmm.task.instruments.reversal_simulation import axis_motion

STRUCTURE = "w C' X' b Z t"
X = np.linspace(0.0, 38.0, 39)


def write(folder, name, header, rows, reversal, more=""):
    text = "\n".join([header, *rows]) + "\n"
    (folder / f"{name}.csv").write_text(text, encoding="utf-8")
    lines = (
        f'vcmm = "recording/1"\ndata = "{name}.csv"\nkind = "displacement"\n{more}[reversal]\n{reversal}\n'
    )
    (folder / f"{name}.toml").write_text(lines, encoding="utf-8")
    return str(folder / f"{name}.toml")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """EZX 26 nm cos, EZC 2 nm (3 per turn), EBC 0.4 urad (2 per turn), B0C 0.39 urad, 0.3 nm of noise."""
    folder, rng = tmp_path_factory.mktemp("reversal"), np.random.default_rng(3)
    line = [
        f"{x:g},{s},{r},{1e-3 * (50 * np.sin(x / 4) + g * 26 * np.cos(x / 6) + 3 * r * x + 0.3 * rng.normal()):.6f}"
        for s, g in (("normal", 1), ("reversed", -1)) for r in (1, 2, 3) for x in X
    ]  # fmt: skip
    half = [
        f"{x:g},{s},{r},{1e-3 * (26 * np.cos(x / 6) - (0.39 + 0.4) * x + g * 2 * x + 0.3 * rng.normal()):.6f}"
        for s, g in (("normal", 1), ("reversed", -1)) for r in (1, 2) for x in X
    ]  # fmt: skip
    face = [
        f"{d},{s},{p},{1e-3 * (2 * np.cos(3 * q) - arm * 0.4 * np.cos(2 * q) + arm * g * np.cos(q) + 0.3 * rng.normal()):.6f}"
        for s, g in (("normal", 1), ("reversed", -1)) for p, arm in (("centre", 0), ("outer", 25 * g))
        for d in range(0, 5 * 360, 10) for q in [np.radians(d)]
    ]  # fmt: skip
    probes = 'probes = { centre = "0 mm", outer = "25 mm" }\nharmonics = 5'
    return (
        write(folder, "straight", "X_mm,setup,run,d_um", line, 'test = "straightness"\nerror = "EZX"'),
        write(folder, "half", "X_mm,setup,run,d_um", half, 'test = "half-turn"'),
        write(folder, "face", "C_deg,setup,instrument,d_um", face, f'test = "face"\n{probes}'),
    )


def document(capsys, *words):
    code = command([*words, "--json"])
    return code, json.loads(capsys.readouterr().out)


def test_a_machine_file_of_three_reversals_gives_back_what_was_put_in(files, tmp_path, capsys):
    out = tmp_path / "lathe.toml"
    code, found = document(capsys, "calibrate", *files, "--structure", STRUCTURE, "--out", str(out))
    assert (code, found["schema"], found["condition"] < 4) == (0, "vcmm.calibration/1", True)
    size = {row["error"]: row for row in found["identified"]}
    slope = np.polyfit(X, 26 * np.cos(X / 6), 1)[0]  # nm/mm, squareness by its definition
    assert size["B0C"]["value"] == pytest.approx(0.39 - slope, abs=4 * size["B0C"]["u"])
    assert size["B0C"]["u"] < 0.02
    assert [c["combination"] for c in found["not_identified"]] == [["EZX"], ["EBC"]]
    machine = load_machine(out)
    q = np.linspace(0.0, 4 * np.pi, 50)  # two turns: the orders go on
    seen = axis_motion(machine, "C", q, (25.0, 0.0, 0.0), {"X": 19.0})[:, 2]
    want = 1e-6 * (2 * np.cos(3 * q) - 25 * 0.4 * np.cos(2 * q))
    assert seen - seen.mean() == pytest.approx(want - want.mean(), abs=0.4e-6)
    curve = np.array(found["reversals"][0]["machine_um"])
    wave = 0.026 * np.cos(X / 6)
    assert curve == pytest.approx(wave - np.polyval(np.polyfit(X, wave, 1), X), abs=0.6e-3)
    assert {i.evidence for i in machine.inputs} >= {"reversal half", "reversal face"}


def test_iso_230_7_from_readings_and_from_the_machine_file(files, tmp_path, capsys):
    """Synchronous axial 2 x 2 nm, tilt 2 x 0.4 urad; a limit of 3 nm fails, one of 0.9 urad holds."""
    limits = ["--limit", "synchronous axial Z = 3 nm", "--limit", "synchronous tilt B = 0.9 urad"]
    code, read = document(capsys, "test", files[2], "--iso", "230-7", *limits)
    rows = {f["name"]: f for f in read["figures"]}
    assert code == 1
    assert rows["synchronous axial Z"]["value_um"] == pytest.approx(4e-3, abs=0.5e-3)
    assert rows["synchronous tilt B (urad)"]["value_um"] == pytest.approx(0.8, abs=0.04)
    assert (
        rows["synchronous axial Z"]["p_pass"],
        rows["synchronous tilt B (urad)"]["p_pass"],
    ) == pytest.approx((0, 1), abs=1e-3)
    assert "fundamental tilt B (urad)" not in rows
    out = tmp_path / "lathe.toml"
    assert command(["calibrate", files[2], "--structure", STRUCTURE, "--out", str(out)]) == 0
    capsys.readouterr()
    _, said = document(capsys, "test", str(out), "--iso", "230-7", "--trials", "200")
    predicted = {f["name"]: f for f in said["figures"]}
    assert "synchronous radial X" not in predicted  # nothing is known of it
    for name in ("synchronous axial Z", "synchronous tilt B (urad)"):
        assert predicted[name]["value_um"] == pytest.approx(rows[name]["value_um"], rel=0.05)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('setup', 'stup'), 'unknown column "stup"'),
        (('"straightness"', '"straitness"'), "straitness"),
        (('"EZX"', '"EXX"'), 'which takes a straightness such as "EZX"'),
        (('[reversal]', 'observed = "indicated - true"\n[reversal]'), 'says in [reversal] sense = "+" or "-"'),
        (('[reversal]', '[nuisance]\nzero = ""\n[reversal]'), "its free parameters follow from its test"),
        (('error = "EZX"', 'error = "EZX"\nprobes = { a = "1 mm" }'), 'probes belongs to test = "face"'),
        (('reversed', 'turned'), 'there are normal and turned'),
    ],
    ids=["column", "test", "error", "observed", "nuisance", "probes", "set-up"],
)  # fmt: skip
def test_bad_files_are_refused_with_the_fix(files, tmp_path, capsys, change, said):
    for path in (files[0], files[0].replace(".toml", ".csv")):
        text = Path(path).read_text(encoding="utf-8").replace(*change)
        (tmp_path / path.rpartition("/")[2]).write_text(text, encoding="utf-8")
    assert command(["calibrate", str(tmp_path / "straight.toml")]) == 2
    streams = capsys.readouterr()
    assert said in streams.err
    assert streams.out == ""


def test_rows_out_of_order_and_too_few_are_refused(tmp_path, capsys):
    rng = np.random.default_rng(0)
    rows = [f"{d},{0.02 * np.cos(2 * np.radians(d)):.5f}" for d in range(0, 1440, 5)]
    test = 'test = "direct"\nerror = "EZC"\nharmonics = 6'
    file = write(tmp_path, "order", "C_deg,d_um", list(rng.permutation(rows)), test)
    assert command(["calibrate", file]) == 2
    assert "the angles go to and fro" in capsys.readouterr().err
    assert command(["calibrate", write(tmp_path, "few", "C_deg,d_um", rows[:5], test)]) == 2
    assert "6 orders need 13 in every turn" in capsys.readouterr().err
    again = [
        f"{float(r.split(',')[0]) % 360:g},{r.split(',')[1]}" for r in rows
    ]  # the same turns, each from 0 again
    assert command(["calibrate", write(tmp_path, "again", "C_deg,d_um", again, test), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["reversals"][0]
    assert found["turns"][0]["turns"] == 4
    assert found["orders"]["EZC"][1]["cos"] == pytest.approx(0.02, abs=1e-5)


def test_what_does_not_go_together_is_said(files, tmp_path, capsys):
    assert command(["calibrate", *files, "--out", str(tmp_path / "m.toml")]) == 2
    assert "--structure" in capsys.readouterr().err
    assert command(["calibrate", files[1]]) == 0
    alone = capsys.readouterr().out
    assert "the slope that EZX has over the scanned part is in it" in alone
    assert "the mean tilt motion of the turning axis at both angles is in it" in alone
    assert command(["calibrate", files[0], files[0]]) == 2
    assert "both find EZX" in capsys.readouterr().err
    assert command(["diagnose", files[0]]) == 2
    assert "vcmm calibrate or vcmm test --iso 230-7" in capsys.readouterr().err
    assert command(["test", files[0], "--iso", "230-7"]) == 2
    assert "takes one of a turning axis" in capsys.readouterr().err
    assert command(["test", files[2], "--iso", "230-7", "--limit", "tilt B = 1 urad"]) == 2
    assert 'Did you mean "total tilt B"' in capsys.readouterr().err
