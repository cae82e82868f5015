"""Expressions of all languages: read from the tokens of a block by precedence, kept as functions, evaluated when they are needed.

A language is a `Grammar` (operators, functions, brackets) and a reader of its own variables. A value is a number or a function
of what the control knows, so that a loop reads its text once. None is a vacant Fanuc variable: 0 in sums, ignored as
the value of a word, equal to nothing but itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from vcmm.program.faults import BlockFault
from vcmm.program.tokens import Token

Evaluation = Callable[[Any], "float | None"]  # of what the control knows
Value = float | Evaluation
DEEPEST_BRACKETS, MOST_OPERATORS = 60, 200  # no control takes more in a block; each costs frames of the stack
TIGHT = 99  # binds tighter than any operator


@dataclass(frozen=True)
class Grammar:
    """levels: how tightly an operator of two values binds; equal ones bind from the left. prefixes: an operator before a value,
    how tightly it binds, and what it does. functions: how many arguments, and what they do. call: how a call looks in messages.
    dividing: operators that cannot take a zero behind them. equal: operators that tell a vacant value from zero.
    """

    levels: Mapping[str, int]
    operations: Mapping[str, Callable[[float, float], float]]
    prefixes: Mapping[str, tuple[int, Callable[[float], float]]]
    functions: Mapping[str, tuple[int, Callable[..., float]]]
    dividing: tuple[str, ...]
    brackets: str = "()"
    call: str = "{name}({arguments})"
    equal: Mapping[str, bool] = field(default_factory=dict)


# -- working out --------------------------------------------------------------------------------------------------------
def evaluate(value: Value, variables: Any) -> float | None:
    """Return the number now; None for a vacant variable."""
    return value(variables) if callable(value) else value


def number(value: Value, variables: Any) -> float:
    """Return the number now; 0 for a vacant variable. Raises BlockFault for a text."""
    now = (value(variables) if callable(value) else value) or 0.0
    if not isinstance(now, float | int):
        raise BlockFault(0, f'expected a number, found "{now}"')
    return now


def whole_number(number: float | None, what: str, column: int = 0, near: float = 1e-4) -> int:
    """Return a whole number from a computed one. Raises BlockFault (column 0: the caller knows it)."""
    if number is None or not math.isfinite(number) or abs(number - round(number)) > near:
        text = "vacant" if number is None else f"{number:g}"
        raise BlockFault(column, f"{what} is {text}; expected a whole number")
    return round(number)


def finite(number: float, column: int) -> float:
    """Refuse NaN, infinity and complex results."""
    if isinstance(number, complex) or not math.isfinite(number):
        raise BlockFault(
            column, f"the result of this expression is {number}, not a finite number; check the parameters"
        )
    return float(number)


def power(x: float, y: float) -> float:
    """Return x to the power of y; not a number where there is no real one."""
    return math.nan if isinstance(x**y, complex) else float(x**y)


def apply_sign(function: Callable[[float], float], value: Value) -> Value:
    """Return a sign or negation before a value."""
    if callable(value):
        inner = value
        return lambda variables: float(function(number(inner, variables)))
    return float(function(value))


def binary(grammar: Grammar, operator: str, left: Value, right: Value, column: int) -> Evaluation:
    """Return two values and the operator between them."""

    def result(variables: Any) -> float:
        a, b = evaluate(left, variables), evaluate(right, variables)
        if operator in grammar.equal and (a is None or b is None):
            return float((a is b) == grammar.equal[operator])
        x, y = a or 0.0, b or 0.0
        if not (isinstance(x, float | int) and isinstance(y, float | int)):
            raise BlockFault(column, f"{operator} needs numbers on both sides")
        if operator in grammar.dividing and y == 0.0:
            raise BlockFault(column, "division by zero; check the parameters used here")
        try:
            return finite(grammar.operations[operator](x, y), column)
        except (OverflowError, ZeroDivisionError, ValueError) as error:
            kind = "real" if isinstance(error, ValueError) else "finite"
            raise BlockFault(
                column, f"{x:g} {operator} {y:g} has no {kind} value; check the parameters"
            ) from None

    return result


def call_function(grammar: Grammar, name: str, arguments: Sequence[Value], column: int) -> Evaluation:
    """Return a function and its arguments, of which there are as many as it takes."""
    _, function = grammar.functions[name]

    def result(variables: Any) -> float:
        values = [number(a, variables) for a in arguments]
        try:
            return finite(function(*values), column)
        except (ValueError, OverflowError, ZeroDivisionError):
            text = grammar.call.format(name=name, arguments=", ".join(f"{v:g}" for v in values))
            raise BlockFault(column, f"{text} has no real value; check the parameters") from None

    return result


def in_degrees(function: Callable[[float], float]) -> Callable[[float], float]:
    """Return a function of an angle in degrees."""
    return lambda x: function(math.radians(x))


def to_degrees(function: Callable[..., float]) -> Callable[..., float]:
    """Return a function that gives an angle in degrees."""
    return lambda *x: math.degrees(function(*x))


def round_half_up(x: float) -> float:
    """Round to the nearest whole number, halves away from zero."""
    return math.copysign(math.floor(abs(x) + 0.5), x)


def away_from_zero(x: float) -> float:
    """Round to the next whole number away from zero."""
    return math.copysign(math.ceil(abs(x)), x)


# -- reading ------------------------------------------------------------------------------------------------------------
class Cursor:
    """Reads the tokens of one block from left to right. `at` is the index of the next token; end: column behind the last."""

    def __init__(self, tokens: Sequence[Token], end: int | None = None) -> None:
        self.tokens, self.at, self.end = tokens, 0, end

    @property
    def is_done(self) -> bool:
        return self.at >= len(self.tokens)

    @property
    def column(self) -> int:
        """Column of the next token."""
        if not self.is_done:
            return self.tokens[self.at].column
        return self.end or self.reached_by(self.tokens[-1])

    @property
    def read_to(self) -> int:
        """One past the last character read."""
        return self.reached_by(self.tokens[max(self.at - 1, 0)])

    @staticmethod
    def reached_by(token: Token) -> int:
        return token.column + len(token.text)

    def peek(self, ahead: int = 0) -> Token | None:
        return self.tokens[self.at + ahead] if self.at + ahead < len(self.tokens) else None

    def next(self) -> Token:
        """Return the next token. Raises BlockFault where there is none."""
        if self.is_done:
            raise self.fault("expected more, found the end of the block; complete it")
        self.at += 1
        return self.tokens[self.at - 1]

    def upper(self, ahead: int = 0) -> str:
        token = self.peek(ahead)
        return "" if token is None else token.text.upper()

    def accept(self, *texts: str) -> bool:
        """Accept all the texts, one after another. Return whether they were there."""
        if all(self.upper(k) == text for k, text in enumerate(texts)):
            self.at += len(texts)
            return True
        return False

    def expect(self, text: str, why: str) -> None:
        if not self.accept(text):
            raise self.fault(
                f'"{text}" is missing {why}{f", found {self.upper()}" if not self.is_done else ""}'
            )

    def fault(self, text: str, column: int | None = None) -> BlockFault:
        return BlockFault(self.column if column is None else column, text)


class ExpressionReader(Cursor):
    """Reads values by precedence. A language says what a number and a variable look like (`atom`)."""

    grammar: Grammar
    depth = 0
    operators = 0

    def expression(self, lowest: int = 0) -> Value:
        """Return the values and the operators between them that bind tighter than `lowest`."""
        left = self.operand()
        levels = self.grammar.levels
        while (operator := self.upper()) in levels and levels[operator] > lowest:
            column = self.next().column
            self.operators += 1
            if self.operators > MOST_OPERATORS:
                raise self.fault(
                    f"more than {MOST_OPERATORS} operators in one block; divide the expression", column
                )
            right = self.expression(levels[operator])
            left = self.keep(self.join(operator, left, right, column))
        return left

    def join(self, operator: str, left: Value, right: Value, column: int) -> Evaluation:
        """Return two values and the operator between them."""
        return binary(self.grammar, operator, left, right, column)

    def operand(self) -> Value:
        """Return a value with the operators before it."""
        self.depth += 1
        if self.depth > DEEPEST_BRACKETS:
            raise self.fault(
                f"brackets, signs or functions are nested more than {DEEPEST_BRACKETS} deep; divide the expression"
            )
        value = self._operand()
        self.depth -= 1
        return value

    def _operand(self) -> Value:
        prefix = self.upper()
        if prefix in self.grammar.prefixes:
            self.at += 1
            tightness, function = self.grammar.prefixes[prefix]
            return apply_sign(function, self.expression(tightness))
        if self.upper() == self.grammar.brackets[0]:
            return self.read_brackets()
        return self.atom()

    def read_brackets(self) -> Value:
        """Return an expression in brackets."""
        self.at += 1
        inside = self.expression()
        self.expect(self.grammar.brackets[1], "after the expression")
        return inside

    def keep(self, value: Evaluation) -> Value:
        """Return the kept form of an expression: a function, for readers that evaluate it later."""
        return value

    def atom(self) -> Value:
        """Return a number, a variable or a call of a function."""
        raise NotImplementedError
