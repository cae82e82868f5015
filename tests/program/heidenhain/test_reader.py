"""Klartext programs: parameters, labels, jumps, ends, what is refused, and samples."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.program.heidenhain.klartext import SETUP, check, ends, moves, sample
from vcmm.core.errors import DataError
from vcmm.program.heidenhain.reader import read
from vcmm.program.setup import Setup


def test_q_parameters():
    text = (
        "FN 0: Q1 = +5\nFN 1: Q2 = +Q1 + +5\nFN 4: Q3 = +Q2 DIV +4\nFN 8: Q4 = +3 LEN +4\nFN 13: Q5 = +1 ANG-1\nFN 5: Q6 = SQRT 16\n"
        "FN 2: Q7 = +Q1 - +1\nFN 3: Q8 = +Q1 * +3\nL X+Q1 Y+Q2 Z-Q3 FMAX\nL X+Q4 Y+Q5 Z+Q6 FMAX\nL X+Q7 Y+Q8 FMAX"
    )
    check(text, (5, 10, -2.5), (5, 135, 4), (4, 15, 4))


def test_labels():
    check("CALL LBL 1\nL X+9 FMAX\nM30\nLBL 1\nL IX+1 FMAX\nLBL 0", (1, 0, 0), (9, 0, 0))
    check(
        'LBL "A"\nL IX+1 FMAX\nCALL LBL "A" REP 2/2\nL Y+5 FMAX', (1, 0, 0), (2, 0, 0), (3, 0, 0), (3, 5, 0)
    )
    jump = "Q1 = {}\nFN 9: IF +Q1 EQU +1 GOTO LBL 7\nL X+1 FMAX\nLBL 7\nL Y+1 FMAX"
    assert [len(ends(jump.format(n))) for n in (1, 2)] == [1, 2]
    loop = "LBL 3\nQ1 = Q1 + 1\nL X+Q1 FMAX\nFN 12: IF +Q1 LT +3 GOTO LBL 3"
    check(loop, (1, 0, 0), (2, 0, 0), (3, 0, 0))


def test_present_position():
    check("L X+7 FMAX\nFN 18: SYSREAD Q3 = ID270 NR1 IDX1\nL Y+Q3 FMAX", (7, 0, 0), (7, 7, 0))


def test_end_of_program():
    assert len(moves("L X+1 FMAX\nL X+2 FMAX M30\nL X+3 FMAX")) == 2


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("CYCL DEF 263 THREAD MILLING", "part.h:2:10: Cycle 263 is not understood"),
        ("CYCL DEF 251 RECTANGULAR POCKET", "part.h:2:10: cycle 251 has no Q218"),
        ("CALL PGM OTHER.H", "CALL PGM OTHER.H: there is no such file"),
        ("FN 18: SYSREAD Q1 = ID50 NR3 IDX1", "ID50 NR3 IDX1 is known to the machine only"),
        ("FN 14: ERROR = 1000", "FN 14 is not understood"),
        ("L X+1", "part.h:2:1: no feed"),
        ("L X+1 X+2 FMAX", "part.h:2:7: X appears twice"),
        ("L X FMAX", "part.h:2:5: X needs a number"),
        ("L X+1 LEN5 FMAX", "part.h:2:7: LEN is not understood"),
        ("CC X+0 Y+5\nC X+5 Y+5 F100", "needs the sense of rotation"),
        ("CC X+0 Y+5\nC X+6 Y+5 DR+ F100", "radius 5.0000 mm at its start, 6.0000 mm at its end"),
        ("CALL LBL 5", "there is no LBL 5"),
        ("LBL 1\nLBL 1", "part.h:3:1: LBL 1 appears twice"),
        ("LBL 1\nFN 9: IF +1 EQU +1 GOTO LBL 1", "seems to be endless"),
        ("CYCL CALL", "none is defined"),
        ("Q1,5 = 3", "Q1,5 is no Q parameter"),
        ("L X+1 RL F100", "no known radius"),
        ("Q1 = 1 / 0", "part.h:2:8: division by zero"),
        ("CT X+5 Y+5 F100", "needs a contour element before it"),
        ("APPR LT X+0 Y+0 LEN10 F100", "APPR needs the side of the tool"),
        ("CYCL DEF 10.0\nCYCL DEF 10.1 ROT+30\nCYCL DEF 7.0\nCYCL DEF 7.1 X+5", "shift first, then rotate"),
    ],
)  # fmt: skip
def test_refused_by_name_and_place(text, message, monkeypatch):
    monkeypatch.setattr("vcmm.program.heidenhain.reader.LONGEST", 1000)
    with pytest.raises(DataError, match=message):
        moves(text)


def test_sample_from_a_cam_system():
    program = read(sample("metrologia_11"), "part.h", Setup())
    lines = sample("metrologia_11").count(" L ") - 2  # two of them hold nothing but M03
    arcs = sample("metrologia_11").count(" C X")
    assert len([m for m in program.moves if m.kind in ("rapid", "line")]) == lines
    assert len([m for m in program.moves if m.kind == "arc"]) == arcs
    assert [m.seconds for m in program.moves if m.kind == "dwell"] == [5.0, 5.0]
    assert all(np.allclose(a.end, b.start) for a, b in pairwise(program.moves) if a.tool == b.tool)


@pytest.mark.parametrize("end", ["STOP M30", "STOP M2", "M30", "L FMAX M2"])
def test_the_program_ends_where_it_says(end):
    """STOP with M2 or M30 ends the program as a block of its own does: what follows is not run."""
    (one,) = moves(f"L X+10 F100\n{end}\nLBL 1\nL X+99\nLBL 0")[:1]
    assert one.end == (10, 0, 0)
    assert all(m.end[0] == 10.0 for m in moves(f"L X+10 F100\n{end}\nLBL 1\nL X+99\nLBL 0"))


def test_a_stop_without_an_end_goes_on():
    assert [m.end[0] for m in moves("L X+10 F100\nSTOP M5\nL X+99\nSTOP\nL X+0")] == [10, 99, 0]


def survey(text):
    program = read(f"BEGIN PGM T MM\n{text}\nEND PGM T MM\n", "part.h", replace(SETUP, strict=False))
    return program, {a.what: (a.line, a.value) for a in program.assumed}


def test_structure_lines_and_long_comments_are_no_blocks():
    """TNC 640, "Structuring programs": `* - text`; a comment block goes on with ~ up to the next block number."""
    check("1 * - MILL X+99\n* - DRILL\n2 ;a long~\n comment about L X+5~\n the rest\n3 L X+1 FMAX", (1, 0, 0))
    check("5 ;ends here~\n6 L X+2 FMAX", (2, 0, 0))


def test_a_survey_names_what_only_the_machine_knows_once():
    program, told = survey(
        'TCH PROBE 421 MEASURE HOLE\nQ5 = Q150 + 2\nL X+Q5 FMAX\nL X+Q5 Y+Q150 FMAX\nFN 16: F-PRINT A / B\nSEL TABLE "X"'
    )
    assert [m.end for m in program.moves] == [(2, 0, 0), (2, 0, 0)]
    assert list(told) == ["TCH PROBE 421", "the value of Q150", "FN 16: F-PRINT", "SEL TABLE"]
    assert told["the value of Q150"] == (3, "0")


def test_a_position_without_l_is_read_as_one():
    program, told = survey("Z+5 FMAX\nX+10 F200")
    assert [m.end for m in program.moves] == [(0, 0, 5), (10, 0, 5)]
    assert "a position without L" in told
    with pytest.raises(DataError, match="without L before it"):
        moves("Z+5 FMAX")


def test_missing_programs_and_cycles_are_holes():
    program, told = survey("CALL PGM TNC:\\\\X\\\\SUB.H\nCYCL DEF 263 THREAD\nL X+3 FMAX M99\nL X+4 FMAX M99")
    hole = "a hole in the path: its moves are missing"
    assert told == {
        "the program SUB.H": (2, hole),
        "cycle 263": (4, hole),
    }
    assert [m.end[0] for m in program.moves] == [3, 4]


def test_a_program_beside_is_called_with_the_parameters(tmp_path):
    (tmp_path / "SUB.H").write_text("BEGIN PGM SUB MM\nL X+Q1 FMAX\nQ1 = Q1 + 1\nEND PGM SUB MM\n")
    main = "BEGIN PGM T MM\nQ1 = 5\nCALL PGM sub\nCYCL DEF 12.0 PGM CALL\nCYCL DEF 12.1 PGM SUB.H\nL Y+2 FMAX M99\nEND PGM T MM\n"
    (tmp_path / "T.H").write_text(main)
    program = read(main, str(tmp_path / "T.H"), replace(SETUP, strict=False))
    assert [m.end for m in program.moves] == [(5, 0, 0), (5, 2, 0), (6, 2, 0)]
    (tmp_path / "SUB.H").write_text("CALL PGM SUB\n")
    with pytest.raises(DataError, match=r"does SUB(\.H)? call itself"):
        read(main, str(tmp_path / "T.H"), SETUP)


def test_an_arc_whose_start_nobody_knows_is_told():
    program, told = survey("CC X+0 Y+0\nL Y+0 F100\nC DR+\nL Y-10")
    assert [m.kind for m in program.moves] == ["line", "line", "line"]
    assert "the start position, from which an arc is programmed" in told
    with pytest.raises(DataError, match="radius zero"):  # both axes are known here: it is the program's fault
        survey("CC X+0 Y+0\nL X+0 Y+0 F100\nC DR+")


def test_fn_14_ends_the_program():
    program, told = survey("L X+1 FMAX\nFN 14: ERROR = 1000\nL X+2 FMAX")
    assert len(program.moves) == 1
    assert told["an error that the program raises itself (FN 14)"][1] == "the program ends there"


def test_words_without_use_are_told_and_tools_that_nobody_knows_can_be_given():
    program, told = survey("TOOL CALL 77 Z S100\nCC X+0 Y+0\nL X+10 Y+0 F100\nC X-10 Y+0 A+5 DR+\nM8 X+3")
    assert [(u.line, u.word) for u in program.unused] == [(5, "A+5")]
    assert told["tool 77"] == (2, "a tool without length")
    assert next(a.blank for a in program.assumed if a.what == "tool 77").table == "tools.77"
    assert program.moves[-1].end[0] == 3
    with pytest.raises(DataError, match=r'part.h:4:\d+: nothing in this block uses the word "A"; remove it'):
        moves("CC X+0 Y+0\nL X+10 Y+0 F100\nC X-10 Y+0 A+5 DR+")


def test_plain_lines_mean_what_they_mean_word_by_word(monkeypatch):
    """The short way for plain lines gives the moves, sources and feeds of the long way."""
    rng = np.random.default_rng(8)
    specials = [
        "CYCL DEF 7.0\nCYCL DEF 7.1 X+5",
        "L M3",
        "M89",
        "L X+1 M99",
        "CC X+0 Y+0",
        "L IX+3 F200",
        "L X+5 Y+5 R0 F100 M8",
        "L F150",
        "CT X+9 Y+9 F80",
        "M136",
        "M137",
    ]
    lines = ["TOOL CALL 5 Z S1000", "CYCL DEF 201 Q200=2 Q201=-1 Q206=9 Q203=+0", "L X+0 Y+0 Z+10 F300"]
    for k in range(300):
        axes = " ".join(f"{a}{rng.uniform(-50, 50):+.3f}" for a in "XYZ" if rng.random() < 0.6) or "X+1"
        lines.append(
            f"{k if k % 3 else ''} L {axes} {rng.choice(['FMAX', 'F250', '', ''])}{' ;note' if k % 11 == 0 else ''}"
        )
        if rng.random() < 0.08:
            lines.append(str(rng.choice(specials)))
    text = "M3\n" + "\n".join(lines)
    short = survey(text)[0].moves
    monkeypatch.setattr("vcmm.program.heidenhain.text.plain_block", lambda text, number: None)
    assert survey(text)[0].moves == short
    assert len(short) > 300


def test_splines_and_conditions_on_texts_are_told():
    program, told = survey(
        'SPL X+10 Y+5 K3X+1 K2X+1 K1X+1 F200\nFN 9: IF QS1 EQU "A" GOTO LBL 1\nL X+3 FMAX\nLBL 1'
    )
    assert [m.end[:2] for m in program.moves] == [(10, 5), (3, 5)]
    assert {"splines (SPL)", "a condition on texts"} <= told.keys()


def test_a_repetition_with_its_label_behind_the_call_is_a_jump_and_told():
    text = "BEGIN PGM A MM\nCALL LBL 1 REP 2\nL X+1 FMAX\nLBL 1\nL IX+5 FMAX\nL Y+9 FMAX\nEND PGM A MM\n"
    program = read(text, "a.h", Setup(strict=False))
    assert [m.end[:2] for m in program.moves] == [(5, 0), (5, 9)]
    assert [(a.line, a.what) for a in program.assumed] == [(2, "CALL LBL REP with its label behind it")]
