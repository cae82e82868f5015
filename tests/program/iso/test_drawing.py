"""Angles and chamfers in the words of a straight cut of a lathe, and axes that the machine lacks: by hand from the manuals."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest

from tests.program.pencil import check
from vcmm.core.errors import DataError, VcmmError
from vcmm.files.own.setup import load_setup
from vcmm.program.interpret import interpret
from vcmm.program.iso.drawing import turns_c
from vcmm.program.setup import Setup

SURVEY = Setup(strict=False)
DRAWN = Setup(drawing_dimensions=True)
HEAD = "S1000 M3\nG0 X20. Z0.\n"
LATHE = Setup(axes=frozenset("XZC"))


def test_the_angle_of_a_line():
    # B-64304EN-1, direct drawing dimensions: X2 A, from +Z towards +X. 135 deg from (10, 0): 5 up in X is 5 back in Z
    check("haas-lathe", f"{HEAD}G1 X30. A135. F.2\nM30", "R 10 0 0 ; L 15 0 -5", Setup())
    check("fanuc-lathe", f"{HEAD}G1 X30. A135. F.2\nM30", "R 10 0 0 ; L 15 0 -5", DRAWN)
    # Z2 A: 10 back at 150 deg is 10 tan 30 deg up
    up = 10.0 + 10.0 * math.tan(math.radians(30.0))
    check("fanuc-lathe", f"{HEAD}G1 Z-10. A150. F.2\nM30", f"R 10 0 0 ; L {up} 0 -10", DRAWN)
    check("fanuc-lathe", f"{HEAD}G1 U10. A135. F.2\nM30", "R 10 0 0 ; L 15 0 -5", DRAWN)


def test_the_angle_of_a_line_is_an_option_of_fanuc():
    text = f"{HEAD}G1 X30. A135. F.2\nM30"
    with pytest.raises(DataError, match=r":3:9: A135\. is the angle.*drawing_dimensions = true"):
        interpret(text, "fanuc-lathe")
    with pytest.raises(DataError, match=r"A135\. is the angle"):
        interpret(text, "fanuc-lathe", replace(SURVEY, drawing_dimensions=False))
    found = interpret(text, "fanuc-lathe", SURVEY)
    assert any(a.what == "what A of a straight cut is" and a.line == 3 for a in found.assumed)
    assert all(m.rotary_end == (0.0, 0.0, 0.0) for m in found.moves)


@pytest.mark.parametrize("words", ["X30. A-45.", "X30. A0.", "X30. Z-5. A135."])
def test_an_angle_that_does_not_lead_there_is_refused(words: str):
    with pytest.raises(DataError, match=":3:"):  # -45 deg leads down in X, 0 deg never to X30
        interpret(f"{HEAD}G1 {words} F.2\nM30", "fanuc-lathe", DRAWN)


@pytest.mark.parametrize("word", ["C-2.", "K-2."])
def test_a_chamfer_behind_a_cut_along_x(word: str):
    # B-64304EN-1, chamfering: X20 (radius) less 2, then 2 along both legs, Z going the way of the sign
    text = f"{HEAD}G1 X40. {word} F.2\nZ-20.\nM30"
    for dialect in ("fanuc-lathe", "haas-lathe"):
        check(dialect, text, "R 10 0 0 ; L 18 0 0 ; L 20 0 -2 ; L 20 0 -20", Setup())
    assert all(m.rotary_end == (0.0, 0.0, 0.0) for m in interpret(text, "fanuc-lathe").moves)


@pytest.mark.parametrize("word", ["C2.", "I2."])
def test_a_chamfer_behind_a_cut_along_z(word: str):
    check(
        "fanuc-lathe",
        f"{HEAD}G1 Z-20. {word} F.2\nX40.\nM30",
        "R 10 0 0 ; L 10 0 -18 ; L 12 0 -20 ; L 20 0 -20",
        Setup(),
    )


@pytest.mark.parametrize(
    ("first", "then"), [("X40. K2.", "Z-20."), ("X40. K-2.", "X50. Z-20."), ("X40. I2.", "Z-20."), ("X40. Z-5. C2.", "Z-20.")]
)  # fmt: skip
def test_a_chamfer_that_the_control_refuses(first: str, then: str):
    with pytest.raises(VcmmError, match=":3:"):  # the sign, the next block, the letter, both axes
        interpret(f"{HEAD}G1 {first} F.2\n{then}\nM30", "fanuc-lathe", SURVEY)


def test_c_is_an_axis_where_machine_or_program_say_so():
    text = f"{HEAD}G1 X40. C-2. F.2\nZ-20.\nM30"
    moved = interpret(text, "fanuc-lathe", LATHE).moves
    assert moved[1].rotary_end[2] == pytest.approx(math.radians(-2.0))
    assert len(interpret(text, "fanuc-lathe", Setup(axes=frozenset("XZ"))).moves) == 4
    turning = f"{HEAD}G0 C90.\nG1 X40. C-2. F.2\nZ-20.\nM30"
    assert interpret(turning, "fanuc-lathe").moves[2].rotary_end[2] == pytest.approx(math.radians(-2.0))
    told = [
        a for a in interpret(text, "fanuc-lathe", SURVEY).assumed if a.what == "what C of a straight cut is"
    ]
    assert [a.line for a in told] == [3]
    assert turns_c("G12.1\nG1 X1. C2.")
    assert not turns_c("(G12.1)\nG1 X1. C2.")


@pytest.mark.parametrize("strict", [True, False])
@pytest.mark.parametrize(
    ("dialect", "axes", "text", "where"),
    [
        ("fanuc", "XYZ", "G0 X1.\nG0 A90.\nM30", ":2:4: the machine has no axis A"),
        ("fanuc", "XYZ", "G53 A90.\nM30", ":1:5: the machine has no axis A"),
        ("linuxcnc", "XYZ", "G0 A0\nM2", ":1:4: the machine has no axis A"),
        ("fanuc-lathe", "XZC", "G0 X1. B30.\nM30", ":1:8: the machine has no axis B"),
        ("fanuc", "XYZC", "G28 A0.\nM30", ":1:5: the machine has no axis A"),
        ("sinumerik", "XYZ", "G0 X1\nG0 A90\nM30", ":2:1: the machine has no axis A"),
    ],
)  # fmt: skip
def test_no_machine_takes_an_axis_that_it_lacks(dialect: str, axes: str, text: str, where: str, strict: bool):
    with pytest.raises(DataError, match=where):
        interpret(text, dialect, Setup(axes=frozenset(axes), strict=strict))
    assert interpret(text, dialect, Setup(axes=frozenset("XYZABC"), strict=strict)).moves


def test_the_axes_are_those_of_the_machine_file(tmp_path: Path):
    (tmp_path / "m.toml").write_text('vcmm = "machine/1"\n[axes.X]\n[axes.Z]\n', encoding="utf-8")
    (tmp_path / "s.toml").write_text(
        'vcmm = "setup/1"\nmachine = "m.toml"\ndrawing_dimensions = true\nunit = "inch"\n', encoding="utf-8"
    )
    setup = load_setup(tmp_path / "s.toml")
    assert (setup.axes, setup.drawing_dimensions, setup.unit) == (frozenset("XZ"), True, 25.4)
    (tmp_path / "s.toml").write_text('vcmm = "setup/1"\nmachine = "absent.toml"\n', encoding="utf-8")
    assert load_setup(tmp_path / "s.toml").axes is None


# -- units and points -------------------------------------------------------------------------------------------------
def test_the_unit_of_a_program_that_states_none():
    text = "(PART NO 7 - ALL UNITS IN INCHES)\nG0 X1. Y0.\nG1 X2. F10.\nM30"
    found = interpret(text, "fanuc", SURVEY)
    said = next(a for a in found.assumed if a.what.startswith("the unit"))
    assert found.moves[0].end[0] == 1.0
    assert said.value.startswith('mm; the comment of line 1 says "PART NO 7 - ALL UNITS IN INCHES"')
    assert str(said.blank) == 'unit = "inch"'
    inches = interpret(text, "fanuc", replace(SURVEY, unit=25.4))
    assert [m.end[0] for m in inches.moves] == pytest.approx([25.4, 50.8])
    assert inches.moves[1].feed == pytest.approx(254.0)  # 10 inch/min
    assert not any(a.what.startswith("the unit") for a in inches.assumed)
    stated = interpret("G21\n" + text, "fanuc", replace(SURVEY, unit=25.4)).moves
    assert stated[0].end[0] == 1.0  # what the program says counts
    with pytest.raises(DataError, match="a heidenhain program says it itself"):
        interpret("BEGIN PGM A MM\nEND PGM A MM\n", "heidenhain", Setup(unit=25.4))


@pytest.mark.parametrize(
    ("comment", "unit"), [("METRIC PROGRAM", "mm"), ("UNITS: IN", "inch"), ("1/2 INCH MILL", "inch"), ("T2 .375 DRILL", "inch"), ("T3 = 3/8 END MILL", "inch"), ("DIA-0.5000 TOOL", "inch"), ("D=6MM", "mm"), ("DATE 1/2", None), ("L0.5 F.015", None), ("PINCH", None), ("INCH, NOT METRIC", None)]
)  # fmt: skip
def test_what_a_comment_says_of_the_unit(comment: str, unit: str | None):
    from vcmm.program.iso.numbers import stated_unit

    found = stated_unit(f"O1\n({comment})\nG0 X1.\n")
    assert (found[0] if found else None) == unit
    assert found is None or found[1] == 2


def test_one_block_counts_by_one_rule():
    # every coordinate has its point: U-100 W10 of an inch program are 0.0100 and 0.0010 inch, and G75 R10 is 0.0010 inch
    text = "G20\nS500 M3\nG0 X2. Z.1\nG71 U100 R10\nG71 P1 Q2 U-100 W10 F.01\nN1 G0 X1.\nG1 Z-1.\nN2 X2.\nM30"
    cut = interpret(text, "fanuc-lathe", SURVEY)
    assert (
        max(abs(m.end[0]) for m in cut.moves) < 30.0
    )  # the start is at 25.4 mm; nothing goes out by 100 inch
    last = [m for m in cut.moves if m.kind == "line"]
    # allowances: W10 = 0.001 inch = 0.0254 mm off the shoulder at Z-1 inch = -25.4 mm
    assert min(m.end[2] for m in last) == pytest.approx(-25.4 + 0.0254)
    assert any("increments of 0.0001" in a.value for a in cut.assumed)
    with pytest.raises(
        DataError,
        match=r":4:5: U100 without a decimal point, where every coordinate has its own: 0.01 or 100\?",
    ):
        interpret(text, "fanuc-lathe")
    said = interpret(text, "fanuc-lathe", Setup(decimal_point="increment")).moves
    assert [m.end for m in said] == [m.end for m in cut.moves]


def test_a_short_retraction_of_an_inch_program_counts_increments():
    # R10 of G75 is 10 inch or 0.001 inch, R1 25.4 mm or 2.5 um
    for word in ("R10", "R1"):
        with pytest.raises(DataError, match=f"{word} without a decimal point"):
            interpret(f"G20\nS500 M3\nG0 X2. Z.1\nG75 {word}\nG75 X1. Q.1 F.01\nM30", "fanuc-lathe")
    metric = interpret("G21\nS500 M3\nG0 X50. Z1.\nG75 R1\nG75 X40. Q2000 F.1\nM30", "fanuc-lathe")
    assert metric.moves  # 1 mm is a retraction: calculator type, with a remark
