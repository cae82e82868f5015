"""Expressions of O-words and of macro B: values by hand, and where their faults lie."""

from __future__ import annotations

import pytest

from vcmm.program.expressions import number
from vcmm.program.faults import BlockFault
from vcmm.program.iso.expressions import LineReader


class Known:
    """#1 = 2, #2 = -3.5, #5 vacant, #<a> = 4."""

    def number(self, index: int) -> float | None:
        return {1: 2.0, 2: -3.5, 5: None}.get(index, 0.0)

    def variable(self, name: str) -> float:
        return {"a": 4.0}[name]

    def exists(self, name: str) -> bool:
        return name == "a"


@pytest.mark.parametrize(
    ("words", "text", "value"),
    [
        ("o", "[2 + 3 * 2 ** 3]", 26.0), ("o", "[2 ** 3 ** 2]", 64.0), ("o", "[-7 MOD 3]", 2.0), ("o", "[1 GT 0 AND 0]", 0.0),
        ("o", "[#1ANDABS[#2]]", 1.0), ("o", "ATAN[1]/[-1]", 135.0), ("o", "FIX[-2.5]", -3.0), ("o", "FUP[-2.5]", -2.0),
        ("o", "EXISTS[#<a>]", 1.0), ("o", "EXISTS[#<b>]", 0.0), ("o", "#<A>", 4.0), ("o", "-#2", 3.5), ("o", "- 1 0.5", -10.5),
        ("macro", "FIX[-2.5]", -2.0), ("macro", "FUP[-2.5]", -3.0), ("macro", "[6 AND 3]", 2.0), ("macro", "[6 XOR 3]", 5.0),
        ("macro", "POW[2,-2]", 0.25), ("macro", "[#5 EQ #0]", 0.0), ("macro", "[#5 EQ #5]", 1.0), ("macro", "[#5 + 1.]", 1.0),
        ("macro", "ATAN[#1,#1]", 45.0), ("macro", "##1", -3.5), ("macro", "ROUND[2.5]", 3.0), ("macro", "[1 EQ 1 && 0]", 0.0),
        ("macro", "SQRT[16.]", 4.0),
    ],
)  # fmt: skip
def test_values(words: str, text: str, value: float):
    assert number(LineReader(text, words).value(), Known()) == pytest.approx(value)


@pytest.mark.parametrize(
    ("words", "text", "column", "what"),
    [
        ("o", "[1 + 2", 1, '"\\[" is never closed'), ("o", "FOO[1]", 1, '"FOO" is no function of this dialect; known: ABS'),
        ("o", "ATAN[1]", 8, "ATAN takes two arguments"), ("macro", "#<a>", 2, "belong to the linuxcnc dialect"),
        ("o", "#[2.5] ", 7, "parameter #2.5 does not exist"), ("o", "1,5", 2, "a comma in a number"),
        ("o", "1.2.3", 4, "a second decimal point"), ("o", "", 1, "expected a number, found the end of the line"),
        ("o", "  )", 3, "expected a number, found '\\)'"), ("o", "#<a", 2, "never closed"),
        ("o", "SIN 30", 5, "is missing after SIN, found '3'"), ("o", "[1/0]", 3, "division by zero"),
        ("macro", "SQRT[-4.]", 1, "SQRT\\[-4\\] has no real value"),
    ],
)  # fmt: skip
def test_faults(words: str, text: str, column: int, what: str):
    with pytest.raises(BlockFault, match=what) as fault:
        number(LineReader(text, words).value(), Known())
    assert fault.value.column == column


def test_a_reader_stops_where_the_value_ends():
    reader = LineReader("12.5 X[1+2]Y3", "o")
    assert reader.value() == 12.5
    assert reader.skip() == "X"
    reader.at += 1
    assert number(reader.value(), Known()) == 3.0
    assert reader.skip() == "Y"
    assert LineReader("#12 = 3", "macro").target() == 12.0
