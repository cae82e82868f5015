"""Strict refuses what a program lacks; a survey takes what the machine would have in its memory, and says so once."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.nc.interpret import interpret, read_for
from vcmm.nc.levels import Assumed, SetupEntry, demand
from vcmm.nc.setup import Setup

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
        Assumed(4, "the diameter of tool 3", "0 mm", SetupEntry("tools.3", "diameter", '"10 mm"')),
        Assumed(9, "the subprogram O5", "a hole in the path"),
        Assumed(12, "M30", "the end of the text", matters=False),
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
    with pytest.raises(DataError, match="stands twice"):  # what is wrong in itself is refused as it is
        read_for("cut", "G21\nG0 X1. X2.\nM30", "fanuc", Setup())
    assert len(read_for("cut", "G21\nG0 X1.\nM30", "fanuc", Setup()).moves) == 1
