"""Circular pockets and bolt holes of Haas mills."""

from __future__ import annotations

import pytest

from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup


def moves(text: str):
    return interpret(f"%\nO1\nG21 G90 G17 F100.\n{text}\nM30\n%", "haas", Setup(strict=False)).moves


def test_g13_goes_out_round_and_back():
    found = moves("G0 X50. Y40.\nZ1.\nG13 Z-2. I10.")
    assert found[2].end == (50, 40, -2)
    arcs = [m for m in found if m.kind == "arc"]
    assert [a.end for a in arcs] == [(60, 40, -2), (60, 40, -2), (50, 40, -2)]
    assert {a.clockwise for a in arcs} == {False}
    assert arcs[1].centre == (50, 40, -2)
    assert arcs[0].centre == (55, 40, -2)


def test_g12_widens_in_steps():
    arcs = [m for m in moves("G0 X0 Y0\nG12 Z-2. I5. K12. Q4.") if m.kind == "arc"]
    assert [a.end[0] for a in arcs if a.centre == (0, 0, -2)] == [5, 9, 12]


@pytest.mark.parametrize(
    ("code", "holes"),
    [
        ("G70 I10. J0 L4", [(10, 0), (0, 10), (-10, 0), (0, -10)]),
        ("G71 I10. J90. K90. L2", [(0, 10), (-10, 0)]),
        ("G72 I5. J0 L3", [(0, 0), (5, 0), (10, 0)]),
    ],
)
def test_bolt_holes(code: str, holes: list[tuple[float, float]]):
    found = moves(f"G0 X0 Y0 Z5.\nG81 Z-3. R1. L0\n{code}\nG80")
    bottoms = [m.end for m in found if m.kind == "line"]
    assert [b[:2] for b in bottoms] == [pytest.approx(h, abs=1e-9) for h in holes]
    assert {b[2] for b in bottoms} == {-3}
