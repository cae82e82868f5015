"""The blank: the material removed, the rapids that run through it, and the forces that follow from the engagement.

While the tool points along +Z of the workpiece, the stock is a map of heights (vcmm.shop.cutting.stock). A tool that comes from
another side makes undercuts, which heights cannot hold: then it is kept as rays along X, Y and Z (vcmm.shop.cutting.dexels).
Either is good to a few percent, which is what pictures and forces need. Deviations never come from it.

A shank or holder wider than the cutter does not cut: where it meets the remaining stock, a remark names the line.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.program.moves import Program
from vcmm.program.setup import LINEAR_EDGE, LinearEdge, Setup, kienzle, linear_edge
from vcmm.shop.cutting import tools as shapes
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.cutting.dexels import Dexels, both, carve
from vcmm.shop.cutting.force import (
    RADIAL,
    at_chip,
    mean_chip,
    milling_force,
    milling_power,
    to_workpiece,
)
from vcmm.shop.cutting.merging import merge_lines
from vcmm.shop.cutting.stock import Removal, Stock, block, remove
from vcmm.shop.cutting.sweeps import LINE, UP, Sweep, lengths, pieces, position
from vcmm.shop.cutting.tooth_force import ToothCuts
from vcmm.shop.machining.indexed_stock import indexed_removal
from vcmm.shop.machining.turned_blank import TurnedBlank
from vcmm.shop.motion.toolpath import CUTS

NODES = 600  # along the longer side, of a map of heights
RAYS = 100  # along the longest side, where rays are needed
ROUGH = 1 / 16  # of the way between rays, by which a row may miss a tool that turns
# of the radius of the tool, rad of an arc: spacing at which the engagement is sampled for forces
OFTEN = 0.5
TURNED = 0.125
TURN = 2.0 * np.pi
MOST_PIECES = 200_000
LEAST_REMOVED_SHARE = (
    1e-3  # of what the whole program removes: less is the difference between two bundles of rays
)


@dataclass(frozen=True, eq=False)
class PathPieces:
    """The rows of a sweep cut into stretches: sweep of the stretches, first (rows,) of each row and how many (rows,)."""

    sweep: Sweep
    first: Ints
    count: Ints

    def at(self, row: Ints, share: Array) -> tuple[Ints, Array]:
        """Return (stretch (k,), share of it (k,)) at shares of rows."""
        along = np.clip(share, 0.0, 1.0) * self.count[row]
        inside = np.minimum(along.astype(np.intp), self.count[row] - 1)
        return self.first[row] + inside, along - inside


@dataclass(frozen=True, eq=False)
class Blank:
    """after: the remaining stock; removed mm^3; collisions: (line, depth mm) of rapids through material; forces (pieces, 3) N or None.

    power (pieces,) W: the cutting power. pieces: the stretches of the path, each with its own engagement. shanks: (line, tool, depth mm) where a
    shank runs in the remaining stock. remarks: remarks on results that this stock cannot give.
    """

    before: Stock | Dexels
    after: Stock | Dexels
    removed_volume: float
    collisions: tuple[tuple[int, float], ...]
    forces: Array | None
    shanks: tuple[tuple[int, int, float], ...] = ()
    remarks: tuple[str, ...] = ()
    pieces: PathPieces | None = None
    power: Array | None = None
    teeth: ToothCuts | None = None  # of the stretches, where forces are known

    @property
    def kept_as(self) -> str:
        """Storage of the stock."""
        return "rays along X, Y and Z" if isinstance(self.after, Dexels) else "map of heights"


@dataclass(frozen=True, eq=False)
class BlankRequest:
    """Requests for a blank beside set-up and program. runout: mm by tool number; feed (rows,): mm/min of the tip over the part in each
    row of the sweep,
    None: F as programmed; rough: the sweep within some mm, for rays; None: the sweep itself."""

    runout: Mapping[int, float] = field(default_factory=dict)
    feed: Array | None = None
    rough: Callable[[float], Sweep] | None = None


def machined_blank(
    setup: Setup, program: Program, sweep: Sweep, zero: Array, asks: BlankRequest = BlankRequest()
) -> Blank | None:
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
    rapid = np.array([program.moves[i].kind == "rapid" for i in sweep.move.tolist()])
    if np.abs(sweep.axis - UP).max() > 1e-12:
        return _from_all_sides(setup, program, sweep, rapid, (low, low + size), asks)
    before = block(low, low + size, float(size[:2].max() / NODES))
    has_material = setup.material is not None
    stretches = along_path(sweep, has_material)
    removal = remove(before, stretches.sweep, np.repeat(rapid, stretches.count))
    deepest: dict[int, float] = {}
    for row, depth in zip(removal.collisions, removal.collision_depth):
        hit = program.moves[int(stretches.sweep.move[row])].source.line
        deepest[hit] = max(deepest.get(hit, 0.0), float(depth))
    forces, power, teeth = (
        cutting_forces(setup, program, stretches, removal, asks) if has_material else (None, None, None)
    )
    shanks = shank_collisions(setup, program, sweep, removal.stock)
    return Blank(
        before=before,
        after=removal.stock,
        removed_volume=float(removal.volume.sum()),
        collisions=tuple(deepest.items()),
        forces=forces,
        shanks=shanks,
        pieces=stretches,
        power=power,
        teeth=teeth,
    )


def along_path(sweep: Sweep, divided: bool) -> PathPieces:
    """Return the stretches of at most OFTEN of the tool's radius, and of an eighth of a radian of an arc; the rows themselves if not divided."""
    count = np.ones(len(sweep), dtype=np.intp)
    if divided:
        reach = np.array([t.radius for t in sweep.tools])[sweep.tool]
        length = np.where(sweep.kind == LINE, lengths(sweep) / (OFTEN * reach), np.abs(sweep.turn) / TURNED)
        count = np.maximum(np.ceil(length - 1e-9), 1).astype(np.intp)
        count = np.maximum(count // max(1, int(np.ceil(count.sum() / MOST_PIECES))), 1)
    parts, _, _, _ = pieces(sweep, count)
    return PathPieces(parts, np.cumsum(count) - count, count)


def first_turned_cut(program: Program) -> int:
    """Return the line of the first cut with a rotary axis off zero, 0 where there is none."""
    turned = (
        m.source.line for m in program.moves if m.kind in CUTS and any((*m.rotary_start, *m.rotary_end))
    )
    return next(turned, 0)


def _from_all_sides(
    setup: Setup,
    program: Program,
    sweep: Sweep,
    rapid: Array,
    corners: tuple[Array, Array],
    asks: BlankRequest,
) -> Blank:
    """Return the blank as rays along X, Y and Z. Material that rapids alone remove was not removed by a feed move, so they ran through material."""
    low, high = corners
    cell = float((high - low).max() / RAYS)
    rough = sweep if asks.rough is None else asks.rough(ROUGH * cell)
    fast = np.array([program.moves[i].kind == "rapid" for i in rough.move.tolist()], dtype=bool)
    if asks.rough is not None:
        rough = merge_lines(rough, np.logical_not(fast), ROUGH * cell)
        fast = np.array([program.moves[i].kind == "rapid" for i in rough.move.tolist()], dtype=bool)
    before = carve(low, high, cell, rough.take(np.zeros(0, np.intp)))
    feed = carve(low, high, cell, rough.take(np.flatnonzero(np.logical_not(fast))))
    after = both(feed, carve(low, high, cell, rough.take(np.flatnonzero(fast)))) if fast.any() else feed
    removed, through = _volume(before) - _volume(after), _volume(feed) - _volume(after)
    stretches = along_path(sweep, setup.material is not None)
    row = np.repeat(np.arange(len(sweep)), stretches.count)
    met = indexed_removal(low, high, sweep, rapid, (stretches.sweep, row)) if setup.material else None
    forces, power, teeth = (
        (None, None, None) if met is None else cutting_forces(setup, program, stretches, met, asks)
    )
    remarks = [
        f"the tool comes from several sides: the stock is kept as rays along X, Y and Z, {cell:.2g} mm apart; rapids are checked "
        "against what no feed move removes, shanks are not checked"
        + (", and no cutting forces are computed" if setup.material and met is None else "")
    ]
    if through > LEAST_REMOVED_SHARE * max(removed, 1.0):
        remarks.append(
            f"rapids run through the stock and remove {through:.3g} mm³ of it that no feed move would"
        )
    return Blank(
        before=before, after=after, removed_volume=removed, collisions=(), forces=forces, shanks=(), remarks=tuple(remarks),
        pieces=stretches, power=power, teeth=teeth,
    )  # fmt: skip


def _volume(stock: Dexels) -> float:
    """Return the volume in mm^3, mean of the three bundles of rays."""
    return float(np.mean([stock.volume(axis) for axis in range(3)]))


def shank_collisions(
    setup: Setup, program: Program, sweep: Sweep, left: Stock
) -> tuple[tuple[int, int, float], ...]:
    """Return (line, tool, depth mm) of lines whose shank or holder runs in the stock left by the whole program, deepest of their runs.

    The shank is a cylinder from the end of the cutting edges upwards. Material that a later move removes is not looked at.
    """
    moves = [program.moves[i] for i in sweep.move.tolist()]
    wide = [_shank(setup, m.tool) for m in moves]
    rows = np.flatnonzero([w is not None for w in wide])
    if not len(rows):
        return ()
    numbers = sorted({moves[i].tool for i in rows.tolist()})
    solids = [w for n in numbers if (w := _shank(setup, n)) is not None]
    which = np.array([numbers.index(moves[i].tool) for i in rows.tolist()])
    lift = np.array([solids[k][1] for k in which.tolist()])[:, None] * UP
    part = sweep.take(rows)
    raised = replace(
        part, start=part.start + lift, end=part.end + lift, centre=part.centre + lift, tool=which,
        tools=tuple(solid for solid, _ in solids),
    )  # fmt: skip
    removal = remove(left, raised, np.ones(len(rows), bool))
    hit = [moves[int(rows[k])] for k in removal.collisions.tolist()]
    deepest: dict[tuple[int, int], float] = {}
    for m, depth in zip(hit, removal.collision_depth.tolist()):
        place = (m.source.line, m.tool)
        deepest[place] = max(deepest.get(place, 0.0), depth)
    return tuple((line, tool, depth) for (line, tool), depth in deepest.items())


def _shank(setup: Setup, number: int) -> tuple[shapes.Cutter, float] | None:
    """Return (cylinder of the shank, height of its lower end over the tip in mm); None where no wider shank is stated."""
    tool = setup.tools.get(number)
    if tool is None or tool.shank_diameter is None or tool.cutting_length is None:
        return None
    wider = tool.shank_diameter > (tool.diameter or 0.0)
    return (shapes.flat(tool.shank_diameter / 2), tool.cutting_length) if wider else None


def cutting_forces(
    setup: Setup,
    program: Program,
    stretches: PathPieces,
    removal: Removal,
    asks: BlankRequest = BlankRequest(),
) -> tuple[Array, Array, ToothCuts]:
    """Return, while each stretch is cut, the mean force of the part on the tool (rows, 3) N, workpiece axes, power (rows,) W, and the cuts of each
    tooth."""
    sweep = stretches.sweep
    moves = [program.moves[i] for i in sweep.move.tolist()]
    teeth = np.array([setup.tools[m.tool].teeth or 0 for m in moves])
    missing = sorted({m.tool for m, z in zip(moves, teeth) if z == 0 and m.kind != "rapid"})
    if missing:
        raise UsageError(
            f"forces need the number of teeth: add teeth = 3 to [tools.{missing[0]}] of the set-up, or leave material out"
        )
    turning = np.array([abs(m.spindle) for m in moves])
    feed = np.array([m.feed or 0.0 for m in moves])
    if asks.feed is not None:
        feed = np.where(feed > 0.0, np.repeat(asks.feed, stretches.count), 0.0)
    chip = np.divide(feed, turning * teeth, out=np.zeros(len(feed)), where=turning * teeth > 0)
    at_work = (removal.volume > 0) & (feed > 0)
    material = _edges(setup, mean_chip(removal.enter, removal.leave, chip))
    axial = np.where(at_work, removal.axial, 0.0)
    radius = np.array([t.radius for t in sweep.tools])[sweep.tool]
    speed = radius * 1e-3 * turning * TURN / 60.0
    power = milling_power(removal.enter, removal.leave, axial, chip, teeth=teeth, speed=speed, of=material)
    helix = np.array([np.nan if (h := setup.tools[m.tool].helix) is None else h for m in moves], dtype=float)
    cuts = ToothCuts(
        start=removal.enter, exit=removal.leave, axial=axial, chip=chip, teeth=teeth, lag=np.tan(helix) / radius, edges=material,
        runout=np.array([asks.runout.get(m.tool, 0.0) for m in moves]),
    )  # fmt: skip
    force = (
        cuts.mean()
        if cuts.runs_out
        else milling_force(removal.enter, removal.leave, axial, chip, teeth, material)
    )
    middle = position(sweep, np.array([[0.49], [0.51]]))
    way = middle[1] - middle[0]
    length = np.linalg.norm(way, axis=1)
    return to_workpiece(force, way / np.where(length > 0, length, 1.0)[:, None], sweep.axis), power, cuts


def _edges(setup: Setup, chip: Array) -> LinearEdge:
    """Return the edge coefficients of the material, those of Kienzle's law at the mean chip (rows,) of each move."""
    name = str(setup.material)
    if name in LINEAR_EDGE:
        return linear_edge(name)
    return at_chip(kienzle(name), chip, RADIAL if setup.thrust is None else setup.thrust)


def notes(blank: Blank | TurnedBlank | None) -> list[str]:
    """Return the remarks on the blank: collisions, and a program that misses it."""
    if blank is None:
        return []
    out = [
        f"line {line}: a rapid runs through the stock, {depth:.2f} mm deep; the tool or the part would break"
        for line, depth in blank.collisions[:5]
    ]
    if len(blank.collisions) > 5:
        out.append(f"{len(blank.collisions) - 5} more rapids run through the stock")
    for line, tool, depth in blank.shanks[:5]:
        out.append(
            f"line {line}: the shank of tool {tool} runs {depth:.2f} mm deep in the remaining stock; take a longer or "
            "slimmer tool"
        )
    if len(blank.shanks) > 5:
        out.append(f"{len(blank.shanks) - 5} more moves run their shank through the stock")
    out += blank.remarks
    if blank.removed_volume == 0.0:
        out.append("the program does not touch the stock; check the work offset and the place of the stock")
    return out
