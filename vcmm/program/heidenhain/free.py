"""Free contour programming of Klartext (FK): FPOL, FL, FLT, FC, FCT, FSELECT.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming and TNC 407 (280 580), "FK free contour programming":

    FL FC, FLT FCT   a line, an arc; T: tangential to the element before        X Y, PR PA   end point, its polar coordinates about FPOL
    AN, IAN          direction of a line, of an arc where it begins; IAN counts from the end of the element before
    LEN, CCA         length of a line, chord of an arc; see `FreeWords.turn`       CCX CCY, CCPR CCPA, R, DR   centre, radius, sense of an arc
    P1X P1Y ...      points on the line, its extension, or the arc              PDX PDY D    a point at the distance D from the element
    PAR N, DP        parallel to the line of block N, at this distance          CLSD+ CLSD-  where a closed contour begins and ends
    RX N, RY N, RPR N, RPA N, RAN N, RCCX N, RCCY N, RCCPR N, RCCPA N           the increments in the block count from block N

The blocks of a contour are read together when the first other block comes (RND and CHF may stand between them), and worked out by
vcmm.program.free_search. Which of several contours FSELECT n means is the order in which the control finds them, which no manual states.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from vcmm.program.faults import BlockFault
from vcmm.program.free_contour import MOST_CONTOURS, FreeContour, travel_angle
from vcmm.program.free_search import TooMany, Undetermined, contours
from vcmm.program.heidenhain.free_words import FreeBlock, FreeKnown, FreeWords, merge
from vcmm.program.heidenhain.paths import KlartextPaths
from vcmm.program.heidenhain.text import KlartextBlock, KlartextReader
from vcmm.program.heidenhain.words import read_words
from vcmm.program.moves import Point
from vcmm.program.offsetting import Vec
from vcmm.program.tangents import DirectedCircle, DirectedLine
from vcmm.program.trace import BlockPlace

ELEMENTS = ("FL", "FLT", "FC", "FCT")
FREE = (*ELEMENTS, "FPOL", "FSELECT")
BETWEEN = (*FREE, "RND", "CHF")  # do not end a contour
_ENDS = ("PR", "PA", "IPR", "IPA", "AN", "IAN", "LEN", "PDX", "PDY", "D", "RX", "RY", "RPR", "RPA", "RAN")
_LINE = (*_ENDS, "PAR", "DP", "P1X", "P1Y", "P2X", "P2Y")
_CENTRE = tuple(f"{i}{name}" for name in ("CCX", "CCY", "CCPR", "CCPA") for i in ("", "I", "R"))
_ARC = (*_ENDS, *_CENTRE, "R", "CCA", "P1X", "P1Y", "P2X", "P2Y", "P3X", "P3Y")
WORDS = {"FL": _LINE, "FLT": _LINE, "FC": _ARC, "FCT": _ARC, "FPOL": (), "FSELECT": ()}
WHAT = {
    False: "X, Y, PR, PA, AN, LEN, P1X P1Y, PDX PDY D or PAR DP",
    True: "X, Y, CCX, CCY, R, DR, LEN or P1X P1Y",
}


@dataclass(eq=False)
class FreeContours(FreeKnown):
    """The contour that is being read, and what makes its moves."""

    paths: KlartextPaths
    has_fselect: bool = False  # by FSELECT

    def read(self, reader: KlartextReader, number: int) -> None:
        """Read a block of FREE."""
        r, word = self.paths.r, reader.upper()
        if r.plane != "XY":
            r.fault("the free contour (FK) is understood in the plane XY; call the tool with Z as its axis")
        reader.at += 1
        closes = merge(reader)
        if word == "FSELECT":
            reader.value("FSELECT")
            self.has_fselect = True
            return
        words = read_words(reader, WORDS[word])
        if word == "FPOL":
            x, y = words.take("X"), words.take("Y")
            if x is None or y is None:
                r.fault("FPOL needs X and Y, as in FPOL X+20 Y+30")
            self.pole = (x * r.unit, y * r.unit)
            self.paths.leftover(words)
            return
        if "Z" in words.values or "IZ" in words.values:
            r.fault(f"{word} takes no Z; bring the tool to its depth before the contour")
        element = FreeWords(self, words).element(word, closes)
        self.waiting.append(FreeBlock(number, r.source, words, element, None))

    def goes_on(self, line: KlartextBlock) -> bool:
        """Return whether a block belongs to the contour that waits."""
        return not line.plain and line.tokens[0].text.upper() in BETWEEN

    def corner(self, reader: KlartextReader, kind: str) -> None:
        """Read a corner, RND, CHF: between the elements of a contour when their turn comes."""
        if self.waiting:
            later = KlartextReader(reader.tokens[reader.at :], reader.parameters, reader.unset)
            self.waiting.append(
                FreeBlock(-1, self.r.source, None, None, lambda: self.paths.corner(later, kind))
            )
            reader.at = len(reader.tokens)
        else:
            self.paths.corner(reader, kind)

    # -- all together --
    def flush(self) -> bool:
        """Evaluate the contour and make its moves. True where one of its M functions ends the program."""
        blocks, self.waiting = self.waiting, []
        selected, self.has_fselect = self.has_fselect, False
        rows = [b for b in blocks if b.element is not None]
        r, paths = self.paths.r, self.paths
        if not rows:
            return False
        kept = r.source
        made = self._contour(rows, selected)
        over, k = False, 0
        for block in blocks:
            r.source = block.source
            if block.corner is not None:
                try:
                    block.corner()
                except BlockFault as fault:
                    r.fault(fault.text, fault.column)
                continue
            assert block.words is not None
            if paths.technology(block.words):
                r.fault("a free contour is not run at FMAX; give it a feed")
            self._move(made, k)
            block.words.has_moved = True
            over = paths.after(block.words) or over
            self._remember(made, k, block.number)
            k += 1
        r.source = kept
        return over

    def _contour(self, rows: list[FreeBlock], selected: bool) -> FreeContour:
        """Return the contour that fits; the shortest, with a remark, where several do."""
        r = self.paths.r
        tangent = self.paths.tangent
        before = None if tangent is None else math.atan2(tangent[1], tangent[0])
        elements = [b.element for b in rows if b.element is not None]
        begin = (r.p[0], r.p[1])
        closed = [e.closes for e in elements if e.closes]
        if "-" in closed and closed != ["+", "-"]:
            r.fault("CLSD- ends a closed contour that no CLSD+ begins; add CLSD+ to its first element, once")
        try:
            candidates = contours(elements, begin, before)
        except Undetermined as left:
            self._tell_missing(rows, left.contour)
        except TooMany:
            r.source = rows[0].source
            r.fault(
                f"the FK blocks from line {r.source.line} on leave too many contours to try; add X and Y, or centres, to some of them"
            )
        first, last = rows[0].source.line, rows[-1].source.line
        r.source = rows[0].source
        if not candidates:
            r.fault(
                f"no contour fits what the FK blocks of lines {first} to {last} say, beginning at X{begin[0] / r.unit:g} Y{begin[1] / r.unit:g}; "
                "check their words, the side of DR, and where the contour begins"
            )
        best = min(candidates, key=lambda c: c.length())
        if len(candidates) > 1:
            self._tell_several(rows, candidates, best, selected)
        return best

    def _tell_missing(self, rows: list[FreeBlock], c: FreeContour) -> None:
        """Refuse a contour that is not determined, by the first element that is not."""
        r = self.paths.r
        for i, row in enumerate(rows):
            e = c.elements[i]
            r.source = row.source
            kind = "arc" if e.arc else "line"
            if c.carriers[i] is None:
                where = "its centre or radius" if e.arc else "its direction or place"
                if e.tangential and not i and c.before is None:
                    r.fault(
                        f"this {kind} is tangential to nothing; begin with FL or FC, or program L before it"
                    )
                r.fault(
                    f"the free contour does not determine this {kind}: {where} is open; add {WHAT[e.arc]}, here or in the blocks beside it"
                )
            if c.joints[i + 1] is None:
                full = "; X and Y of its start make a full circle" if e.arc else ""
                r.fault(
                    f"the free contour does not say where this {kind} ends; add X or Y, LEN, or an element after it{full}"
                )

    def _tell_several(
        self, rows: list[FreeBlock], candidates: list[FreeContour], best: FreeContour, selected: bool
    ) -> None:
        """Note several contours that fit, with their differences."""
        r = self.paths.r
        at = next(k for k in range(len(rows)) if any(_apart(c, best, k) for c in candidates))
        r.source = rows[at].source
        ends = [_marks(c, at)[0] for c in candidates]
        by_end = any(math.dist(p, ends[0]) > 1e-6 for p in ends if p is not None and ends[0] is not None)
        many = f"{len(candidates)} or more" if len(candidates) >= MOST_CONTOURS else str(len(candidates))
        places = sorted({_end_text(c, at, r.unit, by_end) for c in candidates})
        chosen = "; FSELECT counts them in an order of the control that no manual states" if selected else ""
        some = ", ".join(places[:6]) + (" ..." if len(places) > 6 else "")
        r.assume(
            f"which of {many} contours the FK blocks of lines {rows[0].source.line} to {rows[-1].source.line} mean{chosen}",
            f"the shortest one, with {_end_text(best, at, r.unit, by_end)} there; possible are {some}",
            f"{many} free contours fit (FK){chosen}: this element may have {some}; add one of them to its block",
        )  # fmt: skip

    def _move(self, made: FreeContour, k: int) -> None:
        """Make the move of element k."""
        paths, r = self.paths, self.paths.r
        carrier, start, end = made.carriers[k], made.joints[k], made.joints[k + 1]
        assert start is not None
        assert end is not None
        goal: Point = (end[0], end[1], r.p[2])
        count, r.marker = len(r.moves), "FK"
        if isinstance(carrier, DirectedCircle):
            turns = 1 if travel_angle(carrier, start, end, made.elements[k].is_full) else 0
            paths.round(goal, (*carrier.centre, r.p[2]), carrier.rho < 0, turns)
        else:
            paths.line(goal, False)
        r.marker = ""
        if r.tracer is not None:
            r.tracer.note(r, count, r.modal(), {}, BlockPlace(r.file, r.source.line, 0))

    def _remember(self, made: FreeContour, k: int, number: int) -> None:
        carrier, end = made.carriers[k], made.joints[k + 1]
        assert end is not None
        self.ends[number] = (end, carrier if isinstance(carrier, DirectedLine) else None)


def _marks(c: FreeContour, k: int) -> tuple[Vec | None, Vec | None]:
    """End of element k, and its centre where it is an arc."""
    carrier = c.carriers[k]
    return c.joints[k + 1], carrier.centre if isinstance(carrier, DirectedCircle) else None


def _apart(a: FreeContour, b: FreeContour, k: int) -> bool:
    """Return whether element k ends elsewhere, or has another centre."""
    pairs = zip(_marks(a, k), _marks(b, k))
    return any(p is not None and q is not None and math.dist(p, q) > 1e-6 for p, q in pairs)


def _end_text(c: FreeContour, k: int, unit: float, by_end: bool) -> str:
    """End of element k as a block says it, or its centre where all end at one point."""
    end, centre = _marks(c, k)
    p, name = (end, "") if by_end or centre is None else (centre, "CC")
    assert p is not None
    return f"{name}X{round(p[0] / unit, 3) + 0.0:g} {name}Y{round(p[1] / unit, 3) + 0.0:g}"
