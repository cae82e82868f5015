"""Words of a Klartext positioning block."""

from __future__ import annotations

import pytest

from vcmm.program.faults import BlockFault
from vcmm.program.heidenhain.text import KlartextReader, blocks_of
from vcmm.program.heidenhain.words import KlartextWords, read_words


def words(text: str, *addresses: str, bare: str = "") -> KlartextWords:
    line = blocks_of(text)[0]
    return read_words(KlartextReader(line.tokens, {"Q1": 7.0}, lambda name: None), addresses, bare)


def test_words():
    w = words("X+10 IY-Q1 DR- RL F250 M3 M99")
    assert w.values == {"X": 10.0, "IY": -7.0}
    assert (w.side, w.has_side, w.clockwise, w.feed, w.feed_kind, w.m) == (
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
    ("text", "column"), [("X1 X2", 4), ("X1 QS2", 4), ("DR X1", 1), ("FZ", 3), ("X1 5", 4), ("X", 2)]
)
def test_what_cannot_be_read(text: str, column: int):
    with pytest.raises(BlockFault) as fault:
        words(text)
    assert fault.value.column == column


def test_words_of_m_functions_are_no_coordinates_and_no_feed():
    w = words("X1 F500 M128 F9000 M120 LA5 M118 X2 Z3")
    assert (w.values, w.feed, w.m) == ({"X": 1.0}, 500.0, [128, 120, 118])
    assert words("M140 MB MAX").away == float("inf")
    assert (words("M140 MB+50 F750").away, words("M140 MB+50 F750").feed) == (50.0, 750.0)


def test_a_parameter_needs_no_blank_before_it():
    w = words("XQ1 Y-Q1 FQ1")
    assert (w.values, w.feed) == ({"X": 7.0, "Y": -7.0}, 7.0)


def test_axes_that_are_not_modelled_are_words():
    assert words("X1 W2 IU3").values == {"X": 1.0, "W": 2.0, "IU": 3.0}
    assert (words("FZ0.1").feed, words("FZ0.1").feed_kind) == (0.1, "FZ")
