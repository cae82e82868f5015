"""Numbers, parameters and expressions of O-words (LinuxCNC) and of Fanuc macro B, read from a line into functions.

A value is a number or a function of the parameters, called when the block is executed, so a loop reads its text once.
None stands for a vacant Fanuc variable: 0 in sums, ignored as the value of a word, equal to nothing but itself.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from typing import Protocol

from vcmm.nc.faults import BlockFault


class Parameters(Protocol):
    """What an expression sees of the control."""

    def number(self, index: int) -> float | None: ...
    def named(self, name: str) -> float: ...
    def exists(self, name: str) -> bool: ...


Value = Callable[[Parameters], "float | None"]
_NUMBER = re.compile(r"[ \t]*[-+]?[ \t]*(?:\d[\d \t]*(?:\.[\d \t]*)?|\.[ \t]*\d[\d \t]*)")
_NAME = re.compile(r"[A-Za-z]+")
_LEVELS = {  # binding strength of the binary operators; equal strengths bind from the left
    "o": {"**": 6, "*": 5, "/": 5, "MOD": 5, "+": 4, "-": 4, "EQ": 3, "NE": 3, "GT": 3, "GE": 3, "LT": 3, "LE": 3, "AND": 2, "OR": 2, "XOR": 2},
    "macro": {"*": 5, "/": 5, "AND": 5, "MOD": 5, "+": 4, "-": 4, "OR": 4, "XOR": 4, "EQ": 3, "NE": 3, "GT": 3, "GE": 3, "LT": 3, "LE": 3, "&&": 2, "||": 2},
}  # fmt: skip
_FUNCTIONS = ("ABS", "ACOS", "ASIN", "ATAN", "COS", "EXP", "FIX", "FUP", "LN", "ROUND", "SIN", "SQRT", "TAN")
FUNCTIONS = {"o": (*_FUNCTIONS, "EXISTS"), "macro": (*_FUNCTIONS, "POW", "ADP")}


class Reader:
    """Reads values from one line. `at` is the index of the next character; columns in messages are at + 1."""

    def __init__(self, text: str, words: str, at: int = 0) -> None:
        self.text, self.words, self.at = text, words, at
        self.levels = _LEVELS[words]

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
            found = self.skip()
            raise self.fault(f'"{piece}" is missing {why}{f", {found!r} stands there" if found else ""}')

    def value(self) -> float | Value:
        """A number, #parameter, [expression] or function, with signs before it."""
        if self.skip() and self.text[self.at] in "+-":
            match = _NUMBER.match(self.text, self.at)
            if match:
                return self._number(match)
            sign = -1.0 if self.text[self.at] == "-" else 1.0
            self.at += 1
            return _signed(sign, self.value())
        here = self.skip()
        if here == "[":
            return self.bracket()
        if here == "#":
            return self.parameter()
        match = _NUMBER.match(self.text, self.at)
        if match:
            return self._number(match)
        if here.isalpha():
            return self._function()
        raise self.fault(
            f"a number is due here, {repr(here) + ' stands there' if here else 'the line ends'}; write for example 12.5"
        )

    def _number(self, match: re.Match[str]) -> float:
        text = match[0].replace(" ", "").replace("\t", "")
        self.at = match.end()
        if self.text[self.at : self.at + 1] == "," and self.text[self.at + 1 : self.at + 2].isdigit():
            raise self.fault("a comma stands in a number; decimals take a point, as in 12.5")
        if self.at < len(self.text) and self.text[self.at] == ".":
            raise self.fault("a second decimal point stands in a number; write one, as in 12.5")
        if not math.isfinite(float(text)):
            raise self.fault("this number is too large; correct it", match.start())
        return float(text)

    def bracket(self) -> float | Value:
        """[expression]."""
        begin = self.at
        self.expect("[", "before an expression")
        inside = self.expression(0)
        if not self.accept("]"):
            raise self.fault('"[" is never closed; add "]"', begin)
        return inside

    def expression(self, lowest: int) -> float | Value:
        left = self.value()
        while True:
            operator = self._operator()
            if not operator or self.levels[operator] <= lowest:
                return left
            at = self.at
            self.at += len(operator)
            left = _binary(operator, left, self.expression(self.levels[operator]), self.words, at + 1)

    def _operator(self) -> str:
        self.skip()
        rest = self.text[self.at : self.at + 3].upper()
        for size in (3, 2, 1):
            if rest[:size] in self.levels and len(rest[:size]) == size:
                return rest[:size]
        return ""

    def parameter(self) -> Value:
        """#12, ##1, #[expression], #<name> (O-words)."""
        target = self.target()
        if isinstance(target, str):
            return lambda parameters: parameters.named(target)
        if callable(target):
            index = target
            return lambda parameters: parameters.number(whole(index(parameters), "the number of a parameter"))
        fixed = int(target)
        return lambda parameters: parameters.number(fixed)

    def target(self) -> str | float | Value:
        """What a parameter is called: its name, its number, or a function that gives the number."""
        self.expect("#", "before a parameter")
        if self.skip() == "<":
            return self._angle_name()
        number = self.value()
        if not callable(number) and (number != int(number) or number < 0):
            raise self.fault(f"parameter #{number:g} does not exist; numbers of parameters are whole")
        return number

    def _angle_name(self) -> str:
        if self.words != "o":
            raise self.fault("named parameters #<...> belong to the linuxcnc dialect; use #100 here")
        end = self.text.find(">", self.at)
        if end < 0:
            raise self.fault('the name of a parameter is never closed; add ">"')
        name = "".join(self.text[self.at + 1 : end].split()).lower()
        self.at = end + 1
        return name

    def _function(self) -> float | Value:
        match = _NAME.match(self.text, self.at)
        assert match is not None
        at, name = self.at, match[0].upper()
        known = next((f for f in FUNCTIONS[self.words] if name.startswith(f)), None)
        if known is None:
            raise self.fault(
                f'"{match[0]}" is no function of this dialect; known: {", ".join(FUNCTIONS[self.words])}'
            )
        self.at += len(known)
        if known == "EXISTS":
            return self._exists()
        self.expect("[", f"after {known}")
        first = self.expression(0)
        second = self._second(known)
        return _call(known, first, second, self.words, at + 1)

    def _second(self, known: str) -> float | Value | None:
        """The second argument of ATAN[a]/[b] or ATAN[a,b] or POW[a,b]."""
        second: float | Value | None = None
        if known in ("ATAN", "POW") and self.words == "macro" and self.accept(","):
            second = self.expression(0)
        self.expect("]", f"after the argument of {known}")
        if known == "ATAN" and second is None:
            before = self.at
            if self.accept("/"):
                if self.skip() == "[":
                    return self.bracket()
                self.at = before
            if self.words == "o":
                raise self.fault("ATAN takes two arguments; write ATAN[y]/[x]")
        return second

    def _exists(self) -> Value:
        self.expect("[", "after EXISTS")
        name = self.target()
        self.expect("]", "after the argument of EXISTS")
        if not isinstance(name, str):
            raise self.fault("EXISTS takes a named parameter, as in EXISTS[#<depth>]")
        return lambda parameters: 1.0 if parameters.exists(name) else 0.0


def whole(number: float | None, what: str) -> int:
    """A whole number from a computed one. Raises BlockFault (column 0: the caller knows it)."""
    if number is None or not math.isfinite(number) or abs(number - round(number)) > 1e-4:
        shown = "vacant" if number is None else f"{number:g}"
        raise BlockFault(0, f"{what} is {shown}, and a whole number is due")
    return round(number)


def _signed(sign: float, value: float | Value) -> float | Value:
    if callable(value):
        inner = value
        return lambda parameters: sign * (inner(parameters) or 0.0)
    return sign * value


def evaluate(value: float | Value, parameters: Parameters) -> float | None:
    """The number now; None for a vacant variable."""
    return value(parameters) if callable(value) else value


def _binary(operator: str, left: float | Value, right: float | Value, words: str, column: int) -> Value:
    def result(parameters: Parameters) -> float:
        a, b = evaluate(left, parameters), evaluate(right, parameters)
        return _operate(operator, a, b, words, column)

    return result


def _operate(operator: str, a: float | None, b: float | None, words: str, column: int) -> float:
    if operator in ("EQ", "NE") and (a is None or b is None):
        return float((a is b) == (operator == "EQ"))
    x, y = a or 0.0, b or 0.0
    if operator in ("/", "MOD") and y == 0.0:
        raise BlockFault(column, "division by zero; check the parameters used here")
    if operator in ("AND", "OR", "XOR") and words == "macro":
        i, j = whole(x, "a bit pattern"), whole(y, "a bit pattern")
        return float(i & j if operator == "AND" else i | j if operator == "OR" else i ^ j)
    try:
        return finite(float(_ARITHMETIC[operator](x, y)), column)
    except (OverflowError, ZeroDivisionError):
        raise BlockFault(
            column, f"{x:g} {operator} {y:g} has no finite value; check the parameters"
        ) from None


def finite(number: float, column: int) -> float:
    """Refuses NaN, infinity and complex results."""
    if isinstance(number, complex) or not math.isfinite(number):
        raise BlockFault(
            column, f"the result of this expression is {number}, not a finite number; check the parameters"
        )
    return number


def _power(x: float, y: float) -> float:
    return math.nan if isinstance(x**y, complex) else float(x**y)


_ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": lambda x, y: x + y, "-": lambda x, y: x - y, "*": lambda x, y: x * y, "/": lambda x, y: x / y,
    "**": _power, "MOD": lambda x, y: x - abs(y) * math.floor(x / abs(y)),
    "EQ": lambda x, y: x == y, "NE": lambda x, y: x != y, "GT": lambda x, y: x > y, "GE": lambda x, y: x >= y,
    "LT": lambda x, y: x < y, "LE": lambda x, y: x <= y,
    "AND": lambda x, y: bool(x) and bool(y), "OR": lambda x, y: bool(x) or bool(y), "XOR": lambda x, y: bool(x) != bool(y),
    "&&": lambda x, y: bool(x) and bool(y), "||": lambda x, y: bool(x) or bool(y),
}  # fmt: skip


def _call(name: str, first: float | Value, second: float | Value | None, words: str, column: int) -> Value:
    def result(parameters: Parameters) -> float | None:
        a = evaluate(first, parameters)
        if name == "ADP":
            return a
        b = None if second is None else evaluate(second, parameters)
        try:
            return finite(_apply(name, a or 0.0, b, words), column)
        except (ValueError, OverflowError):
            raise BlockFault(
                column, f"{name}[{a or 0.0:g}] has no real value; check the parameters"
            ) from None

    return result


def _apply(name: str, x: float, y: float | None, words: str) -> float:
    """Angles in degrees. FIX and FUP: towards minus and plus infinity (O-words), towards and away from zero (macro B)."""
    if name == "ATAN":
        return math.degrees(math.atan(x) if y is None else math.atan2(x, y))
    if name == "POW":
        return _power(x, y or 0.0)
    if name == "FIX":
        return float(math.floor(x) if words == "o" else math.trunc(x))
    if name == "FUP":
        return float(math.ceil(x) if words == "o" else math.copysign(math.ceil(abs(x)), x))
    return float(_ONE[name](x))


_ONE: dict[str, Callable[[float], float]] = {
    "ABS": abs, "ACOS": lambda x: math.degrees(math.acos(x)), "ASIN": lambda x: math.degrees(math.asin(x)),
    "COS": lambda x: math.cos(math.radians(x)), "SIN": lambda x: math.sin(math.radians(x)),
    "TAN": lambda x: math.tan(math.radians(x)), "EXP": math.exp, "LN": math.log, "SQRT": math.sqrt,
    "ROUND": lambda x: math.copysign(math.floor(abs(x) + 0.5), x),  # halves away from zero
}  # fmt: skip
