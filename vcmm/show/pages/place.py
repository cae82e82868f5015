"""The report of a placement: poses compared, map, region within 2 %, budgets side by side, the part where it goes."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm import __version__
from vcmm.answer.placing.advice import room_and_shares
from vcmm.answer.placing.words import UNITS, changes, goal_text, pose_text, region_text
from vcmm.show import charts as draw
from vcmm.show import report as r
from vcmm.show.pages.header import facts
from vcmm.show.pages.view import part_items, touch_items, volume_items
from vcmm.show.tables.answers import place_answers, placed_cut_answers
from vcmm.show.tables.placement import OTHER_DRAWS, compared_cut_poses, compared_poses, gains
from vcmm.show.tables.table import html, listing
from vcmm.task.measuring.fixture import DOFS, pose_of

if TYPE_CHECKING:
    from vcmm.answer.placing.result import PlacementResult
    from vcmm.shop.machining.placement import PlacedCut
    from vcmm.task.measuring.cut_scenario import CutScenario

WORDS = {"x": "shift x / mm", "y": "shift y / mm", "z": "shift z / mm", "turn_x": "turn x / °", "turn_y": "turn y / °", "turn_z": "turn z / °"}  # fmt: skip


def place_page(placed: PlacementResult) -> str:
    """Return one self-contained HTML file."""
    scenario = placed.objective.scenario
    blocks = [
        r.paragraph(f"Minimised: {goal_text(placed.objective.goal)}."),
        r.heading("Poses compared"),
        html(compared_poses(placed), emphasise=(0,)),
    ]
    blocks += [r.heading("Advice"), *map(r.paragraph, room_and_shares(placed))]
    blocks += r.notices(placed.warnings)
    blocks += [r.heading("How sure"), sure_table(placed)]
    blocks += [r.heading("Over the table"), *maps(placed)]
    if placed.before is not None:
        blocks += [r.heading("Why: which influence shrinks"), *budgets(placed)]
    blocks += [r.heading("Where the part goes"), scene(placed)]
    footer = (
        f"vcmm {__version__}, seed {placed.seed}. Pose: shift of the part's origin after turns about the fixed x, then y, "
        "then z. The search is in closed form; budgets and the gain are those of the full evaluation."
    )
    return r.page(
        f"Placement report: {scenario.name}",
        blocks,
        footer=footer,
        answers=place_answers(placed),
        facts=facts("", scenario.machine.name, scenario.record, placed.seed),
    )


def sure_table(placed: PlacementResult) -> str:
    """Return the certificate, confirmation, flatness, effort."""
    rows: list[list[object]] = [["certificate", placed.certificate.text], ["flatness", region_text(placed)]]
    sure = placed.confirmation
    if sure is not None:
        verdict = r.Cell(
            "confirmed" if sure.is_confirmed else "not confirmed",
            kind="good" if sure.is_confirmed else "warning",
        )
        rows.insert(0, ["the gain above is", verdict])
        rows.insert(1, ["by", f"{sure.trials:,} paired trials with a seed of their own, {OTHER_DRAWS}"])
    rows.append(
        [
            "search",
            f"{placed.evaluations} evaluations; {placed.feasible_share:.1%} of the fixture's poses can be used",
        ]
    )
    if placed.region.convenient is not None:
        rows.append(["convenient pose", pose_text(placed.region.convenient)])
    return r.table(["", ""], rows)


def maps(placed: PlacementResult) -> list[str]:
    """Return the objective over two degrees of freedom, and where it lies within 2 % of the best value."""
    chart = placed.map
    if len(chart.names) < 2:
        return (
            [_line(placed)]
            if chart.names
            else [r.paragraph("Nothing is free to move continuously: there is no map.")]
        )
    word, scale = UNITS.get(placed.objective.unit, ("", 1.0))
    x, y = chart.axis_values(0)[1], chart.axis_values(1)[1]
    marks = [("found", *_at(placed, placed.best.pose))]
    if placed.present is not None and _in_the_map(placed, placed.present.pose):
        marks.append(("present", *_at(placed, placed.present.pose)))
    labels: Any = {"x_label": WORDS[chart.names[0]], "y_label": WORDS[chart.names[1]]}
    whole = draw.on_page(draw.heat_map,
        chart.values * scale, x, y, unit=word or "objective", title="Objective, other freedoms as at the pose found", marks=marks, **labels)  # fmt: skip
    loss = np.round(100 * (chart.values / placed.best.value - 1), 3) + 0.0  # the rest is rounding
    flat = draw.on_page(draw.heat_map,
        np.minimum(loss, 10.0), x, y, unit="%", title="Loss against the pose found, up to 10 %", marks=marks[:1], **labels)  # fmt: skip
    return [r.columns(whole, flat)]


def _in_the_map(placed: PlacementResult, six: np.ndarray) -> bool:
    """Return whether a pose agrees with the best pose in all freedoms but the two of the map, so that its colour there is valid."""
    others = [i for i, name in enumerate(DOFS) if name not in placed.map.names[:2]]
    return bool(np.allclose(six[others], placed.best.pose[others], rtol=0, atol=1e-6))


def _at(placed: PlacementResult, six: np.ndarray) -> tuple[float, float]:
    """Return the place of a pose in the map; NaN where it lies outside of it."""
    out = []
    for k, name in enumerate(placed.map.names[:2]):
        value = float(six[DOFS.index(name)])
        axis = (placed.map.x, placed.map.y)[k]
        inside = axis[0] - 1e-9 <= value <= axis[-1] + 1e-9
        out.append((np.degrees(value) if name.startswith("turn") else value) if inside else np.nan)
    return float(out[0]), float(out[1])


def _line(placed: PlacementResult) -> str:
    """Return the objective over the one degree of freedom that is free."""
    word, scale = UNITS.get(placed.objective.unit, ("", 1.0))
    name = placed.map.names[0]
    good = np.isfinite(placed.map.values[0])
    series = [
        draw.PlotSeries(placed.map.axis_values(0)[1][good], placed.map.values[0][good] * scale, "objective")
    ]
    return draw.on_page(
        draw.curve,
        series,
        x_label=WORDS[name],
        y_label=f"objective / {word}" if word else "objective",
        title="Objective",
    )


def budgets(placed: PlacementResult) -> list[str]:
    """Return the contributions of the influences at both poses, side by side, for every characteristic that counts."""
    out = []
    assert placed.before is not None
    for name, unit, lines, _ in changes(placed):
        word, scale = UNITS[unit]
        before = next(c for c in placed.before.characteristics if c.name == name)
        after = next(c for c in placed.after.characteristics if c.name == name)
        kept = [line for line in lines if max(line[1], line[2]) > 1e-3 * before.u][:8]
        kept.sort(key=lambda line: -line[1])
        longest = max((u * scale for _, *both in kept for u in both), default=0.0)
        charts = []
        for k, (title, c) in enumerate((("present", before), ("found", after))):
            found_u = [(n, (present, best)[k]) for n, present, best in kept]
            items = [(n, u * scale if u > 1e-6 * c.u else 0.0) for n, u in found_u]  # the rest is rounding
            charts.append(
                draw.on_page(
                    draw.bars,
                    items,
                    unit=word,
                    title=f"{name}: {title}, U = {c.expanded * scale:.3g} {word}",
                    total=c.u * scale,
                    longest=longest,
                )
            )
        out.append(r.columns(*charts))
    return out


def scene(placed: PlacementResult) -> str:
    """Return the machine with the part at the best pose, and a ghost at its present pose."""
    task = placed.after.model.task
    t = task.touches
    features = list(task.part.features.values())
    last = t.pose.apply(t.points[-1:] + t.tip_radius[-1] * t.normals[-1:])[0]
    stylus = task.plan.styli[task.plan.steps[-1].stylus]
    items = [
        *volume_items(task.machine, stylus, last),
        *part_items(features, t.pose, task.part.mesh),
        *touch_items(t),
    ]
    if placed.present is not None:
        here = pose_of(placed.present.pose).apply(t.points)
        items.append(r.Points(here, "muted", 1.6, name="touches at the present pose"))
    return r.scene(
        items, title="Part at the pose found", caption="Machine frame; the wire box is the reach of the tip."
    )


def place_cut_page(scenario: CutScenario, placed: PlacedCut) -> str:
    """Return one self-contained HTML file."""
    blocks = [
        r.heading("Poses"),
        html(compared_cut_poses(placed)),
        r.heading("What each characteristic gains"),
        html(gains(placed)),
    ]
    blocks += [r.heading("Map over the table"), _map(placed)]
    sure = [["certificate", placed.certificate.text], ["flatness", region_text(placed)]]
    blocks += [r.heading("How sure, how flat"), html(listing("", ["", ""], sure, words=(0, 1)))]
    footer = f"vcmm {__version__}, seed {placed.seed}. Part and work offset move together; the program stays as it is."
    return r.page(
        f"Placement report: {scenario.name}",
        blocks,
        footer=footer,
        answers=placed_cut_answers(placed),
        facts=facts(
            "", scenario.machine.name, scenario.record, placed.seed, [("program", scenario.program.name)]
        ),
    )


def _map(placed: PlacedCut) -> str:
    chart = placed.map
    if len(chart.names) < 2:
        return r.paragraph("One degree of freedom or none: no map.")
    return draw.on_page(draw.heat_map,
        chart.values, chart.x, chart.y, x_label=f"{chart.names[0]} / mm", y_label=f"{chart.names[1]} / mm", unit="",
        title="objective", marks=[("found", placed.best.pose[0], placed.best.pose[1]), ("present", placed.present.pose[0], placed.present.pose[1])],
        ax=draw.ChartSheet(900, 480))  # fmt: skip
