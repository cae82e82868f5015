"""Numbers of a text as a whole: coordinates as controls of the seventies had them."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.iso.numbers import fixed_format
from vcmm.program.setup import Setup

TEXT = "N001M03\nN002G01X-010000Y+005000F1200\nN003G03X-005000Y-005000I+000000J-005000\nN004G01X+002500Z-001250\nN005M30\n"


def test_numbers_are_thousandths_from_point_to_point():
    """The quarter fits from (-10, 5) about (-10, 0) by (-5, -5) only; nothing says G90 or G91."""
    program = interpret(TEXT, "fanuc", Setup(strict=False))
    assert [m.end for m in program.moves] == [(-10, 5, 0), (-15, 0, 0), (-12.5, 0, -1.25)]
    assert program.moves[1].centre == (-10, 0, 0)
    assert [a.what for a in program.assumed[:2]] == [
        "numbers of a fixed format, without a point", "how coordinates count, for want of G90 and G91",
    ]  # fmt: skip


def test_what_is_said_holds():
    absolute = (
        TEXT.replace("N001", "N001G90")
        .replace("X-005000Y-005000", "X-015000Y+000000")
        .replace("X+002500", "X-012500")
    )
    program = interpret(absolute, "fanuc", Setup(strict=False))
    assert [m.end for m in program.moves] == [(-10, 5, 0), (-15, 0, 0), (-12.5, 0, -1.25)]
    assert [a.what for a in program.assumed[:1]] == ["numbers of a fixed format, without a point"]
    with pytest.raises(DataError, match="does not fit"):
        interpret(TEXT, "fanuc", Setup())  # strict: as the set-up says, and here it says nothing


def test_numbers_with_a_point_or_few_zeros_are_none_of_these():
    assert not fixed_format(TEXT + "G1 X1.5\n")
    assert not fixed_format("G1 X100 Y200\n" * 10)
