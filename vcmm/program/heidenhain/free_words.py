"""Words of the blocks of a free contour, in mm and rad, with their origin. Source: see vcmm.program.heidenhain.free."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, NoReturn

from vcmm.program.free_contour import Coordinate, FreeElement, Reference
from vcmm.program.heidenhain.text import KlartextReader
from vcmm.program.heidenhain.words import KlartextWords
from vcmm.program.moves import Source
from vcmm.program.offsetting import Vec
from vcmm.program.recorder import Recorder
from vcmm.program.tangents import DirectedLine
from vcmm.program.tokens import Token


class FreeBlock(NamedTuple):
    """A block that waits: of an element with what it says, or of a corner, which is read when its turn comes."""

    number: int
    source: Source
    words: KlartextWords | None
    element: FreeElement | None
    corner: Callable[[], None] | None


@dataclass(eq=False)
class FreeKnown:
    """Blocks that wait. ends: of elements of contours before, by block number: their end, and the line that they are of."""

    r: Recorder
    waiting: list[FreeBlock] = field(default_factory=list, kw_only=True)
    ends: dict[int, tuple[Vec, DirectedLine | None]] = field(default_factory=dict, kw_only=True)
    pole: Vec | None = field(default=None, kw_only=True)

    @property
    def elements(self) -> list[FreeElement]:
        return [b.element for b in self.waiting if b.element is not None]

    def about(self) -> Vec:
        """Return the pole."""
        if self.pole is None:
            self.r.fault("polar coordinates of a free contour need FPOL before it; add FPOL X.. Y..")
        return self.pole

    def index(self, number: int) -> int | None:
        """Return the element of the contour of block N; None where it is none of this one."""
        elements = [b for b in self.waiting if b.element is not None]
        return next((i for i, b in enumerate(elements) if b.number == number), None)


def merge(reader: KlartextReader) -> str:
    """Return the text with joined addresses: P 1 X becomes P1X; CLSD+ is taken out, its sign returned."""
    tokens: list[Token] = []
    closes, k = "", 0
    row = list(reader.tokens)
    while k < len(row):
        name = row[k].text.upper()
        then = row[k + 1].text if k + 1 < len(row) else ""
        behind = row[k + 2].text.upper() if k + 2 < len(row) else ""
        if name == "CLSD":
            if then not in ("+", "-"):
                raise reader.fault("CLSD takes + where a closed contour begins and - where it ends")
            closes, k = then, k + 2
        elif name == "P" and then in ("1", "2", "3") and behind in ("X", "Y"):
            tokens.append(row[k]._replace(text=f"P{then}{behind}"))
            k += 3
        else:
            tokens.append(row[k])
            k += 1
    reader.tokens = tuple(tokens)
    return closes


@dataclass
class FreeWords:
    """Takes the words of a block in mm and rad, with what they count from."""

    free: FreeKnown
    words: KlartextWords

    def element(self, word: str, closes: str) -> FreeElement:
        """Return the element of a block."""
        x, y = self.place("X", "RX", 0), self.place("Y", "RY", 1)
        pr, pa = self.polar("PR", "RPR"), self.polar("PA", "RPA")
        angle, after = self.direction()
        arc = word in ("FC", "FCT")
        cx = cy = cpr = cpa = line = None
        if arc:
            cx, cy = self.place("CCX", "RCCX", 0), self.place("CCY", "RCCY", 1)
            cpr, cpa = self.polar("CCPR", "RCCPR"), self.polar("CCPA", "RCCPA")
        else:
            line = self.parallel()
        is_polar = any(c is not None for c in (pr, pa, cpr, cpa))
        return FreeElement(
            arc, tangential=word in ("FLT", "FCT"), clockwise=self.words.clockwise if arc else None, x=x, y=y,
            pole=self.free.about() if is_polar else (0.0, 0.0), pr=pr, pa=pa, angle=angle, angle_from=after, length=self.mm("LEN"),
            turn=self.turn(), radius=self.mm("R"), cx=cx, cy=cy, cpr=cpr, cpa=cpa, through=self.points(), beside=self.beside(),
            parallel=line, apart=self.mm("DP") if line is not None else None, closes=closes,
        )  # fmt: skip

    @property
    def unit(self) -> float:
        return self.free.r.unit

    def fault(self, text: str) -> NoReturn:
        self.free.r.fault(text)

    def mm(self, name: str) -> float | None:
        value = self.words.take(name)
        return None if value is None else value * self.unit

    def rad(self, name: str) -> float | None:
        value = self.words.take(name)
        return None if value is None else math.radians(value)

    def turn(self) -> float | None:
        """Return the turn CCA, for which the manuals have two definitions."""
        value = self.rad("CCA")
        if value is not None:
            self.free.r.assume(
                "CCA of a free contour", "the centre angle of the arc (TNC 407: the direction of its end from its centre)",
                "CCA is the centre angle of an arc on later controls, and the direction of its end from its centre in the manual of the TNC 407; "
                "give its end by X, Y, LEN or AN of the next element",
            )  # fmt: skip
            if not 1e-9 < abs(value) < 2.0 * math.pi + 1e-9:
                self.fault(
                    "CCA as a centre angle lies above 0 and up to 360 deg; give the end of the arc by X, Y or LEN"
                )
        return None if value is None else abs(value)

    def block(self, name: str) -> int | None:
        """Return the block number in a word of reference."""
        value = self.words.take(name)
        return None if value is None else round(value)

    def place(self, name: str, reference: str, axis: int) -> Coordinate | None:
        """Return X, IX (from the start of the element, or from the end of block N); for a centre CCX and ICCX."""
        value, more, block = self.mm(name), self.mm(f"I{name}"), self.block(reference)
        free = self.free
        if more is None:
            if block is not None:
                self.fault(f"{reference} needs the increment I{name} beside it")
            return None if value is None else Coordinate(value)
        if value is not None:
            self.fault(f"{name} and I{name} stand in one block; remove one")
        if block is None:
            return Coordinate(more, len(free.elements))
        return self.from_block(more, block, reference, lambda end: end[axis])

    def polar(self, name: str, reference: str) -> Coordinate | None:
        """Return PR, IPR; PA, IPA."""
        angular = name.endswith("A")
        take = self.rad if angular else self.mm
        value, more, block = take(name), take(f"I{name}"), self.block(reference)
        if more is None:
            if block is not None and value is not None and angular:  # PA+0 RPA 13 as increments of 0 deg
                more = value
            elif block is not None:
                self.fault(f"{reference} needs the increment I{name} beside it")
            else:
                return None if value is None else Coordinate(value)
        if block is None:
            return Coordinate(more, len(self.free.elements))
        pole = self.free.about()

        def count(end: Vec) -> float:
            a, b = end[0] - pole[0], end[1] - pole[1]
            return math.atan2(b, a) if angular else math.hypot(a, b)

        return self.from_block(more, block, reference, count)

    def from_block(
        self, more: float, block: int, reference: str, count: Callable[[Vec], float]
    ) -> Coordinate:
        """Return an increment from the end of block N, of this contour or one before."""
        index = self.free.index(block)
        if index is not None:
            return Coordinate(more, index + 1)
        if block not in self.free.ends:
            self.fault(
                f"{reference} {block} names no block of a free contour before this one; correct the number of the block"
            )
        return Coordinate(more + count(self.free.ends[block][0]))

    def direction(self) -> tuple[float | None, Reference | None]:
        """Return the direction of AN; IAN from the element before; IAN with RAN N from the line of block N."""
        value, more, block = self.rad("AN"), self.rad("IAN"), self.block("RAN")
        here = len(self.free.elements)
        if block is None:
            return (value, None) if more is None else (more, Reference(here - 1, True))
        angle = more if more is not None else value
        if angle is None:
            self.fault("RAN needs the angle IAN beside it")
        line = self.line_of(block, "RAN")
        if isinstance(line, DirectedLine):
            return (angle or 0.0) + line.angle, None
        return angle, line

    def line_of(self, block: int, reference: str) -> Reference | DirectedLine:
        """Return the line of block N."""
        index = self.free.index(block)
        elements = self.free.elements
        if index is not None:
            if elements[index].arc:
                self.fault(
                    f"{reference} {block} names an arc; a line is understood there, write the angle AN instead"
                )
            return Reference(index)
        line = self.free.ends.get(block, ((0.0, 0.0), None))[1]
        if line is None:
            self.fault(
                f"{reference} {block} names no line of a free contour before this one; correct the number of the block"
            )
        return line

    def parallel(self) -> Reference | DirectedLine | None:
        block = self.block("PAR")
        if block is None and self.words.has("DP"):
            self.fault("DP is the distance from a parallel line; add PAR and the number of its block")
        return None if block is None else self.line_of(block, "PAR")

    def points(self) -> tuple[Vec, ...]:
        """Return the points P1X P1Y to P3X P3Y."""
        out: list[Vec] = []
        for n in (1, 2, 3):
            x, y = self.mm(f"P{n}X"), self.mm(f"P{n}Y")
            if (x is None) != (y is None):
                self.fault(f"P{n}X and P{n}Y belong together; add the other")
            if x is not None and y is not None:
                out.append((x, y))
        return tuple(out)

    def beside(self) -> tuple[Vec, float] | None:
        """Return PDX PDY D."""
        x, y, d = self.mm("PDX"), self.mm("PDY"), self.mm("D")
        if (x, y, d) == (None, None, None):
            return None
        if x is None or y is None or d is None:
            self.fault("PDX, PDY and D belong together; add what is missing")
        return (x, y), abs(d)
