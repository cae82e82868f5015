"""Write Klartext: L, C with CC, CR, CP, and blocks that are converted to these where they must change (LP -> L; CT, CTP -> C).

The pole (CC) of an arc is moved in its own block where that serves this arc alone, else a new CC is put before the arc.
An arc whose third axis has to change as well becomes a helix (CP IPA.. Z..): C has no third axis.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.compensation.contours import sweep_of
from vcmm.compensation.fitting import BlockFit
from vcmm.compensation.frame import AXES, BlockFrame, frame_of
from vcmm.compensation.numbers import HOLD, SAME_INCREMENT_SHARE, format_number, nearest
from vcmm.compensation.source import Edit, semicolon_code
from vcmm.compensation.writer import Stretch, Writer, best_centre
from vcmm.core.run import Array
from vcmm.program.moves import PLANES
from vcmm.program.trace import Trace, WordAt

POLAR = ("PR", "IPR", "PA", "IPA")
CHANGED_FUNCTIONS = ("LP", "CT", "CTP")  # path functions that are turned into others
NO_MOTION_MM = 1e-6  # mm
ANGLE = 4  # decimals of IPA, deg


@dataclass(eq=False)
class KlartextWriter(Writer):
    """Writes Klartext blocks. pole: of the new program, numbers of the plane; pole_line: where the source set it."""

    pole: tuple[float, float] | None = None
    pole_line: int = 0
    pole_free: bool = False  # no block has relied on it yet
    pole_moved: bool = False  # the new program has it elsewhere than the source
    path: str = "L"
    turned_lines: set[int] = field(
        default_factory=set
    )  # lines whose path function has been turned into another

    def code(self, index: int) -> str:
        return semicolon_code(self.source.lines[index][0])

    def order(self) -> Sequence[str]:
        return (*AXES, "R")

    def number(self, value: float, decimals: int, like: str = "", whole: bool = False) -> str:
        text = format_number(value, decimals, like, whole)
        return text if text[0] in "+-" or like[:1].isdigit() else "+" + text

    def _number_style(self, trace: Trace) -> str:
        return next((w.text for k, w in trace.words.items() if k in AXES and w.plain), "+")

    def drop(self, index: int, word: WordAt) -> None:
        """Remove a word and the blanks before it."""
        at = word.line - 1 if word.line else index
        ahead = self.source.lines[at][0][: word.first - 1]
        first = len(ahead.rstrip()) + 1
        self.edits.setdefault(at, []).append(Edit(first, word.last, ""))

    def relative(self, trace: Trace, frame: BlockFrame, i: int, first: bool) -> bool:
        word = trace.words.get(AXES[i]) if first else None
        return word is not None and word.mode == "IC"

    def centre_absolute(self, trace: Trace, frame: BlockFrame, i: int) -> bool:
        return True

    # -- blocks -----------------------------------------------------------------------------------------------------
    def move(self, trace: Trace, fit: BlockFit) -> None:
        frame, index = frame_of(trace), trace.line - 1
        self.path = trace.words["path"].text if "path" in trace.words else "L"
        self._pole_of(trace, frame)
        polar = any(k in trace.words for k in POLAR)
        if self.path in CHANGED_FUNCTIONS or polar:
            if self._is_unchanged(trace, frame, fit):
                self.pole_free = self.pole_free and not polar
                self.q = np.array(trace.contour.end) + frame.offset
                return
            self._turn(trace, frame, index)
        super().move(trace, fit)

    def _pole_of(self, trace: Trace, frame: BlockFrame) -> None:
        """Note that a CC of the source has been passed since the last arc."""
        block = trace.words.get("CC path")
        if block is None or block.line == self.pole_line:
            return
        self.pole_line, self.pole, self.pole_moved = block.line, None, False
        words = [trace.words.get(f"CC {AXES[i]}") for i in PLANES[trace.contour.plane][:2]]
        self.pole_free = all(w is not None and w.plain and not w.mode for w in words)
        if self.pole_free and trace.contour.kind == "arc" and trace.words["path"].text in ("C", "CP", "CTP"):
            assert trace.contour.centre is not None
            a, b, _ = PLANES[trace.contour.plane]
            centre = frame.numbers(np.array(trace.contour.centre))
            if trace.words["path"].text != "CTP":
                self.pole = float(centre[a]), float(centre[b])

    def _is_unchanged(self, trace: Trace, frame: BlockFrame, fit: BlockFit) -> bool:
        """Return whether the block may stay as it is: tool, pole and end are as in the source."""
        m = trace.contour
        if self.pole_moved and any(k in trace.words for k in POLAR):
            return False
        if len(fit.pieces) > 1 or np.abs(self.q - frame.offset - np.array(m.start)).max() > NO_MOTION_MM:
            return False
        piece = fit.pieces[0]
        off = float(np.abs(piece.end - np.array(m.end)).max())
        if m.centre is not None and piece.centre is not None:
            off = max(
                off,
                *(abs(float(piece.centre[i] - m.centre[i])) for i in PLANES[m.plane][:2]),
            )
        return off < NO_MOTION_MM

    def _turn(self, trace: Trace, frame: BlockFrame, index: int) -> None:
        """Convert LP -> L, CT and CTP -> C; arcs get their name in `_set_function`, once it is known whether they climb."""
        if self.path in ("CT", "CTP"):
            self.path = "C"
        if self.path == "LP":
            self.path = "L"
            self._set_function(trace, index, "L")

    def _set_function(self, trace: Trace, index: int, name: str) -> None:
        """Set the path function of the block; polar words are removed."""
        word = trace.words["path"]
        if word.text != name:
            self.turned_lines.add(index)
            self.edits.setdefault(word.line - 1, []).append(Edit(word.first, word.last, name))
        for key in POLAR:
            if key in trace.words:
                self.drop(index, trace.words[key])

    def _behind(self, trace: Trace) -> tuple[int, int]:
        """Return index of the line and column behind the last axis word, else behind the path function."""
        words = [trace.words[k] for k in AXES if k in trace.words] or [trace.words["path"]]
        last = max(words, key=lambda w: (w.line, w.last))
        return last.line - 1, last.last

    def _settle(self, s: Stretch) -> Array:
        trace, frame, piece, cur = s.trace, s.frame, s.piece, s.start
        new = super()._settle(replace(s, whole=False))
        if trace.contour.kind != "arc":
            return new
        a, b, n = s.plane
        step = self.step(frame.inch)
        wanted = frame.numbers(piece.end)
        for i in (a, b):
            steps = self.relative(trace, frame, i, s.first)
            origin = float(cur[i]) if steps else 0.0
            new[i] = float(cur[i]) if s.whole else origin + nearest(float(wanted[i]) - origin, step)
        near = max(HOLD * step, self.slack * float(frame.scale[1]))
        rises = abs(wanted[n] - cur[n]) > near
        new[n] = nearest(float(wanted[n]), step) if rises or s.names(n) else cur[n]
        self.helix = abs(new[n] - cur[n]) > SAME_INCREMENT_SHARE * step or trace.contour.turns > 1
        if self.helix:
            new = self._spiral(replace(s, end=new))
        return new

    helix: bool = False
    angle: float = 0.0  # deg, of the last helix
    centre: tuple[float, float] = (0.0, 0.0)

    def _rounded_centre(self, s: Stretch) -> tuple[float, float]:
        flat = list(s.plane[:2])
        assert s.piece.centre is not None
        wanted = s.frame.numbers(s.piece.centre)[flat]
        return best_centre(wanted, s.start[flat], (s.end - s.start)[flat], self.step(s.frame.inch))

    def _spiral(self, s: Stretch) -> Array:
        """End of a helix: on the circle about the pole that goes through the start, at an angle as written."""
        cur, new = s.start, s.end
        a, b, _ = s.plane
        self.centre = self._rounded_centre(s)
        begin = math.atan2(cur[b] - self.centre[1], cur[a] - self.centre[0])
        goal = math.atan2(new[b] - self.centre[1], new[a] - self.centre[0])
        part = s.share * sweep_of(s.trace.contour) * (-1.0 if _is_mirrored(s.trace) else 1.0)
        turn = part + math.remainder(goal - begin - part, 2 * math.pi)
        self.angle = round(math.degrees(turn), ANGLE)
        radius = math.hypot(cur[a] - self.centre[0], cur[b] - self.centre[1])
        out = new.copy()
        at = begin + math.radians(self.angle)
        out[a], out[b] = self.centre[0] + radius * math.cos(at), self.centre[1] + radius * math.sin(at)
        return out

    # -- words ------------------------------------------------------------------------------------------------------
    def _first(self, s: Stretch) -> None:
        trace, frame, cur, new, index = s.trace, s.frame, s.start, s.end, s.index
        if trace.contour.kind != "arc":
            super()._first(s)
            return
        self._set_function(trace, index, "CP" if self.helix else "C" if self.path == "CP" else self.path)
        if self.helix:
            self._as_helix(trace, frame, new, index)
            self._place(index, trace, self.centre, frame, first=True)
            self._set_direction(trace)
            return
        flat = tuple(AXES[i] for i in s.plane[:2])
        whole_block = s.whole and self.path == "C" and not any(k in trace.words for k in flat)
        for letter in (
            () if whole_block else flat
        ):  # the block names its whole end, so that it says what it means
            i = AXES.index(letter)
            steps = self.relative(trace, frame, i, True)
            value = float(new[i] - cur[i] if steps else new[i])
            if (
                letter in trace.words
                or s.split
                or self.path != "C"
                or abs(new[i] - cur[i]) > SAME_INCREMENT_SHARE * self.step(frame.inch)
            ):
                self.word(index, trace, letter, value, s.nominal(i, steps), frame.inch)
        n = s.plane[2]
        if AXES[n] in trace.words:
            steps = self.relative(trace, frame, n, True)
            self.word(
                index,
                trace,
                AXES[n],
                float(new[n] - cur[n] if steps else new[n]),
                s.nominal(n, steps),
                frame.inch,
            )
        self._set_direction(trace)
        self._centre(s)

    def _set_direction(self, trace: Trace) -> None:
        """Write the sense of rotation, which CT and CTP do not state."""
        if trace.words["path"].text in ("CT", "CTP"):
            index, column = self._behind(trace)
            self.edits.setdefault(index, []).append(Edit(column, column, f" {_sense(trace)}"))

    def _as_helix(self, trace: Trace, frame: BlockFrame, new: Array, index: int) -> None:
        """Convert C X.. Y.. -> CP IPA.. Z.."""
        a, b, n = PLANES[trace.contour.plane]
        word = trace.words["path"]
        for key in (AXES[a], AXES[b], "R"):
            if key in trace.words:
                self.drop(index, trace.words[key])
        at = word.last
        text = f" IPA{self.number(self.angle, ANGLE)}"
        if AXES[n] in trace.words:
            steps = trace.words[AXES[n]].mode == "IC"
            cur = frame.numbers(self.q - frame.offset)
            self.word(
                index, trace, AXES[n], float(new[n] - cur[n] if steps else new[n]), math.inf, frame.inch
            )
        else:
            text += f" {AXES[n]}{self.number(float(new[n]), self.decimals[frame.inch])}"
        self.edits.setdefault(word.line - 1, []).append(Edit(at, at, text))

    def _more(self, s: Stretch) -> None:
        trace, frame, new, index = s.trace, s.frame, s.end, s.index
        if trace.contour.kind != "arc":
            before = len(self.added_blocks.get(index, []))
            super()._more(s)
            if len(self.added_blocks.get(index, [])) > before:
                self.added_blocks[index][-1] = "L " + self.added_blocks[index][-1]
            return
        a, b, n = s.plane
        places, like = self.decimals[frame.inch], self._number_style(trace)
        ends = [AXES[i] + self.number(float(new[i]), places, like) for i in (a, b)]
        if self.helix:
            self._place(index, trace, self.centre, frame, first=False)
            height = AXES[n] + self.number(float(new[n]), places, like)
            words = ["CP", f"IPA{self.number(self.angle, ANGLE)}", height, _sense(trace)]
        elif "R" in trace.words:
            radius = self._centre_words(s)["R"]
            words = ["CR", *ends, "R" + self.number(radius, places, like), _sense(trace)]
        else:
            self._place(index, trace, self._rounded_centre(s), frame, first=False)
            words = ["C", *ends, _sense(trace)]
        self.insert(index, words)

    def _centre(self, s: Stretch) -> None:
        if "R" in s.trace.words:
            super()._centre(s)
            return
        self._place(s.index, s.trace, self._rounded_centre(s), s.frame, first=True)

    def _place(
        self, index: int, trace: Trace, centre: tuple[float, float], frame: BlockFrame, first: bool
    ) -> None:
        """Place the pole of an arc: where it is already, in the CC of the source, or in a new CC."""
        step, places = self.step(frame.inch), self.decimals[frame.inch]
        letters = [AXES[i] for i in PLANES[trace.contour.plane][:2]]
        if (
            self.pole is not None
            and max(abs(x - y) for x, y in zip(self.pole, centre)) < SAME_INCREMENT_SHARE * step
        ):
            self.pole_free = False
            return
        if first and self.pole_free and trace.words["path"].text in ("C", "CP"):
            for letter, value in zip(letters, centre):
                word: WordAt = trace.words[f"CC {letter}"]
                self.replace(index, word, self.number(value, places, word.text))
        else:
            text = " ".join(
                [
                    "CC",
                    *(k + self.number(v, places, self._number_style(trace)) for k, v in zip(letters, centre)),
                ]
            )
            (self.before if first else self.added_blocks).setdefault(index, []).append(text)
        self.pole, self.pole_free, self.pole_moved = centre, False, True

    def _add(self, index: int, trace: Trace, letter: str, number: str) -> None:
        """Add a word that the block lacks: behind the axes before it, else behind the path function."""
        order = self.order()
        before = [trace.words[k] for k in order[: order.index(letter)] if k in trace.words]
        last = max(before, key=lambda w: (w.line, w.last)) if before else trace.words.get("path")
        if last is None or last.text == "M":
            super()._add(index, trace, letter, number)
            return
        self.edits.setdefault(last.line - 1, []).append(Edit(last.last, last.last, f" {letter}{number}"))

    def leave(self, traces: Sequence[Trace], fit: BlockFit) -> None:
        """Write DEP: its moves follow from the contour; only words that it has are corrected."""
        first, last = traces[0].contour, traces[-1].contour
        self.q = self.q + np.array(last.end) - np.array(first.start)
        frame, index = frame_of(traces[-1]), traces[-1].line - 1
        cur, wanted = frame.numbers(self.q - frame.offset), frame.numbers(fit.pieces[-1].end)
        for i, letter in enumerate(AXES):
            if letter in traces[-1].words and not self.relative(traces[-1], frame, i, True):
                cur[i] = nearest(float(wanted[i]), self.step(frame.inch))
                self.word(index, traces[-1], letter, float(cur[i]), float(cur[i]), frame.inch)
        self.q = frame.tip(cur) + frame.offset


def _is_mirrored(trace: Trace) -> bool:
    """Return whether the frame turns arcs of the plane round."""
    a, b, _ = PLANES[trace.contour.plane]
    m = trace.transformation.matrix
    return m[a][a] * m[b][b] - m[a][b] * m[b][a] < 0


def _sense(trace: Trace) -> str:
    return "DR-" if bool(trace.contour.clockwise) != _is_mirrored(trace) else "DR+"
