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
from dataclasses import dataclass
from typing import Any

from vcmm.core.errors import choose_from
from vcmm.program.expressions import (
    TIGHT,
    Evaluation,
    ExpressionReader,
    Grammar,
    Value,
    away_from_zero,
    call_function,
    evaluate,
    in_degrees,
    number,
    round_half_up,
    to_degrees,
    whole_number,
)
from vcmm.program.faults import BlockFault
from vcmm.program.frames import AffineMap
from vcmm.program.tokens import Token, match_tokens

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:EX[-+]?\d+)?"
_TOKEN = re.compile(
    rf"""(?P<end>\r\n|\n|\r)
    |(?P<space>[ \t]+)
    |(?P<comment>;[^\r\n]*)
    |(?P<string>"[^"\r\n]*")
    |(?P<name>[A-Za-z_$]{{2}}[A-Za-z0-9_$]*)
    |(?P<word>[A-Za-z][ \t]*[-+]?{_NUMBER})
    |(?P<letter>[A-Za-z])
    |(?P<number>{_NUMBER}|'B[01]+'|'H[0-9A-F]+')
    |(?P<symbol>==|<>|<=|>=|<<|.)""",
    re.VERBOSE | re.DOTALL | re.IGNORECASE,
)


def _same(a: float, b: float) -> bool:
    """Return whether two REAL values are equal within a relative limit (manual: "Precision correction on comparison errors")."""
    return math.isclose(a, b, rel_tol=1e-12, abs_tol=1e-12)


FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "SIN": (1, in_degrees(math.sin)), "COS": (1, in_degrees(math.cos)), "TAN": (1, in_degrees(math.tan)),
    "ASIN": (1, to_degrees(math.asin)), "ACOS": (1, to_degrees(math.acos)), "ATAN2": (2, to_degrees(math.atan2)),
    "SQRT": (1, math.sqrt), "ABS": (1, abs), "POT": (1, lambda x: x * x), "TRUNC": (1, math.trunc), "ROUND": (1, round_half_up),
    "ROUNDUP": (1, away_from_zero), "LN": (1, math.log), "EXP": (1, math.exp), "MINVAL": (2, min), "MAXVAL": (2, max),
    "BOUND": (3, lambda low, high, x: min(max(x, low), high)),
}  # fmt: skip
GRAMMAR = Grammar(
    levels={
        "*": 10, "/": 10, "DIV": 10, "MOD": 10, "+": 9, "-": 9, "B_AND": 8, "B_XOR": 7, "B_OR": 6, "AND": 5, "XOR": 4, "OR": 3, "<<": 2, ":": 2,
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
FRAME_PARTS = ("TR", "RT", "SC", "MI", "FI")  # of a frame: shift, rotation, scale, mirror, fine shift
CONSTANTS = {"TRUE": 1.0, "FALSE": 0.0, "$PI": math.pi}


def tokenize(text: str) -> Iterator[Token]:
    """Yield all tokens of a text, in order; together they are the text."""
    return match_tokens(_TOKEN, text)


def lines_of(text: str) -> list[list[Token]]:
    """Return the tokens of each line without blanks, comments and line ends."""
    lines: list[list[Token]] = [[]]
    for token in tokenize(text):
        if token.kind == "end":
            lines.append([])
        elif token.kind not in ("space", "comment"):
            lines[-1].append(token)
    return lines


def line_tokens(line: str) -> list[Token]:
    """Return the tokens of one line without blanks and comments."""
    return [t for t in tokenize(line) if t.kind not in ("space", "comment")]


def number_of(text: str) -> float:
    """Return a number: 12.5, -3, 1.5EX-3, 'B101', 'H7F'."""
    if text[0] == "'":
        return float(int(text[2:-1], 2 if text[1] in "Bb" else 16))
    return float(re.sub(r"\s", "", text).upper().replace("EX", "E"))


@dataclass(frozen=True)
class VariableValue:
    """A variable as it is read: an element of an array where there is an index. Called with the program under way, it gives the value.

    `parameter` recognises a number of R parameters.
    """

    name: str
    column: int
    index: tuple[Any, ...] = ()
    parameter: Callable[[object], int] | None = None

    def __call__(self, variables: Any) -> Any:
        if self.parameter is not None:
            return variables.parameter(self.parameter(variables))
        if self.index:
            return variables.element(self.name, self.indices(variables), self.column)
        return variables.variable(self.name, self.column)

    def indices(self, variables: Any) -> tuple[Any, ...]:
        """Return the numbers and names of axes between the brackets."""
        return tuple(i(variables) if callable(i) else i for i in self.index)


def _text(text: str) -> Callable[[Any], Any]:
    """Return a text as a value."""
    return lambda variables: text


def _compare(
    operator: str, left: Value, right: Value, plain: Callable[[Any], float | None]
) -> Callable[[Any], Any]:
    """Return the comparison: == and <> of texts, << of any values; numbers go the plain way."""

    def result(variables: Any) -> Any:
        a, b = (v(variables) if callable(v) else v for v in (left, right))
        if operator == "<<":
            return f"{_text_of(a)}{_text_of(b)}"
        if operator == ":":  # frames, one inside the other
            return a.then(b) if isinstance(a, AffineMap) and isinstance(b, AffineMap) else a or b
        if isinstance(a, str) or isinstance(b, str):
            return float((str(a).upper() == str(b).upper()) == (operator == "=="))
        return plain(variables)

    return result


def _text_of(value: Any) -> str:
    return value if isinstance(value, str) else f"{value or 0.0:g}"


class SinumerikReader(ExpressionReader):
    """Reads the tokens of one line, and expressions."""

    grammar = GRAMMAR

    def join(self, operator: str, left: Value, right: Value, column: int) -> Evaluation:
        """Return the evaluation: texts can be compared and put together."""
        made = super().join(operator, left, right, column)
        return _compare(operator, left, right, made) if operator in ("==", "<>", "<<", ":") else made

    def atom(self) -> Value:
        """Return a number, an R parameter, a constant, a variable or a call of a function."""
        token = self.peek()
        if token is None:
            raise self.fault(
                "expected a number or expression, found the end of the line; write for example 12.5 or R1*2"
            )
        if token.kind == "number":
            self.at += 1
            return number_of(token.text)
        if token.kind in ("word", "letter") and token.text[0] in "rR":
            return VariableValue("R", token.column, parameter=self.index())
        if token.kind == "name":
            return self.read_name(self.next())
        if token.kind == "string":
            self.at += 1
            return _text(token.text[1:-1])
        if (
            token.kind in ("letter", "word")
            and token.text[0].upper() in "XYZABCUVWQ"
            and self.upper(1) != "="
        ):
            self.at += 1  # the name of an axis
            return _text(token.text.upper())
        if token.kind == "letter" and self.upper(1) in (",", ")"):
            self.at += 1  # a letter used as itself: CONTPRON(TAB,"L",N)
            return _text(token.text.upper())
        raise self.fault(f'expected a number or expression, found "{token.text}"')

    def index(self) -> Callable[[object], int]:
        """Return the number of a parameter, R10 or R[expression], as a function."""
        token = self.next()
        if token.kind == "word":
            digits = token.text[1:].strip()
            if not digits.isdigit():
                raise self.fault(f'"{token.text}" is no R parameter; write for example R10', token.column)
            fixed = int(digits)
            return lambda variables: fixed
        self.expect("[", "after R")
        inside = self.expression()
        self.expect("]", "after the number of the R parameter")
        column = token.column
        return lambda variables: whole_number(
            number(inside, variables), "the number of a parameter", column, 1e-6
        )

    def read_name(self, token: Token) -> Value:
        """Return a constant, a variable, or a function with its arguments."""
        name, column = token.text.upper(), token.column
        if name in CONSTANTS:
            return CONSTANTS[name]
        if self.upper() == "(":
            return _call(name, self.optional_arguments(), column)
        if self.upper() == "[":
            return VariableValue(name, column, self.indices())
        return VariableValue(name, column)

    def indices(self) -> tuple[Value, ...]:
        """Read [ a, b ]: numbers, names of axes, TR and its like."""
        self.expect("[", "before the index")
        out: list[Value] = []
        while not self.accept("]"):
            token = self.peek()
            if token is not None and token.kind == "name" and token.text.upper() in FRAME_PARTS:
                self.at += 1
                out.append(_text(token.text.upper()))
            else:
                out.append(self.expression())
            if not self.accept(","):
                self.expect("]", "after the index")
                break
        return tuple(out)

    def arguments(self) -> list[Value]:
        """Read ( a, b )."""
        values = self.optional_arguments()
        if any(a is None for a in values):
            raise self.fault("an argument is missing between the commas")
        return [a for a in values if a is not None]

    def optional_arguments(self) -> list[Value | None]:
        """Read ( a, , b ): an argument left out is None."""
        self.expect("(", "before the arguments")
        values: list[Value | None] = []
        while not self.accept(")"):
            if self.accept(","):
                values.append(None)
                continue
            values.append(self.expression())
            if not self.accept(","):
                self.expect(")", "after the arguments")
                break
        return values


def _call(name: str, arguments: list[Value | None], column: int) -> Value:
    if name not in FUNCTIONS:
        message = f"the function {name} is not understood.{choose_from(name, FUNCTIONS)}"
        return lambda variables: variables.function(
            name, [a and evaluate(a, variables) for a in arguments], column, message
        )
    count = FUNCTIONS[name][0]
    numbers = [a for a in arguments if a is not None]
    if len(numbers) != count:
        raise BlockFault(
            column, f"{name} takes {count} argument{'s' if count > 1 else ''}, got {len(numbers)}"
        )
    return call_function(GRAMMAR, name, numbers, column)
