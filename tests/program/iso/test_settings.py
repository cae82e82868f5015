"""Settings of the control that cycles hang on: each is told with what is taken for it, and a first block keeps it."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

TOOLS = {1: Tool(1, 0.0, 10.0)}
HEAD = "%\nO1\nG21 G18 G40 G99\nG97 S500 M3\nG0 X50. Z2.\n"
CONTOUR = "N10 G0 X30.\nG1 Z-20.\nN20 X50.\n"


def read(text, dialect="fanuc-lathe", strict=False):
    return interpret(text, dialect, Setup(strict=strict, tools=TOOLS))


def told(text, dialect="fanuc-lathe"):
    return {a.what: a.value for a in read(text, dialect).assumed}


def test_g71_without_an_escape_tells_the_parameter():
    lathe = HEAD + "G71 U2.\nG71 P10 Q20 U0. W0. F0.2\n" + CONTOUR + "M30\n%\n"
    what = "how far the tool comes off after a pass of G71 (FANUC parameter 5133)"
    assert told(lathe)[what].startswith("0 mm")
    assert what not in told(lathe.replace("U2.", "U2. R1."))
    assert any(what in w.text for w in read(lathe, strict=True).warnings)  # both levels go on, and say it
    haas = HEAD + "G71 P10 Q20 D2. U0. W0. F0.2\n" + CONTOUR + "M30\n%\n"
    assert "how far the tool comes off after a pass of G71 (Haas setting 73)" in told(haas, "haas-lathe")


def test_the_first_block_stays_in_force():
    # B-64304EN-1, G71: "this designation is modal and is not changed until the other value is designated". From X50 (radius 25) to X30 (15)
    # in cuts of 5: one pass at 20, and the contour at 15; the second G71 has no first block and does the same to Z-10
    first = HEAD + "G71 U5. R1.\nG71 P10 Q20 U0. W0. F0.2\n" + CONTOUR
    second = first + "G0 X50. Z2.\nG71 P30 Q40 U0. W0. F0.2\nN30 G0 X30.\nG1 Z-10.\nN40 X50.\nM30\n%\n"
    cuts = [
        (m.source.line, m.end[0], m.end[2])
        for m in read(second, strict=True).moves
        if m.kind == "line" and m.start[0] == m.end[0]
    ]
    assert cuts == [(7, 20, -20), (7, 15, -20), (12, 20, -10), (12, 15, -10)]  # fmt: skip


def test_g74_without_a_return_tells_the_parameter():
    text = HEAD + "G74 X20. Z-10. P2000 Q3000 F0.1\nM30\n%\n"
    assert "how far the tool comes back after a peck of G74 (FANUC parameter 5139)" in told(text)
    assert not told(text.replace("G74 X20.", "G74 R0.5\nG74 X20."))


def test_pull_out_of_threads_is_told():
    thread = HEAD + "G76 P02{}60 Q100 R0.05\nG76 X20. Z-15. P1000 Q300 F1.5\nM30\n%\n"
    assert "the pull-out at the end of a thread of G76 (P: 1.2 times the lead, at 45 degrees)" in told(
        thread.format("12")
    )
    assert not told(thread.format("00"))
    assert "the pull-out at the end of a thread of G92 (FANUC parameter 5130)" in told(
        HEAD + "G92 X28. Z-10. F1.\nM30\n%\n"
    )


def test_clearance_of_pecks_is_told_where_the_control_sets_it():
    text = "G21 G90 G54\nT1 M6\nS500 M3\nG0 Z5.\nG{} X0. Y0. Z-10. R2. Q{} F100.\nG80\nM30\n"
    assert "how far the tool stays before the depth reached with G83 (FANUC parameter 5115)" in told(
        text.format(83, "3."), "fanuc"
    )
    assert "how far the tool comes back after a peck of G73 (Haas setting 22)" in told(
        text.format(73, "3."), "haas"
    )
    assert not told(text.format(83, "20."), "fanuc")
    assert not told(text.format(83, "3."), "linuxcnc")


def test_j_of_g84_on_a_haas_is_the_speed_of_the_way_out():
    # F500 S500: down at 500, out at J3 x 500 = 1500 mm/min with -1500 turns per minute
    text = "G21 G90 G54\nT1 M6\nS500 M3\nG0 Z20.\nG84 X0. Y0. Z-10. R2. F500. J3\nG80\nG1 Z19. F100.\nM30\n"
    moves = [(m.end[2], m.feed, m.spindle) for m in read(text, "haas", strict=True).moves if m.kind == "line"]
    assert moves == [(-10, 500, 500), (2, 1500, -1500), (19, 100, 500)]
    pecks = text.replace("G84", "G83 X1. Y0. Z-3. R2. I2. J1. K1. F500.\nG84").replace(" J3", "")
    out = [
        m.feed for m in read(pecks, "haas", strict=True).moves if m.kind == "line" and m.end[2] > m.start[2]
    ]
    assert out[:1] == [500]  # J of G83 is a length; of G87 too (LinuxCNC)
    series = "G21 G90 G17\nT1 M6\nS500 M3\nF500\nG0 Z5\nG87 X0 Y0 Z-5 R1 I1 J0 K-3\nG84 X1 Z-5 R1\nG80\nM2\n"
    up = [m.feed for m in read(series, "linuxcnc").moves if m.kind == "line" and m.end[2] > m.start[2]]
    assert up[-1] == 500  # not 500 x J0
    with pytest.raises(DataError, match="J0: how many times"):
        read(text.replace("J3", "J0"), "haas")
    with pytest.raises(DataError, match='uses the word "J"'):
        read(text, "fanuc", strict=True)


def test_m39_and_m46_of_a_haas_are_told():
    text = "G21 G90 G54\nT1 M6\nT1 M39\nG0 X1.\nM46 Q1 P6\nX2.\nM30\n"
    made = read(text, "haas")
    assert any(w.text.startswith("M39 turns the tool changer") for w in made.warnings)
    assert "whether the pallet of M46 Q is loaded" in {a.what for a in made.assumed}
    with pytest.raises(DataError, match="M46 jumps"):
        read(text, "haas", strict=True)
