"""Precedence, working out and reading of expressions, for a language made up here."""

from __future__ import annotations

import math

import pytest

from vcmm.program.expressions import (
    TIGHT,
    Cursor,
    ExpressionReader,
    Grammar,
    away_from_zero,
    binary,
    call_function,
    evaluate,
    finite,
    number,
    power,
    round_half_up,
    to_degrees,
    whole_number,
)
from vcmm.program.faults import BlockFault
from vcmm.program.tokens import Token

GRAMMAR = Grammar(
    levels={"+": 1, "-": 1, "*": 2, "/": 2, "IS": 0},
    operations={
        "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b,
        "IS": lambda a, b: a == b,
    },
    prefixes={"-": (TIGHT, lambda x: -x), "~": (1, lambda x: -x)},
    functions={"ROOT": (1, math.sqrt), "HYP": (2, math.hypot)}, dividing=("/",), equal={"IS": True},
)  # fmt: skip


class Plain(ExpressionReader):
    grammar = GRAMMAR

    def atom(self):
        token = self.next()
        return (lambda known: known[token.text]) if token.text.isalpha() else float(token.text)


def reader(text: str) -> Plain:
    column, tokens = 1, []
    for piece in text.split():
        tokens.append(Token("any", piece, 1, column))
        column += len(piece) + 1
    return Plain(tokens)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 + 2 * 3", 7.0), ("( 1 + 2 ) * 3", 9.0), ("8 - 3 - 2", 3.0), ("8 / 4 / 2", 1.0), ("- 2 * 3", -6.0),
        ("2 * - 3", -6.0), ("~ 2 * 3 + 1", -5.0), ("a * a - 1", 24.0), ("- ( a - 7 )", 2.0),
    ],
)  # fmt: skip
def test_precedence(text: str, value: float):
    # ~ binds looser than *, so that ~ 2 * 3 is -(2 * 3) = -6, and tighter than +
    assert number(reader(text).expression(), {"a": 5.0}) == value


def test_vacant_values_are_zero_in_sums_and_equal_to_nothing_but_themselves():
    def vacant(known):
        return None

    assert number(binary(GRAMMAR, "+", vacant, 3.0, 1), None) == 3.0
    assert number(binary(GRAMMAR, "IS", vacant, 0.0, 1), None) == 0.0
    assert number(binary(GRAMMAR, "IS", vacant, vacant, 1), None) == 1.0
    assert evaluate(vacant, None) is None
    assert number(vacant, None) == 0.0


def test_what_has_no_value_is_told_with_its_column():
    with pytest.raises(BlockFault, match="division by zero") as fault:
        number(reader("1 / 0").expression(), {})
    assert fault.value.column == 3
    with pytest.raises(BlockFault, match=r"ROOT\(-4\) has no real value") as fault:
        number(call_function(GRAMMAR, "ROOT", [-4.0], 7), {})
    assert fault.value.column == 7
    with pytest.raises(BlockFault, match=r"the result of this expression is inf"):
        finite(math.inf, 1)
    with pytest.raises(BlockFault, match=r"the label is 1\.5; expected a whole number"):
        whole_number(1.5, "the label")
    with pytest.raises(BlockFault, match="the label is vacant"):
        whole_number(None, "the label")
    with pytest.raises(BlockFault, match='"\\)" is missing after the expression') as fault:
        reader("( 1 + 2").expression()
    assert fault.value.column == 8  # one past the last token


def test_numbers_by_hand():
    assert number(call_function(GRAMMAR, "HYP", [3.0, 4.0], 1), {}) == 5.0
    assert whole_number(2.00005, "it") == 2
    assert [round_half_up(x) for x in (0.5, -0.5, 2.4, -2.6)] == [1.0, -1.0, 2.0, -3.0]
    assert [away_from_zero(x) for x in (1.2, -1.2)] == [2.0, -2.0]
    assert to_degrees(math.atan2)(1.0, 1.0) == pytest.approx(45.0)
    assert power(2.0, -2.0) == 0.25
    assert math.isnan(power(-8.0, 0.5))


def test_a_cursor_reads_from_left_to_right():
    cursor = Cursor([Token("name", "go", 1, 1), Token("name", "To", 1, 4)])
    assert cursor.upper() == "GO"
    assert not cursor.accept("GO", "ON")
    assert cursor.accept("GO", "TO")
    assert cursor.is_done
    assert cursor.column == cursor.read_to == 6
    assert cursor.peek() is None
    assert Cursor([Token("name", "go", 1, 1)], end=9).column == 1
