"""Words of a Sinumerik block are taken as they are used."""

from __future__ import annotations

import pytest

from vcmm.program.faults import BlockFault
from vcmm.program.sinumerik.blocks import Item, SinumerikBlock
from vcmm.program.sinumerik.state import SinumerikWords


def test_words_are_taken_once():
    words = SinumerikWords(runner=None, block=SinumerikBlock(1, 1, 9))
    words.items = {"X": Item("X", 1, 3, 5.0), "T": Item("T", 4, 9, text="MILL")}
    assert words.has("X", "Y")
    assert words.take("X") == 5.0
    assert words.take("X") is None
    with pytest.raises(BlockFault, match="T takes a number") as fault:
        words.take("T")
    assert fault.value.column == 4
