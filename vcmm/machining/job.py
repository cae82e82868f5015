"""Cut: from a cutting scenario to the finished part with its uncertainty.

program -> moves -> time law -> swept tools -> contacts at the inspection points -> states of the machine there
        -> departures of the surface -> inspection -> features, characteristics, decisions, budget
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.cutting.envelope import CutSurface
from vcmm.cutting.stylus import rolled
from vcmm.evaluation.sampling import Progress
from vcmm.evaluation.uncertainty import evaluate
from vcmm.machining.gauge import gauge_plan
from vcmm.machining.inspection import cut_points, measuring_world, with_uncut
from vcmm.machining.machine_at_cut import tool_side
from vcmm.machining.patches import surface_map
from vcmm.machining.preparation import GOUGE, Shop, look, remarks, set_up
from vcmm.machining.recut import Recut, recut
from vcmm.machining.result import CutResult, batch, extremes, grouped
from vcmm.machining.scenario import IDEAL, CutScenario
from vcmm.machining.tool_errors import needs_forces
from vcmm.machining.turned import TurnedSurface, backs
from vcmm.machining.turned_recut import lifted, recut_turned
from vcmm.machining.world import Cutting
from vcmm.measuring.settings import Settings
from vcmm.measuring.task import Task

RECUT_LIMIT = 1e-4  # mm
EXACT_TRIALS = 2000  # of a turned part, where no engine is asked for: interval ends to about 3 % of U


def cut(
    scenario: CutScenario,
    *,
    seed: int | None = None,
    trials: int | None = None,
    engine: str | None = None,
    progress: Progress | None = None,
) -> CutResult:
    """Machine a part virtually. Raises DataError for a program that cannot be read, UsageError and ModelLimit."""
    report = progress or (lambda text, share: None)
    changes = {"seed": seed, "trials": trials, "engine": engine}
    settings = replace(scenario.settings, **{k: v for k, v in changes.items() if v is not None})  # type: ignore[arg-type]
    report("reading the program", 0.0)
    shop = set_up(scenario)
    report("cutting (compiles on first use)", 0.0)
    task, world, notes = finished_part(shop)
    settings, said = _for_marks(settings, shop)
    notes = (*notes, *said)
    again = _again(shop, task)
    found = evaluate(task, settings, report, world)
    report("mapping the surface", 0.0)
    patches = surface_map(shop)
    warnings = (*remarks(shop), *notes, *_beyond_contacts(again, notes), *found.warnings)
    found = replace(found, warnings=warnings, characteristics=with_uncut(found, task, shop))
    halves = {c.name: batch(c) for c in found.characteristics}
    return CutResult(
        found, extremes(patches, GOUGE), patches, shop.seconds, {c.name: grouped(c) for c in found.characteristics},
        {n: h[0] for n, h in halves.items()}, {n: h[1] for n, h in halves.items()}, warnings, shop.blank, again,
    )  # fmt: skip


def _for_marks(settings: Settings, shop: Shop) -> tuple[Settings, tuple[str, ...]]:
    """Turned parts by exact trials: feed marks move along with the errors, which the linear model does not follow."""
    if shop.turning is None or settings.engine != "auto":
        return settings, ()
    trials = min(settings.trials, EXACT_TRIALS)
    said = f"computed by {trials} exact trials, as feed marks move along with the errors"
    if trials < settings.trials:
        said += f"; all {settings.trials} with --engine exact, or a linear model with --engine montecarlo"
    return replace(settings, engine="exact", trials=trials), (said,)


def finished_part(shop: Shop) -> tuple[Task, Cutting, tuple[str, ...]]:
    """The task of inspecting the part, the world it was cut in, and what is to be said about points left out."""
    scenario = shop.scenario
    planned = gauge_plan(scenario.part, scenario.plan) if scenario.inspection.kind == IDEAL else scenario.plan
    if planned is None:
        raise UsageError(
            "inspection on a machine needs a plan with styli; add [plan], or leave [inspection] out"
        )
    plan, surface, notes = cut_points(shop, planned)
    inputs = (*shop.machine.inputs, *scenario.inputs)
    measuring = measuring_world(shop, plan, surface)
    touch, feature = (measuring.task.touches.run.labels[name] for name in ("touch", "feature"))
    if isinstance(surface, TurnedSurface) and shop.turning is not None:
        notes = (*notes, *backs(shop.turning, surface, feature))
    tool, contacts = tool_side(shop, surface, touch, feature, inputs)
    world = Cutting(measuring, tool, contacts)
    placed = measuring.task.touches
    seen = surface if shop.motion is None else look(shop, placed.points, placed.normals, exact=False)
    form = world.level + _lifted(shop, seen, placed.tip_radius)
    task = replace(measuring.task, inputs=(*inputs, *measuring.task.inputs), form=form)
    measuring = replace(measuring, task=replace(measuring.task, form=form))
    return task, replace(world, measuring=measuring), notes


def _again(shop: Shop, task: Task) -> Recut | None:
    """Points cut again with displaced tools; those in the side of a gouge by the program itself move by more than any error."""
    found = look(shop, task.touches.points, task.touches.normals, exact=False)
    if isinstance(found, TurnedSurface):
        return recut_turned(shop, found)
    sound = np.flatnonzero(found.contact_s[:, 0] >= -GOUGE)
    if not len(sound):
        return None
    names = ("points", "normals", "status", "contact_s", "row", "t", "normal", "tests")
    kept = replace(found, **{n: getattr(found, n)[sound] for n in names})
    smooth = tuple(e for e in shop.machine.effects if not needs_forces(e))  # they jump from move to move
    machine = replace(shop.machine, effects=smooth)
    return recut(shop.path, shop.sweep, machine, kept, dict(shop.scenario.constants), shop.motion)


def _lifted(shop: Shop, surface: CutSurface, radius: Array) -> Array:
    """How much higher a stylus tip of radius (P,) mm rests on the cusps beside each point than the surface in it, (P,) mm."""
    out = np.zeros(len(surface.points))
    turning = shop.turning
    for r in np.unique(radius[radius > 0]):
        mine = np.flatnonzero(radius == r)
        if turning is not None:
            assert isinstance(surface, TurnedSurface)
            out[mine] = lifted(turning, surface, mine, float(r))
            continue
        found = rolled(surface.points[mine], surface.normals[mine], float(r), shop.index)
        out[mine] = np.where(np.isfinite(found.s), np.maximum(found.s - surface.contact_s[mine, 0], 0.0), 0.0)
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
