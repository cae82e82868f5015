"""Words of a block by modal group."""

from __future__ import annotations

import pytest

from vcmm.program.dialects import FANUC, FANUC_LATHE, LINUXCNC, Dialect
from vcmm.program.faults import BlockFault
from vcmm.program.iso.blocks import parse_block
from vcmm.program.iso.codes import IsoWords, code_text, groups_of
from vcmm.program.iso.control import new_control
from vcmm.program.setup import Setup


def words(text: str, language: Dialect = FANUC) -> IsoWords:
    return IsoWords(new_control("p.nc", language, Setup()), parse_block(text, 1, language))


def test_groups():
    w = words("G0 G90 G54 X1. M3 S500")
    assert (w.g, w.m) == ({"motion": "G0", "distance": "G90", "offset": "G54"}, {"spindle": 3})
    assert (w.take("X"), w.has("Y"), w.column("S"), w.any_axis) == (1.0, False, 19, True)
    assert w.used == {"X"}
    assert code_text(54.1) == "G54.1"
    assert groups_of(new_control("p", FANUC_LATHE, Setup()))["G98"] == "feed"


@pytest.mark.parametrize(
    ("text", "language", "column", "what"),
    [
        ("G0 G1 X1", FANUC, 4, "G0 and G1 belong to one group"), ("M3 M4", FANUC, 4, "exclude each other"),
        ("X1 X2", FANUC, 4, 'the word "X" appears twice'), ("M123", LINUXCNC, 1, "machine builder or user"),
        ("G92.4", LINUXCNC, 1, 'Did you mean "G92'),
    ],
)  # fmt: skip
def test_what_is_refused(text: str, language: Dialect, column: int, what: str):
    with pytest.raises(BlockFault, match=what) as fault:
        words(text, language)
    assert fault.value.column == column


def test_whole_numbers():
    with pytest.raises(BlockFault, match=r"P1\.5 must be a whole number, 1 or more"):
        words("P1.5").whole("P", 1, 1)
    assert words("P3").whole("P", 1) == 3
    assert words("X1").whole("P", 1) is None
    with pytest.raises(BlockFault, match='the word "P" is missing: the depth'):
        words("X1").need("P", "the depth", 1)
