"""The report of a calibration: curves with their bands, residuals per recording, what is not identified."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.learn.calibration.result import Calibration, rms
from vcmm.show import charts as draw
from vcmm.show.pages.header import OF_MACHINES, facts, files_block
from vcmm.show.report import blocks as r
from vcmm.show.tables.answers_machine import calibration_answers
from vcmm.show.tables.calibration import Residuals, errors_by_name, positioning, residuals
from vcmm.show.tables.table import html, titled_html
from vcmm.task.response.joining import joined_record

if TYPE_CHECKING:
    from vcmm.learn.calibration.acceptance import Figure

MOST_RECORDINGS, MOST_DOTS = 12, 1000  # recordings whose residuals are drawn, worst first; dots of one


def calibration_page(
    calibration: Calibration, figures: Sequence[Figure] = (), files: Sequence[Path] = ()
) -> str:
    """Return one self-contained HTML file. figures: A, R, E, M of the calibrated machine (ISO 230-2); files: all files read."""
    blocks = r.notices(calibration.warnings)
    blocks += [r.heading("Errors by name"), html(errors_by_name(calibration))]
    blocks += [r.heading("Not identified"), *missing(calibration)]
    if figures:
        blocks += [r.heading("Positioning (ISO 230-2)"), html(positioning(figures))]
    blocks += [r.heading("Errors over the travel, 95 % bands")]
    pictures = [draw.on_page(calibration.plot, c.component) for c in calibration.kept_model.curves]
    blocks += [r.columns(*pictures[i : i + 2]) for i in range(0, len(pictures), 2)]
    blocks += titled_html(residuals(calibration))
    left = sorted(
        residuals(calibration).rows, key=lambda row: -rms(row.residual) / (rms(row.part.u) * row.noise.u)
    )
    pictures = [scatter(row) for row in left[:MOST_RECORDINGS]]
    blocks += [r.columns(*pictures[i : i + 2]) for i in range(0, len(pictures), 2)] + files_block(files)
    footer = (
        f"vcmm {__version__}. Over the travel rotations have the mean zero and straightness no least-squares line: the direction of travel is "
        "squareness (ISO 230-1)."
    )
    return r.page(
        f"Calibration report: {calibration.machine.name}",
        blocks,
        footer=footer,
        answers=calibration_answers(calibration, figures),
        facts=facts(
            "",
            f"{calibration.machine.name}, structure {calibration.machine.chain.structure}",
            joined_record(
                [calibration.machine.record, *(reading.recording.record for reading in calibration.readings)]
            ),
            expected_names=OF_MACHINES,
        ),
    )


def scatter(row: Residuals) -> str:
    """Return the residuals of one recording, reading by reading, over the band of its noise."""
    step = 1 + (row.part.m - 1) // MOST_DOTS
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


def missing(calibration: Calibration) -> list[str]:
    if not calibration.identified.combinations:
        return [r.paragraph("Everything is identified.")]
    return [r.paragraph(c.text) for c in calibration.identified.combinations]
