"""G87 and G88 of Fagor mills: by pencil from the manual of the CNC 8055 (9.13). The tool has 10 mm."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

HEAD = "%PART,MX--,\nN10 G90 G17 G71\nN20 T1 D1 M6\nN30 G0 G43 X0 Y0 Z20 F200 S1000 M3\n"
TOOLS = {1: Tool(1, 50.0, 10.0)}


def moves(text: str, strict: bool = False):
    return interpret(HEAD + text + "G80\nM30\n", "fagor", Setup(strict=strict, tools=TOOLS)).moves[1:]


def test_a_rectangular_pocket_with_a_finishing_pass():
    """60 x 40 about (50, 30) from Z0 (2 mm below the plane Z2) to Z-8 in infeeds of 4: rings 4.83 apart up to 5.5 mm from the wall (14.5 / 3, C6
    at most), then 5 mm at H100; clockwise (J+): from (75, 30) down. Then 1 mm up, to the middle, and on."""
    made = moves("G98 G87 X50 Y30 Z2 I-8 J30 K20 B4 C6 D2 H100 L0.5 V80\nX150\n")
    one = [m for m in made if m.source.line == 5]
    assert [m.end for m in one[:2]] == [(50, 30, 20), (50, 30, 2)]
    assert (one[2].end, one[2].feed) == ((50, 30, -4), 80)
    wall = [m for m in one if m.feed == 100 and m.end[2] == -4]
    assert [m.end[:2] for m in wall] == [(75, 30), (75, 15), (25, 15), (25, 45), (75, 45), (75, 30)]
    rough = [m.end for m in one if m.feed == 200 and m.end[2] == -4]
    assert max(p[0] for p in rough) == pytest.approx(74.5)
    assert sorted({round(p[1], 3) for p in rough if p[1] > 30}) == [
        pytest.approx(30 + 14.5 * k / 3, abs=1e-3) for k in (1, 2, 3)
    ]
    levels = [m.end[2] for m in one]
    assert sorted(set(levels)) == [-8, -7, -4, -3, 2, 20]
    assert levels[-1] == 20
    assert made[-1].end == (150, 30, 20)  # modal: the second pocket at X150


def test_a_circular_pocket_by_the_infeed_as_it_is():
    """J-15: counter-clockwise, radius 10 of the centre; C is 3/4 of 10 mm: rings at 5 and 10; B-3 from Z0: -3 and the rest; V is half of F."""
    made = moves("G88 G99 X50 Y100 Z2 I-4 J-15 B-3 D2\n")
    arcs = [m for m in made if m.kind == "arc"]
    assert {m.clockwise for m in arcs} == {False}
    assert sorted({round(m.end[0] - 50, 6) for m in arcs}) == [5, 10]
    assert [m.end[2] for m in made if m.kind == "line" and m.start[:2] == m.end[:2]] == [-3, -4]
    assert {m.feed for m in made if m.kind == "line" and m.start[:2] == m.end[:2]} == {100}
    assert made[-1].end == (50, 100, 2)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("G87 X5 Y5 Z2 I-8 J30 B4\n", "5:.*G87 of Fagor needs J, K and B"),
        ("G88 X5 Y5 Z2 I-8 J4 B4\n", "the tool does not fit into the pocket"),
        ("G88 X5 Y5 Z2 I-8 J20 B4 C11\n", "up to the diameter of the tool"),
        ("G88 X5 Y5 Z2 I-8 J20 B4 C0\n", "up to the diameter of the tool"),
    ],
)
def test_what_the_control_refuses(text, message):
    with pytest.raises(DataError, match=message):
        moves(text)


def test_strict_refuses_how_it_clears():
    with pytest.raises(DataError, match=r"5:.*how G88 of Fagor clears is the control's own"):
        moves("G88 X5 Y5 Z2 I-8 J20 B4\n", strict=True)


def test_a_pocket_in_a_block_with_a_number_is_the_same():
    """N40 G88 ...: the number stays first (such blocks were refused: "N must be the first word")."""
    block = "G88 G99 X50 Y100 Z2 I-4 J-15 B-3 D2\n"
    assert [m.end for m in moves(f"N40 {block}")] == [m.end for m in moves(block)]
