"""The report of a calibration: curves with their bands, residuals per recording, what is not identified."""

from __future__ import annotations

import numpy as np

from vcmm import __version__
from vcmm.learn.calibration.identifiability import is_angle
from vcmm.learn.calibration.result import Calibration, rms
from vcmm.show import charts as draw
from vcmm.show import report as r
from vcmm.show.tables.calibration import Left, residuals
from vcmm.show.tables.table import titled_html

MOST, DOTS = 12, 1000  # recordings whose residuals are drawn, worst first; dots of one


def calibration_page(found: Calibration) -> str:
    """One self-contained HTML file."""
    blocks = [r.note(w, "warning") for w in found.warnings]
    blocks += [r.heading("Errors of the machine, 95 % bands")]
    pictures = [draw.on_page(found.plot, c.component) for c in found.kept.curves]
    blocks += [r.columns(*pictures[i : i + 2]) for i in range(0, len(pictures), 2)]
    if found.kept.pairs:
        rows = []
        for pair in found.kept.pairs:
            scale, unit = size_of(pair)
            _, value, u = found.band(pair)
            rows.append([pair, f"{value[0] * scale:+.2f} {unit}", f"{u[0] * scale:.2f} {unit}"])
        blocks += [r.heading("Squareness and location"), r.table(["", "value", "u"], rows, numeric=(1, 2))]
    blocks += [r.heading("Not identified"), *missing(found), *titled_html(residuals(found))]
    left = sorted(residuals(found).rows, key=lambda row: -rms(row.residual) / (rms(row.part.u) * row.noise.u))
    pictures = [scatter(row) for row in left[:MOST]]
    blocks += [r.columns(*pictures[i : i + 2]) for i in range(0, len(pictures), 2)]
    footer = (
        f"vcmm {__version__}. Over the travel rotations have the mean zero and straightness no least-squares line: the direction of travel is "
        "squareness (ISO 230-1)."
    )
    return r.page(
        f"Calibration of {found.machine.name}",
        blocks,
        subtitle=f"structure {found.machine.chain.structure}",
        footer=footer,
    )


def scatter(row: Left) -> str:
    """What is left of one recording, reading by reading, over the band of its noise."""
    step = 1 + (row.part.m - 1) // DOTS
    number = np.arange(row.part.m)[::step]
    unit = "µrad" if row.unit == "rad" else "µm"
    width = 1.96 * rms(row.part.u) * row.noise.u * row.scale
    every = "" if step == 1 else f", every {step} readings one"
    return draw.on_page(
        draw.curve,
        [draw.PlotSeries(number + 1, row.residual[::step] * row.scale, marker=True, line=False)],
        x_label=f"reading{every}",
        y_label=f"left in {unit}",
        title=f"{row.part.recording.name}: residuals and 95 % of the noise",
        bands=[draw.Band(-width, width)],
        ax=draw.ChartSheet(height=200),
    )


def size_of(name: str) -> tuple[float, str]:
    """(to the unit, unit) in which an error is shown."""
    return (1e6, "µrad") if is_angle(name) else (1e3, "µm")


def missing(found: Calibration) -> list[str]:
    if not found.identified.combinations:
        return [r.paragraph("Everything is identified.")]
    return [r.paragraph(c.text) for c in found.identified.combinations]
