"""A calibration as tables: its errors, residuals of every recording, set-ups of a plan, figures of acceptance tests."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from vcmm.core.error_names import words_of
from vcmm.learn.calibration.result import Calibration, rms
from vcmm.learn.calibration.spindle import ANGLE
from vcmm.show.report.answers import K, signed_value
from vcmm.show.tables.quantities import DASH, SIZE, fixed
from vcmm.show.tables.table import Column, ResultTable, Writing, entry, listing

if TYPE_CHECKING:
    from vcmm.core.run import Array
    from vcmm.learn.calibration.acceptance import Figure
    from vcmm.learn.calibration.cross_validation import PredictedPositions
    from vcmm.learn.calibration.design import Proposal
    from vcmm.learn.calibration.readings import Readings
    from vcmm.learn.calibration.reversal import ReversalResult
    from vcmm.learn.calibration.solve import ReadingNoise
    from vcmm.learn.calibration.verification import IndependentTest

COUNT_OR_NONE = fixed(0)


@dataclass(frozen=True, eq=False)
class Residuals:
    """Residuals of one recording: residual (m,) mm or rad, and the noise that the fit assumed."""

    part: Readings
    residual: Array
    noise: ReadingNoise

    @property
    def unit(self) -> str:
        return "rad" if self.part.recording.kind == "angle" else "mm"

    @property
    def scale(self) -> float:
        """Factor to um or urad."""
        return 1e6 if self.unit == "rad" else 1e3

    @property
    def outliers(self) -> int:
        return int(self.noise.outliers.sum())


RESIDUALS: tuple[Column[Residuals], ...] = (
    Column("recording", lambda row: row.part.recording.name, key="recording"),
    entry("kind", lambda row: row.part.recording.kind),
    Column("readings", lambda row: row.part.m, COUNT_OR_NONE, key="observations"),
    Column("residual rms", lambda row: rms(row.residual), SIZE, page_head="residual rms / µm"),
    entry("rms", lambda row: rms(row.residual) * row.scale),
    entry("unit", lambda row: "urad" if row.unit == "rad" else "um"),
    Column("noise u", lambda row: rms(row.part.u) * row.noise.u, SIZE, page_head="noise u / µm"),
    entry("noise_ratio", lambda row: row.noise.scale),
    entry("dof", lambda row: row.noise.dof if row.noise.dof < 1e6 else None),
    Column("outliers", lambda row: row.outliers, COUNT_OR_NONE, key="outliers"),
    entry("station_moved_mm", lambda row: dict(row.part.moved)),
)
LEAST_U_UM = 1e-6  # below it a u is what rounding leaves of nothing
_WRITTEN_U = fixed(3, "um")
U_OF_FIGURE = Writing(
    lambda value, unit: DASH if value is None or value < LEAST_U_UM else _WRITTEN_U.terminal(value, unit)
)
FIGURES: tuple[Column[Figure], ...] = (
    Column("figure", lambda row: row.name, key="name"),
    Column("value", lambda row: row.value_um, fixed(3, "um"), key="value_um"),
    Column("u", lambda row: row.u_um, U_OF_FIGURE, key="u_um"),
    Column("limit", lambda row: row.limit_um, fixed(3, "um"), key="limit_um"),
    Column("probability to pass", lambda row: row.p_pass, fixed(3), key="p_pass"),
)
LENGTHS: tuple[Column[Figure], ...] = (  # of ISO 10360-2, whose limit grows with the length
    *FIGURES[:3],
    Column("largest E/MPE", lambda row: row.ratio, fixed(2), key="ratio"),
    Column("u of E/MPE", lambda row: row.u_ratio, fixed(2), key="u_ratio"),
    Column("at length", lambda row: row.at_mm, fixed(0, "mm"), key="at_mm"),
    Column("limit there", lambda row: row.limit_um, fixed(3, "um"), key="limit_um"),
    FIGURES[-1],
)
HELD_OUT: tuple[Column[PredictedPositions], ...] = (
    Column("interpolation", lambda row: row.name, key="interpolation"),
    Column("readings held out", lambda row: row.n, COUNT_OR_NONE, key="observations"),
    Column("rms of lengths", lambda row: row.rms_um, fixed(3, "um"), key="rms_um"),
    Column("rms of angles", lambda row: row.rms_urad, fixed(3, "urad"), key="rms_urad"),
    Column("within the 95 % band", lambda row: row.inside, fixed(3), key="inside"),
    Column("log score", lambda row: row.nats, fixed(2, "nats"), key="log_score_nats"),
    Column("time", lambda row: row.seconds, fixed(1, "s"), key="seconds"),
)
TESTS: tuple[Column[IndependentTest], ...] = (
    Column("test", lambda row: row.name, key="recording"),
    Column("readings", lambda row: row.n, COUNT_OR_NONE, key="observations"),
    Column("rms before", lambda row: row.before * row.scale, fixed(3), key="rms_before"),
    Column("after", lambda row: row.after * row.scale, fixed(3), key="rms_after"),
    Column("unit", lambda row: row.unit, key="unit"),
    Column("gain", lambda row: row.gain, fixed(3), key="gain"),
    Column("within the 95 % band", lambda row: row.inside, fixed(3), key="inside"),
    Column("u of the band", lambda row: row.u * row.scale, fixed(3), key="u"),
)
PROPOSALS: tuple[Column[Proposal], ...] = (
    entry("setups", lambda row: list(row.names)),
    entry("minutes", lambda row: row.minutes),
    entry("volume_um", lambda row: row.volume_um),
    entry("identified", lambda row: list(row.identified.names)),
    entry("not_identified", lambda row: row.identified.document()),
    entry("condition", lambda row: row.identified.condition),
)


def errors(calibration: Calibration) -> ResultTable[Sequence[str]]:
    """Return the size and u of every identified error."""
    rows = []
    for f in calibration.figures():
        size = f"{f['value']:+.3f}" if "value" in f else f"{f['low']:+.3f} to {f['high']:+.3f}"
        rows.append((str(f["error"]), f"{size} {f['unit']}", f"{f['u']:.2g} {f['unit']}"))
    return listing("errors of the machine", ("error", "from ... to", "u (rms over the travel)"), rows)


def errors_by_name(calibration: Calibration) -> ResultTable[Sequence[str]]:
    """Return the same with the words of ISO 230-1: positioning of X, EXX."""
    rows = [(words_of(name), name, size, u) for name, size, u in errors(calibration).rows]
    heads = ("error", "name", "from ... to", "u (rms over the travel)")
    return listing("Errors by name", heads, rows, words=(0, 1))


def positioning(figures: Sequence[Figure]) -> ResultTable[Sequence[str]]:
    """Return A, R, E and M by axis, with U (k = 2); figures that the recordings do not determine are a dash."""
    values = {f.name: f for f in figures}
    axes = list(dict.fromkeys(name.split(" ")[1] for name in values if " " in name))

    def cell(name: str) -> str:
        f = values.get(name)
        return (
            DASH if f is None or f.value_um is None else signed_value(f.value_um, K * (f.u_um or 0.0), "µm")
        )

    kinds = (
        ("A", "accuracy A"),
        ("R", "repeatability R"),
        ("E", "systematic deviation E"),
        ("M", "mean deviation M"),
    )
    rows = [(axis, *(cell(f"{short} {axis}") for short, _ in kinds)) for axis in axes]
    caption = "Bidirectional, over the whole travel, ± U with k = 2: what a test by ISO 230-2 of the calibrated machine would find."
    return listing("Positioning (ISO 230-2)", ("axis", *(words for _, words in kinds)), rows, caption=caption)


def residuals(calibration: Calibration) -> ResultTable[Residuals]:
    """Return the rms of the residuals per recording, against its noise."""
    post = calibration.posterior
    rows = [Residuals(*reading) for reading in zip(calibration.readings, post.residual, post.noise)]
    return ResultTable("Residuals", RESIDUALS, rows)


def figures(iso: str, acceptance_figures: Sequence[Figure]) -> ResultTable[Figure]:
    """Return the figures of an acceptance test, iso such as "230-2"."""
    return ResultTable(f"ISO {iso}", figure_columns(iso), acceptance_figures)


def figure_columns(iso: str) -> tuple[Column[Figure], ...]:
    return LENGTHS if iso == "10360-2" else FIGURES


def interpolations(predicted: Sequence[PredictedPositions]) -> ResultTable[PredictedPositions]:
    """Return how each interpolation predicts readings that it was not given."""
    return ResultTable("Positions held out", HELD_OUT, predicted)


def independent_tests(tests: Sequence[IndependentTest]) -> ResultTable[IndependentTest]:
    """Return the predictions of the machine file for recordings that it was not made from."""
    return ResultTable("Independent tests", TESTS, tests)


def setups(choices: Sequence[tuple[str, Proposal]]) -> ResultTable[Sequence[str]]:
    """Return choices of set-ups by their names."""
    rows = [
        (
            what,
            f"{p.minutes:g} min",
            f"{p.volume_um:.2f} µm",
            f"{len(p.identified.names)} errors",
            ", ".join(p.names),
        )
        for what, p in choices
    ]
    heads = ("choice", "time", "u of the tip over the volume", "identified", "set-ups")
    return listing("set-ups", heads, rows, words=(0, 4))


def reversals(results: Sequence[ReversalResult]) -> ResultTable[Sequence[str]]:
    """Return every error that was separated, with its u and the artefact beside it."""
    rows = []
    for result in results:
        for row in result.rows():
            size = f"{row['value']:+.4g}" if "value" in row else f"{row['low']:+.4g} to {row['high']:+.4g}"
            unit, u = row["unit"], float(str(row["u"]))
            rows.append(
                (result.file.name, result.file.kind, str(row["error"]), f"{size} {unit}", f"{u:.2g} {unit}")
            )
    return listing(
        "errors separated from the artefact", ("recording", "test", "error", "from ... to", "u"), rows
    )


def _nm(value: float | None, unit: str) -> str:
    """Return a figure given in um, as nm, or in urad with three digits."""
    if value is None:
        return DASH
    return f"{value:.3g} µrad" if unit else f"{value * 1e3:.3g} nm"


def _unit(row: Figure) -> str:
    return "urad" if row.name.endswith(ANGLE) else ""


SPINDLE: tuple[Column[Figure], ...] = (
    Column("figure", lambda row: row.name.removesuffix(ANGLE)),
    Column("value", lambda row: _nm(row.value_um, _unit(row))),
    Column("u", lambda row: _nm(row.u_um, _unit(row))),
    Column("limit", lambda row: _nm(row.limit_um, _unit(row))),
    Column("probability to pass", lambda row: row.p_pass, fixed(3)),
)


def spindle_figures(figures: Sequence[Figure]) -> ResultTable[Figure]:
    """Return ISO 230-7 values of a turning axis, nm and urad."""
    return ResultTable("ISO 230-7", SPINDLE, figures)
