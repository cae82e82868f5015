"""A turned part: the program seen in the meridian half plane, and the surface that the passes of the nose leave there.

What cuts the section at the angle phi are not the swept moves but the circles of the nose at the times at which the tool
passes phi, one per turn (vcmm.shop.machining.spindle): feed marks, their phase and what depends on the angle of the spindle come
from that. The swept moves only say where to look, and where nothing was cut.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.moves import Move, Program
from vcmm.program.setup import FANUC_TIPS, LINUXCNC_TIPS, Tool
from vcmm.shop.cutting import nose
from vcmm.shop.cutting.envelope import BEYOND, CUT, UNCUT, CutSurface
from vcmm.shop.cutting.sweeps import Sweep
from vcmm.shop.cutting.turning import OUTWARD, meridian
from vcmm.shop.machining.program_sweep import sweep_of_moves
from vcmm.shop.machining.spindle import TURN, Spindle, moves_at, spindle_of
from vcmm.shop.machining.states import seconds_at
from vcmm.shop.motion.toolpath import Toolpath
from vcmm.task.measuring.cut_scenario import CutScenario

SEEDS, EACH = 4, 2  # moves whose passes are evaluated, passes before and after the place of contact
MOST_PASSES = 6  # passes that may cut a point
BAND = 0.05  # mm: a pass that leaves more above the deepest is no candidate
FLAT = 1e-6  # mm, of the tip from the plane of the spindle
CRASH = 0.01  # mm: a rapid that runs deeper through the part is seen on all sides of it
Ints = np.typing.NDArray[np.intp]
Bools = np.typing.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Turning:
    """sweep: in the plane (radius, 0, z); to_tip (rows, 2): from the centre of the nose to the imaginary tip, in noses.

    centre (2,): x and y of the spindle axis, workpiece axes; row_of: sweep row of each move, -1 = none; rapid (rows,).
    rotary: whether the machine has the spindle as its axis C. lowest: smallest position of C that is shown, rad.
    """

    sweep: Sweep
    to_tip: Array
    paths: nose.Capsules
    centre: Array
    row_of: Ints
    rapid: Bools
    spindle: Spindle
    path: Toolpath
    rotary: bool
    lowest: float
    notes: tuple[str, ...]

    def section(self, points: Array, normals: Array) -> tuple[Array, Array, Array]:
        """Return the points and normals (n, 3) of the workpiece turned into the plane y = 0, and their angles (n,), 0 to 2 pi."""
        arm = points - np.array([*self.centre, 0.0])
        phi = np.mod(np.arctan2(arm[:, 1], arm[:, 0]), TURN)
        middle = np.hypot(arm[:, 0], arm[:, 1]) == 0.0
        across = np.arctan2(normals[:, 1], normals[:, 0])
        flat_points, flat_normals = meridian(arm, normals)
        return flat_points, flat_normals, np.where(middle, np.mod(across, TURN), phi)

    def position_c(self, phi: Array) -> Array:
        """Return the position of axis C at which the tool passes phi, within its travel where that is a turn wide."""
        return self.lowest + np.mod(phi - self.lowest, TURN)


@dataclass(frozen=True, eq=False)
class TurnedSurface(CutSurface):
    """The surface at n points of the workpiece: contacts are passes of the nose.

    flat, flat_normals (n, 3): the points in the plane of their section; phi (n,); time (n, K) s of each pass.
    normal (n, K, 3) is that of the swept nose beside the pass, out of the tool, in the plane of the section: over all phases
    of the spindle a small error moves the surface as it moves the swept nose, while the feed marks just move along.
    """

    flat: Array
    flat_normals: Array
    phi: Array
    time: Array


def turning_of(scenario: CutScenario, program: Program, path: Toolpath) -> Turning:
    """Return the program in the meridian. Raises UsageError and ModelLimit for what cannot be turned."""
    tools = {n: t for n, t in scenario.setup.tools.items() if t.shape == "turning"}
    driven = [n for n, t in scenario.setup.tools.items() if t.driven is not None]
    spindle = scenario.work_spindle
    kept, notes = _cutting_moves(program, tools, driven, int(path.timing.moving[0]), spindle)
    notes += in_other_spindles(program, spindle)
    flat = sweep_of_moves([program.moves[i] for i in kept], tools)
    sweep = replace(flat, move=np.array(kept, dtype=np.intp)[flat.move])
    centre, machine = spindle_axis(scenario.machine), scenario.machine
    moves = [program.moves[i] for i in sweep.move.tolist()]
    _check_moves(moves, centre)
    tips = LINUXCNC_TIPS if program.dialect == "linuxcnc" else FANUC_TIPS
    to_tip = np.array([tips.get(tools[m.tool].orientation, (0, 0)) for m in moves], dtype=float)
    sweep = _in_meridian(sweep, to_tip, centre)
    row_of = np.full(len(program.moves), -1, dtype=np.intp)
    row_of[sweep.move] = np.arange(len(sweep))
    rapid = np.array([m.kind == "rapid" for m in moves], dtype=bool)
    low, high = machine.axes["C"].travel if "C" in machine.axes else (0.0, TURN)
    lowest = 0.0 if low <= 0.0 and high >= TURN - 1e-9 else low
    return Turning(
        sweep=sweep,
        to_tip=to_tip,
        paths=nose.capsules(sweep),
        centre=centre,
        row_of=row_of,
        rapid=rapid,
        spindle=spindle_of(path),
        path=path,
        rotary="C" in machine.chain.work,
        lowest=lowest,
        notes=tuple(notes),
    )


def spindle_axis(machine: Machine) -> Array:
    """Return x and y of the axis of the spindle (2,), machine frame: the centre of axis C, else the origin."""
    if "C" in machine.chain.tool:
        raise ModelLimit(
            f"structure {machine.chain.structure}: axis C carries the tool; a lathe has its spindle on the workpiece side, for "
            'example "w C\' b Z X t"'
        )
    return np.array(machine.axes["C"].centre[:2]) if "C" in machine.axes else np.zeros(2)


def _cutting_moves(
    program: Program, tools: dict[int, Tool], driven: Collection[int], first: int, spindle: int
) -> tuple[list[int], list[str]]:
    """Return the moves whose nose is followed, and remarks on the others; not the way from the unknown start position."""
    kept: list[int] = []
    threads: list[int] = []
    others: dict[int, int] = {}
    for i, m in enumerate(program.moves):
        if (i == first and m.kind == "rapid") or m.work_spindle != spindle:
            continue
        if m.kind == "thread":
            threads.append(m.source.line)
        elif m.kind == "rapid" and i and program.moves[i - 1].kind == "thread":
            continue  # out of a groove that is not cut into the surface
        elif m.tool in tools:
            kept.append(i)
        elif m.kind in ("line", "arc") and m.tool not in driven:
            others.setdefault(m.tool, m.source.line)
    notes = []
    if threads:
        notes.append(
            f"line {threads[0]}: threads are not cut into the surface, as their form is that of the flanks of the insert; pitch and diameter stand in a table of their own"
        )
    notes += [
        f'line {line}: tool {n} is no turning tool; what it cuts is left out of the surface. A tool with its own spindle gets driven = "x" or "z"'
        for n, line in others.items()
    ]
    return kept, notes


def in_other_spindles(program: Program, spindle: int) -> list[str]:
    """Return the remarks on the cuts on parts in other spindles."""
    lines: dict[int, list[int]] = {}
    for m in program.moves:
        if m.work_spindle != spindle and m.kind not in ("rapid", "dwell"):
            lines.setdefault(m.work_spindle, []).append(m.source.line)
    return [
        f"lines {min(at)} to {max(at)}: {len(at)} moves cut the part in spindle {n} and are left out; work_spindle = {n} in [cut], with the machine as it "
        "stands to that spindle, cuts them"
        for n, at in lines.items()
    ]


def _check_moves(moves: list[Move], centre: Array) -> None:
    """Check that a nose that cuts is in the plane of the spindle axis, beside the axis, while the spindle turns."""
    for m in moves:
        if m.kind == "rapid":
            continue
        line = m.source.line
        if not m.spindle:
            raise UsageError(
                f"line {line} turns the part while the spindle does not turn; add M3 S... (or G96) before it"
            )
        if m.plane != "ZX" and m.centre is not None:
            raise ModelLimit(
                f"line {line}: an arc of a turning tool lies in the plane ZX (G18), not {m.plane}"
            )
        if max(abs(p[1] - centre[1]) for p in (m.start, m.end)) > FLAT:
            raise ModelLimit(
                f"line {line}: the tip is {m.end[1] - centre[1]:.6g} mm beside the plane of the spindle axis; turning is "
                "computed at centre height. Leave offset_y of the tool out and state its height as u_offset_y or by the effect "
                "tool_offset"
            )
        if max(p[0] for p in (m.start, m.end)) - centre[0] < -5.0:
            raise ModelLimit(
                f"line {line} turns beyond the spindle axis (X {2 * (m.end[0] - centre[0]):.6g} as a diameter); the tool is taken to "
                "stand on the side of +X"
            )


def _in_meridian(sweep: Sweep, to_tip: Array, centre: Array) -> Sweep:
    """Return the path of the tip as that of the nose: its point nearest to the axis, spindle axis at radius zero."""
    r = nose.nose_radius(sweep)
    shift = np.zeros((len(sweep), 3))
    shift[:, 0], shift[:, 2] = -to_tip[:, 0] * r - r - centre[0], -to_tip[:, 1] * r
    flat = {n: getattr(sweep, n) + shift for n in ("start", "end", "centre")}
    for name in flat:
        flat[name][:, 1] = np.where(np.isfinite(flat[name][:, 1]), 0.0, np.nan)
    axis = np.broadcast_to(OUTWARD, sweep.start.shape).copy()
    return replace(sweep, **flat, axis=axis)


def turned_surface(
    turning: Turning, points: Array, normals: Array, depth: float, deepest: float, height: float
) -> TurnedSurface:
    """Return the surface at points of the workpiece (n, 3): by swept moves first, then pass by pass."""
    flat, out, phi = turning.section(points, normals)
    seeds = nose.removed_by(
        flat, out, path=turning.paths, depth=depth, height=height, band=0.1, candidates=SEEDS
    )
    deep = np.flatnonzero(seeds.status == BEYOND)
    if len(deep):
        again = nose.removed_by(
            flat[deep],
            out[deep],
            path=turning.paths,
            depth=deepest,
            height=height,
            band=0.1,
            candidates=SEEDS,
        )
        for name in ("status", "contact_s", "row", "t"):
            getattr(seeds, name)[deep] = getattr(again, name)
    times, swept_normal = _passes(turning, seeds, phi, EACH)
    passes = passes_at(turning, times, flat, out)
    order = passes.order()[:, :MOST_PASSES]
    passes = passes.take(order)
    time, row, t = passes.time, passes.row, passes.t
    s = np.where(passes.height > height, np.inf, passes.height)
    good = np.isfinite(s) & (s <= s[:, :1] + BAND)
    status = np.where(seeds.status == BEYOND, BEYOND, np.where(good[:, 0], CUT, UNCUT))
    return TurnedSurface(
        points=points,
        normals=normals,
        status=status,
        contact_s=np.where(good, s, np.nan),
        row=np.where(good, row, -1),
        t=np.where(good, t, np.nan),
        normal=np.take_along_axis(swept_normal, order[..., None], 1),
        tests=seeds.tests,
        flat=flat,
        flat_normals=out,
        phi=phi,
        time=np.where(good, time, np.nan),
    )


def _passes(turning: Turning, seeds: CutSurface, phi: Array, each: int) -> tuple[Array, Array]:
    """Return the times (n, Q) of the passes around every contact of the swept moves, nan where there is none, and the normals there."""
    count, k = seeds.row.shape
    point, seed = np.nonzero(seeds.row >= 0)
    row, t = seeds.row[point, seed], seeds.t[point, seed]
    when = seconds_at(turning.path.timing, turning.sweep.move[row], t)
    times = np.full((count, k, 2 * each + 1), np.nan)
    times[point, seed, : 2 * each] = turning.spindle.passes(when, phi[point], each)
    crash = turning.rapid[row] & (seeds.contact_s[point, seed] < -CRASH)
    times[point[crash], seed[crash], -1] = when[crash]
    normal: Array = np.broadcast_to(seeds.normals[:, None, :], (count, k, 3)).copy()
    contact = seeds.points[point] + seeds.contact_s[point, seed][:, None] * seeds.normals[point]
    arm = contact[:, [0, 2]] - nose.noses(turning.sweep, row, t)
    normal[point, seed] = _unit(arm)
    each_normal = np.repeat(normal, 2 * each + 1, axis=1)
    flat = times.reshape(count, -1)
    order = np.argsort(flat, axis=1)
    flat = np.take_along_axis(flat, order, 1)
    flat[:, 1:][np.diff(flat, axis=1) < 1e-9] = np.nan  # one pass found from two moves
    return flat, np.take_along_axis(each_normal, order[..., None], 1)


def _unit(arm: Array) -> Array:
    """Return vectors (n, 2) of the section as unit vectors (n, 3)."""
    size = np.hypot(arm[:, 0], arm[:, 1])
    flat = arm / np.where(size > 0, size, 1.0)[:, None]
    return np.stack([flat[:, 0], np.zeros(len(flat)), flat[:, 1]], axis=1)


@dataclass(frozen=True, eq=False)
class Passes:
    """Of n points, Q passes each: time s, row of the sweep (-1 = none) and share of it, height mm (inf = misses); (n, Q)."""

    time: Array
    row: Ints
    t: Array
    height: Array

    def order(self) -> Ints:
        """Return the order of the passes, the deepest first (n, Q)."""
        return np.argsort(self.height, axis=1)

    def take(self, order: Ints) -> Passes:
        return Passes(
            np.take_along_axis(self.time, order, 1),
            np.take_along_axis(self.row, order, 1),
            np.take_along_axis(self.t, order, 1),
            np.take_along_axis(self.height, order, 1),
        )


def passes_at(turning: Turning, times: Array, points: Array, normals: Array) -> Passes:
    """Return where rays from flat points (n, 3) meet the nose at times (n, Q), nan = none."""
    row = np.full(times.shape, -1, dtype=np.intp)
    t, s = np.zeros(times.shape), np.full(times.shape, np.inf)
    point, at = np.nonzero(np.isfinite(times))
    move, share = moves_at(turning.path.timing, times[point, at])
    rows = turning.row_of[move]
    there = rows >= 0
    point, at, rows, share = point[there], at[there], rows[there], share[there]
    o = points[point][:, [0, 2]] - nose.noses(turning.sweep, rows, share)
    row[point, at], t[point, at] = rows, share
    s[point, at] = nose.entry(o, normals[point][:, [0, 2]], nose.nose_radius(turning.sweep)[rows])
    return Passes(times, row, t, s)


def backs(turning: Turning, surface: TurnedSurface, features: np.typing.NDArray[np.str_]) -> list[str]:
    """Return remarks on features that the nose would have to cut with its back: further than 75 deg from where its tip points."""
    row = surface.row[:, 0]
    tip = turning.to_tip[np.maximum(row, 0)]
    size = np.hypot(tip[:, 0], tip[:, 1])
    facing = -(tip * surface.flat_normals[:, [0, 2]]).sum(axis=1) / np.where(size > 0, size, 1.0)
    bad = (row >= 0) & (size > 0) & (facing < np.cos(np.radians(75.0)))
    remarks = []
    for name in dict.fromkeys(features[bad].tolist()):
        number = int(turning.sweep.move[row[np.flatnonzero(bad & (features == name))[0]]])
        line = turning.path.timing.moves[number].source.line
        remarks.append(
            f"{name}: line {line} cuts it with the back of the nose, more than 75 deg from where the tip points; flanks are not "
            "modelled, check the orientation of the tool"
        )
    return remarks
