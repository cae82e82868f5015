"""How far a program runs off another, by hand, and what may not differ between them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.compensation.test_contours import HEAD, move
from vcmm.compensation.proof import (
    Walk,
    best_shifts,
    block_rate,
    compare,
    compare_comments,
    departure,
    departures,
    shift_errors,
    spans,
    walk,
)
from vcmm.core.errors import ModelLimit
from vcmm.program.interpret import interpret
from vcmm.program.moves import Program
from vcmm.program.setup import Setup, Tool

SETUP = Setup(dialect="fanuc", offsets={"G54": (0.0, 0.0, 0.0)})


def program(body: str) -> Program:
    return interpret(f"{HEAD}{body}M30\n%\n", "fanuc", SETUP, "part.nc", trace=True)


def test_distance_from_the_nearer_of_two_moves() -> None:
    """Along +X then +Y: a point 3 mm right of the second and 4 mm over the first's line is 3 mm off."""
    moves = program("G1 X20. F100\nY20.\n").moves[-2:]
    at = np.array([[23.0, 4.0, 0.0]])
    assert departures(at, moves, np.array([0]), np.array([1])) == pytest.approx([3.0])
    assert departures(at, moves, np.array([0]), np.array([0])) == pytest.approx([5.0])  # from its end


def test_largest_and_rms_over_the_way() -> None:
    """3 um over 1 mm and 1 um over 3 mm: sqrt((9 + 3) / 4) = 1.732 um."""
    found = departure(np.array([3e-3, 1e-3]), np.array([1.0, 3.0]), [7, 8])
    assert (found.largest, found.line) == (3e-3, 7)
    assert found.rms == pytest.approx(math.sqrt(3.0) * 1e-3)


def test_the_best_shift_is_minus_the_mean() -> None:
    moves = program("G1 X20. F100\n").moves
    w = Walk(np.array([1, 1]), np.array([0.0, 1.0]), np.zeros((2, 3)), np.array([1.0, 3.0]))
    error = np.array([[4e-3, 0, 0], [0.0, 0, 0]])
    shifts = best_shifts(error, w, moves)
    assert shifts["G54"] == pytest.approx([-1e-3, 0.0, 0.0])
    assert shift_errors(error, w, moves, shifts)[0] == pytest.approx([3e-3, 0.0, 0.0])


def test_knots_of_a_walk() -> None:
    """10 mm of feed: one knot each 2 mm, six in all, of 10 / 6 mm each; rapids are not walked."""
    w = walk(program("G1 X20. F100\nG0 X0\n").moves)
    assert w.tip[:, 0] == pytest.approx([10, 12, 14, 16, 18, 20])
    assert w.weight == pytest.approx([10 / 6] * 6)


def test_a_split_block_lies_on_the_one_that_it_splits() -> None:
    old, new = program("G1 X20. F100\nY5.\n"), program("G1 X15. F100\nX20.\nY5.\n")
    low, high = spans(old, new, (1, 2, 3, 4, 5, 5, 6, 7, 8))
    assert low.tolist() == high.tolist() == [0, 1, 1, 2]


@pytest.mark.parametrize(
    ("new", "words"),
    [
        ("G1 X20. F90\n", r"modal state differs \(100.0 has become 90.0\)"),
        ("G0 X20.\n", "modal state differs"),
        ("", "not the same"),
    ],
)
def test_what_may_not_differ(new, words) -> None:
    old = program("G1 X20. F100\n")
    lines = (1, 2, 3, 4, 5, 6, 7)
    compare(old, old, lines, "part.nc")
    with pytest.raises(ModelLimit, match=words) as caught:
        compare(old, program(new), lines, "part.nc")
    assert caught.value.line == 5


def test_comments_stay_in_their_order() -> None:
    compare_comments("(A)\n(B)\n", "(MARK)\n(A)\n(B)\n", ["(MARK)"])
    with pytest.raises(ModelLimit, match="other comments"):
        compare_comments("(A)\n(B)\n", "(MARK)\n(B)\n(A)\n", ["(MARK)"])


def test_blocks_per_second() -> None:
    """1 mm at 600 mm/min is 10 blocks per second."""
    m = program("G1 X11. F600\nX21.\n").moves
    assert block_rate(m) == (pytest.approx(10.0), 5)
    assert move("G1 X20.").feed == 100.0


def test_a_corner_that_radius_compensation_adds_is_no_block_of_its_own() -> None:
    """40 mm at 300 mm/min and a corner that turns by 0.5 mrad: 0.1 blocks/s, not the thousands of an arc of 4 um."""
    text = "G17 G71 G90 G94\nT1 M6\nG54 G0 X0 Y-20 S100 M3\nG1 G41 X10 Y0 F300\nX50 Y0.01\nX90 Y0\nG40 Y-20\nM30\n"
    found = interpret(
        text, "sinumerik", Setup(offsets={"G54": (0.0, 0.0, 0.0)}, tools={1: Tool(1, 0.0, 16.0)})
    )
    assert any(m.kind == "arc" and m.source.line == 6 for m in found.moves)
    assert block_rate(found.moves)[0] < 0.4
