"""Labels, and the contour of one, read for the cycles that follow it: its moves; the state is otherwise unchanged."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Protocol

from vcmm.core.errors import choose_from
from vcmm.program.contouring import record_contour
from vcmm.program.faults import ProgramFault
from vcmm.program.heidenhain.paths import KlartextPaths
from vcmm.program.heidenhain.text import KlartextBlock
from vcmm.program.moves import Move

DEEPEST = 20  # contours in contours


class LabelRunner(Protocol):
    """Runs blocks from `at` on until it returns."""

    at: int
    returns: list[int]
    depth: int
    lines: list[KlartextBlock]

    def run(self) -> bool: ...


def labels_of(lines: Sequence[KlartextBlock], file: str) -> dict[str, int]:
    """Return the labels, and the number of the block of each."""
    out: dict[str, int] = {}
    for k, line in enumerate(lines):
        words = [] if line.plain else [t.text.upper() for t in line.tokens]
        if len(words) < 2 or words[0] != "LBL" or words[1] == "0":
            continue
        if words[1] in out:
            raise ProgramFault(
                file, line.number, line.first, f"LBL {words[1]} appears twice in this program; rename one"
            )
        out[words[1]] = k
    return out


def contour_moves(
    paths: KlartextPaths, runner: LabelRunner, labels: Mapping[str, int], name: str
) -> tuple[list[Move], str | None]:
    """Return the moves of a label, in programmed coordinates, and the side on which the tool goes beside them."""
    r = paths.r
    if name not in labels:
        r.fault(f"there is no LBL {name} for the contour; add it.{choose_from(name, labels)}")
    if runner.depth > DEEPEST:
        r.fault(f"contours are nested deeper than {DEEPEST}; does LBL {name} call its own cycle?")
    modes = copy.copy(vars(paths))
    with record_contour(r) as contour:
        r.feed, r.feed_mode = r.feed or 1.0, "G94"  # that of the contour is the cycle's
        runner.at, runner.returns = labels[name], [len(runner.lines)]
        runner.run()
    vars(paths).update(modes)
    return contour.programmed_moves, contour.side
