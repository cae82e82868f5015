"""Malformed programs: one message with line, column, reason and what to do, exit code 2, nothing on stdout."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError, ModelLimit
from vcmm.face.cli import run
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

TOOLED = Setup(tools={1: Tool(1, 50.0, 10.0)})
L, F = "linuxcnc", "fanuc"
BAD = [  # dialect, program, line, column, words of the message
    (L, "G21 F100\nG2 X10 Y0 I1 J0\nM2", 2, 1, "the arc does not fit"),
    (L, "G21 F100\nG2 X10 Y0 R0\nM2", 2, 11, "radius zero"),
    (L, "G21 F100\nG2 X0 Y0 R5\nM2", 2, 10, "end elsewhere"),
    (L, "G21 F100\nG2 X30 Y0 R5\nM2", 2, 11, "R is too small"),
    (L, "G21 F100\nG2 X30 Y0 R20 I5\nM2", 2, 11, "not both"),
    (L, "G21 F100\nG2 X30 Y0\nM2", 2, 1, "neither R nor a centre"),
    (L, "G21 F100\nG2 X10 I5 K1\nM2", 2, 11, "no centre word"),
    (L, "G21 F100\nG18 G2 X10 J5\nM2", 2, 12, "no centre word"),
    (L, "G21 F100\nG1 X10 X20\nM2", 2, 8, "twice"),
    (L, "G21 F100\nG0 G1 X10\nM2", 2, 4, "one group"),
    (L, "G21 F100\nG17 G18\nM2", 2, 5, "one group"),
    (F, "G21 F100.\nG0 G1 X10.\nM30", 2, 4, "one group"),
    (L, "G21\nG1 X10\nM2", 2, 1, "no feed"),
    (F, "G21\nG1 X10.\nM30", 2, 1, "no feed"),
    (L, "G21 G1 F100 X1\n", 1, 1, "no end"),
    (L, "%\nG21 G1 F100 X1\n", 2, 1, "second %"),
    (L, "G21\nG0 X1 (never closed\nM2", 2, 7, "never closed"),
    (F, "G21\nG0 X1. (never closed\nM30", 2, 8, "never closed"),
    (L, "G21\nG0 X1 (a (b) c)\nM2", 2, 10, "comment inside a comment"),
    (L, "G21\nG0 X1 )\nM2", 2, 7, r'"\)" without'),
    (L, "G21\nG0 X\u00e9\nM2", 2, 5, "not allowed"),
    (L, "G21\nG0 X\u2212 5\nM2", 2, 5, "not allowed"),
    (L, "G21\nG0 X5,5\nM2", 2, 6, "comma"),
    (F, "G21\nG0 X5,5\nM30", 2, 6, "comma"),
    (L, "G21\nG0 Xabc\nM2", 2, 5, "no function"),
    (L, "G21\nG0 X\nM2", 2, 5, "expected a number"),
    (L, "G21\nG0 X--\nM2", 2, 7, "expected a number"),
    (L, "G21\nG0 X1.2.3\nM2", 2, 8, "second decimal point"),
    (L, "G21\nG999 X1\nM2", 2, 1, "unknown"),
    (L, "G21\nM444\nM2", 2, 1, "M444 is unknown"),
    (L, "G21\nM1.5\nM2", 2, 1, "whole"),
    (L, "G21\nG0 X10 N5\nM2", 2, 8, "first word"),
    (L, "G21\nX10\nM2", 2, 1, "without a motion code"),
    (L, "G21 F100\nG1 X1 U2\nM2", 2, 7, "axis U is not modelled"),
    (L, "G21 F100\nG1 X1 Q2\nM2", 2, 7, 'uses the word "Q"'),
    (L, "G21 F100\nG5.2 X1 Y1 P1 L3\nM2", 2, 1, "NURBS"),
    (F, "G21 F100\nG31 Z-10.\nM30", 2, 1, "skip"),
    (L, "G21 F100\nG38.2 Z-10\nM2", 2, 1, "probing"),
    (L, "G21 F-5\nG1 X1\nM2", 1, 5, "negative"),
    (L, "G21 S-5\nM2", 1, 5, "negative"),
    (L, "G21\nG4\nM2", 2, 1, "time of G4"),
    (L, "G21\nG4 P-1\nM2", 2, 1, "negative"),
    (L, "G21\nG93 F2\nG1 X1\nM2", 3, 1, "G93"),
    (L, "G21 G95 F0.1\nG1 X1\nM2", 2, 1, "spindle has no speed"),
    (L, "G21\nG0 X[1/0]\nM2", 2, 7, "division by zero"),
    (L, "G21\nG0 X[SQRT[-1]]\nM2", 2, 6, "no real value"),
    (L, "G21\n#1=[0-1]\nG0 X[SQRT[#1]]\nM2", 3, 6, "no real value"),
    (L, "G21\nG0 X[10 ** 400]\nM2", 2, 9, "no finite value"),
    (L, "G21\nG0 X[1 + 2\nM2", 2, 5, "never closed"),
    (L, "G21\nG0 X#<nothing>\nM2", 2, 4, "no value yet"),
    (L, "G21\nG0 X#1.5\nM2", 2, 9, "whole"),
    (L, "G21\n#5221=3 #5420=1\nM2", 2, 9, "filled in by the control"),
    (L, "G21\no1 while [1]\no1 endwhile\nM2", 3, 1, "endless"),
    (L, "G21\no1 while [1]\nM2", 2, 1, "endwhile is missing"),
    (L, "G21\no1 if [0]\nM2", 2, 1, "is missing"),
    (L, "G21\no1 endsub\nM2", 2, 1, "without a call"),
    (L, "G21\no<gone> call\nM2", 2, 1, "neither in this program"),
    (L, "G21\no1 sub\no1 call\no1 endsub\no1 call\nM2", 3, 1, "call one another"),
    (F, "O1\nM98 P1\nM30", 2, 1, "call one another"),
    (F, "O1\nM98 P77\nM30", 2, 1, "O77 is neither"),
    (F, "O1\nM98\nM30", 2, 1, "needs P"),
    (F, "O1\nN1 #1=1\nGOTO1\nM30", 3, 1, "endless"),
    (F, "O1\nGOTO 99\nM30", 2, 1, "no block N99"),
    (F, "O1\nWHILE[1 EQ 1] DO1\nM30", 2, 1, "END1 is missing"),
    (F, "O1\nEND1\nM30", 2, 1, "without WHILE"),
    (F, "O1\n#3000=5 (TOOL BROKEN)\nM30", 2, 1, "own alarm"),
    (F, "O1\nG0 X[#1/#2]\nM30", 2, 8, "division by zero"),
    (L, "G21\nG81 X1 Z-1\nM2", 2, 1, "no clearance height"),
    (L, "G21\nG81 X1 R1\nM2", 2, 1, "no depth"),
    (L, "G21 F100\nG81 X1 R1 Z5\nM2", 2, 1, "lies above"),
    (L, "G21 F100\nG83 X1 R1 Z-5\nM2", 2, 1, "needs Q"),
    (L, "G21 F100\nG83 X1 R1 Z-5 Q-1\nM2", 2, 15, "must be positive"),
    (L, "G21 F100\nG81 X1 R1 Z-5 L0\nM2", 2, 15, "L0"),
    (L, "G21 F100\nG81 A1 R1 Z-5\nM2", 2, 1, "rotary axes"),
    (L, "G21 F100\nG53 X1\nM2", 2, 1, "G53 needs"),
    (L, "G21 F100\nG91 G53 G0 X1\nM2", 2, 5, "absolute"),
    (L, "G21 F100\nG0 G28 X1\nM2", 2, 4, "both want the axis words"),
    (L, "G21 F100\nG10 L2 P12 X1\nM2", 2, 1, "P0 to P9"),
    (L, "G21 F100\nG10 L7 P1 X1\nM2", 2, 1, "not understood"),
    (L, "G21 F100\nG92\nM2", 2, 1, "at least one axis"),
    (L, "G21 F100\nG33 Z-5 K1\nM2", 2, 1, "turning spindle"),
    (L, "G21 F100\nG64 P-1\nM2", 2, 5, "negative"),
    (L, "G21\n@3 ^4\nM2", 2, 1, "without a motion code"),
    (L, "", 1, 1, "empty"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("dialect", "text", "line", "column", "words"), BAD, ids=[repr(b[1])[:40] for b in BAD]
)
def test_one_message_with_line_and_column(dialect: str, text: str, line: int, column: int, words: str):
    with pytest.raises(DataError, match=rf"^bad\.nc:{line}:{column}: .*(?:{words})") as caught:
        interpret(text, dialect, name="bad.nc")
    assert len(caught.value.problems) == 1


COMPENSATION = [
    ("G21 F100\nG41 D1\nG1 X2 Y0\nX50\nG40 X60\nM2", 3, "lead-in"),
    ("G21 F100\nG41 D1\nG1 X20 Y0\nX40\nY3\nX0\nY20\nG40 X-20\nM2", 5, "goug|reach"),
    ("G21 F100\nG41 D1\nG1 X20\nX40\nG18\nG1 X50\nM2", 5, "plane changes"),
    ("G21 F100\nG41 D1\nG1 X20\nX40\nG28\nM2", 5, "reference move"),
    ("G21 F100\nG41 D1\nG1 X20\nX40\nG81 X1 R1 Z-5\nM2", 5, "cancel it with G40"),
    ("G21 F100\nG41 D7\nG1 X20\nX40\nM2", 2, "tool 7 .* not in the set-up"),
]


@pytest.mark.parametrize(("text", "line", "words"), COMPENSATION)
def test_radius_compensation_that_cannot_be(text: str, line: int, words: str):
    with pytest.raises((DataError, ModelLimit), match=rf"bad\.nc:{line}:\d+: .*(?:{words})"):
        interpret(text, "linuxcnc", TOOLED, "bad.nc")


def test_compensation_without_a_tool_table_names_the_set_up():
    with pytest.raises(DataError, match=r"bad.nc:2:1: .*--setup"):
        interpret("G21 F100\nG41 D1\nG1 X20\nM2", "linuxcnc", name="bad.nc")


def test_nothing_on_stdout_and_exit_code_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "bad.nc"
    path.write_text("G21 F100\nG1 X1\nG2 X10 Y0 I1 J0\nM2\n")
    for words in (
        ["nc", str(path)],
        ["nc", str(path), "--json"],
        ["nc", str(path), "--dialect", "linuxcnc", "--json"],
    ):
        assert run(words) == 2
        shown = capsys.readouterr()
        assert shown.out == ""
        assert len(shown.err.strip().splitlines()) == 1
        assert f"{path}:3:1: the arc does not fit" in shown.err


def test_nul_bytes_and_missing_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "nul.nc"
    path.write_bytes(b"G21\nG0 X\0001\nM2\n")
    assert run(["nc", str(path)]) == 2
    assert f"{path}:2:5: a NUL byte" in capsys.readouterr().err
    assert run(["nc", str(tmp_path / "nol.nc")]) == 2
    assert 'Did you mean "nul.nc"' in capsys.readouterr().err


def test_an_unknown_dialect_is_answered_with_the_closest(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    path = tmp_path / "a.nc"
    path.write_text("G0 X1.\nM30\n")
    assert run(["nc", str(path), "--dialect", "fanoc"]) == 2
    assert 'Did you mean "fanuc"' in capsys.readouterr().err


@pytest.mark.parametrize("end", ["\n", "\r\n", "\r"])
def test_line_ends(end: str):
    text = end.join(["G21", "G0 X1", "G1 Y2 F100", "M2", ""])
    assert [m.source.line for m in interpret(text, "linuxcnc").moves] == [2, 3]


@pytest.mark.parametrize(
    ("word", "x"),
    [("X.5", 0.5), ("X5.", 5.0), ("X+5", 5.0), ("X-.0", 0.0), ("x5", 5.0), ("X 1 0", 10.0), ("X - 5", -5.0)],
)
def test_ways_to_write_a_number(word: str, x: float):
    assert interpret(f"g21\nG0 Y9\nG0 {word}\nM2", "linuxcnc").moves[-1].end[0] == x


def test_a_tool_without_m6_is_not_in_the_spindle():
    moves = interpret("G21 T5\nG0 X1\nM6\nG0 X2\nM2", "linuxcnc").moves
    assert [m.tool for m in moves] == [0, 5]


def test_text_after_the_end_and_a_second_percent():
    found = interpret("%\nG21\nG0 X1\n%\nG0 X9\n%\n", "linuxcnc")
    assert len(found.moves) == 1
    assert any("not read" in w.text for w in found.warnings)
    assert len(interpret("%\n%\nG21\n", "linuxcnc").moves) == 0


def test_a_change_of_unit_is_remarked_and_right():
    found = interpret("G21\nG0 X25.4\nG20\nG0 X2\nM2", "linuxcnc")
    assert found.moves[-1].end[0] == 50.8
    assert any("unit changes" in w.text for w in found.warnings)


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("linuxcnc", "G21 G91 G0\no1 while [1]\nX0.001\no1 endwhile\nM2"),
        ("fanuc", "O1\nG91 G0\nM98 P2 L99999999\nM30\nO2\nX0.001\nM99"),
    ],
)
def test_a_loop_that_moves_for_ever_ends_too(dialect: str, text: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("vcmm.program.iso.flow.MOST_REPETITIONS", 5000)
    with pytest.raises(
        DataError, match=r"bad\.nc:[2-7]:1: .* (?:more than 5000 blocks again|5000 are the most)"
    ):
        interpret(text, dialect, name="bad.nc")
