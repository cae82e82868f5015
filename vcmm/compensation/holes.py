"""Drilling cycles: each hole is shifted by the correction at its own place; R and the depth move together.

X and Y take the mean of the corrections at the clearance height and at the bottom (a hole stays straight), R and Z that at
the bottom, so that depth and number of pecks stay; where the way out is cut too (G85, G89), R takes its own. Repeats (L, K)
in increments are written out where holes differ.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.compensation.fitting import BlockFit
from vcmm.compensation.frame import AXES, CENTRES, BlockFrame, frame_of
from vcmm.compensation.numbers import SAME_INCREMENT_SHARE, format_number, nearest
from vcmm.compensation.source import at_line
from vcmm.compensation.writer import Writer
from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.program.iso.cycles import DRILLING
from vcmm.program.moves import PLANES
from vcmm.program.trace import Trace

SAME_PLACE_MM = 1e-6  # mm
FEED_OUT = (
    "G85",
    "G89",
)  # they cut on the way out as well, and have no pecks: R gets a correction of its own


@dataclass(frozen=True, eq=False)
class DrilledHole:
    """Numbers of the program: place (3,) of the bottom, its correction (3,), and along the hole the correction at R."""

    place: Array
    shift: Array
    top: float


def drill(writer: Writer, traces: Sequence[Trace], fits: Sequence[BlockFit | None]) -> None:
    """Write one block of a cycle with all its moves."""
    first = traces[0]
    frame = frame_of(first)
    normal = PLANES[first.contour.plane][2]
    _series(writer, first, frame, normal)
    r, bottom = _heights(writer, first, frame, normal)
    holes = _holes(traces, fits, frame, normal, bottom)
    blocks = _blocks(writer, holes, frame, normal, r, bottom)
    repeat = next((k for k in ("L", "K") if k in first.words and len(holes) > 1), None)
    if repeat is not None and _even(blocks, writer.step(frame.inch)):
        blocks = blocks[:1]
        repeat = None
    _write(writer, first, frame, normal, blocks)
    if first.cycle == "G87" and writer.dialect.words == "o":
        _back_bore(writer, traces, fits, frame, normal, blocks)
    if repeat is not None:
        writer.drop(first.line - 1, first.words[repeat])
    _arrive(writer, traces[-1], frame=frame, normal=normal, r=r, bottom=bottom, holes=holes, blocks=blocks)


def _series(writer: Writer, trace: Trace, frame: BlockFrame, normal: int) -> None:
    """Begin a new series where no cycle was in force: its initial level is the present height of the tool."""
    c = writer.cycle
    going = trace.before.motion in DRILLING and trace.before.plane == trace.after.plane and "level" in c
    if not going:
        c.clear()
        c["level"] = float(frame.numbers(np.array(trace.contour.start))[normal])
        c["new level"] = float(frame.numbers(writer.q - frame.offset)[normal])


def _heights(writer: Writer, trace: Trace, frame: BlockFrame, normal: int) -> tuple[float, float]:
    """Return R and bottom as programmed, absolute, numbers of the program."""
    c = writer.cycle
    for letter, name in ((AXES[normal], "Z"), ("R", "R")):
        if letter in trace.words:
            if not trace.words[letter].plain:
                message = (
                    f"{letter} of a cycle is an expression; write it as a number to compensate the program"
                )
                raise at_line(DataError, trace.file, trace.line, message, trace.words[letter].first)
            c[name] = _written_value(writer, trace, letter, frame.inch)
            c[f"{name} counts"] = float(not frame.absolute)
    r = c["R"] + (c["level"] if _counts(writer, "R", frame) else 0.0)
    return r, c["Z"] + (r if _counts(writer, "Z", frame) else 0.0)


def _counts(writer: Writer, name: str, frame: BlockFrame) -> bool:
    """Return whether R (or "new R") in force counts from the initial level, Z from R: as in vcmm.program.iso.cycles."""
    if writer.dialect.words == "o":
        return not frame.absolute
    return bool(writer.cycle.get(f"{name} counts"))


def _standing(writer: Writer, name: str, frame: BlockFrame, base: float) -> float | None:
    """Return the new R or Z in force, as this block would write it; base: its reference under G91, program numbers."""
    value = writer.cycle.get(name)
    if value is None:
        return None
    return value + base * (_counts(writer, name, frame) - (not frame.absolute))


def _written_value(writer: Writer, trace: Trace, letter: str, inch: bool) -> float:
    from vcmm.compensation.numbers import value_of

    word = trace.words[letter]
    number = value_of(word)
    pointless = word.decimals is None and writer.dialect.decimal_point == "increment"
    return number * writer.dialect.increment[inch] if pointless else number


def _holes(
    traces: Sequence[Trace], fits: Sequence[BlockFit | None], frame: BlockFrame, normal: int, bottom: float
) -> list[DrilledHole]:
    """Return the holes in order: one for each stay at the bottom."""
    holes: list[DrilledHole] = []
    others = [i for i in range(3) if i != normal]
    for trace, fit in zip(traces, fits):
        if fit is None:
            continue
        end = np.array(trace.contour.end)
        numbers, shift = frame.numbers(end), frame.ways(fit.pieces[-1].end - end)
        if abs(numbers[normal] - bottom) > SAME_PLACE_MM or trace.contour.kind == "rapid":
            continue
        start = np.array(trace.contour.start)
        top = _top(traces, fits, start, frame, normal)
        mean = shift.copy()
        if top is not None:
            mean[others] = (shift[others] + top[others]) / 2
        place = numbers.copy()
        if not holes or np.abs((place - holes[-1].place)[others]).max() > SAME_PLACE_MM:
            out = trace.cycle in FEED_OUT and top is not None
            holes.append(
                DrilledHole(place, mean, float(top[normal] if out and top is not None else shift[normal]))
            )
    if not holes:
        message = f"the holes of {traces[0].cycle} cannot be told; write the block as single moves"
        raise at_line(DataError, traces[0].file, traces[0].line, message)
    return holes


def _top(
    traces: Sequence[Trace], fits: Sequence[BlockFit | None], start: Array, frame: BlockFrame, normal: int
) -> Array | None:
    """Return the correction where the feed of a hole begins."""
    for trace, fit in zip(traces, fits):
        if fit is not None and np.abs(np.array(trace.contour.end) - start).max() < SAME_PLACE_MM:
            return frame.ways(fit.pieces[-1].end - np.array(trace.contour.end))
    return None


def _blocks(
    writer: Writer, holes: Sequence[DrilledHole], frame: BlockFrame, normal: int, r: float, bottom: float
) -> list[dict[str, float]]:
    """Return the words of the block of each hole: X Y of the plane, Z and R as they are written."""
    step, out = writer.step(frame.inch), []
    cur = frame.numbers(writer.q - frame.offset)
    for hole in holes:
        down, up = nearest(float(hole.shift[normal]), step), nearest(hole.top, step)
        words: dict[str, float] = {}
        for i in (i for i in range(3) if i != normal):
            wanted = nearest(float(hole.place[i] + hole.shift[i]), step)
            words[AXES[i]] = wanted if frame.absolute else nearest(wanted - float(cur[i]), step)
            cur[i] = wanted if frame.absolute else cur[i] + words[AXES[i]]
            words[f"off {i}"] = float(cur[i] - hole.place[i] - hole.shift[i])
        words[AXES[normal]] = bottom + down if frame.absolute else bottom + down - r - up
        words["R"] = r + up if frame.absolute else r + up - writer.cycle["new level"]
        words["R height"] = r + up
        words["up"], words["down"], words[f"off {normal}"] = up, down, down - float(hole.shift[normal])
        out.append(words)
    return out


def _even(blocks: Sequence[dict[str, float]], step: float) -> bool:
    return all(abs(b[k] - blocks[0][k]) < SAME_INCREMENT_SHARE * step for b in blocks for k in (*AXES, "R"))


def _write(
    writer: Writer, trace: Trace, frame: BlockFrame, normal: int, blocks: Sequence[dict[str, float]]
) -> None:
    """Write the block itself, then one block for each further hole."""
    c, step, index = writer.cycle, writer.step(frame.inch), trace.line - 1
    cur = frame.numbers(writer.q - frame.offset)
    for k, words in enumerate(blocks):
        more = []
        for letter in (*AXES, "R"):
            value = words[letter]
            sticky = letter in (AXES[normal], "R")
            name = f"new {'Z' if letter == AXES[normal] else letter}"
            if sticky:
                base = c["new level"] if letter == "R" else words["R height"]
                stands = _standing(writer, name, frame, base)
            else:
                stands = float(cur[AXES.index(letter)]) if frame.absolute else 0.0
            changed = stands is None or abs(value - stands) > SAME_INCREMENT_SHARE * step
            if k == 0 and (changed or letter in trace.words):
                writer.word(index, trace, letter, value, value, frame.inch)
            elif k and changed:
                more.append(letter + format_number(value, writer.decimals[frame.inch]))
            if sticky and (changed or (k == 0 and letter in trace.words)):
                c[name], c[f"{name} counts"] = value, float(not frame.absolute)
            elif not sticky and frame.absolute:
                cur[AXES.index(letter)] = value
        if k and not any(w[0] in AXES for w in more):
            more.insert(0, "X" + format_number(words["X"], writer.decimals[frame.inch]))
        if more:
            writer.insert(index, more)


def _back_bore(
    writer: Writer, traces: Sequence[Trace], fits: Sequence[BlockFit | None], frame: BlockFrame, normal: int,
    blocks: Sequence[dict[str, float]],
) -> None:  # fmt: skip
    """Write I, J or K of G87: the end of the bore, with the correction there; from the bottom on where the program counts steps."""
    first, letter = traces[0], CENTRES[normal]
    word = first.words.get(letter)
    feeds = [i for i, t in enumerate(traces) if t.contour.kind == "line" and fits[i] is not None]
    if word is None or not feeds or len(blocks) > 1:
        return
    end, fit = np.array(traces[feeds[0]].contour.end), fits[feeds[0]]
    assert fit is not None
    up = nearest(float(frame.ways(fit.pieces[-1].end - end)[normal]), writer.step(frame.inch))
    old = (
        _written_value(writer, first, letter, frame.inch) if word.plain else float(frame.numbers(end)[normal])
    )
    value = old + up - (0.0 if frame.absolute else blocks[0]["down"])
    writer.word(first.line - 1, first, letter, value, old, frame.inch)


def _arrive(
    writer: Writer, last: Trace, frame: BlockFrame, normal: int, r: float, bottom: float, holes: Sequence[DrilledHole],
    blocks: Sequence[dict[str, float]],
) -> None:  # fmt: skip
    """Set the position of the new program after the block."""
    new = frame.numbers(writer.q - frame.offset)
    step = writer.step(frame.inch)
    for i in (i for i in range(3) if i != normal):
        letter = AXES[i]
        if frame.absolute:
            new[i] = blocks[-1][letter]
        else:
            steps = blocks if len(blocks) == len(holes) else [blocks[0]] * len(holes)
            new[i] += sum(nearest(b[letter], step) for b in steps)
    height = float(frame.numbers(np.array(last.contour.end))[normal])
    c = writer.cycle
    if abs(height - r) < SAME_PLACE_MM:
        new[normal] = r + blocks[-1]["up"]
    elif abs(height - c["level"]) < SAME_PLACE_MM:
        new[normal] = c["new level"]
    else:
        new[normal] = height
    writer.q = frame.tip(new) + frame.offset
    if len(blocks) == len(holes):
        size = abs(float(frame.scale[1]))
        writer.rounding += [np.array([b["off 0"], b["off 1"], b["off 2"]]) / size for b in blocks]
