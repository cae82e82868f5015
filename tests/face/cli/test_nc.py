"""The command vcmm nc: documents, tables, remarks; and set-up files."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.face.cli import run
from vcmm.files.own.setup import load_setup

PROGRAM = "O1\nG21 G90\nT1 M6\nG54 S1000 M3\nG43 H1 G0 X0. Y0. Z5.\nG1 Z-1. F100.\nX30.\nG2 X40. Y-10. I0. J-10.\nG4 P500\nG0 Z5.\nM30\n"
SETUP = """vcmm = "setup/1"
machine = "machine.toml"
dialect = "fanuc"
[offsets]
G54 = ["100 mm", "50 mm", "-200 mm"]
[tools.1]
length = "80 mm"
diameter = "10 mm"
[tools.2]
diameter = "6 mm"
shape = "bull"
corner_radius = "1 mm"
[stock]
box = ["100 mm", "60 mm", "30 mm"]
"""


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    program, setup = tmp_path / "part.nc", tmp_path / "setup.toml"
    program.write_text(PROGRAM)
    setup.write_text(SETUP)
    return program, setup


def test_the_document(files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]):
    program, setup = files
    assert run(["nc", str(program), "--setup", str(setup), "--json"]) == 0
    shown = capsys.readouterr().out
    document = json.loads(shown)
    assert document["schema"] == "vcmm.nc/1"
    assert document["dialect"] == "fanuc"
    assert [Path(f["file"]).name for f in document["inputs"]] == ["part.nc", "setup.toml"]
    arc = next(m for m in document["moves"] if m["type"] == "arc")
    assert arc == {
        "type": "arc", "line": 8, "start_mm": [130, 50, -201], "end_mm": [140, 40, -201], "plane": "XY",
        "centre_mm": [130, 40, -201], "turns": 1, "clockwise": True, "feed_mm_min": 100, "spindle_rpm": 1000, "tool": 1,
        "compensation": None,
    }  # fmt: skip
    dwell = next(m for m in document["moves"] if m["type"] == "dwell")
    assert (dwell["seconds"], dwell["feed_mm_min"]) == (0.5, None)
    # 6 down, 30 along, a quarter of radius 10: (36 + 15.708) mm at 100 mm/min = 31.02 s
    assert document["summary"]["cutting_time_s"] == pytest.approx((36 + 5 * 3.14159265) * 0.6)
    assert document["summary"]["extent_work_mm"][1] == [40, 0, 5]
    assert [w["text"].rsplit("/", 1)[-1] for w in document["warnings"]] == [
        "machine.toml does not exist: travels are not looked at"
    ]


def test_a_guess_is_told(files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]):
    program, _ = files
    assert run(["nc", str(program), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert "guessed" in document["warnings"][0]["text"]
    assert document["assumed"] == [{"line": 5, "what": "tool 1", "value": "a tool without length"}]


def test_tables(files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]):
    program, setup = files
    assert run(["nc", str(program), "--setup", str(setup), "--moves"]) == 0
    shown = capsys.readouterr().out
    for words in ("part.nc", "arc G2", "130.0000 40.0000", "cutting time", "extent of the tip, work", "T1"):
        assert words in shown


def test_the_set_up(files: tuple[Path, Path]):
    setup = load_setup(files[1])
    assert setup.offsets == {"G54": (100, 50, -200)}
    assert setup.tools[1].offset == (0, 0, 80)
    assert setup.tools[1].radius == 5
    assert setup.tools[2].corner_radius == 1
    assert setup.machine == files[1].parent / "machine.toml"
    assert setup.stock == (100, 60, 30)


@pytest.mark.parametrize(
    ("old", "new", "line", "words"),
    [
        ('"80 mm"', "80", 7, 'length = "80'),
        ("G54 =", "G44 =", 5, "no work offset"),
        ('"fanuc"', '"fanoc"', 3, 'Did you mean "fanuc"'),
        ("tools.1", "tools.one", 6, "no tool number"),
        ('corner_radius = "1 mm"', "", 9, "needs corner_radius"),
        ('corner_radius = "1 mm"', 'corner_radius = "4 mm"', 9, "more than half"),
        ('shape = "bull"', 'shape = "bulb"', 11, 'Did you mean "bull"'),
        ("length =", "lenght =", 7, 'Did you mean "length"'),
        ('"setup/1"', '"setup/2"', 1, "newer vcmm"),
    ],
)
def test_wrong_set_ups(tmp_path: Path, old: str, new: str, line: int, words: str):
    path = tmp_path / "setup.toml"
    path.write_text(SETUP.replace(old, new, 1))
    with pytest.raises(DataError, match=rf"setup\.toml:{line}: .*{words}"):
        load_setup(path)


def test_a_tool_that_the_set_up_lacks_is_refused(
    files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
):
    program, setup = files
    program.write_text(PROGRAM.replace("H1", "H7"))
    assert run(["nc", str(program), "--setup", str(setup), "--strict"]) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert f"{program}:5:1: tool 7 (H7) is not in the set-up file, which has 1, 2" in shown.err


def test_check_and_schema_know_set_ups(files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]):
    setup = files[1]
    assert run(["check", str(setup)]) == 2  # it names a machine that is not there
    assert "machine.toml does not exist" in capsys.readouterr().err
    setup.write_text(SETUP.replace('machine = "machine.toml"', ""))
    assert run(["check", str(setup), "--json"]) == 0
    understood = json.loads(capsys.readouterr().out)["understood"]
    assert understood["offset G54"] == "work zero at 100 50 -200 mm"
    assert understood["tool 1"] == "flat, length 80 mm, diameter 10 mm"
    assert run(["schema", "setup"]) == 0
    assert json.loads(capsys.readouterr().out)["properties"]["vcmm"] == {"const": "setup/1"}


def test_time_by_the_time_law(files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]):
    program, setup = files
    axes = "".join(f'[axes.{a}]\ntravel = ["-500 mm", "500 mm"]\n' for a in "XYZ")
    (setup.parent / "machine.toml").write_text(
        f'vcmm = "machine/1"\nname = "mill"\nkind = "machine-tool"\nstructure = "w X\' Y\' b Z t"\n{axes}'
    )
    assert run(["nc", str(program), "--setup", str(setup), "--time", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["time"]
    # fed at 100 mm/min: 6 + 30 mm and a quarter of a circle of radius 10 mm, 51.708 mm: 31.0 s; speeding up costs below 0.5 s
    assert found["by_mode"]["feed"] == pytest.approx(31.02, abs=0.5)
    assert found["by_mode"]["dwell"] >= 0.5
    assert sum(found["by_mode"].values()) == pytest.approx(found["seconds"])
    assert any("jerk" in text for text in found["assumptions"])
    assert run(["nc", str(program), "--time"]) == 2
    assert "--time needs the machine" in capsys.readouterr().err


def test_strict_assumes_nothing(tmp_path, capsys):
    """What both levels know stands as a remark under --strict; `assumed` is what a survey took."""
    import json

    path = tmp_path / "tcp.nc"
    path.write_text("%\nO1\nG21 G90 G54 T1 M6\nG43.4 H1 Z50.\nG1 X1. F100\nM30\n%\n")
    for option, count in (("--strict", 0), (None, 1)):
        run([w for w in ("nc", str(path), "--dialect", "fanuc", option, "--json") if w])
        found = json.loads(capsys.readouterr().out or '{"assumed": []}')
        assert (len(found["assumed"]) > 0) == bool(count)
