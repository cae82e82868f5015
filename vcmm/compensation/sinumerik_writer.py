"""Write Sinumerik: X=IC(5), I=AC(0), CR=, AR=, CIP with I1= J1=, TURN=, RND= at the last of the blocks of a split."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.compensation.contours import nearest_share, points
from vcmm.compensation.fitting import BlockFit, BlockPiece
from vcmm.compensation.frame import AXES, CENTRES, BlockFrame, frame_of
from vcmm.compensation.numbers import nearest, value_of
from vcmm.compensation.source import semicolon_code
from vcmm.compensation.writer import Stretch, Writer
from vcmm.core.run import Array
from vcmm.program.moves import PLANES, Move
from vcmm.program.trace import Trace

VIA = ("I1", "J1", "K1")
NO_MOTION_MM = 1e-6  # mm


@dataclass(eq=False)
class SinumerikWriter(Writer):
    """Writes Sinumerik blocks."""

    def code(self, index: int) -> str:
        return semicolon_code(self.source.lines[index][0])

    def order(self) -> Sequence[str]:
        return (*AXES, *VIA, *CENTRES, "R")

    def spelt(self, letter: str, number: str) -> str:
        if letter == "R":
            return f"CR={number}"
        if letter in VIA:
            return f"{letter}={number}"
        return f"{letter}=AC({number})" if letter in self.from_zero else letter + number

    from_zero: frozenset[str] = frozenset()  # centres of the block that are written as AC()

    def relative(self, trace: Trace, frame: BlockFrame, i: int, first: bool) -> bool:
        word = trace.words.get(AXES[i]) if first else None
        if word is not None and word.mode:
            return word.mode == "IC"
        return not frame.absolute

    def centre_absolute(self, trace: Trace, frame: BlockFrame, i: int) -> bool:
        word = trace.words.get(CENTRES[i])
        return word is not None and word.mode == "AC"

    def move(self, trace: Trace, fit: BlockFit) -> None:
        self.from_zero = frozenset(c for i, c in enumerate(CENTRES) if _from_zero(trace, c))
        if "AR" in trace.words:
            trace, changed = self._drop_opening(trace, fit)
            if not changed:
                frame = frame_of(trace)
                self.q = np.array(trace.contour.end) + frame.offset
                return
        if trace.contour.turns > 1 and len(fit.pieces) > 1 and "TURN" in trace.words:
            self.drop(trace.line - 1, trace.words["TURN"])
        super().move(trace, fit)

    def _settle(self, s: Stretch) -> Array:
        """Return the numbers at which a block ends; CIP keeps its height: with another one it would be a circle in space."""
        new = super()._settle(s)
        if s.trace.after.motion == "CIP":
            new[s.plane[2]] = s.start[s.plane[2]]
        return new

    def _drop_opening(self, trace: Trace, fit: BlockFit) -> tuple[Trace, bool]:
        """Remove AR= where the arc must change: the end point and the centre determine the arc."""
        m = trace.contour
        frame = frame_of(trace)
        begin = np.abs(self.q - frame.offset - np.array(m.start)).max()
        if len(fit.pieces) == 1 and begin < NO_MOTION_MM and _same(m, fit.pieces[0]):
            return trace, False
        self.drop(trace.line - 1, trace.words["AR"])
        a, b, _ = PLANES[m.plane]
        for i in (a, b):
            for letter, nominal in ((AXES[i], m.end), (CENTRES[i], m.centre)):
                assert nominal is not None
                if letter not in trace.words and letter in AXES:
                    self.forced_axes = (*self.forced_axes, letter)
        return trace, True

    forced_axes: tuple[str, ...] = ()  # axes that the block must name

    def _first(self, s: Stretch) -> None:
        trace, frame, step = s.trace, s.frame, self.step(s.frame.inch)
        for letter in self.forced_axes:
            i = AXES.index(letter)
            if abs(s.end[i] - s.start[i]) <= 1e-3 * step:  # otherwise it is added as for any block
                value = 0.0 if self.relative(trace, frame, i, True) else float(s.end[i])
                self.word(s.index, trace, letter, value, math.inf, frame.inch)
        self.forced_axes = ()
        super()._first(s)

    def _centre_words(self, s: Stretch) -> dict[str, float]:
        trace, frame, piece, cur, new, share = s.trace, s.frame, s.piece, s.start, s.end, s.share
        if trace.after.motion != "CIP":
            return super()._centre_words(s)
        m, step = trace.contour, self.step(frame.inch)
        a, b, _ = s.plane
        assert piece.centre is not None
        begin = piece.share - share if piece.share > share else 0.0
        at = self._via(trace, frame) if share >= 1.0 - 1e-9 else begin + share / 2
        nominal = points(m, np.array([at]))[0] - np.array(m.centre)
        radius = math.hypot(*(frame.tip(new) - piece.centre)[[a, b]])
        point = piece.centre + nominal * radius / math.hypot(nominal[a], nominal[b])
        wanted = frame.numbers(point)
        centre = frame.numbers(piece.centre)
        unit = frame.radii()
        size = math.hypot(*((new - centre) * unit)[[a, b]])
        best = min(
            (
                (nearest(float(wanted[a]), step) + i * step, nearest(float(wanted[b]), step) + j * step)
                for i in (-1, 0, 1)
                for j in (-1, 0, 1)
            ),
            key=lambda p: (
                abs(math.hypot((p[0] - centre[a]) * unit[a], (p[1] - centre[b]) * unit[b]) - size)
                + 0.1 * math.hypot(p[0] - wanted[a], p[1] - wanted[b])
            ),
        )
        out = {}
        for i, value in zip((a, b), best):
            word = trace.words.get(VIA[i]) if share >= 1.0 - 1e-9 or begin == 0.0 else None
            steps = (
                word.mode == "IC" if word is not None and word.mode else self.relative(trace, frame, i, False)
            )
            out[VIA[i]] = (value - float(cur[i])) * float(unit[i]) if steps else value
        return out

    def _nominal_centre(self, trace: Trace, frame: BlockFrame) -> dict[str, float]:
        return super()._nominal_centre(trace, frame) | dict.fromkeys(VIA, math.inf)

    def _via(self, trace: Trace, frame: BlockFrame) -> float:
        """Return the share of the arc at which its intermediate point lies."""
        m = trace.contour
        point = frame.numbers(np.array(m.start))
        start = point.copy()
        for i, letter in enumerate(VIA):
            word = trace.words.get(letter)
            if word is None:
                continue
            if not word.plain:
                return 0.5
            steps = word.mode == "IC" or (not word.mode and not frame.absolute)
            point[i] = value_of(word) / frame.radii()[i] + start[i] if steps else value_of(word)
        return float(nearest_share(m, frame.tip(point)[None])[0])


def _from_zero(trace: Trace, letter: str) -> bool:
    word = trace.words.get(letter)
    return word is not None and word.mode == "AC"


def _same(m: Move, piece: BlockPiece) -> bool:
    """Return whether nothing of an arc has to change."""
    assert m.centre is not None
    assert piece.centre is not None
    a, b, _ = PLANES[m.plane]
    centre = max(abs(piece.centre[i] - m.centre[i]) for i in (a, b))
    return bool(max(centre, np.abs(piece.end - np.array(m.end)).max()) < NO_MOTION_MM)
