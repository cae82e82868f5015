"""@ and ^ of LinuxCNC; G16 is in test_motion."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret


def ends(text: str) -> list[tuple[float, float]]:
    return [m.end[:2] for m in interpret(f"G21 G90 G17 F100\n{text}M2\n", "linuxcnc").moves]


def test_distance_and_angle_from_the_work_zero():
    """@10 ^90 is (0, 10); @20 alone keeps the angle; ^180 alone keeps the distance; G91 counts on: 25 mm at 270 degrees."""
    found = ends("G0 @10 ^90\nG1 @20\n^180\nG91 @5 ^90\n")
    assert found == [pytest.approx(p, abs=1e-12) for p in ((0, 10), (0, 20), (-20, 0), (0, -25))]


@pytest.mark.parametrize(
    ("text", "word"),
    [("G0 @10\n", "no angle"), ("G18 G0 @10 ^0\n", "plane XY"), ("G0 X1 @10 ^0\n", "beside X or Y"), ("@5 ^0\n", "without a motion")],
)  # fmt: skip
def test_what_the_interpreter_refuses_is_refused(text: str, word: str):
    with pytest.raises(DataError, match=word):
        ends(text)


def test_g80_beside_another_motion_code_leaves_that_one_in_force():
    """As LinuxCNC 2.9 does, in either order (checked against rs274)."""
    moves = interpret("G21 G0 G80 X3\nG80 G1 X4 F50\nX5\nM2\n", "linuxcnc").moves
    assert [(m.kind, m.end[0]) for m in moves] == [("rapid", 3), ("line", 4), ("line", 5)]
