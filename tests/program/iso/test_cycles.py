"""Drilling, tapping and boring cycles of the G-code family, move by move."""

from __future__ import annotations

import pytest

from tests.program.meanings import fanuc, linuxcnc
from vcmm.program.interpret import interpret


# -- cycles -------------------------------------------------------------------------------------------------------------
def test_pecks_of_fanuc():
    moves = fanuc("G21 G90 G99 G0 X0. Y0. Z50.\nG83 X10. Z-5. R2. Q3. F100.\nG80")
    # R 2: pecks to -1, -4, -5; back to 0.5 above the depth reached
    assert [(m.kind, m.end[2]) for m in moves[1:]] == [
        ("rapid", 50), ("rapid", 2), ("line", -1), ("rapid", 2), ("rapid", -0.5), ("line", -4), ("rapid", 2),
        ("rapid", -3.5), ("line", -5), ("rapid", 2),
    ]  # fmt: skip


def test_chip_breaking_and_initial_level():
    moves = fanuc("G21 G90 G98 G0 X0. Y0. Z50.\nG73 X10. Z-3. R2. Q3. F100.\nX20.\nG80")
    first = [m.end[2] for m in moves[1:7]]
    assert first == [50, 2, -1, -0.5, -3, 50]
    assert moves[7].end == (20, 0, 50)


def test_repeats_in_increments():
    moves = fanuc("G21 G90 G99 G0 X0. Y0. Z10.\nG91 G81 X5. Z-4. R-8. K3 F100.\nG80")
    holes = [m.end for m in moves if m.kind == "line"]
    assert holes == [(5, 0, -2), (10, 0, -2), (15, 0, -2)]  # R = 10 - 8 = 2, bottom = 2 - 4


@pytest.mark.parametrize("dialect", ["fanuc", "haas", "mazak"])
def test_heights_stay_where_they_are_when_the_mode_changes(dialect):
    start = "G21 G90 G98 G0 X0. Y0. Z50.\n"
    text = f"{start}G81 X10. Y10. Z-12. R2. F100.\nG91 X20. K3\nG90 X5. Y5.\nG80\nM30"
    moves = interpret(text, dialect).moves
    assert [m.end for m in moves if m.kind == "line"] == [
        (10, 10, -12), (30, 10, -12), (50, 10, -12), (70, 10, -12), (5, 5, -12),
    ]  # fmt: skip
    assert {m.end[2] for m in moves if m.kind == "rapid"} == {50, 2}
    # given under G91, R is 50 - 48 = 2 and the bottom 2 - 4 = -2: repeated, and under G90; a new Z is a height again
    text = f"{start}G91 G81 X10. Z-4. R-48. F100. K2\nX10.\nG90 X5.\nX6. Z-7.\nG80\nM30"
    moves = interpret(text, dialect).moves
    bottoms = [(m.end[0], m.end[2]) for m in moves if m.kind == "line"]
    assert bottoms == [(10, -2), (20, -2), (30, -2), (5, -2), (6, -7)]
    assert {m.end[2] for m in moves if m.kind == "rapid"} == {50, 2}


def test_a_lathe_keeps_the_heights_of_its_cycle_under_g91():
    # R counts from the height where the cycle begins: 5 - 3 = 2; the depth is the Z of the G90 block; X4. is a diameter
    text = "G21 G90 G0 X0. Z5.\nG97 S100 M3\nG83 Z-12. R-3. F100.\nG91 X4. K2\nG80\nM30"
    moves = interpret(text, "fanuc-lathe-b").moves
    assert [(m.start[2], m.end[2]) for m in moves if m.kind == "line"] == [(2, -12)] * 3


def test_the_plate_of_haas_in_inches():
    text = "G20 G90 G98 G0 X0. Y0. Z1.\nG81 Z-1.5 R.1 F15.\nG91 X1.0 L9\nG80\nM30"
    holes = [m.end for m in interpret(text, "haas").moves if m.kind == "line"]
    assert holes == [pytest.approx((25.4 * k, 0, -38.1)) for k in range(10)]


def test_linuxcnc_reads_heights_in_the_mode_of_each_block():
    moves = linuxcnc("G21 G90 G98 G0 X0 Y0 Z50\nG81 X10 Z-12 R2 F100\nG91 X20\nG80")
    assert [m.end for m in moves if m.kind == "line"] == [
        (10, 0, -12),
        (30, 0, 40),
    ]  # R 50 + 2, bottom 52 - 12


def test_the_number_of_repeats_is_no_length():
    text = "G21 G90 G98 G0 X0. Y0. Z50.\nG83 X10. Z-5. R2. Q3. P200 F100. {0}\nG91 X20. {0}\nG80\nM30"
    for count in ("K3", "L3"):
        told = [
            w.text for w in interpret(text.format(count), "fanuc").warnings
        ]  # the clearance of the pecks, and nothing of K or L
        assert len(told) == 1
        assert "parameter 5115" in told[0]
    assert "Z-5" in interpret(text.format("K3").replace("Z-5.", "Z-5"), "fanuc").warnings[0].text


def test_fine_boring_moves_off_the_wall():
    moves = fanuc("G21 G99 S100 M3 G0 X0. Y0. Z10.\nG76 X5. Z-4. R2. Q0.5 F100.\nG80")
    kinds = [(m.end, m.spindle) for m in moves[-4:]]
    assert kinds == [((5, 0, -4), 100), ((5.5, 0, -4), 0), ((5.5, 0, 2), 0), ((5, 0, 2), 0)]


def test_tapping_turns_the_spindle_back():
    moves = fanuc("G21 G99 S100 M3 G0 X0. Y0. Z10.\nG84 X5. Z-4. R2. F125.\nG80")
    assert [(m.kind, m.end[2], m.spindle) for m in moves[-2:]] == [("line", -4, 100), ("line", 2, -100)]
