"""The report of a recorded acceptance test: its figures, and the picture from which they are read (ISO 230-2, 230-4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vcmm import __version__
from vcmm.core.axes import is_rotary
from vcmm.learn.calibration.recorded_circles import circle_paths
from vcmm.learn.calibration.recorded_lines import axis_line, axis_of
from vcmm.show import charts as draw
from vcmm.show.pages.header import facts
from vcmm.show.report import blocks as r
from vcmm.show.tables.answers_runs import acceptance_answers
from vcmm.show.tables.calibration import figures as figures_table
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from vcmm.learn.calibration.acceptance import Figure
    from vcmm.learn.calibration.deviations import RecordedTest

SHOWN = ("A", "R", "E", "B", "M")
NAMES = {"230-2": "positioning of an axis", "230-4": "circles"}


def acceptance_page(
    tests: Sequence[RecordedTest],
    iso: str,
    acceptance_figures: Sequence[Figure],
    warnings: Sequence[str] = (),
) -> str:
    """Return one self-contained HTML file; acceptance_figures: the figures of the table, of all tests in their order."""
    make = positioning_picture if iso == "230-2" else circle_picture
    pictures = [make(test, acceptance_figures) for test in tests]
    blocks = [r.heading("Figures"), html(figures_table(iso, acceptance_figures))]
    blocks += [r.note(w) for w in warnings]
    blocks += [
        r.heading("Recordings"),
        *(r.columns(*pictures[i : i + 2]) for i in range(0, len(pictures), 2)),
    ]
    names = ", ".join(test.recording.name for test in tests)
    footer = f"vcmm {__version__}. Deviation = actual - commanded; implements the method of ISO {iso}."
    machine = ", ".join(dict.fromkeys(test.machine.name for test in tests))
    return r.page(
        f"ISO {iso}, {NAMES[iso]}: {names}",
        blocks,
        footer=footer,
        answers=acceptance_answers(acceptance_figures, recorded=True),
        facts=facts("", machine, more=[("recordings", names)]),
    )


def positioning_picture(test: RecordedTest, acceptance_figures: Sequence[Figure]) -> str:
    """Return the band chart of one axis."""
    axis = axis_of(test.recording)
    up, down, targets = axis_line(test.recording, axis).runs()
    value = test.value * test.scale
    stated = {f.name: f.value_um for f in acceptance_figures}
    figures = {n: float(v) for n in SHOWN if (v := stated.get(f"{n} {axis}")) is not None}
    return draw.on_page(
        draw.positioning_band, targets, value[up], value[down], figures,
        unit="µrad" if test.recording.kind == "angle" else "µm", title=f"{test.recording.name}, axis {axis}",
        label=f"{axis} / {'rad' if is_rotary(axis) else 'mm'}",
    )  # fmt: skip


def circle_picture(test: RecordedTest, acceptance_figures: Sequence[Figure]) -> str:
    """Return the trace of one circle in both senses, about their common centre (that of G(b))."""
    paths = circle_paths(test)
    stated = {f.name: f.value_um for f in acceptance_figures}
    radii_text = ", ".join(
        f"{n} {v:.3g} µm" for n in ("G+", "G-", "G(b)", "H") if (v := stated.get(f"{n} {paths.plane}")) is not None
    )  # fmt: skip
    lines = [
        draw.PolarTrace(
            "counter-clockwise",
            paths.angle,
            1e3 * paths.ahead,
            "c1",
            closed=False,
            width_um=stated.get(f"G+ {paths.plane}"),
        ),
        draw.PolarTrace(
            "clockwise",
            paths.back_angle,
            1e3 * paths.back,
            "c2",
            closed=False,
            width_um=stated.get(f"G- {paths.plane}"),
        ),
    ]
    title = f"{test.recording.name}, {paths.plane}: {radii_text}"
    return draw.on_page(draw.traces, lines, title=title)
