"""A turned or milled face scanned on the machine that made it: separate part and machine, and state what no such scan determines.

    reading d = f(part) + s(machine)         s = -(tip error along Z): how the surface under the probe seems to rise, mm
    spiral      the spindle C turns the part under the probe, which is at X (signed): place r = |X|, d from the programmed surface
    turned face f = p(r) with p(r) = t(r) - s(r): t is the deviation by the tool beside the slide's own error, which is cut into the part

With g(X) the mean over the turns: g(+r) = p(r) + s(r) = t(r), so on the side where the tool cut everything that the slide repeats is
invisible; g(-r) = p(r) + s(-r). Hence

    (g(+r) - g(-r)) / 2 = odd part of s          (g(+r) + g(-r)) / 2 = p(r) + even part of s

for any machine that cut the part. A squareness of X to the axis of C by phi, s = -phi X, cuts the cone p = phi r, which the cut side does
not show and
the other side shows twice. No scan determines the even part of s (a dish of the slide): it comes from the machine file (a reversal,
docs/reversal.md) or stays in p. Evans, Hocken and Estler, "Self-calibration: reversal, redundancy, error separation, and absolute testing",
Annals of the CIRP 45 (1996) 617-634.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.face_knowledge import KnownRise, known_rise
from vcmm.learn.calibration.face_outliers import outlier_remarks
from vcmm.task.instruments.face_scan import FaceScan

LOBES = (2, 3, 4, 5, 6)  # orders per turn that are reported; order 1 is the tilt of the face
READINGS = 12  # at least, for every ring of a turned face
MOST_RINGS, MOST_CELLS = 40, 60
LAGS = 200  # of the memory of neighbours


@dataclass(frozen=True)
class FaceFigure:
    """One number with its standard uncertainty, of unit "mm" or "rad"."""

    name: str
    value: float
    u: float
    unit: str


@dataclass(frozen=True, eq=False)
class FaceMap:
    """The map of the part: cells x (k,), y (m,) mm of the face, height and u (m, k) mm; NaN where no reading lies.

    Of a turned face also r (j,), profile p (j,) with u and covariance (j, j), and odd (j,) with u_odd: the odd part of the slide's error that the
    machine file does not hold, None without readings on both sides. noise: rms of the residuals, mm; memory: number of readings with a common error.
    """

    scan: FaceScan
    x: Array
    y: Array
    height: Array
    u: Array
    figures: tuple[FaceFigure, ...]
    noise: float
    memory: float
    warnings: tuple[str, ...]
    machine: str
    r: Array | None = None
    profile: Array | None = None
    covariance: Array | None = None
    odd: Array | None = None
    u_odd: Array | None = None

    @property
    def u_profile(self) -> Array:
        assert self.covariance is not None
        return np.asarray(np.sqrt(np.diag(self.covariance)))

    def at(self, x: Array, y: Array) -> Array:
        """Return the excess height of the face, mm, at places (n,) of the part; beyond the scan the value at its edge.

        A turned face by its profile over the radius: errors that go round with the spindle cannot be corrected by a turning program.
        """
        if self.r is not None and self.profile is not None:
            return np.asarray(np.interp(np.hypot(x, y), self.r, self.profile))
        return _bilinear(self.x, self.y, _without_gaps(self.height), x, y)


def map_face(scan: FaceScan, machine: Machine | None = None) -> FaceMap:
    """Map the face of a scan. machine: knowledge about the machine that scanned it; its errors are subtracted from the readings.

    Raises UsageError where the readings are too few or lie on no area.
    """
    return (_spiral if scan.spiral else _raster)(scan, known_rise(scan, machine))


def _spiral(scan: FaceScan, rise: KnownRise) -> FaceMap:
    """Map a turned face: profiles of both sides, tilt and lobes by least squares, each scan with its own zero.

    All is linear in the readings, so that the knowledge of the machine goes through the same matrices (vcmm.learn.calibration.face_knowledge).
    """
    height = scan.reading - rise.value
    sides = [s for s in (1.0, -1.0) if (s * scan.x > 0).sum() >= 4 * READINGS]
    if 1.0 not in sides:
        raise UsageError(
            "no readings at X > 0, the side on which the tool cuts: turn the sign of X_mm, or scan that side"
        )
    nodes = _rings(scan, sides)
    a, cut = _columns(scan, sides, nodes)
    fit, noise, memory = _least_squares(a, height)
    theta, k = fit.estimate, len(nodes)
    alone = (fit.weights * rise.alone) @ fit.weights.T
    covariance, moved = fit.covariance + alone, fit.weights @ rise.joint
    halves = np.zeros((len(sides), k, len(theta)))
    for i in range(len(sides)):
        halves[i, :, i * k : (i + 1) * k] = np.eye(k)
    to_p = (np.eye(k) - np.outer(np.ones(k), _ring_areas(nodes))) @ halves.mean(axis=0)
    to_odd = (halves[0] - halves[-1]) / 2
    profile, spread = to_p @ theta, to_p @ (covariance + moved @ moved.T) @ to_p.T
    figures = [*_shape_figures(scan, nodes, profile, spread), *_lobe_figures(theta, covariance, cut["lobes"])]
    odd = u_odd = None
    if len(sides) == 2:  # it is what the machine file does not hold, so that the file's u is not in it
        by_noise = to_odd @ covariance @ to_odd.T
        odd, u_odd = to_odd @ theta, np.sqrt(np.diag(by_noise))
        figures.append(_slope(nodes, odd, by_noise))
    # free zeros and tilts, the mean over the area, and what the slide still does on either side
    off = np.outer(np.ones(len(height)), _ring_areas(nodes)) @ halves.mean(axis=0)
    off += np.sign(scan.x)[:, None] * (_hats(nodes, np.abs(scan.x)) @ to_odd)
    off[:, cut["free"]] += a[:, cut["free"]]
    px, py = scan.x * np.cos(scan.across), scan.x * np.sin(scan.across)
    x, y, cells, count, _ = _cell_means(px, py, height - off @ theta)
    number = _cell_numbers(px, py)[0]
    together = _means_of(number, rise.joint - off @ moved, count.size)
    u_cells = _u_alone(noise, memory, count, _means_of(number, rise.alone[:, None], count.size))
    u = np.sqrt(u_cells**2 + (together**2).sum(axis=1).reshape(count.shape))
    return FaceMap(
        scan=scan, x=x, y=y, height=cells, u=u, figures=(*_size_figures(cells, u_cells, together), *figures), noise=noise, memory=memory,
        warnings=(*_unseen(scan, rise.machine, len(sides)), *outlier_remarks(scan, a, height, height - a @ theta)), machine=rise.machine, r=nodes, profile=profile, covariance=spread, odd=odd, u_odd=u_odd,
    )  # fmt: skip


def _rings(scan: FaceScan, sides: list[float]) -> Array:
    """Return the radii of the nodes, mm, from the innermost to the outermost reading that all sides have."""
    low = max(float(np.abs(scan.x[s * scan.x > 0]).min()) for s in sides)
    high = min(float(np.abs(scan.x[s * scan.x > 0]).max()) for s in sides)
    if not high > low:
        raise UsageError(
            "the readings lie on one radius: a spiral goes over the face, from the rim to the centre"
        )
    count = min(MOST_RINGS, len(scan.x) // (READINGS * len(sides)))
    return np.linspace(low, high, max(count, 3))


def _columns(scan: FaceScan, sides: list[float], nodes: Array) -> tuple[Array, dict[str, slice]]:
    """Return the columns of the fit: profile of each side, then what is free (tilt of each scan, zero of each but the first) and lobes."""
    r, c = np.abs(scan.x), scan.across
    profiles = [_hats(nodes, r) * (s * scan.x > 0)[:, None] for s in sides]
    names = list(dict.fromkeys(scan.run.tolist()))
    free = []
    for i, name in enumerate(names):
        mine = (scan.run == name).astype(float)
        free += [mine * scan.x * np.cos(c), mine * scan.x * np.sin(c)] + ([mine] if i else [])
    lobes = []
    for order in LOBES:  # E_ZC and -x E_BC alike: of part or spindle, which one scan does not tell
        lobes += [
            wave * arm for wave in (np.cos(order * c), np.sin(order * c)) for arm in (np.ones(len(r)), scan.x)
        ]
    start = len(sides) * len(nodes)
    cut = {
        "free": slice(start, start + len(free)),
        "lobes": slice(start + len(free), start + len(free) + len(lobes)),
    }
    return np.column_stack([*profiles, *free, *lobes]), cut


@dataclass(frozen=True, eq=False)
class LinearFit:
    """estimate (p,) = weights (p, n) @ readings, covariance (p, p) by noise alone."""

    estimate: Array
    weights: Array
    covariance: Array


def _least_squares(a: Array, y: Array) -> tuple[LinearFit, float, float]:
    """Return (fit, noise, memory): neighbours with correlated errors count as fewer (1 + 2 sum of correlations)."""
    scale = np.sqrt((a**2).sum(axis=0))
    scale[scale == 0] = 1.0
    q = a / scale
    inverse = np.linalg.pinv(q.T @ q, rcond=1e-12, hermitian=True)
    rank = np.linalg.matrix_rank(inverse, hermitian=True)
    theta = inverse @ (q.T @ y)
    theta = theta + inverse @ (q.T @ (y - q @ theta))  # once more: what rounding left
    left = y - q @ theta
    noise = float(np.sqrt((left**2).sum() / max(len(y) - int(rank), 1)))
    memory = _memory(left)
    covariance = noise**2 * memory * inverse / np.outer(scale, scale)
    return LinearFit(theta / scale, inverse @ q.T / scale[:, None], covariance), noise, memory


def _memory(left: Array) -> float:
    """Return 1 + 2 sum of correlations up to the first that is not above zero."""
    size, total = float((left**2).mean()), 1.0
    if size == 0:
        return total
    for lag in range(1, min(LAGS, len(left) // 4)):
        rho = float((left[lag:] * left[:-lag]).mean()) / size
        if rho <= 2 / np.sqrt(len(left)):
            break
        total += 2 * rho
    return total


def _shape_figures(scan: FaceScan, r: Array, p: Array, covariance: Array) -> list[FaceFigure]:
    """Return the cone and dish of the profile: p = c0 + c1 r + c2 (r/R)^2, weighted by area; of a sphere the tool beside the centre, d =
    c1 radius."""
    a = np.column_stack([np.ones(len(r)), r, (r / r[-1]) ** 2])
    weight = np.sqrt(_ring_areas(r))[:, None]
    to = np.linalg.pinv(a * weight) * weight.T
    value, spread = to @ p, to @ covariance @ to.T
    u = np.sqrt(np.diag(spread))
    out = [
        FaceFigure("cone", float(value[1]), float(u[1]), "rad"),
        FaceFigure("dish at the rim", float(value[2]), float(u[2]), "mm"),
    ]
    if scan.radius:
        out.append(
            FaceFigure(
                "tool beside the centre", float(value[1]) * scan.radius, float(u[1]) * abs(scan.radius), "mm"
            )
        )
    return out


def _lobe_figures(theta: Array, covariance: Array, where: slice) -> list[FaceFigure]:
    """Return the amplitude of each order at the centre of the face (axial)."""
    out = []
    for i, order in enumerate(LOBES):
        c, s = where.start + 4 * i, where.start + 4 * i + 2
        size = float(np.hypot(theta[c], theta[s]))
        u = float(np.sqrt((covariance[c, c] + covariance[s, s]) / 2))
        out.append(FaceFigure(f"{order} per turn, axial", size, u, "mm"))
    return out


def _slope(r: Array, odd: Array, covariance: Array) -> FaceFigure:
    """Return the slope of the odd part: the squareness of X to the spindle that the machine file does not hold, s = -phi X."""
    to = -r / float(r @ r)
    return FaceFigure(
        "squareness of X to the spindle", float(to @ odd), float(np.sqrt(to @ covariance @ to)), "rad"
    )


def _raster(scan: FaceScan, rise: KnownRise) -> FaceMap:
    """Map a milled face: less its plane (or its mean) of each scan."""
    height = scan.reading - rise.value
    names = list(dict.fromkeys(scan.run.tolist()))
    columns = []
    for name in names:
        mine = (scan.run == name).astype(float)
        columns += [mine, mine * scan.x, mine * scan.across] if scan.level == "plane" else [mine]
    a = np.column_stack(columns)
    if len(height) < 12 + a.shape[1] or np.ptp(scan.x) == 0 or np.ptp(scan.across) == 0:
        raise UsageError(
            f"{len(height)} readings on no area: a raster takes twelve or more, over X and over Y"
        )
    both = np.column_stack([height, rise.joint])
    flat = both - a @ np.linalg.lstsq(a, both, rcond=None)[0]
    x, y, cells, count, inside = _cell_means(scan.x, scan.across, flat[:, 0])
    noise = float(np.sqrt((inside**2).sum() / max(len(flat) - int((count > 0).sum()), 1)))
    memory = _memory(inside)
    number = _cell_numbers(scan.x, scan.across)[0]
    together = _means_of(number, flat[:, 1:], count.size)
    u_cells = _u_alone(noise, memory, count, _means_of(number, rise.alone[:, None], count.size))
    u = np.sqrt(u_cells**2 + (together**2).sum(axis=1).reshape(count.shape))
    return FaceMap(
        scan=scan, x=x, y=y, height=cells, u=u, figures=_size_figures(cells, u_cells, together), noise=noise, memory=memory,
        warnings=_unseen(scan, rise.machine, 1), machine=rise.machine,
    )  # fmt: skip


def _size_figures(cells: Array, u: Array, together: Array) -> tuple[FaceFigure, ...]:
    """Return peak to valley (of the two cells) and rms of the map: the change of each with every cell, through u of the cells by
    themselves and through
    together (cells, m), their common errors."""
    filled = np.isfinite(cells)
    value, alone, common = cells[filled], u[filled], together[filled.ravel()]
    ends = np.zeros(len(value))
    ends[value.argmax()] += 1.0
    ends[value.argmin()] -= 1.0
    rms = float(value.std())
    out = []
    for name, size, slope in (
        ("flatness of the map, peak to valley", float(np.ptp(value)), ends),
        ("rms of the map", rms, (value - value.mean()) / max(len(value) * rms, 1e-300)),
    ):
        spread = np.concatenate([slope * alone, slope @ common])
        out.append(FaceFigure(name, size, float(np.linalg.norm(spread)), "mm"))
    return tuple(out)


def _unseen(scan: FaceScan, machine: str, sides: int) -> tuple[str, ...]:
    """Return what the scan does not determine, in words."""
    if not scan.spiral:
        if machine:
            return ()
        return (
            "no machine file: what the machine repeats is cut into the face and followed by the probe alike, so this map holds only what it does not repeat; "
            "name the machine file with --machine",
        )
    out = []
    if sides == 1 and not machine:
        out.append(
            "one side alone and no machine file: what the slide X repeats (its straightness, its squareness to the spindle) is cut into the face and not seen; "
            "scan on to the other side of the centre, or name the machine file with --machine"
        )
    elif sides == 1:
        out.append(
            "one side alone: the squareness of X to the spindle and the odd part of the slide's error are taken from the machine file, unchecked"
        )
    elif not machine:
        out.append(
            "no machine file: an even error of the slide X (a dish, the same on both sides of the centre) is cut and scanned alike and not seen; "
            "a straightness reversal tells it (docs/reversal.md), name its machine file with --machine"
        )
    return tuple(out)


def _ring_areas(r: Array) -> Array:
    """Return the shares (k,) of the face that rings about the nodes have."""
    edges = np.concatenate([[r[0]], (r[1:] + r[:-1]) / 2, [r[-1]]])
    area = np.diff(edges**2)
    return np.asarray(area / area.sum())


def _hats(nodes: Array, r: Array) -> Array:
    """Return linear interpolation between the nodes, the end value beyond them, (n, k)."""
    r = np.clip(r, nodes[0], nodes[-1])
    left = np.clip(np.searchsorted(nodes, r, side="right") - 1, 0, len(nodes) - 2)
    t = (r - nodes[left]) / (nodes[left + 1] - nodes[left])
    out = np.zeros((len(r), len(nodes)))
    out[np.arange(len(r)), left], out[np.arange(len(r)), left + 1] = 1 - t, t
    return out


def _cell_numbers(x: Array, y: Array) -> tuple[npt.NDArray[np.intp], list[Array]]:
    """Return (cell (n,) of each reading, edges of x and y): even cells, about four readings each."""
    side = int(np.clip(np.sqrt(len(x) / 4), 3, MOST_CELLS))
    edges = [np.linspace(v.min(), v.max(), side + 1) for v in (x, y)]
    at = [np.clip(np.searchsorted(e, v, side="right") - 1, 0, side - 1) for e, v in zip(edges, (x, y))]
    return np.asarray(at[1] * side + at[0], dtype=np.intp), edges


def _cell_means(x: Array, y: Array, height: Array) -> tuple[Array, Array, Array, Array, Array]:
    """Return (x, y, mean (m, k), count (m, k), rest of every reading (n,)) of cells."""
    number, edges = _cell_numbers(x, y)
    side = len(edges[0]) - 1
    count = np.bincount(number, minlength=side * side).astype(float)
    mean = _means_of(number, height[:, None], side * side)[:, 0]
    middles = [(e[1:] + e[:-1]) / 2 for e in edges]
    return middles[0], middles[1], mean.reshape(side, side), count.reshape(side, side), height - mean[number]


def _means_of(number: npt.NDArray[np.intp], columns: Array, cells: int) -> Array:
    """Return the means of columns (n, m), as (cells, m); NaN of an empty cell."""
    count = np.bincount(number, minlength=cells).astype(float)
    sums = [np.bincount(number, column, cells) for column in columns.T]
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.reshape(sums, (len(sums), cells)).T / count[:, None])


def _u_alone(noise: float, memory: float, count: Array, shared_variance: Array) -> Array:
    """Return u of cells by themselves: with `memory` readings of common error counting as one; shared_variance (cells, 1) mm^2: mean variance of
    Inputs that are sampled anew for each."""
    with np.errstate(invalid="ignore", divide="ignore"):
        noise_variance = noise**2 * np.minimum(memory, count) / count
        u = np.sqrt(noise_variance + shared_variance.reshape(count.shape) / count)
    return np.where(count > 0, u, np.nan)


def _without_gaps(height: Array) -> Array:
    """Fill empty cells with the nearest one that has a value."""
    if np.isfinite(height).all():
        return height
    rows, columns = np.nonzero(np.isfinite(height))
    out = height.copy()
    for i, j in zip(*np.nonzero(~np.isfinite(height))):
        near = ((rows - i) ** 2 + (columns - j) ** 2).argmin()
        out[i, j] = height[rows[near], columns[near]]
    return out


def _bilinear(x: Array, y: Array, values: Array, at_x: Array, at_y: Array) -> Array:
    wx, wy = _hats(x, at_x), _hats(y, at_y)
    return np.asarray(np.einsum("ni,ij,nj->n", wy, values, wx))
