"""vcmm nc over a folder; the page of a path; the set-up file with blanks."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.face.cli import run
from vcmm.files.own.setup import load_setup

GOOD = "%\nO1\nG21 G90 F100.\nT3 M6\nG0 X0. Y0. Z5.\nG41 D3 G1 X10. Y0.\nY10.\nG40 X20.\nM30\n%"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "a.nc").write_text(GOOD)
    (tmp_path / "b.ngc").write_text("G21 F100\nG0 X1\nG1 X2\nM2\n")
    (tmp_path / "c.nc").write_text("%\nO3\nG21\nG0 X1. X2.\nM30\n%")
    (tmp_path / "d.h").write_text("BEGIN PGM D MM\nL X+1 Y+2 FMAX\nEND PGM D MM\n")
    (tmp_path / "notes.pdf").write_text("no program")
    return tmp_path


def test_the_table_as_json(folder: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["nc", str(folder), "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["programs"]
    assert [(r["file"], r["dialect"], r["exit"], r["moves"]) for r in rows] == [
        ("a.nc", "fanuc", 0, 4), ("b.ngc", "linuxcnc", 0, 2), ("c.nc", "fanuc", 2, 0), ("d.h", "heidenhain", 0, 1),
    ]  # fmt: skip
    assert rows[0]["assumed"] == 1
    assert rows[1]["assumed"] == 0
    assert rows[2]["reason"].startswith('c.nc:4:8: the word "X" appears twice')
    assert set(rows[0]) == {"file", "dialect", "exit", "moves", "assumed", "reason"}


def test_the_table_as_text_csv_and_page(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "out"
    assert run(["nc", str(folder), "--out", str(out)]) == 0
    shown = capsys.readouterr().out
    assert "read with assumptions" in shown
    assert "refused" in shown
    with (out / "programs.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(r["file"], r["exit"]) for r in rows] == [
        ("a.nc", "0"),
        ("b.ngc", "0"),
        ("c.nc", "2"),
        ("d.h", "0"),
    ]
    assert "appears twice" in (out / "programs.html").read_text()


def test_a_folder_without_programs(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["nc", str(tmp_path)]) == 2
    assert "holds no NC program" in capsys.readouterr().err


def test_the_page_of_a_path(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    out = tmp_path / "out"
    assert run(["nc", str(folder / "a.nc"), "--plot", "--out", str(out)]) == 0
    page = (out / "a.html").read_text()
    data = json.loads(page.split('<script type="application/json">')[1].split("</script>")[0])
    (path,) = data["paths"]
    assert path["line"] == [5, 6, 7, 8]
    assert path["x"] == [0, 0, 10, 10, 20]
    assert path["tool"] == [3] * 4
    assert path["rapid"] == [1, 0, 0, 0]
    assert path["feed"] == [None, 100, 100, 100]
    assert data["text"]["7"] == "Y10."
    assert "the diameter of tool 3" in page
    assert 'type="range"' in page


def test_the_set_up_file_with_blanks(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    setup = tmp_path / "set-up.toml"
    program = str(folder / "a.nc")
    assert run(["nc", program, "--write-setup", str(setup)]) == 0
    with pytest.raises(DataError, match=r'set-up\.toml:\d+: \[tools\.3\] diameter = "\?" has no number'):
        load_setup(setup)
    assert run(["nc", program, "--write-setup", str(setup)]) == 2  # not written over
    setup.write_text(setup.read_text().replace('"?"', '"4 mm"'))
    capsys.readouterr()
    assert run(["nc", program, "--setup", str(setup), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["assumed"] == []
    assert document["moves"][2]["end_mm"][0] == pytest.approx(
        8.0
    )  # the centre path of a radius of 2 mm, left of X 10


def test_text_that_no_control_reads(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "a.nc"
    path.write_bytes("G0 X1.\nM30".encode("utf-16"))
    assert run(["nc", str(path)]) == 2
    assert "UTF-16" in capsys.readouterr().err
