"""An NC program as tables: a line, an arc and a dwell by hand."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import pytest

from tests.programs import line, mill
from vcmm.program.interpret import read_program
from vcmm.program.summary import summary
from vcmm.show.tables import program as tables
from vcmm.show.tables.table import in_terminal


@pytest.fixture(scope="module")
def read(tmp_path_factory):
    path = tmp_path_factory.mktemp("nc") / "p.nc"
    path.write_text("%\nG21 G17 G90 G94\nG0 X0 Y0 Z0\nG1 X10. F100\nG2 X20. Y0 I5. J0\nG4 P500\nM30\n%\n")
    return read_program(path, "fanuc", None)


def test_moves(read):
    rows = in_terminal(tables.moves("p.nc", read)).rows
    line, arc, dwell = (next(r for r in rows if r[1] == kind) for kind in ("line", "arc G2", "dwell"))
    assert line[:4] == ["4", "line", "0.0000 0.0000 0.0000", "10.0000 0.0000 0.0000"]
    assert line[5] == "100"
    assert arc[4] == "15.0000 0.0000 0.0000"
    assert dwell[4] == "0.5 s"


def test_moves_of_a_document(read):
    by = {m.kind: tables.move_json(m) for m in read.moves}
    assert by["arc"]["centre_mm"] == [15.0, 0.0, 0.0]
    assert by["arc"]["clockwise"] is True
    assert by["dwell"]["seconds"] == 0.5
    assert "seconds" not in by["line"]
    assert set(by["line"]) == {
        "type", "line", "start_mm", "end_mm", "plane", "centre_mm", "turns", "clockwise", "feed_mm_min", "spindle_rpm",
        "tool", "compensation",
    }  # fmt: skip


def test_kinds_and_extents(read):
    total = summary(read.moves)
    kinds = {row[0]: row[1:] for row in in_terminal(tables.kinds("p.nc", read, total)).rows}
    assert kinds["line"] == ["1", "10.000 mm"]
    assert kinds["arc"] == ["1", "15.708 mm"]  # half a circle of radius 5
    assert in_terminal(tables.extents(read, total)).rows[0][0] == "cutting time at the programmed feed"


def test_travels_of_the_axes_go_with_the_tool_offset():
    """The axes stand at the point plus the tool offset: tip at Z -5 and 10 under a tool of 60 mm is 55 to 70; X 1 + 2 to 4 + 2."""
    ends = [(1.0, 0.0, -5.0), (4.0, 0.0, 10.0)]
    moves = [line((0, 0, 0), end, tool_offset=(2.0, 0.0, 60.0), rotary_end=(0.0, 0.0, 0.5)) for end in ends]
    machine = mill()
    axes = machine.axes | {"Z": replace(machine.axes["Z"], travel=(0.0, 69.0))}
    rows = tables.travels(SimpleNamespace(moves=moves), replace(machine, axes=axes)).rows
    assert {r[0]: (r[1], r[3]) for r in rows} == {
        "X": ("3.000 to 6.000 mm", "yes"),
        "Y": ("0.000 to 0.000 mm", "yes"),
        "Z": ("55.000 to 70.000 mm", "no"),
        "C": ("28.648 to 28.648 deg", "yes"),  # 0.5 rad x 180 / pi
    }


def test_times():
    path = SimpleNamespace(
        seconds=80.0, seconds_by=lambda what: {"1": 20.0} if what == "tool" else {"feed": 60.0}
    )
    assert in_terminal(tables.times(path)).rows == [
        ["cycle time", "80.0 s", "0:01:20"],
        ["mode feed", "60.0 s", "75%"],
        ["tool 1", "20.0 s", "25%"],
    ]


def test_remarks():
    """What `unused` says already is not said again."""
    warnings = (
        SimpleNamespace(line=3, column=7, text="said"),
        SimpleNamespace(line=4, column=1, text="K is not used"),
    )
    program = SimpleNamespace(warnings=warnings, unused=(SimpleNamespace(text="K is not used"),))
    assert in_terminal(tables.remarks("p.nc", program)).rows == [["p.nc:3:7", "said"]]


@pytest.mark.parametrize(("count", "words"), [(0, "0 moves"), (1, "1 move"), (2, "2 moves")])
def test_one_move_is_not_called_moves(count, words):
    program = SimpleNamespace(moves=[None] * count, dialect="iso")
    title = tables.kinds("p.nc", program, SimpleNamespace(counts={}, lengths={})).title
    assert title == f"p.nc: {words}, dialect iso"
