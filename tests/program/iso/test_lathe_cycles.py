"""Drilling cycles of Fanuc lathes along Z (G83 ...) and along X (G87 ...): depths and clearances by hand.

Source: FANUC B-64304EN-1, "canned cycle for drilling": X of G87 is a diameter, R counts from where the cycle begins, U and W from R.
"""

from __future__ import annotations

import math

import pytest

from vcmm.program.interpret import interpret

HEAD = "%\nO1\nG21 G18 G98\nG0 X50. Z-20.\n"


def path(block, dialect="fanuc-lathe"):
    return [
        (m.kind, m.end[0], m.end[2], round(math.degrees(m.rotary_end[2]), 9))
        for m in interpret(HEAD + block + "\nG80\nM30\n%\n", dialect).moves[1:]
    ]


@pytest.mark.parametrize(
    "block", ["G87 X12. C30. R-3. F100.", "G87 U-32. C30. R-3. F100.", "G87 X12. H30. R-3. F100."]
)
def test_a_cross_hole(block):
    """From X 50 (25 mm) to 22 mm, down to 6 mm (X12, or 16 mm below R as U-32), back to where it began."""
    assert path(block) == [
        ("rapid", 25, -20, 30), ("rapid", 22, -20, 30), ("line", 6, -20, 30), ("rapid", 25, -20, 30),
    ]  # fmt: skip


def test_a_face_hole_with_an_increment_and_a_second_one():
    """R-2 below Z-20: -22; W-8 below it: -30; the next block only indexes C."""
    found = path("G83 W-8. R-2. F100.\nC90.")
    first = [("rapid", 25, -22, 0), ("line", 25, -30, 0), ("rapid", 25, -20, 0)]
    assert found == [*first, ("rapid", 25, -20, 90), *((k, x, z, 90) for k, x, z, _ in first)]


def test_side_tapping_and_boring_come_out_at_feed():
    for code in ("G88", "G89"):
        assert [(k, x) for k, x, _, _ in path(f"{code} X12. R-3. F100.")] == [
            ("rapid", 22), ("line", 6), ("line", 22), ("rapid", 25),
        ]  # fmt: skip
