"""Correct directions of the tool in a program that leads the tip: find the angles (or vectors) at which the tool points as programmed.

    tilt = (e(a point LEVER up the tool) - e(tip)) / LEVER          the tool points along  a(q) + tilt(q)

a(q) from the kinematic chain, e from the same errors that correct the tip. Wanted is a(q) of the program as it is; q follows by
Newton's method with the pseudo-inverse of da/dq. Where one axis hardly turns the tool (a singular position) that axis would have to
run far to correct a small tilt: there a cut is refused. Only words of the program change, block by block; the path of the
tip is corrected for the new angles afterwards, as usual.

Hand check: a table B that is 50 urad off, tool along Z: tilt (50e-6, 0, 0); B is written 50 urad = 0.00286 deg less.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.compensation.field import PathErrors
from vcmm.compensation.numbers import format_number, value_of
from vcmm.compensation.proof import CUTS, departure
from vcmm.compensation.result import Departure
from vcmm.compensation.source import Edit, SourceText, apply_edits, at_line
from vcmm.compensation.targets import moves_of
from vcmm.core.axes import ROTARY
from vcmm.core.errors import DataError, ModelLimit
from vcmm.core.run import Array
from vcmm.program.moves import Move, Program
from vcmm.program.trace import Trace, WordAt
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.motion.tool_pose import rotary_of, tip_and_axis

LEVER = 100.0  # mm; rigid tilts are the same over any length
GAIN = 20.0  # rad of an axis for one of the tool, beyond which the position is singular
WEAK = 1e-6  # rad of tilt that may be left in a cut at a singular position
ROUNDS, DIFFERENCE_STEP_RAD = 4, 1e-6
VECTORS = (("I", "J", "K"), ("A3", "B3", "C3"), ("TX", "TY", "TZ"))
LEAST_ANGLE, LEAST_VECTOR = 3, 6  # decimals of degrees, of components of a unit vector
SHARES = (0.0, 0.5, 1.0)  # of a move, where its direction is looked at


def direction(field: PathErrors, angle: Array) -> Array:
    """Return the tool axes (k, 3) in the workpiece at angles (k, 3)."""
    none = np.zeros_like(angle)
    return tip_and_axis(field.known_errors.machine, none, angle, none)[1]


def tilt(field: PathErrors, move: Ints, share: Array, tips: Array, angle: Array) -> Array:
    """Return the tilt (k, 3) rad of the tool by errors, its tip at tips (k, 3) and its rotary axes at angles (k, 3)."""
    run = field.run(move, share, tips)
    linear = field.axes_at(move, tips, angle, -run.offset) - run.offset
    travel = {
        a: field.known_errors.machine.axes[a].limits for a in run.position
    }  # what leads beyond is refused by its line
    both = {
        a: linear[:, "XYZ".index(a)] if a in "XYZ" else np.clip(angle[:, ROTARY.index(a)], *travel[a])
        for a in run.position
    }
    near = replace(run, position=both)
    far = replace(near, offset=near.offset + np.array([0.0, 0.0, LEVER]))
    return np.asarray((field.errors(far, move) - field.errors(near, move)) / LEVER)


@dataclass(frozen=True, eq=False)
class OrientationCorrection:
    """Angles (k, 3) that point the tool as programmed; rest (k,): tilt that remains, rad; singular (k,)."""

    angle: Array
    rest: Array
    singular: np.typing.NDArray[np.bool_]


def correct_orientation(field: PathErrors, move: Ints, tips: Array, angle: Array) -> OrientationCorrection:
    """Return the corrected angles at the ends of moves (k,) with tips (k, 3) and programmed angles (k, 3)."""
    letters, share = rotary_of(field.known_errors.machine), np.ones(len(move))
    wanted, corrected = direction(field, angle), angle.copy()
    singular = np.zeros(len(move), dtype=bool)
    miss = np.zeros_like(wanted)
    for k in range(ROUNDS):
        now = direction(field, corrected)
        miss = wanted - now - tilt(field, move, share, tips, corrected)
        miss -= np.einsum("ki,ki->k", miss, wanted)[:, None] * wanted
        if k == ROUNDS - 1:
            break
        slopes = [
            (direction(field, _step_angle(corrected, letter)) - now) / DIFFERENCE_STEP_RAD
            for letter in letters
        ]
        slope = np.stack(slopes, axis=2)
        size = np.linalg.svd(slope, compute_uv=False)
        singular = size[:, -1] < 1.0 / GAIN
        step = np.linalg.pinv(slope, rcond=1.0 / GAIN) @ miss[:, :, None]
        corrected[:, letters] += step[:, :, 0]
    return OrientationCorrection(corrected, np.linalg.norm(miss, axis=1), singular)


def _step_angle(angle: Array, letter: int) -> Array:
    out = angle.copy()
    out[:, letter] += DIFFERENCE_STEP_RAD
    return out


def oriented_source(
    source: SourceText, read: Program, field: PathErrors, decimals: int | None
) -> tuple[SourceText, tuple[str, ...]]:
    """Return the program with the words that turn the tool corrected, and remarks.

    Raises DataError and ModelLimit with the line: words that are no plain absolute numbers, travels, singular positions.
    """
    index = moves_of(read.traces, read.moves)
    chosen = [k for k, t in enumerate(read.traces) if t.contour.is_tip_led and _turns(t)]
    if not chosen:
        return source, ("no block turns the tool: its direction is left as it is",)
    move = np.array([index[k] for k in chosen], dtype=np.intp)
    ends = [read.moves[i] for i in move.tolist()]
    angle, tips = np.array([m.rotary_end for m in ends]), np.array([m.end for m in ends])
    correction = correct_orientation(field, move, tips, angle)
    axes = direction(field, correction.angle)
    edits: dict[int, list[Edit]] = {}
    for row, k in enumerate(chosen):
        trace = read.traces[k]
        _check(field, trace, source.name, correction, row)
        change = np.degrees(correction.angle[row] - angle[row])
        for word, text in _words(trace, source.name, change, angle[row], axes[row], decimals):
            begin, end = (word.begin, word.end) if word.begin else (word.first + 1, word.last)
            edits.setdefault((word.line or trace.line) - 1, []).append(Edit(begin, end, text))
    lines = tuple((apply_edits(line, edits.get(n, ())), end) for n, (line, end) in enumerate(source.lines))
    return replace(source, lines=lines), ()


def _turns(trace: Trace) -> bool:
    return _vector(trace) is not None or any(w in trace.words for a in ROTARY for w in (a, f"I{a}"))


def _vector(trace: Trace) -> tuple[str, str, str] | None:
    """Return the words of a direction; tilted planes point the tool without them."""
    if trace.contour.tool_axis_end is None or trace.contour.kind == "arc":
        return None
    return next((names for names in VECTORS if any(n in trace.words for n in names)), None)


def _check(field: PathErrors, trace: Trace, name: str, correction: OrientationCorrection, row: int) -> None:
    machine, first = field.known_errors.machine, trace.contour.source.first
    if correction.singular[row] and correction.rest[row] > WEAK and trace.contour.kind in CUTS:
        message = (
            f"the tool is where one rotary axis hardly turns it (a singular position), and {correction.rest[row] * 1e6:.1f} urad of its tilt could only be "
            "corrected by a long way of that axis; lay the part so that the tool leans there, or leave --orientation out"
        )
        raise at_line(ModelLimit, name, trace.line, message, first)
    for k in rotary_of(machine):
        low, high = machine.axes[ROTARY[k]].limits
        q = correction.angle[row, k]
        if not low - 1e-9 <= q <= high + 1e-9:
            message = f"axis {ROTARY[k]} = {math.degrees(q):.4f} deg is outside its travel {math.degrees(low):g} to {math.degrees(high):g} deg after correction"
            raise at_line(ModelLimit, name, trace.line, message, first)


def _words(
    trace: Trace, name: str, change: Array, nominal: Array, axis: Array, decimals: int | None
) -> list[tuple[WordAt, str]]:
    """Return each word of a block that turns the tool, and its new value. change, nominal (3,): degrees, rad; axis (3,): the new direction."""
    names = _vector(trace)
    if names is not None:
        return _vector_words(trace, name, names, axis, decimals)
    out = []
    for k, letter in enumerate(ROTARY):
        if f"I{letter}" in trace.words:
            raise _unreadable(trace, name, f"I{letter}")
        word = trace.words.get(letter)
        if word is None:
            continue
        given = (
            value_of(word) if word.plain and word.mode in ("", "AC") and trace.after.absolute else math.nan
        )
        if not abs(math.remainder(given - math.degrees(nominal[k]), 360.0)) < 1e-6:
            raise _unreadable(trace, name, letter)
        out += _anew(word, given + change[k], LEAST_ANGLE, decimals)
    return out


def _vector_words(
    trace: Trace, name: str, names: Sequence[str], axis: Array, decimals: int | None
) -> list[tuple[WordAt, str]]:
    words = [trace.words.get(n) for n in names]
    if any(w is None or not w.plain for w in words):
        raise _unreadable(trace, name, " ".join(names))
    present = [w for w in words if w is not None]
    length = math.hypot(*(value_of(w) for w in present))
    vector = np.linalg.solve(np.array(trace.transformation.matrix), axis)
    vector *= length / np.linalg.norm(vector)
    return [new for w, v in zip(present, vector.tolist()) for new in _anew(w, v, LEAST_VECTOR, decimals)]


def _anew(word: WordAt, value: float, least: int, decimals: int | None) -> list[tuple[WordAt, str]]:
    """Return the word with its new value; none where its digits do not change: it is left byte for byte."""
    digits = max(least, word.decimals or 0, decimals or 0)
    same = abs(round(value, digits) - value_of(word)) < 0.5 * 10.0**-digits
    return [] if same else [(word, format_number(value, digits, word.text))]


def _unreadable(trace: Trace, name: str, words: str) -> DataError:
    message = (
        f"{words} turns the tool and is not rewritten here: an orientation is corrected in plain numbers, absolute and without shifts of the axis "
        "(B30.5, or all three of a direction); write it so, or leave --orientation out"
    )
    return at_line(DataError, name, trace.line, message, trace.contour.source.first)


def prove_orientation(
    field: PathErrors, wanted: Sequence[Move], moves: Sequence[Move], low: Ints, lines: Sequence[int]
) -> Departure:
    """Return how far (rad) the tool points off along the cuts of `moves`; wanted: the program as it is, low (m,): its move for each of them.

    lines: of the file for each line of the program that is run.
    """
    cuts = [i for i, m in enumerate(moves) if m.is_tip_led and m.kind in CUTS and m.rewritable]
    if not cuts:
        return Departure(0.0, 0.0, 0)
    move = np.repeat(np.array(cuts, dtype=np.intp), len(SHARES))
    share = np.tile(np.array(SHARES), len(cuts))
    ends = np.array([(moves[i].start, moves[i].end) for i in move.tolist()])
    tips = ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0])
    angle, should = _angles(moves, move, share), _angles(wanted, low[move], share)
    off = direction(field, angle) + tilt(field, move, share, tips, angle) - direction(field, should)
    axis = direction(field, should)
    off -= np.einsum("ki,ki->k", off, axis)[:, None] * axis
    weight = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    return departure(
        np.linalg.norm(off, axis=1), weight, [lines[moves[i].source.line] for i in move.tolist()]
    )


def _angles(moves: Sequence[Move], which: Ints, share: Array) -> Array:
    ends = np.array([(moves[i].rotary_start, moves[i].rotary_end) for i in which.tolist()])
    return np.asarray(ends[:, 0] + share[:, None] * (ends[:, 1] - ends[:, 0]))
