"""Klartext: the lossless layer, and values, Q parameters and formulas read from the tokens of a block.

    "".join(t.text for t in tokenize(text)) == text

Kinds of tokens: end, space, comment (; to the end of the line), string ("..."), name (letters), number, symbol.
Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Programming Q parameters". Angles are degrees.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from vcmm.core.errors import choose_from
from vcmm.nc.cursor import Cursor
from vcmm.nc.faults import BlockFault
from vcmm.nc.tokens import Token, matched

_TOKEN = re.compile(
    r"""(?P<end>\r\n|\n|\r)
    |(?P<space>[ \t]+)
    |(?P<comment>;(?:[^\r\n]|\r(?!\n)(?=[^\n]*\n))*)
    |(?P<string>"[^"\r\n]*")
    |(?P<name>[A-Za-z_]+)
    |(?P<number>\d+(?:[.,]\d*)?|[.,]\d+)
    |(?P<symbol>.)""",
    re.VERBOSE | re.DOTALL,
)


class Line(NamedTuple):
    """A block: its tokens without blanks, comments and block number; where it stands."""

    tokens: tuple[Token, ...]
    number: int
    first: int
    last: int


def tokenize(text: str) -> Iterator[Token]:
    """All tokens of a text, in order; together they are the text."""
    return matched(_TOKEN, text)


def blocks_of(text: str) -> list[Line]:
    """The blocks; a line that ends with ~ goes on in the next one."""
    found: list[Line] = []
    row: list[Token] = []
    goes_on = False
    for token in [*tokenize(text), Token("end", "", 0, 0)]:
        if token.kind == "end":
            if not goes_on and row:
                found.append(_line(row))
                row = []
            goes_on = False
        elif token.kind == "comment":
            goes_on = token.text.rstrip().endswith("~")
        elif token.text == "~":
            goes_on = True
        elif token.kind != "space":
            row.append(token)
    if row:
        found.append(_line(row))
    return [line for line in found if line.tokens]  # not: a block number with nothing but a comment


def _line(row: list[Token]) -> Line:
    first, last = row[0], row[-1]
    tokens = row[1:] if first.kind == "number" else row
    same = [t for t in row if t.line == first.line]
    last = same[-1]
    return Line(tuple(tokens), first.line, first.column, last.column + len(last.text))


class Reader(Cursor):
    """Reads the tokens of one block and evaluates as it reads. `parameters`: Q1, QL3, QR5 -> value."""

    def __init__(
        self, tokens: Sequence[Token], parameters: Mapping[str, float], unset: Callable[[str], None]
    ) -> None:
        super().__init__(tokens)
        self.parameters, self.unset = parameters, unset
        self.spans: dict[
            str, tuple[int, int, int]
        ] = {}  # address -> tokens: its own, first and past last of its value
        self.computed: list[tuple[int, int, float]] = []  # values that are no plain numbers: tokens, value

    def rest(self) -> str:
        """What is left of the block, as one text."""
        text = "".join(t.text for t in self.tokens[self.at :])
        self.at = len(self.tokens)
        return text

    # -- values --
    def value(self, what: str) -> float:
        """A number or Q parameter with signs before it, as it follows an address."""
        sign, begin = 1.0, self.at
        while self.upper() in ("+", "-"):
            sign = -sign if self.upper() == "-" else sign
            self.at += 1
        token = self.peek()
        if token is not None and token.kind == "number":
            self.at += 1
            return sign * float(token.text.replace(",", "."))
        if token is not None and self.is_parameter():
            found = sign * self.read(self.parameter())
            self.computed.append((begin, self.at, found))
            return found
        raise self.fault(
            f"{what} needs a number or a Q parameter{f', {token.text} stands there' if token else ''}; write for example {what}+12.5"
        )

    def is_parameter(self, ahead: int = 0) -> bool:
        token = self.peek(ahead + 1)
        return self.upper(ahead) in ("Q", "QL", "QR") and token is not None and token.kind == "number"

    def parameter(self) -> str:
        """The name of a parameter, Q12."""
        if self.upper() == "QS":
            raise self.fault("QS (text parameters) are not understood")
        if not self.is_parameter():
            raise self.fault("a Q parameter is due here, as in Q10")
        if not self.upper(1).isdigit():
            raise self.fault(
                f"{self.upper()}{self.upper(1)} is no Q parameter; their numbers are whole, as in Q10"
            )
        name = f"{self.upper()}{int(self.upper(1))}"
        self.at += 2
        return name

    def read(self, name: str) -> float:
        if name not in self.parameters:
            self.unset(name)
        return self.parameters.get(name, 0.0)

    # -- formulas --
    def formula(self, lowest: int = 0) -> float:
        """+ - * / % ^ with brackets and functions; ^ binds strongest, equal ones from the left."""
        left = self.operand()
        while (operator := self.upper()) in _LEVELS and _LEVELS[operator] > lowest:
            column = self.column
            self.at += 1
            left = _operate(operator, left, self.formula(_LEVELS[operator]), column)
        return left

    def operand(self) -> float:
        if self.accept("-"):
            return -self.formula(2)
        if self.accept("+"):
            return self.operand()
        if self.accept("("):
            inside = self.formula()
            self.expect(")", "after the expression")
            return inside
        if self.accept("PI"):
            return math.pi
        token = self.peek()
        if token is not None and token.kind == "name" and not self.is_parameter():
            return self.function(token)
        return self.value("the formula")

    def function(self, token: Token) -> float:
        name = token.text.upper()
        if name not in FUNCTIONS:
            raise self.fault(f"{token.text} is no function of a formula.{choose_from(name, FUNCTIONS)}")
        self.at += 1
        argument = self.operand()
        try:
            return float(FUNCTIONS[name](argument))
        except (ValueError, OverflowError):
            raise BlockFault(
                token.column, f"{name} {argument:g} has no real value; check the parameters"
            ) from None


_LEVELS = {"^": 3, "*": 2, "/": 2, "%": 2, "+": 1, "-": 1}
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "SIN": lambda x: math.sin(math.radians(x)), "COS": lambda x: math.cos(math.radians(x)), "TAN": lambda x: math.tan(math.radians(x)),
    "ASIN": lambda x: math.degrees(math.asin(x)), "ACOS": lambda x: math.degrees(math.acos(x)),
    "ATAN": lambda x: math.degrees(math.atan(x)), "SQRT": math.sqrt, "SQ": lambda x: x * x, "LN": math.log, "LOG": math.log10,
    "EXP": math.exp, "NEG": lambda x: -x, "INT": math.trunc, "ABS": abs, "FRAC": lambda x: x - math.trunc(x),
    "SGN": lambda x: float(x > 0) - float(x < 0),
}  # fmt: skip


def _operate(operator: str, a: float, b: float, column: int) -> float:
    if operator in ("/", "%") and b == 0.0:
        raise BlockFault(column, "division by zero; check the parameters used here")
    if operator == "^":
        power = a**b if a or b > 0 else math.nan
        if isinstance(power, complex) or not math.isfinite(power):
            raise BlockFault(column, f"{a:g} ^ {b:g} has no real value; check the parameters")
        return float(power)
    return (
        {"+": a + b, "-": a - b, "*": a * b}[operator]
        if operator in "+-*"
        else a / b
        if operator == "/"
        else math.fmod(a, b)
    )
