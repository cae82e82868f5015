"""The 18 (or more) component errors of ISO 230-1 as tables, splines and polynomials over the axis positions.

EXX is the error in X of axis X, EYX its straightness in Y, EAX EBX ECX its rotations (roll, and the two tilts).
The numbers are the axis's own motion (for a table axis: the table's), so `own = True`.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from vcmm.core.axes import axis_of, is_component, whole_turn
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
)
from vcmm.core.effect import COLUMN, Effect, argument_grids, argument_letters, at, param, positions
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.grid import multilinear, node_weights
from vcmm.core.run import T0_DEG_C, Array, Run

EDGE = 1e-6  # mm or rad: rounding of positions at the ends of a table


@dataclass(frozen=True, eq=False)
class _Component(Effect):
    """Common part of the component errors: `component` such as EBX names direction and axis."""

    component: str = at("EXX", "component error, for example EXX, EYX, EBX")
    per = "component"
    own = True

    def __post_init__(self) -> None:
        c = self.component
        if not is_component(c):
            raise UsageError(
                f'component = "{c}" is not a component error; write for example "EXX", "EZY" or "EBX"'
            )

    @property
    def link(self) -> str:
        return axis_of(self.component)

    @property
    def column(self) -> int:
        return COLUMN[self.component[1]]

    def _ranges(self, grids: Iterable[tuple[str, Any]]) -> tuple[KnownRange, ...]:
        what = f"range of the table {self.component}"
        return tuple(
            KnownRange(what, "XYZ".index(a), float(g[0]), float(g[-1])) for a, g in grids if a in "XYZ"
        )

    def _place(self, values: Array) -> Array:
        out = np.zeros((len(values), 6))
        out[:, self.column] = values
        return out


def _inside(component: str, axis: str, q: Array, grid: Array) -> Array:
    low, high = grid[0], grid[-1]
    outside = np.flatnonzero((q < low - EDGE) | (q > high + EDGE))
    if len(outside):
        raise ModelLimit(
            f"{component}: {axis} = {q[outside[0]]:.6g} lies outside its table ({low:.6g} to {high:.6g}); "
            "extend the table or move the part"
        )
    return np.minimum(np.maximum(q, low), high)


def _curve_weights(component: str, axis: str, run: Run, nodes: Array, interpolation: str) -> Array:
    """Return the weights (n, nodes); a cubic curve of a rotary axis over one whole turn repeats itself from turn to turn."""
    q = run.q(axis)
    if interpolation == "cubic" and whole_turn(axis, nodes):
        return node_weights(nodes, q, "periodic")
    return node_weights(nodes, _inside(component, axis, q, nodes), interpolation)


def check_increasing(what: str, grid: Array) -> None:
    """Raises UsageError for positions that are not finite or do not increase."""
    wrong = np.flatnonzero(~(np.diff(grid) > 0))
    if len(wrong) or not np.isfinite(grid).all():
        at = int(wrong[0]) + 1 if len(wrong) else 0
        raise UsageError(
            f"{what} do not increase: {grid[at]:g} after {grid[max(at - 1, 0)]:g}; sort them and remove repeats"
        )


@dataclass(frozen=True, eq=False)
class ComponentTable(_Component, WithResponse, Tabulated):
    """A component error tabulated over one axis, or over a grid of several; linear between the nodes.

    measured: nodes of the stored table over its own axis, where more were added for the sake of a correlated uncertainty.
    """

    name = "component_table"
    about = About(
        cites="ISO 230-1:2012, 3.4 (component errors); linear interpolation as controls do it",
        trade=Trade(
            "calibrated error {where} of the machine",
            "calibrate {where} again, or place the part where it shows less (vcmm place)",
        ),
        table_parameter="values",
        is_calibrated=True,
    )
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    arguments: tuple[str, ...] = argument_letters()
    grids: tuple[Array, ...] = argument_grids(((0.0, 1.0),))
    values: Any = param(
        lambda: np.zeros(2),
        "mm or rad",
        "error at the nodes",
        shape="(nodes, ...)",
        typical=Typical(2 * UM, "usual: 1-5 um, 2-20 urad per component", 5 * URAD),
    )
    measured: Any = field(default=None, metadata={"internal": True})

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.arguments) != len(self.grids) or not self.arguments:
            raise UsageError(
                f"{self.id}: {len(self.grids)} grids for the arguments {', '.join(self.arguments) or 'none'}; give one per axis"
            )
        for letter, grid in zip(self.arguments, self.grids):
            check_increasing(f"{self.id}: positions of {letter}", np.asarray(grid, dtype=float))
        shape = tuple(len(grid) for grid in self.grids)
        if np.size(self.values) != int(np.prod(shape)):
            raise UsageError(
                f"{self.id}: {np.size(self.values)} values for {' x '.join(map(str, shape))} nodes; give one value per node"
            )
        object.__setattr__(self, "values", np.reshape(np.asarray(self.values, dtype=float), shape))

    def known_range(self) -> tuple[KnownRange, ...]:
        return self._ranges(zip(self.arguments, self.grids))

    def own_nodes(self) -> Array | None:
        return np.asarray(self.grids[0], dtype=float) if len(self.grids) == 1 else None

    def error_motion(self, run: Run) -> Array:
        values = np.asarray(self.values, dtype=float)
        positions = [_inside(self.component, a, run.q(a), g) for a, g in zip(self.arguments, self.grids)]
        if len(self.arguments) == 1:
            return self._place(np.interp(positions[0], self.grids[0], values))
        weights, nodes = multilinear(positions, self.grids)
        return self._place((weights * values.reshape(-1)[nodes]).sum(axis=1))

    def response(self, name: str, run: Run) -> Array:
        positions = [_inside(self.component, a, run.q(a), g) for a, g in zip(self.arguments, self.grids)]
        weights, nodes = multilinear(positions, self.grids)
        out = np.zeros((run.n, 6, np.asarray(self.values).size))
        for corner in range(weights.shape[1]):
            out[np.arange(run.n), self.column, nodes[:, corner]] += weights[:, corner]
        return out

    def projection(self, name: str, run: Run, weights: Array) -> Array:
        positions = [_inside(self.component, a, run.q(a), g) for a, g in zip(self.arguments, self.grids)]
        shares, nodes = multilinear(positions, self.grids)
        out = np.zeros((run.n, np.asarray(self.values).size))
        for corner in range(shares.shape[1]):
            out[np.arange(run.n), nodes[:, corner]] += shares[:, corner] * weights[:, self.column]
        return out


@dataclass(frozen=True, eq=False)
class ComponentSpline(_Component, WithResponse, Tabulated):
    """A component error as a natural cubic spline through nodes; of a rotary axis over one whole turn, a periodic one."""

    name = "component_spline"
    about = About(
        cites="de Boor, A Practical Guide to Splines (1978), ch. IV: natural cubic spline",
        trade=Trade(
            "calibrated error {where} of the machine",
            "calibrate {where} again, or place the part where it shows less (vcmm place)",
        ),
        table_parameter="values",
        is_calibrated=True,
    )
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    nodes: Any = positions((0.0, 1.0, 2.0))
    values: Any = param(
        lambda: np.zeros(3),
        "mm or rad",
        "error at the nodes",
        shape="(nodes,)",
        typical=Typical(2 * UM, "usual: 1-5 um, 2-20 urad per component", 5 * URAD),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        nodes = np.asarray(self.nodes, dtype=float)
        check_increasing(f"{self.id}: nodes", nodes)
        if len(nodes) < 3 or np.shape(self.values) != nodes.shape:
            raise UsageError(
                f"{self.id}: {np.size(self.values)} values for {len(nodes)} nodes; a spline takes 3 nodes or more, one value each"
            )

    def known_range(self) -> tuple[KnownRange, ...]:
        return self._ranges([(self.link, self.nodes)])

    def own_nodes(self) -> Array:
        return np.asarray(self.nodes, dtype=float)

    def error_motion(self, run: Run) -> Array:
        return self._place(self._weights(run) @ np.asarray(self.values, dtype=float))

    def response(self, name: str, run: Run) -> Array:
        weights = self._weights(run)
        out = np.zeros((run.n, 6, weights.shape[1]))
        out[:, self.column, :] = weights
        return out

    def projection(self, name: str, run: Run, weights: Array) -> Array:
        return np.asarray(self._weights(run) * weights[:, self.column, None])

    def _weights(self, run: Run) -> Array:
        return _curve_weights(self.component, self.link, run, np.asarray(self.nodes, dtype=float), "cubic")


@dataclass(frozen=True, eq=False)
class ComponentPolynomial(_Component):
    """A component error as c0 + c1 s + c2 s^2 ..., s = position in m (linear axis) or rad (rotary axis)."""

    name = "component_polynomial"
    about = About(
        cites="ISO 230-1:2012, 3.4; power series",
        trade=Trade(
            "calibrated error {where} of the machine",
            "calibrate {where} again, or place the part where it shows less (vcmm place)",
        ),
        is_calibrated=True,
    )
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    coefficients: Any = param(
        lambda: np.zeros(2),
        "mm or rad",
        "c0, c1 ... per power of the position in m or rad",
        shape="(powers,)",
        typical=Typical(2 * UM, "the same over a travel of the order of 1 m", 5 * URAD),
    )

    def error_motion(self, run: Run) -> Array:
        return self._place(_power_series(self.coefficients, self.link, run))


def _power_series(coefficients: Any, axis: str, run: Run) -> Array:
    """Return c0 + c1 s + c2 s^2 ... (n,), s = position in m or rad."""
    q = run.q(axis)
    s = q / 1000.0 if axis in "XYZ" else q
    return np.asarray(
        np.vander(s, len(coefficients), increasing=True) @ np.asarray(coefficients, dtype=float)
    )


@dataclass(frozen=True, eq=False)
class ComponentWarming(_Component, ChoosesColumns):
    """(c0 + c1 s + c2 s^2 ...) (T lagged by tau - 20 degC): a component error that goes with a temperature, coefficients per kelvin.

    A regression of an error parameter on temperature sensors gives one such effect per parameter and sensor.
    """

    name = "component_warming"
    per = "component, sensor"
    about = About(
        cites="ISO 230-3:2020; D. Marin, SISOM 2004: geometric parameters by regression on temperatures",
    )
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    sensor: str = at("air", "temperature sensor: column temp_<sensor>_C")
    coefficients: Any = param(
        lambda: np.zeros(2),
        "mm or rad",
        "c0, c1 ... per kelvin and power of the position in m or rad",
        shape="(powers,)",
        typical=Typical(2 * UM, "per kelvin, over a travel of the order of 1 m", 5 * URAD),
    )
    tau: float = param(0.0, "s", "time constant behind the sensor", scan=(60.0, 300.0, 1200.0, 3600.0))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.tau < 0:
            raise UsageError(f"{self.id}: tau = {self.tau:g} s is negative; a lag is zero or positive")

    def required_columns(self) -> tuple[str, ...]:
        return (f"temp_{self.sensor}_C",)

    def error_motion(self, run: Run) -> Array:
        warm = run.lag(self.sensor, self.tau) - T0_DEG_C
        return self._place(_power_series(self.coefficients, self.link, run) * warm)


@dataclass(frozen=True, eq=False)
class CalibrationModes(Effect, WithResponse):
    """Departure of one error, correlated with all others of a joint calibration: departure = loadings @ modes.

    There is one such effect per component, squareness and location error; all share the numbers `modes`, which are 0 in the machine and
    have one Input (where = "*", unit variance). The joint covariance of the errors is loadings @ loadings.T, over all of
    them. It is made by [errors] covariance = "..." of a machine file.
    """

    name = "calibration_modes"
    about = About(
        cites="JCGM 102:2011, 6.2: joint covariance, here by its factor",
        trade=Trade(
            "calibrated error {where} of the machine",
            "calibrate {where} again, or place the part where it shows less (vcmm place)",
        ),
    )
    per = "component"
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    made_by: ClassVar[str] = 'covariance = "errors_covariance.csv" in [errors]'
    component: str = at("EXX", "component, squareness or location error, for example EXX, C0Y, X0C")
    nodes: Any = positions((0.0, 1.0, 2.0))
    loadings: Any = field(default_factory=lambda: np.zeros((3, 1)), metadata={"internal": True})
    interpolation: str = "linear"
    modes: Any = param(
        lambda: np.zeros(0),
        "1",
        "departure in each mode; zero when left out",
        shape="(modes,)",
        typical=Typical(1.0, "standardised by its own loadings"),
    )

    def __post_init__(self) -> None:
        rows = np.shape(self.loadings)
        due = len(self.nodes) if self.varies else 1
        if len(rows) != 2 or rows[0] != due:
            raise UsageError(f"{self.id}: loadings of shape {rows}; expected {due} rows, one per node")
        if np.size(self.modes) == 0:
            object.__setattr__(self, "modes", np.zeros(rows[1]))

    @property
    def varies(self) -> bool:
        """Whether the error depends on a position (EXX) or is one number (C0Y)."""
        return self.component[0] == "E"

    @property
    def link(self) -> str:
        return axis_of(self.component)

    @property
    def column(self) -> int:
        return COLUMN[self.component[1 if self.varies else 0]]

    @property
    def place(self) -> str:  # type: ignore[override]
        if self.varies:
            return "motion"
        return "travel" if self.link in "XYZ" else "location"

    @property
    def own(self) -> bool:  # type: ignore[override]
        return self.place != "travel"

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, self.column] = self._shapes(run) @ self.modes
        return out

    def response(self, name: str, run: Run) -> Array:
        shapes = self._shapes(run)
        out = np.zeros((run.n, 6, shapes.shape[1]))
        out[:, self.column, :] = shapes
        return out

    def projection(self, name: str, run: Run, weights: Array) -> Array:
        return np.asarray(self._shapes(run) * weights[:, self.column, None])

    def _shapes(self, run: Run) -> Array:
        """Return the error per unit of every mode (n, modes)."""
        loadings = np.asarray(self.loadings, dtype=float)
        if not self.varies:
            return np.broadcast_to(loadings, (run.n, loadings.shape[1]))
        nodes = np.asarray(self.nodes, dtype=float)
        return _curve_weights(self.component, self.link, run, nodes, self.interpolation) @ loadings
