"""What shops really write: each case with the rule of the control's manual behind it."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.reading import guess
from vcmm.program.setup import Setup

SURVEY = Setup(strict=False)


def read(text: str, dialect: str | None = "fanuc"):
    return interpret(text, dialect, SURVEY)


def ends(text: str, dialect: str | None = "fanuc") -> list[tuple[float, ...]]:
    return [m.end for m in read(text, dialect).moves]


def test_g80_is_no_motion_code_of_group_01():
    # FANUC "G code list": G80 is of group 09; B-64304EN, canned cycle: G00 to G03 stay in force behind it
    assert interpret("G0 G17 G40 G49 G80 G90\nX5. Y6.\nM30", "fanuc").moves[0].kind == "rapid"
    found = read("G21 F100.\nG0 Z5.\nG81 X1. Y0. Z-2. R1.\nG80\nZ20.\nM30").moves
    assert (found[-1].kind, found[-1].end) == ("rapid", (1, 0, 20))
    with pytest.raises(DataError, match="without a motion code"):  # RS274 3.5.15: G80 leaves none
        read("G21 F100 G98\nG0 Z5\nG81 X1 Y0 Z-2 R1\nG80\nZ20\nM2", "linuxcnc")


def test_the_later_of_a_cycle_and_a_motion_counts():
    assert read("G21 F100.\nG0 G81 X1. Y0. Z-2. R1.\nM30").moves[-2].kind == "line"
    assert [m.kind for m in read("G21 F100.\nG81 G0 X1. Y0. Z-2. R1.\nM30").moves] == ["rapid"]


def test_of_two_codes_of_a_group_the_last_counts():
    # FANUC, "preparatory function": of several G codes of one group in a block the last is effective
    assert read("G21 F100.\nG0 G1 X10.\nM30").moves[0].kind == "line"


def test_text_before_the_first_percent_is_a_leader():
    # FANUC, "tape start": everything up to the first % is skipped
    assert ends("(made by)\nGARBAGE § here\n%\nO1\nG0 X1.\nM30\n%\nG0 X9.") == [(1, 0, 0)]
    assert ends("%\nO1\nG0 X1.\n%\nG0 X9.\n") == [(1, 0, 0)]


def test_notes_behind_a_semicolon():
    assert ends("N1 G0 X1.; rapid move\nN2 Y2. ; and on\n; all over\nM30") == [(1, 0, 0), (1, 2, 0)]
    with pytest.raises(DataError, match="second block"):
        read("G0 X1.; Y2.\nM30")


def test_two_tools_in_the_block_of_m6():
    # Mazak EIA: T of the change, then T of the next tool
    program = read("G21 F100.\nT02 T05 M06\nG1 X1.\nM06\nX2.\nM30", "mazak")
    assert [m.tool for m in program.moves] == [2, 5]


def test_output_and_titles_move_nothing():
    assert ends("%\nO0001(PLATE)\nDPRNT[X#100[53]]\nPOPEN\nG0 X1.\nPCLOS\nM30") == [(1, 0, 0)]
    assert ends("%\nOWASHER(ROUND)\n<PLATE-7>\nG0 X1.\nM30") == [(1, 0, 0)]


def test_corners_rounded_and_cut_by_comma_words():
    # FANUC, "optional chamfering and corner R": a right corner at (10, 0) with R2 touches at (8, 0) and (10, 2)
    found = read("G21 F100.\nG1 X10. Y0 ,R2.\nY10.\nM30").moves
    assert [m.end[:2] for m in found] == [
        pytest.approx((8, 0)),
        pytest.approx((10, 2)),
        pytest.approx((10, 10)),
    ]
    found = read("G21 F100.\nG1 X10. Y0, C 2.\nY10.\nM30").moves
    assert [m.end[:2] for m in found] == [
        pytest.approx((8, 0)),
        pytest.approx((10, 2)),
        pytest.approx((10, 10)),
    ]


def test_centres_from_the_work_zero_are_recognised():
    program = read("G21 F100.\nG0 X10. Y0\nG3 X0 Y10. I0 J0\nX-10. Y0 I0 J0\nM30", "mach3")
    assert [m.centre for m in program.moves[1:]] == [(0, 0, 0), (0, 0, 0)]
    assert [a.what for a in program.assumed if "I J K" in a.what] == ["how I J K count"]


def test_an_arc_without_radius_is_a_line_on_fanuc():
    # FANUC parameter 3403 CIR = 0
    assert read("G21 F100.\nG2 X10. Y0\nM30").moves[0].kind == "line"
    with pytest.raises(DataError, match="neither R nor a centre"):
        interpret("G21 F100.\nG2 X10. Y0\nM30", "fanuc")


def test_words_without_a_point_in_a_program_of_points():
    program = read("G21 F100.\nG0 X0. Y0. Z5.\nG83 X1. Y1. Z-6. R2. Q4000\nM30")  # 4000 increments are 4 mm
    assert [m.end[2] for m in program.moves if m.kind == "line"] == [-2, -6]
    assert any(a.what == "words without a decimal point" for a in program.assumed)


def test_haas_offsets_and_local_subprograms():
    setup = Setup(strict=False, offsets={"G54.1 P2": (100.0, 0.0, 0.0), "G54.1 P1": (7.0, 0.0, 0.0)})
    text = "%\nO1\nG21 G90 G154 P2 G0 X1.\nG110 X2.\nM97 P100 L2\nM30\nN100 G91 Y1.\nM99\n%"
    assert [m.end for m in interpret(text, "haas", setup).moves] == [
        (101, 0, 0),
        (9, 0, 0),
        (9, 1, 0),
        (9, 2, 0),
    ]


def test_rs274_takes_the_feed_before_the_unit():
    # RS274/NGC 3.8: F is executed before G20 and G21
    assert [m.feed for m in interpret("G20 F10 G1 X1\nF10 X2\nM2", "linuxcnc").moves] == pytest.approx(
        [10, 254]
    )


def test_g85_goes_out_at_feed_to_r_and_on_at_rapid():
    # LinuxCNC 2.9 and Fanuc alike: at feed to R, with G98 on at rapid to the level where the cycle began
    for dialect in ("linuxcnc", "fanuc"):
        found = interpret("G21 F100\nG0 Z20.\nG98 G85 X1. Y0 Z-2. R1.\nM2", dialect).moves
        assert [(m.kind, m.end[2]) for m in found[-3:]] == [("line", -2), ("line", 1), ("rapid", 20)]


def test_an_alarm_of_its_own_ends_the_program():
    program = read("O1\nG0 X1.\n#3000=5 (BROKEN)\nX2.\nM30")
    assert len(program.moves) == 1
    assert program.assumed[-1][:3] == (
        3,
        "the alarm #3000 = 5",
        "the program ends here",
    )


def test_what_is_not_modelled_is_named_once_with_its_line():
    program = read("G21 F100.\nG31 Z-10.\nM444\nG31 Z-20.\nM30")
    told = [(a.line, a.what) for a in program.assumed]
    assert told == [
        (2, "G31 (the skip function: where it stops is decided by a probe)"),
        (3, "M444, a code of the machine builder"),
    ]
    assert [m.end[2] for m in program.moves] == [-10, -20]


def test_a_second_program_is_told():
    program = read("O1\nG0 X1.\nO2\nG0 X2.\nM30")
    assert len(program.moves) == 1
    assert program.assumed[-1].what == "the end of the program before O2"
    after = read("%\nO1\nG0 X1.\nM30\n%\n%\nO2\nG0 X5.\nM30\n%")
    assert [(w.line, w.text[:27]) for w in after.warnings] == [(7, "a second program, O2, begin")]
    library = read("O1\nG0 X1.\nM98 P2\nM30\nO2\nG0 X5.\nM99\nO3\nG0 X7.\nM99")
    assert not library.warnings


@pytest.mark.parametrize("code", ["G53 Z0", "G28 Z0."])
def test_compensation_rests_while_the_axes_go_home(code: str):
    program = read(f"G21 F100.\nG41 D1 G1 X10.\nX20.\n{code}\nG1 X30.\nG40 X40.\nM30")
    assert [m.compensation for m in program.moves if not m.rewritable] in ([None], [None, None])


def test_grbl_and_mach3_need_no_end_and_no_motion_code():
    assert ends("$H\nG21 G90 ; mm\nX1 Y2\nG4 P0.5\n", "grbl") == [(1, 2, 0), (1, 2, 0)]
    assert ends("G21 G91.1 G90\nG0 X1\nG80\nZ5\n", "mach3") == [(1, 0, 0), (1, 0, 5)]


def test_pecks_of_haas_that_grow_smaller():
    # G83 I4 J1 K2: 4, 3, 2, 2 ... of 10 mm from R 1
    found = read("%\nO1\nG21 G90 F100.\nG0 Z5.\nG83 X0 Y0 Z-10. R1. I4. J1. K2.\nM30\n%", "haas").moves
    assert [m.end[2] for m in found if m.kind == "line"] == [-3, -6, -8, -10]


def test_a_subprogram_called_by_its_name(tmp_path):
    from vcmm.program.interpret import read_program

    (tmp_path / "RING.nc").write_text("G91 X1.\nM99\n")
    (tmp_path / "main.nc").write_text(
        "%\nO1\nG21 G90 G0 X0.\nM98 <RING> L2\nM98 (RING.NC)\nM98 <GONE>\nM30\n%"
    )
    program = read_program(tmp_path / "main.nc", "fanuc", SURVEY)
    assert [m.end[0] for m in program.moves] == [0, 1, 2, 3]
    assert [a.what for a in program.assumed] == ["the subprogram GONE (GONE)"]


def test_a_colon_before_a_tool_change_is_a_block_number():
    """Posts write the block of a tool change as :0030 T01 M06; a program number stands alone."""
    text = ":0001\nN10 G21 G90\n:0020 T01 M06\nN30 G0 X1.\nM30\n"
    assert [m.tool for m in interpret(text, "fanuc", Setup(strict=False)).moves] == [1]


def test_the_iso_mode_of_sinumerik_is_read_as_fanuc():
    dialect, why = guess("G291\nG90 G54\nG0 X10. Y5.\nG290\nM30\n", None)
    assert dialect == "fanuc"
    assert "G291" in why
