"""Map interpolation: the error that a table misses between its nodes, where it is linear."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander

from vcmm.core.axes import axis_of
from vcmm.core.declaration import UM, URAD, About, ForDiagnosis, Site, Typical, Words
from vcmm.core.effect import COLUMN, Effect, at, choice, param, positions
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Array, Run

SHAPES = ("smooth", "ripple", "cells")
TRIED = ("smooth", "ripple")
MOST_CELLS = 40  # meshes of a table with a height each


def _map_interpolation_make_at(
    cls: type[MapInterpolation], place: Mapping[str, Any], site: Site
) -> MapInterpolation:
    component = place["component"]
    tables = [e for e in site.effects if e.about.table_parameter and getattr(e, "component", "") == component]
    table = next((e for e in tables if hasattr(e, "grids")), None)
    if table is None:
        raise UsageError(f"the machine has no table of {component}")
    return cls.from_table(table)


def _map_interpolation_trials(
    effect: MapInterpolation, name: str
) -> list[tuple[dict[str, Any], float]] | None:
    """Return the trials: heights that follow a polynomial, and a separate height in every mesh, since the bend of a guide
    between two nodes does not follow from its neighbours.
    """
    cells = len(np.asarray(effect.nodes)) - 1
    if name != "shape" or not 1 < cells <= MOST_CELLS:
        return None
    share = float(np.log(0.5 / len(TRIED)))
    smooth: list[tuple[dict[str, Any], float]] = [({"shape": shape}, share) for shape in TRIED]
    return [*smooth, ({"shape": "cells", "coefficients": np.zeros(cells)}, float(np.log(0.5)))]


@dataclass(frozen=True, eq=False)
class MapInterpolation(Effect):
    """A residual of a component's table that is zero at every node; u runs from 0 to 1 between two nodes.

    smooth: 4 u (1 - u) (c0 P0(s) + c1 P1(s) ...), the bow of a curved error under straight lines, s from -1 to +1
    over the table;   ripple: sin(2 pi u) (c0 P0(s) + ...), a period of one grid step (a screw's lead);
    cells: 4 u (1 - u) c_i, one height per interval. Own motion of the axis, as the table is.
    """

    name = "map_interpolation"
    diagnosis = ForDiagnosis(
        special_case_of=("geometric_change",),
        shared_physics="geometry",
        holds_table_edits=True,
        is_free_curve=True,
        trials=_map_interpolation_trials,
        make_at=_map_interpolation_make_at,
    )
    per = "map"
    own = True
    about = About(
        cites="de Boor, A Practical Guide to Splines (1978), ch. III: error of broken-line interpolation",
        words=Words(
            seen="between the nodes of its table {where} is off ({rms})",
            causes="the nodes are too far apart",
            confirm="measure between the nodes and refine the table",
        ),
    )
    component: str = at("EXX", "component error whose table is interpolated")
    nodes: Any = positions((0.0, 1.0))
    shape: str = choice("smooth", TRIED)
    coefficients: Any = param(
        lambda: np.zeros(3),
        "mm or rad",
        "heights between the nodes",
        shape="(powers,)",
        typical=Typical(0.5 * UM, "up to a few um between nodes 25-100 mm apart", 1 * URAD),
    )

    def __post_init__(self) -> None:
        if self.shape not in SHAPES:
            raise UsageError(f'{self.id}: shape = "{self.shape}"; allowed: {", ".join(SHAPES)}')
        cells = len(np.asarray(self.nodes)) - 1
        if cells < 1 or (self.shape == "cells" and len(self.coefficients) != cells):
            raise UsageError(
                f"{self.id}: {len(self.coefficients)} coefficients for {cells} intervals; give one each"
            )

    @classmethod
    def from_table(cls, table: Effect, shape: str = "smooth", orders: int = 3) -> MapInterpolation:
        """Return a residual of zero on the nodes of a component table over its own axis. Raises UsageError for other effects."""
        component = str(getattr(table, "component", ""))
        grids = dict(zip(getattr(table, "arguments", ()), getattr(table, "grids", ())))
        if axis_of(component) not in grids:
            raise UsageError(f"{table.id} has no table over axis {axis_of(component)} to be interpolated")
        measured = getattr(table, "measured", None)
        nodes = np.asarray(grids[axis_of(component)] if measured is None else measured, dtype=float)
        return cls(component, nodes, shape, np.zeros(len(nodes) - 1 if shape == "cells" else orders))

    @property
    def link(self) -> str:
        return axis_of(self.component)

    @property
    def rms(self) -> float:
        """Root mean square over the table, mm or rad (64 points per interval)."""
        nodes = np.asarray(self.nodes, dtype=float)
        u = (np.arange(64) + 0.5) / 64
        width = np.diff(nodes)
        squares = self._at((nodes[:-1, None] + width[:, None] * u).ravel()).reshape(len(width), -1) ** 2
        return float(np.sqrt((squares.mean(axis=1) * width).sum() / width.sum()))

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, COLUMN[self.component[1]]] = self._at(run.q(self.link))
        return out

    def _at(self, q: Array) -> Array:
        nodes, c = np.asarray(self.nodes, dtype=float), np.asarray(self.coefficients, dtype=float)
        outside = np.flatnonzero((q < nodes[0] - 1e-6) | (q > nodes[-1] + 1e-6))
        if len(outside):
            raise ModelLimit(f"{self.id}: row {outside[0] + 1} at {q[outside[0]]:.6g} lies outside the table")
        cell = np.clip(np.searchsorted(nodes, q, side="right") - 1, 0, len(nodes) - 2)
        u = (q - nodes[cell]) / (nodes[cell + 1] - nodes[cell])
        wave = np.sin(2 * np.pi * u) if self.shape == "ripple" else 4 * u * (1 - u)
        if self.shape == "cells":
            return wave * c[cell]
        s = (2 * q - nodes[0] - nodes[-1]) / (nodes[-1] - nodes[0])
        return wave * (legvander(s, len(c) - 1) @ c)
