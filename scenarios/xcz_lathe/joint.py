"""All scans in one fit: the flat's shape, the machine's errors and what the selective model leaves out, by generalised least squares.

    on-machine   reading(x, q) = flat(place, index) + h(x) + E_ZC(q) - x E_BC(q) + plane and slow wander of each scan
    half turn    odd part of (scan at 0 + scan at 180 deg) / 2 = odd part of h(x) - x (E_BC(0) + E_BC(180)) / 2
    knowledge    h = E_ZX - x B0C - x E_BX(x), E_ZX as the straightness reversal found it, E_BX of ROLL's size; orders of E_ZC and
                 E_BC as the face reversal found them; all with their covariances

The half turn tells the odd part of h with everything that is in it, E_BX included. A flat that is turned on the spindle between
the repeats (index) tells its own orders from the spindle's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vcmm import Array, reversals

from .flat import PER_TURN, SLOW, FlatScan, cells, on_flat, terms
from .lathe import NM, RADIUS, YAW
from .surveys import MIRROR, PLACED, PLACES, Survey

RINGS, SECTORS = 25, 36
NODES = np.linspace(-RADIUS, RADIUS, 41)
SHAPE = 10 * NM  # prior of a term of the flat
FREE = 1e-3  # mm or rad: as good as unknown
YAW_LENGTH = 12.0  # mm


@dataclass(frozen=True, eq=False)
class JointFit:
    """surface, u (k,) mm: the flat at the cells and its standard uncertainty; noise: rms of what is left, mm."""

    surface: Array
    u: Array
    noise: float


@dataclass(frozen=True, eq=False)
class _Columns:
    """Where the numbers of each kind stand, and how many there are."""

    size: int
    shape: slice
    slide: slice
    axial: slice
    tilt: slice
    planes: slice
    rings: slice


def joint_fit(
    survey: Survey, scans: Sequence[FlatScan], index: Sequence[float], yaw: bool = False
) -> JointFit:
    """The flat from all scans; index: rad by which it was turned in each of them. yaw: E_BX was measured too."""
    where = _columns(survey, len(scans))
    rows, read = [], []
    for number, (scan, turned) in enumerate(zip(scans, index)):
        a, y = _flat_rows(scan, turned, number, where)
        rows.append(a)
        read.append(y)
    half, odd, u_half = _half_turn_rows(survey, where)
    mean, precision = _knowledge(survey, where, yaw)
    a, y = np.concatenate(rows), np.concatenate(read)
    u = _scatter(scans)
    for _ in range(2):  # the noise from what is left, once the fit is known
        normal = a.T @ a / u**2 + half.T @ half / u_half**2 + precision
        right = a.T @ y / u**2 + half.T @ odd / u_half**2 + precision @ mean
        found = np.linalg.solve(normal, right)
        left = y - a @ found
        u = float(np.sqrt((left**2).mean() * _memory(left)))
    x, place_y = cells()
    columns = terms(x, place_y)[:, 3:]
    covariance = np.linalg.inv(normal)[where.shape, where.shape]
    spread = np.sqrt(np.einsum("ki,ij,kj->k", columns, covariance, columns))
    return JointFit(columns @ found[where.shape], spread, float(left.std()))


def _columns(survey: Survey, scans: int) -> _Columns:
    orders = survey.spindle.value.shape[1]
    sizes = [
        terms(np.zeros(1), np.zeros(1)).shape[1] - 3,
        len(NODES),
        2 * orders,
        2 * orders,
        3 * scans,
        RINGS * scans,
    ]
    ends = np.cumsum([0, *sizes])
    parts = [slice(int(s), int(e)) for s, e in pairwise(ends)]
    return _Columns(int(ends[-1]), *parts)


def _means(values: Array) -> Array:
    """(RINGS * SECTORS,) means of a spiral's values over rings of turns and sectors."""
    return values.reshape(RINGS, -1, SECTORS, PER_TURN // SECTORS).mean(axis=(1, 3)).ravel()


def _flat_rows(scan: FlatScan, index: float, number: int, where: _Columns) -> tuple[Array, Array]:
    x, q = _means(scan.x), _means(np.mod(scan.angle, 2 * np.pi))
    px, py = on_flat(x, q, index)
    a = np.zeros((len(x), where.size))
    a[:, where.shape] = terms(px, py)[:, 3:]
    a[:, where.slide] = _hats(x)
    waves = _waves(q, where)
    a[:, where.axial], a[:, where.tilt] = waves, -x[:, None] * waves
    first = where.planes.start + 3 * number
    a[:, first : first + 3] = np.stack([np.ones(len(x)), px, py], axis=1)
    ring = where.rings.start + RINGS * number + np.repeat(np.arange(RINGS), SECTORS)
    a[np.arange(len(x)), ring] = 1.0
    return a, _means(scan.reading)


def _half_turn_rows(survey: Survey, where: _Columns) -> tuple[Array, Array, float]:
    """Rows of x > 0, the odd part that was read, and its u from the scatter of the scans."""
    odd = np.stack([(s.value - s.value[::-1]) / 2 for s in survey.scans])
    first = np.array([s.setup == reversals.NORMAL for s in survey.scans])
    up = MIRROR > 1e-9
    both = (odd[first].mean(axis=0) + odd[~first].mean(axis=0)) / 2
    left = np.concatenate([odd[m] - odd[m].mean(axis=0) for m in (first, ~first)])
    a = np.zeros((int(up.sum()), where.size))
    a[:, where.slide] = (_hats(MIRROR[up]) - _hats(-MIRROR[up])) / 2
    tilt = _waves(np.array([0.0, np.pi]), where).mean(axis=0)
    a[:, where.tilt] = -MIRROR[up][:, None] * tilt
    spread = float(
        np.sqrt((left**2).sum() / (len(odd) - 2) / left.shape[1] / len(odd) * _memory(left.ravel()))
    )
    return a, both[up], spread


def _knowledge(survey: Survey, where: _Columns, measured: bool) -> tuple[Array, Array]:
    """(mean, precision) of all numbers before the scans."""
    mean, covariance = np.zeros(where.size), np.zeros((where.size, where.size))
    on = _interpolation(survey.straight.nodes, NODES)
    yaw = YAW**2 * np.exp(-((NODES[:, None] - NODES) ** 2) / (2 * YAW_LENGTH**2))
    mean[where.slide] = on @ survey.straight.machine
    if measured:
        mean[where.slide] -= NODES * (_interpolation(PLACES, NODES) @ survey.yaw[0])
        yaw *= (survey.yaw[1] / YAW) ** 2
    slope = on @ np.gradient(
        survey.straight.artefact, survey.straight.nodes
    )  # a mirror that lies PLACED beside its old place
    covariance[where.slide, where.slide] = (
        on @ survey.straight.covariance @ on.T
        + (PLACED / 2) ** 2 * np.outer(slope, slope)
        + np.outer(NODES, NODES) * (yaw + FREE**2)
        + (0.05 * NM) ** 2 * np.eye(len(NODES))
    )
    for name, part in (("EZC", where.axial), ("EBC", where.tilt)):
        i = survey.spindle.names.index(name)
        value, known = survey.spindle.value[i], survey.spindle.identified[i]
        mean[part] = np.stack([value.real, -value.imag], axis=1).ravel()
        free = FREE if name == "EZC" else FREE / RADIUS
        covariance[part, part] = np.diag(
            np.repeat(np.where(known, survey.spindle.covariance[:, i, i], free**2), 2)
        )
    for part, size in ((where.shape, SHAPE), (where.planes, FREE)):
        covariance[part, part] = size**2 * np.eye(part.stop - part.start)
    ring = np.arange(1, RINGS + 1)
    walk = 6 * SLOW**2 * np.minimum(ring[:, None], ring) / RINGS  # of rms SLOW about its mean
    for first in range(where.rings.start, where.rings.stop, RINGS):
        covariance[first : first + RINGS, first : first + RINGS] = walk
    scale = np.sqrt(np.diag(covariance))
    precision = np.linalg.inv(covariance / np.outer(scale, scale)) / np.outer(scale, scale)
    return mean, precision


def _hats(x: Array) -> Array:
    return _interpolation(NODES, x)


def _interpolation(nodes: Array, x: Array) -> Array:
    """(n, k): linear interpolation between the nodes."""
    left = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    t = (x - nodes[left]) / (nodes[left + 1] - nodes[left])
    out = np.zeros((len(x), len(nodes)))
    out[np.arange(len(x)), left], out[np.arange(len(x)), left + 1] = 1 - t, t
    return out


def _waves(angle: Array, where: _Columns) -> Array:
    k = np.arange(1, (where.tilt.stop - where.tilt.start) // 2 + 1)
    turns = np.outer(angle, k)
    return np.stack([np.cos(turns), np.sin(turns)], axis=2).reshape(len(angle), -1)


def _scatter(scans: Sequence[FlatScan]) -> float:
    """A first guess of the noise of a mean: rms of differences of neighbours."""
    return float(np.mean([np.std(np.diff(_means(s.reading))) for s in scans]) / np.sqrt(2)) + 0.1 * NM


def _memory(left: Array) -> float:
    """1 + 2 sum of correlations up to the first that is not above zero: neighbours that err alike count as fewer."""
    size, total = float((left**2).mean()), 1.0
    for lag in range(1, SECTORS):
        rho = float((left[lag:] * left[:-lag]).mean()) / size
        if rho <= 0:
            break
        total += 2 * rho
    return total
