"""The report of the twin marin2004: engines compared, regression over a drawn day, the part before and after rewriting."""

from __future__ import annotations

import numpy as np

from vcmm import __version__
from vcmm import report as r
from vcmm.machining.scenario import CutScenario
from vcmm.pages.tables import Shown, html
from vcmm.papers.marin2004.day import PARAMETERS, SENSORS, UNITS
from vcmm.papers.marin2004.twin import COLD, LEARNED, MODELS, VALIDATED, WARM, Cut, Result

WHAT = (
    "D. Marin, Error prediction and compensation for CNC machine tools (SISOM 2004): the errors of a vertical machining "
    "centre as a product of transforms, thermal parameters from temperature sensors, and an NC program that is read, "
    "corrected at every cutter position and written again."
)
CAUTION = (
    "The paper prints formulas and no numbers, so nothing of its can be matched but the algebra. Machine, day, sensors, part "
    "and program are drawn here. Multiple regression is used, one of the paper's two choices. A neural net could learn what "
    "a linear model of this minute's readings cannot: the bent share of the spindle's growth and, fed with earlier readings, "
    "the lag between sensor and structure. The residuals below bound what it could gain."
)
SOURCES = (
    ("chain w X' Y' b Z t, equations 5 to 22", "the paper's; (11) with z3 where z1 is printed"),
    ("equations 23 to 25", "derived again: minus signs are lost in the text"),
    ("squareness on X: axy, axz", "the paper's; ayz is not shown there and sits on Z here"),
    ("offsets a, b, c where the errors were measured", "the paper's idea; places drawn"),
    ("parameters by multiple regression on sensors", "the paper's; sensors, days and coefficients drawn"),
    (
        "program: identify positions, correct, rewrite (figure 3)",
        "the paper's scheme; lines of 10 mm at most",
    ),
    ("error tables, travels, part, tool", "drawn"),
)
REWRITTEN = {
    MODELS[0]: "as programmed",
    MODELS[1]: "rewritten: geometry",
    MODELS[2]: "rewritten: geometry, thermal",
}


def tables(result: Result) -> list[Shown]:
    """The same in terminal, report and documentation."""
    return [_agreements(result), _fits(result), _cuts(result), _predictions(result)]


def _agreements(result: Result) -> Shown:
    rows = tuple((a.what, a.against, _nm(a.nanometres)) for a in result.agreements)
    caption = (
        f"Largest difference of a tip coordinate on 343 places; the tip errors reach {result.largest_um:.1f} µm. The paper's "
        "first-order rotation matrices multiplied out are second order; reference axes and true rotations make the rest. Where "
        "rotations are true, squareness is what remains: vcmm turns the travel, the paper adds a slope."
    )
    return Shown(
        "The paper's product against vcmm's engines",
        ("what", "against", "largest difference / nm"),
        rows,
        caption,
        (0, 1),
    )


def _nm(value: float) -> str:
    return f"{value:.2f}" if value >= 0.01 else "< 0.01"


def _fits(result: Result) -> Shown:
    rows = tuple(
        (
            PARAMETERS[f.parameter],
            UNITS[f.parameter].replace("u", "µ", 1),
            f"{f.span:.1f}",
            f"{f.rms:.2f}",
            f"{f.largest:.2f}",
        )
        for f in result.fits
    )
    caption = (
        f"Learned on {len(LEARNED)} drawn days from {len(SENSORS)} sensors, judged on another. The first parameter holds a "
        "quadratic share that a linear model cannot follow."
    )
    columns = ("parameter", "unit", "range over the day", "rms left", "largest left")
    return Shown("Thermal parameters by multiple regression", columns, rows, caption, (0, 1))


def _of(result: Result, minute: int, model: str) -> Cut:
    return next(c for c in result.cuts if c.state == f"minute {minute}" and c.model == model)


def _cuts(result: Result) -> Shown:
    rows = []
    for state, minute in (("cold", COLD), ("warm", WARM)):
        chosen = [_of(result, minute, model).departure for model in MODELS]
        for name in chosen[0]:
            rows.append(
                (state, name, *(f"{d[name].mean():+.2f} / {np.abs(d[name]).max():.2f}" for d in chosen))
            )
    columns = ("machine", "feature", *REWRITTEN.values())
    caption = (
        f"Mean / largest departure from the drawing, µm, along the outward normal. Cold: minute {COLD}; warm: minute {WARM} of the "
        "validation day; the work zero was set cold. What is left cold comes from the rotations: the edge that cuts is not the tip "
        "that was corrected. Warm, what the regression misses is added."
    )
    return Shown("The part, cut virtually", columns, tuple(rows), caption, (0, 1))


def _predictions(result: Result) -> Shown:
    rows = []
    for name in result.cuts[0].departure:
        cells = []
        for minute in (COLD, WARM):
            truth = _of(result, minute, MODELS[0]).departure[name]
            for model in MODELS[1:]:
                said = _of(result, minute, model).predicted
                assert said is not None
                cells.append(f"{np.sqrt(np.mean((said[name] - truth) ** 2)):.2f}")
        rows.append((name, *cells))
    columns = ("feature", "cold: geometry", "cold: and thermal", "warm: geometry", "warm: and thermal")
    caption = (
        "rms difference, µm, between the predicted and the true departures of the program as it was. Cold it is zero because the "
        "predictor has the true error tables."
    )
    return Shown("Predicted without rewriting", columns, tuple(rows), caption)


def twin_page(scenario: CutScenario, result: Result) -> str:
    """One self-contained HTML file."""
    blocks = [r.paragraph(WHAT), r.note(CAUTION, "warning")]
    blocks.append(r.table(["input", "whose"], SOURCES, caption="What is the paper's, and what is drawn."))
    for shown in tables(result):
        blocks += html(shown)
    blocks += [r.heading("The drawn day"), _day(result), r.heading("The surface, warm"), _scenes(result)]
    footer = f"vcmm {__version__}. Machining error = actual - commanded; departures along the outward normal, plus is material left."
    return r.page(
        "Marin 2004: chain, warm-up, rewritten program", blocks, subtitle=scenario.machine.name, footer=footer
    )


def _day(result: Result) -> str:
    """Sensors, and the first parameter as it is and as the regression says."""
    today, minute = result.today, result.today.minute
    sensors = [r.Series(minute, today.sensors[:, i], name) for i, name in enumerate(SENSORS)]
    one = r.curve(
        sensors,
        x_label="minute of the day",
        y_label="sensor / °C",
        title=f"Validation day (seed {VALIDATED})",
        zero_line=False,
    )
    said = result.model.at(today.sensors)
    both = [r.Series(minute, today.parameters[:, 0], "true"), r.Series(minute, said[:, 0], "regression")]
    return r.columns(
        one,
        r.curve(
            both,
            x_label="minute of the day",
            y_label="EZZ, displacement of the head / µm",
            title="Growth of spindle and column",
        ),
    )


def _scenes(result: Result) -> str:
    """Departure of all features on one scale each: as programmed and rewritten."""
    charts = []
    for model in (MODELS[0], MODELS[2]):
        cut = _of(result, WARM, model)
        items = [
            r.Mesh(
                v.net.points,
                v.net.faces,
                values=cut.departure[v.net.feature],
                unit="µm",
                symmetric=True,
                edges=False,
                cull=False,
            )
            for v in result.seen
        ]
        charts.append(
            r.scene(
                items,
                title=f"Warm, {REWRITTEN[model]}",
                caption="Departure along the outward normal; drawing frame.",
            )
        )
    return r.columns(*charts)
