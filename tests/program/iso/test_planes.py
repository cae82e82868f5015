"""G68.2 in its forms, against rotations multiplied out here."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.shop.motion.test_tool_centre import about
from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup

HEAD = "G21 G90 G54 F100.\n"


def moves(text: str, dialect: str = "fanuc", *, strict: bool = True):
    return interpret(HEAD + text, dialect, Setup(strict=strict)).moves


def spun(*steps: tuple[str, float]) -> np.ndarray:
    """Turns about axes that stand still, the first one first."""
    made = np.eye(3)
    for letter, angle in steps:
        made = about(letter, math.radians(angle)) @ made
    return made


POINT = np.array([1.0, 2.0, 3.0])


@pytest.mark.parametrize(
    ("block", "turn"),
    [
        ("G68.2 X10. Y5. Z-2. I20. J30. K40.", about("C", math.radians(20)) @ about("A", math.radians(30)) @ about("C", math.radians(40))),
        ("G68.2 P1 X10. Y5. Z-2. I20. J30. K40.", spun(("A", 20), ("B", 30), ("C", 40))),
        ("G68.2 P1 Q321 X10. Y5. Z-2. I20. J30. K40.", spun(("C", 40), ("B", 30), ("A", 20))),
        ("G68.2 P1 Q213 X10. Y5. Z-2. I20. J30. K40.", spun(("B", 30), ("A", 20), ("C", 40))),
        ("G68.2 P3 Q1 X10. Y5. Z-2. I0 J0 K-2.\nG68.2 P3 Q2 I3. J0 K0", np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])),
        ("G68.2 P2 Q1 X10. Y5. Z-2.\nG68.2 P2 Q2 X10. Y5. Z-9.\nG68.2 P2 Q3 X10. Y7. Z-4.", np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])),
    ],
)  # fmt: skip
def test_a_plane_in_its_forms(block, turn):
    """A point of the plane lies at origin + R p. Three points: X along -Z of the part, the third one on the side of +Y, so that the normal
    is x cross y = (1, 0, 0); two vectors: X along -Z, the normal along X."""
    found = moves(f"{block}\nG53.1\nG1 X1. Y2. Z3.\n")
    assert found[-1].end == pytest.approx(np.array([10.0, 5.0, -2.0]) + turn @ POINT, abs=1e-9)
    assert found[-1].tool_axis_end == pytest.approx(turn[:, 2], abs=1e-9)
    assert len(found) == 1  # the blocks that describe the plane move nothing


def test_three_points_with_a_shift_and_a_turn():
    """Q0 X3. R90.: the origin lies 3 mm along X of the plane, which is then turned by 90 deg: X1 is Y of the three points."""
    text = "G68.2 P2 Q0 X3. Y0 Z0 R90.\nG68.2 P2 Q1 X10. Y0 Z0\nG68.2 P2 Q2 X20. Y0 Z0\nG68.2 P2 Q3 X10. Y9. Z0\nG53.1\nG1 X1. Y0 Z0\n"
    assert moves(text)[-1].end == pytest.approx((13.0, 1.0, 0.0), abs=1e-9)


def test_without_g53_1_the_rotary_axes_stay():
    text = "G68.2 X0 Y0 Z0 I0 J90. K0\nG1 Y2.\n{}G1 Y3.\nG69\nG1 Y4.\n"
    for code, is_square in (("", False), ("G53.1\n", True)):
        found = moves(text.format(code))
        assert found[0].end == pytest.approx((0, 0, 2), abs=1e-12)
        assert (found[0].is_tip_led, found[0].tool_axis_end) == (False, None)
        assert found[1].is_tip_led is is_square
        assert not found[2].is_tip_led


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("G68.2 P4 X0 Y0 Z0 I30. J0", "G68.2 P4 is not understood; describe the plane by Euler angles"),
        ("G68.3 X0 Y0 Z0", "G68.3, a tilted working plane that depends on the position of the machine is not understood"),
        ("G68.4 X0 Y0 Z0 I30.", "G68.4, a tilted working plane that depends on"),
        ("G68.2 P1 Q122 X0 I30.", "Q122 is no order of rotations"),
        ("G68.2 P2 Q5 X0", "G68.2 P2 takes Q0, Q1, Q2, Q3"),
        ("G68.2 P2 Q3 X0", "needs its blocks Q1 to Q3"),
        ("G68.2 P3 Q1 X0 I1.\nG68.2 P3 Q2 I2.", "parallel or zero"),
        ("G53.1", "G53.1 turns the tool square to the plane of G68.2, which is missing"),
        ("G68.2 X0 J30.\nG53.1 P3", "G53.1 takes P0, P1 or P2"),
    ],
)  # fmt: skip
def test_what_is_not_understood_is_refused(text, said):
    with pytest.raises(DataError) as caught:
        moves(f"{text}\nG1 X1.\n")
    assert said in str(caught.value)


def test_haas_states_the_order_of_its_rotations():
    """G268 Q123: about X, Y, Z that stand still; G253 turns the tool square to it."""
    found = moves("G268 X0 Y0 Z0 I0 J90. K0 Q123\nG253\nG1 Z1.\nG269\nG1 Z2.\n", "haas")
    assert found[0].end == pytest.approx((1, 0, 0), abs=1e-12)
    assert found[0].tool_axis_end == pytest.approx((1, 0, 0), abs=1e-12)
    assert not found[1].is_tip_led
    with pytest.raises(DataError, match="state the order of its rotations"):
        moves("G268 X0 Y0 Z0 J90.\nG1 Z1.\n", "haas")


def test_p1_says_how_it_was_read():
    program = interpret(f"{HEAD}G68.2 X0 J30.\nG53.1 P1\nG1 X1.\n", "fanuc", Setup())
    assert program.moves[-1].posture.sign == 1
    assert any("P1 of G53.1" in r.text and r.line == 3 for r in program.warnings)
