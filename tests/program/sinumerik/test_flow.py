"""Variables, loops, jumps, subprograms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.program.sinumerik.programs import SETUP, SURVEY, check, ends, moves, sample, told
from vcmm.core.errors import DataError
from vcmm.program.setup import Setup
from vcmm.program.sinumerik.reader import read


def test_parameters_and_variables():
    check("DEF REAL a_1=2, b_1\nDEF INT nn\nnn=2.6\nb_1=a_1*2 R[5]=7 G0\nX=a_1 Y=b_1 Z=R5+nn", (2, 4, 10))


def test_control_structures():
    loop = "R1=0 G0\n{}\nR1=R1+1\nX=R1\n{}"
    for head, tail in (
        ("WHILE R1<3", "ENDWHILE"),
        ("REPEAT", "UNTIL R1>=3"),
        ("LOOP\nIF R1>2 GOTOF OUT", "ENDLOOP\nOUT: ;"),
    ):
        check(loop.format(head, tail), (1, 0, 0), (2, 0, 0), (3, 0, 0))
    check("G0\nFOR R1=1 TO 3\nX=R1\nENDFOR", (1, 0, 0), (2, 0, 0), (3, 0, 0))
    branch = "R1={} G0\nIF R1==1\nX1\nELSE\nIF R1==2\nX2\nENDIF\nY3\nENDIF"
    check(branch.format(1), (1, 0, 0))
    check(branch.format(2), (2, 0, 0), (2, 3, 0))
    check(branch.format(5), (0, 3, 0))
    case = "R1={} G0\nCASE R1 OF 1 GOTOF A_A 2 GOTOF B_B DEFAULT GOTOF C_C\nA_A: X1\nB_B: X2\nC_C: X3"
    assert [len(ends(case.format(n))) for n in (1, 2, 7)] == [3, 2, 1]


def test_jumps_and_repeated_parts():
    check("G0\nGOTOF N40\nX1\nN40 X2\nGOTOC NOWHERE\nX3", (2, 0, 0), (3, 0, 0))
    check("G0 G91\nPART: X1\nX2\nREPEAT PART P=2", *[(v, 0, 0) for v in (1, 3, 4, 6, 7, 9)])
    check("G0 G91\nONE: X1\nX2\nREPEATB ONE P2", *[(v, 0, 0) for v in (1, 3, 4, 5)])
    check("G0 G91\nAA: X1\nBB: X2\nX4\nREPEAT AA BB", *[(v, 0, 0) for v in (1, 3, 7, 8, 10)])


def test_subprograms_of_the_same_file():
    check("G0\nSLOT(5, 7)\nX0\nM30\nPROC SLOT(REAL xx, REAL yy)\nX=xx Y=yy\nRET\n", (5, 7, 0), (0, 7, 0))
    check("%_N_MAIN_MPF\nG0\nL100\nX0\nM30\n%_N_L100_SPF\nX9\nM17", (9, 0, 0), (0, 0, 0))


def test_block_skip():
    from dataclasses import replace

    assert len(moves("G0 X1\n/X2\nX3")) == 3
    assert len(moves("G0 X1\n/X2\nX3", replace(SETUP, block_delete=True))) == 2


def test_sample_jumps_loops_frames():
    assert [m.end[0] for m in moves(sample("goto"))] == [0, 30, 40, 50]
    # 101 rows of 1 mm from 950 to 1050, two moves each, and three moves before them
    assert len(moves(sample("loop"))) == 3 + 2 * 101
    assert np.allclose(
        ends(sample("trans_reset")), [(1, 1, 0), (102, 22, 0), (13, 3, 0), (4, 4, 0), (55, 5, 0), (6, 6, 0)]
    )


def test_skip_levels_and_words_behind_a_message():
    """/2 is one of ten switches; the text of MSG ends with its bracket."""
    text = 'G1 X10 F100\n/2 X20\n/ X30\nMSG("A (B) M30") X40\n'
    setup = Setup(offsets={"G54": (0.0, 0.0, 0.0)})
    assert [m.end[0] for m in read(text, "part.mpf", setup).moves] == [10, 20, 30, 40]
    skipping = replace(setup, block_delete=True)
    assert [m.end[0] for m in read(text, "part.mpf", skipping).moves] == [10, 40]


def test_subprograms_with_arguments_repetitions_and_modal_calls(tmp_path):
    """L140(2), L70 P3, CALL "NAME", MCALL L70: files beside the program; VAR gives back; SAVE keeps the caller's modes."""
    (tmp_path / "L140.SPF").write_text("PROC L140(INT HEAD) SAVE\nG91 G0 X=HEAD\nTRANS X100\nM17")
    (tmp_path / "l70.spf").write_text("G91 G1 Z-1 F100\nG90\nM17")
    (tmp_path / "TWICE.SPF").write_text("PROC TWICE(VAR REAL WHAT, REAL ADD=1)\nWHAT=2*WHAT+ADD\nRET")
    main = 'EXTERN L140(INT)\nDEF REAL AA=3\nR1=5\nL140(2)\nG0 X3\nL70 P3\nTWICE(AA,4)\nTWICE(R1)\nG0 X=AA Y=R1\nCALL "TWICE"\nMCALL L70\nG0 X0 Y0 Z0\nMCALL'
    (tmp_path / "MAIN.MPF").write_text(main)
    program = read(main, str(tmp_path / "MAIN.MPF"), SETUP)
    assert [m.end for m in program.moves] == [
        (2, 0, 0), (3, 0, 0), (3, 0, -1), (3, 0, -2), (3, 0, -3), (10, 11, -3), (0, 0, 0), (0, 0, -1),
    ]  # fmt: skip
    assert program.moves[2].source.line == 1


def test_missing_subprograms_are_holes_told_once():
    text = 'L140(2) ;HEAD\nSPEC_UGV\nMSG("A"<<R1)\nprintln("X")\nSPEC_UGV\nCYCLE95("CONTOUR",1)\nG0 X1'
    hole = "a hole in the path: its moves are missing"
    assert told(text) == {
        "the subprogram L140": (1, hole), "the subprogram SPEC_UGV": (2, hole), "the subprogram PRINTLN": (4, hole), "the contour CONTOUR of CYCLE95": (6, hole),
    }  # fmt: skip
    assert len(moves(text, SURVEY)) == 1


@pytest.mark.thorough
def test_a_subprogram_on_its_own():
    """Its arguments are zero and told; blocks that then have no value are passed over; loops that then never end are left."""
    text = "PROC SIDE(REAL DEP, INT COUNT=2) DISPLOF\nR1=10/DEP\nG0 X=COUNT\nUP:\nIF DEP<5 GOTOB UP\nRET"
    assert [m.end[0] for m in moves(text, SURVEY)] == [2]
    got = told(text)
    assert got["the argument DEP of the subprogram SIDE"] == (1, "0")
    assert "blocks that hang on values which only the caller or the machine knows" in got
    assert any(what.startswith("the end of a loop") for what in got)
    with pytest.raises(DataError, match="there is no NOWHERE"):  # a missing label is the program's own fault
        moves("PROC SIDE(REAL DEP)\nGOTOF NOWHERE", SURVEY)


def test_several_jumps_in_a_line():
    text = "R1=2\nIF R1==1 GOTOF A_1 IF R1==2 GOTOF A_2\nG0 X9\nA_1: G0 X1\nA_2: G0 X2"
    assert [m.end[0] for m in moves(text)] == [2]


def test_synchronised_actions_and_alarms_are_told():
    assert told("ID=1 WHENEVER $A_IN[1] DO OVR=0\nWHEN TRUE DO M8\nSETAL(66000)\nG0 X1") == {
        "synchronised actions (WHENEVER, DO ...)": (1, "passed over"),
        "an alarm that the program raises itself (SETAL)": (3, "passed over"),
    }


def test_axes_and_edges_that_are_not_modelled():
    assert told("T1 D3\nG0 X1 W5 U=2 M31=101 H5=2") == {
        "the cutting edge D3 of tool 1": (1, "that of D1"), "the axis or spindle W": (2, "passed over"),
        "the axis or spindle U": (2, "passed over"),
    }  # fmt: skip
