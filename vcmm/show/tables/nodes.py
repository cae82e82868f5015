"""Nodes found from LaserTracer lengths as a table."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.show.tables.quantities import fixed
from vcmm.show.tables.table import NUMBER_TEXT, Column, ResultTable, entry

if TYPE_CHECKING:
    from vcmm.core.run import Array
    from vcmm.learn.calibration.field_process import ProcessFit
    from vcmm.learn.calibration.nodes import NodeScatter


@dataclass(frozen=True, eq=False)
class NodeRow:
    """One node of a result."""

    scatter: NodeScatter
    number: int

    def three(self, name: str) -> list[float]:
        """Return x, y, z of a quantity of the node, um."""
        return [float(v) * 1e3 for v in getattr(self.scatter, name)[self.number]]


def _three(name: str) -> Callable[[NodeRow], str]:
    return lambda row: " ".join(f"{v:.2f}" for v in row.three(name))


def _node(row: NodeRow) -> str:
    return " ".join(f"{v:g}" for v in row.scatter.place[row.number])


def _key(name: str) -> Column[NodeRow]:
    return entry(f"{name}_um", lambda row: row.three(name))


NODE_COLUMNS: tuple[Column[NodeRow], ...] = (
    Column("node / mm", _node),
    Column("mean - nominal / µm", _three("deviation"), NUMBER_TEXT),
    Column("d / µm", _three("d"), NUMBER_TEXT),
    Column("instrument's share / µm", _three("instrument"), NUMBER_TEXT),
    Column("one approach / µm", _three("single"), NUMBER_TEXT),
    Column("least p of the law", lambda row: float(row.scatter.test[row.number].min()), fixed(3)),
    entry("place_mm", lambda row: row.scatter.place[row.number].tolist()),
    *(_key(name) for name in ("deviation", "deviation_u", "d", "instrument", "changing", "single")),
    entry("approaches", lambda row: int(row.scatter.dof[row.number]) + 1),
    entry("p_of_the_law", lambda row: row.scatter.test[row.number].tolist()),
)


def nodes_table(scatter: NodeScatter) -> ResultTable[NodeRow]:
    """Return one line per node."""
    rows = [NodeRow(scatter, k) for k in range(len(scatter.place))]
    return ResultTable("Nodes: where the machine stops when it comes from many sides", NODE_COLUMNS, rows)


def sentences(scatter: NodeScatter) -> list[str]:
    """Return statements from the lengths as a whole."""
    located = scatter.multilateration
    d, instrument, single = (
        np.quantile(v, [0, 0.5, 1]) * 1e3 for v in (scatter.d, scatter.instrument, scatter.single)
    )
    deviation_u = float(np.sqrt((scatter.deviation_u**2).mean())) * 1e3
    covered = float((scatter.instrument > scatter.d / 2).mean())
    return [
        f"{len(located.residual)} lengths, {len(located.points)} points, {len(located.stations)} stations: {located.freedom} degrees of freedom, residuals "
        f"{located.u * 1e3:.3f} µm",
        f"d {_range(d)} µm; of it the lengths' own u makes {_range(instrument)} µm, more than half of d in {covered:.0%} of the directions",
        f"one approach: {_range(single)} µm, d freed of what changes between stations and of the instrument",
        f"mean deviations are known to {deviation_u:.2f} µm (rms of their u)",
        f"chi-squared against the t-law: {scatter.rejection_share():.0%} of {scatter.test.size} tests below 0.05",
    ]


def process_json(fit: ProcessFit, dof: int) -> dict[str, Any]:
    """Return the process of the field in a document: its numbers and central 95 % of what the likelihood leaves."""
    return {
        "margins": "t",
        "dof": dof,
        "length_scales_mm": fit.lengths.tolist(),
        "length_scales_interval_mm": fit.lengths_range.T.tolist(),
        "length_scales_tried_mm": list(fit.trial_range),
        "amplitude_um": (fit.amplitude * 1e3).tolist(),
        "amplitude_interval_um": (fit.amplitude_range.T * 1e3).tolist(),
        "correlation": fit.correlation.tolist(),
        "correlation_u": fit.correlation_u.tolist(),
    }


def process_sentences(fit: ProcessFit) -> list[str]:
    """Return statements from the nodes about the field between them."""
    low, high = fit.lengths_range
    lengths = ", ".join(
        f"{a} {v:.0f} ({b:.0f} to {c:.0f})" for a, v, b, c in zip("xyz", fit.lengths, low, high)
    )
    small, large = fit.amplitude_range * 1e3
    sizes = ", ".join(
        f"{a} {v:.2f} ({b:.2f} to {c:.2f})" for a, v, b, c in zip("xyz", fit.amplitude * 1e3, small, large)
    )
    pairs = ", ".join(
        f"{a} {fit.correlation[i, j]:+.2f} (u {fit.correlation_u[i, j]:.2f})"
        for a, i, j in (("XY", 0, 1), ("XZ", 0, 2), ("YZ", 1, 2))
    )
    short = [a for a, v in zip("xyz", low) if v <= fit.trial_range[0] * 1.0001]
    long = [a for a, v in zip("xyz", high) if v >= fit.trial_range[1] * 0.9999]
    open_ends = (
        [f"{' '.join(short)} not separated from shorter than {fit.trial_range[0]:.0f} mm"] if short else []
    )
    open_ends += (
        [f"{' '.join(long)} not separated from longer than {fit.trial_range[1]:.0f} mm"] if long else []
    )
    return [
        f"field between the nodes, by likelihood, with 95 % coverage intervals: length scales along {lengths} mm"
        + "".join(f"; {t}" for t in open_ends),
        f"what comes back every time: amplitude in {sizes} µm",
        f"one approach: correlation of {pairs}",
    ]


def _range(three: Array) -> str:
    return f"{three[0]:.2f} to {three[2]:.2f} (median {three[1]:.2f})"
