"""Variables, loops, jumps, subprograms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.nc.sinumerik.programs import SETUP, check, ends, moves, sample
from vcmm.nc.setup import Setup
from vcmm.nc.sinumerik.reader import read


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
