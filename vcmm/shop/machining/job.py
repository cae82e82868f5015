"""Cut: from a cutting scenario to the finished part with its uncertainty.

program -> moves -> time law -> swept tools -> contacts at the inspection points -> states of the machine there
        -> departures of the surface -> inspection -> features, characteristics, decisions, budget

The surface over all features is for pictures and extremes.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.evaluation.virtual_measurement import Measurement, measure_task
from vcmm.core.blocks import Progress, Sharing
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.shop.cutting.envelope import UNCUT, CutSurface
from vcmm.shop.machining.contact_path import surface_at, tool_side
from vcmm.shop.machining.cut_world import Cutting
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.grooves import grooves_of
from vcmm.shop.machining.inspection import cut_points, measuring_world, unseen, with_uncut
from vcmm.shop.machining.maps import Net
from vcmm.shop.machining.preparation import remarks, set_up
from vcmm.shop.machining.process import GOUGE, PreparedCut
from vcmm.shop.machining.recut import Recut, recut
from vcmm.shop.machining.result import CutResult, Patch, batch, extremes, shares_by_group
from vcmm.shop.machining.threads import threads_of
from vcmm.task.measuring.cut_scenario import IDEAL, SAME_MACHINE, CutScenario
from vcmm.task.measuring.task import Task

MOST_ACROSS, MOST_FACES = 41, 28_000  # points across one feature, triangles of all features in one picture


def surface_map(job: PreparedCut) -> tuple[Patch, ...]:
    """Return all features of the part that have an extent, with a density that a picture of all of them can show."""
    features = job.scenario.part.features.values()
    across = int(min(MOST_ACROSS, np.sqrt(MOST_FACES / 2 / max(len(features), 1))))
    return tuple(patch(job, n) for f in features if (n := job.process.net(job, f, across)) is not None)


def patch(job: PreparedCut, over: Net) -> Patch:
    """Return the surface over one net at the estimates of all errors, and without errors."""
    surface = surface_at(job, over.points, over.normals)
    height, nominal = np.full(len(over.points), np.nan), np.full(len(over.points), np.nan)
    there = np.flatnonzero(surface.status != UNCUT)
    if len(there):
        some = surface_at(job, over.points[there], over.normals[there])
        names = np.array([f"{over.feature} {i}" for i in range(len(there))])
        tool, contacts = tool_side(job, some, names, np.full(len(there), over.feature))
        height[there], nominal[there] = contacts.surface(tool.errors()), contacts.surface(tool.known_error)
    return Patch(over, height, nominal)


RECUT_LIMIT = 1e-4  # mm


def cut(
    scenario: CutScenario,
    *,
    seed: int | None = None,
    trials: int | None = None,
    engine: str | None = None,
    progress: Progress | None = None,
    sharing: Sharing | None = None,
) -> CutResult:
    """Machine a part virtually. Raises DataError for a program that cannot be read, UsageError and ModelLimit."""
    report = progress or (lambda text, share: None)
    settings = scenario.settings.with_changes(seed=seed, trials=trials, engine=engine)
    report("reading the program", 0.0)
    job = set_up(scenario)
    report("cutting (compiles on first use)", 0.0)
    task, world, notes = finished_part(job)
    settings, engine_text = job.process.engine(settings)
    notes = (*notes, *engine_text)
    touches = task.touches
    again = recut(job, surface_at(job, touches.points, touches.normals, exact=False))
    reading = None
    if scenario.inspection.kind == SAME_MACHINE:
        reading = evaluate(task, settings, report, world)
        world = world.of_part()
    outcome = evaluate(task, settings, report, world, sharing)
    notes = (*notes, *unseen(outcome, reading))
    report("mapping the surface", 0.0)
    patches = surface_map(job)
    warnings = tuple(
        dict.fromkeys((*remarks(job), *notes, *_beyond_contacts(again, notes), *outcome.warnings))
    )
    outcome = replace(outcome, warnings=warnings, characteristics=with_uncut(outcome, task, job))
    halves = {c.name: batch(c) for c in outcome.characteristics}
    return CutResult(
        uncertainty=outcome,
        surface=extremes(patches, GOUGE, scenario.part.features),
        patches=patches,
        seconds=job.seconds,
        shares={c.name: shares_by_group(c) for c in outcome.characteristics},
        repeats={n: h[0] for n, h in halves.items()},
        scatters={n: h[1] for n, h in halves.items()},
        warnings=warnings,
        blank=job.blank,
        recut=again,
        own_reading=reading,
        threads=threads_of(job),
        grooves=grooves_of(job),
    )


def measure_cut(scenario: CutScenario, seed: int | None = None) -> Measurement:
    """Cut the part once and inspect it once. seed=None: errors of mill and measuring machine at their estimates; else one draw of all.

    Raises DataError for a program that cannot be read, UsageError and ModelLimit.
    """
    job = set_up(scenario)
    task, world, notes = finished_part(job)
    return measure_task(task, seed, world, tuple(dict.fromkeys((*remarks(job), *notes))))


def finished_part(job: PreparedCut) -> tuple[Task, Cutting, tuple[str, ...]]:
    """Return the task of inspecting the part, the world it was cut in, and remarks on points left out."""
    scenario = job.scenario
    planned = gauge_plan(scenario.part, scenario.plan) if scenario.inspection.kind == IDEAL else scenario.plan
    if planned is None:
        raise UsageError(
            "inspection on a machine needs a plan with styli; add [plan], or leave [inspection] out"
        )
    plan, surface, notes = cut_points(job, planned)
    inputs = (*job.machine.inputs, *scenario.inputs)
    measuring = measuring_world(job, plan, surface)
    placed = measuring.task.touches
    touch, feature = (placed.run.labels[name] for name in ("touch", "feature"))
    notes = (*notes, *job.process.remarks_on(surface, feature))
    tool, contacts = tool_side(job, surface, touch, feature, inputs)
    world = Cutting(measuring, tool, contacts)
    form = world.level + _cusp_lift(job, surface, placed.tip_radius)
    task = replace(measuring.task, inputs=(*inputs, *measuring.task.inputs), form=form)
    measuring = replace(measuring, task=replace(measuring.task, form=form))
    return task, replace(world, measuring=measuring), notes


def _cusp_lift(job: PreparedCut, surface: CutSurface, radius: Array) -> Array:
    """Return how much higher a stylus tip of radius (P,) mm rests on the cusps beside each point than the surface in it, (P,) mm."""
    out = np.zeros(len(surface.points))
    for r in np.unique(radius[radius > 0]):
        mine = np.flatnonzero(radius == r)
        out[mine] = job.process.cusp_lift(job, surface, mine, float(r))
    return out


def _beyond_contacts(again: Recut | None, notes: tuple[str, ...]) -> list[str]:
    if again is None and any("gouges" in note for note in notes):
        return []  # of points that are all gouged there is nothing to cut again
    if again is None:
        return [
            "the errors change too fast along the path to cut some points again as a check of the contacts"
        ]
    if again.largest <= RECUT_LIMIT:
        return []
    return [
        f"cut again with the tools really displaced, {again.points} points differ by up to {again.largest * 1e3:.2f} um from the "
        "contacts used here: the errors change faster along the path than the contacts follow"
    ]
