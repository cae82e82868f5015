"""Write the new program, block by block: only numbers that must change are replaced; blocks are added after the one they split.

Everything is decided in absolute machine coordinates and re-differenced from the actual position of the new program, so that
sections in increments (G91) do not drift.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.compensation.codes import Code, codes_after_motion
from vcmm.compensation.contours import length_of, sweep_of
from vcmm.compensation.fitting import WHOLE, BlockFit, BlockPiece
from vcmm.compensation.frame import AXES, CENTRES, BlockFrame, frame_of
from vcmm.compensation.header import SEMICOLON
from vcmm.compensation.numbers import HOLD, SAME_INCREMENT_SHARE, Diffusion, nearest
from vcmm.compensation.source import Edit
from vcmm.compensation.wording import Wording
from vcmm.core.run import Array
from vcmm.program.moves import PLANES
from vcmm.program.trace import Trace

CHAINED_BLOCK_MM = 5.0  # mm: chains of blocks up to this length carry their rounding along
TINY_ARC = 0.1  # mm: an arc shorter than this is shifted as a whole


@dataclass(frozen=True, eq=False)
class Stretch:
    """One piece of a move as it is written, from start to end (3,), numbers of the program; end: once it is settled.

    share: of the move. first: it is in the block itself, not in one added behind it. split: the move has more pieces.
    whole: it is a whole circle. feed: F of inverse time, None where F stays.
    """

    trace: Trace
    frame: BlockFrame
    piece: BlockPiece
    start: Array
    end: Array
    share: float
    first: bool
    split: bool
    whole: bool
    feed: float | None

    @property
    def index(self) -> int:
        """Index of the line of the source."""
        return self.trace.line - 1

    @property
    def plane(self) -> tuple[int, int, int]:
        """Both axes of the plane and its normal."""
        return PLANES[self.trace.contour.plane]

    def names(self, i: int) -> bool:
        """Return whether the block names an axis."""
        return self.first and AXES[i] in self.trace.words

    @property
    def standing(self) -> tuple[int, ...]:
        """Axes that must not move: those of the plane where a contour with radius compensation goes up or down in one place.

        A step of a micrometre would be an element of the contour, with corners of its own.
        """
        m = self.trace.contour
        still = m.kind != "arc" and all(m.start[i] == m.end[i] for i in self.plane[:2])
        return self.plane[:2] if still and self.trace.compensation is not None else ()

    def nominal(self, i: int, steps: bool) -> float:
        """Number with which the source says the end in an axis, absolute or in steps."""
        m = self.trace.contour
        end, start = self.frame.numbers(np.array(m.end)), self.frame.numbers(np.array(m.start))
        return float(end[i] - start[i] if steps else end[i])


@dataclass(eq=False)
class Writer(Wording):
    """Position of the new program, block by block."""

    def relative(self, trace: Trace, frame: BlockFrame, i: int, first: bool) -> bool:
        """Return whether a number counts from the present position of the tool. first: in the block itself, not in one added behind it."""
        return not frame.absolute

    def centre_absolute(self, trace: Trace, frame: BlockFrame, i: int) -> bool:
        return frame.arc_absolute

    # -- one block ------------------------------------------------------------------------------------------------
    def move(self, trace: Trace, fit: BlockFit) -> None:
        """Write a rapid, a line, an arc or a thread of its own."""
        frame, m = frame_of(trace), trace.contour
        index = trace.line - 1

        wanted = fit.pieces[-1].end
        if m.kind == "arc" and length_of(m) < TINY_ARC:
            fit = self._shift_arc(trace, frame)
        shares = [0.0, *(p.share for p in fit.pieces)]

        last_codes = (
            codes_after_motion(self.source.lines[index][0], self.dialect) if len(fit.pieces) > 1 else []
        )
        for k, piece in enumerate(fit.pieces):
            cur = frame.numbers(self.q - (self._standing(trace) if k == 0 else frame.offset))
            split = len(fit.pieces) > 1
            stretch = Stretch(
                trace=trace, frame=frame, piece=piece, start=cur, end=cur, share=shares[k + 1] - shares[k], first=k == 0,
                split=split, whole=m.kind == "arc" and not split and _is_whole(trace), feed=self._feed(trace, fit, k, shares),
            )  # fmt: skip
            stretch = replace(stretch, end=self._settle(stretch))
            if k == 0:
                self._first(stretch)
            else:
                self._more(stretch)
            self.q = frame.tip(stretch.end) + frame.offset
            if m.kind != "rapid":
                last = k == len(fit.pieces) - 1
                off = self.q - frame.offset - (wanted if last else piece.end)
                off[list(stretch.standing)] = 0.0  # left off, not rounded
                self.rounding.append(off)
        if last_codes and self.added_blocks.get(index):
            self._last(index, last_codes)

    def _last(self, index: int, codes: Sequence[Code]) -> None:
        """Move every code and corner that acts behind the motion to the last of the blocks."""
        line = self.source.lines[index][0]
        gap = " " if self.dialect.name in SEMICOLON else self.gap
        for code in codes:
            ahead = line[: code.first - 1].endswith(" ")
            trailing = not ahead and line[code.last - 1 : code.last] == " "
            self.edits.setdefault(index, []).append(Edit(code.first - ahead, code.last + trailing, ""))
            self.added_blocks[index][-1] += gap + code.text

    def _standing(self, trace: Trace) -> Array:
        """Return the tool offset from which a block counts: Fanuc's G43 with Z counts from the programmed point before it."""
        follows = self.dialect.length_follows and "Z" in trace.words
        return np.array(trace.before.tool_offset if follows else trace.contour.tool_offset)

    def _shift_arc(self, trace: Trace, frame: BlockFrame) -> BlockFit:
        """Return a tiny arc moved as a whole with its start, so that rounding cannot close or turn it."""
        m = trace.contour
        by = self.q - frame.offset - np.array(m.start)
        assert m.centre is not None
        return BlockFit((BlockPiece(1.0, np.array(m.end) + by, np.array(m.centre) + by),), 0.0)

    def _settle(self, s: Stretch) -> Array:
        """Return the numbers at which the block will end, rounded."""
        trace, frame, piece, cur = s.trace, s.frame, s.piece, s.start
        kind, step, part = trace.contour.kind, self.step(frame.inch), s.share * length_of(trace.contour)
        wanted, new = frame.numbers(piece.end), cur.copy()
        short = (
            self.carry
            and kind == "line"
            and part <= CHAINED_BLOCK_MM
            and not (self.chain_ends and piece.share == 1.0)
        )
        for i in range(3):
            diffusion = self.diffusions.setdefault((i, frame.inch), Diffusion(step))
            if (s.whole and i in s.plane[:2]) or i in s.standing:
                continue
            if not s.names(i) and self.absent(i):
                continue
            if short and s.names(i):
                target = diffusion.next(float(wanted[i]))
            else:
                diffusion.forget()
                target = nearest(float(wanted[i]), step)
                slack = self.rapid if kind == "rapid" else self.slack
                slack = math.inf if kind == "rapid" and i == self.above else slack
                near = max(HOLD * step, slack * float(frame.scale[1]))
                if not s.names(i) and abs(wanted[i] - cur[i]) <= near:
                    continue
            steps = self.relative(trace, frame, i, s.first)
            new[i] = cur[i] + nearest(target - float(cur[i]), step) if steps else target
        return new

    def _feed(self, trace: Trace, fit: BlockFit, k: int, shares: list[float]) -> float | None:
        """Return F of an inverse-time block (1/min) for its share of the block; None where F stays."""
        if trace.after.feed_mode != "G93" or trace.contour.kind == "rapid" or len(fit.pieces) == 1:
            return None
        length, feed = length_of(trace.contour), trace.contour.feed
        return None if not feed or not length else feed / (length * (shares[k + 1] - shares[k]))

    def _first(self, s: Stretch) -> None:
        """Write the block itself."""
        trace, frame, cur, new = s.trace, s.frame, s.start, s.end
        index, step = s.index, self.step(frame.inch)
        for i, letter in enumerate(AXES):
            steps = self.relative(trace, frame, i, True)
            value = float(new[i] - cur[i] if steps else new[i])
            old = s.nominal(i, steps)
            if (
                s.whole
                and letter in trace.words
                and abs(value - nearest(value, step)) > SAME_INCREMENT_SHARE * step
            ):
                self.drop(index, trace.words[letter])
            elif letter in trace.words or abs(new[i] - cur[i]) > SAME_INCREMENT_SHARE * step:
                self.word(index, trace, letter, value, old, frame.inch)
        if trace.contour.kind == "arc":
            self._centre(s)
        if s.feed is not None and "F" in trace.words:
            self.word(index, trace, "F", s.feed, math.inf, frame.inch)
        if s.split and "P" in trace.words and trace.contour.turns > 1:
            self.drop(index, trace.words["P"])

    def _more(self, s: Stretch) -> None:
        """Write a block behind the one it continues: axis words, centre, F of inverse time; nothing else."""
        trace, frame, cur, new = s.trace, s.frame, s.start, s.end
        step, m = self.step(frame.inch), trace.contour
        kept = s.plane[:2] if m.kind == "arc" else ()
        words = []
        for i, letter in enumerate(AXES):
            if abs(new[i] - cur[i]) > SAME_INCREMENT_SHARE * step or i in kept:
                value = float(new[i] - cur[i] if self.relative(trace, frame, i, False) else new[i])
                words.append(
                    self.spelt(
                        letter, self.number(value, self.decimals[frame.inch], self._number_style(trace))
                    )
                )
        if not words:
            return
        if m.kind == "arc":
            words += [
                self.spelt(letter, self.number(v, self.decimals[frame.inch], self._number_style(trace)))
                for letter, v in self._centre_words(s).items()
            ]
        if s.feed is not None:
            words.append("F" + self.number(s.feed, 4))
        self.insert(s.index, words)

    # -- arcs -------------------------------------------------------------------------------------------------------
    def _centre(self, s: Stretch) -> None:
        trace, frame = s.trace, s.frame
        nominal = self._nominal_centre(trace, frame)
        for letter, value in self._centre_words(s).items():
            present, step = letter in trace.words, self.step(frame.inch)
            if (
                present
                or abs(value) > SAME_INCREMENT_SHARE * step
                or self.centre_absolute(trace, frame, CENTRES.find(letter))
            ):
                old = math.inf if s.split else nominal[letter]
                self.word(s.index, trace, letter, value, old, frame.inch)

    def _nominal_centre(self, trace: Trace, frame: BlockFrame) -> dict[str, float]:
        m = trace.contour
        assert m.centre is not None
        start, centre = np.array(m.start), np.array(m.centre)
        points, ways = frame.numbers(centre), frame.ways(centre - start)
        coordinates = [points[i] if self.centre_absolute(trace, frame, i) else ways[i] for i in range(3)]
        radius = math.dist(*[[p[i] for i in PLANES[m.plane][:2]] for p in (m.start, m.centre)])
        out = {CENTRES[i]: float(coordinates[i]) for i in PLANES[m.plane][:2]}
        out["R"] = frame.length(radius, PLANES[m.plane][0]) * (-1.0 if abs(sweep_of(m)) > math.pi else 1.0)
        return out

    def _centre_words(self, s: Stretch) -> dict[str, float]:
        """Return I J K, or R where the block has R, of one arc."""
        trace, frame, piece, step = s.trace, s.frame, s.piece, self.step(s.frame.inch)
        a, b, _ = s.plane
        assert piece.centre is not None
        start, end = frame.tip(s.start), frame.tip(s.end)
        if "R" in trace.words:
            radius = (_gap(start, piece.centre, a, b) + _gap(end, piece.centre, a, b)) / 2
            value = nearest(frame.length(radius, a), step)
            half = float(np.linalg.norm(frame.ways(end - start)[[a, b]])) / 2
            value = value if value >= half else math.ceil(half / step) * step
            return {"R": -value if abs(sweep_of(trace.contour)) * s.share > math.pi else value}
        from_zero = np.array([self.centre_absolute(trace, frame, i) for i in range(3)])
        wanted = np.where(from_zero, frame.numbers(piece.centre), frame.ways(piece.centre - start))
        origin = np.where(from_zero, frame.numbers(start), 0.0)
        share = np.where(from_zero, frame.radii(), 1.0)[[a, b]]
        first, second = best_centre(
            wanted[[a, b]], origin[[a, b]], frame.ways(end - start)[[a, b]], step, share
        )
        return {CENTRES[a]: first, CENTRES[b]: second}


def _is_whole(trace: Trace) -> bool:
    sweep = abs(sweep_of(trace.contour))
    return sweep > math.pi and abs(math.remainder(sweep, 2 * math.pi)) < WHOLE


def _gap(p: Array, c: Array, a: int, b: int) -> float:
    return math.hypot(p[a] - c[a], p[b] - c[b])


def best_centre(
    wanted: Array, origin: Array, end: Array, step: float, share: Sequence[float] | Array = (1.0, 1.0)
) -> tuple[float, float]:
    """Return the rounded centre near the wanted one whose distances from both ends agree best; share: 0.5 where a number is a diameter."""
    best, least = (0.0, 0.0), math.inf
    for i in (-1, 0, 1):
        for j in (-1, 0, 1):
            c = (nearest(float(wanted[0]), step) + i * step, nearest(float(wanted[1]), step) + j * step)
            rel = ((c[0] - origin[0]) * share[0], (c[1] - origin[1]) * share[1])
            uneven = math.hypot(*rel) - math.hypot(rel[0] - end[0], rel[1] - end[1])
            cost = uneven**2 + (c[0] - wanted[0]) ** 2 + (c[1] - wanted[1]) ** 2
            if cost < least - 1e-18:
                best, least = c, cost
    return best
