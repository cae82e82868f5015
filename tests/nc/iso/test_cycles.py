"""Drilling, tapping and boring cycles of the G-code family, move by move."""

from __future__ import annotations

from tests.nc.meanings import fanuc


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


def test_fine_boring_moves_off_the_wall():
    moves = fanuc("G21 G99 S100 M3 G0 X0. Y0. Z10.\nG76 X5. Z-4. R2. Q0.5 F100.\nG80")
    kinds = [(m.end, m.spindle) for m in moves[-4:]]
    assert kinds == [((5, 0, -4), 100), ((5.5, 0, -4), 0), ((5.5, 0, 2), 0), ((5, 0, 2), 0)]


def test_tapping_turns_the_spindle_back():
    moves = fanuc("G21 G99 S100 M3 G0 X0. Y0. Z10.\nG84 X5. Z-4. R2. F125.\nG80")
    assert [(m.kind, m.end[2], m.spindle) for m in moves[-2:]] == [("line", -4, 100), ("line", 2, -100)]
