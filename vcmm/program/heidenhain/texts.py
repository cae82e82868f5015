"""Texts in Klartext: QS parameters, joined, cut, and turned into numbers.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "String parameters": || joins, TOCHAR turns a number into a text, SUBSTR cuts LEN
characters from BEG on (the first is 0), TONUMB turns a text into a number, STRLEN is its length, INSTR where a text begins in another one (its
length where it does not), STRCOMP 0 where both are the same, -1 or 1 where the first is before or behind the second in the alphabet.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field

_VALUE = r"([-+]?(?:Q[LR]?\d+|\d+(?:\.\d+)?))"
_TERM = re.compile(
    r'"(?P<plain>[^"]*)"|QS(?P<name>\d+)|SUBSTR\(SRC_QS(?P<cut>\d+)BEG' + _VALUE + "LEN" + _VALUE + r"\)|TOCHAR\(DAT" + _VALUE + "DECIMALS" + _VALUE + r"\)",
    re.IGNORECASE,
)  # fmt: skip
_NUMBER = re.compile(
    r"(TONUMB|STRLEN|INSTR|STRCOMP)\(SRC_QS(\d+)(?:SEA_QS(\d+))?(?:BEG" + _VALUE + r")?\)", re.IGNORECASE
)
Evaluate = Callable[[str], float]  # a number, or a Q parameter with its sign


@dataclass(eq=False)
class KlartextTexts:
    """QS parameters that are known, by their numbers."""

    values: dict[str, str] = field(default_factory=dict)

    def assign(self, number: str, written: str, value_of: Evaluate) -> bool:
        """Assign QS1 = terms joined by ||. False where a term is not known: the parameter then is not either."""
        text = self.text(written, value_of)
        if text is None:
            self.values.pop(number, None)
            return False
        self.values[number] = text
        return True

    def text(self, expression: str, value_of: Evaluate) -> str | None:
        """Return the text of an expression without blanks; None where it is not known."""
        out, place = "", 0
        while place < len(expression):
            term = _TERM.match(expression, place)
            if term is None:
                return None
            made = self._term(term, value_of)
            if made is None:
                return None
            out += made
            place = term.end()
            if place < len(expression) and not expression.startswith("||", place):
                return None
            place += 2
        return out

    def _term(self, term: re.Match[str], value_of: Evaluate) -> str | None:
        if term["plain"] is not None:
            return term["plain"]
        if term["name"] is not None:
            return self.values.get(term["name"])
        if term["cut"] is not None:
            whole, begin = self.values.get(term["cut"]), round(value_of(term[4]))
            return None if whole is None or begin < 0 else whole[begin : begin + round(value_of(term[5]))]
        return f"{value_of(term[6]):.{max(round(value_of(term[7])), 0)}f}"

    def number(self, text: str, value_of: Evaluate) -> float | None:
        """Return TONUMB, STRLEN, INSTR, STRCOMP, without blanks; None where it is not known."""
        match = _NUMBER.fullmatch(text)
        whole = self.values.get(match[2]) if match else None
        if match is None or whole is None:
            return None
        function, other = match[1].upper(), self.values.get(match[3] or "")
        if function == "STRLEN":
            return float(len(whole))
        if function == "TONUMB":
            try:
                return float(whole.strip().replace(",", "."))
            except ValueError:
                return None
        if other is None:
            return None
        if function == "STRCOMP":
            return float((whole > other) - (whole < other))
        place = whole.find(other, round(value_of(match[4] or "0")))
        return float(place if place >= 0 else len(whole))
