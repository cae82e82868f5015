"""One line as a block: words with their columns, assignments, flow control."""

from __future__ import annotations

import pytest

from vcmm.program.dialects import FANUC, LINUXCNC
from vcmm.program.faults import BlockFault
from vcmm.program.iso.blocks import parse_block, without_comments


def test_words_and_their_columns():
    block = parse_block("N10 G1 X-1.5 Y[#1] (side) F.2", 7, FANUC)
    assert (block.line, block.n) == (7, 10)
    assert [(w.letter, w.first, w.last, w.text) for w in block.words] == [
        ("G", 5, 7, "1"), ("X", 8, 13, "-1.5"), ("Y", 14, 19, "[#1]"), ("F", 27, 30, ".2"),
    ]  # fmt: skip
    assert [w.has_point for w in block.words] == [False, True, True, True]


def test_assignments_flow_and_signs():
    assert [a.target for a in parse_block("#1=2 #<b>=3", 1, LINUXCNC).assigns] == [1.0, "b"]
    block = parse_block("IF[#1 GT 2] GOTO 30", 1, FANUC)
    assert (block.flow.kind, block.flow.values[1]) == ("if-goto", 30.0)
    assert parse_block("o<side> call [1] [2]", 1, LINUXCNC).flow[:2] == ("call", "side")
    assert parse_block("/2 G0", 1, FANUC).has_slash
    assert parse_block(" % ", 1, FANUC).percent
    assert parse_block("X1 0", 1, FANUC).blank_column == 1


def test_comments_leave_blanks_so_that_columns_stay():
    assert without_comments("G0(a)X1;b", LINUXCNC) == "G0   X1  "
    assert without_comments("G0(a(b))X1", FANUC) == "G0      X1"
    for text, column in (("G0 (a", 4), ("G0 a)", 5), ("(a(b))", 3)):
        with pytest.raises(BlockFault) as fault:
            without_comments(text, LINUXCNC)
        assert fault.value.column == column


@pytest.mark.parametrize(("text", "column"), [("X", 2), ("X1 N5", 4), ("G0 X\u00b5", 5), ("&", 1)])
def test_what_cannot_be_read(text: str, column: int):
    with pytest.raises(BlockFault) as fault:
        parse_block(text, 1, FANUC)
    assert fault.value.column == column
