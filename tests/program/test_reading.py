"""The dialect that a text seems to be written in."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.program.reading import read_bytes


@pytest.mark.parametrize(
    ("text", "dialect", "doubt"),
    [
        ("o100 sub\no100 endsub\nM2", "linuxcnc", False),
        ("G0 X#<a>\nM2", "linuxcnc", False),
        ("%\nO0001\nG28 G91 Z0\nM30\n%", "fanuc", False),
        ("M98 P5\nG64 P0.1\nM30", "linuxcnc", True),
        ("G0 X1.\nM30", "fanuc", True),
        ("G0 X9. Z1.\nG3 X10. Z0. I0. K-.6\nM30", "fanuc-lathe", True),
    ],
)
def test_the_dialect_is_guessed_and_doubt_is_told(text: str, dialect: str, doubt: bool):
    from vcmm.program.reading import guess

    found, why = guess(text, Path("part.nc"))
    assert found == dialect
    assert ("--dialect" in why) == doubt


def test_the_leader_of_a_tape_is_passed_over(tmp_path: Path):
    """NUL bytes before the first and behind the last block; one between is no text."""
    file = tmp_path / "dnc.nc"
    file.write_bytes(b"\0\0\0%\r\nG0 X1.\r\n%\r\n\0\0")
    assert read_bytes(file) == "%\r\nG0 X1.\r\n%\r\n"
    file.write_bytes(b"%\nG0 \0X1.\n")
    with pytest.raises(DataError, match=r"dnc.nc:2:4: a NUL byte"):
        read_bytes(file)
