"""From moves to swept tools, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool
from vcmm.shop.machining.program_sweep import cutter, sweep_of_moves

HEAD = "%\nO1\nG21 G17 G40 G80 G90 G94 G54\nT1 M6\nS1000 M3\nG0 X10. Y0 Z0\n"


def moves(body: str):
    setup = Setup(dialect="fanuc", offsets={"G54": (0.0, 0.0, 0.0)}, tools={1: Tool(1, 0.0, 10.0)})
    return interpret(f"{HEAD}{body}M30\n%\n", "fanuc", setup, "part.nc").moves


def test_an_arc_to_the_right_turns_by_minus_its_angle():
    """G2 from (10, 0) to (0, 10) about 0 is three quarters of a turn clockwise; two turns more with P3 on a helix."""
    sweep = sweep_of_moves(moves("G2 X0 Y10. I-10. J0 F100\n"), {1: Tool(1, 0.0, 10.0)})
    assert sweep.turn[-1] == pytest.approx(-1.5 * math.pi)
    assert sweep.centre[-1] == pytest.approx([0.0, 0.0, 0.0])
    assert sweep.tools[0].radius == 5.0


def test_a_full_circle_is_one():
    sweep = sweep_of_moves(moves("G3 X10. Y0 I-10. J0 F100\n"), {1: Tool(1, 0.0, 10.0)})
    assert sweep.turn[-1] == pytest.approx(2 * math.pi)


def test_a_rapid_cuts_and_a_pause_does_not():
    found = sweep_of_moves(moves("G1 X20. F100\nG4 P1000\nG0 X30.\n"), {1: Tool(1, 0.0, 10.0)})
    kinds = [moves("G1 X20. F100\nG4 P1000\nG0 X30.\n")[i].kind for i in found.move.tolist()]
    assert kinds[-2:] == ["line", "rapid"]
    assert np.isfinite(found.start).all()


def test_tools_by_their_words():
    assert cutter(Tool(1, 0.0, 10.0, shape="bull", corner_radius=1.0)).corner == 1.0
    assert cutter(Tool(1, 0.0, 10.0, shape="ball")).corner == 5.0
    with pytest.raises(UsageError, match="no diameter"):
        cutter(Tool(3, 0.0, None))
    with pytest.raises(UsageError, match="line 7 cuts with tool 1, which is not in the set-up"):
        sweep_of_moves(moves("G1 X20. F100\n"), {2: Tool(2, 0.0, 10.0)})
