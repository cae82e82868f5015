"""Grooves that a lathe plunges: errors of width, place and floor, and their uncertainty.

A groove tool of the width w cuts one flank with its left corner, the other with its right one. The corner that the program leads
follows from the orientation of the insert: the lower one in Z (2, 3), the upper one (1, 4), or the middle of the edge (6, 8). With the error e
of the tool at its deepest place beside each flank (as the mean over a turn of the spindle) and its width wrong by d

    lower flank   e_z(lower) + c_1 d        c_1, c_2 = 0, 1 (lower corner led), -1, 0 (upper one), -1/2, 1/2 (the middle)
    upper flank   e_z(upper) + c_2 d
    width         upper - lower             place: the mean of both, along Z; floor: 2 e_x, mean of both

d is not known: the width of the set-up is taken, and `u_width` of [cut.tools] is its uncertainty. The flanks are taken to be straight
and square: rake, side clearance and the force of grooving are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.program.moves import Move
from vcmm.program.setup import FANUC_TIPS, LINUXCNC_TIPS, Tool
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.threads import ANGLES, asked_along, uncertainty_of

SAME_PLACE_MM = 1e-6  # mm
NORMALS = np.array(
    [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
)  # of the flanks, and of the floor


@dataclass(frozen=True)
class CutGroove:
    """One groove. lines: those that cut the lower and the upper flank; width and middle of it as programmed, work coordinates, mm.

    um unless named otherwise; U for k = 2; + is wider, further along +Z, a larger diameter.
    """

    lines: tuple[int, int]
    tool: int
    width_mm: float
    middle_mm: float
    width_um: float
    width_U_um: float
    middle_um: float
    middle_U_um: float
    diameter_um: float
    diameter_U_um: float


@dataclass(frozen=True)
class Flanks:
    """The moves (number, share) that are deepest beside the lower and the upper flank, and these flanks, machine axes, mm."""

    tool: Tool
    lower: tuple[int, float]
    upper: tuple[int, float]
    z: tuple[float, float]


def corners(tool: Tool, dialect: str) -> tuple[float, float]:
    """Return the share of the width by which the lower and the upper corner are off the point that is led, along Z."""
    tips = LINUXCNC_TIPS if dialect == "linuxcnc" else FANUC_TIPS
    side = tips.get(tool.orientation, (0, 0))[1]
    return (-0.5 - 0.5 * side, 0.5 - 0.5 * side)


def grooves_of(job: PreparedCut) -> tuple[CutGroove, ...]:
    """Return every groove that is plunged towards the axis by a tool with a width, in order."""
    return tuple(_cut_groove(job, flanks) for flanks in flanks_of(job))


def flanks_of(job: PreparedCut) -> list[Flanks]:
    """Group plunges side by side, with one tool, into grooves."""
    grooves: list[Flanks] = []
    tools = {n: t for n, t in job.scenario.setup.tools.items() if t.width}
    for k, m in enumerate(job.program.moves):
        tool = tools.get(m.tool)
        if tool is None or m.kind != "line" or m.work_spindle != job.scenario.work_spindle or not _plunges(m):
            continue
        low, high = (m.end[2] + c * (tool.width or 0.0) for c in corners(tool, job.program.dialect))
        here = Flanks(tool, (k, 1.0), (k, 1.0), (low, high))
        touching = next((i for i, flanks in enumerate(grooves) if _beside(flanks, here)), None)
        if touching is None:
            grooves.append(here)
        else:
            grooves[touching] = _together(grooves[touching], here)
    return grooves


def _plunges(m: Move) -> bool:
    """Return whether a move goes towards the axis, square to it."""
    return m.start[0] - m.end[0] > SAME_PLACE_MM and abs(m.end[2] - m.start[2]) < SAME_PLACE_MM


def _beside(flanks: Flanks, other: Flanks) -> bool:
    return (
        flanks.tool is other.tool
        and flanks.z[0] <= other.z[1] + SAME_PLACE_MM
        and other.z[0] <= flanks.z[1] + SAME_PLACE_MM
    )


def _together(flanks: Flanks, new: Flanks) -> Flanks:
    """Combine plunges; the later one counts where both are at one flank."""
    lower = new if new.z[0] <= flanks.z[0] + SAME_PLACE_MM else flanks
    upper = new if new.z[1] >= flanks.z[1] - SAME_PLACE_MM else flanks
    return Flanks(flanks.tool, lower.lower, upper.upper, (lower.z[0], upper.z[1]))


def _cut_groove(job: PreparedCut, flanks: Flanks) -> CutGroove:
    places = [flanks.lower, flanks.upper]
    move = np.tile(np.repeat([p[0] for p in places], ANGLES), 2).astype(np.intp)
    share = np.tile(np.repeat([p[1] for p in places], ANGLES), 2)
    side = asked_along(job, move, share, "groove", np.repeat(NORMALS, ANGLES, axis=0))
    side = replace(side, passes=_passes(side.run.n, move, flanks))
    operator = _operator(side.run.n)
    value = np.einsum("kni,ni->k", operator, side.errors())
    first, second = corners(flanks.tool, job.program.dialect)
    width = job.scenario.u_width.get(flanks.tool.number, 0.0)
    u = np.hypot(uncertainty_of(side, operator), width * np.array([1.0, 0.5 * (first + second), 0.0]))
    lines = tuple(job.program.moves[p[0]].source.line for p in places)
    zero = job.scenario.setup.offsets.get(job.program.moves[flanks.lower[0]].offset, (0.0, 0.0, 0.0))[2]
    return CutGroove(
        (lines[0], lines[1]), flanks.tool.number, flanks.z[1] - flanks.z[0], 0.5 * sum(flanks.z) - zero,
        *(float(v) for pair in zip(1e3 * value, 2e3 * u) for v in pair),
    )  # fmt: skip


def _passes(n: int, move: Ints, flanks: Flanks) -> Array:
    """Return the scatter of each plunge (n, 2), which shifts both flanks together along +Z, though they face one another."""
    out = np.zeros((n, 2))
    out[: len(move), 0] = move == flanks.lower[0]
    out[: len(move), 1] = (move == flanks.upper[0]) & (flanks.lower[0] != flanks.upper[0])
    out[ANGLES : 2 * ANGLES] *= -1.0
    return out


def _operator(n: int) -> Array:
    """Return the operator (3, n, 3) from the errors of n rows to width, place and diameter: the lower flank, the upper one, the floor
    beside either."""
    out = np.zeros((3, n, 3))
    lower, upper = slice(0, ANGLES), slice(ANGLES, 2 * ANGLES)
    out[0, lower, 2], out[0, upper, 2] = -1.0 / ANGLES, 1.0 / ANGLES
    out[1, lower, 2] = out[1, upper, 2] = 0.5 / ANGLES
    out[2, 2 * ANGLES : 4 * ANGLES, 0] = 1.0 / ANGLES
    return out
