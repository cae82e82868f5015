"""Words that a control obeys and that are easily passed over: each path by hand from the rule of its manual."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from tests.program.oracle import SETUP, differences, ours
from tests.program.pencil import check
from tests.program.rs274 import path_of
from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.moves import Program
from vcmm.program.setup import Setup, Tool

SURVEY = Setup(strict=False)


def survey(text: str, dialect: str) -> Program:
    return interpret(text, dialect, SURVEY)


def assumed(text: str, dialect: str) -> str:
    return "; ".join(f"{a.line}: {a.what}: {a.value}" for a in survey(text, dialect).assumed)


# -- LinuxCNC ---------------------------------------------------------------------------------------------------------
THREAD = "G21 G90 G18 G94\nS1000 M3\nG7\nG0 X20 Z5\nG76 P1.5 Z-10 I-4 J0.4 K1.6 R1.5 Q29.5 H1 E1 L2\nM2\n"


def test_g76_counts_diameters_with_g7():
    # LinuxCNC, G76: "in G7 I, J and K are diameters". Drive line r = 10; peak 10 - 4/2 = 8; full depth 1.6/2 = 0.8 below: 7.2;
    # the tool clears by |I|/2 + K/2 = 2.8 above the bottom: 10
    cuts = [m for m in interpret(THREAD, "linuxcnc").moves if m.kind == "thread"]
    assert min(m.end[0] for m in cuts) == pytest.approx(7.2)
    first = 8.0 - 0.4 / 2.0  # the first pass is J/2 deep
    assert max(m.start[0] for m in cuts) == pytest.approx(first)


def test_g76_with_g7_is_the_path_of_the_interpreter(tmp_path: Path):
    cut = [
        m._replace(kind="line") if m.kind == "thread" else m
        for m in interpret(THREAD, "linuxcnc", SETUP).moves
    ]
    assert not differences(ours(tuple(cut)), path_of(THREAD, tmp_path), 0.004)


# -- dwells -----------------------------------------------------------------------------------------------------------
def test_a_dwell_of_haas_with_a_point_is_in_seconds():
    # Haas mill operator's manual, G04: P10 is 10 ms, P10. is 10 s
    assert [m.seconds for m in survey("G4 P2.\nG4 P500\nM30", "haas").moves] == [2.0, 0.5]
    hole = survey("G0 Z5.\nG82 X1. Y0. Z-2. R1. P1.5 F100.\nG80\nM30", "haas").moves
    assert [m.seconds for m in hole if m.kind == "dwell"] == [1.5]


def test_a_dwell_of_fanuc_with_a_point_is_asked_for():
    # FANUC B-64304EN, G04: the decimal point cannot be used with P
    with pytest.raises(
        DataError, match=r":1:4: P2\.: P counts milliseconds and takes no decimal point.*P2000"
    ):
        interpret("G4 P2.\nM30", "fanuc")
    assert [m.seconds for m in survey("G4 P2.\nM30", "fanuc").moves] == [2.0]
    assert "1: the time of P2., which has a decimal point: 2 s" in assumed("G4 P2.\nM30", "fanuc")


def test_grbl_has_no_dwell_by_s():
    # grbl, error 28: a G-code command requires the value word P
    with pytest.raises(DataError, match="G4 needs P, its time in seconds: grbl stops here"):
        interpret("G4 S2\n", "grbl")
    assert "the time of G4 S2: 2 s" in assumed("G4 S2\n", "grbl")
    assert [m.seconds for m in interpret("G4 P0.5 S2\n", "grbl").moves] == [0.5]


# -- codes ------------------------------------------------------------------------------------------------------------
def test_engraving_of_haas_is_a_hole_in_the_path():
    # Haas mill operator's manual, G47: P0 engraves the text in the comment
    text = "G0 X0. Y0.\nG47 P0 X2. Y2. I45. J.5 R.05 Z-.005 F15. E10. (TEXT TO ENGRAVE)\nM30"
    with pytest.raises(DataError, match=r"G47 \(engraving of a text\) is not understood"):
        interpret(text, "haas")
    assert "2: G47 (engraving of a text): a hole in the path" in assumed(text, "haas")
    assert not any("changes no path" in w.text for w in survey(text, "haas").warnings)
    for code in ("G35", "G37", "G141", "G174", "G184"):
        with pytest.raises(DataError, match=f"{code} .*is not understood"):
            interpret(f"{code} X1.\nM30", "haas")


@pytest.mark.parametrize("setup", [Setup(), SURVEY])
def test_dynamic_work_offsets_are_refused(setup: Setup):
    # with A20 the work zero turns with the table; only P0, which ends it, changes no path
    with pytest.raises(DataError, match=r"G54\.2 .*does not model"):
        interpret("G54.2 P1\nG0 A20.\nG1 X10. F100.\nM30", "fanuc", setup)
    assert len(interpret("G54.2 P0\nG0 X10.\nM30", "fanuc", setup).moves) == 1


def test_p_beside_g54_chooses_a_further_offset():
    # FANUC B-64304EN, additional workpiece coordinate systems: "G54.1 Pn or G54 Pn"
    setup = Setup(offsets={"G54": (1.0, 0.0, 0.0), "G54.1 P3": (30.0, 0.0, 0.0)}, strict=False)
    check("fanuc", "G54 P3\nG0 X10. Y0. Z0.\nM30", "R 40 0 0", setup)
    check("fanuc", "G54 G4 P3\nG0 X10. Y0. Z0.\nM30", "D 0.003 ; R 11 0 0", setup)  # P is the time of G4
    check("fanuc", "G54 M98 P3\nG0 X10. Y0. Z0.\nM30\nO3\nM99", "R 11 0 0", setup)
    with pytest.raises(DataError, match='nothing in this block uses the word "P"'):
        interpret("G54 P3\nM30", "haas")


# -- cycles -----------------------------------------------------------------------------------------------------------
def test_a_cycle_whose_r_lies_above_the_level_at_which_it_begins():
    # FANUC B-64304EN, canned cycle: operation 1 positions X and Y, operation 2 is the rapid to R
    text = "G21 F100.\nG0 X0. Y0. Z2.\nG98 G81 X10. Y0. Z-3. R5.\nX20.\nG80\nM30"
    check(
        "fanuc",
        text,
        "R 0 0 2 ; R 10 0 2 ; R 10 0 5 ; L 10 0 -3 ; R 10 0 5 ; R 20 0 5 ; L 20 0 -3 ; R 20 0 5",
    )
    assert "3: where G81 ends whose R lies above the level at which it begins: at R" in assumed(text, "fanuc")


def test_tapping_in_pecks():
    # FANUC B-64304EN, "peck rigid tapping cycle": Q deep from R, back by d (5213; here 0.5), on to 2 Q, ... ; out at R at feed.
    # R 1, Z -6, Q 3: down to -2, up to -1.5, down to -5, up to -4.5, down to -6
    text = "G21 F100. S500 M3\nG0 X0. Y0. Z2.\nG99 G84 X0. Y0. Z-6. R1. Q3.\nG80\nM30"
    down = "L . . -2 ; L . . -1.5 ; L . . -5 ; L . . -4.5 ; L . . -6 ; L . . 1"
    check("fanuc", text, f"R 0 0 2 ; R . . 1 ; {down}")
    senses = [m.spindle for m in survey(text, "fanuc").moves if m.kind == "line"]
    assert senses == [500, -500, 500, -500, 500, -500]
    assert "how far the tap comes up after each peck Q: 0.5 mm" in assumed(text, "fanuc")


# -- jumps and reference points ---------------------------------------------------------------------------------------
def test_m99_with_p_in_the_main_program_jumps():
    # FANUC B-64304EN, M99 Pn in the main program: control goes on at block n
    check("fanuc", "G0 X1. Y0. Z0.\nM99 P50\nX99.\nN50 X5.\nM30", "R 1 0 0 ; R 5 0 0")
    again = survey("N10 G0 X1.\nX2.\nM99 P10\nM30", "fanuc")  # no way out: read once
    assert len(again.moves) == 2
    assert "M99 in the main program goes back to N10 for ever; it is read once" in [
        w.text for w in again.warnings
    ]
    text = "#1=0\nN10 #1=#1+1\nG0 X#1\nIF[#1GE3]GOTO20\nM99 P10\nN20 X9.\nM30"
    assert [m.end[0] for m in survey(text, "fanuc").moves] == [1, 2, 3, 9]
    with pytest.raises(DataError, match="M99 P7: this program has no block N7"):
        interpret("G0 X1.\nM99 P7\nM30", "fanuc")


def test_g29_goes_back_by_way_of_the_point_of_g28():
    # FANUC B-64304EN, G28 and G29: P1 = (30, 40) on the way home (0, 0, 0), the same point on the way back, then the end
    text = "G21\nG0 X10. Y10. Z0.\nG28 X30. Y40.\nG29 X50. Y60.\nM30"
    check("fanuc", text, "R 10 10 0 ; R 30 40 0 ; R 0 0 0 ; R 30 40 0 ; R 50 60 0")
    # only the axes that G29 names move; increments count from the point
    check(
        "fanuc",
        "G0 X10. Y10. Z0.\nG28 X30. Y40.\nG91 G29 X5.\nM30",
        "R 10 10 0 ; R 30 40 0 ; R 0 0 0 ; R 30 0 0 ; R 35 0 0",
    )
    with pytest.raises(DataError, match="G29: no G28 has led Z over a point"):
        interpret("G28 X1.\nG29 Z1.\nM30", "fanuc")


def test_g28_without_axes_is_told_with_its_line():
    assert "2: where G28 without axes goes: nowhere" in assumed("G0 X5.\nG28\nM30", "fanuc-lathe")
    assert len(survey("G0 X5.\nG28\nM30", "haas-lathe").moves) == 2


# -- lathes -----------------------------------------------------------------------------------------------------------
def test_g14_of_a_haas_lathe_mirrors_z():
    # Haas lathe operator's manual, G14: Z is mirrored until G15; arcs turn the other way round
    text = "G0 X20. Z2.\nG14\nG0 Z2.\nG1 Z-5. F.2\nG2 X24. Z-7. R2.\nG15\nG0 Z3.\nM30"
    moves = survey(text, "haas-lathe").moves
    assert [m.end[2] for m in moves] == pytest.approx([2, -2, 5, 7, 3])
    assert [m.clockwise for m in moves if m.kind == "arc"] == [False]
    assert [m.work_spindle for m in moves] == [1, 2, 2, 2, 1]


# -- blocks -----------------------------------------------------------------------------------------------------------
def test_the_rest_of_a_block_can_be_left_out():
    # FANUC B-64304EN, optional block skip: what stands behind / in a block is left out
    text = "G0 X1. /Y2.\nX3. /2 Y4. Z5.\nM30"
    check("fanuc", text, "R 1 2 0 ; R 3 4 5")
    check("fanuc", text, "R 1 0 0 ; R 3 0 0", Setup(block_delete=True, strict=False))


def test_a_remark_names_the_line_of_a_block_that_can_be_left_out():
    found = survey("G0 X1.\nX3. /Y4.\nM30", "fanuc").warnings
    assert [(w.line, re.match(r'blocks with "/"', w.text) is not None) for w in found] == [(2, True)]


# -- what only the machine file knows ----------------------------------------------------------------------------------
def test_a_rotary_axis_without_a_machine_file_is_told_on_both_levels():
    text = "G21 G90\nG0 X0. Y0. A90.\nG1 X10. A0. F100.\nM30"
    assert "2: whether the machine has an axis A: taken as there" in assumed(text, "fanuc")
    said = [w.text for w in interpret(text, "fanuc").warnings]
    assert sum("whether the machine has an axis A" in t for t in said) == 1
    known = Setup(strict=False, axes=frozenset("XYZA"))
    assert not any("axis A" in a.what for a in interpret(text, "fanuc", known).assumed)


def test_q_of_g64_is_told():
    # LinuxCNC, G64 P Q: lines that lie within Q of one line are run as that line
    assert "Q of G64" in assumed("G21 G90\nG64 P0.05 Q0.01\nG0 X1\nM2", "linuxcnc")
    assert "Q of G64" not in assumed("G21 G90\nG64 P0.05 Q0\nG0 X1\nM2", "linuxcnc")


def test_offsets_in_the_memory_of_the_control_are_refused():
    with pytest.raises(
        DataError, match=r"G54.4 .workpiece setting error compensation. shifts and turns the work"
    ):
        survey("G21 G90\nG54.4 P1\nG0 X1.\nM30", "fanuc")
    assert len(survey("G21 G90\nG54.4 P0\nG0 X1.\nM30", "fanuc").moves) == 1


def test_g53_6_keeps_the_tip_of_its_own_tool_only():
    text = "G21 G90\nT1 M6\nG43 H1\nG68.2 X0. Y0. Z0. I0. J30. K0.\nG53.6 H{} R{}\nG0 X1.\nM30"
    assert "of G53.6" not in assumed(text.format("1", "0"), "fanuc")
    with pytest.raises(DataError, match=r"G53.6 H2 leads the tip of another length than that of tool 1"):
        interpret(text.format("2", "0"), "fanuc")
    with pytest.raises(DataError, match=r"R10 of G53.6 leads a point beside the tip"):
        interpret(text.format("1", "10."), "fanuc")


# -- radius without a number ------------------------------------------------------------------------------------------
def test_g41_without_d_is_asked_for_where_none_is_in_force():
    # FANUC B-64304EN, "cutter compensation": the offset number is D, D0 after power-on is no offset
    text = "G21 G90 G54 T4 M6\nG0 X0 Y0\n{before}G41{d}\nG1 X10. Y5. F100.\nX30.\nG40 X40.\nM30\n"
    strict = Setup(strict=True, tools={4: Tool(4, 0.0, 10.0)})
    for dialect in ("fanuc", "haas"):
        with pytest.raises(DataError, match="3:1: G41 has no D, and none is in force before it"):
            interpret(text.format(before="", d=""), dialect, strict)
        assert interpret(text.format(before="", d=" D4"), dialect, strict).moves[2].end[1] == pytest.approx(
            10.0
        )
        again = text.format(before="G41 D4\nG1 X20. F100.\nG40 X0.\n", d="")
        assert interpret(again, dialect, strict).moves  # D4 is in force
    assert interpret(text.format(before="", d=""), "mach3", strict).moves[2].end[1] == pytest.approx(
        10.0
    )  # the tool table


def test_p_of_g41_is_told_on_mach3():
    # router/p017 of the public programs: (TOOL DIA. 3) G41 P1.5; its way onto the contour is shorter than LinuxCNC accepts
    text = "G21 G90 G54 T7 M6\nG0 X0 Y0\nG41 P1.5\nG1 X10 Y5 F100\nX30\nG40 X40\nM30\n"
    assert "P of G41, the radius of the tool on Mach3" in assumed(text, "mach3")
    with pytest.raises(DataError, match=r"3:1: P of G41 .* is not understood; write D"):
        interpret(text, "mach3", Setup(strict=True))
