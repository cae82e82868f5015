"""Pictures of a diagnosis: where the residual departs (over covariates, over the volume, in space), and an unknown shape."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.learn.calibration.deviations import RecordedTest
from vcmm.learn.calibration.recorded_circles import radial_of, width_of_path
from vcmm.show import charts as draw
from vcmm.show.report import blocks as r

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.core.run import Array
    from vcmm.learn.diagnosis.result import Diagnosis
    from vcmm.task.response.recording import Recording

CELLS = (10, 8)  # of the map over two axes
MOST_ARROWS = 400
BEFORE, AFTER = "c2", "c1"  # colours in charts and scenes alike


def location_bars(d: Diagnosis) -> list[str]:
    """Return the evidence of a departure over every covariate, best direction each, in nats."""
    items = [(f"{p.covariate} ({p.direction})", max(p.score, 0.0)) for p in d.map][:14]
    if not items:
        return []
    title = f"Evidence that the residual depends on a covariate / nats; chance reaches {d.chance:.1f}"
    return [draw.on_page(draw.bars, items, unit="nats", title=title, share="none")]


def zone_maps(recording: Recording, before: Array, after: Array, unit: str) -> list[str]:
    """Return the rms of the residual over the two axes of the longest travel, before and after."""
    spans = {a: float(np.ptp(q[recording.row])) for a, q in recording.run.position.items()}
    axes = sorted((a for a in spans if spans[a] > 0), key=lambda a: -spans[a])[:2]
    if len(axes) < 2 or recording.m < 40:
        return []
    x, y = (recording.run.position[a][recording.row] for a in sorted(axes))
    grids = {word: _cells(x, y, values) for word, values in (("before", before), ("after", after))}
    scale = np.concatenate([grid.ravel() for grid, *_ in grids.values()])
    first, second = (f"{a} / {'mm' if a in 'XYZ' else 'rad'}" for a in sorted(axes))
    out = []
    for word, (grid, xs, ys) in grids.items():
        if draw.is_of_one_colour(grid, scale):
            low, high = np.nanmin(grid), np.nanmax(grid)
            out.append(r.paragraph(f"Rms of the residual {word}: {low:.3g} to {high:.3g} {unit} in all cells, one colour of the scale of both."))  # fmt: skip
            continue
        title = f"Rms of the residual {word} (one scale for before and after)"
        out.append(
            draw.on_page(draw.heat_map, grid, xs, ys, unit=unit, title=title, x_label=first, y_label=second, over=scale)
        )  # fmt: skip
    return out


def _cells(x: Array, y: Array, values: Array) -> tuple[Array, Array, Array]:
    """Return the rms (ny, nx) per cell, NaN where nothing was recorded, and the centres."""
    nx, ny = CELLS
    ex, ey = np.linspace(x.min(), x.max(), nx + 1), np.linspace(y.min(), y.max(), ny + 1)
    count = np.histogram2d(y, x, bins=(ey, ex))[0]
    total = np.histogram2d(y, x, bins=(ey, ex), weights=values**2)[0]
    grid = np.where(count > 0, np.sqrt(total / np.maximum(count, 1)), np.nan)
    return np.asarray(grid), (ex[1:] + ex[:-1]) / 2, (ey[1:] + ey[:-1]) / 2


def bar_traces(recording: Recording, machine: Machine, before: Array, after: Array) -> list[str]:
    """Return polar traces of a ball bar before and after, mm, on one scale; nothing for recordings that are no circle."""
    if recording.kind != "length":
        return []
    test = RecordedTest(recording, machine)
    try:
        radii = [radial_of(test, values) for values in (before, after)]
    except UsageError:
        return []
    every = 1e3 * np.concatenate([radial for _, radial in radii])
    out = []
    for (circle, radial), word, colour in zip(radii, ("before", "after"), (BEFORE, AFTER)):
        ways = (("counter-clockwise", 1.0, False), ("clockwise", -1.0, True))
        lines = [
            draw.PolarTrace(
                name,
                circle.angle[mine],
                1e3 * radial[mine],
                colour,
                thin=thin,
                closed=False,
                width_um=1e3 * width_of_path(test, circle, radial, way),
            )
            for name, way, thin in ways
            if (mine := circle.way == way).any()
        ]
        out.append(
            draw.on_page(
                draw.traces,
                lines,
                title=f"Residual of the ball bar in {circle.plane} {word}",
                low_um=float(every.min()),
                high_um=float(every.max()),
            )
        )
    return [r.columns(*out)]


def arrows(recording: Recording, tip: Array, before: Array, after: Array) -> list[str]:
    """Return the residuals in space along their directions, before and after, strongly magnified. Values in mm."""
    place = tip[recording.row]
    if recording.kind == "angle" or (np.ptp(place, axis=0) > 1e-6).sum() < 2:
        return []
    chosen = np.unique(np.linspace(0, recording.m - 1, min(MOST_ARROWS, recording.m)).astype(int))
    size = float(np.ptp(place, axis=0).max())
    scale = 0.1 * size / max(float(np.quantile(np.abs(before), 0.98)), 1e-12)
    scale = float(10.0 ** np.floor(np.log10(scale)))
    along = recording.direction[chosen]
    items: list[r.Points | r.Arrows] = [
        r.Points(place[chosen], "muted", 1.5),
        r.Arrows(place[chosen], before[chosen, None] * along, scale, BEFORE, name=f"before x {scale:,.0f}"),
        r.Arrows(place[chosen], after[chosen, None] * along, scale, AFTER, name=f"after x {scale:,.0f}"),
    ]
    return [
        r.scene(items, title="Residuals in space", caption="Along the direction of each observation; mm.")
    ]


def unknown_picture(d: Diagnosis) -> list[str]:
    """Return the shape of a departure that is not in the catalogue: a curve with its band, or a map."""
    shape = d.unknown.shape if d.unknown is not None else None
    if shape is None:
        return []
    scale, unit = (1e6, "µrad") if d.angle else (1e3, "µm")
    if shape.y is None:
        low, high = (shape.value - 2 * shape.u) * scale, (shape.value + 2 * shape.u) * scale
        band = draw.Band(low, high, "95 % coverage band", shape.x)
        line = draw.PlotSeries(shape.x, shape.value * scale, "fitted shape")
        title = f"Unknown, over {shape.names[0]} ({shape.direction}): a proposal, not physics"
        return [
            draw.on_page(
                draw.curve,
                [line],
                bands=[band],
                x_label=shape.names[0],
                y_label=f"departure / {unit}",
                title=title,
            )
        ]
    title = (
        f"Unknown, over {shape.names[0]} and {shape.names[1]} ({shape.direction}): a proposal, not physics"
    )
    return [
        draw.on_page(draw.heat_map,
            shape.value * scale, shape.x, shape.y, x_label=shape.names[0], y_label=shape.names[1], unit=unit,
            title=title, symmetric=True)
    ]  # fmt: skip
