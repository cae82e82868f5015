"""U of every characteristic against one knob, all others at their present values, to show in which direction and how far to turn it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.errors import UsageError, VcmmError, choose_from
from vcmm.face.workbench.live import preview
from vcmm.show.charts import ChartSheet, PlotSeries, curve, on_page
from vcmm.show.charts.canvas import carrying
from vcmm.show.report.palette import LIGHT
from vcmm.task.measuring.knobs import Knob, knobs_of, with_knobs
from vcmm.task.measuring.scenario import Scenario

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PLACES = 13  # values of the knob
FINE_UNITS = {"um": "µm", "urad": "µrad"}


def sweep(
    scenario: Scenario, values: Mapping[str, Any], name: str, step: Callable[[int, int], None]
) -> dict[str, Any]:
    """Evaluate the previews along one knob (`pictures` draws them). step(done, all) is called before each and may raise.

    `at` (n,), `U` by characteristic (n,) with None where the knob allows no evaluation, `reasons` for these.
    UsageError: no such knob, or no value of it allows an evaluation.
    """
    knobs = {k.name: k for k in knobs_of(scenario)}
    if name not in knobs:
        raise UsageError(f'there is no knob "{name[:40]}".{choose_from(name, knobs)}')
    knob, now = knobs[name], float(values.get(name, knobs[name].start))
    at = places_of(knob, now)
    results: list[dict[str, Any] | None] = []
    reasons: list[str] = []
    for i, value in enumerate(at):
        step(i, len(at))
        try:
            chosen = with_knobs(scenario, {**values, name: value})
            results.append(preview(chosen, chosen.settings.seed))
        except VcmmError as error:
            results.append(None)
            reasons.append(f"{value:g} {knob.unit}: {error}".replace(" :", ":"))
    lines = _lines(results)
    if not lines:
        raise UsageError(f"no value of this knob allows an evaluation: {reasons[0]}")
    units, us = ({n: both[i] for n, both in lines.items()} for i in (0, 1))
    return {"knob": name, "at": at, "now": now, "unit": units, "U": us, "reasons": reasons}


def pictures(scenario: Scenario, results: Mapping[str, Any]) -> list[str]:
    """Draw the result of `sweep`: one chart per unit, as SVG."""
    knob = next(k for k in knobs_of(scenario) if k.name == results["knob"])
    units = results["unit"]
    return [
        on_page(sweep_chart, knob, results["at"], {n: u for n, u in results["U"].items() if units[n] == unit}, unit, results["now"])
        for unit in dict.fromkeys(units.values())
    ]  # fmt: skip


def places_of(knob: Knob, now: float) -> list[float]:
    """Return values over the reach of a knob, its present one among them; whole numbers for a knob that counts."""
    low, high = knob.reach
    if knob.name == "touches":
        return [float(v) for v in range(round(low), round(high) + 1)]
    return sorted({*(float(v) for v in np.linspace(low, high, PLACES)), now})


def _lines(results: list[dict[str, Any] | None]) -> dict[str, tuple[str, list[float | None]]]:
    """Return the unit of every characteristic and its U along the knob, by name."""
    out: dict[str, tuple[str, list[float | None]]] = {}
    first = next((f for f in results if f is not None), None)
    for i, c in enumerate(first["characteristics"] if first else ()):
        us = [None if f is None else float(f["characteristics"][i]["U"]) for f in results]
        out[c["name"]] = (c["unit"], [u if u is None or math.isfinite(u) else None for u in us])
    return out


def sweep_chart(
    knob: Knob,
    at: list[float],
    lines: Mapping[str, list[float | None]],
    unit: str,
    now: float,
    ax: Axes | ChartSheet | None = None,
) -> Axes:
    """Plot U over the knob, one line per characteristic; a line at the present value of the knob."""
    series = [
        PlotSeries(at, [math.nan if u is None else u for u in us], name, marker=True) for name, us in lines.items()
    ]  # fmt: skip
    word = FINE_UNITS.get(unit, unit)
    label = f"{knob.words} / {knob.unit}" if knob.unit else knob.words
    drawn: Any = curve(
        series, x_label=label, y_label=f"U / {word}", title=f"U against {knob.words} (preview)", zero_line=False, ax=ax
    )  # fmt: skip
    drawn.set_ylim(bottom=0.0)
    drawn.axvline(now, color=LIGHT["muted"], linewidth=0.9, linestyle=":")
    return carrying(drawn, chart="sweep", unit=word, knob=knob.name, at=at, now=now, U=dict(lines))
