"""Programs of Sinumerik 840D sl, each worked out by hand (Programming Manual Fundamentals and Job Planning)."""

from __future__ import annotations

import pytest

from tests.program.pencil import check

PROGRAMS = {
    "AC and IC, and G91": (
        "G71 G90 G17 G54\nG0 X10 Y=IC(5)\nG1 Z-2 F100\nG91 X5 Y=AC(0)\nG90 X0\nM30",
        "R 10 5 0; L . . -2; L 15 0 .; L 0 . .",
    ),
    "arcs by centre, by CR, by AR, and by a point between": (
        "G90 G17\nG0 X10 Y0\nG3 X0 Y10 I-10 J0 F100\nG2 X-10 Y20 CR=10\nG2 AR=180 I=AC(-15) J=AC(20)\nCIP X-40 Y20 I1=-30 J1=30\nM30",
        "R 10 0 0; A 0 10 . (0 0 +); A -10 20 . (0 20 -); A -20 20 . (-15 20 -)\nA -40 20 . (-30 20 +)",
    ),
    "TRANS, then AROT by 90 degrees": (
        "G90 G17\nTRANS X10 Y20\nG1 X5 Y0 F100\nAROT RPL=90\nX5 Y0\nX5 Y5\nTRANS\nX0 Y0\nM30",
        "L 15 20 0; L 10 25 .; L 5 25 .; L 0 0 .",
    ),
    "MIRROR turns an arc round, SCALE makes it larger": (
        "G90 G17\nMIRROR X0\nG1 X10 Y0 F100\nG3 X0 Y10 CR=10\nMIRROR\nSCALE X2 Y2\nG1 X5 Y5\nSCALE\nX0 Y0\nM30",
        "L -10 0 0; A 0 10 . (0 0 -); L 10 10 .; L 0 0 .",
    ),
    "MCALL CYCLE81: retract 20, surface 0, clearance 2, depth 5": (
        "G90 G17 F100\nG0 Z30\nMCALL CYCLE81(20,0,2,-5)\nX10 Y0\nX20\nMCALL\nX0\nM30",
        "R 0 0 30; R 10 . .; R . . 2; L . . -5; R . . 20; R 20 . .; R . . 2; L . . -5; R . . 20; R 0 . .",
    ),
    "CYCLE82 with DPR and a dwell": (
        "G90 G17 F100\nG0 X1 Y1 Z10\nCYCLE82(10,0,1,,4,0.5)\nM30",
        "R 1 1 10; R . . 1; L . . -4; D 0.5; R . . 10",
    ),
    "HOLES2: four holes on a circle of 10 mm about (50, 0) from 0 degrees": (
        "G90 G17 F100\nG0 X50 Y0 Z10\nMCALL CYCLE81(10,0,1,-2)\nHOLES2(50,0,10,0,90,4)\nMCALL\nM30",
        "R 50 0 10; R 60 0 .; R . . 1; L . . -2; R . . 10; R 50 10 .; R . . 1; L . . -2; R . . 10; R 40 0 .; R . . 1; L . . -2; R . . 10; "
        "R 50 -10 .; R . . 1; L . . -2; R . . 10",
    ),
    "HOLES1: three holes in a line at 30 degrees from (5, 0), 10 mm to the first, 10 apart": (
        "G90 G17 F100\nG0 X0 Y0 Z10\nMCALL CYCLE81(10,0,1,-2)\nHOLES1(5,0,30,10,10,3)\nMCALL\nM30",
        "R 0 0 10; R 13.6603 5 .; R . . 1; L . . -2; R . . 10; R 22.3205 10 .; R . . 1; L . . -2; R . . 10; R 30.9808 15 .; R . . 1; "
        "L . . -2; R . . 10",
    ),
    "polar coordinates about a pole": (
        "G90 G17\nG111 X10 Y10\nG0 AP=0 RP=10\nG1 AP=90 F100\nG3 AP=180 RP=10\nM30",
        "R 20 10 0; L 10 20 .; A 0 10 . (10 10 +)",
    ),
    "a counting loop, a jump, a condition": (
        "G90 G17\nDEF INT kk\nFOR kk=1 TO 3\nIF kk==2 GOTOF SKIP\nG1 X=10*kk F100\nSKIP: Y=kk\nENDFOR\nM30",
        "L 10 0 0; L . 1 .; L . 2 .; L 30 . .; L . 3 .",
    ),
    "REPEAT of a part between labels, twice more": (
        "G91 G17 F100\nBEGIN: G1 X5\nY1\nEND_IT: G4 F0.5\nREPEAT BEGIN END_IT P=2\nM30",
        "L 5 0 0; L . 1 .; D 0.5; L 10 . .; L . 2 .; D 0.5; L 15 . .; L . 3 .; D 0.5",
    ),
    "a subprogram with an argument, called three times": (
        "G90 G17\nL10 P2\nSTEP(7)\nM30\nPROC L10\nG91 G1 X5 F100\nG90\nRET\nPROC STEP(REAL way)\nG1 Y=way F100\nRET",
        "L 5 0 0; L 10 . .; L . 7 .",
    ),
    "a rounded corner and a chamfer by its width": (
        "G90 G17\nG1 X20 RND=5 F100\nY20 CHR=3\nX0\nM30",
        "L 15 0 0; A 20 5 . (15 5 +); L . 17 .; L 17 20 .; L 0 . .",
    ),
    "inches: G70 counts lengths, G700 the feed too": (
        "G90 G17 G70\nG0 X1 Y0.5\nG71\nX0 Y0\nG700 G1 X2 F1\nM30",
        "R 25.4 12.7 0; R 0 0 .; L 50.8 . .",
    ),
    "heights of cycles in inches: RTP 2 = 50.8, RFP 0.5 = 12.7, SDIS 0.1 = 2.54 above it, DP -0.5 = -12.7, DPR 0.25 = 6.35 below RFP": (
        "G90 G17 G70 F100\nG0 X0 Y0 Z3\nCYCLE81(2,0.5,0.1,-0.5)\nX1\nCYCLE82(2,0.5,0.1,,0.25)\nM30",
        "R 0 0 76.2; R . . 15.24; L . . -12.7; R . . 50.8; R 25.4 . .; R . . 15.24; L . . 6.35; R . . 50.8",
    ),
    "G55 as set up, G500 none, SUPA the machine": (
        "G90 G17 G55\nG0 X0 Y0 Z0\nSUPA Z0\nG500 X1\nM30",
        "R 100 50 -10; R . . 0; R 1 . .",
    ),
    "a helix with one whole turn and a quarter": (
        "G90 G17\nG0 X10 Y0\nG3 X0 Y10 Z-5 I-10 J0 TURN=1 F100\nM30",
        "R 10 0 0; A 0 10 -5 (0 0 +)",
    ),
    "radius compensation right along a corner, round outside": (
        "G90 G17 T1 D1\nM6\nG0 X-20 Y20\nG42 G1 X0 Y0 F100\nX30\nG40 Y-30\nM30",
        "R -20 20 0; L 0 -5 .; L 30 . .; L . -30 .",
    ),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_means_what_was_worked_out_by_hand(name: str):
    check("sinumerik", *PROGRAMS[name])
