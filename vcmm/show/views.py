"""Register the pictures and lines of results, which `plot()` and repr use, with `vcmm.core.views`."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.answer.evaluation.result import (
    ROUNDING,
    SHOWN_IN,
    Budgets,
    CharacteristicResult,
    PlottedBudget,
    UncertaintyResult,
    closed_form,
)
from vcmm.answer.placing.result import PlacementResult
from vcmm.core.axes import LINEAR, is_rotary
from vcmm.core.views import line, picture
from vcmm.files.learned.last_checks import check_parts
from vcmm.files.learned.track_result import Track
from vcmm.learn.calibration.identifiability import is_angle
from vcmm.learn.calibration.result import Calibration
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.shop.machining.result import CutResult, rms_text
from vcmm.show import charts
from vcmm.show.charts.bars import MOST_BARS
from vcmm.show.charts.distribution import coarsen
from vcmm.show.pages.track import beside_forecast, number_over_time
from vcmm.show.report.answers import answer_of, in_one_line
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.response.recording import Recording
from vcmm.task.response.volumetric import ErrorField

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Sheet = Any  # Axes, a ChartSheet of a page, or None for a new figure


@picture.register(PlottedBudget)
def budget_picture(budget: PlottedBudget, ax: Sheet = None, title: str = "budget") -> Axes:
    return charts.contributions(budget, title, ax)


@picture.register(CharacteristicResult)
def distribution(c: CharacteristicResult, ax: Sheet = None) -> Axes:
    unit, scale = SHOWN_IN[c.unit]
    from_nominal = lambda ends: tuple((e - c.nominal) * scale for e in ends)  # noqa: E731
    edges, counts = coarsen(*c.summary.histogram) if c.summary else closed_form(c)
    return charts.distribution(
        (edges - c.nominal) * scale,
        counts,
        interval=from_nominal(c.interval),
        limits=from_nominal(c.tolerance) if c.tolerance else None,
        marks={"result": (c.value - c.nominal) * scale},
        unit=unit,
        title=f"{c.name}: deviation from {c.nominal:g} {c.unit}"
        + (" as indicated; interval of the true value" if c.true_value else ""),
        ax=ax,
    )


@picture.register(Budgets)
def budget_pictures(budgets: Budgets) -> list[Axes]:
    rows = [min(sum(line.share >= ROUNDING for line in b), MOST_BARS) for b in budgets.values()]
    return [
        b.plot(ax, name) for ax, (name, b) in zip(charts.panels(len(budgets), rows=rows), budgets.items())
    ]


@picture.register(UncertaintyResult)
def characteristics(result: UncertaintyResult) -> list[Axes]:
    drawn = zip(result.characteristics, charts.panels(len(result.characteristics)))
    return [c.plot(ax) for c, ax in drawn]


@picture.register(PlacementResult)
def placement(placed: PlacementResult, ax: Sheet = None) -> Axes:
    (across, x), (up, y) = placed.map.axis_values(0), placed.map.axis_values(1)
    unit, scale = SHOWN_IN.get(placed.objective.unit, ("objective", 1.0))
    values = placed.map.values * scale
    if len(y) < 2:
        course = [charts.PlotSeries(x, values[0], placed.objective.unit)]
        return charts.curve(
            course, x_label=across, y_label=unit, title="where to put the part", zero_line=False, ax=ax
        )
    return charts.heat_map(
        values, x, y, x_label=across, y_label=up, unit=unit, title="where to put the part", ax=ax
    )


@picture.register(Calibration)
def error_curve(result: Calibration, name: str, ax: Sheet = None) -> Axes:
    nodes, value, u = result.along(name) if len(result.band(name)[0]) > 1 else result.band(name)
    unit, scale = ("µrad", 1e6) if is_angle(name) else ("µm", 1e3)
    turns = any(c.component == name and c.rotary for c in result.kept.curves)
    place, label = (np.degrees(nodes), "angle / deg") if turns else (nodes, "position / mm")
    return charts.band(place, value * scale, u * scale, unit=unit, title=name, label=label, ax=ax)


@picture.register(Diagnosis)
def probabilities(result: Diagnosis, ax: Sheet = None) -> Axes:
    names = [f"{a.effect} {' '.join(map(str, a.where.values()))}".strip() for a in result.answer]
    return charts.probabilities(names, [a.probability for a in result.answer], result.verdict, ax)


@picture.register(Track)
def over_time(track: Track, name: str | None = None, ax: Sheet = None) -> Axes:
    if name and name.split(" ")[0] in [c.name for c in track.checks]:
        return beside_forecast(check_parts(track, name)[0], ax)
    course = track.course(name) if name else max(track.courses, key=lambda c: c.change_over_u)
    return number_over_time(track, course, ax)


@picture.register(CutResult)
def surface(cut: CutResult, ax: Sheet = None) -> Axes:
    none = np.zeros((0, 3))
    places = np.concatenate([none, *(p.net.points for p in cut.patches)])
    height = np.concatenate([none[:, 0], *(p.height for p in cut.patches)])
    return charts.heights(places, 1e3 * height, f"cut surface{rms_text(cut.surface)}", ax)


@picture.register(Scenario)
def touches(scenario: Scenario, ax: Sheet = None) -> Axes:
    placed = scenario.task().touches
    normals = placed.pose.turn(placed.normals)
    at, names = placed.pose.apply(placed.points), placed.run.labels["feature"]
    return charts.touches(at, normals, names, scenario.name, ax)


@picture.register(Recording)
def readings(recording: Recording, ax: Sheet = None) -> Axes:
    moved = {axis: float(np.ptp(q[recording.row])) for axis, q in recording.run.position.items()}
    axis = max(moved, key=lambda a: moved[a])
    turns, angle = is_rotary(axis), recording.kind == "angle"
    sense = recording.run.columns.get(f"sense_{axis}", np.zeros(recording.run.n))
    return charts.readings(
        recording.run.q(axis)[recording.row] * (180.0 / np.pi if turns else 1.0),
        recording.value * (1e6 if angle else 1e3),
        sense[recording.row],
        unit="µrad" if angle else "µm",
        title=f"{recording.name}: {'indicated - true' if recording.measuring else 'actual - commanded'}",
        label=f"{axis} / {'deg' if turns else 'mm'}",
        ax=ax,
    )


@picture.register(ErrorField)
def tip_errors(field: ErrorField, ax: Sheet = None) -> Axes:
    most = 1e3 * float(field.size.max(initial=0.0))
    at = [field.run.position.get(a, np.zeros(field.run.n)) for a in LINEAR]
    return charts.motions(np.stack(at, axis=1), field.tip_error, f"tip error, at most {most:.3g} µm", ax)


@line.register(CharacteristicResult)
def answer_line(c: CharacteristicResult) -> str:
    return in_one_line(answer_of(c))
