"""One line of a Sinumerik program as a block."""

from __future__ import annotations

import pytest

from vcmm.program.faults import BlockFault
from vcmm.program.sinumerik.blocks import SinumerikBlock, parse_block
from vcmm.program.sinumerik.text import lines_of


def block(text: str) -> SinumerikBlock:
    return parse_block(lines_of(text)[0], 1)


def test_items():
    read = block('/3 N10 START: G1 X=IC(5) I1=AC(2) R5=3 T="MILL" CYCLE81(1,,2)')
    assert (read.skipped, read.number, read.label) == (True, "N10", "START")
    assert [(i.name, i.mode, i.text) for i in read.items] == [
        ("G", "", "1"), ("X", "IC", ""), ("I", "AC", ""), ("R", "", ""), ("T", "", "MILL"), ("CYCLE81", "", ""),
    ]  # fmt: skip
    assert read.items[1].value == 5.0
    assert read.items[5].arguments == (1.0, None, 2.0)
    assert [read.items[k].number(None) for k in (2, 3)] == [1, 5]


def test_flow():
    assert block("IF R1>2 GOTOF END_1").flow.kind == "JUMP"
    assert block("FOR R1=1 TO 3").flow.data[1:] == (1.0, 3.0)
    assert block("REPEAT FIRST LAST P=3").flow.data == (("FIRST", "LAST"), 3.0)
    assert block("DEF INT AA=1, BB").flow.data == ("INT", (("AA", 1.0, ()), ("BB", None, ())))
    assert block("PROC SIDE(REAL DEP)").flow.data == ("SIDE", (("REAL", "DEP", None, False),), False)
    _, cases = block("CASE R1 OF 1 GOTOF UP DEFAULT GOTOB DOWN").flow.data
    assert [c[1:] for c in cases] == [("GOTOF", "UP"), ("GOTOB", "DOWN")]


@pytest.mark.parametrize(
    ("text", "column"),
    [
        ("X", 2),
        ("G1 )", 4),
        ("GOTOF", 6),
        ("X=CDC(3)", 3),
        ("DEF FRAME A", 11),
        ("DEF THING AB", 5),
        ("ENDIF G1", 7),
    ],
)
def test_what_cannot_be_read(text: str, column: int):
    with pytest.raises(BlockFault) as fault:
        block(text)
    assert fault.value.column == column
