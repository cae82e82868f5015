"""Prepare a cutting scenario: read and time the program, sweep the tools, place the part, and refuse what is wrong with it."""

from __future__ import annotations

import pickle
from dataclasses import replace
from pathlib import Path

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.expansions import unusual_expansion
from vcmm.core.play import playing
from vcmm.core.pose import Pose
from vcmm.core.run import Array, Series
from vcmm.program.interpret import read_for
from vcmm.program.moves import Move, Program
from vcmm.program.reading import read_bytes
from vcmm.program.sensible import length_missing, without_length
from vcmm.program.setup import turns_with
from vcmm.shop.cutting.envelope import CUT
from vcmm.shop.cutting.index import build
from vcmm.shop.machining.blank import Blank, first_turned_cut
from vcmm.shop.machining.blank import notes as blank_notes
from vcmm.shop.machining.contact_path import surface_at
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.lathe import LatheProcess
from vcmm.shop.machining.milling import MillingProcess
from vcmm.shop.machining.process import DEPTH, PreparedCut, Process
from vcmm.shop.machining.program_sweep import MOVING, driven_sweep, part_sweep
from vcmm.shop.machining.rotary import point_of_part
from vcmm.shop.machining.rotary_milling import RotaryMillingProcess
from vcmm.shop.machining.spindle_load import gap_of
from vcmm.shop.machining.tool_errors import cutting_effects, needs_forces
from vcmm.shop.machining.touched_zero import touched_zero, with_scatter
from vcmm.shop.machining.turned_faces import with_faces
from vcmm.shop.machining.turned_surface import turning_of
from vcmm.shop.machining.turning import TurningProcess
from vcmm.shop.machining.wrong_unit import unit_hint
from vcmm.shop.motion.tool_centre import in_machine_axes
from vcmm.shop.motion.toolpath import CUTS, Toolpath, toolpath
from vcmm.task.measuring.cut_scenario import CutScenario

FAR_TRAVELS = 100.0  # times the travel
LOG_SLACK = 1.0  # s of the cycle time by which a log may be shorter: the way home


def set_up(scenario: CutScenario) -> PreparedCut:
    """Read, time and sweep the program; place the part. Raises DataError, UsageError and ModelLimit."""
    text = read_bytes(Path(scenario.program))
    program = read_for("cut", text, scenario.dialect, scenario.setup, name=str(scenario.program))
    if not program.moves:
        raise UsageError(f"{scenario.program}: the program has no motion; nothing is cut")
    _check_lengths(scenario, program)
    touched = touched_zero(scenario, text, program)
    scenario = with_scatter(scenario, touched)
    program = _of_axes(scenario, program)
    _check_forces(scenario, program)
    _check_ends(scenario, program)
    path = _timed_path(program, scenario)
    _check_travels(scenario, program, path)
    _check_log(scenario, path)
    job = _prepare_cut(scenario, program, path)
    refused = job.process.refusal(job)
    if refused is not None:
        raise refused
    job = replace(job, blank=job.process.blank(job, _work_zero(scenario, program)), touched_zero=touched)
    _check_forces_known(job)
    return job


_PATHS: dict[tuple[tuple[Move, ...], bytes], Toolpath] = {}
MOST_PATHS = 2  # kept: a job cuts the program as it is and the new one, each several times


def _timed_path(program: Program, scenario: CutScenario) -> Toolpath:
    """Return the motion of the program; that of the same moves with the same axes and control is computed once. Of the errors of
    the machine only its play changes it."""
    machine = scenario.machine
    axes = replace(machine, effects=playing(machine.effects, machine.axes), inputs=())
    key = tuple(program.moves), pickle.dumps((axes, scenario.setup.control, scenario.step))
    if key not in _PATHS:
        while len(_PATHS) >= MOST_PATHS:
            _PATHS.pop(next(iter(_PATHS)))
        _PATHS[key] = toolpath(program, scenario.machine, scenario.setup, step=scenario.step)
    return _PATHS[key]


def _of_axes(scenario: CutScenario, program: Program) -> Program:
    """Return the program as motions of the axes: where it leads the tip over the workpiece, the machine follows."""
    moves, remarks_ = in_machine_axes(program.moves, scenario.machine, str(scenario.program))
    return replace(program, moves=moves, warnings=(*program.warnings, *remarks_))


def _prepare_cut(scenario: CutScenario, program: Program, path: Toolpath) -> PreparedCut:
    """Return the cut without a blank: tools swept, on a lathe in the meridian; the part placed."""
    # the drawing frame is the work coordinate system of the first cut
    pose = scenario.pose or Pose(np.eye(3), _work_zero(scenario, program))
    if turns_with(scenario.setup, program):
        _check_spindle(scenario, program)
        _check_driven(scenario, program)
        turning = turning_of(scenario, program, path)
        scenario = with_faces(scenario, pose, turning)
        return PreparedCut(
            scenario, program, path, pose, _on_lathe(scenario, program, TurningProcess(turning))
        )
    sweep, motion = part_sweep(program.moves, scenario.setup.tools, scenario.machine)
    index = build(sweep)
    process = MillingProcess(sweep, index) if motion is None else RotaryMillingProcess(sweep, index, motion)
    return PreparedCut(scenario, program, path, pose, process)


def _check_spindle(scenario: CutScenario, program: Program) -> None:
    spindles = {m.work_spindle for m in program.moves if m.kind in CUTS}
    if scenario.work_spindle not in spindles:
        raise UsageError(
            f"{scenario.program.name}: nothing is cut in spindle {scenario.work_spindle}, only in {', '.join(map(str, sorted(spindles)))}; correct "
            "work_spindle of [cut], or work_spindles of the set-up"
        )


def _check_driven(scenario: CutScenario, program: Program) -> None:
    """Check that the set-up names the driven tool of each cut with axis C off zero."""
    tools = scenario.setup.tools
    for m in program.moves:
        turned = (
            m.kind in CUTS
            and m.work_spindle == scenario.work_spindle
            and any((*m.rotary_start, *m.rotary_end))
        )
        if turned and m.tool in tools and tools[m.tool].driven is None:
            raise UsageError(
                f'line {m.source.line} of the program cuts with a rotary axis off zero, on a lathe a driven tool: add driven = "x" (it is '
                f'across the spindle) or driven = "z" (along it) to [tools.{m.tool}] of the set-up, or take these blocks out'
            )


def _on_lathe(scenario: CutScenario, program: Program, turning: TurningProcess) -> Process:
    """Return turning alone, or with the cuts of driven tools."""
    tools = {n: t for n, t in scenario.setup.tools.items() if t.driven is not None}
    first = int(turning.turning.path.timing.moving[0])
    kept = [
        i
        for i, m in enumerate(program.moves)
        if m.tool in tools
        and m.kind in MOVING
        and m.work_spindle == scenario.work_spindle
        and not (i == first and m.kind == "rapid")
    ]
    if not any(program.moves[i].kind in CUTS for i in kept):
        return turning
    sweep, motion = driven_sweep(program.moves, kept, tools, scenario.machine)
    return LatheProcess(turning, RotaryMillingProcess(sweep, build(sweep), motion), frozenset(tools))


def other_unit(scenario: CutScenario) -> str:
    """Return an addition to the message about a program that misses the part, where it would hit it in the other unit."""
    return unit_hint(scenario, _hits)


def _hits(scenario: CutScenario, program: Program) -> tuple[int, int]:
    """Return (inspection points that the program cuts no more than DEPTH too deep, inspection points); travels are not checked."""
    program = _of_axes(scenario, program)
    path = toolpath(program, scenario.machine, scenario.setup, step=scenario.step)
    job = _prepare_cut(scenario, program, path)
    steps = gauge_plan(job.scenario.part, job.scenario.plan).steps
    points, normals = (np.concatenate([getattr(s, name) for s in steps]) for name in ("points", "normals"))
    surface = surface_at(job, points, normals, exact=False)
    hit = (surface.status == CUT) & (np.nan_to_num(surface.contact_s[:, 0], nan=-np.inf) >= -DEPTH)
    return int(hit.sum()), len(points)


def _check_lengths(scenario: CutScenario, program: Program) -> None:
    """Check tool lengths: a tool whose length the program ignores would cut too deep by that length."""
    tools = scenario.setup.tools
    move = without_length(program.moves, tools)
    if move is not None:
        raise UsageError(length_missing(move, tools))


def _check_forces(scenario: CutScenario, program: Program) -> None:
    """Check that the material is stated where deflection needs forces."""
    bends = [e for e in scenario.machine.effects if needs_forces(e)]
    stated = scenario.setup.stock is not None or scenario.setup.bar is not None
    if bends and not scenario.force_log and not (stated and scenario.setup.material is not None):
        raise UsageError(
            f"{bends[0].id} needs cutting forces: add [stock] with box (or bar) and material, and teeth to milling tools of the set-up, or leave "
            "the effect out"
        )


def _check_forces_known(job: PreparedCut) -> None:
    """Refuse a tool that tilts while it cuts: its forces are unknown."""
    bends = [e for e in job.machine.effects if needs_forces(e)]
    if bends and not job.scenario.force_log and isinstance(job.blank, Blank) and job.blank.forces is None:
        raise ModelLimit(
            f"{bends[0].id} needs cutting forces, but line {first_turned_cut(job.program)} of the program cuts with a rotary axis off zero and the tool "
            "comes from too many directions, for which none are computed; log them ([cut] force_log), or leave out the effect, or stick_out and compliance of the tools "
            "where these bend them"
        )


def _to_check(scenario: CutScenario, move: Move) -> str:
    """Return the likely cause where a move leaves the travels: its work offset first, where the set-up does not name it."""
    if move.offset in scenario.setup.offsets:
        return "check work offset and tool length"
    return f"work offset {move.offset} is not in the set-up, and machine zero is taken: add it to [offsets]"


def _check_ends(scenario: CutScenario, program: Program) -> None:
    """Check that no move ends a hundred travels away, as a length in a wrong unit does, before the motion there is computed."""
    for move in program.moves[1:]:
        for i, letter in enumerate("XYZ"):
            axis = scenario.machine.axes.get(letter)
            q = move.end[i] + move.tool_offset[i]
            if axis is not None and abs(q) > FAR_TRAVELS * max(map(abs, axis.travel)):
                raise ModelLimit(
                    f"line {move.source.line} of the program is out of travel: axis {letter} = {q:.6g} mm, its travel is "
                    f"{axis.travel[0]:.6g} to {axis.travel[1]:.6g} mm; {_to_check(scenario, move)}"
                )


def _logs(scenario: CutScenario) -> list[tuple[str, Series]]:
    """Return the logs that were measured while such a part was cut."""
    logs = {"force": next(iter(scenario.force_log.values()), None), "load": scenario.load_log}
    return [(what, log) for what, log in logs.items() if log is not None]


def _check_log(scenario: CutScenario, path: Toolpath) -> None:
    """Refuse a log that ends before the program, since it does not cover the rest."""
    for what, log in _logs(scenario):
        if log.time[0] > 0.0 or log.time[-1] < path.seconds - LOG_SLACK:
            raise ModelLimit(
                f"the {what} log covers {log.time[0]:.1f} to {log.time[-1]:.1f} s, but the program runs from 0 to {path.seconds:.1f} s by the time law; "
                "state the dynamics of the machine and of its control, or log the whole program"
            )


def _check_travels(scenario: CutScenario, program: Program, path: Toolpath) -> None:
    """Check that the whole program stays within the travels, except the way from the unknown start position."""
    later = np.flatnonzero(path.move != path.timing.moving[0])
    for letter, axis in scenario.machine.axes.items():
        q, (low, high) = path.axes[letter][later], axis.limits
        bad = np.flatnonzero((q < low - 1e-6) | (q > high + 1e-6))
        if len(bad):
            line = path.columns["line"][later[bad[0]]]
            move = next((m for m in program.moves if m.source.line == round(line)), program.moves[0])
            scale, unit = (180 / np.pi, "deg") if axis.rotary else (1.0, "mm")
            raise ModelLimit(
                f"line {line:.0f} of the program is out of travel: axis {letter} = {q[bad[0]] * scale:.6g} {unit}, its travel is "
                f"{low * scale:.6g} to {high * scale:.6g} {unit}; {_to_check(scenario, move)}{other_unit(scenario)}"
            )


def _work_zero(scenario: CutScenario, program: Program) -> Array:
    """Return the point of the part at the work offset of the first cut (3,), workpiece axes."""
    moves = [m for m in program.moves if m.work_spindle == scenario.work_spindle] or program.moves
    first = next((m for m in moves if m.kind != "rapid"), moves[0])
    zero = np.array(scenario.setup.offsets.get(first.offset, (0.0, 0.0, 0.0)))
    if not any(first.rotary_start) or first.tool_axis_end is not None:
        return zero  # of a led move in the workpiece as it lies with the rotary axes at zero
    return point_of_part(scenario.machine, zero, np.array(first.rotary_start))


def _unready(job: PreparedCut) -> list[str]:
    """Return a remark on the first cut with a spindle at rest; the machine builder defines the word that starts that of a driven tool."""
    tools = {n: t for n, t in job.scenario.setup.tools.items() if t.shape != "probe" and t.driven is None}
    for move in job.program.moves:
        cuts = move.kind in ("line", "arc") and move.tool in tools
        if cuts and not move.spindle:
            return [f"line {move.source.line} cuts while the spindle does not turn"]
    return []


def _turned_part(job: PreparedCut) -> list[str]:
    """Return a remark on a part that lies turned against its drawing: effects that name directions of the workpiece mean those of the
    machine's table."""
    named = [e.id for e in job.machine.effects if needs_forces(e) and hasattr(e, "direction")]
    if not named or np.allclose(job.pose.rotation, np.eye(3), atol=1e-9):
        return []
    return [
        f"{', '.join(named)}: the part lies turned against its drawing; x, y and z are those of the workpiece on the machine, not of the "
        "drawing"
    ]


def _mean_forces(job: PreparedCut) -> list[str]:
    """Return a remark on tools that bend while no helix is stated: the mean force of a turn bends their walls."""
    blank = job.blank
    if not isinstance(blank, Blank) or blank.teeth is None or blank.pieces is None:
        return []
    if job.scenario.force_log or not any(needs_forces(e) for e in job.machine.effects):
        return []
    rows = np.repeat(job.sweep.move, blank.pieces.count)[
        np.isnan(blank.teeth.lag) & (blank.teeth.axial > 0.0)
    ]
    tools = sorted({job.program.moves[int(i)].tool for i in rows})
    if not tools:
        return []
    name = ", ".join(map(str, tools))
    return [
        f"tool {name}: no helix is stated, so the mean force of a turn bends it; a wall keeps the force of the moment at which an edge makes it: write "
        f'helix = "30 deg" ("0 deg": straight) in [tools.{tools[0]}]'
    ]


def remarks(job: PreparedCut) -> tuple[str, ...]:
    """Return the remarks of the program, the time law and the machine."""
    program = [f"{job.scenario.program.name}:{w.line}: {w.text}" for w in job.program.warnings]
    idle = cutting_effects(job.machine)[2]
    lines = [f"{', '.join(idle)} act on measuring, not on cutting"] if idle else []
    assumed = (
        (f"assumed, as nothing is stated: {'; '.join(job.path.assumptions)}",) if job.path.assumptions else ()
    )
    lines += [*_turned_part(job), *_mean_forces(job)]
    lines += [
        f"{name}: what the scenario states is not added; the machine file says how well it is known now ({evidence})"
        for name, evidence in job.scenario.found_since.items()
    ]
    gaps = [(what, gap) for what, log in _logs(job.scenario) if (gap := gap_of(log)) is not None]
    lines += [
        f"the {what} log has no reading from {a:.1f} to {b:.1f} s: a straight line bridges the gap"
        for what, (a, b) in gaps
    ]
    expands = unusual_expansion("[part] expansion", job.scenario.part.expansion)
    lines += [*job.machine.remarks, *([expands] if expands else [])]
    return (*program, *_unready(job), *job.process.remarks(), *blank_notes(job.blank), *lines, *assumed)
