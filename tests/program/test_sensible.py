"""What the language allows and a shop would not do: told by nc, refused by cut and compensate."""

from __future__ import annotations

import json

import pytest

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.face.cli import run
from vcmm.files.own.setup import load_setup
from vcmm.program.interpret import interpret, read_for
from vcmm.program.sensible import remarks_on, without_length
from vcmm.program.setup import Setup, Tool

SETUP = Setup(
    dialect="fanuc", offsets={"G54": (100.0, 0.0, 0.0)}, tools={1: Tool(1, length=80.0, diameter=10.0)}
)
MILL = """\
vcmm = "machine/1"
name = "mill"
kind = "machine-tool"
structure = "w X' Y' b Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-500 mm", "0 mm"]
"""
TEXT = (
    'vcmm = "setup/1"\nmachine = "mill.toml"\ndialect = "fanuc"\n[offsets]\nG54 = ["300 mm", "250 mm", "-350 mm"]\n'
    '[tools.1]\nlength = "100 mm"\ndiameter = "20 mm"\n[control]\ncompensation = []\n'
)


def meant(body: str):
    return interpret(f"G21 G90\nT1 M6\n{body}\nM30\n", "fanuc", SETUP)


def test_a_cut_without_tool_length():
    move = without_length(meant("G54 G0 X0 Y0\nG1 Z-5. F100").moves, SETUP.tools)
    assert move is not None
    assert move.source.line == 4
    assert without_length(meant("G54 G0 X0 Y0\nG43 H1 Z5.\nG1 Z-5. F100").moves, SETUP.tools) is None


def test_remarks_name_the_first_line_of_each_fault(tmp_path):
    (tmp_path / "mill.toml").write_text(MILL)
    from vcmm.files.own.machine import load_machine

    machine: Machine = load_machine(tmp_path / "mill.toml")
    program = meant("G57 G43 H1 G0 X0 Y0 Z-200.\nG1 X700. F100\nG1 X710.")
    # Z -200 + 80 of the tool = -120 is inside; X 700 is not, and is told once
    assert [(r.line, r.text) for r in remarks_on(program, SETUP, machine)] == [
        (3, "work offset G57 is not in the set-up: machine zero is taken; add it to [offsets]"),
        (4, "axis X is sent to 700 mm, its travel is 0 to 600 mm; check work offset and tool length"),
    ]
    for line in ("G55", "G0 X1. G55"):  # told where the offset is named, with or without a move
        program = meant(f"{line}\nG43 H1\nG0 X0 Y0 Z-200.\nG1 X7. F100")
        assert [r.line for r in remarks_on(program, SETUP, None)] == [3]


def test_nc_says_so_and_that_a_machine_is_missing(tmp_path, capsys):
    (tmp_path / "setup.toml").write_text(TEXT)
    (tmp_path / "part.nc").write_text("G21 G90 G54\nT1 M6\nS1000 M3\nG0 X0 Y0\nG1 X400. F500\nM30\n")
    words = ["nc", str(tmp_path / "part.nc"), "--setup", str(tmp_path / "setup.toml"), "--json"]
    assert run(words) == 0
    assert "mill.toml does not exist: travels are not looked at" in capsys.readouterr().out
    (tmp_path / "mill.toml").write_text(MILL)
    assert run(words) == 0
    texts = [w["text"] for w in json.loads(capsys.readouterr().out)["warnings"]]
    assert any("axis X is sent to 700 mm" in t for t in texts)
    assert any("would cut 100 mm too deep" in t for t in texts)


def test_compensate_refuses_a_program_without_tool_length(tmp_path, capsys):
    (tmp_path / "setup.toml").write_text(TEXT)
    (tmp_path / "mill.toml").write_text(MILL)
    (tmp_path / "part.nc").write_text("G21 G90 G54\nT1 M6\nS1000 M3\nG0 X0 Y0\nG1 X100. F500\nM30\n")
    assert run(["compensate", str(tmp_path / "part.nc"), "--setup", str(tmp_path / "setup.toml")]) == 2
    assert "add G43 H1" in capsys.readouterr().err
    assert not (tmp_path / "part-compensated.nc").exists()


@pytest.mark.parametrize(
    ("tool", "due"), [(Tool(1, shape="turning", orientation=3), "nose_radius"), (Tool(1), "diameter")]
)
def test_radius_compensation_asks_for_the_size_of_this_tool(tool, due):
    from vcmm.core.errors import DataError

    with pytest.raises(DataError, match=f"add {due} = "):
        interpret("G21 G90\nT1 M6\nG41 D1 G1 X10. F100\nM30\n", "fanuc", Setup(tools={1: tool}))


def test_a_program_read_in_another_dialect_than_its_name_says(tmp_path, capsys):
    (tmp_path / "setup.toml").write_text(TEXT)
    (tmp_path / "part.mpf").write_text('; ring\nN10 G54 G90\nN20 R1=5\nMSG("RING")\nN30 G0 X=R1\nM30\n')
    assert run(["nc", str(tmp_path / "part.mpf"), "--setup", str(tmp_path / "setup.toml")]) == 2
    err = capsys.readouterr().err
    assert "was read as fanuc, that of the set-up; it looks like sinumerik (14: the file ends in .mpf" in err


def test_polar_interpolation_on_a_lathe_is_no_cut_along_y():
    text = "G21 G98 T0101\nG0 X120. C0 Z2.\nG12.1\nG1 X40. F200\nC20.\nG13.1\nM30\n"
    lathe = Machine(
        "turn",
        "machine-tool",
        parse_structure("w C' b Z X t"),
        {a: Axis(a, (-500.0, 500.0)) for a in "XZC"},
        (),
    )
    program = interpret(text, "fanuc-lathe", Setup(strict=False))
    assert not [
        r for r in remarks_on(program, Setup(offsets={"G54": (0.0, 0.0, 0.0)}), lathe) if "along Y" in r.text
    ]


def test_a_tool_that_states_no_length_is_told(tmp_path):
    text = 'vcmm = "setup/1"\ndialect = "fanuc"\n[offsets]\nG54 = ["0 mm", "0 mm", "0 mm"]\n[tools.1]\ndiameter = "10 mm"\n'
    program = "G21 G90 G54\nT1 M6\nG43 H1 G0 Z5.\nG1 Z-5. F100\nM30\n"
    said = {}
    for length in ("", 'length = "0 mm"\n', 'length = "90 mm"\n'):
        (tmp_path / "s.toml").write_text(text + length)
        read = read_for("cut", program, None, load_setup(tmp_path / "s.toml"))
        said[length] = [(r.line, "[tools.1] of the set-up states no length" in r.text) for r in read.warnings]
    assert said == {"": [(4, True)], 'length = "0 mm"\n': [], 'length = "90 mm"\n': []}


def test_g1_that_only_positions_needs_no_length():
    # 80 mm long: the tip stands at -80 while Z is at 0; G43 Z-100 goes down from there, so nothing was cut before
    text = "T1 M6\nG21 F100.\nG54 G1 X10. Y5.\nG43 H1 Z-100.\nG1 X20.\nM30"
    assert without_length(interpret(text, "fanuc", SETUP).moves, SETUP.tools) is None
    low = text.replace("Z-100.", "Z-20.")  # the tip has to come up: it was below its first height
    late = without_length(interpret(low, "fanuc", SETUP).moves, SETUP.tools)
    assert late is not None
    assert late.source.line == 3
    down = text.replace("G1 X10. Y5.", "G0 Z-5.\nG1 X10. Y5.")
    assert without_length(interpret(down, "fanuc", SETUP).moves, SETUP.tools) is not None
    never = "T1 M6\nG21 F100.\nG54 G1 X10. Y5.\nM30"
    assert without_length(interpret(never, "fanuc", SETUP).moves, SETUP.tools) is not None


def test_the_tool_that_is_in_the_spindle(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(
        'vcmm = "setup/1"\n[tools.spindle]\nlength = "30 mm"\ndiameter = "6 mm"\n', encoding="utf-8"
    )
    setup = load_setup(path)
    assert (setup.tools[0].number, setup.tools[0].diameter) == (0, 6.0)
    cut = interpret("G21 F100.\nG0 Z-5.\nG1 X10.\nM30", "fanuc", setup)
    late = without_length(cut.moves, setup.tools)
    assert late is not None
    assert late.tool == 0
