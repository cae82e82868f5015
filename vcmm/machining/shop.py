"""A cutting scenario made ready: program read and timed, tools swept, part placed; the surface that the program leaves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.cutting.envelope import BEYOND, CutSurface, surface_left
from vcmm.cutting.index import Index, build
from vcmm.cutting.sweeps import Sweep
from vcmm.errors import ModelLimit, UsageError
from vcmm.machine import Machine
from vcmm.machining.blank import Blank, machined_blank
from vcmm.machining.blank import notes as blank_notes
from vcmm.machining.rows import Words
from vcmm.machining.scenario import CutScenario
from vcmm.machining.sweeps import swept
from vcmm.machining.toolside import cutting_effects
from vcmm.machining.turned import Turning, turned_surface, turning_of, turns
from vcmm.machining.turned_blank import TurnedBlank, turned_blank
from vcmm.machining.turned_faces import with_faces
from vcmm.machining.wrong_unit import unit_hint
from vcmm.nc.interpret import read_program
from vcmm.nc.moves import Program
from vcmm.nc.toolpath import Toolpath, toolpath
from vcmm.pose import Pose
from vcmm.run import Array

DEPTH, HEIGHT = 0.5, 2.0  # mm, how far below and above nominal the surface is looked for
DEEPEST = 20.0  # mm, for points that are gouged deeper
CONTACTS = 6  # of one point: repeated passes tie
GOUGE = 0.01  # mm below nominal by the program alone


@dataclass(frozen=True, eq=False)
class Shop:
    """A scenario made ready: the program read, its motion in time, the tools swept, the part placed."""

    scenario: CutScenario
    program: Program
    path: Toolpath
    sweep: Sweep
    index: Index
    pose: Pose
    machine: Machine
    blank: Blank | TurnedBlank | None
    turning: Turning | None = None  # on a lathe: sweep and index are those of the meridian then

    @property
    def seconds(self) -> float:
        return self.path.seconds


def set_up(scenario: CutScenario) -> Shop:
    """Read, time and sweep the program; place the part."""
    program = read_program(scenario.program, scenario.dialect, scenario.setup)
    if not program.moves:
        raise UsageError(f"{scenario.program}: the program has no motion; nothing is cut")
    _check_lengths(scenario, program)
    _check_forces(scenario)
    path = toolpath(program, scenario.machine, scenario.setup, step=scenario.step)
    _check_travels(scenario, path)
    zero = _work_zero(scenario, program)
    if turns(scenario, program):
        return _set_up_to_turn(scenario, program, path, zero)
    sweep = swept(program.moves, scenario.setup.tools)
    blank = machined_blank(scenario.setup, program, sweep, zero)
    pose = scenario.pose or Pose(
        np.eye(3), zero
    )  # the drawing frame is the work coordinate system of the first cut
    return Shop(scenario, program, path, sweep, build(sweep), pose, scenario.machine, blank)


def _set_up_to_turn(scenario: CutScenario, program: Program, path: Toolpath, zero: Array) -> Shop:
    """The same for a lathe: everything in the meridian."""
    turning = turning_of(scenario, program, path)
    pose = scenario.pose or Pose(np.eye(3), zero)
    blank = turned_blank(scenario.setup, program, turning, float(zero[2]))
    shop = Shop(
        scenario, program, path, turning.sweep, build(turning.sweep), pose, scenario.machine, blank, turning
    )
    return replace(shop, scenario=with_faces(scenario, pose, turning))


def _check_lengths(scenario: CutScenario, program: Program) -> None:
    """A tool whose length the program does not take into account would cut too deep by that length."""
    tools = scenario.setup.tools
    for move in program.moves:
        cuts = move.kind in ("line", "arc") and move.tool in tools and tools[move.tool].shape != "turning"
        if cuts and tools[move.tool].length and not any(move.tool_offset):
            raise UsageError(
                f"line {move.source.line} of the program cuts with tool {move.tool} while no tool length is in force: the tool "
                f'would cut {tools[move.tool].length:g} mm too deep; add G43 H{move.tool}, or state length = "0 mm" in '
                f"[tools.{move.tool}] of the set-up where the work offset was set with this tool"
            )


def _check_forces(scenario: CutScenario) -> None:
    """Deflection needs forces, and they need to be told what is cut."""
    bends = [e for e in scenario.machine.effects if e.name == "tool_deflection"]
    stated = scenario.setup.stock is not None or scenario.setup.bar is not None
    if bends and not (stated and scenario.setup.material is not None):
        raise UsageError(
            f"{bends[0].id} needs cutting forces: add [stock] with box (or bar) and material, and teeth to milling tools of the set-up, or leave "
            "the effect out"
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
                f"{low * scale:.6g} to {high * scale:.6g} {unit}; check work offset and tool length{unit_hint(scenario)}"
            )


def _work_zero(scenario: CutScenario, program: Program) -> Array:
    """Work offset of the first cut (3,), workpiece axes."""
    return np.array(scenario.setup.offsets.get(first_offset(program), (0.0, 0.0, 0.0)))


def first_offset(program: Program) -> str:
    """The work offset of the first cut."""
    return next((m.offset for m in program.moves if m.kind != "rapid"), program.moves[0].offset)


def zeros(shop: Shop, names: Words) -> Array:
    """Where each work offset was set (k, 3): at the stated place, else at the work zero itself; workpiece axes."""
    scenario = shop.scenario
    if scenario.set_at is not None:
        return np.tile(np.array(scenario.set_at), (len(names), 1))
    return np.array([scenario.setup.offsets.get(str(name), (0.0, 0.0, 0.0)) for name in names], dtype=float)


def look(shop: Shop, points: Array, normals: Array) -> CutSurface:
    """The surface that the program leaves at points (n, 3) of the drawing, workpiece axes."""
    at, out = shop.pose.apply(points), shop.pose.turn(normals)
    if shop.turning is not None:
        return turned_surface(shop.turning, at, out, DEPTH, DEEPEST, HEIGHT)
    found = surface_left(at, out, shop.index, DEPTH, HEIGHT, candidates=CONTACTS)
    deep = np.flatnonzero(found.status == BEYOND)
    if not len(deep):
        return found
    again = surface_left(at[deep], out[deep], shop.index, DEEPEST, HEIGHT, candidates=CONTACTS)
    names = ("status", "contact_s", "row", "t", "normal", "tests")
    merged = {name: getattr(found, name).copy() for name in names}
    for name in names:
        merged[name][deep] = getattr(again, name)
    return replace(found, **merged)


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
