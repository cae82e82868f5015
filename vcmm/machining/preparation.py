"""A cutting scenario made ready: program read and timed, tools swept, part placed; the surface that the program leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.cutting.envelope import BEYOND, CUT, CutSurface, surface_left
from vcmm.cutting.index import Index, build
from vcmm.cutting.sweeps import Sweep
from vcmm.machining.blank import Blank, cuts_turned, machined_blank
from vcmm.machining.blank import notes as blank_notes
from vcmm.machining.gauge import gauge_plan
from vcmm.machining.polish import polished
from vcmm.machining.rotary import Motion, point_of_part
from vcmm.machining.rows import Words
from vcmm.machining.scenario import CutScenario
from vcmm.machining.sweeps import part_sweep
from vcmm.machining.tool_errors import cutting_effects, needs_forces
from vcmm.machining.turned import Turning, turned_surface, turning_of, turns
from vcmm.machining.turned_blank import TurnedBlank, turned_blank
from vcmm.machining.turned_faces import with_faces
from vcmm.machining.wrong_unit import unit_hint
from vcmm.motion.toolpath import Toolpath, toolpath
from vcmm.nc.interpret import read_program
from vcmm.nc.moves import Program
from vcmm.nc.sensible import length_missing, without_length

DEPTH, HEIGHT = 0.5, 2.0  # mm, how far below and above nominal the surface is looked for
DEEPEST = 20.0  # mm, for points that are gouged deeper
CONTACTS = 6  # of one point: repeated passes tie
OF_TURNING = 16  # the same while rotary axes turn: rows beside each other find one contact
SPINDLE_ANGLE = "spindle_angle_rad"  # column of effects that follow the turning spindle
GOUGE = 0.01  # mm below nominal by the program alone


@dataclass(frozen=True, eq=False)
class Shop:
    """A scenario made ready: the program read, its motion in time, the tools swept, the part placed.

    motion: how the rows of the sweep lie on the moves where rotary axes stand off zero; None where all stay at zero.
    """

    scenario: CutScenario
    program: Program
    path: Toolpath
    sweep: Sweep
    index: Index
    pose: Pose
    machine: Machine
    blank: Blank | TurnedBlank | None
    turning: Turning | None = None  # on a lathe: sweep and index are those of the meridian then
    motion: Motion | None = None  # where rotary axes leave zero

    @property
    def seconds(self) -> float:
        return self.path.seconds


def set_up(scenario: CutScenario) -> Shop:
    """Read, time and sweep the program; place the part."""
    program = read_program(scenario.program, scenario.dialect, scenario.setup)
    if not program.moves:
        raise UsageError(f"{scenario.program}: the program has no motion; nothing is cut")
    _check_lengths(scenario, program)
    _check_forces(scenario, program)
    path = toolpath(program, scenario.machine, scenario.setup, step=scenario.step)
    _check_travels(scenario, path)
    shop = _placed(scenario, program, path)
    zero = _work_zero(scenario, program)
    if shop.turning is not None:
        return replace(shop, blank=turned_blank(scenario.setup, program, shop.turning, float(zero[2])))
    _check_runout(scenario)
    if shop.motion is not None:
        _check_fields(scenario, program, shop.motion)
    return replace(shop, blank=machined_blank(scenario.setup, program, shop.sweep, zero))


def _placed(scenario: CutScenario, program: Program, path: Toolpath) -> Shop:
    """The shop without a blank: tools swept, on a lathe in the meridian; the part placed."""
    zero = _work_zero(scenario, program)
    pose = scenario.pose or Pose(
        np.eye(3), zero
    )  # the drawing frame is the work coordinate system of the first cut
    if turns(scenario, program):
        turning = turning_of(scenario, program, path)
        index = build(turning.sweep)
        shop = Shop(scenario, program, path, turning.sweep, index, pose, scenario.machine, None, turning)
        return replace(shop, scenario=with_faces(scenario, pose, turning))
    sweep, motion = part_sweep(program.moves, scenario.setup.tools, scenario.machine)
    return Shop(scenario, program, path, sweep, build(sweep), pose, scenario.machine, None, motion=motion)


def other_unit(scenario: CutScenario) -> str:
    """What to add to the message about a program that misses the part, where it would hit it in the other unit."""
    return unit_hint(scenario, _hits)


def _hits(scenario: CutScenario, program: Program) -> tuple[int, int]:
    """(inspection points that the program cuts no more than DEPTH too deep, inspection points); travels are not checked."""
    path = toolpath(program, scenario.machine, scenario.setup, step=scenario.step)
    shop = _placed(scenario, program, path)
    steps = gauge_plan(shop.scenario.part, shop.scenario.plan).steps
    points, normals = (np.concatenate([getattr(s, name) for s in steps]) for name in ("points", "normals"))
    found = look(shop, points, normals, exact=False)
    hit = (found.status == CUT) & (np.nan_to_num(found.contact_s[:, 0], nan=-np.inf) >= -DEPTH)
    return int(hit.sum()), len(points)


def _check_fields(scenario: CutScenario, program: Program, motion: Motion) -> None:
    """Fields over workpiece axes are known with rotary axes at zero only."""
    fixed = [e.id for e in scenario.machine.effects if e.over_volume]
    if fixed:
        line = first_turned(program, motion)
        raise ModelLimit(
            f"{', '.join(fixed)}: a field over workpiece axes says nothing of a machine whose rotary axes stand off zero, as this "
            f"program's do (line {line}); leave it out, or state the errors of the axes instead"
        )


def _check_lengths(scenario: CutScenario, program: Program) -> None:
    """A tool whose length the program does not take into account would cut too deep by that length."""
    tools = scenario.setup.tools
    move = without_length(program.moves, tools)
    if move is not None:
        raise UsageError(length_missing(move, tools))


def _check_runout(scenario: CutScenario) -> None:
    """Of a tool that runs out the tooth that stands out most passes everywhere once per turn; a wave in time would be sampled."""
    waves = [e for e in scenario.machine.effects if SPINDLE_ANGLE in e.required()]
    if waves:
        raise UsageError(
            f"{waves[0].id}: while milling the tooth that stands out most leaves the surface, whatever its angle; write harmonic = 0 with the "
            "amplitude (feed marks, f^2 / 8R per turn, come on top). Waves per turn are for lathes and for diagnose"
        )


def _check_forces(scenario: CutScenario, program: Program) -> None:
    """Deflection needs forces, and they need to be told what is cut; beside rotary axes off zero none are computed."""
    bends = [e for e in scenario.machine.effects if needs_forces(e)]
    stated = scenario.setup.stock is not None or scenario.setup.bar is not None
    if bends and not (stated and scenario.setup.material is not None):
        raise UsageError(
            f"{bends[0].id} needs cutting forces: add [stock] with box (or bar) and material, and teeth to milling tools of the set-up, or leave "
            "the effect out"
        )
    line = cuts_turned(program)
    if bends and line and not turns(scenario, program):
        raise ModelLimit(
            f"{bends[0].id} needs cutting forces, but line {line} of the program cuts with a rotary axis off zero, where none are "
            "computed; leave out the effect, or stick_out and compliance of the tools where these bend them"
        )


def _check_travels(scenario: CutScenario, path: Toolpath) -> None:
    """The whole program stays within the travels, but for the way from where the machine happens to stand."""
    later = np.flatnonzero(path.move != path.timing.moving[0])
    for letter, axis in scenario.machine.axes.items():
        q, (low, high) = path.axes[letter][later], axis.travel
        bad = np.flatnonzero((q < low - 1e-6) | (q > high + 1e-6))
        if len(bad):
            line = path.columns["line"][later[bad[0]]]
            scale, unit = (180 / np.pi, "deg") if axis.rotary else (1.0, "mm")
            raise ModelLimit(
                f"line {line:.0f} of the program leaves the machine: axis {letter} = {q[bad[0]] * scale:.6g} {unit}, its travel is "
                f"{low * scale:.6g} to {high * scale:.6g} {unit}; check work offset and tool length{other_unit(scenario)}"
            )


def first_turned(program: Program, motion: Motion) -> int:
    """Line of the first move with a rotary axis off zero."""
    row = int(np.argmax(np.abs(motion.turned).max(axis=(1, 2)) > 0))
    return program.moves[int(motion.base.move[row])].source.line


def _work_zero(scenario: CutScenario, program: Program) -> Array:
    """Point of the part at the work offset of the first cut (3,), workpiece axes."""
    zero = np.array(scenario.setup.offsets.get(first_offset(program), (0.0, 0.0, 0.0)))
    first = next((m for m in program.moves if m.kind != "rapid"), program.moves[0])
    if not any(first.rotary_start):
        return zero
    return point_of_part(scenario.machine, zero, np.array(first.rotary_start))


def first_offset(program: Program) -> str:
    """The work offset of the first cut."""
    return next((m.offset for m in program.moves if m.kind != "rapid"), program.moves[0].offset)


def zeros(shop: Shop, names: Words) -> Array:
    """Where each work offset was set (k, 3): at the stated place, else at the work zero itself; workpiece axes."""
    scenario = shop.scenario
    if scenario.set_at is not None:
        return np.tile(np.array(scenario.set_at), (len(names), 1))
    return np.array([scenario.setup.offsets.get(str(name), (0.0, 0.0, 0.0)) for name in names], dtype=float)


def look(shop: Shop, points: Array, normals: Array, exact: bool = True) -> CutSurface:
    """The surface that the program leaves at points (n, 3) of the drawing, workpiece axes.

    exact=False: as the search sees it, turning tools in short rows of constant direction.
    """
    if shop.motion is None or not exact or not shop.motion.inexact.any():
        return _searched(shop, points, normals, CONTACTS)
    return polished(_searched(shop, points, normals, OF_TURNING), shop.motion, CONTACTS)


def _searched(shop: Shop, points: Array, normals: Array, contacts: int) -> CutSurface:
    at, out = shop.pose.apply(points), shop.pose.turn(normals)
    if shop.turning is not None:
        return turned_surface(shop.turning, at, out, DEPTH, DEEPEST, HEIGHT)
    found = _left(shop, at, out, DEPTH, contacts)
    deep = np.flatnonzero(found.status == BEYOND)
    if not len(deep):
        return found
    again = _left(shop, at[deep], out[deep], DEEPEST, contacts)
    names = ("status", "contact_s", "row", "t", "normal", "tests")
    merged = {name: getattr(found, name).copy() for name in names}
    for name in names:
        merged[name][deep] = getattr(again, name)
    return replace(found, **merged)


def _left(shop: Shop, points: Array, normals: Array, depth: float, contacts: int) -> CutSurface:
    try:
        return surface_left(points, normals, shop.index, depth, HEIGHT, candidates=contacts)
    except ModelLimit as error:
        if shop.motion is None or not shop.motion.inexact.any():
            raise
        lines = sorted(
            {shop.program.moves[i].source.line for i in shop.sweep.move[shop.motion.inexact].tolist()}
        )
        raise ModelLimit(
            f"a rotary axis turns while the tool is in the part, up to {depth:g} mm below the features; the moves that turn are "
            f"those of line {', '.join(map(str, lines[:10]))}{' ...' if len(lines) > 10 else ''}. Check from where it turns, the "
            f"work offset and the pose of the part ({error})"
        ) from None


def _unready(shop: Shop) -> list[str]:
    """The first cut with a spindle that stands still."""
    tools = shop.scenario.setup.tools
    for move in shop.program.moves:
        if move.kind in ("line", "arc") and move.tool in tools and not move.spindle:
            return [f"line {move.source.line} cuts while the spindle stands still"]
    return []


def remarks(shop: Shop) -> tuple[str, ...]:
    """What the program, the time law and the machine leave to be said."""
    program = [f"{shop.scenario.program.name}:{w.line}: {w.text}" for w in shop.program.warnings]
    idle = cutting_effects(shop.machine)[2]
    said = [f"{', '.join(idle)} act on measuring, not on cutting"] if idle else []
    assumed = (
        (f"assumed, as nothing is stated: {'; '.join(shop.path.assumptions)}",)
        if shop.path.assumptions
        else ()
    )
    turned = () if shop.turning is None else shop.turning.notes
    return (*program, *_unready(shop), *turned, *blank_notes(shop.blank), *said, *assumed)
