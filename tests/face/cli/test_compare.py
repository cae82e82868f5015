"""vcmm compare: figures by pencil, several machines and recordings, what must not change them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.conftest import data_file
from vcmm.face.cli import run

MACHINE = """vcmm = "machine/1"
name = "axis"
structure = "w b X t"
[axes.X]
travel = ["0 mm", "400 mm"]
[repeatability]
law = "normal"
u = "0.5 um"
"""
SCALE = """[[effects]]
effect = "scale_factor"
axis = "X"
k = "-10 um/m"
"""
RECORDING = """vcmm = "recording/1"
data = "rows.csv"
machine = "machine.toml"
kind = "displacement"
[nuisance]
zero = ""
"""
ROWS = ["0,1,0,0,1", "100,1,0,0,2", "200,1,0,0,3", "300,1,0,0,4"]


@pytest.fixture
def folder(tmp_path):
    """The axis goes 1 um per 100 mm too short: indicated - true = +1 um per 100 mm, a scale factor of -10 um/m."""
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "better.toml").write_text(MACHINE + SCALE)
    (tmp_path / "recording.toml").write_text(RECORDING)
    (tmp_path / "rows.csv").write_text("\n".join(["X_mm,nx,ny,nz,d_um", *ROWS]) + "\n")
    return tmp_path


def document(capsys, *words) -> dict:
    assert run(["compare", *map(str, words), "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_figures_by_pencil(folder, capsys):
    """1 2 3 4 um less their mean: -1.5 -0.5 0.5 1.5; rms sqrt(5/4) = 1.118 um; chi-square 5 / 0.25 = 20 with 4 - 1 dof."""
    got = document(capsys, folder / "recording.toml", "--machine", folder / "better.toml")
    own, better = got["machines"]
    assert own["file"] == str(folder / "machine.toml")
    assert own["rms_um"] == pytest.approx(1.1180339887)
    assert own["weighted_rms_um"] == pytest.approx(1.1180339887)
    assert own["noise_um"] == pytest.approx(0.5)
    assert (own["chi2"], own["dof"]) == (pytest.approx(20.0), 3)
    assert better["rms_um"] == pytest.approx(0.0, abs=1e-9)
    assert got["schema"] == "vcmm.compare/1"
    assert own["left_out"] == []


def test_weights_count(folder, capsys):
    """u = 1 1 1 3: weights 9 9 9 1 of 28. mean (9+18+27+4)/28 = 58/28; weighted sum of squares 9+36+81+16 - 58^2/28 over 9:
    142 - 120.142857 = 21.857143, /28 = 0.780612, root 0.883522 um; chi-square 21.857143 / 9 = 2.428571.
    """
    rows = [row + f",{u}" for row, u in zip(ROWS, (1, 1, 1, 3))]
    (folder / "rows.csv").write_text("\n".join(["X_mm,nx,ny,nz,d_um,u_um", *rows]) + "\n")
    own = document(capsys, folder / "recording.toml")["machines"][0]
    assert own["weighted_rms_um"] == pytest.approx(0.883522, abs=1e-6)
    assert own["chi2"] == pytest.approx(2.428571, abs=1e-6)


def test_a_machine_that_is_named_twice_stands_once(folder, capsys):
    own, better = folder / "machine.toml", folder / "better.toml"
    words = [folder / "recording.toml"]
    for file in (own, better, better):
        words += ["--machine", file]
    assert [m["file"] for m in document(capsys, *words)["machines"]] == [str(own), str(better)]


def test_order_of_rows_does_not_matter(folder, capsys):
    before = document(capsys, folder / "recording.toml")["machines"][0]
    (folder / "rows.csv").write_text("\n".join(["X_mm,nx,ny,nz,d_um", *ROWS[::-1]]) + "\n")
    after = document(capsys, folder / "recording.toml")["machines"][0]
    for key in ("rms_um", "weighted_rms_um", "chi2"):
        assert after[key] == pytest.approx(before[key], rel=1e-12)


def test_two_recordings_are_one_row_with_a_fold_each(folder, capsys):
    (folder / "second.toml").write_text(RECORDING.replace("rows.csv", "more.csv"))
    (folder / "more.csv").write_text(
        "X_mm,nx,ny,nz,d_um\n0,1,0,0,0\n100,1,0,0,4\n"
    )  # -2 and 2 um about their mean
    own = document(capsys, folder / "recording.toml", folder / "second.toml")["machines"][0]
    assert own["rms_um"] == pytest.approx(np.sqrt((5 + 8) / 6))
    of = {f["fold"]: f["rms_um"] for f in own["folds"]}
    assert of[str(folder / "second.toml")] == pytest.approx(2.0)
    assert own["dof"] == 4


def test_report_and_terminal(folder, capsys):
    words = [
        "compare",
        str(folder / "recording.toml"),
        "--machine",
        str(folder / "better.toml"),
        "--out",
        str(folder / "r"),
    ]
    assert run(words) == 0
    assert "1.118" in capsys.readouterr().out
    page = (folder / "r" / "report.html").read_text()
    assert "better.toml" in page
    assert "1.118" in page
    assert json.loads((folder / "r" / "compare.json").read_text())["machines"][0]["dof"] == 3


def test_too_few_rows_and_wrong_files_are_said(folder, capsys):
    (folder / "rows.csv").write_text("X_mm,nx,ny,nz,d_um\n0,1,0,0,1\n")
    assert run(["compare", str(folder / "recording.toml")]) == 2
    assert "nuisance parameter" in capsys.readouterr().err
    (folder / "rows.csv").write_text("\n".join(["X_mm,nx,ny,nz,d_um", *ROWS]) + "\n")
    assert run(["compare", str(folder / "recording.toml"), "--machine", str(folder / "no.toml")]) == 2
    assert "no.toml" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "unit", "rms"),
    [("s60res", "um", 0.96), ("heatK", "um", 17.6), ("rot1", "urad", 17400.0), ("mcuB", "um", 22.1)],
)
def test_recordings_of_others(name, unit, rms, capsys):
    """Rms of all rows, nuisance refitted, as plain least squares by other hands gives it (README of the recordings)."""
    own = document(capsys, data_file(f"data/recordings_2/{name}/recording.toml"))["machines"][0]
    assert own[f"rms_{unit}"] == pytest.approx(rms, rel=0.03)
