"""The blank: what of it is removed, which rapids run through it, and the forces that follow from the engagement.

The stock is a map of heights (vcmm.cutting.stock): good to a few percent, which is what pictures and forces need.
Deviations never come from it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.cutting.force import linear_edge, milling_force, to_workpiece
from vcmm.cutting.stock import Removal, Stock, block, remove
from vcmm.cutting.sweeps import UP, Sweep, position
from vcmm.errors import UsageError
from vcmm.nc.moves import Program
from vcmm.nc.setup import Setup
from vcmm.run import Array

NODES = 600  # along the longer side


@dataclass(frozen=True, eq=False)
class Blank:
    """before and after; removed mm^3; collisions: (line, depth mm) of rapids through material; forces (rows, 3) N or None."""

    before: Stock
    after: Stock
    removed: float
    collisions: tuple[tuple[int, float], ...]
    forces: Array | None
    left_out: int = 0  # moves whose tool does not point along Z of the workpiece


def machined_blank(setup: Setup, program: Program, sweep: Sweep, zero: Array) -> Blank | None:
    """Cut the blank of a set-up with all moves; None where no stock is stated. zero (3,): work zero, workpiece axes."""
    if setup.stock is None:
        return None
    size = np.array(setup.stock)
    corner = (
        np.array([-size[0] / 2, -size[1] / 2, -size[2]])
        if setup.stock_corner is None
        else np.array(setup.stock_corner)
    )
    low = zero + corner
    before = block(low, low + size, float(size[:2].max() / NODES))
    upright = np.flatnonzero(np.abs(sweep.axis - UP).max(axis=1) < 1e-12)
    tilted = len(set(sweep.move.tolist()) - set(sweep.move[upright].tolist()))
    if not len(upright):
        return Blank(before, before, 0.0, (), None, tilted)
    sweep = sweep if not tilted else sweep.take(upright)
    rapid = np.array([program.moves[i].kind == "rapid" for i in sweep.move.tolist()])
    removal = remove(before, sweep, rapid)
    lines = [program.moves[int(sweep.move[row])].source.line for row in removal.collisions]
    hits = tuple(zip(lines, (float(d) for d in removal.collision_depth)))
    forces = None if setup.material is None or tilted else cutting_forces(setup, program, sweep, removal)
    return Blank(before, removal.stock, float(removal.volume.sum()), hits, forces, tilted)


def cutting_forces(setup: Setup, program: Program, sweep: Sweep, removal: Removal) -> Array:
    """Mean force of the part on the tool (rows, 3) N, workpiece axes, while each row of the sweep cuts."""
    material = linear_edge(str(setup.material))
    moves = [program.moves[i] for i in sweep.move.tolist()]
    teeth = np.array([setup.tools[m.tool].teeth or 0 for m in moves])
    missing = sorted({m.tool for m, z in zip(moves, teeth) if z == 0 and m.kind != "rapid"})
    if missing:
        raise UsageError(
            f"forces need the number of teeth: add teeth = 3 to [tools.{missing[0]}] of the set-up, or leave material out"
        )
    turning = np.array([abs(m.spindle) for m in moves])
    feed = np.array([m.feed or 0.0 for m in moves])
    chip = np.divide(feed, turning * teeth, out=np.zeros(len(feed)), where=turning * teeth > 0)
    at_work = (removal.volume > 0) & (feed > 0)
    force = milling_force(
        removal.enter, removal.leave, np.where(at_work, removal.axial, 0.0), chip, teeth, material
    )
    middle = position(sweep, np.array([[0.49], [0.51]]))
    way = middle[1] - middle[0]
    length = np.linalg.norm(way, axis=1)
    return to_workpiece(force, way / np.where(length > 0, length, 1.0)[:, None], sweep.axis)


def notes(blank: Blank | None) -> list[str]:
    """What the blank has to say: collisions, and a program that misses it."""
    if blank is None:
        return []
    out = [
        f"line {line}: a rapid runs through the stock, {depth:.2f} mm deep; the tool or the part would break"
        for line, depth in blank.collisions[:5]
    ]
    if blank.left_out:
        out.append(
            f"the stock is a map of heights along Z of the workpiece: {blank.left_out} moves with the tool turned away from it are "
            "missing in its picture, its volume and the search for rapids through material, and no cutting forces are computed"
        )
    if len(blank.collisions) > 5:
        out.append(f"{len(blank.collisions) - 5} more rapids run through the stock")
    if blank.removed == 0.0 and not blank.left_out:
        out.append("the program does not touch the stock; check the work offset and the place of the stock")
    return out
