"""Audit as users evaluate: points of sampled parts are evaluated as a file of points is, and the intervals counted.

    part       forms of the families that vcmm samples (`vcmm.answer.evaluation.form_family`) on all features, sizes and distances among
               them; its true values from its surface all over
    machine    sampled from the Inputs; where only limits are known from perfect to its limit, one share after another
    points     surface + errors of the machine, known ones included
    claims     the result of `vcmm evaluate --points` for each: the interval, and whether its coverage is claimed

Outliers, noise with memory and forms that points cannot bound withdraw claims here as there. Intervals are counted where they are claimed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.form_family import KNOWN, OTHER
from vcmm.answer.evaluation.pairs import Drawing, Largest, prepare_drawing, surfaces, values
from vcmm.answer.inference.given_points import GivenPoints
from vcmm.answer.inference.job import EvaluatedPart, evaluate_points
from vcmm.core.run import Array
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.task import Task, measured_points

# of the parts asked for, and at most, of a kind: each is evaluated from its points, which takes 0.1 s
SHARE = 0.1
MOST_PARTS = 100
ANEW = 2000  # added to the seed: parts that nothing was made of
IN_WORDS = {
    "waves": "waves of all numbers",
    "lobes": "lobes or half waves of one number",
    "edges": "steps and edges",
}
AUDITED_FORMS: tuple[tuple[str, float | None], ...] = (
    *((family, None) for family in KNOWN),
    (KNOWN[0], 0.0),
    (OTHER, None),
)


@dataclass(frozen=True)
class HeldByPoints:
    """Counts of one characteristic and one kind of parts: the number claimed, and how many of them (of all, where none was) hold the
    true value; width: mean, mm or rad; why: the first reason where nothing was claimed.
    """

    i: int
    kind: str
    parts: int
    claimed: int
    covering: int
    width: float
    why: str


def why_not_by_points(scenario: Scenario) -> str:
    """Return why parts of a scenario cannot be sampled with forms; empty where they can."""
    task = scenario.task()
    if task.forms:
        return "the scenario states forms of its features: parts are not drawn with others"
    kinds = {task.part.features[n].kind for n in task.touches.rows}
    return "its surfaces come from a file" if kinds & {"mesh", "points", "point"} else ""


def count_by_points(scenario: Scenario, settings: Settings, parts: int) -> tuple[HeldByPoints, ...]:
    """Count every characteristic, kind after kind. Raises what `evaluate_points` raises."""
    task = scenario.task()
    names = task.part.characteristics
    drawing = prepare_drawing(task, settings.seed, range(len(names)))
    count = min(max(int(SHARE * parts), 1), MOST_PARTS)
    drawn = [_draw(task, drawing, settings.seed + ANEW, count, kind) for kind in AUDITED_FORMS]
    given = [part for _, files in drawn for part in files]
    evaluated = evaluate_points(scenario, given, settings=settings)
    out = []
    for k, (kind, (true, _)) in enumerate(zip(AUDITED_FORMS, drawn)):
        mine = evaluated[k * count : (k + 1) * count]
        out += [_count(i, _kind_in_words(drawing, *kind), mine, true[:, i]) for i in range(len(names))]
    return tuple(out)


def _kind_in_words(drawing: Drawing, family: str, ratio: float | None) -> str:
    shares = "; machines from perfect to the limit" if len(drawing.machines.shares) > 1 else ""
    form = "no form" if ratio == 0.0 else f"forms of any size: {IN_WORDS[family]}"
    return f"evaluated from points, {form}{shares}"


def _draw(
    task: Task, drawing: Drawing, seed: int, count: int, kind: tuple[str, float | None]
) -> tuple[Array, list[GivenPoints]]:
    """Return true values (count, C), and the points of every part as if they came from a file."""
    family, ratio = kind
    touched, surface = surfaces(drawing, count, (seed, 0), (family, Largest(), ratio))
    true = values(drawing.surface, surface)
    shares = drawing.machines.shares
    moved = [drawing.machines.errors(seed, 0, count, share) for share in shares]
    error = task.machine.indication_error(task.touches.run)
    names = _names(task)
    form, files = np.zeros(task.touches.run.n), []
    for n in range(count):
        form[drawing.touches] = touched[n] + moved[n % len(shares)][n]
        points = measured_points(replace(task, form=form.copy()), error)
        where = tuple(f"drawn part {n}, point {k + 1}" for k in range(len(points)))
        styli = (
            tuple(str(s) for s in task.touches.run.labels["stylus"])
            if "stylus" in task.touches.run.labels
            else None
        )
        files.append(GivenPoints(str(n), points, where, features=names, styli=styli))
    return true, files


def _names(task: Task) -> tuple[str, ...]:
    return tuple(str(f) for f in task.touches.run.labels["feature"])


def _count(i: int, kind: str, evaluated: Sequence[EvaluatedPart], true: Array) -> HeldByPoints:
    """Count the claimed intervals; where none is claimed, all."""
    there = [(p.characteristics[i].result, float(t)) for p, t in zip(evaluated, true) if np.isfinite(t)]
    claimed = [
        (r, t) for r, t in there if r.coverage_shown and (r.true_value is None or r.true_value.is_claimed)
    ]
    spans = [(r.true_value.interval if r.true_value else r.interval, t) for r, t in claimed or there]
    covering = sum(low <= t <= high for (low, high), t in spans)
    width = float(np.mean([high - low for (low, high), _ in spans])) if spans else 0.0
    why = next((r.why_not_shown for r, _ in there if r.why_not_shown), "") if not claimed else ""
    return HeldByPoints(
        i, kind, parts=len(there), claimed=len(claimed), covering=covering, width=width, why=why
    )
