"""Learned residual: a smooth curve with its own uncertainty, for deviations that recordings show repeatedly and no effect explains."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from vcmm.core.axes import axis_of, is_component, is_rotary
from vcmm.core.declaration import (
    UM,
    URAD,
    About,
    ChoosesColumns,
    ForDiagnosis,
    KnownRange,
    Tabulated,
    Trade,
    Typical,
    WithResponse,
    Words,
)
from vcmm.core.effect import COLUMN, Effect, at, param, positions
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Array, Run

SPACINGS = 2.0  # between nodes, in a correlation length


@dataclass(frozen=True, eq=False)
class LearnedResidual(Effect, WithResponse, Tabulated, ChoosesColumns):
    """A Gaussian process over the position of an axis, and over one recorded column where it is named.

    f(q, t) = k(q, t; nodes) K^-1 values,   k = exp(-(dq / l)^2 / 2 - (dt / m)^2 / 2),   l, m: twice the mean distance of nodes and levels

    values: f at every node and level, level by level, the axis's own motion as a table has it. Refused outside the nodes and the levels: what was not seen is not
    said. An Input of their joint covariance grows to that of the prior where no row lay.
    """

    name = "learned_residual"
    per = "component"
    own = True
    about = About(
        cites="Rasmussen & Williams, Gaussian Processes for Machine Learning (2006), 2.2 and 8.3.1",
        trade=Trade(
            "learned residual {where}: seen in recordings, explained by nothing",
            "find its cause (vcmm diagnose without it), or check more often where it is used",
        ),
        words=Words(
            seen="{where} departs by a curve that recordings showed again and again",
            causes="unknown: it was learned, no physics is named",
            confirm="more recordings over the same positions and temperatures",
        ),
    )
    diagnosis = ForDiagnosis(is_named=False)
    component: str = at("EXX", "component error, for example EXX, EYX, EBX")
    column: str = at("", "recorded column over which it varies besides, such as temp_air_C")
    nodes: Any = positions((0.0, 1.0))
    levels: str = ""
    kernel: str = ""
    learned: str = ""
    values: Any = param(
        lambda: np.zeros(2),
        "mm or rad",
        "residual at every node, level by level",
        shape="(levels x nodes,)",
        typical=Typical(
            2 * UM, "usual: remainder of a component after calibration, 1-5 um, 2-20 urad", 5 * URAD
        ),
    )

    def __post_init__(self) -> None:
        if not is_component(self.component) or is_rotary(axis_of(self.component)):
            raise UsageError(
                f'component = "{self.component}": a learned residual is one of a linear axis, such as "EXX" or "EBY"'
            )
        nodes, levels = np.asarray(self.nodes, dtype=float), self.level_values
        for what, grid in (("nodes", nodes), ("levels", levels)):
            if not (np.diff(grid) > 0).all():
                raise UsageError(f"{self.id}: {what} do not increase; sort them and remove repeats")
        if len(nodes) < 2 or bool(self.column) != (len(levels) > 1):
            raise UsageError(
                f'{self.id}: two nodes or more, and two levels or more where it has a column; write for example levels = "18 20 22"'
            )
        if np.size(self.values) != len(nodes) * len(levels):
            raise UsageError(
                f"{self.id}: {np.size(self.values)} values for {len(levels)} levels of {len(nodes)} nodes; give one each, level by level"
            )

    @property
    def link(self) -> str:
        return axis_of(self.component)

    @cached_property
    def level_values(self) -> Array:
        """Levels of the column, in its unit; one of zero where there is none."""
        try:
            return np.array([float(v) for v in self.levels.split()] or [0.0])
        except ValueError:
            raise UsageError(
                f'{self.id}: levels = "{self.levels}" is no row of numbers such as "18 20 22"'
            ) from None

    def required_columns(self) -> tuple[str, ...]:
        return (self.column,) if self.column else ()

    def known_range(self) -> tuple[KnownRange, ...]:
        nodes = np.asarray(self.nodes, dtype=float)
        what = f"range of the learned residual {self.component}"
        return (KnownRange(what, "XYZ".index(self.link), float(nodes[0]), float(nodes[-1])),)

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, COLUMN[self.component[1]]] = self.weights(run) @ np.asarray(self.values, dtype=float)
        return out

    def response(self, name: str, run: Run) -> Array:
        weights = self.weights(run)
        out = np.zeros((run.n, 6, weights.shape[1]))
        out[:, COLUMN[self.component[1]], :] = weights
        return out

    def weights(self, run: Run) -> Array:
        """Return the weights k K^-1 (n, levels x nodes). Raises ModelLimit outside nodes and levels."""
        along = _weights(
            np.asarray(self.nodes, dtype=float), self._inside(self.link, run.q(self.link), self.nodes)
        )
        if not self.column:
            return along
        over = _weights(
            self.level_values, self._inside(self.column, run.column(self.column), self.level_values)
        )
        return np.asarray((over[:, :, None] * along[:, None, :]).reshape(run.n, -1))

    def prior_shape(self) -> Array:
        """Return K of all values, for a variance of one."""
        nodes, levels = np.asarray(self.nodes, dtype=float), self.level_values
        return np.asarray(np.kron(_kernel(levels, levels), _kernel(nodes, nodes)), dtype=np.float64)

    def _inside(self, what: str, values: Array, grid: Any) -> Array:
        low, high = float(grid[0]), float(grid[-1])
        edge = 1e-6 * max(1.0, high - low)
        outside = np.flatnonzero((values < low - edge) | (values > high + edge))
        if len(outside):
            raise ModelLimit(
                f"{self.id}: {what} = {values[outside[0]]:.6g} lies outside what it was learned from ({low:.6g} to {high:.6g}); "
                "record there and learn it anew, or take the term out of the machine file"
            )
        return values


def _kernel(a: Array, nodes: Array) -> Array:
    """Return the squared exponential (n, k); its length: SPACINGS mean distances of the nodes."""
    length = SPACINGS * float(np.ptp(nodes)) / (len(nodes) - 1) if len(nodes) > 1 else 1.0
    return np.asarray(np.exp(-(((np.asarray(a)[:, None] - nodes) / length) ** 2) / 2.0))


def _weights(nodes: Array, a: Array) -> Array:
    return np.asarray(np.linalg.solve(_kernel(nodes, nodes), _kernel(a, nodes).T).T)
