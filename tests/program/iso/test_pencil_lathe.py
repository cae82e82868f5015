"""Programs of Fanuc and Haas lathes, Mazak and Okuma, worked out by hand from the manuals (B-64304EN-1; Haas lathe; OSP).

X of the points is a radius, as in every move; Y is always 0.
"""

from __future__ import annotations

import pytest

from tests.program.pencil import check, found
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

SETUP = Setup(tools={1: Tool(1, 0.0, shape="turning"), 2: Tool(2, 0.0, shape="turning")}, strict=False)
LATHE = {
    "X counts diameters, U and W increments": (
        "G21 T0101\nS800 M3\nG0 X50. Z2.\nG1 Z-10. F.2\nU10.\nW-5.\nG0 X60. W7.\nM30",
        "R 25 0 2; L . . -10; L 30 . .; L . . -15; R 30 . -8",
    ),
    "a quarter by R and by I K": (
        "G21 T0101\nS800 M3\nG0 X0 Z0\nG3 X20. Z-10. R10. F.1\nG2 X30. Z-15. I5. K0.\nM30",
        "A 10 0 -10 (-10 0 +); A 15 0 -15 (-10 15 -)",
    ),
    "G90: straight cuts to two diameters": (
        "G21 T0101\nS800 M3\nG0 X40. Z2.\nG90 X36. Z-20. F.2\nX32.\nG0 X60.\nM30",
        "R 20 0 2; R 18 . .; L . . -20; L 20 . .; R . . 2; R 16 . .; L . . -20; L 20 . .; R . . 2; R 30 . .",
    ),
    "G94: a face in two cuts": (
        "G21 T0101\nS800 M3\nG0 X40. Z2.\nG94 X0 Z-1. F.2\nZ-2.\nM30",
        "R 20 0 2; R . . -1; L 0 . .; L . . 2; R 20 . .; R . . -2; L 0 . .; L . . 2; R 20 . .",
    ),
    "G90 with R: a taper, 1 mm in radius": (
        "G21 T0101\nS800 M3\nG0 X40. Z0\nG90 X30. Z-20. R-1. F.2\nM30",
        "R 20 0 0; R 14 . .; L 15 . -20; L 20 . .; R . . 0",
    ),
    "G92: one cut of a thread, its feed from lead and speed": (
        "G21 T0101\nG97 S800 M3\nG0 X24. Z5.\nG92 X19. Z-20. F1.5\nM30",
        "R 12 0 5; R 9.5 . .; T . . -20; R 12 . .; R . . 5",
    ),
    "G74: pecks of 4 mm, back by 1": (
        "G21 T0101\nS800 M3\nG0 X0 Z2.\nG74 R1.\nG74 Z-8. Q4000 F.1\nM30",
        "R 0 0 2; L . . -2; R . . -1; L . . -6; R . . -5; L . . -8; R . . 2",
    ),
    "G75: a groove in pecks of 2 mm, back by 0.5": (
        "G21 T0101\nS800 M3\nG0 X40. Z-10.\nG75 R.5\nG75 X30. P2000 F.1\nM30",
        "R 20 0 -10; L 18 . .; R 18.5 . .; L 16 . .; R 16.5 . .; L 15 . .; R 20 . .",
    ),
    "G71 in two blocks: 4 mm deep each, 1 mm back at 45 degrees": (
        "G21 T0101\nS800 M3\nG0 X40. Z2.\nG71 U4. R1.\nG71 P10 Q20 U0 W0 F.2\nN10 G0 X20.\nG1 Z-10.\nN20 X40.\nM30",
        "R 20 0 2; R 16 . .; L . . -10; L 17 . -9; R . . 2; R 12 . .; L . . -10; L 13 . -9; R . . 2; R 10 . .; L . . -10; L 20 . .; R . . 2",
    ),
    "G70 runs the contour of G71 once more": (
        "G21 T0101\nS800 M3\nG0 X40. Z2.\nG70 P10 Q20\nG0 X60.\nM30\nN10 G0 X20.\nG1 Z-10. F.1\nN20 X40.",
        "R 20 0 2; R 10 . .; L . . -10; L 20 . .; R . . 2; R 30 . .",
    ),
    "G50 sets the coordinates": (
        "G21 T0101\nS800 M3\nG0 X40. Z10.\nG50 X20. Z0\nG1 X10. F.2\nM30",
        "R 20 0 10; L 15 . .",
    ),
}
HAAS = {
    "G71 in one block: D is the depth in radius": (
        "G21 T101\nS800 M3\nG0 X40. Z2.\nG71 P10 Q20 D5. U0 W0 F.2\nN10 G0 X20.\nG1 Z-10.\nN20 X40.\nM30",
        [15.0, 10.0],
    ),
    "G76 with K, D and A0: the depths go with the root of the number of the pass": (
        "G21 T101\nG97 S800 M3\nG0 X24. Z5.\nG76 X18. Z-20. K1. D.5 F1.5\nM30",
        [9.5, 10 - 0.5 * 2**0.5, 10 - 0.5 * 3**0.5, 9.0],
    ),
}
MAZAK = {
    "two tools before M6: the first goes in, the second is made ready": (
        "G21 G90 G54\nT01T02M06\nG0 X1. Y2.\nG43 H1 Z3.\nG1 Z0 F100\nM30",
        "R 1 2 0; R . . 3; L . . 0",
    ),
    "G98 and G99, as Fanuc": (
        "G21 G90 G0 X0 Y0 Z20.\nG99 G82 X5. Y0 Z-1. R2. P500 F100\nG98 X9.\nG80\nM30",
        "R . . 20; R 5 . .; R . . 2; L . . -1; D 0.5; R . . 2; R 9 . .; L . . -1; D 0.5; R . . 20",
    ),
    "G68 turns, G61.1 moves nothing": (
        "G21 G90 G17 G61.1\nG68 X0 Y0 R-90.\nG1 X10. Y0 F100\nG69\nX0\nM30",
        "L 0 -10 0",
    ),
    "M98 with L": ("G21 G91\nM98 P7 L2\nM30\nO7\nG1 X2. F100\nM99", "L 2 0 0; L 4 0 0"),
}
OKUMA = {
    "a lathe: X counts diameters, L is the radius of an arc": (
        "G50 S2000\nG97 S800 M3 T0101\nG0 X40 Z2\nG1 Z-10 F0.2\nG2 X50 Z-15 L5\nG1 X60\nM2",
        "R 20 0 2; L . . -10; A 25 0 -15 (-10 25 -); L 30 . .",
    ),
    "a loop by a sequence name": (
        "G97 S800 M3 T0101\nG0 X40 Z0\nV1=0\nNTOP V1=V1+1\nG1 Z=-V1*5 F0.2\nIF [V1 LT 3] NTOP\nM2",
        "R 20 0 0; L . . -5; L . . -10; L . . -15",
    ),
    "CALL hands over a variable": (
        "G97 S800 M3 T0101\nG0 X40 Z0\nCALL OCUT DEP=7\nG0 X50\nM2\nOCUT\nG1 Z=-DEP F0.2\nRTS",
        "R 20 0 0; L . . -7; R 25 . .",
    ),
    "a mill: G15 H2 is the second work offset": (
        "G21\nG90 G15 H2\nG0 X1 Y2 Z3\nG1 X5 F100\nG15 H1\nG0 X0 Y0\nM2",
        "R 101 52 -7; L 105 . .; R 0 0 .",
    ),
    "increments and arcs by centre": (
        "G90 G15 H1\nG0 X10 Y0\nG3 X0 Y10 I-10 J0 F100\nG91 G1 X-3 Y-4\nM2",
        "R 10 0 0; A 0 10 . (0 0 +); L -3 6 .",
    ),
}


@pytest.mark.parametrize("name", LATHE)
def test_a_lathe_program_means_what_was_worked_out_by_hand(name: str):
    check("fanuc-lathe", *LATHE[name], SETUP)


@pytest.mark.parametrize("name", HAAS)
def test_the_cuts_of_a_haas_cycle_lie_where_they_were_worked_out(name: str):
    text, radii = HAAS[name]
    moves = interpret(text, "haas-lathe", SETUP).moves
    cut = [r for r in found(moves) if r[0] in ("line", "thread") and r[1][2] <= -10]
    have = list(dict.fromkeys(round(r[1][0], 4) for r in cut))
    assert have[: len(radii)] == [pytest.approx(r, abs=1e-4) for r in radii]


def test_the_passes_of_g76_in_two_blocks():
    """P010060: one pass to finish; thread 1 mm high, first cut 0.4, least cut 0.1, 0.05 left to finish. Depths 0.4, 0.4 sqrt 2,
    0.4 sqrt 3, 0.4 sqrt 4 = 0.8, then by 0.1: 0.9, 0.95 = 1 - 0.05, and 1."""
    text = "G21 T0101\nG97 S800 M3\nG0 X24. Z5.\nG76 P010060 Q100 R.05\nG76 X18. Z-20. P1000 Q400 F1.5\nM30"
    cuts = [m.end[0] for m in interpret(text, "fanuc-lathe", SETUP).moves if m.kind == "thread"]
    assert cuts == pytest.approx([9.6, 9.434315, 9.307180, 9.2, 9.1, 9.05, 9.0], abs=1e-5)


@pytest.mark.parametrize("name", MAZAK)
def test_a_mazak_program_means_what_was_worked_out_by_hand(name: str):
    check("mazak", *MAZAK[name])


@pytest.mark.parametrize("name", OKUMA)
def test_an_okuma_program_means_what_was_worked_out_by_hand(name: str):
    check("okuma", *OKUMA[name])
