"""Inspection of the finished part: its points, and the world of the machine that measures it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.answer.evaluation.world import Measuring
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import OFFSET_LABEL
from vcmm.part.fit.elements import MINIMUM_POINTS
from vcmm.physics.structure.setting import TOOL_TABLE, WorkOffset
from vcmm.shop.cutting.envelope import BEYOND, UNCUT, CutSurface
from vcmm.shop.machining.contact_path import surface_at
from vcmm.shop.machining.gauge import gauge_plan, ideal_gauge
from vcmm.shop.machining.preparation import other_unit
from vcmm.shop.machining.probing import ProbedHere
from vcmm.shop.machining.process import DEEPEST, GOUGE, HEIGHT, PreparedCut, Words, zeros
from vcmm.shop.machining.result import expected_deviation
from vcmm.task.measuring.cut_scenario import IDEAL, SAME_MACHINE
from vcmm.task.measuring.plan import Plan, touches
from vcmm.task.measuring.qualification import qualified_machine
from vcmm.task.measuring.task import Task

UNSEEN = 0.1  # of U: larger errors that the probing machine misses are reported


def cut_points(job: PreparedCut, plan: Plan) -> tuple[Plan, CutSurface, tuple[str, ...]]:
    """Return the plan without the points that no cutter touched, and the surface at those that remain."""
    steps, notes = [], []
    for step in plan.steps:
        surface = surface_at(job, step.points, step.normals)
        kept = np.flatnonzero(surface.status != UNCUT)
        kind = job.scenario.part.features[step.feature].kind
        if len(kept) < MINIMUM_POINTS.get(kind, 1):
            raise ModelLimit(
                f"feature {step.feature}: the program cuts {len(kept)} of its {len(step.points)} inspection points within "
                f"{HEIGHT:g} mm; check the work offset, the pose of the part and the tool, or leave the feature out"
                f"{other_unit(job.scenario)}"
            )
        if len(kept) < len(step.points):
            notes.append(
                f"{step.feature}: at {len(step.points) - len(kept)} of {len(step.points)} inspection points more than {HEIGHT:g} mm is left or nothing was "
                "cut; the figures are of the other points, and what depends on it does not conform"
            )
        notes += gouges(job, step.feature, surface)
        approach = None if step.approach is None else step.approach[kept]
        steps.append(replace(step, points=step.points[kept], normals=step.normals[kept], approach=approach))
    plan = replace(plan, steps=tuple(steps))
    points, normals = (
        np.concatenate([getattr(s, name) for s in plan.steps]) for name in ("points", "normals")
    )
    return plan, surface_at(job, points, normals), tuple(notes)


def gouges(job: PreparedCut, feature: str, surface: CutSurface) -> list[str]:
    """Return remarks on gouges, material that the program itself removes too deep. Raises ModelLimit where the depth is beyond all search."""
    if not (surface.status == BEYOND).any() and not (surface.contact_s[:, 0] < -GOUGE).any():
        return []
    worst = int(np.where(surface.status == BEYOND, -np.inf, np.nan_to_num(surface.contact_s[:, 0])).argmin())
    row = int(surface.row[worst, 0])
    line = job.line_of(row) if row >= 0 else 0
    if (surface.status == BEYOND).any():
        raise ModelLimit(
            f"feature {feature}: line {line} of the program cuts more than {DEEPEST:g} mm below it; check the work offset, the "
            f"pose of the part and the tool{other_unit(job.scenario)}"
        )
    count, depth = int((surface.contact_s[:, 0] < -GOUGE).sum()), -float(surface.contact_s[worst, 0])
    return [
        f"{feature}: the program itself gouges {count} of its {len(surface.points)} inspection points deeper than {GOUGE * 1e3:g} um, by "
        f"{depth:.3f} mm at most (line {line})"
    ]


def measuring_world(job: PreparedCut, plan: Plan, surface: CutSurface) -> Measuring | ProbedHere:
    """Return the world of the measuring machine: none, the machine tool again, or another machine."""
    scenario, how = job.scenario, job.scenario.inspection
    if how.kind == IDEAL:
        gauge = ideal_gauge()
        placed = touches(plan, job.pose, gauge)
        return Measuring(Task(gauge, scenario.part, plan, placed, (), np.zeros(placed.run.n)))
    same = how.kind == SAME_MACHINE
    if same and job.touched_zero is not None:
        raise ModelLimit(
            f'[inspection] machine = "same" reads from zeros that were set by hand, but line {job.touched_zero.touches[0].line} of the program probes them; '
            "inspect on another machine, or take the probing out"
        )
    base = job.machine if same else how.machine
    assert base is not None
    machine, qualified = qualified_machine(base, plan, scenario.qualifications)
    pose = how.pose or job.pose
    placed = touches(plan, pose, machine, scenario.constants if same else how.constants)
    empty = np.zeros(placed.run.n)
    if not same:
        inputs = [replace(i, owner=machine.name) for i in (*machine.inputs, *qualified)]
        return Measuring(Task(machine, scenario.part, plan, placed, tuple(inputs), empty))
    given = [i for i in (*machine.inputs, *scenario.inputs) if i.effect not in TOOL_TABLE]
    shared = [
        i if i.redraw == "machine" or i.effect == WorkOffset.name else replace(i, owner="probing")
        for i in given
    ]
    inputs = [*shared, *(replace(i, owner="probing") for i in qualified)]
    drawn = any(i.effect == WorkOffset.name and i.redraw == OFFSET_LABEL for i in given)
    offset = _offset_cut_under(job, surface, placed.run.labels["feature"], drawn)
    placed = replace(placed, run=replace(placed.run, labels={**placed.run.labels, OFFSET_LABEL: offset}))
    task = Task(machine, scenario.part, plan, placed, tuple(inputs), empty)
    if not scenario.set_here:
        return Measuring(task)
    names = np.unique(offset)
    for name in names.tolist():
        if np.any(job.process.angle_set(job, name)):
            raise ModelLimit(
                f'[inspection] machine = "same" probes with the rotary axes at zero, but {name} was set with them turned '
                '(work_offset.rotary = "as cut"); inspect on another machine, or begin the program at zero'
            )
    return ProbedHere(task, dict(zip(names.tolist(), zeros(job, names))))


def _offset_cut_under(job: PreparedCut, surface: CutSurface, feature: Words, drawn: bool) -> Words:
    """Return the work offset (n,) from which each touch is read: that under which its feature was cut, for the most part.

    Raises UsageError for a feature that two of them share, where each was set with an uncertainty of its own.
    """
    move = job.sweep.move[surface.row[:, 0]]
    cut = np.array([job.program.moves[i].offset for i in move.tolist()])
    out = cut.copy()
    for name in dict.fromkeys(feature.tolist()):
        mine = feature == name
        offsets, count = np.unique(cut[mine], return_counts=True)
        if len(offsets) > 1 and drawn:
            raise UsageError(
                f"feature {name} is cut under {' and '.join(offsets.tolist())}, each of which was set with the uncertainty of "
                '[cut.work_offset]; probed on the machine that cut it ([inspection] machine = "same") a feature is read from one '
                "of them: cut it under one work offset, leave u out, or inspect on another machine"
            )
        out[mine] = offsets[int(np.argmax(count))]
    return out


def unseen(part: UncertaintyResult, reading: UncertaintyResult | None) -> list[str]:
    """Return remarks on errors that the machine that cut the part does not see on it, characteristic by characteristic, where they are
    large beside U.

    reading: its reading; None where another machine measures.
    """
    out = []
    for true, read in zip(part.characteristics, reading.characteristics if reading else ()):
        scale, unit = (1e3, "um") if true.unit == "mm" else (1e6, "urad")
        missed = expected_deviation(true) - expected_deviation(read)
        if max(abs(missed), true.expanded - read.expanded) > UNSEEN * max(true.expanded, 1e-9):
            out.append(
                f"{true.name}: the machine errs in probing as it did in cutting: of {expected_deviation(true) * scale:+.3g} +- "
                f"{true.expanded * scale:.3g} {unit} from nominal it would read {expected_deviation(read) * scale:+.3g} +- "
                f"{read.expanded * scale:.3g} {unit}; value, interval and decision are about the part"
            )
    return out


def with_uncut(outcome: UncertaintyResult, task: Task, job: PreparedCut) -> tuple[CharacteristicResult, ...]:
    """Return results in which a feature with uncut points does not conform, whatever the points that were cut show."""
    scenario = job.scenario
    plan = gauge_plan(scenario.part, scenario.plan) if scenario.inspection.kind == IDEAL else scenario.plan
    planned = {step.feature: len(step.points) for step in plan.steps} if plan else {}
    left = {name for name, rows in task.touches.rows.items() if len(rows) < planned.get(name, 0)}
    out = []
    for c, spec in zip(outcome.characteristics, scenario.part.characteristics):
        if c.decision is not None and left & set(spec.features):
            c = replace(
                c, decision=replace(c.decision, text="does not conform", p_conform=0.0), coverage_shown=False
            )
        out.append(c)
    return tuple(out)
