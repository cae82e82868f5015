"""The new program, block by block: only the numbers that must change change; blocks are added after the one they split.

Everything is decided in absolute machine coordinates and re-differenced from where the new program really stands, so that
sections in increments (G91) do not drift.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from vcmm.compensating.contours import length_of, sweep_of
from vcmm.compensating.fitting import WHOLE, Fit, Piece
from vcmm.compensating.numbers import HOLD, SAME, Diffusion, nearest, value_of, written
from vcmm.compensating.source import Edit, SourceText, code_of, edited, separator
from vcmm.nc.dialects import Dialect
from vcmm.nc.moves import PLANES
from vcmm.nc.trace import Trace, WordAt
from vcmm.run import Array

AXES, CENTRES = "XYZ", "IJK"
SHORT = 5.0  # mm: chains of blocks up to this length carry their rounding along
_STOP = re.compile(r"M[ \t]*0*(?:0|1|2|30|60)(?![\d.])", re.IGNORECASE)
TINY_ARC = 0.1  # mm: an arc shorter than this is shifted as a whole


@dataclass(frozen=True, eq=False)
class Frame:
    """Machine point of the tip <-> numbers of the program (its unit; diameters where X is one)."""

    matrix: Array
    shift: Array
    scale: Array
    offset: Array
    absolute: bool
    inch: bool
    arc_absolute: bool

    def numbers(self, tip: Array) -> Array:
        return np.asarray((tip - self.shift) @ self.matrix * self.scale)

    def ways(self, way: Array) -> Array:
        """A vector instead of a point; never a diameter."""
        return np.asarray(way @ self.matrix * abs(self.scale[1]))

    def tip(self, numbers: Array) -> Array:
        return np.asarray(self.matrix @ (numbers / self.scale) + self.shift)


def frame_of(trace: Trace) -> Frame:
    t, m = trace.transformation, trace.after
    scale = np.full(3, 1.0 / m.unit)
    if m.diameter:
        scale[0] *= 2.0
    return Frame(
        np.array(t.matrix), np.array(t.shift), scale, np.array(trace.contour.tool_offset), m.absolute,
        m.unit > 1.0, m.arc_absolute,
    )  # fmt: skip


@dataclass(eq=False)
class Writer:
    """Where the new program stands (q: axes), and what has been decided so far, by index of the line."""

    source: SourceText
    dialect: Dialect
    decimals: tuple[int, int]  # metric, inch
    q: Array
    axes: str = AXES
    carry: bool = True  # rounding errors are carried along chains of short blocks
    chain_ends: bool = True  # the block after this one belongs to no chain of short blocks
    slack: float = 0.0  # mm by which a feed may leave such an axis off
    rapid: float = math.inf  # mm by which a rapid may leave an axis off that it does not name
    edits: dict[int, list[Edit]] = field(default_factory=dict)
    added: dict[int, list[str]] = field(default_factory=dict)
    carried: dict[tuple[int, bool], Diffusion] = field(default_factory=dict)
    rounding: list[Array] = field(default_factory=list)  # written - wanted at the ends of feeds, mm
    cycle: dict[str, float] = field(default_factory=dict)  # of a series of holes, see holes.py
    expressions: set[int] = field(default_factory=set)  # lines in which an expression became a number

    def __post_init__(self) -> None:
        self.gap = separator(self.source)

    def absent(self, i: int) -> bool:
        """Axes that the machine has not, and Y of a lathe, are never added to a block."""
        return AXES[i] not in self.axes or (self.dialect.lathe and i == 1)

    def step(self, inch: bool) -> float:
        return float(10.0 ** -self.decimals[inch])

    # -- one block ------------------------------------------------------------------------------------------------
    def move(self, trace: Trace, fit: Fit) -> None:
        """A rapid, a line, an arc or a thread of its own."""
        frame, m = frame_of(trace), trace.contour
        index = trace.line - 1
        nominal = frame.numbers(np.array(m.end)), frame.numbers(np.array(m.start))
        wanted = fit.pieces[-1].end
        if m.kind == "arc" and length_of(m) < TINY_ARC:
            fit = self._shifted(trace, frame)
        shares = [0.0, *(p.share for p in fit.pieces)]
        stop = self._stop(index) if len(fit.pieces) > 1 else None
        for k, piece in enumerate(fit.pieces):
            cur = frame.numbers(self.q - (self._standing(trace) if k == 0 else frame.offset))
            named = tuple(a in trace.words for a in AXES) if k == 0 else (False,) * 3
            whole = m.kind == "arc" and len(fit.pieces) == 1 and _is_whole(trace)
            part = (shares[k + 1] - shares[k]) * length_of(m)
            new = self._settled(trace, frame, piece, cur, named, part, whole)
            feed = self._feed(trace, fit, k, shares)
            if k == 0:
                self._first(trace, frame, piece, cur, new, nominal, feed, whole, len(fit.pieces) > 1)
            else:
                self._more(trace, frame, piece, cur, new, feed, shares[k + 1] - shares[k], index)
            self.q = frame.tip(new) + frame.offset
            if m.kind != "rapid":
                last = k == len(fit.pieces) - 1
                self.rounding.append(self.q - frame.offset - (wanted if last else piece.end))
        if stop is not None and self.added.get(index):
            self._last(index, stop)

    def _stop(self, index: int) -> re.Match[str] | None:
        """A code of the line that acts behind its motion (M0, M1, M2, M30, M60)."""
        return _STOP.search(code_of(self.source.lines[index][0]))

    def _last(self, index: int, stop: re.Match[str]) -> None:
        """Such a code moves to the last of the blocks."""
        line = self.source.lines[index][0]
        first = stop.start() + 1 - (1 if line[: stop.start()].endswith(" ") else 0)
        self.edits.setdefault(index, []).append(Edit(first, stop.end() + 1, ""))
        self.added[index][-1] += self.gap + stop[0]

    def _standing(self, trace: Trace) -> Array:
        """Tool offset from which a block counts: Fanuc's G43 with Z counts from the programmed point before it."""
        follows = self.dialect.length_follows and "Z" in trace.words
        return np.array(trace.before.tool_offset if follows else trace.contour.tool_offset)

    def _shifted(self, trace: Trace, frame: Frame) -> Fit:
        """A tiny arc moves as a whole with its start, so that rounding cannot close or turn it."""
        m = trace.contour
        by = self.q - frame.offset - np.array(m.start)
        assert m.centre is not None
        return Fit((Piece(1.0, np.array(m.end) + by, np.array(m.centre) + by),), 0.0)

    def _settled(
        self, trace: Trace, frame: Frame, piece: Piece, cur: Array, named: tuple[bool, ...], part: float, whole: bool
    ) -> Array:  # fmt: skip
        """Numbers at which the block will end, rounded."""
        kind, step = trace.contour.kind, self.step(frame.inch)
        wanted, new = frame.numbers(piece.end), cur.copy()
        short = (
            self.carry and kind == "line" and part <= SHORT and not (self.chain_ends and piece.share == 1.0)
        )
        a, b, _ = PLANES[trace.contour.plane]
        for i in range(3):
            diffusion = self.carried.setdefault((i, frame.inch), Diffusion(step))
            if whole and i in (a, b):
                continue
            if not named[i] and self.absent(i):
                continue
            if short and named[i]:
                target = diffusion.next(float(wanted[i]))
            else:
                diffusion.forget()
                target = nearest(float(wanted[i]), step)
                slack = self.rapid if kind == "rapid" else self.slack
                near = max(HOLD * step, slack * float(frame.scale[1]))
                if not named[i] and abs(wanted[i] - cur[i]) <= near:
                    continue
            new[i] = target if frame.absolute else cur[i] + nearest(target - float(cur[i]), step)
        return new

    def _feed(self, trace: Trace, fit: Fit, k: int, shares: list[float]) -> float | None:
        """F of an inverse-time block (1/min) for its share of the block; None where F stays."""
        if trace.after.feed_mode != "G93" or trace.contour.kind == "rapid" or len(fit.pieces) == 1:
            return None
        length, feed = length_of(trace.contour), trace.contour.feed
        return None if not feed or not length else feed / (length * (shares[k + 1] - shares[k]))

    def _first(
        self, trace: Trace, frame: Frame, piece: Piece, cur: Array, new: Array, nominal: tuple[Array, Array],
        feed: float | None, whole: bool, split: bool,
    ) -> None:  # fmt: skip
        index, step = trace.line - 1, self.step(frame.inch)
        end, start = nominal
        for i, letter in enumerate(AXES):
            value = float(new[i] if frame.absolute else new[i] - cur[i])
            old = float(end[i] if frame.absolute else end[i] - start[i])
            if whole and letter in trace.words and abs(value - nearest(value, step)) > SAME * step:
                self._drop(index, trace.words[letter])
            elif letter in trace.words or abs(new[i] - cur[i]) > SAME * step:
                self.word(index, trace, letter, value, old, frame.inch)
        if trace.contour.kind == "arc":
            self._centre(trace, frame, piece, cur, new, index, split)
        if feed is not None and "F" in trace.words:
            self.word(index, trace, "F", feed, math.inf, frame.inch)
        if split and "P" in trace.words and trace.contour.turns > 1:
            self._drop(index, trace.words["P"])

    def _more(
        self, trace: Trace, frame: Frame, piece: Piece, cur: Array, new: Array, feed: float | None, share: float, index: int
    ) -> None:  # fmt: skip
        """A block behind the one it continues: axis words, centre, F of inverse time; nothing else."""
        step, m = self.step(frame.inch), trace.contour
        kept = PLANES[m.plane][:2] if m.kind == "arc" else ()
        words = []
        for i, letter in enumerate(AXES):
            if abs(new[i] - cur[i]) > SAME * step or i in kept:
                value = float(new[i] if frame.absolute else new[i] - cur[i])
                words.append(letter + written(value, self.decimals[frame.inch], self._like(trace)))
        if not words:
            return
        if m.kind == "arc":
            words += [
                letter + written(v, self.decimals[frame.inch], self._like(trace))
                for letter, v in self._centre_words(trace, frame, piece, cur, new, share).items()
            ]
        if feed is not None:
            words.append("F" + written(feed, 4))
        self.insert(index, words)

    # -- arcs -------------------------------------------------------------------------------------------------------
    def _centre(
        self, trace: Trace, frame: Frame, piece: Piece, cur: Array, new: Array, index: int, split: bool
    ) -> None:
        m = trace.contour
        assert m.centre is not None
        share = piece.share
        nominal = self._nominal_centre(trace, frame)
        for letter, value in self._centre_words(trace, frame, piece, cur, new, share).items():
            present, step = letter in trace.words, self.step(frame.inch)
            if present or abs(value) > SAME * step or frame.arc_absolute:
                self.word(index, trace, letter, value, math.inf if split else nominal[letter], frame.inch)

    def _nominal_centre(self, trace: Trace, frame: Frame) -> dict[str, float]:
        m = trace.contour
        assert m.centre is not None
        start, centre = np.array(m.start), np.array(m.centre)
        found = frame.numbers(centre) if frame.arc_absolute else frame.ways(centre - start)
        radius = math.dist(*[[p[i] for i in PLANES[m.plane][:2]] for p in (m.start, m.centre)])
        out = {CENTRES[i]: float(found[i]) for i in PLANES[m.plane][:2]}
        out["R"] = radius * abs(float(frame.scale[1])) * (-1.0 if abs(sweep_of(m)) > math.pi else 1.0)
        return out

    def _centre_words(
        self, trace: Trace, frame: Frame, piece: Piece, cur: Array, new: Array, share: float
    ) -> dict[str, float]:
        """I J K, or R where the block has R, of one arc from `cur` to `new`."""
        m, step = trace.contour, self.step(frame.inch)
        a, b, _ = PLANES[m.plane]
        assert piece.centre is not None
        start, end = frame.tip(cur), frame.tip(new)
        if "R" in trace.words:
            radius = frame.ways(
                np.array([0.0, (_gap(start, piece.centre, a, b) + _gap(end, piece.centre, a, b)) / 2, 0.0])
            )
            value = nearest(float(np.linalg.norm(radius)), step)
            half = float(np.linalg.norm(frame.ways(end - start)[[a, b]])) / 2
            value = value if value >= half else math.ceil(half / step) * step
            return {"R": -value if abs(sweep_of(m)) * share > math.pi else value}
        wanted = frame.numbers(piece.centre) if frame.arc_absolute else frame.ways(piece.centre - start)
        ends = (np.zeros(3), frame.ways(end - start))
        origin = frame.numbers(start) if frame.arc_absolute else np.zeros(3)
        one, two = _best_centre(wanted[[a, b]], origin[[a, b]], ends[1][[a, b]], step)
        return {CENTRES[a]: one, CENTRES[b]: two}

    # -- words ------------------------------------------------------------------------------------------------------
    def word(self, index: int, trace: Trace, letter: str, value: float, old: float, inch: bool) -> None:
        """Give a word of the block its new value, or add it. old: what it says now, where it is an expression."""
        word = trace.words.get(letter)
        step, decimals = self.step(inch), self.decimals[inch]
        if word is None:
            self._add(index, trace, letter, written(value, decimals, self._like(trace)))
            return
        pointless = word.decimals is None and self.dialect.decimal_point == "increment" and letter != "F"
        if word.plain:
            says = value_of(word) * (self.dialect.increment[inch] if pointless and value_of(word) else 1.0)
            if abs(value - says) < SAME * step:
                return
        elif abs(value - old) < 0.5 * step:
            return
        else:
            self.expressions.add(index)
        whole = pointless and math.isclose(self.dialect.increment[inch], step)
        line = self.source.lines[index][0]
        begin = word.first  # the letter and the blanks after it stay
        while line[begin : begin + 1] in (" ", "\t"):
            begin += 1
        text = written(value, 4 if letter == "F" else decimals, word.text, whole)
        self.edits.setdefault(index, []).append(Edit(begin + 1, word.last, text))

    def _drop(self, index: int, word: WordAt) -> None:
        line = self.source.lines[index][0]
        blank = line[word.last - 1 : word.last] == " "
        first = word.first - (1 if not blank and line[: word.first - 1].endswith(" ") else 0)
        self.edits.setdefault(index, []).append(Edit(first, word.last + blank, ""))

    drop = _drop

    def _add(self, index: int, trace: Trace, letter: str, number: str) -> None:
        """A word that the block has not: behind those that come before it in X Y Z I J K R, else before the first."""
        line, order = self.source.lines[index][0], AXES + CENTRES + "R"
        gap, letter = self.gap, letter.lower() if _lower(line) else letter
        before = [
            w for k, w in trace.words.items() if k in order and order.index(k) < order.index(letter.upper())
        ]
        behind = [
            w for k, w in trace.words.items() if k in order and order.index(k) > order.index(letter.upper())
        ]
        if before:
            at = max(w.last for w in before)
            edit = Edit(at, at, f"{gap}{letter}{number}")
        elif behind:
            at = min(w.first for w in behind)
            edit = Edit(at, at, f"{letter}{number}{gap}")
        else:
            at = len(code_of(line).rstrip()) + 1
            edit = Edit(at, at, f"{gap}{letter}{number}")
        self.edits.setdefault(index, []).append(edit)

    def insert(self, index: int, words: Sequence[str]) -> None:
        line = self.source.lines[index][0]
        slash = line.lstrip()[:1] == "/"
        digits = line.lstrip()[1:2] if slash and line.lstrip()[1:2].isdigit() else ""
        body = self.gap.join(words)
        body = body.lower() if _lower(line) else body
        self.added.setdefault(index, []).append((f"/{digits} " if slash else "") + body)

    def _like(self, trace: Trace) -> str:
        """A number of the block whose style a new one takes: only the missing zero before the point, never the plus sign."""
        return next((w.text.lstrip("+- ") for k, w in trace.words.items() if k in AXES and w.plain), "")

    # -- the text ---------------------------------------------------------------------------------------------------
    def lines(self) -> list[tuple[str, int]]:
        """New lines with their ends, and the index of the source line each belongs to."""
        out = []
        for index, (body, end) in enumerate(self.source.lines):
            added = self.added.get(index, [])
            own = end or (self.source.end if added else "")
            out.append((edited(body, self.edits.get(index, [])) + own, index))
            for k, text in enumerate(added):
                last = k == len(added) - 1
                out.append((text + (end if last else own), index))
        return out


def _lower(line: str) -> bool:
    """Whether the words of a line are written in small letters."""
    code = code_of(line)
    return code != code.upper() and code == code.lower()


def _is_whole(trace: Trace) -> bool:
    sweep = abs(sweep_of(trace.contour))
    return sweep > math.pi and abs(math.remainder(sweep, 2 * math.pi)) < WHOLE


def _gap(p: Array, c: Array, a: int, b: int) -> float:
    return math.hypot(p[a] - c[a], p[b] - c[b])


def _best_centre(wanted: Array, origin: Array, end: Array, step: float) -> tuple[float, float]:
    """The rounded centre near the wanted one whose distances from both ends agree best."""
    best, least = (0.0, 0.0), math.inf
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            c = (nearest(float(wanted[0]), step) + i * step, nearest(float(wanted[1]), step) + j * step)
            rel = (c[0] - origin[0], c[1] - origin[1])
            uneven = math.hypot(*rel) - math.hypot(rel[0] - end[0], rel[1] - end[1])
            cost = uneven**2 + (c[0] - wanted[0]) ** 2 + (c[1] - wanted[1]) ** 2
            if cost < least - 1e-18:
                best, least = c, cost
    return best
