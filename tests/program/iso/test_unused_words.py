"""Words that nothing uses: refused by the strict level, told once with their lines by the survey; rounding told in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.face.cli import run
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

SURVEY = Setup(strict=False)


def unused(text: str, dialect: str = "fanuc") -> list[tuple[int, str]]:
    return [(u.line, u.word) for u in interpret(text, dialect, SURVEY).unused]


@pytest.mark.parametrize(
    ("dialect", "text", "where"),
    [
        ("fanuc", "G0 X1. Q5.\nM30", ":1:8: .*\"Q\""),
        ("haas", "G54 P3\nM30", ":1:5: .*\"P\""),
        ("grbl", "M3 S1000 P100\nM30", ":1:10: .*\"P\""),
        ("haas-lathe", "S900 M3 G0 X3. Z.1\nG71 P1 Q2 U.02 W.01 D.1 I1. F.01\nN1 G0 X1.\nG1 Z-1.\nN2 X2.\nM30", ":2:25: .*\"I\""),
        ("fanuc", "G0 Z5.\nG81 X1. Y0. Z-2. R1. Q1. F100.\nM30", ":2:22: .*\"Q\""),
        ("fanuc", "M8 P5\nM30", ":1:4: .*\"P\""),
    ],
)  # fmt: skip
def test_the_strict_level_refuses_a_word_that_nothing_uses(dialect: str, text: str, where: str):
    with pytest.raises(DataError, match=where):
        interpret(text, dialect)
    assert len(unused(text, dialect)) == 1


def test_every_one_is_kept_and_each_letter_told_once():
    text = "G0 X1. Q5.\nX2. Q5. K2.\nM30"
    assert unused(text) == [(1, "Q5."), (2, "Q5."), (2, "K2.")]
    told = [w for w in interpret(text, "fanuc", SURVEY).warnings if "nothing in this block" in w.text]
    assert [(w.line, w.text.split('"')[1]) for w in told] == [(1, "Q"), (2, "K")]


def test_h_and_d_stay_in_force():
    # FANUC: H and D are modal; G43 and G41 without them take the last ones
    tools = {1: Tool(1, 10.0, 8.0), 2: Tool(2, 30.0, 4.0)}
    setup = Setup(tools=tools)
    moves = interpret("G0 X0. Y0. H2\nG43 Z50.\nM30", "fanuc", setup).moves
    assert moves[-1].tool_offset == (0.0, 0.0, 30.0)
    text = "T1 M6\nG21 F100.\nG0 X-20. Y-20. D2\nG41 G1 X0. Y0.\nY20.\nG40 X-20.\nM30"
    at = [m.end[0] for m in interpret(text, "fanuc", setup).moves if m.compensation]
    assert at[-1] == pytest.approx(-2.0)  # to the left of Y+ by the radius of tool 2, 2 mm


def test_the_command_says_them_with_the_answer_and_before_the_tables(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
):
    program = tmp_path / "p.nc"
    program.write_text("O1\nG0 X1. Q5.\nX2. Q5.\nM30\n", encoding="utf-8")
    assert run(["nc", str(program), "--dialect", "fanuc"]) == 0
    said = capsys.readouterr().out
    assert "Q5." in said
    # the answer comes first and counts them; the list of them stands above the tables
    assert "Words that nothing uses: 2 times: passed over" in said
    assert said.index("words that nothing uses, ") < said.index("p.nc: 2 moves")
    assert said.count("p.nc:2:8") == 1
    assert run(["nc", str(program), "--dialect", "fanuc", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["unused"]
    assert [(u["line"], u["word"]) for u in found] == [(2, "Q5."), (3, "Q5.")]
    assert run(["nc", str(program), "--dialect", "fanuc", "--strict"]) == 2
    assert "p.nc:2:8" in capsys.readouterr().err


def test_rounded_arcs_are_told_in_one_line():
    # radii by hand: (10.002, 0) and (0, 10) from 0: 2 um apart; (10.003, 0): 3 um
    arc = "G1 X{0} Y0\nG3 X0 Y10 I-{0} J0\n"
    text = "G21 F100\nG0 X0 Y0\n" + arc.format(10.002) + arc.format(10.003) + arc.format(10.002) + "M2"
    told = [w for w in interpret(text, "linuxcnc").warnings if "radii" in w.text]
    assert [w.line for w in told] == [4]
    assert told[0].text.startswith(
        "3 arcs have radii at start and end that differ by more than 1 um, by 3.0 um at most (line 6)"
    )
    assert told[0].text.endswith("lines 4, 6, 8")
    alone = interpret("G21 F100\nG0 X0 Y0\n" + arc.format(10.002) + "M2", "linuxcnc").warnings
    assert "differ by 2.0 um (10.0020 and 10.0000 mm)" in alone[-1].text
