"""The order of a block: feed, speed, dwell, path control."""

from __future__ import annotations

import pytest

from tests.program.meanings import fanuc, linuxcnc
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup


# -- feeds and spindle ------------------------------------------------------------------------------------------------
def test_feeds():
    moves = linuxcnc("G21 S1000 M3\nG95 F0.2 G1 X10\nG93 G1 X20 F2\nG94 F300 G1 X30\nG20 F10 G1 X2\nF10 X3")
    # 0.2 mm per turn x 1000; 10 mm in half a minute; 300; 10 mm/min, for RS274 takes F before G20; 10 inch/min
    assert [m.feed for m in moves] == pytest.approx([200, 20, 300, 10, 254])
    assert fanuc("G20 G1 X2. F10.")[0].feed == pytest.approx(254)  # Fanuc: the unit of the block counts
    assert moves[0].spindle == 1000


def test_constant_cutting_speed_with_its_limit():
    moves = linuxcnc("G21 G18 G8 G96 D2000 S100 M4 G95 F0.1\nG0 X20\nG1 Z-1\nG0 X1\nG1 Z-2")
    # 100 m/min on radius 20: 100e3 / (2 pi 20) = 795.77 turns/min; on radius 1 15915, limited to 2000
    assert [m.spindle for m in moves if m.kind == "line"] == pytest.approx([-795.7747, -2000])
    assert [m.feed for m in moves if m.kind == "line"] == pytest.approx([79.57747, 200])


def test_dwell_in_ms_and_s():
    assert [m.seconds for m in fanuc("G4 P500\nG4 X1.5\nG4 U2.")] == [0.5, 1.5, 2.0]
    assert [m.seconds for m in linuxcnc("G4 P0.5")] == [0.5]


def test_path_control():
    moves = linuxcnc("G21 F100 G64 P0.02\nG1 X1\nG61 X2\nG64 X3")
    assert [(m.exact_stop, m.tolerance) for m in moves] == [(False, 0.02), (True, None), (False, None)]
    assert [m.exact_stop for m in fanuc("G1 X1. F100.\nG9 X2.\nX3.")] == [False, True, False]


@pytest.mark.parametrize("dialect", ["fanuc", "haas"])
def test_positioning_from_one_side_is_one_block_at_rapid_and_told(dialect):
    """G60 stands for one block: at rapid, also under G1. How far the axis runs past the end point stands in the control."""
    text = "G21 G90 G0 X0\nG1 X10. F100.\nG60 X50.\nX60.\nM30\n"
    program = interpret(text, dialect, Setup(strict=False))
    assert [(m.kind, m.end[0]) for m in program.moves[-3:]] == [("line", 10), ("rapid", 50), ("line", 60)]
    assert [(a.line, a.what) for a in program.assumed] == [(3, "G60, positioning from one side")]
    assert any("runs past it" in w.text for w in interpret(text, dialect, Setup()).warnings)


def test_a_change_of_the_pallet_is_told():
    said = interpret("G21 G90 G0 X0\nM50\nM60\nX1.\nM30\n", "haas", Setup()).warnings
    assert [w.text[:3] for w in said if "pallet" in w.text] == ["M50", "M60"]
    assert not any(
        "pallet" in w.text for w in interpret("G21 G90 G0 X0\nM50\nM30\n", "fanuc", Setup()).warnings
    )
