"""The report of the twin gaska2014: title procedure, readings beside Table 3, one machine at five places, maps as in Fig. 7."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from vcmm import Array, Pose, Scenario, __version__, measuring
from vcmm import charts as draw
from vcmm import effects as fx
from vcmm import report as r
from vcmm import tables as tb
from vcmm.show.pages.uncertainty import pictures
from vcmm.show.pages.view import machine_items, part_items, reach

from .maps import PANELS, field_map, grid
from .nodes import NODES, SHOWN, draw_deviations
from .readings import (
    PAPER_DISTANCE_U,
    PAPER_FORM_U,
    SHOWN_READING,
    ReadingResult,
)
from .twin import (
    PLAN_MACHINES,
    Followed,
    GaskaTwin,
    OtherPlan,
    Row,
    in_detail,
    order,
    span_of,
)

WHAT = (
    "Residual kinematic errors of a Leitz PMM 12106 after Gąska et al., Int. J. Adv. Manuf. Technol. 73 (2014) 497–507. "
    "Published and typed in: the 52 reference nodes, the standard deviations of 8 of them, ν = 13, the maxima and means, "
    "the 14 approaches, five stations, eq. 1, the interpolation, the results. Drawn, because unpublished: the other 44 nodes, where the "
    "stations stood, the part, its five places, the plan, the probe and the tolerances."
)
CAUTION = (
    "Table 3's U is not stated to be an output of the model (the part was measured with a step gauge and a ring), and part, plan and places are "
    "drawn. What the readings say holds for the drawn plan. Form: by the paper's recipe, coverage not demonstrated."
)
STEPS = (
    ("eq. 1: U = 0.2 um + 0.3 um/m", "`tracer.U_CONSTANT`, `tracer.U_LENGTH`, k = 2, plus for the garbled sign; the part with L as one wavelength per station and as noise of every length"),
    ("Table 1: 52 nodes in 13 columns", "`nodes.NODES`"),
    ("section 3: 14 approaches, six axis directions and eight diagonals", "`tracer.DIRECTIONS`; an axis that stands still keeps its last sense (`tracer.senses`). The text's 45 deg to each axis is impossible: a space diagonal has 54.7 deg"),
    ("section 3: five positions of the LaserTracer, one after the other", "`tracer.STATIONS`, drawn: four at the corners, one above; what does not come back from run to run differs between stations"),
    ("dynamic mode, cat's eye on the probe head", "one length per approach; the path between is left out, as in the paper's evaluation"),
    ("eq. 2: coordinates, stations and dead paths by least squares", "`multilateration.locate_points`, all 728 points and five stations together; six numbers of where the whole lies by the nominal nodes"),
    ("Table 2: d(X), d(Y), d(Z)", "`nodes.PUBLISHED`; `calibrating.nodes.node_scatter` finds d from lengths, `vcmm calibrate --nodes` from a file"),
    ("Fig. 4: ellipsoids of the nodes", "in the scene of the report; axis-parallel, since no covariance of X, Y, Z is published"),
    ("dmax, mean d", "`nodes.draw_deviations`; read as those of Table 2's d, whose means they match, though the text calls them differences to nominal"),
    ("section 4: t-law, nu = 13", "`readings.AMOUNTS`: d as its standard deviation or as its scale"),
    ("chi-squared for 10 of 52 nodes", "`calibrating.nodes.t_tests` for all, against a simulated null, since 14 values fill no table; `tracer.untold`"),
    ("section 4, Fig. 5: 13 b-splines over four nodes", "`residual_weights.CURVES`: through the nodes, or with them as control points"),
    ("Fig. 6: plane at z1, nearest neighbour or bilinear", "`residual_weights.field_weights`; bilinear on staggered columns is linear on their triangles"),
    ("x from (y, z), y from (x, z)", "both from (x, y) at z1, as Fig. 6 draws it: with the column's own x and y moved by micrometres the difference is of second order"),
    ("z from the nearest node", "`residual_weights.field_weights`, vertical"),
    ("n Monte Carlo trials of a measuring point", "`readings.matrix`; distance in closed form"),
    ("Fig. 7: maps of the reproduction error", "`maps.field_map`, at one height; in closed form"),
    ("probing plan", "unpublished, drawn; `twin.other_plans` shows what more and fewer touches change"),
    ("section 5: form and distance at five places, Table 3", "`twin.places`, `readings.matrix`"),
    ("correction matrix, step gauge and ring", "left out: no data; the systematic part is taken as corrected, as in the paper"),
    ("grid for a neural network, [29]", "left out: the paper names it as an alternative that it does not take"),
    ("section 6: best place from the shape of the object, with the probe's errors", "`placement.optimum`; `vcmm place gaska2014`"),
    ("section 6: fewer nodes", "`placement.reduction`; random and optimised subsets"),
    ("section 6: number and distribution of probing points", "`vcmm place --plan`"),
)  # fmt: skip
UM = tb.fixed(2, scale=1e3)


def tables(result: GaskaTwin) -> list[tb.ResultTable[Any]]:
    """The same in terminal, report and documentation."""
    return [followed_table(result), readings_table(result), plans_table(result), places_table(result)]


FOLLOWED: tuple[tb.Column[Followed], ...] = (
    tb.Column("hysteresis", lambda f: f.hysteresis, tb.percent(0)),
    tb.Column("L per", lambda f: f.lengths),
    tb.Column("eq. 2 / um", lambda f: f.residual, tb.fixed(2)),
    tb.Column("d", lambda f: f.found, tb.fixed(2)),
    tb.Column("one approach", lambda f: f.single, tb.fixed(2)),
    tb.Column("instrument / um", lambda f: f"{f.instrument[1]:.2f} ({f.instrument[0]:.2f} to {f.instrument[2]:.2f})", tb.NUMBER_TEXT),
    tb.Column("of d < 0.3", lambda f: f.small, tb.percent(0)),
    tb.Column("rejected", lambda f: f.rejected, tb.percent(0)),
    tb.Column("ten quiet", lambda f: f.quiet, tb.percent(0)),
)  # fmt: skip


def followed_table(result: GaskaTwin) -> tb.ResultTable[Followed]:
    """The title procedure."""
    caption = (
        "hysteresis: share of the variance of an approach that its direction makes, the same from every station. L per: the part of U that grows with "
        "the length is one wavelength of a station, or noise of every length. eq. 2: residuals. d: scatter of the solved coordinates, over the true scatter of an approach; one "
        "approach: that freed of what changes between stations, over the same. instrument: its share in d, median and range over nodes; of d < 0.3: its share of the variance of d below "
        "0.3 um. rejected: chi-squared tests below 5 %; ten quiet: probability that ten nodes reject nothing, as the paper's ten."
    )
    return tb.ResultTable("Followed by the LaserTracer", FOLLOWED, result.followed, caption, " ")


def _over(u: Array) -> str:
    mean = u.mean(axis=1) * 1e3
    low, high = span_of(mean)
    return f"{np.median(mean):.2f} ({low:.2f} to {high:.2f})"


def _against(one: ReadingResult) -> str:
    return ", ".join(one.against()) or "nothing"


READ: tuple[tb.Column[ReadingResult], ...] = (
    tb.Column("b-spline, plane, d, per", lambda one: one.reading.words),
    tb.Column("U form / um", lambda one: _over(one.form), tb.NUMBER_TEXT),
    tb.Column("U distance / um", lambda one: _over(one.distance), tb.NUMBER_TEXT),
    tb.Column("hits (p)", lambda one: f"{sum(one.hits())} ({one.hits_p:.2f})", tb.NUMBER_TEXT),
    tb.Column("ratio (> 1)", lambda one: f"{one.ratio()[0]:.2f} ({one.ratio()[1]:.0%})", tb.NUMBER_TEXT),
    tb.Column("p spread", lambda one: "{:.2f} {:.2f}".format(*one.spread), tb.NUMBER_TEXT),
    tb.Column("against", _against),
)


def readings_table(result: GaskaTwin) -> tb.ResultTable[ReadingResult]:
    """Readings of the model beside Table 3."""
    caption = (
        f"{result.draws} machines that agree with the published figures. U: mean over the five places, median and central 95 % of the machines; Table 3: 0.66 and 0.44 um. "
        "hits: how many of the ten U of Table 3 lie in the 95 % of the machines; p: share of the machines that have no more hits themselves. ratio: U form / U distance, mean over "
        "the places (Table 3: 1.50); > 1: share of the machines in which it is so at all five (as in Table 3). p spread: of the five results of form (s = 0.16 um) and distance "
        "(0.28 um), two-sided. against: p or the share below 5 %, or one p of the spread below 2.5 %."
    )
    return tb.ResultTable("Readings of the model beside Table 3", READ, result.matrix, caption, " ")


def _of_result(cell: Callable[[ReadingResult], Any], one: OtherPlan) -> Any:
    return cell(one.result)


def _of_plan(column: tb.Column[ReadingResult]) -> tb.Column[OtherPlan]:
    assert column.head is not None
    return tb.Column(column.head, partial(_of_result, column.cell), column.writing)


OTHER: tuple[tb.Column[OtherPlan], ...] = (
    tb.Column("touches", lambda one: f"{one.face} + {one.bore}", tb.NUMBER_TEXT),
    tb.Column("b-spline, per", lambda one: f"{one.result.reading.curve}, {one.result.reading.redraw}"),
    *(_of_plan(c) for c in READ[1:]),
)


def plans_table(result: GaskaTwin) -> tb.ResultTable[OtherPlan]:
    """Four readings with other numbers of touches."""
    caption = (
        f"The same for {min(PLAN_MACHINES, result.draws)} machines and three plans; the paper gives none."
    )
    return tb.ResultTable("Readings with fewer and more touches", OTHER, result.plans, caption, " ")


def places_table(result: GaskaTwin) -> tb.ResultTable[Row]:
    """Form and distance at every place beside the paper; the same in the terminal, the CSV and the report."""
    n = result.draws
    columns: list[tb.Column[Row]] = [
        tb.Column("place", lambda row: row.place, csv="place"),
        tb.Column("form um", lambda row: row.form.value, UM, csv="form_um"),
        tb.Column("U um", lambda row: row.form.expanded, UM, csv="form_U_um"),
        tb.Column(f"{n} machines", lambda row: span(row.form_range), tb.NUMBER_TEXT, csv="form_U_range_um"),
        tb.Column("paper", lambda row: PAPER_FORM_U[row.place], tb.fixed(1), csv="paper_form_U_um"),
        tb.Column("best in", lambda row: result.shares[row.place][0], tb.percent(0), csv="form_best_share"),
        tb.Column("distance mm", lambda row: row.distance.value, tb.fixed(4), csv="distance_mm"),
        tb.Column("U um", lambda row: row.distance.expanded, UM, csv="distance_U_um"),
        tb.Column(f"{n} machines", lambda row: span(row.distance_range), tb.NUMBER_TEXT, csv="distance_U_range_um"),
        tb.Column("paper", lambda row: PAPER_DISTANCE_U[row.place], tb.fixed(1), csv="paper_distance_U_um"),
        tb.Column("best in", lambda row: result.shares[row.place][1], tb.percent(0), csv="distance_best_share"),
        tb.Column("field's share", lambda row: f"{_field(row.form):.0%}, {_field(row.distance):.0%}", tb.NUMBER_TEXT, csv="field_share", on="terminal"),
    ]  # fmt: skip
    return tb.ResultTable(
        "One machine from the middle, at five places", columns, result.rows, _caption(result), " "
    )


def _caption(result: GaskaTwin) -> str:
    form, distance = ([getattr(row, w).expanded for row in result.rows] for w in ("form", "distance"))
    return (
        f"Draw {SHOWN}, read as {SHOWN_READING.words}: by mean U of the form it ranks {result.ranks[0]} of {result.draws}, by that of the distance {result.ranks[1]}. "
        f"Order of its places from the best: form {order(form)}, distance {order(distance)} (paper: 3 5 1 2 4 and 5 1 3 2 4 with ties). Ranges: central 95 % of the "
        "machines; best in: share of the machines in which the place has the smallest U. Form: by the paper's recipe, coverage not demonstrated."
    )


def _field(c: measuring.CharacteristicResult) -> float:
    """The field's share of u² in the budget."""
    name = fx.ResidualField.name
    return sum(line.share for line in c.budget if line.input.startswith(name))


def span(ends: tuple[float, float]) -> str:
    return f"{ends[0] * 1e3:.2f} … {ends[1] * 1e3:.2f}"


def answers(result: GaskaTwin) -> list[r.AnswerLine]:
    """U of form and distance at the five places, beside the paper's."""
    return [
        r.AnswerLine(
            f"place {row.place}, {what}", f"U = {1e3 * c.expanded:.2f} µm", coverage=f"{span(ends)} µm over {result.draws} machines",
            limits=f"{paper[row.place]:.1f} µm", link="One machine from the middle, at five places", labels=("paper", "", ""),
        )
        for what, paper in (("form", PAPER_FORM_U), ("distance", PAPER_DISTANCE_U))
        for row in result.rows
        for c, ends in [(row.form, row.form_range) if what == "form" else (row.distance, row.distance_range)]
    ]  # fmt: skip


def twin_page(scenario: Scenario, result: GaskaTwin, first: Sequence[str] = ()) -> str:
    """One self-contained HTML file. first: blocks of one plain part, which stand before the published one."""
    blocks = (
        [r.heading("First: one part on one machine"), *first, r.heading("A published part at five places")]
        if first
        else []
    )
    blocks += [r.paragraph(WHAT), r.note(CAUTION, "warning")]
    for one in tables(result):
        blocks += [*tb.titled_html(one), r.paragraph(one.caption)]
    blocks += [r.heading("U of every reading"), *charts(result)]
    blocks += [r.heading(f"Maps as in Fig. 7, at z = {HEIGHT:g} mm"), *maps(scenario)]
    blocks += [r.heading("Machine, part and places"), overview(scenario)]
    shown = next(row for row in result.rows if row.place == "3")
    blocks += [r.heading("Place 3 in detail"), *pictures(in_detail(shown, scenario.settings.rule))]
    blocks += [
        r.heading("The paper, step by step"),
        r.table(["paper", "here"], [[cell.replace("`", "") for cell in row] for row in STEPS]),
    ]
    footer = f"vcmm {__version__}, seed {scenario.settings.seed}. Error = indicated - true."
    title = (
        "Virtual measurement report: one part, and a published one"
        if first
        else "Gąska 2014, virtually measured"
    )
    return r.page(
        title,
        blocks,
        subtitle="" if first else scenario.machine.name,
        footer=footer,
        answers=answers(result),
    )


HEIGHT = 125.0  # mm, between the two lower layers of nodes


def maps(scenario: Scenario) -> list[str]:
    """Panels a to e of Fig. 7 for the machine that is shown, with the five places."""
    marks = [(name, float(pose.shift[0]), float(pose.shift[1])) for name, pose in scenario.places.items()]
    x, y = grid()
    d, out = draw_deviations(SHOWN), []
    for letter, axis, plane in PANELS:
        values = field_map(d, axis, plane, HEIGHT, SHOWN_READING.curve)
        title = f"{letter}: {'XYZ'[axis]}, {plane}"
        out.append(
            draw.on_page(
                draw.heat_map,
                values,
                x,
                y,
                x_label="X / mm",
                y_label="Y / mm",
                unit="µm",
                title=title,
                marks=marks,
            )
        )
    return [r.columns(*out[:2]), r.columns(*out[2:4]), out[4]]


def charts(result: GaskaTwin) -> list[str]:
    """Mean U of form and of distance by reading, medians over the machines."""
    out = []
    for what, paper in (("form", PAPER_FORM_U), ("distance", PAPER_DISTANCE_U)):
        mean = sum(paper.values()) / len(paper)
        items = [
            (one.reading.words, float(np.median(getattr(one, what).mean(axis=1))) * 1e3)
            for one in result.matrix
        ]
        title = f"U of the {what}, mean over the places"
        out.append(draw.on_page(draw.bars, [("Table 3", mean), *items], unit="µm", title=title, share="none"))
    return [r.columns(*out)]


def overview(scenario: Scenario) -> str:
    """The machine's reach, the 52 nodes with their standard deviations, the part at its five places."""
    stylus = next(iter(scenario.plan.styli.values()))
    features = list(scenario.part.features.values())
    low, high = reach(scenario.machine, stylus.offset)
    items = machine_items(low, high, scenario.pose.shift + [0, 0, 120], stylus)
    for name, pose in scenario.places.items():
        items += [body(pose), *part_items(features, pose)]
        items.append(r.Label(pose.shift + [0, 0, 150], name))
    scales = draw_deviations(SHOWN) * 1e-3
    covariances = np.einsum("ni,ij->nij", scales**2, np.eye(3))
    items += [
        r.Points(NODES, "muted", 1.5, name="reference nodes"),
        r.Ellipsoids(NODES, covariances, 2e4, "c4", name="d(X), d(Y), d(Z) of the nodes"),
    ]
    return r.scene(items, title="Places of the part among the reference nodes", view=(-74.0, 36.0))


def body(pose: Pose) -> r.SceneMesh:
    """The drawn body around the bore and between the faces."""
    vertices, faces = r.box_mesh([-94.0, -40.0, 10.0], [94.0, 40.0, 99.0])
    return r.SceneMesh(pose.apply(vertices), faces, "#b9c3cf", 0.55)
