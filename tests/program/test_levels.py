"""Strict refuses what a program lacks; a survey takes what the machine would have in its memory, and says so once."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret, read_for
from vcmm.program.levels import Assumption, SetupEntry, demand
from vcmm.program.setup import Setup, Tool

SURVEY = Setup(strict=False)
CUT = "G21 G90 G17 F100.\nT3 M6\nG0 X0. Y0.\nG41 D3 G1 X10.\nY10.\nG40 X30.\nG41 D3 X40.\nG40 Y0.\nM30\n"


def test_an_unknown_diameter_is_the_programmed_contour_and_marked():
    program = interpret(CUT, "fanuc", SURVEY)
    assert [m.end[:2] for m in program.moves[1:4]] == [(10.0, 0.0), (10.0, 10.0), (30.0, 10.0)]
    assert [m.compensation for m in program.moves[1:4]] == ["left", "left", None]
    assert [(a.line, a.what) for a in program.assumed] == [
        (4, "the diameter of tool 3")
    ]  # once, not at line 7 too


def test_strict_refuses_what_a_survey_assumes():
    with pytest.raises(DataError, match=r"program:4:\d+: .*diameter of tool 3"):
        interpret(CUT, "fanuc")


@pytest.mark.parametrize("dialect", ["fanuc", "linuxcnc", "sinumerik"])
def test_a_feed_that_the_caller_sets_is_not_known(dialect):
    program = interpret("G90 G0 X0 Y0\nG1 X10.\nM30\n", dialect, SURVEY)
    assert program.moves[-1].feed is None
    assert [(a.line, a.what) for a in program.assumed if "unit" not in a.what] == [(2, "the feed")]


def test_a_demand_names_every_number_and_how_to_give_it():
    missing = (
        Assumption(4, "the diameter of tool 3", "0 mm", SetupEntry("tools.3", "diameter", '"10 mm"')),
        Assumption(9, "the subprogram O5", "a hole in the path"),
        Assumption(12, "M30", "the end of the text", matters=False),
    )
    with pytest.raises(DataError) as caught:
        demand(missing, "part.nc", "cut")
    first, second = caught.value.problems
    assert first.startswith(
        'part.nc:4:1: cut needs the diameter of tool 3: write [tools.3] diameter = "10 mm" in'
    )
    assert second.startswith("part.nc:9:1: cut needs the subprogram O5:")
    demand(missing[2:], "part.nc", "cut")


def test_a_job_that_needs_every_number_reads_strictly_and_names_them_all():
    text = CUT.replace("F100.", "").replace("M30", "M98 P9\nM30")
    with pytest.raises(DataError) as caught:
        read_for("compensate", text, "fanuc", Setup(), name="part.nc")
    assert [p.split(": ")[1] for p in caught.value.problems] == [
        "compensate needs the diameter of tool 3", "compensate needs the feed", "compensate needs the subprogram O9 (O0009.nc)",
    ]  # fmt: skip
    with pytest.raises(DataError, match="appears twice"):  # what is wrong in itself is refused as it is
        read_for("cut", "G21\nG0 X1. X2.\nM30", "fanuc", Setup())
    assert len(read_for("cut", "G21\nG0 X1.\nM30", "fanuc", Setup()).moves) == 1


def test_a_code_of_another_system_is_named_with_the_right_one():
    """G-code system A of a FANUC lathe: G99 is the feed per turn, G95 a tapping cycle (B-64304EN, 3.2, table of G codes)."""
    with pytest.raises(DataError) as caught:
        read_for(
            "calibrate face",
            "G21\nG97 S500 M3\nG95\nG0 X50. Z2.\nG1 Z-10. F0.1\nM30",
            "fanuc-lathe",
            Setup(),
            name="face.nc",
        )
    (said,) = [p for p in caught.value.problems if ":3:" in p]
    assert said.startswith(
        "face.nc:3:1: G95 (tapping with a driven tool in G-code system A) is not understood"
    )
    assert "write G99" in said
    assert "a survey takes" not in said


TOOLED = {
    "fanuc": "G21 G90\nT1 M6\nG43 H1 G0 Z5.\nM30\n", "haas": "G21 G90\nT1 M6\nG43 H1 G0 Z5.\nM30\n",
    "linuxcnc": "G21 G90\nT1 M6\nG43 H1 G0 Z5.\nM2\n", "sinumerik": "T1 D1\nM6\nG0 Z5\nM30\n",
    "heidenhain": "BEGIN PGM E MM\nTOOL CALL 1 Z S1000\nL Z+5 FMAX\nEND PGM E MM\n", "fanuc-lathe": "G21 T0101\nG0 Z5.\nM30\n",
    "okuma": "G21 G15 H1\nT1 M6\nG56 HA G0 Z5\nM2\n", "mach3": "G21 G90\nT1 M6\nG43 H1 G0 Z5\nM30\n",
}  # fmt: skip


@pytest.mark.parametrize("dialect", TOOLED)
def test_a_tool_that_is_not_known_is_told_and_refused_in_one_way_in_every_language(dialect: str):
    """Survey: assumed, with and without a tool table; strict: refused where the table lacks it, a remark where there is none."""
    text, table = TOOLED[dialect], {9: Tool(9, 80.0, 10.0)}
    for tools in ({}, table):
        told = interpret(text, dialect, Setup(strict=False, tools=tools)).assumed
        assert [(a.what, a.value) for a in told] == [("tool 1", "a tool without length")]
    with pytest.raises(
        DataError, match=r"tool 1 \(.*1\) is not in the set-up file, which has 9; add \[tools.1\]"
    ):
        interpret(text, dialect, Setup(tools=table))
    bare = interpret(text, dialect, Setup())
    assert "the length of tool 1 is not known" in bare.warnings[0].text
    assert not bare.assumed


def test_the_unit_that_nothing_states_is_told_on_both_levels():
    text = "G0 X1.\nM30\n"
    assert interpret(text, "fanuc", Setup()).warnings[-1].text == "the unit, for want of G20 and G21: mm"
    assert (
        interpret(text, "fanuc", Setup(strict=False)).assumed[-1].what == "the unit, for want of G20 and G21"
    )


def test_strict_tells_of_a_tilted_plane_and_reads_it():
    """As docs/nc.md says: what moves the axes alone is a remark under --strict, and no refusal."""
    text = "G21 G90 G54 F100.\nT1 M6\nG43 H1 Z20.\nG68.2 X0 Y0 Z0 I0 J30. K0\nG53.1\nG1 X10.\nG69\nM30\n"
    program = interpret(text, "fanuc", Setup())
    assert [(r.line, r.text.split(",")[0]) for r in program.warnings] == [
        (3, "the length of tool 1 is not known and taken as 0 mm; give the tools with --setup"),
        (4, "G68.2"), (5, "G53.1"),
    ]  # fmt: skip
    assert not program.assumed
