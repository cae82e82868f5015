"""Sinumerik text: the lossless layer and expressions.

    "".join(t.text for t in tokenize(text)) == text

Kinds of tokens: end, space, comment (; to the end of the line), string ("..."), name (two letters or more: TRANS, _N_PART),
word (a letter with a plain number: X-12.5, R10), letter, number (also 1.5EX-3), symbol.
Operators and their order: Siemens, "Programming Manual, NC programming", "Priority of the operations": from high to low
NOT B_NOT, * / DIV MOD, + -, B_AND, B_XOR, B_OR, AND, XOR, OR, comparison. Angles are degrees.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator

from vcmm.core.errors import choose_from
from vcmm.nc.expressions import (
    TIGHT,
    ExpressionReader,
    Grammar,
    Value,
    away_from_zero,
    called,
    in_degrees,
    number,
    rounded,
    to_degrees,
    whole,
)
from vcmm.nc.faults import BlockFault
from vcmm.nc.tokens import Token, matched

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:EX[-+]?\d+)?"
_TOKEN = re.compile(
    rf"""(?P<end>\r\n|\n|\r)
    |(?P<space>[ \t]+)
    |(?P<comment>;[^\r\n]*)
    |(?P<string>"[^"\r\n]*")
    |(?P<name>[A-Za-z_$]{{2}}[A-Za-z0-9_$]*)
    |(?P<word>[A-Za-z][ \t]*[-+]?{_NUMBER})
    |(?P<letter>[A-Za-z])
    |(?P<number>{_NUMBER})
    |(?P<symbol>==|<>|<=|>=|<<|.)""",
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)


def _same(a: float, b: float) -> bool:
    """Comparison of REAL values is relative (manual: "Precision correction on comparison errors")."""
    return math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12)


FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "SIN": (1, in_degrees(math.sin)), "COS": (1, in_degrees(math.cos)), "TAN": (1, in_degrees(math.tan)),
    "ASIN": (1, to_degrees(math.asin)), "ACOS": (1, to_degrees(math.acos)), "ATAN2": (2, to_degrees(math.atan2)),
    "SQRT": (1, math.sqrt), "ABS": (1, abs), "POT": (1, lambda x: x * x), "TRUNC": (1, math.trunc), "ROUND": (1, rounded),
    "ROUNDUP": (1, away_from_zero), "LN": (1, math.log), "EXP": (1, math.exp), "MINVAL": (2, min), "MAXVAL": (2, max),
    "BOUND": (3, lambda low, high, x: min(max(x, low), high)),
}  # fmt: skip
GRAMMAR = Grammar(
    levels={
        "*": 9, "/": 9, "DIV": 9, "MOD": 9, "+": 8, "-": 8, "B_AND": 7, "B_XOR": 6, "B_OR": 5, "AND": 4, "XOR": 3, "OR": 2,
        "==": 1, "<>": 1, ">": 1, "<": 1, ">=": 1, "<=": 1,
    },
    operations={
        "*": lambda a, b: a * b, "/": lambda a, b: a / b, "DIV": lambda a, b: math.trunc(a / b), "MOD": math.fmod,
        "+": lambda a, b: a + b, "-": lambda a, b: a - b, "B_AND": lambda a, b: round(a) & round(b),
        "B_XOR": lambda a, b: round(a) ^ round(b), "B_OR": lambda a, b: round(a) | round(b),
        "AND": lambda a, b: bool(a) and bool(b), "XOR": lambda a, b: bool(a) != bool(b), "OR": lambda a, b: bool(a) or bool(b),
        "==": _same, "<>": lambda a, b: not _same(a, b), ">": lambda a, b: a > b and not _same(a, b),
        "<": lambda a, b: a < b and not _same(a, b), ">=": lambda a, b: a > b or _same(a, b), "<=": lambda a, b: a < b or _same(a, b),
    },
    prefixes={
        "-": (TIGHT, lambda x: -x), "+": (TIGHT, lambda x: x), "NOT": (TIGHT, lambda x: not x),
        "B_NOT": (TIGHT, lambda x: ~round(x)),
    },
    functions=FUNCTIONS, dividing=("/", "DIV", "MOD"),
)  # fmt: skip
CONSTANTS = {"TRUE": 1.0, "FALSE": 0.0, "$PI": math.pi}


def tokenize(text: str) -> Iterator[Token]:
    """All tokens of a text, in order; together they are the text."""
    return matched(_TOKEN, text)


def lines_of(text: str) -> list[list[Token]]:
    """The tokens of each line without blanks, comments and line ends."""
    lines: list[list[Token]] = [[]]
    for token in tokenize(text):
        if token.kind == "end":
            lines.append([])
        elif token.kind not in ("space", "comment"):
            lines[-1].append(token)
    return lines


def number_of(text: str) -> float:
    """12.5, -3, 1.5EX-3."""
    return float(re.sub(r"\s", "", text).upper().replace("EX", "E"))


class SinumerikReader(ExpressionReader):
    """Reads the tokens of one line, and expressions."""

    grammar = GRAMMAR

    def atom(self) -> Value:
        """A number, an R parameter, a constant, a variable or a call of a function."""
        token = self.peek()
        if token is None:
            raise self.fault(
                "a number or expression is due here, and the line ends; write for example 12.5 or R1*2"
            )
        if token.kind == "number":
            self.at += 1
            return number_of(token.text)
        if token.kind in ("word", "letter") and token.text[0] in "rR":
            index = self.index()
            return lambda known: known.parameter(index(known))
        if token.kind == "name":
            return self.named(self.next())
        raise self.fault(f'a number or expression is due here, "{token.text}" stands there')

    def index(self) -> Callable[[object], int]:
        """The number of a parameter, R10 or R[expression], as a function."""
        token = self.next()
        if token.kind == "word":
            digits = token.text[1:].strip()
            if not digits.isdigit():
                raise self.fault(f'"{token.text}" is no R parameter; write for example R10', token.column)
            fixed = int(digits)
            return lambda known: fixed
        self.expect("[", "after R")
        inside = self.expression()
        self.expect("]", "after the number of the R parameter")
        column = token.column
        return lambda known: whole(number(inside, known), "the number of a parameter", column, 1e-6)

    def named(self, token: Token) -> Value:
        """A constant, a variable, or a function with its arguments."""
        name, column = token.text.upper(), token.column
        if name in CONSTANTS:
            return CONSTANTS[name]
        if self.upper() == "(":
            return _call(name, self.arguments(), column)
        if self.upper() == "[":
            raise self.fault(
                f"{token.text}[...]: arrays and system variables with an index are not understood; use R parameters",
                column,
            )
        return lambda known: known.variable(name, column)

    def arguments(self) -> list[Value]:
        """( a, b )."""
        given = self.optional_arguments()
        if any(a is None for a in given):
            raise self.fault("an argument is missing between the commas")
        return [a for a in given if a is not None]

    def optional_arguments(self) -> list[Value | None]:
        """( a, , b ): an argument left out is None."""
        self.expect("(", "before the arguments")
        given: list[Value | None] = []
        while not self.accept(")"):
            if self.accept(","):
                given.append(None)
                continue
            token = self.peek()
            if token is not None and token.kind == "string":
                raise self.fault("a text argument is not understood here; give a number")
            given.append(self.expression())
            if not self.accept(","):
                self.expect(")", "after the arguments")
                break
        return given


def _call(name: str, arguments: list[Value], column: int) -> Value:
    if name not in FUNCTIONS:
        raise BlockFault(column, f"the function {name} is not understood.{choose_from(name, FUNCTIONS)}")
    count = FUNCTIONS[name][0]
    if len(arguments) != count:
        raise BlockFault(
            column, f"{name} takes {count} argument{'s' if count > 1 else ''}, got {len(arguments)}"
        )
    return called(GRAMMAR, name, arguments, column)
