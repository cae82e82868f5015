"""Words of a block: feed, frames, tools, machine coordinates."""

from __future__ import annotations

import math

import numpy as np

from tests.program.sinumerik.programs import SETUP, check, moves
from vcmm.program.sinumerik.reader import read


def test_kinds_feed_and_source():
    got = moves("G0 X10\n  N20 G1 X20 F=50*4 S1000 M3\nX30 G95 F0.1")
    assert [m.kind for m in got] == ["rapid", "line", "line"]
    assert [m.feed for m in got] == [None, 200.0, 100.0]  # 0.1 mm x 1000 1/min
    assert got[1].source == (2, 3, 29)
    assert got[1].spindle == 1000.0


def test_inch():
    check("G70 G0 X1\nG71 X1", (25.4, 0, 0), (1, 0, 0))
    assert moves("G70 G1 X1 F100")[0].feed == 100.0  # G70 leaves feeds metric
    assert moves("G700 G1 X1 F10")[0].feed == 254.0


def test_work_offsets_and_machine_coordinates():
    check("G54 G0 X1 Y1\nG55 X1\nG500 Z1\nSUPA X0 Y0 Z0", (1, 1, 0), (101, 1, 0), (101, 1, 1), (0, 0, 0))
    last = moves("G55 G0 X1\nG53 Z0")[-1]
    assert last.rewritable is False
    assert last.end == (101, 0, 0)


def test_frames():
    check("G0\nTRANS X100 Y20\nX2 Y2\nATRANS X5\nX2 Y2\nTRANS\nX3 Y3", (102, 22, 0), (107, 22, 0), (3, 3, 0))
    # turn by 90 deg: (10, 0) -> (0, 10); ATRANS inside it shifts along the turned axes: (10 + 5, 0) -> (0, 15)
    check("G0\nROT RPL=90\nX10 Y0\nATRANS X5\nX10 Y0", (0, 10, 0), (0, 15, 0))
    # AROT after TRANS: (100, 0) + R30 (10, 0) = (100 + 8.660254, 5)
    check("G0\nTRANS X100\nAROT RPL=30\nX10 Y0", (100 + 10 * math.cos(math.pi / 6), 5, 0))
    # RPY: about Z by 90, then about the new X by 90: (0, 0, 1) -> R_z R_x (0, 0, 1) = R_z (0, -1, 0) = (1, 0, 0)
    check("G0\nROT X90 Z90\nX0 Y0 Z1", (1, 0, 0))
    check("G0\nSCALE X2 Y2\nX10 Y5", (20, 10, 0))


def test_mirror_turns_arcs_and_the_side_of_the_tool():
    text = "T1 D1\nG1 F100\nMIRROR X0\nG0 X-20 Y0\nG41 G1 X0 Y0\nX20\nG3 X30 Y10 CR=10\nG40 G1 X50"
    got = moves(text)
    # mirrored: x -> -x. The tool is left of +x, now right of -x, at y = +5; the arc about (20, 10) becomes clockwise
    assert np.allclose(
        [m.end for m in got[:4]], [(20, 0, 0), (0, 5, 0), (-20, 5, 0), (-25, 10, 0)], atol=1e-9
    )
    assert got[2].compensation == "right"
    assert got[3].clockwise is True
    assert np.allclose(got[3].centre, (-20, 10, 0))


def test_dwell():
    got = moves("S600 M3\nG4 F1.5\nG4 S30")
    assert [m.seconds for m in got] == [1.5, 3.0]  # 30 turns at 600 1/min


def test_tools_by_number_and_name():
    program = read('T="MILL_6"\nM6\nG0 Z0\nT1 M6\nZ0', "part.mpf", SETUP)
    assert [m.tool for m in program.moves] == [2, 1]
    assert program.moves[0].tool_offset == (0, 0, 80)
    assert program.moves[0].start == (0, 0, -80)  # the axes stand at zero, the tip 80 mm below
    assert program.tools == {1: "T1", 2: "MILL_6"}
    without = read("T2 D1\nG0 Z0\nD0 Z0", "part.mpf", SETUP)  # no M6 anywhere: T changes the tool
    assert [m.tool_offset[2] for m in without.moves] == [80, 0]


def test_the_tool_length_stays_along_z():
    program = read("T2 D1\nG0 Z0\nG18 G1 F100\nG2 X10 Z10 K10 I0\nG17 G0 X0", "part.mpf", SETUP)
    assert {m.tool_offset for m in program.moves} == {(0, 0, 80)}
    assert any("stays along Z" in r.text for r in program.warnings)
