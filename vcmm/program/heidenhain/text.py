"""Klartext: the lossless layer, and values, Q parameters and formulas read from the tokens of a block.

    "".join(t.text for t in tokenize(text)) == text

Kinds of tokens: end, space, comment (; to the end of the line), string ("..."), name (letters), number, symbol.
Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Programming Q parameters". Angles are degrees.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

from vcmm.core.errors import choose_from
from vcmm.program.expressions import (
    TIGHT,
    Evaluation,
    ExpressionReader,
    Grammar,
    Value,
    call_function,
    in_degrees,
    number,
    power,
    to_degrees,
)
from vcmm.program.tokens import Token, match_tokens

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


_WORD_AND_Q = re.compile(r"([A-Za-z]+?)(Q[LRS]?)\Z", re.IGNORECASE)


_VALUE = r"[-+]?(?:\d+\.?\d*|\.\d+)"
_PLAIN = re.compile(
    rf"[ \t]*(?:\d+[ \t]+)?L((?:[ \t]+[XYZ]{_VALUE})+)(?:[ \t]+(?:(FMAX)|F(\d+\.?\d*)))?[ \t]*\Z"
)
_PLAIN_AXIS = re.compile(rf"([XYZ])({_VALUE})")


class PlainKlartext(NamedTuple):
    """L with X, Y, Z and F alone, with plain numbers: what most blocks are."""

    axes: tuple[tuple[int, float], ...]
    rapid: bool
    feed: float | None


class KlartextBlock:
    """A block: its tokens without blanks, comments and block number; where it stands. Those of a plain line are read when asked for."""

    __slots__ = ("_tokens", "block", "first", "last", "number", "text")

    def __init__(
        self,
        tokens: tuple[Token, ...] | None,
        number: int,
        first: int,
        last: int,
        text: str = "",
        block: str = "",
    ) -> None:
        self._tokens, self.number, self.first, self.last, self.text = tokens, number, first, last, text
        self.block = int(block) if block.isdigit() else -1  # its block number, -1 without one

    @property
    def plain(self) -> bool:
        return self._tokens is None

    @property
    def tokens(self) -> tuple[Token, ...]:
        if self._tokens is None:
            row = [
                t._replace(line=self.number)
                for t in tokenize(self.text)
                if t.kind not in ("space", "comment")
            ]
            self._tokens = tuple(row[1:] if row[0].kind == "number" else row)
        return self._tokens

    def read(self) -> PlainKlartext | None:
        """Return the words of a plain line; None for others."""
        match = _PLAIN.match(self.text) if self.text else None
        if match is None:
            return None
        axes = tuple(("XYZ".index(w[1]), float(w[2])) for w in _PLAIN_AXIS.finditer(match[1]))
        return PlainKlartext(axes, match[2] is not None, None if match[3] is None else float(match[3]))


def plain_block(text: str, number: int) -> KlartextBlock | None:
    """Return a plain line; None for others, and for one that names an axis twice."""
    match = _PLAIN.match(text)
    if match is None or any(match[1].count(axis) > 1 for axis in "XYZ"):
        return None
    return KlartextBlock(None, number, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1, text)


def tokenize(text: str) -> Iterator[Token]:
    """Yield all tokens of a text, in order; together they are the text."""
    return match_tokens(_TOKEN, text)


def blocks_of(text: str) -> list[KlartextBlock]:
    """Return the blocks; a line that ends with ~ goes on in the next one.

    A block of nothing but a comment goes on as a comment (to the next block number), and `* -` heads a line of structure,
    which is text: TNC 640 User's Manual Klartext Programming, "Entering comments", "Structuring programs".
    """
    blocks: list[KlartextBlock] = []
    row: list[Token] = []
    goes_on = remark = False
    for at, written in enumerate(_lines(text), 1):
        plain = plain_block(written, at) if isinstance(written, str) and not row and not remark else None
        if plain is not None:
            blocks.append(plain)
            continue
        line = [t._replace(line=at) for t in tokenize(written)] if isinstance(written, str) else written
        tokens = [t for t in line if t.kind not in ("space", "comment")]
        continued = remark and not (tokens and tokens[0].kind == "number")
        remark = False
        if not row and (continued or _is_structure(tokens)):
            remark = continued and _goes_on(line)
            continue
        goes_on = _goes_on(line)
        row += _pieces([t for t in tokens if t.text != "~"])
        if goes_on and all(t.kind == "number" for t in row):
            row, remark = [], True
        elif not goes_on and row:
            blocks.append(_line(row))
            row = []
    if row:
        blocks.append(_line(row))
    return [
        line for line in blocks if line.plain or line.tokens
    ]  # not: a block number with nothing but a comment


def _lines(text: str) -> Iterable[str | list[Token]]:
    """Return the lines as texts; as tokens where a lone CR is among them, which may be part of a comment."""
    plain = text.replace("\r\n", "\n")
    return _token_lines(text) if "\r" in plain else plain.split("\n")


def _token_lines(text: str) -> Iterator[list[Token]]:
    """Yield the tokens of each line without its end."""
    line: list[Token] = []
    for token in tokenize(text):
        if token.kind == "end":
            yield line
            line = []
        else:
            line.append(token)
    yield line


def _is_structure(row: Sequence[Token]) -> bool:
    """Return whether a line is `* - FINISHING`, behind its block number or without one."""
    first = row[1:2] if row and row[0].kind == "number" else row[:1]
    return bool(first) and first[0].text == "*"


def _goes_on(line: Sequence[Token]) -> bool:
    """Return whether the block has not ended with this line: ~ as its last sign, behind a comment or not."""
    last = next((t for t in reversed(line) if t.kind != "space"), None)
    return last is not None and last.text.rstrip().endswith("~")


def _pieces(row: Sequence[Token]) -> Iterator[Token]:
    """Return the tokens of joined words: XQ1 is X and Q1, IDXQ1 is IDX and Q1; an address whose value is a parameter needs no blank."""
    for here, then in pairwise([*row, Token("end", "", 0, 0)]):
        touching = then.kind == "number" and then.column == here.column + len(here.text)
        match = _WORD_AND_Q.match(here.text) if here.kind == "name" and touching else None
        if match is None:
            yield here
            continue
        cut = match.end(1)
        yield here._replace(text=here.text[:cut])
        yield here._replace(text=here.text[cut:], column=here.column + cut)


def _line(row: list[Token]) -> KlartextBlock:
    first, last = row[0], row[-1]
    tokens = row[1:] if first.kind == "number" else row
    same = [t for t in row if t.line == first.line]
    last = same[-1]
    block = first.text if first.kind == "number" else ""
    return KlartextBlock(tuple(tokens), first.line, first.column, last.column + len(last.text), block=block)


def _raise_power(a: float, b: float) -> float:
    result = power(a, b) if a or b > 0 else math.nan
    if math.isnan(result):
        raise ValueError
    return result


FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {
    "SIN": (1, in_degrees(math.sin)), "COS": (1, in_degrees(math.cos)), "TAN": (1, in_degrees(math.tan)),
    "ASIN": (1, to_degrees(math.asin)), "ACOS": (1, to_degrees(math.acos)), "ATAN": (1, to_degrees(math.atan)), "SQRT": (1, math.sqrt),
    "SQ": (1, lambda x: x * x), "LN": (1, math.log), "LOG": (1, math.log10), "EXP": (1, math.exp), "NEG": (1, lambda x: -x),
    "INT": (1, math.trunc), "ABS": (1, abs), "FRAC": (1, lambda x: x - math.trunc(x)), "SGN": (1, lambda x: float(x > 0) - float(x < 0)),
}  # fmt: skip
GRAMMAR = Grammar(
    levels={"^": 3, "*": 2, "/": 2, "%": 2, "+": 1, "-": 1},
    operations={
        "^": _raise_power, "*": lambda a, b: a * b, "/": lambda a, b: a / b, "%": math.fmod, "+": lambda a, b: a + b,
        "-": lambda a, b: a - b,
    },
    prefixes={"-": (2, lambda x: -x), "+": (TIGHT, lambda x: x)},
    functions=FUNCTIONS, dividing=("/", "%"), call="{name} {arguments}",
)  # fmt: skip


class KlartextReader(ExpressionReader):
    """Reads the tokens of one block and works its values out as it reads. `parameters`: Q1, QL3, QR5 -> value."""

    grammar = GRAMMAR

    def __init__(
        self, tokens: Sequence[Token], parameters: Mapping[str, float], unset: Callable[[str], float | None]
    ) -> None:
        super().__init__(tokens)
        self.parameters, self.unset = parameters, unset
        self.spans: dict[
            str, tuple[int, int, int]
        ] = {}  # address -> tokens: its own, first and past last of its value
        self.computed: list[tuple[int, int, float]] = []  # values that are no plain numbers: tokens, value

    def rest(self) -> str:
        """Return the rest of the block, as one text."""
        text = "".join(t.text for t in self.tokens[self.at :])
        self.at = len(self.tokens)
        return text

    def is_hidden(self) -> bool:
        """Return whether / is before the block, with its number behind it or not: /81 M30."""
        if not self.accept("/"):
            return False
        token = self.peek()
        self.at += token is not None and token.kind == "number"
        return True

    # -- values --
    def value(self, what: str) -> float:
        """Return a number or Q parameter with signs before it, as it follows an address."""
        sign, begin = 1.0, self.at
        while self.upper() in ("+", "-"):
            sign = -sign if self.upper() == "-" else sign
            self.at += 1
        token = self.peek()
        if token is not None and token.kind == "number":
            self.at += 1
            return sign * float(token.text.replace(",", "."))
        if token is not None and self.is_parameter():
            value = sign * self.read(self.parameter())
            self.computed.append((begin, self.at, value))
            return value
        raise self.fault(
            f"{what} needs a number or a Q parameter{f', found {token.text}' if token else ''}; write for example {what}+12.5"
        )

    def is_parameter(self, ahead: int = 0) -> bool:
        token = self.peek(ahead + 1)
        return self.upper(ahead) in ("Q", "QL", "QR") and token is not None and token.kind == "number"

    def parameter(self) -> str:
        """Return the name of a parameter, Q12."""
        if self.upper() == "QS":
            raise self.fault("QS (text parameters) are not understood")
        if not self.is_parameter():
            raise self.fault("expected a Q parameter, as in Q10")
        if not self.upper(1).isdigit():
            raise self.fault(
                f"{self.upper()}{self.upper(1)} is no Q parameter; their numbers are whole, as in Q10"
            )
        name = f"{self.upper()}{int(self.upper(1))}"
        self.at += 2
        return name

    def read(self, name: str) -> float:
        if name not in self.parameters:
            return self.unset(name) or 0.0
        return self.parameters[name]

    # -- formulas --
    def formula(self) -> float:
        """Evaluate a formula: + - * / % ^ with brackets and functions; ^ binds strongest, equal ones from the left."""
        return number(self.expression(), self)

    def keep(self, value: Evaluation) -> float:
        """Return the value, evaluated at once."""
        return number(value, self)

    def single(self) -> float:
        """Return one value of a formula."""
        return number(self.operand(), self)

    def atom(self) -> Value:
        """Return a number, a Q parameter, PI, or a function, whose argument needs no brackets."""
        if self.accept("PI"):
            return math.pi
        token = self.peek()
        if token is None or token.kind != "name" or self.is_parameter():
            return self.value("the formula")
        name = token.text.upper()
        if name not in FUNCTIONS:
            raise self.fault(f"{token.text} is no function of a formula.{choose_from(name, FUNCTIONS)}")
        self.at += 1
        return self.keep(call_function(GRAMMAR, name, [self.operand()], token.column))
