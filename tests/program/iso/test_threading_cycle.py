"""G76 of LinuxCNC: depths and places of its passes by hand."""

from __future__ import annotations

import pytest

from tests.program.meanings import linuxcnc


def test_threading_cycle_depths():
    # J 0.2, equal areas: 0.2, 0.2 sqrt 2 = 0.283, 0.2 sqrt 3 = 0.346, then the full 0.4 and one spring pass
    moves = linuxcnc("G21 S500 M3 G18 G8\nG0 X10 Z2\nG76 P1 Z-10 I-1 J0.2 K0.4 R2 H1")
    cuts = [m for m in moves if m.kind == "thread"]
    assert [m.end[0] for m in cuts] == pytest.approx([8.8, 9 - 0.2 * 2**0.5, 9 - 0.2 * 3**0.5, 8.6, 8.6])
    assert [m.end[0] for m in moves if m.kind == "rapid"][1] == pytest.approx(10.2)  # depth 8.8 + 1 + 0.4
    assert moves[-1].end == pytest.approx((10, 0, -10))


def test_threading_cycle_along_the_flank_and_with_a_taper():
    # tan 29.5 deg = 0.565773: the first pass, 0.2 deep, begins 0.113155 further on and ends 0.2 x 0.565773 before Z
    moves = linuxcnc("G21 S500 M3 G18 G8\nG0 X10 Z2\nG76 P1 Z-10 I-1 J0.2 K0.4 R2 Q29.5 E1 L2")
    first = [(m.kind, *(round(v, 4) for v in (m.end[0], m.end[2]))) for m in moves[1:6]]
    assert first == [
        ("rapid", 10.2, 1.8868), ("rapid", 8.8, 1.8868), ("thread", 8.8, -8.8868), ("thread", 9.2, -9.8868), ("rapid", 10.2, -9.8868),
    ]  # fmt: skip
    # the pitch counts along Z: 1 mm x sqrt(1 + 0.4^2) = 1.07703 per turn on the taper, 500 turns/min
    assert [m.feed for m in moves[3:5]] == pytest.approx([500, 538.516], abs=1e-3)
