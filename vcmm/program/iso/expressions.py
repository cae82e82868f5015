"""Expressions of O-words (LinuxCNC) and of Fanuc macro B: numbers, parameters, operators."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Any, Protocol

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
    power,
    round_half_up,
    to_degrees,
    whole_number,
)
from vcmm.program.faults import BlockFault
from vcmm.program.tokens import Token


class Parameters(Protocol):
    """Interface of the control for expressions."""

    locals: list[dict[int, float]]

    def number(self, index: int) -> float | None: ...
    def variable(self, name: str) -> float: ...
    def exists(self, name: str) -> bool: ...
    def set(self, target: str | float | None, value: float | None, column: int) -> None: ...


def _bits(function: Callable[[int, int], int]) -> Callable[[float, float], float]:
    return lambda x, y: float(function(whole_number(x, "a bit pattern"), whole_number(y, "a bit pattern")))


_LEVELS = {
    "o": {"**": 6, "*": 5, "/": 5, "MOD": 5, "+": 4, "-": 4, "EQ": 3, "NE": 3, "GT": 3, "GE": 3, "LT": 3, "LE": 3, "AND": 2, "OR": 2, "XOR": 2},
    "macro": {"*": 5, "/": 5, "AND": 5, "MOD": 5, "+": 4, "-": 4, "OR": 4, "XOR": 4, "EQ": 3, "NE": 3, "GT": 3, "GE": 3, "LT": 3, "LE": 3, "&&": 2, "||": 2},
}  # fmt: skip
_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y, "/": lambda x, y: x / y,
    "**": power, "MOD": lambda x, y: x - abs(y) * math.floor(x / abs(y)),
    "EQ": lambda x, y: x == y, "NE": lambda x, y: x != y, "GT": lambda x, y: x > y, "GE": lambda x, y: x >= y,
    "LT": lambda x, y: x < y, "LE": lambda x, y: x <= y,
    "AND": lambda x, y: bool(x) and bool(y), "OR": lambda x, y: bool(x) or bool(y), "XOR": lambda x, y: bool(x) != bool(y),
    "&&": lambda x, y: bool(x) and bool(y), "||": lambda x, y: bool(x) or bool(y),
}  # fmt: skip
_BITWISE = {"AND": _bits(lambda i, j: i & j), "OR": _bits(lambda i, j: i | j), "XOR": _bits(lambda i, j: i ^ j)}  # fmt: skip
_FUNCTIONS: dict[str, tuple[int, Callable[..., float]]] = {  # angles in degrees
    "ABS": (1, abs), "ACOS": (1, to_degrees(math.acos)), "ASIN": (1, to_degrees(math.asin)),
    "ATAN": (2, lambda *x: math.degrees(math.atan(*x) if len(x) == 1 else math.atan2(*x))),
    "COS": (1, in_degrees(math.cos)), "EXP": (1, math.exp), "FIX": (1, math.floor), "FUP": (1, math.ceil), "LN": (1, math.log),
    "ROUND": (1, round_half_up), "SIN": (1, in_degrees(math.sin)), "SQRT": (1, math.sqrt), "TAN": (1, in_degrees(math.tan)),
}  # fmt: skip
_TOWARDS_ZERO: dict[str, tuple[int, Callable[..., float]]] = {
    "FIX": (1, math.trunc), "FUP": (1, away_from_zero), "POW": (2, power), "ADP": (1, lambda x: x),
    "BCD": (1, lambda x: float(int(str(whole_number(x, "the argument of BCD")), 16))),
    "BIN": (1, lambda x: float(f"{whole_number(x, 'the argument of BIN'):x}")),
}  # fmt: skip
_LIKE_DIVIDEND = {
    "MOD": math.fmod
}  # FANUC B-64304EN, "arithmetic and logic operation": negative where the dividend is
_SIGNS: dict[str, tuple[int, Callable[[float], float]]] = {
    "-": (TIGHT, lambda x: -1.0 * x), "+": (TIGHT, lambda x: 1.0 * x),
}  # fmt: skip


def _grammar(words: str) -> Grammar:
    """Return the grammar: FIX and FUP go towards minus and plus infinity in O-words, towards and away from zero in macro B."""
    macro = words == "macro"
    return Grammar(
        levels=_LEVELS[words], operations=_ARITHMETIC | (_BITWISE | _LIKE_DIVIDEND if macro else {}), prefixes=_SIGNS,
        functions=_FUNCTIONS | (_TOWARDS_ZERO if macro else {"EXISTS": (1, float)}), dividing=("/", "MOD"), brackets="[]",
        call="{name}[{arguments}]", equal={"EQ": True, "NE": False},
    )  # fmt: skip


GRAMMARS = {words: _grammar(words) for words in _LEVELS}
_DIGITS = r"\d[\d \t]*(?:\.[\d \t]*)?|\.[ \t]*\d[\d \t]*"  # blanks inside are passed over
NUMBER = re.compile(rf"[ \t]*[-+]?[ \t]*(?:{_DIGITS})")
_LETTERS = re.compile(r"[A-Za-z]+")


def _pattern(words: str) -> re.Pattern[str]:
    names = sorted({n for n in (*_LEVELS[words], *GRAMMARS[words].functions) if n.isalpha()}, key=len)
    signs = sorted((n for n in _LEVELS[words] if not n.isalpha()), key=len)
    return re.compile(
        rf"(?P<space>[ \t]+)|(?P<number>{_DIGITS})|(?P<angle><[^>]*>)|(?P<name>{'|'.join(names[::-1])})"
        rf"|(?P<symbol>{'|'.join(re.escape(s) for s in signs[::-1])}|.)",
        re.IGNORECASE | re.DOTALL,
    )


_PATTERNS = {words: _pattern(words) for words in _LEVELS}


def plain_number(text: str, match: re.Match[str]) -> float:
    """Return the number of a match in a line. Raises BlockFault: a comma, a second point, too large."""
    digits, behind = match[0].replace(" ", "").replace("\t", ""), match.end()
    if text[behind : behind + 1] == "," and text[behind + 1 : behind + 2].isdigit():
        raise BlockFault(behind + 1, "a comma in a number; decimals take a point, as in 12.5")
    if text[behind : behind + 1] == ".":
        raise BlockFault(behind + 1, "a second decimal point in a number; write one, as in 12.5")
    if not math.isfinite(float(digits)):
        raise BlockFault(match.start() + 1, "this number is too large; correct it")
    return float(digits)


class IsoExpressions(ExpressionReader):
    """Values from the place `begin` of a line on. words: "o" or "macro"."""

    def __init__(self, text: str, words: str, begin: int) -> None:
        self.text, self.words, self.grammar = text, words, GRAMMARS[words]
        matches = _PATTERNS[words].finditer(text, begin)
        tokens = [Token(str(m.lastgroup), m[0], 1, m.start() + 1) for m in matches if m.lastgroup != "space"]
        super().__init__(tokens, end=len(text) + 1)

    def expect(self, text: str, why: str) -> None:
        if not self.accept(text):
            token = self.peek()
            there = f", found {token.text[0]!r}" if token else ""
            raise self.fault(f'"{text}" is missing {why}{there}')

    def read_brackets(self) -> Value:
        """Read [expression]."""
        begin = self.column
        self.expect("[", "before an expression")
        inside = self.expression()
        if not self.accept("]"):
            raise self.fault('"[" is never closed; add "]"', begin)
        return inside

    def atom(self) -> Value:
        """Return a number, #parameter or function."""
        token = self.peek()
        if token is None:
            raise self.fault("expected a number, found the end of the line; write for example 12.5")
        if token.text == "#":
            return self.parameter()
        match = NUMBER.match(self.text, token.column - 1) if token.kind == "number" else None
        if match:
            self.at += 1
            return plain_number(self.text, match)
        if token.text[0].isalpha():
            return self._function(token)
        raise self.fault(f"expected a number, found {token.text[0]!r}; write for example 12.5")

    def parameter(self) -> Evaluation:
        """Read a parameter #12, ##1, #[expression], #<name> (O-words)."""
        target = self.target()
        if isinstance(target, str):
            return lambda variables: variables.variable(target)
        if callable(target):
            index = target
            return lambda variables: variables.number(
                whole_number(index(variables), "the number of a parameter")
            )
        fixed = int(target)
        return lambda variables: variables.number(fixed)

    def target(self) -> str | Value:
        """Return the key of a parameter: its name, its number, or a function that gives the number."""
        self.expect("#", "before a parameter")
        token = self.peek()
        if token is not None and token.text[0] == "<":
            return self._name(token)
        number = self.operand()
        if not callable(number) and (number != int(number) or number < 0):
            text = f"parameter #{number:g} does not exist; numbers of parameters are whole"
            raise self.fault(text, self.read_to)
        return number

    def _name(self, token: Token) -> str:
        if self.words != "o":
            raise self.fault("named parameters #<...> belong to the linuxcnc dialect; use #100 here")
        if token.kind != "angle":
            raise self.fault('the name of a parameter is never closed; add ">"')
        self.at += 1
        return "".join(token.text[1:-1].split()).lower()

    def _function(self, token: Token) -> Value:
        name, functions = token.text.upper(), self.grammar.functions
        if name not in functions:
            letters = _LETTERS.match(self.text, token.column - 1)
            raise self.fault(
                f'"{letters[0] if letters else name}" is no function of this dialect; known: {", ".join(functions)}'
            )
        self.at += 1
        if name == "EXISTS":
            return self._exists()
        self.expect("[", f"after {name}")
        arguments = [self.expression()]
        arguments += self._second(name)
        if name == "ADP":
            value = arguments[0]
            return lambda variables: evaluate(value, variables)
        return call_function(self.grammar, name, arguments, token.column)

    def _second(self, name: str) -> list[Value]:
        """Return the second argument of ATAN[a]/[b] or ATAN[a,b] or POW[a,b]."""
        two = name in ("ATAN", "POW") and self.words == "macro" and self.accept(",")
        second = [self.expression()] if two else []
        self.expect("]", f"after the argument of {name}")
        if name == "ATAN" and not second:
            if self.upper() == "/" and self.upper(1) == "[":
                self.at += 1
                return [self.read_brackets()]
            if self.words == "o":
                raise self.fault("ATAN takes two arguments; write ATAN[y]/[x]")
        return second

    def _exists(self) -> Evaluation:
        self.expect("[", "after EXISTS")
        name = self.target()
        self.expect("]", "after the argument of EXISTS")
        if not isinstance(name, str):
            raise self.fault("EXISTS takes a named parameter, as in EXISTS[#<depth>]")
        return lambda variables: 1.0 if variables.exists(name) else 0.0


class LineReader:
    """Reads one line, character by character where words stand. `at` is the index of the next; columns are at + 1."""

    def __init__(self, text: str, words: str, at: int = 0) -> None:
        self.text, self.words, self.at = text, words, at

    def fault(self, text: str, at: int | None = None) -> BlockFault:
        return BlockFault((self.at if at is None else at) + 1, text)

    def skip(self) -> str:
        """Pass blanks; the next character, '' at the end."""
        while self.at < len(self.text) and self.text[self.at] in " \t":
            self.at += 1
        return self.text[self.at] if self.at < len(self.text) else ""

    def accept(self, piece: str) -> bool:
        self.skip()
        if self.text[self.at : self.at + len(piece)].upper() == piece:
            self.at += len(piece)
            return True
        return False

    def expect(self, piece: str, why: str) -> None:
        if not self.accept(piece):
            there = self.skip()
            raise self.fault(f'"{piece}" is missing {why}{f", found {there!r}" if there else ""}')

    def value(self) -> Value:
        """Return a number, #parameter, [expression] or function, with signs before it."""
        self.skip()
        match = NUMBER.match(self.text, self.at)
        if match:
            self.at = match.end()
            return plain_number(self.text, match)
        return self._read(IsoExpressions.operand)

    def bracket(self) -> Value:
        """Read [expression]."""
        return self._read(IsoExpressions.read_brackets)

    def expression(self) -> Value:
        """Return the values and operators, up to where they end."""
        return self._read(IsoExpressions.expression)

    def target(self) -> str | Value:
        """Return the key of a parameter: its name, its number, or a function that gives the number."""
        return self._read(IsoExpressions.target)

    def _read(self, what: Callable[[IsoExpressions], Any]) -> Any:
        reader = IsoExpressions(self.text, self.words, self.at)
        value = what(reader)
        self.at = reader.read_to - 1
        return value
