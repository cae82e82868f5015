"""Programs of Fanuc and Haas mills, each worked out by hand from the manual's rules (B-64304EN; Haas mill operator's manual)."""

from __future__ import annotations

import pytest

from tests.program.pencil import check

FANUC = {
    "arcs by R, by centre, and in increments": (
        "G21 G90 G17 G54\nG0 X10. Y0.\nZ2.\nG1 Z-1. F100\nG3 X0. Y10. R10.\nG2 X-10. Y20. I0. J10.\nG91 G3 X-5. Y-5. I0. J-5.\nM30",
        "R 10 0 0; R . . 2; L . . -1; A 0 10 . (0 0 +); A -10 20 . (0 20 -); A -15 15 . (-10 15 +)",
    ),
    "G98 and G99 change from hole to hole": (
        "G21 G90 G0 X0 Y0 Z50.\nG99 G81 X10. Y0. Z-5. R2. F100\nX20.\nG98 X30.\nY10.\nG80\nG0 Z60.\nM30",
        "R . . 50; R 10 . .; R . . 2; L . . -5; R . . 2; R 20 . .; L . . -5; R . . 2; R 30 . .; L . . -5; R . . 50; R . 10 .; R . . 2; "
        "L . . -5; R . . 50; R . . 60",
    ),
    "pecks of 4 mm, back to 0.5 mm above the depth": (
        "G21 G90 G0 Z10.\nG98 G83 X0. Z-9. R1. Q4. F50\nG80\nM30",
        "R 0 0 10; R . . 1; L . . -3; R . . 1; R . . -2.5; L . . -7; R . . 1; R . . -6.5; L . . -9; R . . 10",
    ),
    "a subprogram in increments, three times": (
        "O1\nG21 G90 G0 X0 Y0\nM98 P100 L3\nG90 G0 X0\nM30\nO100\nG91 G1 X5. F100\nY1.\nM99",
        "L 5 0 0; L . 1 .; L 10 . .; L . 2 .; L 15 . .; L . 3 .; R 0 . .",
    ),
    "the older form of the same call: P0030100 is three times O0100": (
        "O1\nG21 G90\nM98 P0030100\nM30\nO100\nG91 G1 X5. F100\nM99",
        "L 5 0 0; L 10 0 0; L 15 0 0",
    ),
    "G68 about (10, 0) by 90 degrees": (
        "G21 G90 G17 G0 X0 Y0\nG68 X10. Y0. R90.\nG1 X20. Y0. F100\nY5.\nG69\nX0 Y0\nM30",
        "L 10 10 0; L 5 10 .; L 0 0 .",
    ),
    "G51 P2000 is twice the size, arcs too": (
        "G21 G90 G17\nG51 X0 Y0 Z0 P2000\nG1 X5. Y5. F100\nG2 X10. Y0 R5.\nG50\nG1 X0 Y0\nM30",
        "L 10 10 0; A 20 0 0 (10 0 -); L 0 0 0",
    ),
    "a mirror turns the sense of an arc round": (
        "G21 G90 G17\nG51.1 X0\nG1 X10. Y0 F100\nG3 X0 Y10. R10.\nG50.1 X0\nG1 X5.\nM30",
        "L -10 0 0; A 0 10 . (0 0 -); L 5 . .",
    ),
    "G16: radius and angle": (
        "G21 G90 G17 G0 Z10.\nG16 G99 G81 X20. Y0 Z-2. R1. F100\nY90.\nY180.\nG15 G80\nM30",
        "R 0 0 10; R 20 . .; R . . 1; L . . -2; R . . 1; R 0 20 .; L . . -2; R . . 1; R -20 0 .; L . . -2; R . . 1",
    ),
    "offsets, inches, a local shift, machine coordinates, G10": (
        "G21 G90 G55 G0 X1. Y0\nG20 G1 X1. F10.\nG21 G52 X5. Y5.\nG1 X0 Y0\nG52 X0 Y0\nG53 G0 Z-3.\nG10 L2 P1 X7. Y8. Z9.\nG54 G0 X0 Y0 Z0\nM30",
        "R 101 50 0; L 125.4 . .; L 105 55 .; R . . -3; R 7 8 9",
    ),
    "a rounded corner of 5 mm, a chamfer of 3 mm": (
        "G21 G90 G17\nG1 X20.,R5. F100\nY20.,C3.\nX0\nM30",
        "L 15 0 0; A 20 5 0 (15 5 +); L . 17 .; L 17 20 .; L 0 . .",
    ),
    "radius compensation left of a square corner, type B": (
        "G21 G90 G17 T1 M6\nG0 X-20. Y-20.\nG41 D1 G1 X0 Y-10. F100\nY20.\nX30.\nG40 X40. Y40.\nM30",
        "R -20 -20 0; L -5 -10 .; L . 25 .; L 30 . .; L 40 40 .",
    ),
    "macro B: a loop of holes on a circle of 10 mm": (
        "G21 G90 G17 G0 Z5.\n#1=0\nWHILE[#1 LT 3]DO1\nG0 X[10.*COS[#1*90.]] Y[10.*SIN[#1*90.]]\n#1=#1+1\nEND1\nM30",
        "R 0 0 5; R 10 . .; R 0 10 .; R -10 0 .",
    ),
    "G28 by way of a point in increments": (
        "G21 G90 G0 X10. Y10. Z10.\nG91 G28 Z5.\nG90 G0 X0 Y0\nM30",
        "R 10 10 10; R . . 15; R . . 0; R 0 0 .",
    ),
}
HAAS = {
    "G70: four holes round where the tool stands, L0 defines the cycle": (
        "G21 G90 G17 G0 X0 Y0 Z10.\nG99 G81 Z-2. R1. F100. L0\nG70 I10. J0 L4\nG80\nM30",
        "R 0 0 10; R 10 . .; R . . 1; L . . -2; R . . 1; R 0 10 .; L . . -2; R . . 1; R -10 0 .; L . . -2; R . . 1; R 0 -10 .; L . . -2; R . . 1",
    ),
    "G71: three holes from 90 degrees in steps of 45": (
        "G21 G90 G17 G0 X5. Y0 Z10.\nG99 G81 Z-2. R1. F100. L0\nG71 I10. J90. K45. L3\nG80\nM30",
        "R 5 0 10; R . 10 .; R . . 1; L . . -2; R . . 1; R -2.0711 7.0711 .; L . . -2; R . . 1; R -5 0 .; L . . -2; R . . 1",
    ),
    "G72: three holes in a line at 30 degrees, the first where the tool stands": (
        "G21 G90 G17 G0 X0 Y0 Z10.\nG99 G81 Z-2. R1. F100. L0\nG72 I10. J30. L3\nG80\nM30",
        "R 0 0 10; R . . 1; L . . -2; R . . 1; R 8.6603 5 .; L . . -2; R . . 1; R 17.3205 10 .; L . . -2; R . . 1",
    ),
    "M97 calls a part of the same program": (
        "O1\nG21 G90\nM97 P1000 L2\nG0 X0\nM30\nN1000 G91 G1 X4. F100.\nG90\nM99",
        "L 4 0 0; L 8 0 0; R 0 0 0",
    ),
    "G83 with I J K: 5, then 2 less each time, 2 at least": (
        "G21 G90 G0 Z10.\nG98 G83 X0 Z-10. R0 I5. J2. K2. F50.\nG80\nM30",
        "R 0 0 10; R . . 0; L . . -5; R . . 0; R . . -4.5; L . . -8; R . . 0; R . . -7.5; L . . -10; R . . 10",
    ),
    "G13 I10: left round a circle of 10 mm, in and out": (
        "G21 G90 G17 T3 M6\nG0 X0 Y0\nG13 I12. D3 F100.\nM30",
        "A 10 0 0 (5 0 +); A 10 0 0 (0 0 +); A 0 0 0 (5 0 +)",
    ),
    "G110 is G154 P1": (
        "G21 G90\nG10 L20 P1 X10. Y20. Z0\nG110 G0 X1. Y1.\nG154 P1 X2.\nM30",
        "R 11 21 0; R 12 . .",
    ),
    "G73 Q: chips broken, R between holes": (
        "G21 G90 G0 Z10.\nG99 G73 X1. Y0 Z-5. R1. Q3. F50.\nX2.\nG80\nM30",
        "R 0 0 10; R 1 . .; R . . 1; L . . -2; R . . -1.5; L . . -5; R . . 1; R 2 . .; L . . -2; R . . -1.5; L . . -5; R . . 1",
    ),
    "a tap comes back at its feed": (
        "G21 G90 G0 Z10.\nS500 M3\nG98 G84 X0 Z-6. R2. F500.\nG80\nM30",
        "R 0 0 10; R . . 2; L . . -6; L . . 2; R . . 10",
    ),
    "G53 and G28 with G91": (
        "G21 G90 G55 G0 X0 Y0\nG91 G28 X0\nG90 G53 G0 Y0\nM30",
        "R 100 50 0; R 0 . .; R . 0 .",
    ),
    "G101 mirrors, G100 ends it": (
        "G21 G90 G17\nG101 X0\nG1 X10. F100.\nG100 X0\nX3.\nM30",
        "L -10 0 0; L 3 0 0",
    ),
}


@pytest.mark.parametrize("name", FANUC)
def test_a_fanuc_program_means_what_was_worked_out_by_hand(name: str):
    check("fanuc", *FANUC[name])


@pytest.mark.parametrize("name", HAAS)
def test_a_haas_program_means_what_was_worked_out_by_hand(name: str):
    check("haas", *HAAS[name])
