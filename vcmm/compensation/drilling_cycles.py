"""Drilling cycles of Sinumerik and Klartext: the hole moves with its position, its heights with the definition of the cycle.

X and Y take the mean of the corrections at the clearance height and at the bottom (a hole stays straight). All heights of
the definition move by the correction at the bottom; where that changes from hole to hole by more than what a block may leave
an axis off, the definition is written again before the hole.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.compensation.fitting import BlockFit, BlockPiece
from vcmm.compensation.frame import BlockFrame, frame_of
from vcmm.compensation.numbers import HOLD, SAME_INCREMENT_SHARE, nearest, value_of
from vcmm.compensation.source import Edit, apply_edits, at_line
from vcmm.compensation.writer import Writer
from vcmm.core.errors import DataError
from vcmm.program.moves import PLANES
from vcmm.program.trace import Trace, WordAt

HEIGHTS = {"sinumerik": ("RFP", "DP", "FDEP"), "heidenhain": ("Q203",)}  # absolute heights of a definition


def straighten_holes(traces: Sequence[Trace], fits: Sequence[BlockFit | None]) -> list[BlockFit | None]:
    """Fits in which the block before a hole ends over the mean of the corrections of that hole."""
    out = list(fits)
    for i in range(len(traces) - 1):
        trace, fit = traces[i], fits[i]
        if (
            trace.cycle
            or fit is None
            or not traces[i + 1].cycle
            or trace.contour.kind not in ("rapid", "line")
        ):
            continue
        hole = _hole(traces, i + 1)
        normal = PLANES[trace.contour.plane][2]
        bottom = _bottom(traces, hole, normal)
        ends = [fits[k] for k in (hole[0], bottom)]
        if any(f is None for f in ends):
            continue
        shifts = [
            f.pieces[-1].end - np.array(traces[k].contour.end) for f, k in zip(ends, (hole[0], bottom)) if f
        ]
        mean = (shifts[0] + shifts[1]) / 2
        end = np.array(trace.contour.end) + mean
        end[normal] = fit.pieces[-1].end[normal]
        out[i] = BlockFit((*fit.pieces[:-1], BlockPiece(1.0, end)), fit.residual)
    return out


def _hole(traces: Sequence[Trace], at: int) -> list[int]:
    """Return the moves of the hole that begins at a trace."""
    to = at
    while to < len(traces) and traces[to].cycle and traces[to].line == traces[at].line:
        to += 1
    return list(range(at, to))


def _bottom(traces: Sequence[Trace], hole: Sequence[int], normal: int) -> int:
    """Return the feed of a hole that goes farthest."""
    top = traces[hole[0]].contour.start[normal]
    feeds = [k for k in hole if traces[k].contour.kind == "line"] or list(hole)
    return max(feeds, key=lambda k: abs(traces[k].contour.end[normal] - top))


def drill_here(writer: Writer, traces: Sequence[Trace], fits: Sequence[BlockFit | None]) -> None:
    """Write one hole at the present place of the tool."""
    first = traces[0]
    frame, normal = frame_of(first), PLANES[first.contour.plane][2]
    k = _bottom(traces, range(len(traces)), normal)
    fit = fits[k]
    if fit is None:
        return
    shift = frame.ways(fit.pieces[-1].end - np.array(traces[k].contour.end))[normal]
    block = first.words.get("cycle") or first.words.get("path")
    if block is None:
        raise at_line(
            DataError,
            first.file,
            first.line,
            f"the definition of {first.cycle} cannot be told; write the hole as single moves",
        )
    down = _down(writer, first, frame, block, float(shift))
    top = fits[0] or fit
    mean = (
        top.pieces[-1].end
        - np.array(first.contour.end)
        + fit.pieces[-1].end
        - np.array(traces[k].contour.end)
    ) / 2
    off = writer.q - frame.offset - np.array(first.contour.end) - mean
    off[normal] = (down - float(shift)) / float(frame.scale[1])
    near = max(HOLD * writer.step(frame.inch), writer.slack * float(frame.scale[1]))
    off[np.abs(off) * float(frame.scale[1]) > near + SAME_INCREMENT_SHARE * writer.step(frame.inch)] = (
        0.0  # left off, not rounded
    )
    writer.rounding.append(off)
    _arrive(writer, traces, frame, normal, down)


def _down(writer: Writer, trace: Trace, frame: BlockFrame, block: WordAt, shift: float) -> float:
    """Return the shift of the heights that is in force for this hole, defined again where it must be."""
    c, step = writer.cycle, writer.step(frame.inch)
    wanted = nearest(shift, step)
    near = max(HOLD * step, writer.slack * float(frame.scale[1]))
    fresh = c.get("line") != block.line
    if not fresh and abs(shift - c["down"]) <= near:
        return c["down"]
    words = _values(writer, trace, wanted)
    if fresh:
        for word, text in words:
            if abs(wanted) > 0:
                writer.replace(word.line - 1, word, text)
    else:
        _repeat_definition(writer, trace, block, words)
    c["line"], c["down"] = block.line, wanted
    return wanted


def _values(writer: Writer, trace: Trace, down: float) -> list[tuple[WordAt, str]]:
    """Return the heights of the definition with their new numbers."""
    out = []
    inch = trace.after.unit > 1.0
    names = HEIGHTS[writer.dialect.name]
    reference, over = trace.words.get("RFP"), trace.words.get("RTP")
    has_planes = reference is not None and over is not None and reference.plain and over.plain
    if has_planes and value_of(over) < value_of(reference) + down:  # type: ignore[arg-type]
        names = (*names, "RTP")  # the retract plane may not lie below the reference plane
    for name in names:
        word = trace.words.get(name)
        if word is None:
            continue
        if not word.plain:
            message = f"{name} of {trace.cycle} is an expression; write it as a number, or have the program written out (--inline)"
            raise at_line(DataError, trace.file, word.line, message, word.first)
        number = writer.number(value_of(word) + down, writer.decimals[inch], word.text)
        out.append((word, number))
    return out


def _repeat_definition(
    writer: Writer, trace: Trace, block: WordAt, words: Sequence[tuple[WordAt, str]]
) -> None:
    """Repeat the definition before the block of the hole."""
    last = max([block.line, *(w.line for w in trace.words.values())])
    lines = []
    for number in range(block.line, last + 1):
        line = writer.source.lines[number - 1][0]
        code = writer.code(number - 1)
        edits = [Edit(w.begin, w.end, text) for w, text in words if w.line == number]
        body = apply_edits(code, edits)
        if number == block.line:  # from the name of the cycle on: no block number, no other words
            ahead = "MCALL " if "MCALL" in line.upper() else ""
            end = block.last + len(body) - len(code) if ahead else len(body) + 1
            body = ahead + body[block.first - 1 : end - 1]
        body = body.rstrip().rstrip("~").rstrip()
        lines.append(body + (" ~" if number < last else ""))
    writer.before.setdefault(trace.line - 1, []).extend(lines)


def _arrive(writer: Writer, traces: Sequence[Trace], frame: BlockFrame, normal: int, down: float) -> None:
    """Set the position of the new program after the hole: above it, at the height of the definition."""
    new = frame.numbers(writer.q - frame.offset)
    last = traces[-1]
    height = float(frame.numbers(np.array(last.contour.end))[normal])
    over = last.words.get("RTP")
    fixed = over is not None and over.plain and last.words["RFP"].plain
    if fixed and over is not None:
        stays = value_of(over) >= value_of(last.words["RFP"]) + down
        height += 0.0 if stays else down
    else:
        height += down
    new[normal] = height
    writer.q = frame.tip(new) + frame.offset
