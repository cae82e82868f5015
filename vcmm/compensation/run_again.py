"""Run a program again on the machine with its known errors, and measure how far its tool is from the programmed path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.compensation.field import KnownErrors, PathErrors, field_of
from vcmm.compensation.orientation import prove_orientation
from vcmm.compensation.path_deviations import FollowedPath, follow_path
from vcmm.compensation.proof import Walk, departure, departures, end_departures, errors_on, spans, walk
from vcmm.compensation.result import Departure, OrientationProof
from vcmm.compensation.rewriting import Work
from vcmm.core.run import Array
from vcmm.program.moves import Program


def departure_by_run(
    work: Work, known_errors: KnownErrors, program: Program, lines: Sequence[int]
) -> Departure:
    """Return the departure of the program run on the machine from the path of the original; lines: empty for the original itself."""
    w, gap = _gaps(work, known_errors, program, lines)
    at = [program.moves[i].source.line for i in w.move.tolist()]
    return departure(gap, w.weight, [lines[line - 1] for line in at] if lines else at)


def _gaps(
    work: Work, known_errors: KnownErrors, program: Program, lines: Sequence[int]
) -> tuple[Walk, Array]:
    """Return the points along a program, and how far the tool is there from the path of the original (k,), mm."""
    field = field_of(
        known_errors, work.setup, program.moves, set_here=work.field.set_here, constants=work.field.constants,
        lathe=work.dialect.lathe,
    )  # fmt: skip
    w = walk(program.moves)
    low, high = spans(work.program, program, lines) if lines else (np.arange(len(program.moves)),) * 2
    field = replace(field, surface=work.field.surface, surface_moves=(low, high))
    actual = w.tip + errors_on(field, w)
    gap = departures(actual, work.program.moves, low[w.move], high[w.move])
    return w, np.maximum(gap, end_departures(actual, w, program.moves, work.program.moves, low, high))


def both_paths(work: Work, new: Program, lines: Sequence[int]) -> tuple[FollowedPath, FollowedPath]:
    """Return the program as it is and as rewritten, with the deviations along both; lines of the file."""
    out = []
    for program, source in ((work.program, ()), (new, lines)):
        w, gap = _gaps(work, work.known_errors, program, source)
        of_file = [work.origin[n - 1] for n in (source or range(1, len(work.source.lines) + 1)) if n]
        ahead = sum(n == 0 for n in source)  # lines of the mark, which move nothing
        out.append(follow_path(program.moves, w.move, w.tip, gap, [0] * ahead + of_file))
    return out[0], out[1]


def pointing_of(work: Work, aim: Program, new: Program, lines: Sequence[int]) -> OrientationProof:
    """Return the direction of the tool with the program as it is, and with the new one; lines: of the source for each line of the new program."""

    def along(program: Program) -> PathErrors:
        return replace(work.field, moves=program.moves)

    low, _ = spans(work.program, new, lines)
    origin = (0, *work.origin)
    numbers = np.arange(len(aim.moves))
    before = prove_orientation(along(aim), aim.moves, aim.moves, low=numbers, lines=origin)
    own_lines = (0, *(origin[n] for n in lines))
    return OrientationProof(
        before, prove_orientation(along(new), aim.moves, new.moves, low=low, lines=own_lines)
    )
