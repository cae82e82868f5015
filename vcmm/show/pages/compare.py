"""The report of a comparison: residuals of the recordings under each machine file, fold by fold, and their places."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from vcmm import __version__
from vcmm.learn.diagnosis.locate import without_unit
from vcmm.show import charts as draw
from vcmm.show.pages.header import facts
from vcmm.show.report import blocks as r
from vcmm.show.tables.answers import compare_answers
from vcmm.show.tables.comparison import short_names, tables
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from vcmm.core.run import Array
    from vcmm.learn.diagnosis.comparison import Comparison, Misfit


def compare_page(rows: Sequence[Comparison]) -> str:
    """Return one self-contained HTML file."""
    blocks = [block for table in tables(rows) for block in (r.heading(table.title), html(table))]
    for k, part in enumerate(rows[0].parts):
        blocks += [r.heading(f"Residuals of {part.recording.name}"), r.columns(*_pictures(rows, k))]
    title = "Simulation against recording"
    return r.page(
        title,
        blocks,
        footer=f"vcmm {__version__}",
        answers=compare_answers(rows, short_names([c.file for c in rows])),
        facts=facts(),
    )


def _pictures(rows: Sequence[Comparison], k: int) -> list[str]:
    """Return the residuals of recording k under every machine, over the covariates on which the first of them depends."""
    first = rows[0].parts[k]
    unit, scale = ("µrad", 1e6) if rows[0].angle else ("µm", 1e3)
    names = list(dict.fromkeys(w for p in first.depends_on for w in _columns(first, p.covariate)))[:3]
    out = []
    for name in ["order", *names]:
        x, x_label = (
            (np.arange(first.recording.m) + 1.0, "order") if name == "order" else _values(first, name)
        )
        lines = [
            draw.PlotSeries(x, scale * c.parts[k].residual, file, marker=True, line=False)
            for file, c in zip(short_names([c.file for c in rows]), rows)
            if len(c.parts[k].residual) == len(x)
        ]
        out.append(
            draw.on_page(
                draw.curve, lines, x_label=x_label, y_label=f"residual / {unit}", title=f"over {x_label}"
            )
        )
    return out


def _columns(part: Misfit, covariate: str) -> list[str]:
    """Return the axes and columns of the run that the words of a covariate name."""
    words = covariate.replace(" (periodic)", "").replace(" (step)", "").replace(" (zone)", "").split(" and ")
    columns = {without_unit(c): c for c in part.run.columns} | {a: a for a in part.run.position}
    return [columns[w] for w in words if w in columns]


def _values(part: Misfit, name: str) -> tuple[Array, str]:
    if name in part.run.position:
        turns = name in "ABC"
        values = np.degrees(part.run.position[name]) if turns else part.run.position[name]
        return values[part.recording.row], f"{name} / {'deg' if turns else 'mm'}"
    return part.run.columns[name][part.recording.row], name
