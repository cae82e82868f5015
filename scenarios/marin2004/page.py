"""The report of the twin marin2004: engines compared, regression over a drawn day, the part before and after rewriting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from vcmm import Array, CutScenario, __version__
from vcmm import charts as draw
from vcmm import report as r
from vcmm import tables as tb

from .day import PARAMETERS, SENSORS, UNITS
from .learnt import ANGLE, LENGTH, LearntGeometry
from .rewritten import RewrittenProgram
from .twin import (
    AXES,
    CUT_MINUTES,
    EVERY,
    GEOMETRY,
    LEARNED,
    PLAIN,
    START,
    TABLE,
    UPDATED,
    VALIDATED,
    Agreement,
    MarinTwin,
    ParameterFit,
    PartCut,
    Remainder,
)

WHAT = (
    "D. Marin, Error prediction and compensation for CNC machine tools (SISOM 2004): the errors of a vertical machining "
    "centre as a product of transforms, thermal parameters from temperature sensors, and an NC program that is read, "
    "corrected at every cutter position and written again."
)
CAUTION = (
    "The paper prints formulas and no numbers, so nothing of its can be matched but the algebra. Machine, day, sensors, part "
    "and program are drawn here. Programs are rewritten by multiple regression, one of the paper's two choices; the other, a neural "
    "net, stands beside it in the table of remainders."
)
SOURCES = (
    ("chain w X' Y' b Z t, equations 5 to 22", "the paper's; (11) with z3 where z1 is printed"),
    ("equations 23 to 25", "derived again: minus signs are lost in the text"),
    (
        "equations 20 and 26: relation of the frames, length of the error",
        "the paper's; (20) in the frame of the tool point",
    ),
    ("geometric parameters by regression or net", "the paper's; readings and their noise drawn"),
    ("squareness on X: axy, axz", "the paper's; ayz is not shown there and sits on Z here"),
    ("offsets a, b, c where the errors were measured", "the paper's idea; places drawn"),
    ("parameters by multiple regression on sensors", "the paper's; sensors, days and coefficients drawn"),
    (
        "correction updated while the cut runs; tables of the control",
        "the paper's two routes; from a log of the sensors",
    ),
    (
        "program: identify positions, correct, rewrite (figure 3)",
        "the paper's scheme, by compensate on NC files",
    ),
    ("error tables, travels, part, tool", "drawn"),
)
REWRITTEN = {
    PLAIN: "as programmed",
    GEOMETRY: "geometry",
    START: "state at the start",
    UPDATED: "updated",
    TABLE: "full table",
    AXES: "table of axes",
}


def tables(result: MarinTwin) -> list[tb.ResultTable[Any]]:
    """The same in terminal, report and documentation."""
    return [
        _agreements(result), _learnt(result), _fits(result), _remainders(result), _cuts(result), _programs(result),
        _predictions(result),
    ]  # fmt: skip


LEARNT: tuple[tb.Column[LearntGeometry], ...] = (
    tb.Column("model", lambda row: row.method),
    tb.Column("rms left / µm", lambda row: _spread(row.rms), tb.NUMBER_TEXT),
    tb.Column("largest left / µm", lambda row: _spread(row.largest), tb.NUMBER_TEXT),
)


def _spread(values: tuple[float, ...]) -> str:
    return f"{np.median(values):.2f} ({min(values):.2f} to {max(values):.2f})"


def _learnt(result: MarinTwin) -> tb.ResultTable[LearntGeometry]:
    v = result.volume
    caption = (
        f"Readings at every node with {LENGTH * 1e3:g} µm and {ANGLE * 1e6:g} µrad of noise, {len(result.learnt[0].rms)} draws; what equation 26 then leaves on 343 "
        f"places, where it was {v.mean:.1f} µm in the mean and {v.largest:.1f} µm at most. Equation 20: the workpiece is turned against the tool by {v.turned:.0f} µrad at "
        f"most, and its translation is the correction vector within {v.moved:.1f} nm. The programs below are rewritten with what the network learnt of the first draw."
    )
    return tb.ResultTable("Geometry learnt from readings", LEARNT, result.learnt, caption)


AGREEMENTS: tuple[tb.Column[Agreement], ...] = (
    tb.Column("what", lambda a: a.what),
    tb.Column("against", lambda a: a.against),
    tb.Column(
        "largest difference / nm",
        lambda a: f"{a.nanometres:.2f}" if a.nanometres >= 0.01 else "< 0.01",
        tb.NUMBER_TEXT,
    ),
)


def _agreements(result: MarinTwin) -> tb.ResultTable[Agreement]:
    caption = (
        f"Largest difference of a tip coordinate on 343 places; the tip errors reach {result.largest_um:.1f} µm. The paper's "
        "first-order rotation matrices multiplied out are second order; reference axes and true rotations make the rest. Where "
        "rotations are true, squareness is what remains: vcmm turns the travel, the paper adds a slope."
    )
    return tb.ResultTable(
        "The paper's product against vcmm's engines", AGREEMENTS, result.agreements, caption
    )


FITS: tuple[tb.Column[ParameterFit], ...] = (
    tb.Column("parameter", lambda f: PARAMETERS[f.parameter]),
    tb.Column("unit", lambda f: UNITS[f.parameter].replace("u", "µ", 1)),
    tb.Column("range over the day", lambda f: f.span, tb.fixed(1)),
    tb.Column("rms left", lambda f: f.rms, tb.fixed(2)),
    tb.Column("largest left", lambda f: f.largest, tb.fixed(2)),
)


def _fits(result: MarinTwin) -> tb.ResultTable[ParameterFit]:
    caption = f"Learned on {len(LEARNED)} drawn days from {len(SENSORS)} sensors, judged on another. What is left is looked into below."
    return tb.ResultTable("Thermal parameters by multiple regression", FITS, result.fits, caption)


def _rms_left(i: int, row: Remainder) -> str:
    return f"{row.rms[i]:.2f}"


REMAINDERS: tuple[tb.Column[Remainder], ...] = (
    tb.Column("condition", lambda row: row.condition),
    *(
        tb.Column(f"{name} / {unit.replace('u', 'µ', 1)}", partial(_rms_left, i), tb.NUMBER_TEXT)
        for i, (name, unit) in enumerate(zip(PARAMETERS, UNITS))
    ),
)


def _remainders(result: MarinTwin) -> tb.ResultTable[Remainder]:
    as_drawn, straight, prompt, earlier, net, net_earlier = (row.rms[0] for row in result.remainders)
    caption = (
        f"rms left on the unseen day. Of the {as_drawn:.2f} µm of the first parameter the sensors' lag owns nearly all: without it "
        f"{prompt:.2f} µm are left, without the quadratic share of the structure {straight:.2f} µm. A reading of five minutes ago "
        f"beside that of now tells how fast the node is warming: {earlier:.2f} µm. The network, the paper's other choice, leaves {net:.2f} µm, "
        f"and {net_earlier:.2f} µm with the earlier readings: the law is nearly linear, and a net has no use of that."
    )
    return tb.ResultTable("Where the remainder comes from", REMAINDERS, result.remainders, caption)


def _of(result: MarinTwin, minute: int, model: str) -> PartCut | None:
    return next((c for c in result.cuts if c.state == f"minute {minute}" and c.model == model), None)


@dataclass(frozen=True, eq=False)
class CutFeature:
    """Departures (n,) um of one feature cut by each program, in one state of the machine."""

    state: str
    name: str
    departures: Mapping[str, Array]  # by model


def _mean_and_largest(model: str, row: CutFeature) -> str:
    d = row.departures.get(model)
    return "–" if d is None else f"{d.mean():+.2f} / {np.abs(d).max():.2f}"


CUTS: tuple[tb.Column[CutFeature], ...] = (
    tb.Column("machine", lambda row: row.state),
    tb.Column("feature", lambda row: row.name),
    *(
        tb.Column(words, partial(_mean_and_largest, model), tb.NUMBER_TEXT)
        for model, words in REWRITTEN.items()
    ),
)


def _cuts(result: MarinTwin) -> tb.ResultTable[CutFeature]:
    rows = [
        CutFeature(
            state, name, {c.model: c.departure[name] for c in result.cuts if c.state == f"minute {minute}"}
        )
        for state, minute in (("cold", 0), ("warm", result.warm))
        for name in result.cuts[0].departure
    ]
    caption = (
        f"Mean / largest departure from the drawing, µm, along the outward normal. Cold: minute 0; warm: from minute {result.warm} of the "
        f"validation day, where the head moves most in {CUT_MINUTES:g} minutes; the work zero was set cold. The NC file was rewritten by compensate: for the "
        "geometry, with the state of the sensors when the cut begins, and updated from their log while it runs. Full table, table of axes: the program "
        f"stays, and the control takes off a table that is written anew every {EVERY:g} minutes, of all errors or of each axis along itself. What is "
        "left on the walls cold is geometry that the readings did not tell."
    )
    return tb.ResultTable("The part, cut virtually", CUTS, rows, caption)


PROGRAMS: tuple[tb.Column[RewrittenProgram], ...] = (
    tb.Column("NC file", lambda row: row.name),
    tb.Column("lines", lambda row: row.lines, tb.fixed(0)),
    tb.Column("rewritten", lambda row: row.blocks, tb.fixed(0)),
    tb.Column("off by / µm", lambda row: row.before, tb.fixed(1)),
    tb.Column("after / µm", lambda row: row.after, tb.fixed(2)),
)


def _programs(result: MarinTwin) -> tb.ResultTable[RewrittenProgram]:
    caption = (
        "Files that were not made for this twin, on this mill in the same minutes: largest distance of the tip from the programmed path by the "
        "model that corrects, before and after. The first has arcs and radius compensation, whose ways in and out are one piece."
    )
    return tb.ResultTable("Any program", PROGRAMS, result.programs, caption)


@dataclass(frozen=True)
class PredictedFeature:
    """rms difference, um, between predicted and true departures of a feature, by state and model."""

    name: str
    rms: Mapping[tuple[str, str], float]


def _rms(state: str, model: str, row: PredictedFeature) -> float:
    return row.rms[state, model]


PREDICTIONS: tuple[tb.Column[PredictedFeature], ...] = (
    tb.Column("feature", lambda row: row.name),
    *(
        tb.Column(f"{state}: {words}", partial(_rms, state, model), tb.fixed(2))
        for state in ("cold", "warm")
        for model, words in ((GEOMETRY, "geometry"), (UPDATED, "and thermal"))
        if (state, model) != ("cold", UPDATED)
    ),
)


def _predictions(result: MarinTwin) -> tb.ResultTable[PredictedFeature]:
    asked = {("cold", GEOMETRY): 0, ("warm", GEOMETRY): result.warm, ("warm", UPDATED): result.warm}
    rows = [
        PredictedFeature(
            name, {(state, m): _missed(result, minute, m, name) for (state, m), minute in asked.items()}
        )
        for name in result.cuts[0].departure
    ]
    caption = (
        "rms difference, µm, between the predicted and the true departures of the program as it was: geometry as learnt from readings, and the "
        "regression on the sensors."
    )
    return tb.ResultTable("Predicted without rewriting", PREDICTIONS, rows, caption)


def _missed(result: MarinTwin, minute: int, model: str, name: str) -> float:
    guess, real = _of(result, minute, model), _of(result, minute, PLAIN)
    assert guess is not None
    assert real is not None
    assert guess.predicted is not None
    return float(np.sqrt(np.mean((guess.predicted[name] - real.departure[name]) ** 2)))


def answers(result: MarinTwin) -> list[r.AnswerLine]:
    """How far off every program runs, rewritten and as it was."""
    return [
        r.AnswerLine(
            row.name, f"at most {row.after:.2f} µm", coverage="rewritten, by the model that corrects", limits=f"{row.before:.1f} µm",
            link="Any program", labels=("as it was", "", ""),
        )
        for row in result.programs
    ]  # fmt: skip


def twin_page(scenario: CutScenario, result: MarinTwin) -> str:
    """One self-contained HTML file."""
    blocks = [r.paragraph(WHAT), r.note(CAUTION, "warning")]
    blocks.append(r.table(["input", "whose"], SOURCES, caption="What is the paper's, and what is drawn."))
    for table in tables(result):
        blocks += tb.titled_html(table)
    blocks += [r.heading("Equation 26, volumetric error"), _volume(result)]
    blocks += [r.heading("The drawn day"), _day(result), r.heading("The surface, warm"), _scenes(result)]
    footer = f"vcmm {__version__}. Machining error = actual - commanded; departures along the outward normal, plus is material left."
    return r.page(
        "Marin 2004: chain, warm-up, rewritten program",
        blocks,
        subtitle=scenario.machine.name,
        footer=footer,
        answers=answers(result),
    )


def _volume(result: MarinTwin) -> str:
    v = result.volume
    return draw.on_page(draw.heat_map,
        v.error, v.x, v.y, x_label="X / mm", y_label="Y / mm", unit="µm", title="Length of the error, middle of Z")  # fmt: skip


def _day(result: MarinTwin) -> str:
    """Sensors, and the first parameter as it is and as the regression says."""
    today, minute = result.today, result.today.minute
    sensors = [draw.PlotSeries(minute, today.sensors[:, i], name) for i, name in enumerate(SENSORS)]
    one = draw.on_page(
        draw.curve,
        sensors,
        x_label="minute of the day",
        y_label="sensor / °C",
        title=f"Validation day (seed {VALIDATED})",
        zero_line=False,
    )
    said = result.model.at(today.sensors)
    both = [
        draw.PlotSeries(minute, today.parameters[:, 0], "true"),
        draw.PlotSeries(minute, said[:, 0], "regression"),
    ]
    return r.columns(
        one,
        draw.on_page(
            draw.curve,
            both,
            x_label="minute of the day",
            y_label="EZZ, displacement of the head / µm",
            title="Growth of spindle and column",
        ),
    )


def _scenes(result: MarinTwin) -> str:
    """Departure of all features on one scale each: as programmed and rewritten."""
    charts = []
    for model in (PLAIN, UPDATED):
        cut = _of(result, result.warm, model)
        assert cut is not None
        items = [
            r.SceneMesh(
                v.net.points,
                v.net.faces,
                values=cut.departure[v.net.feature],
                unit="µm",
                symmetric=True,
                edges=False,
            )
            for v in result.views
        ]
        charts.append(
            r.scene(
                items,
                title=f"Warm, {REWRITTEN[model]}",
                caption="Departure along the outward normal; drawing frame.",
            )
        )
    return r.columns(*charts)
