"""The text of a program, prepared for jumping: places of labels, block numbers, loops and programs."""

from __future__ import annotations

import re
from array import array

from vcmm.program.dialects import Dialect
from vcmm.program.faults import BlockFault
from vcmm.program.iso.blocks import O_WORDS, IsoBlock, parse_block
from vcmm.program.tokens import split_lines

_O_WORD = re.compile(
    rf"[ \t]*/?[ \t]*(?:N[ \t]*\d+[ \t]*)?[O:][ \t]*(<[^>]*>|\d+)[ \t]*({'|'.join(O_WORDS)})?", re.IGNORECASE
)
_N_WORD = re.compile(r"[ \t]*/?\d?[ \t]*N[ \t]*(\d+)", re.IGNORECASE)
_JUMP = re.compile(r"(?<![A-Z])(?:GOTO|IF)(?![A-Z])", re.IGNORECASE)
_LOOP = re.compile(r"(?:^|[^A-Z])(DO|END)[ \t]*([123])", re.IGNORECASE)


def _aligns(line: str, match: re.Match[str]) -> bool:
    """Return whether a colon is used for N, as posts write the block of a tool change, :0030 T01 M06: a program number is alone in its line."""
    colon = line[match.start(1) - 1 : match.start(1)] == ":"
    return colon and re.match(r"[ \t]*[A-Z][-+.\d#]", line[match.end(1) :], re.IGNORECASE) is not None


class Text:
    """Lines of one file; blocks are read when they are first reached."""

    def __init__(self, name: str, text: str, dialect: Dialect) -> None:
        self.name, self.dialect = name, dialect
        self.whole, self.lines = text, split_lines(text)
        self._blocks: dict[int, IsoBlock] = {}
        self.runs = array("L", bytes(8 * len(self.lines)))  # how often each line has been executed
        self.o_words: dict[str, list[tuple[int, str]]] = {}  # label -> (index of the line, keyword)
        self.programs: dict[int, int] = {}  # O number -> index of its line
        self._find_o_words()
        self._numbers: dict[int, list[int]] | None = None
        self._loops: list[tuple[int, str, str]] | None = None

    def _find_o_words(self) -> None:
        for i, line in enumerate(self.lines):
            if ("O" in line or "o" in line or ":" in line) and (match := _O_WORD.match(line)):
                label = "".join(match[1].strip("<>").lower().split())
                label = str(int(label)) if label.isdigit() else label
                if match[2] and self.dialect.words == "o":
                    self.o_words.setdefault(label, []).append((i, match[2].lower()))
                elif label.isdigit() and not (self.dialect.survey and _aligns(line, match)):
                    self.programs.setdefault(int(label), i)

    def block(self, index: int) -> IsoBlock:
        """Return the block of a line. It is kept from the second time on: most lines are executed once, and a program has 10^5 of them."""
        block = self._blocks.get(index)
        if block is None:
            block = parse_block(self.lines[index], index + 1, self.dialect)
            if self.runs[index]:
                self._blocks[index] = block
        return block

    def next_o(self, label: str, kinds: tuple[str, ...], index: int, column: int) -> int:
        """Return the first line after `index` with that label and one of the keywords."""
        for i, kind in self.o_words.get(label, ()):
            if i > index and kind in kinds:
                return i
        raise BlockFault(column, f"o{label} {' or '.join(kinds)} is missing after this line; add it")

    def last_o(self, label: str, kinds: tuple[str, ...], index: int, column: int) -> int:
        """Return the last line before `index` with that label and one of the keywords."""
        for i, kind in reversed(self.o_words.get(label, [])):
            if i < index and kind in kinds:
                return i
        raise BlockFault(column, f"o{label} {' or '.join(kinds)} is missing before this line; add it")

    def subprogram(self, label: str) -> int | None:
        """Return the line of o<label> sub."""
        return next((i for i, kind in self.o_words.get(label, ()) if kind == "sub"), None)

    def number(self, n: int, index: int) -> int | None:
        """Return the line of block number N n within the program that holds line `index`: forward first, then from its start."""
        if self._numbers is None:
            self._numbers = {}
            for i, line in enumerate(self.lines):
                match = _N_WORD.match(line)
                if match:
                    self._numbers.setdefault(int(match[1]), []).append(i)
        starts = sorted(self.programs.values())
        begin = max((s for s in starts if s <= index), default=0)
        end = min((s for s in starts if s > index), default=len(self.lines))
        inside = [i for i in self._numbers.get(n, []) if begin <= i < end]
        return next((i for i in inside if i > index), inside[0] if inside else None)

    def has_jumps(self, first: int, last: int) -> bool:
        """Return whether a block of the lines first to last - 1 may jump elsewhere."""
        return any(_JUMP.search(re.sub(r"\([^()]*\)", "", line)) for line in self.lines[first:last])

    def loop_end(self, number: str, index: int) -> int | None:
        """Return the line of END n after a line."""
        return next(
            (i for i, kind, n in self._loop_lines() if i > index and kind == "END" and n == number), None
        )

    def loop_start(self, number: str, index: int) -> int | None:
        """Return the line of DO n before a line."""
        return next(
            (i for i, kind, n in reversed(self._loop_lines()) if i < index and kind == "DO" and n == number),
            None,
        )

    def _loop_lines(self) -> list[tuple[int, str, str]]:
        if self._loops is None:
            self._loops = []
            for i, line in enumerate(self.lines):
                plain = re.sub(r"\([^()]*\)", "", line)
                for match in _LOOP.finditer(plain):
                    self._loops.append((i, match[1].upper(), match[2]))
        return self._loops
