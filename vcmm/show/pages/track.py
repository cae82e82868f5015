"""The page of a tracked machine: alarms, numbers over time with their forecast, recordings against their prediction."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.files.learned.last_checks import last_checks
from vcmm.show import charts
from vcmm.show import report as r
from vcmm.show.charts import Band, ChartSheet, PlotSeries, PolarTrace
from vcmm.show.pages.header import OF_MACHINES, facts
from vcmm.show.tables import track as tables
from vcmm.show.tables.answers_runs import track_answers
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from vcmm.files.learned.last_checks import CheckPart
    from vcmm.files.learned.track_result import NumberOverTime, Track
    from vcmm.learn.tracking.doubtful import DoubtfulParts

DRAWN = 9  # numbers with a picture, those that moved most


def track_page(
    track: Track, planned: tables.Planned | None = None, doubtful: Sequence[DoubtfulParts] = ()
) -> str:
    """Return one self-contained HTML file."""
    name = track.followed.tracked.machine.name
    blocks = [
        r.paragraph(
            f"{len(track.checks)} recordings from {track.checks[0].date} until {track.checks[-1].date}; as of {track.at}. "
            f"Chance of any false alarm over all recordings: {track.followed.alpha:.3g}."
        )
    ]
    if track.alarms:
        blocks += [r.heading("What changed"), html(tables.alarms(track))]
    if doubtful:
        blocks += [r.heading("Doubtful parts"), html(tables.doubtful(doubtful))]
    blocks.append(r.heading("Numbers over time"))
    drawn = sorted(track.courses, key=lambda c: -c.change_over_u)[:DRAWN]
    blocks += [
        r.columns(*(charts.on_page(number_over_time, track, c) for c in drawn)),
        html(tables.numbers(track)),
    ]
    last = last_checks(track)
    blocks += [
        r.heading("Last checks beside their forecast"),
        r.columns(*(charts.on_page(beside_forecast, part) for part in last)),
        r.note(
            "What was read, its zero and place fitted, and what was forecast of it the moment before, with the 95 % band of one reading."
        ),
    ]
    if planned is not None:
        blocks += [
            r.heading("What to check next"),
            html(tables.next_checks(planned, track)),
            html(tables.plan(planned, track)),
        ]
    blocks += [r.heading("How well each recording was predicted"), charts.on_page(_spread, track)]
    rates = "; ".join(
        f"{g}: {rate.words}" for g, rate in zip(track.followed.tracked.groups, track.followed.rates)
    )
    blocks.append(r.note(f"Rates learnt, in usual sizes of the parameter: {rates}."))
    alarms = [i for i, c in enumerate(track.checks) if c.alarm]
    blocks += [r.heading("Recordings"), html(tables.checks(track), emphasise=alarms)]
    return r.page(
        f"{name} over time",
        blocks,
        footer=f"vcmm {__version__}",
        answers=track_answers(track, planned),
        facts=facts(
            "",
            name,
            {"date": track.at, **track.followed.tracked.machine.record},
            more=[("machine file valid on", track.at)],
            asked=OF_MACHINES,
        ),
    )


def _spread(track: Track, ax: charts.ChartSheet | None = None) -> Axes:
    """Plot the innovation over its standard uncertainty."""
    days = np.array([c.when for c in track.checks])
    days = days - days[0]
    values = np.array([c.spread for c in track.checks])
    alarm = np.array([c.alarm for c in track.checks])
    series = [PlotSeries(days[~alarm], values[~alarm], "as predicted", marker=True, line=False)]
    if alarm.any():
        series.append(PlotSeries(days[alarm], values[alarm], "alarm", marker="s", line=False))
    return charts.curve(
        series, x_label=f"days since {track.checks[0].date}", y_label="innovation over its u", bands=[Band(0.0, 1.0, "as predicted on average")],
        title="Innovation of every recording", zero_line=False, ax=ax,
    )  # fmt: skip


WAYS = ((1.0, "forwards", "o"), (-1.0, "backwards", "s"), (0.0, "read", "o"))


def number_over_time(track: Track, course: NumberOverTime, ax: Axes | ChartSheet | None = None) -> Axes:
    """Plot a number over the days with its band, checks, alarms and forecast."""
    return charts.over_time(
        course.when - course.when[0], course.value, course.u, name=course.name, unit=course.unit, start=track.checks[0].date,
        alarms=[c.when - course.when[0] for c in track.alarms], ahead=np.array(course.ahead), what=course.what, ax=ax,
    )  # fmt: skip


def beside_forecast(part: CheckPart, ax: Axes | ChartSheet | None = None) -> Axes:
    """Plot the readings, and their forecast with the 95 % band of one reading."""
    title = f"{part.name} of {part.date}\n{part.inside:.0%} of {len(part.seen)} readings within the 95 % band of their forecast"
    if part.circle:
        lines = [
            PolarTrace("forecast, ± 1.96 u", part.place, part.forecast, "c2", half_um=1.96 * part.u),
            PolarTrace("read", part.place, part.seen, "c1"),
        ]
        return charts.traces(lines, title=title, ax=ax)
    order = np.argsort(part.place, kind="stable")
    place, middle, half = part.place[order], part.forecast[order], 1.96 * part.u[order]
    series = [PlotSeries(place, middle, "forecast, ± 1.96 u", middle - half, middle + half, colour="c2")]
    for way, name, marker in WAYS:
        rows = part.up == way
        if rows.any():
            series.append(
                PlotSeries(part.place[rows], part.seen[rows], name, marker=marker, line=False, colour="c1" if way >= 0 else "c3")
            )  # fmt: skip
    label = f"{part.axis} / mm" if part.axis else "number of the reading"
    return charts.curve(series, x_label=label, y_label=part.unit, title=title, ax=ax)
