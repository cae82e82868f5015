"""The procedure of Echerfaoui et al. 2017 (doi 10.4236/jasmi.2017.73007) on drawn machines of its magnitudes.

    1  18 component errors read by the 6-D laser along the axes (Table 2), squareness beside them      laser.read
    2  one net per axis for its six errors, four layouts (eq. 8 to 13); a spline beside them          net.train_net, spline
    3  synthesis over the volume: X carries Y carries Z carries the tool of length L (eq. 1 to 8)       volumetric
    4  encoder positions corrected by the predicted error; what is left over the volume (Fig. 12)      compensated
    5  body diagonal, 692.82 mm in 10 steps of 69.282 mm (Fig. 13)                                     diagonal

Drawn: the shape of every error (none is published as numbers), the squareness, L. The paper's: travels, largest linear errors of
7, 10, 8 um, straightness of 10 to 12 um, angles of 7 to 10 arcsec, the laser. Signs: eq. 11 needs -eta delta, eq. 13 (1 - O) of
its own layer, eq. 2 a minus in (3, 1); eq. 8a and 8b carry +L where eq. 4 makes it -L.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm import Array, Axis, Machine, Run, calibration, kinematics
from vcmm import effects as fx

from .laser import ARCSEC, OPTIONS, read

TRAVEL, LENGTH, STEP = 400.0, 120.0, 20.0  # mm: travels, tool, distance of laser readings
LINEAR = {"X": 7e-3, "Y": 10e-3, "Z": 8e-3}  # mm, largest; straightness and angles between:
STRAIGHT, ANGLE, SQUARE = (10e-3, 12e-3), (7 * ARCSEC, 10 * ARCSEC), 5 * ARCSEC
SMOOTH = (120.0, 220.0)  # mm: correlation length of a drawn curve
DIAGONAL_STEPS = 10
DRAWS = 8
PROFILES = 9
METHODS = (
    f"nets {calibration.BEST_LAYOUT}",
    "cubic splines",
    f"nets {calibration.BEST_LAYOUT}, nine profiles",
    "cubic splines, nine profiles",
)
LARGE, TRIED = 63.0, 200  # um, the paper's vector; machines drawn to see how many exceed it
PAIRS = {"C0Y": "XY", "B0Z": "XZ", "A0Z": "YZ"}
STEEL = 11.5e-6
Curves = Mapping[str, Array]  # axis -> (n, 6) mm and rad in the order X Y Z A B C
Progress = Callable[[str, float], None]


@dataclass(frozen=True, eq=False)
class DrawnCmm:
    """curves: axis -> (81, 6) at NODES; square: pair -> rad."""

    curves: Curves
    square: Mapping[str, float]


@dataclass(frozen=True)
class LayoutResult:
    """Shares of the range, per layout: on the positions learnt, on those held out, on all of them."""

    layout: str
    training: float
    validation: float
    total: float


@dataclass(frozen=True)
class Residual:
    """um: largest per direction and of the vector over the volume, as it is and compensated."""

    method: str
    before: tuple[float, float, float, float]
    after: tuple[float, float, float, float]

    @property
    def gain(self) -> float:
        return 1.0 - self.after[3] / self.before[3]


@dataclass(frozen=True)
class DiagonalResult:
    """um along the body diagonal: largest vector norm and largest projection, before and after."""

    method: str
    norm: float
    projection: float
    norm_after: float
    projection_after: float


@dataclass(frozen=True)
class OneMachine:
    """Everything of one drawn machine."""

    layouts: tuple[LayoutResult, ...]
    residuals: tuple[Residual, ...]
    diagonals: tuple[DiagonalResult, ...]


@dataclass(frozen=True, eq=False)
class EcherfaouiTwin:
    """machines: draws; option: of the laser; thermal: um that 1 K makes of the travel; large: of `tried` machines, vectors above LARGE."""

    machines: tuple[OneMachine, ...]
    option: str
    thermal: float
    large: int
    tried: int = TRIED


NODES = np.linspace(0.0, TRAVEL, 81)
TARGETS = np.arange(0.0, TRAVEL + STEP / 2, STEP)


def drawn_cmm(rng: np.random.Generator) -> DrawnCmm:
    """Smooth curves with the published maxima; zero at the start, straightness zero at both ends."""
    return DrawnCmm(
        {axis: _six(axis, rng) for axis in "XYZ"}, {p: SQUARE * rng.uniform(-1, 1) for p in PAIRS}
    )


def _six(axis: str, rng: np.random.Generator) -> Array:
    out = np.empty((len(NODES), 6))
    for k, name in enumerate("XYZABC"):
        smooth = rng.uniform(*SMOOTH)
        kernel = np.exp(-((NODES[:, None] - NODES) ** 2) / (2 * smooth**2)) + 1e-8 * np.eye(len(NODES))
        curve = np.linalg.cholesky(kernel) @ rng.standard_normal(len(NODES))
        curve -= curve[0]
        if name in "XYZ" and name != axis:
            curve -= curve[-1] * NODES / TRAVEL
        size = LINEAR[axis] if name == axis else rng.uniform(*(STRAIGHT if name in "XYZ" else ANGLE))
        out[:, k] = size * curve / np.abs(curve).max()
    return out


def machine(curves: Curves, square: Mapping[str, float]) -> Machine:
    """The synthesis (eq. 1 to 8) as a machine of vcmm: bed, X carries Y carries Z carries the tool."""
    tables = [
        fx.ComponentTable(f"E{name}{axis}", (axis,), (NODES,), six[:, k])
        for axis, six in curves.items()
        for k, name in enumerate("XYZABC")
    ]
    axes = {a: Axis(a, (0.0, TRAVEL)) for a in "XYZ"}
    squares = tuple(fx.Squareness(pair, angle) for pair, angle in square.items())
    return Machine("CMM of 2017", "cmm", kinematics.parse_structure("w b X Y Z t"), axes, (*tables, *squares))


def volumetric(one: Machine, places: Array) -> Array:
    """Error vectors (n, 3) mm at encoder positions (n, 3) mm, tip at (0, 0, -L)."""
    offset = np.tile([0.0, 0.0, -LENGTH], (len(places), 1))
    return one.tip_error(Run(dict(zip("XYZ", places.T)), offset))


def measured(cmm: DrawnCmm, option: str, rng: np.random.Generator) -> tuple[Curves, Mapping[str, float]]:
    """Laser readings at TARGETS, and squareness."""
    at = np.searchsorted(NODES, TARGETS)
    readings = {a: read(OPTIONS[option], a, TARGETS, six[at], rng) for a, six in cmm.curves.items()}
    limit = OPTIONS[option].square
    return readings, {p: angle + limit * rng.uniform(-1, 1) for p, angle in cmm.square.items()}


def measured_often(
    cmm: DrawnCmm, option: str, rng: np.random.Generator
) -> tuple[Curves, Mapping[str, float]]:
    """Means of PROFILES readings, each along another line of the volume; a rigid machine has the same errors on all."""
    often = [measured(cmm, option, rng) for _ in range(PROFILES)]
    readings = {a: np.mean([one[a] for one, _ in often], axis=0) for a in "XYZ"}
    return readings, {p: float(np.mean([square[p] for _, square in often])) for p in PAIRS}


def count_large(tried: int = TRIED) -> int:
    """How many machines have an error vector above LARGE somewhere in the volume."""
    places, count = grid(), 0
    for seed in range(tried):
        cmm = drawn_cmm(np.random.default_rng([seed, 20170920]))
        count += _largest(volumetric(machine(cmm.curves, cmm.square), places))[3] > LARGE
    return count


def by_nets(
    readings: Curves, layout: str, rng: np.random.Generator, epochs: int = calibration.EPOCHS
) -> Curves:
    """Every axis's six errors at NODES by its own net, learnt from all readings."""
    x = TARGETS[:, None]
    return {
        a: calibration.train_net(x, six, layout, rng, epochs).at(NODES[:, None])
        for a, six in readings.items()
    }


def by_splines(readings: Curves) -> Curves:
    """The same by cubic splines through the readings, which a machine file can hold."""
    from scipy.interpolate import CubicSpline

    return {a: np.asarray(CubicSpline(TARGETS, six)(NODES)) for a, six in readings.items()}


def compare_layouts(
    readings: Curves, rng: np.random.Generator, epochs: int = calibration.EPOCHS
) -> tuple[LayoutResult, ...]:
    """Errors of the four layouts, on positions learnt, held out and on all, mean over the 18 errors."""
    kept, held = calibration.folds(len(TARGETS))
    x, out = TARGETS[:, None], []
    for layout in calibration.LAYOUTS:
        parts = []
        for six in readings.values():
            net, span = calibration.train_net(x[kept], six[kept], layout, rng, epochs), np.ptp(six, axis=0)
            parts.append(
                [calibration.share_left(net, x[k], six[k], span) for k in (kept, held, np.arange(len(x)))]
            )
        out.append(LayoutResult(layout, *(float(v) for v in np.mean(parts, axis=0))))
    return tuple(out)


def grid(nodes: int = 11) -> Array:
    """Places (nodes^3, 3) mm over the volume."""
    ends = np.linspace(0.0, TRAVEL, nodes)
    return np.stack(np.meshgrid(ends, ends, ends, indexing="ij"), axis=-1).reshape(-1, 3)


def compensated(true: Machine, model: Machine, method: str) -> Residual:
    """What is left where the predicted error is taken off the encoder position."""
    places = grid()
    error = volumetric(true, places)
    left = error - volumetric(model, places)
    return Residual(method, _largest(error), _largest(left))


def _largest(error: Array) -> tuple[float, float, float, float]:
    sizes = [*np.abs(error).max(axis=0), np.linalg.norm(error, axis=1).max()]
    x, y, z, whole = (1e3 * float(v) for v in sizes)
    return x, y, z, whole


def diagonal(true: Machine, model: Machine, method: str) -> DiagonalResult:
    """692.82 mm in ten steps, relative to its start; the 27 um of the paper are the norm of 7, 23 and 12."""
    places = np.linspace(0.0, TRAVEL, DIAGONAL_STEPS + 1)[:, None] * np.ones(3)
    error = volumetric(true, places)
    left = error - volumetric(model, places)
    error, left = error - error[0], left - left[0]
    along = np.ones(3) / np.sqrt(3.0)
    values = (
        np.linalg.norm(error, axis=1),
        np.abs(error @ along),
        np.linalg.norm(left, axis=1),
        np.abs(left @ along),
    )
    return DiagonalResult(method, *(1e3 * float(v.max()) for v in values))


def one_machine(seed: int, option: str = "precision", epochs: int = calibration.EPOCHS) -> OneMachine:
    """Drawn, measured, learnt, compensated."""
    rng = np.random.default_rng([seed, 20170920])
    cmm = drawn_cmm(rng)
    readings, square = measured(cmm, option, rng)
    true = machine(cmm.curves, cmm.square)
    models = {
        METHODS[0]: machine(by_nets(readings, calibration.BEST_LAYOUT, rng, epochs), square),
        METHODS[1]: machine(by_splines(readings), square),
    }
    layouts = compare_layouts(readings, rng, epochs)
    means, square = measured_often(cmm, option, rng)
    models |= {
        METHODS[2]: machine(by_nets(means, calibration.BEST_LAYOUT, rng, epochs), square),
        METHODS[3]: machine(by_splines(means), square),
    }
    return OneMachine(
        layouts,
        tuple(compensated(true, model, method) for method, model in models.items()),
        tuple(diagonal(true, model, method) for method, model in models.items()),
    )


def run(
    draws: int = DRAWS, option: str = "precision", progress: Progress = lambda text, share: None
) -> EcherfaouiTwin:
    """So many drawn machines."""
    found = []
    for seed in range(draws):
        progress(f"machine {seed + 1} of {draws}", seed / draws)
        found.append(one_machine(seed, option))
    return EcherfaouiTwin(tuple(found), option, 1e3 * STEEL * TRAVEL, count_large())


def figures(result: EcherfaouiTwin) -> dict[str, Any]:
    """Body of the JSON document: every machine, lengths in um, shares as numbers."""
    return {
        "option": result.option,
        "thermal_um_per_K": result.thermal,
        "larger_than_63_um": {"machines": result.large, "of": result.tried},
        "machines": [
            {
                "layouts": [vars(one) for one in m.layouts],
                "residuals": [{**vars(one), "gain": one.gain} for one in m.residuals],
                "diagonals": [vars(one) for one in m.diagonals],
            }
            for m in result.machines
        ],
    }
