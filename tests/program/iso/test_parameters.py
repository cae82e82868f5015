"""Parameters that the control fills in."""

from __future__ import annotations

from tests.program.meanings import ONE, fanuc, linuxcnc


def test_parameters_of_the_control():
    moves = linuxcnc("G21 G54\nG0 X3 Y4\nG0 X[#5420 + #5221] Y#<_y> Z[#<_metric> + EXISTS[#<depth>]]", ONE)
    assert moves[-1].end == (100 + 103, 54, -199)
    assert fanuc("G21 G0 X3.\nG0 X[#5041+1] Y#5221", ONE)[-1].end == (104, 150, 0)
