"""Write the words of the new program: numbers replaced in place, words added and removed, blocks added; all else byte for byte."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from vcmm.compensation.frame import AXES, CENTRES
from vcmm.compensation.numbers import SAME_INCREMENT_SHARE, Diffusion, format_number, value_of
from vcmm.compensation.source import Edit, SourceText, apply_edits, code_of, separator
from vcmm.core.run import Array
from vcmm.program.dialects import Dialect
from vcmm.program.trace import Trace, WordAt


@dataclass(eq=False)
class Wording:
    """State of the new program (q: axes), and the edits decided so far, by index of the line."""

    source: SourceText
    dialect: Dialect
    decimals: tuple[int, int]  # metric, inch
    q: Array
    axes: str = AXES
    carry: bool = True  # rounding errors are carried along chains of short blocks
    chain_ends: bool = True  # the block after this one belongs to no chain of short blocks
    slack: float = 0.0  # mm by which a feed may leave such an axis off
    rapid: float = math.inf  # mm by which a rapid may leave an axis off that it does not name
    above: int | None = (
        None  # axis of the hole that comes next: what leads there may stop above it at any height
    )
    edits: dict[int, list[Edit]] = field(default_factory=dict)
    added_blocks: dict[int, list[str]] = field(default_factory=dict)
    before: dict[int, list[str]] = field(default_factory=dict)  # blocks that stand before a line
    diffusions: dict[tuple[int, bool], Diffusion] = field(default_factory=dict)
    rounding: list[Array] = field(default_factory=list)  # written - wanted at the ends of feeds, mm
    cycle: dict[str, float] = field(default_factory=dict)  # of a series of holes, see holes.py
    expressions: set[int] = field(default_factory=set)  # lines in which an expression became a number

    def __post_init__(self) -> None:
        self.gap = separator(self.source)

    def absent(self, i: int) -> bool:
        """Return whether an axis is never added to a block: axes that the machine lacks, and Y of a lathe."""
        return AXES[i] not in self.axes or (self.dialect.lathe and i == 1)

    def step(self, inch: bool) -> float:
        return float(10.0 ** -self.decimals[inch])

    # -- what dialects do differently ---------------------------------------------------------------------------------
    def code(self, index: int) -> str:
        """Return a line with its comments blanked."""
        return code_of(self.source.lines[index][0])

    def spelt(self, letter: str, number: str) -> str:
        """Return a new word."""
        return letter + number

    def number(self, value: float, decimals: int, like: str = "", whole: bool = False) -> str:
        return format_number(value, decimals, like, whole)

    def order(self) -> Sequence[str]:
        """Return addresses in the order in which new words are put in."""
        return AXES + CENTRES + "R"

    # -- words ------------------------------------------------------------------------------------------------------
    def word(self, index: int, trace: Trace, letter: str, value: float, old: float, inch: bool) -> None:
        """Give a word of the block its new value, or add it. old: what it says now, where it is an expression."""
        word = trace.words.get(letter)
        step, decimals = self.step(inch), self.decimals[inch]
        if word is None:
            self._add(index, trace, letter, self.number(value, decimals, self._number_style(trace)))
            return
        pointless = word.decimals is None and self.dialect.decimal_point == "increment" and letter != "F"
        if word.plain:
            says = value_of(word) * (self.dialect.increment[inch] if pointless and value_of(word) else 1.0)
            if abs(value - says) < SAME_INCREMENT_SHARE * step:
                return
        elif abs(value - old) < 0.5 * step:
            return
        else:
            self.expressions.add(index)
        whole = pointless and math.isclose(self.dialect.increment[inch], step)
        text = self.number(value, 4 if letter == "F" else decimals, word.text, whole)
        self.replace(index, word, text)

    def replace(self, index: int, word: WordAt, text: str) -> None:
        """Replace the value of a word; its address and the blanks after it stay."""
        if word.begin:
            at = word.line - 1 if word.line else index
            self.edits.setdefault(at, []).append(Edit(word.begin, word.end, text))
            return
        line = self.source.lines[index][0]
        begin = word.first
        while line[begin : begin + 1] in (" ", "\t"):
            begin += 1
        self.edits.setdefault(index, []).append(Edit(begin + 1, word.last, text))

    def drop(self, index: int, word: WordAt) -> None:
        index = word.line - 1 if word.line else index
        line = self.source.lines[index][0]
        blank = line[word.last - 1 : word.last] == " "
        first = word.first - (1 if not blank and line[: word.first - 1].endswith(" ") else 0)
        self.edits.setdefault(index, []).append(Edit(first, word.last + blank, ""))

    def _add(self, index: int, trace: Trace, letter: str, number: str) -> None:
        """Add a word that the block lacks: behind those that come before it in X Y Z I J K R, else before the first."""
        order, code = self.order(), self.code(index)
        gap, place = self.gap, order.index(letter)
        word = self.spelt(letter, number)
        word = word.lower() if _lower(code) else word
        before = [w for k, w in trace.words.items() if k in order and order.index(k) < place]
        behind = [w for k, w in trace.words.items() if k in order and order.index(k) > place]
        if before:
            at = max(w.last for w in before)
            edit = Edit(at, at, f"{gap}{word}")
        elif behind:
            at = min(w.first for w in behind)
            edit = Edit(at, at, f"{word}{gap}")
        else:
            at = len(code.rstrip()) + 1
            edit = Edit(at, at, f"{gap}{word}")
        self.edits.setdefault(index, []).append(edit)

    def insert(self, index: int, words: Sequence[str]) -> None:
        line = self.source.lines[index][0]
        slash = line.lstrip()[:1] == "/"
        digits = line.lstrip()[1:2] if slash and line.lstrip()[1:2].isdigit() else ""
        body = self.gap.join(words)
        body = body.lower() if _lower(self.code(index)) else body
        self.added_blocks.setdefault(index, []).append((f"/{digits} " if slash else "") + body)

    def _number_style(self, trace: Trace) -> str:
        """Return a number of the block whose style a new one takes: only the missing zero before the point, never the plus sign."""
        return next((w.text.lstrip("+- ") for k, w in trace.words.items() if k in AXES and w.plain), "")

    # -- the text ---------------------------------------------------------------------------------------------------
    def lines(self) -> list[tuple[str, int]]:
        """Return the new lines with their ends, and the index of the source line each belongs to."""
        out = []
        for index, (body, end) in enumerate(self.source.lines):
            added = self.added_blocks.get(index, [])
            line_end = end or (self.source.end if added else "")
            out += [(text + (end or self.source.end), index) for text in self.before.get(index, [])]
            out.append((apply_edits(body, self.edits.get(index, [])) + line_end, index))
            for k, text in enumerate(added):
                last = k == len(added) - 1
                out.append((text + (end if last else line_end), index))
        return out


def _lower(code: str) -> bool:
    """Return whether the words of a line are written in small letters."""
    return code != code.upper() and code == code.lower()
