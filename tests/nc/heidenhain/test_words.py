"""Words of a Klartext positioning block."""

from __future__ import annotations

import pytest

from vcmm.nc.faults import BlockFault
from vcmm.nc.heidenhain.text import KlartextReader, blocks_of
from vcmm.nc.heidenhain.words import KlartextWords, read_words


def words(text: str, *addresses: str, bare: str = "") -> KlartextWords:
    line = blocks_of(text)[0]
    return read_words(KlartextReader(line.tokens, {"Q1": 7.0}, lambda name: None), addresses, bare)


def test_words():
    w = words("X+10 IY-Q1 DR- RL F250 M3 M99")
    assert w.values == {"X": 10.0, "IY": -7.0}
    assert (w.side, w.sided, w.clockwise, w.feed, w.feed_kind, w.m) == (
        "left",
        True,
        True,
        250.0,
        "F",
        [3, 99],
    )
    assert words("X1 R0 FMAX").rapid
    assert words("F AUTO").feed_kind == "AUTO"
    assert words("R5 F40", "R").values == words("F40 5", bare="R").values == {"R": 5.0}
    assert words("LEN10 CCA90", "LEN", "CCA").take("LEN") == 10.0


@pytest.mark.parametrize(
    ("text", "column"), [("X1 X2", 4), ("X1 W2", 4), ("DR X1", 1), ("FZ0.1", 1), ("X1 5", 4), ("X", 2)]
)
def test_what_cannot_be_read(text: str, column: int):
    with pytest.raises(BlockFault) as fault:
        words(text)
    assert fault.value.column == column
