"""G150 of Haas: pockets of any shape, worked out from the manual."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

SQUARE = "M30\nO200\nG1 Y40.\nX10.\nY0.\nX50.\nY40.\nX30.\nM99\n"  # 40 x 40, counter-clockwise from (30, 40)
CALL = "G21 G90 G0 X30. Y20. Z50. S1000 M3 F100.\n"
SETUP = Setup(strict=False, tools={1: Tool(1, 0.0, 10.0)})


def moves(block: str, rest: str = SQUARE, setup: Setup = SETUP):
    return interpret(f"{CALL}{block}\nG40 X30. Y20.\n{rest}", "haas", setup)


def test_a_square_pocket():
    """D1 = 5 mm, K0.5: centre 5.5 mm inside at Z -3 and -4 (from R2 by 5 and then 1), along X rows 29 / 4 apart (J8.), last at 5 mm at the depth."""
    made = moves("G150 G41 D1 X30. Y20. Z-4. R2. Q5. J8. K0.5 P200").moves
    cut = [m for m in made if m.kind == "line" and m.source.line == 2]
    assert {m.end[2] for m in cut} == {-3.0, -4.0}
    first = [m.end for m in cut if m.end[2] == -3.0]
    assert np.allclose(
        first[:7],
        [
            (x, y, -3)
            for x, y in (
                (30, 20),
                (30, 34.5),
                (15.5, 34.5),
                (15.5, 5.5),
                (44.5, 5.5),
                (44.5, 34.5),
                (30, 34.5),
            )
        ],
    )
    rows = sorted(
        {
            round(m.end[1], 3)
            for m in cut
            if m.end[2] == -3.0 and m.start[1] == m.end[1] and abs(m.end[0] - m.start[0]) > 28
        }
    )
    assert rows == [5.5, 12.75, 20.0, 27.25]
    last = [m.end for m in cut][-5:]
    assert np.allclose(last, [(15, 35, -4), (15, 5, -4), (45, 5, -4), (45, 35, -4), (30, 35, -4)])
    assert made[-1].end == (30.0, 20.0, 2.0)


def test_strokes_along_y_with_i_and_the_contour_at_a_block_of_the_program():
    rest = SQUARE.replace("O200", "N200")
    made = moves("G150 G41 D1 X30. Y20. Z-4. R2. Q6. I8. P200", rest).moves
    rows = sorted(
        {
            round(m.end[0], 3)
            for m in made
            if m.kind == "line" and m.start[0] == m.end[0] and abs(m.end[1] - m.start[1]) > 29
        }
    )
    assert rows == [15.0, 22.5, 30.0, 37.5, 45.0]


@pytest.mark.parametrize(
    ("block", "message"),
    [
        ("G150 D1 X30. Y20. Z-4. R2. Q5. J8. P200", "G150 needs the side of the tool; add G41 or G42"),
        ("G150 G41 D1 X30. Y20. Z-4. R2. Q5. P200", "either I .strokes along Y. or J"),
        ("G150 G41 D1 X30. Y20. Z-4. R2. J8. P200", "the word .Q. is missing: a length"),
        ("G150 G41 D1 X30. Y20. Z4. R2. Q5. J8. P200", "a depth Z below its plane R"),
        ("G150 G42 D1 X30. Y20. Z-4. R2. Q5. J8. P200", "the tool goes outside of every contour"),
        ("G150 G41 D1 X30. Y20. Z-4. R2. Q5. J8.", "needs P, the subprogram of its contour"),
    ],
)  # fmt: skip
def test_what_is_missing_is_refused(block, message):
    with pytest.raises(DataError, match=f"2:.*{message}"):
        moves(block)


def test_the_order_is_told_and_strict_refuses_it():
    assert "how G150 clears" in {a.what for a in moves("G150 G41 D1 X30. Y20. Z-4. R2. Q5. J8. P200").assumed}
    with pytest.raises(
        DataError, match="2:1: how G150 gets from one stroke to the next is the control's own"
    ):
        moves("G150 G41 D1 X30. Y20. Z-4. R2. Q5. J8. P200", setup=Setup(strict=True, tools=SETUP.tools))


def test_a_missing_subprogram_is_a_hole():
    made = moves("G150 G41 D1 X30. Y20. Z-4. R2. Q5. J8. P777")
    assert any("777" in a.what and "hole" in a.value for a in made.assumed)
    assert [m.kind for m in made.moves if m.source.line == 2] == ["rapid"]
