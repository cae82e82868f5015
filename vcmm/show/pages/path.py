"""The path of a program with the errors of the machine along it: as programmed, and after compensation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.compensation.field import field_of, known_errors_of
from vcmm.compensation.path_deviations import FollowedPath, follow_path
from vcmm.compensation.proof import errors_on, walk
from vcmm.core.errors import ModelLimit
from vcmm.program.reading import read_bytes
from vcmm.program.setup import turns_with
from vcmm.shop.machining.preparation import set_up
from vcmm.show.pages.header import facts, files_block
from vcmm.show.report import blocks as r
from vcmm.show.report.path import PathPicture, path_picture
from vcmm.show.tables.answers_machine import compensation_answers
from vcmm.show.tables.compensation import before_and_after, departures, shifts
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from vcmm.compensation.result import CompensatedProgram
    from vcmm.shop.machining.proof import CutProof
    from vcmm.task.measuring.cut_scenario import CutScenario

MOST_LISTED = 4000  # lines of a program beside its path
MOST_PIECES = 40_000  # pieces of a picture, about 2 MB


def compensation_page(result: CompensatedProgram, program: Path, proof: CutProof | None = None) -> str:
    """Return one self-contained HTML file; the result holds its paths. program: the file, for the lines under the pointer; proof: by a cut."""
    assert result.paths is not None
    text = _lines(program)
    both = [_picture(path, text, name) for path, name in zip(result.paths, ("as programmed", "compensated"))]
    caption = (
        "Distance of the tool from the programmed path, with the errors that are corrected; rapids dashed."
        + _rest(result.paths)
    )
    blocks = [
        r.heading("Before and after"),
        html(departures(result, before_and_after(result))),
        html(shifts(result)),
    ]
    blocks += [r.heading("Along the program"), path_picture(*both, caption=caption)]
    blocks += [*r.notices(result.warnings), *files_block([program])]
    return r.page(
        f"Compensation report: {result.name}",
        blocks,
        footer=f"vcmm {__version__}, hash {result.digest}",
        answers=compensation_answers(result, proof),
        facts=facts(
            "",
            result.machine,
            None,
            None,
            [("control", result.dialect), ("hash of the new program", result.digest)],
        ),
    )


def cut_path(scenario: CutScenario) -> str:
    """Return the program of a cut, coloured by the known error of the tool tip (drives included), by feed or tool; or why there is no picture."""
    try:
        path = _of_cut(scenario)
    except ModelLimit as why:
        return r.note(f"The path is not drawn with its errors: {why}")
    caption = (
        "Size of the known error of the tool tip, less that where the work offset was set; repeatability and what cutting adds "
        "are not in it. Rapids dashed." + _rest([path])
    )
    return path_picture(_picture(path, _lines(scenario.program)), caption=caption)


def _of_cut(scenario: CutScenario) -> FollowedPath:
    program = set_up(scenario).program
    lathe = turns_with(scenario.setup, program)
    field = field_of(
        known_errors_of(scenario.machine).whole(), scenario.setup, program.moves, set_here=scenario.set_here,
        constants=scenario.constants, lathe=lathe,
    )  # fmt: skip
    field = replace(field, by_axes=True)
    w = walk(program.moves)
    return follow_path(program.moves, w.move, w.tip, np.linalg.norm(errors_on(field, w), axis=1))


def _rest(paths: Sequence[FollowedPath]) -> str:
    """Return the sentence about moves that are not drawn."""
    most = max(len(p.move) for p in paths)
    return f" The first {MOST_PIECES} of {most} pieces." if most > MOST_PIECES else ""


def _lines(file: Path) -> list[str]:
    return read_bytes(file).splitlines()


def _lines_to_list(moving: Sequence[int], count: int) -> Sequence[int]:
    """Return the numbers of the lines beside the picture: all of them, or of a long program those that move."""
    return range(1, count + 1) if count <= MOST_LISTED else [n for n in sorted(set(moving)) if 0 < n <= count]


def _picture(path: FollowedPath, text: Sequence[str], name: str = "") -> PathPicture:
    move, line = path.move[:MOST_PIECES].tolist(), path.line[:MOST_PIECES].tolist()
    moves = [path.moves[i] for i in move]
    at = path.points[: len(move) + 1]
    return PathPicture(
        points=[tuple(p) for p in at.tolist()], line=line, tool=[m.tool for m in moves],
        feed=[None if m.feed is None else round(m.feed, 3) for m in moves], rapid=[m.kind == "rapid" for m in moves],
        error=[None if np.isnan(e) else 1e3 * e for e in path.error[:MOST_PIECES].tolist()],
        text={n: text[n - 1].strip()[:100] for n in _lines_to_list(line, len(text))},
        view="lathe" if np.ptp(at[:, 1]) < 1e-9 else "space", name=name,
    )  # fmt: skip
