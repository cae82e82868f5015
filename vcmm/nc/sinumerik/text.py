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
from typing import Protocol

from vcmm.core.errors import choose_from
from vcmm.nc.cursor import Cursor
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


class Environment(Protocol):
    """What an expression sees of the control."""

    def parameter(self, index: int) -> float: ...
    def variable(self, name: str, column: int) -> float: ...


Expr = Callable[[Environment], float]
_LEVELS = {
    "*": 9, "/": 9, "DIV": 9, "MOD": 9, "+": 8, "-": 8, "B_AND": 7, "B_XOR": 6, "B_OR": 5, "AND": 4, "XOR": 3, "OR": 2,
    "==": 1, "<>": 1, ">": 1, "<": 1, ">=": 1, "<=": 1,
}  # fmt: skip
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


class Reader(Cursor):
    """Reads the tokens of one line, and expressions."""

    @property
    def reached(self) -> int:
        """One past the last character read."""
        last = self.tokens[max(self.at - 1, 0)]
        return last.column + len(last.text)

    def next(self) -> Token:
        self.at += 1
        return self.tokens[self.at - 1]

    def expression(self, lowest: int = 0) -> Expr:
        left = self.unary()
        while (operator := self.upper()) in _LEVELS and _LEVELS[operator] > lowest:
            column = self.next().column
            left = _binary(operator, left, self.expression(_LEVELS[operator]), column)
        return left

    def unary(self) -> Expr:
        if self.accept("-"):
            inner = self.unary()
            return lambda env: -inner(env)
        if self.accept("+"):
            return self.unary()
        if self.accept("NOT"):
            inner = self.unary()
            return lambda env: float(not inner(env))
        if self.accept("B_NOT"):
            inner = self.unary()
            return lambda env: float(~round(inner(env)))
        return self.value()

    def value(self) -> Expr:
        token = self.peek()
        if token is None:
            raise self.fault(
                "a number or expression is due here, and the line ends; write for example 12.5 or R1*2"
            )
        if self.accept("("):
            inside = self.expression()
            self.expect(")", "after the expression")
            return inside
        if token.kind == "number":
            self.at += 1
            number = number_of(token.text)
            return lambda env: number
        if token.kind in ("word", "letter") and token.text[0] in "rR":
            return self.parameter()
        if token.kind == "name":
            return self.named(self.next())
        raise self.fault(f'a number or expression is due here, "{token.text}" stands there')

    def parameter(self) -> Expr:
        """R10 or R[expression]."""
        index = self.index()
        return lambda env: env.parameter(index(env))

    def index(self) -> Callable[[Environment], int]:
        token = self.next()
        if token.kind == "word":
            number = token.text[1:].strip()
            if not number.isdigit():
                raise self.fault(f'"{token.text}" is no R parameter; write for example R10', token.column)
            fixed = int(number)
            return lambda env: fixed
        self.expect("[", "after R")
        inside = self.expression()
        self.expect("]", "after the number of the R parameter")
        column = token.column
        return lambda env: _whole(inside(env), column)

    def named(self, token: Token) -> Expr:
        name, column = token.text.upper(), token.column
        if name in CONSTANTS:
            constant = CONSTANTS[name]
            return lambda env: constant
        if self.upper() == "(":
            return _call(name, self.arguments(), column)
        if self.upper() == "[":
            raise self.fault(
                f"{token.text}[...]: arrays and system variables with an index are not understood; use R parameters",
                column,
            )
        return lambda env: env.variable(name, column)

    def arguments(self) -> list[Expr]:
        """( a, b )."""
        found = self.optional_arguments()
        if any(a is None for a in found):
            raise self.fault("an argument is missing between the commas")
        return [a for a in found if a is not None]

    def optional_arguments(self) -> list[Expr | None]:
        """( a, , b ): an argument left out is None."""
        self.expect("(", "before the arguments")
        found: list[Expr | None] = []
        while not self.accept(")"):
            if self.accept(","):
                found.append(None)
                continue
            token = self.peek()
            if token is not None and token.kind == "string":
                raise self.fault("a text argument is not understood here; give a number")
            found.append(self.expression())
            if not self.accept(","):
                self.expect(")", "after the arguments")
                break
        return found


def _whole(value: float, column: int) -> int:
    if not math.isfinite(value) or abs(value - round(value)) > 1e-6:
        raise BlockFault(column, f"the number of a parameter is {value:g}, and a whole number is due")
    return round(value)


def _binary(operator: str, left: Expr, right: Expr, column: int) -> Expr:
    function = _OPERATIONS[operator]

    def result(env: Environment) -> float:
        a, b = left(env), right(env)
        if operator in ("/", "DIV", "MOD") and b == 0.0:
            raise BlockFault(column, "division by zero; check the parameters used here")
        return float(function(a, b))

    return result


def _same(a: float, b: float) -> bool:
    """Comparison of REAL values is relative (manual: "Precision correction on comparison errors")."""
    return math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12)


_OPERATIONS: dict[str, Callable[[float, float], float]] = {
    "*": lambda a, b: a * b, "/": lambda a, b: a / b, "DIV": lambda a, b: math.trunc(a / b), "MOD": math.fmod,
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "B_AND": lambda a, b: round(a) & round(b),
    "B_XOR": lambda a, b: round(a) ^ round(b), "B_OR": lambda a, b: round(a) | round(b), "AND": lambda a, b: bool(a) and bool(b),
    "XOR": lambda a, b: bool(a) != bool(b), "OR": lambda a, b: bool(a) or bool(b), "==": _same,
    "<>": lambda a, b: not _same(a, b), ">": lambda a, b: a > b and not _same(a, b), "<": lambda a, b: a < b and not _same(a, b),
    ">=": lambda a, b: a > b or _same(a, b), "<=": lambda a, b: a < b or _same(a, b),
}  # fmt: skip
FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "SIN": (1, lambda x: math.sin(math.radians(x))), "COS": (1, lambda x: math.cos(math.radians(x))),
    "TAN": (1, lambda x: math.tan(math.radians(x))), "ASIN": (1, lambda x: math.degrees(math.asin(x))),
    "ACOS": (1, lambda x: math.degrees(math.acos(x))), "ATAN2": (2, lambda y, x: math.degrees(math.atan2(y, x))),
    "SQRT": (1, math.sqrt), "ABS": (1, abs), "POT": (1, lambda x: x * x), "TRUNC": (1, math.trunc),
    "ROUND": (1, lambda x: math.copysign(math.floor(abs(x) + 0.5), x)),
    "ROUNDUP": (1, lambda x: math.copysign(math.ceil(abs(x)), x)), "LN": (1, math.log), "EXP": (1, math.exp),
    "MINVAL": (2, min), "MAXVAL": (2, max), "BOUND": (3, lambda low, high, x: min(max(x, low), high)),
}  # fmt: skip


def _call(name: str, arguments: list[Expr], column: int) -> Expr:
    if name not in FUNCTIONS:
        raise BlockFault(column, f"the function {name} is not understood.{choose_from(name, FUNCTIONS)}")
    count, function = FUNCTIONS[name]
    if len(arguments) != count:
        raise BlockFault(
            column, f"{name} takes {count} argument{'s' if count > 1 else ''}, got {len(arguments)}"
        )

    def result(env: Environment) -> float:
        values = [a(env) for a in arguments]
        try:
            return float(function(*values))
        except (ValueError, OverflowError):
            shown = ", ".join(f"{v:g}" for v in values)
            raise BlockFault(column, f"{name}({shown}) has no real value; check the parameters") from None

    return result
