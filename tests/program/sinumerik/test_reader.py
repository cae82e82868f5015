"""Sinumerik programs: what is refused, and samples."""

from __future__ import annotations

import numpy as np
import pytest

from tests.program.sinumerik.programs import SURVEY, moves, sample
from vcmm.core.errors import DataError
from vcmm.program.setup import Setup
from vcmm.program.sinumerik.reader import read


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("G1 X1 F100\nBSPLINE X5", r"part.mpf:2:1: BSPLINE \(spline\)"),
        ("G0 X1\nG33 Z5 K1", "part.mpf:2:1: G33"),
        ("G0 X1\n  CALL_ME(3)", "part.mpf:2:3: CALL_ME is neither a subprogram"),
        ("G1 X=depth F1", "part.mpf:1:6: the variable DEPTH is not defined"),
        ("DEF REAL depth\nX=depht", 'Did you mean "DEPTH"'),
        ("G1 X5", "part.mpf:1:1: no feed"),
        ("G0 X5 X6", "part.mpf:1:7: X appears twice"),
        ("IF R1==1\nG0 X1", "part.mpf:1:1: this is never closed; add ENDIF"),
        ("ENDWHILE", "closes nothing"),
        ("GOTOF FINE\nM30\nFIN: M30", 'there is no FINE further down.*Did you mean "FIN"'),
        ("G41 G1 X5 F100", "no known radius; state its diameter"),
        ("T1 D2", "part.mpf:1:4: D2"),
        ("G0 X=1/0", "part.mpf:1:7: division by zero"),
        ("G0 U5", "part.mpf:1:4: the address U is not understood"),
        ("X=", "the end of the line"),
        ("X1 )", r"part.mpf:1:4: \"\)\" cannot be understood"),
        ("G0\nAA: X1 REPEATB AA", "the repeated part holds its own REPEAT"),
        ("LOOP\nENDLOOP", "part.mpf:1:1: this loop is endless"),
        ("G1 F100\nLOOP\nR1=R1+1\nG1 X=R1\nENDLOOP\nM30", "part.mpf:2:1: this loop is endless"),
        ("LOOP\nIF R1>1 GOTOF OUT\nENDLOOP\nOUT: M30", "1000 blocks have been executed again; the program seems"),
        ("DEF TEXT name", "takes REAL, INT, BOOL"),
        ("G0 $AA_OFF[X]=5", "system variables"),
        ("T1 D1\nG41 G1 X9 F9\nTRANS X1", "part.mpf:3:1: a frame .* while radius compensation is on"),
        ("G2 X10 Y0 I5 J0 F100\nROT X30\nG2 X0 Y0 I-5 J0", "an arc of the plane XY under a rotation out of that plane"),
    ],
)  # fmt: skip
def test_refused_by_name_and_place(text, message, monkeypatch):
    monkeypatch.setattr("vcmm.program.sinumerik.flow.LONGEST", 1000)
    with pytest.raises(DataError, match=message):
        moves(text)


def test_a_loop_without_motion_is_found_endless_sooner(monkeypatch):
    monkeypatch.setattr("vcmm.program.sinumerik.flow.IDLE", 500)
    counting = "R1=0\nWHILE R1<{}\nR1=R1+1\nENDWHILE\nG0 X1\n"
    with pytest.raises(DataError, match="500 blocks have been executed again without a motion"):
        moves(counting.format(400))
    assert len(moves(3 * counting.format(100))) == 3  # 900 blocks, but moves between


def test_a_loop_that_is_left_or_never_entered_is_read():
    assert len(moves("LOOP\nR1=R1+1\nG0 X=R1\nIF R1>3 GOTOF OUT\nENDLOOP\nOUT: M30")) == 4
    assert len(moves("IF R1==1\nLOOP\nG0 X=5\nENDLOOP\nENDIF\nG0 X1\nM30")) == 1


def test_sample_arcs():
    got = moves(sample("arc"))
    assert [m.kind for m in got] == ["line", "arc", "line", "arc", "arc", "line", "arc"]
    assert np.allclose(got[-1].centre, (80, 60, 10))  # CR=20 over a chord of 40: a half circle
    assert got[4].end == (0, 0, 10)


def test_sample_splines_are_refused():
    with pytest.raises(DataError, match=r"part.mpf:10:1: BSPLINE"):
        moves(sample("spline"))


def test_plain_lines_mean_what_they_mean_word_by_word(monkeypatch):
    """The short way for plain lines gives the moves, sources and feeds of the long way, in and out of what forbids it."""
    rng = np.random.default_rng(7)
    specials = [
        "G91",
        "G90",
        "G41",
        "G40 X99",
        "MCALL CYCLE81(9,0,1,-1)",
        "MCALL",
        "DIAMON",
        "DIAMOF",
        "G70",
        "G71",
        "G9 X1",
        "TRANS X5",
        "R1=3",
        "G64",
    ]
    lines = ["T1", "G0 X0 Y0 Z10 F300"]
    for k in range(400):
        axes = " ".join(f"{a}{rng.uniform(-50, 50):.3f}" for a in "XYZ" if rng.random() < 0.6) or "X1."
        feed = f"F{rng.integers(100, 900)}" if rng.random() < 0.2 else ""
        lines.append(
            f"{f'N{k} ' if k % 3 else ''}{rng.choice(['G0 ', 'G1 ', 'G01', '', ''])}{axes} {feed}{' ; note' if k % 7 == 0 else ''}"
        )
        if rng.random() < 0.08:
            lines.append(str(rng.choice([s for s in specials if s not in ("G41", "G40 X99")])))
    text = "\n".join(lines)
    short = moves(text, SURVEY)
    monkeypatch.setattr("vcmm.program.sinumerik.sections.plain_block", lambda text, line: None)
    assert moves(text, SURVEY) == short
    assert len(short) > 400


def test_plain_lines_under_compensation():
    text = "T1\nG0 X0 Y0 Z5\nG41 G1 X20 Y0 F100\nX40\nY30\nG40 X60"
    assert [m.compensation for m in moves(text)] == [None, "left", "left", "left", None]


def test_text_behind_the_end_is_told():
    program = read("G54 G0 X10\nM30\nG0 X500\n", "p.mpf", Setup())
    assert [m.end[0] for m in program.moves] == [10.0]
    assert [(r.line, r.text[:42]) for r in program.warnings][-1] == (
        3,
        "the text after the end of the program is n",
    )
    jump = read("G54 G0 X10\nGOTOF BACK\nOVER: M30\nBACK: G0 X20\nGOTOB OVER\n", "p.mpf", Setup())
    assert not any("text after the end" in r.text for r in jump.warnings)
