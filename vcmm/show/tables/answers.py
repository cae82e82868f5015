"""The answer of every job in the lines that its report and its terminal show first (`vcmm.show.report.answers`)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vcmm.answer.placing.words import changes, goal_text, pose_text
from vcmm.show.report.answers import AnswerLine, K, answer_of, places_of, signed_value
from vcmm.show.report.trade_words import contributor
from vcmm.show.tables.quantities import SMALL_SCALE

if TYPE_CHECKING:
    from vcmm.answer.placing.planning import PlanResult
    from vcmm.answer.placing.result import PlacementResult
    from vcmm.answer.routes.job import RoutesResult
    from vcmm.core.machine import Machine
    from vcmm.learn.diagnosis.comparison import Comparison
    from vcmm.shop.machining.placement import PlacedCut
    from vcmm.task.response.volumetric import ErrorField


def place_answers(placed: PlacementResult) -> list[AnswerLine]:
    """Return the answer whether to move the part, by the gain that was confirmed; then every characteristic where it should lie."""
    sure, gain = placed.confirmation, placed.gain
    moving = worth_moving(placed)
    verdict, kind = ("move the part", "good") if moving else ("leave the part where it is", "muted")
    result, coverage = (
        ("the present pose cannot be used", "") if gain is None else (f"gain {gain:.1%}", "by the search")
    )
    if sure is not None and sure.present:
        half = K * 100 * sure.u_gain / abs(sure.present)
        confirmed = "confirmed" if sure.is_confirmed else "not confirmed"
        result = f"gain {signed_value(100 * sure.gain / sure.present, half, '%')}"
        coverage = f"k = {K:.0f}, {confirmed} by {sure.trials:,} paired trials of their own"
    first = AnswerLine(
        "Where to put the part",
        result,
        coverage=coverage,
        limits=f"of {goal_words(placed)}",
        verdict=verdict,
        kind=kind,  # type: ignore[arg-type]
        because=_largest_change(placed),
        change=pose_text(
            placed.region.convenient if placed.region.convenient is not None else placed.best.pose
        )
        if moving
        else "",
        link="Poses compared",
        numbers={
            "gain": None if sure is None or not sure.present else sure.gain / sure.present,
            "moving": moving,
        },
        labels=("", "", "convenient pose:"),
    )
    at = placed.after if moving or placed.before is None else placed.before
    where = "at the pose found" if at is placed.after else "at the present pose"
    lines = [answer_of(c) for c in at.characteristics if placed.objective.weights.get(c.name)]
    return [first, *(_with_name(line, f"{line.name}, {where}") for line in lines)]


def goal_words(placed: PlacementResult) -> str:
    """Return the goal in words, such as "U/T of bore diameter, bore to front"; equal weights are not written out."""
    goal = placed.objective.goal
    if len({round(w, 9) for w in goal.weights.values() if w}) > 1:
        return goal_text(goal)
    kinds = " + ".join(f"{v:g} {k}" if v != 1 else str(k) for k, v in goal.mixture.items() if v)
    return f"{kinds} of {', '.join(n for n, w in goal.weights.items() if w)}, equal weights"


# U is stated with two digits: less than half of their smallest step (10 to 9.5) is not seen in it
SMALL_GAIN = 0.05


def worth_moving(placed: PlacementResult) -> bool:
    """Return whether the gain is confirmed and is visible in U as stated; a present pose that cannot be used is left."""
    sure, gain = placed.confirmation, placed.gain
    if gain is None:
        return True
    if sure is not None and not sure.is_confirmed:
        return False
    if sure is not None and sure.present:
        gain = sure.gain / sure.present
    return gain >= SMALL_GAIN


def _with_name(line: AnswerLine, name: str) -> AnswerLine:
    from dataclasses import replace

    return replace(line, name=name, link="")


def _largest_change(placed: PlacementResult) -> str:
    """Return the influence whose variance changes most between the poses."""
    lines = [
        (abs(new**2 - old**2), name, of)
        for of, _, all_of_them, _ in changes(placed)
        for name, old, new in all_of_them
    ]
    if not lines:
        return ""
    _, name, of = max(lines)
    line = next(
        (b for c in placed.after.characteristics if c.name == of for b in c.budget if b.input == name), None
    )
    return f"changes most with the place: {contributor(line) if line else name} ({of})"


def placed_cut_answers(placed: PlacedCut) -> list[AnswerLine]:
    """Return the gain of moving part and work offset; then the characteristics of the part cut at the best pose."""
    moving = placed.gain >= SMALL_GAIN
    first = AnswerLine(
        "Where to put the part",
        f"gain {placed.gain:.1%}",
        coverage="by the known errors",
        limits="of weighted deviations as shares of the tolerance",
        verdict="move part and work offset" if moving else "leave the part where it is",
        kind="good" if moving else "muted",
        change=pose_text(placed.best.pose) if moving else "",
        link="Poses",
        numbers={"gain": placed.gain, "moving": moving},
        labels=("", "", "convenient pose:"),
    )
    at = placed.after if moving else placed.before
    where = "at the pose found" if moving else "at the present pose"
    return [first, *(_with_name(answer_of(c), f"{c.name}, {where}") for c in at.characteristics)]


def field_answers(machine: Machine, error_map: ErrorField) -> list[AnswerLine]:
    """Return the largest tip error with its place and U."""
    worst = int(error_map.size.argmax())
    at = ", ".join(f"{a} {error_map.run.q(a)[worst]:.4g} mm" for a in machine.chain.letters if a in "XYZ")
    parts = error_map.tip_error[worst] * 1e3
    axis = int(np.abs(parts).argmax())
    half = 0.0 if error_map.u is None else K * 1e3 * float(error_map.u[worst, axis])
    largest = float(error_map.size[worst]) * 1e3
    whole = 0.0 if error_map.u is None else K * 1e3 * float(error_map.u.max())
    no_half = (
        f"the Inputs give no U here, elsewhere up to {whole:.{places_of(whole)}f} µm"
        if whole
        else "no Inputs are stated, so no U"
    )
    first = AnswerLine(
        "Largest tip error",
        f"{largest:.{places_of(half) if half else 2}f} µm",
        coverage=f"k = {K:.0f}, U of one positioning" if half else no_half,
        limits=at,
        kind="muted",
        because=f"along {'xyz'[axis]}: {signed_value(float(parts[axis]), half, 'µm')}",
        link="Volumetric error",
        numbers={"largest_um": largest, "U_um": half or None},
        labels=("at", "mostly", ""),
    )
    mean = float(error_map.size.mean()) * 1e3
    return [first, AnswerLine("Mean tip error", f"{mean:.2f} µm", f"{error_map.run.n} points")]


def compare_answers(rows: Sequence[Comparison], names: Sequence[str]) -> list[AnswerLine]:
    """Return the machine files by their residuals, the best first."""
    unit, scale = ("µrad", 1e6) if rows[0].angle else ("µm", 1e3)
    best = min(c.rms for c in rows)
    out = []
    for c, name in sorted(zip(rows, names), key=lambda pair: pair[0].rms):
        least = c.rms == best and len(rows) > 1
        worst = min((p for part in c.parts for p in part.depends_on), key=lambda p: p.p, default=None)
        out.append(
            AnswerLine(
                name,
                f"rms {c.rms * scale:.3g} {unit}",
                coverage=f"noise {c.noise * scale:.3g} {unit}",
                verdict="leaves least" if least else "",
                kind="good",
                because=f"the rest depends on {worst.covariate}" if worst else "",
                numbers={"rms": c.rms, "noise": c.noise},
            )
        )
    return out


def routes_answers(compared: RoutesResult) -> list[AnswerLine]:
    """Return every characteristic by its first route, and whether all routes agree."""
    out = []
    for c in compared.characteristics:
        first = c.routes[0]
        scale, word = SMALL_SCALE[c.unit], {"mm": "µm", "rad": "µrad"}[c.unit]
        apart = max(
            (abs(a.difference) / a.expanded for a in c.agreements if a.expanded > 0), default=math.nan
        )
        owner = max(first.contributions, key=lambda line: line.u, default=None)
        agree = not apart > 1.0
        half = first.expanded * scale
        out.append(
            AnswerLine(
                c.name,
                f"{first.value:.5f} {c.unit} ± {half:.{places_of(half) if half > 0 else 2}f} {word}",
                coverage=f"{first.route}, k = {first.k:.2f}",
                verdict=""
                if math.isnan(apart)
                else ("routes agree" if agree else "routes do not agree") + f", |E_n| ≤ {apart:.2f}",
                kind="good" if agree else "bad",
                because=owner.name if owner else "",
                link="By every route",
                numbers={"name": c.name, "value": first.value, "U": first.expanded},
            )
        )
    return out


def plan_answers(result: PlanResult, units: dict[str, str]) -> list[AnswerLine]:
    """Return U of the chosen plan and of the present one, and their measuring times."""
    out = []
    for name, expanded in result.choice.expanded.items():
        scale, word = SMALL_SCALE[units[name]], {"mm": "µm", "rad": "µrad"}[units[name]]
        was = result.present.expanded.get(name)
        before = "" if was is None else f", was {was * scale:.{places_of(was * scale)}f} {word}"
        out.append(
            AnswerLine(
                name,
                f"U = {expanded * scale:.{places_of(expanded * scale)}f} {word}{before}",
                f"{result.choice.minutes:.1f} min, was {result.present.minutes:.1f} min",
                numbers={"name": name, "U": expanded},
            )
        )
    return out
