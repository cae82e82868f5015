"""All spirals of a turned face in one fit, with the results of reversals on the machine: separate the face from slide and spindle.

    reading(x, q) = face(place turned by the index of the scan) + h(x) + a(q) - x b(q) + plane and slow wander of each scan
    half turn      odd part of (line at 0 + line at 180 deg) / 2 = odd part of h(x) - x (b(0) + b(180)) / 2

h the rise by the slide, a and b axial and tilt motion of the spindle (fixed frame), each with the covariance of its measurement; the face
by Zernike terms
(Born and Wolf, Principles of Optics, 9.2.1). Generalised least squares; the noise is that of the residuals, and neighbours with
correlated errors count as fewer. A face that is
turned on the spindle between the scans separates its own orders from the spindle's; the half turn determines the odd part of h as a whole.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import factorial

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.task.instruments.face_scan import FaceScan

TURN = 2 * np.pi
PLANE = 3  # first terms: piston and tilts, which every scan has for itself


@dataclass(frozen=True, eq=False)
class SlideKnowledge:
    """Rise by the slide at nodes (k,) mm of X: value (k,) mm, covariance (k, k) mm^2; linear between them."""

    nodes: Array
    value: Array
    covariance: Array


@dataclass(frozen=True, eq=False)
class SpindleKnowledge:
    """Cosine and sine of order 1, 2 ... in turn: axial (2 p,) mm, tilt (2 p,) rad, and their variances (2 p,)."""

    axial: Array
    axial_variance: Array
    tilt: Array
    tilt_variance: Array


@dataclass(frozen=True, eq=False)
class HalfTurn:
    """Lines over the centre at 0 and at 180 deg: at places (n,) mm above zero the odd part of their mean, mm, and its standard uncertainty."""

    place: Array
    odd: Array
    u: float


@dataclass(frozen=True)
class FacePrior:
    """radius mm and degree of the terms of the face, each of this usual `size`, mm; wander: rms of the slow wander of one scan, mm; plane: u of its piston
    and tilts at the rim, as good as unknown. rings, sectors: means in which each spiral is taken.
    """

    radius: float
    size: float
    wander: float
    degree: int = 6
    plane: float = 1e-3
    rings: int = 25
    sectors: int = 36


@dataclass(frozen=True, eq=False)
class FaceFit:
    """terms (k,) of the face without piston and tilts, mm, and their covariance; noise: rms of the residuals, mm."""

    prior: FacePrior
    terms: Array
    covariance: Array
    noise: float

    def at(self, x: Array, y: Array) -> Array:
        """Return the height (n,) mm at places of the face."""
        return np.asarray(self._columns(x, y) @ self.terms)

    def u_at(self, x: Array, y: Array) -> Array:
        """Return the standard uncertainty (n,) mm there."""
        columns = self._columns(x, y)
        return np.asarray(np.sqrt(np.einsum("ki,ij,kj->k", columns, self.covariance, columns)))

    def _columns(self, x: Array, y: Array) -> Array:
        return zernike_terms(x, y, self.prior.radius, self.prior.degree)[:, PLANE:]


@dataclass(frozen=True, eq=False)
class _Numbers:
    """Places of the numbers of each kind, and their total."""

    size: int
    face: slice
    slide: slice
    axial: slice
    tilt: slice
    planes: slice
    rings: slice


def fit_face(
    scans: Sequence[FaceScan],
    index: Sequence[float],
    slide: SlideKnowledge,
    spindle: SpindleKnowledge,
    prior: FacePrior,
    half_turn: HalfTurn | None = None,
) -> FaceFit:
    """Fit the face from all spirals. index: rad by which it was turned on the spindle in each. Raises UsageError for rasters and too
    short spirals."""
    if len(scans) != len(index) or not all(s.spiral for s in scans):
        raise UsageError("the joint fit takes spirals, and for each the angle by which the face was turned")
    where = _numbers(slide, spindle, prior, len(scans))
    means = [_means(scan, prior) for scan in scans]
    rows = [
        _rows(of, turned, number, where, (slide, prior))
        for number, (of, turned) in enumerate(zip(means, index))
    ]
    a, y = np.concatenate(rows), np.concatenate([of.reading for of in means])
    mean, precision = _knowledge(slide, spindle, prior, where)
    information, right = precision, precision @ mean
    if half_turn is not None:
        half = _half_turn_rows(half_turn, slide, where)
        information = half.T @ half / half_turn.u**2 + information
        right = half.T @ half_turn.odd / half_turn.u**2 + right
    u = _scatter(means, prior.size)
    for _ in range(2):  # the noise from the residual, once the fit is known
        normal = a.T @ a / u**2 + information
        theta = np.linalg.solve(normal, a.T @ y / u**2 + right)
        left = y - a @ theta
        u = float(np.sqrt((left**2).mean() * memory(left, prior.sectors)))
    covariance = np.asarray(np.linalg.inv(normal), dtype=float)[where.face, where.face]
    return FaceFit(prior, theta[where.face], covariance, float(left.std()))


def zernike_terms(x: Array, y: Array, radius: float, degree: int) -> Array:
    """Return Zernike terms (n, k) to a degree at places mm, unnormalised; the first three are piston and tilts."""
    rho, phi = np.hypot(x, y) / radius, np.arctan2(y, x)
    out = []
    for n in range(degree + 1):
        for m in range(-n, n + 1, 2):
            angular = np.cos(m * phi) if m >= 0 else np.sin(-m * phi)
            out.append(_radial(n, abs(m), rho) * angular)
    return np.stack(out, axis=1)


def _radial(n: int, m: int, rho: Array) -> Array:
    """Evaluate Zernike's radial polynomial (Born and Wolf, Principles of Optics, 9.2.1)."""
    f, total = factorial, np.zeros_like(rho)
    for s in range((n - m) // 2 + 1):
        size = (-1) ** s * f(n - s) / (f(s) * f((n + m) // 2 - s) * f((n - m) // 2 - s))
        total += size * rho ** (n - 2 * s)
    return total


@dataclass(frozen=True, eq=False)
class _ScanMeans:
    """Means (n,) of one spiral over rings of whole turns and sectors: x mm, angle rad, reading mm, ring."""

    x: Array
    angle: Array
    reading: Array
    ring: np.ndarray


def _means(scan: FaceScan, prior: FacePrior) -> _ScanMeans:
    angle = np.asarray(scan.across) - np.floor(float(np.min(scan.across)) / TURN + 1e-9) * TURN
    turn = np.floor(angle / TURN + 1e-9).astype(np.intp)
    turns = int(turn.max()) + 1
    if turns < prior.rings:
        raise UsageError(f"{scan.name}: {turns} turns; the joint fit takes {prior.rings} or more")
    within = np.mod(angle + 1e-9, TURN) - 1e-9
    sector = np.minimum((within / TURN * prior.sectors + 1e-6).astype(np.intp), prior.sectors - 1)
    ring = turn * prior.rings // turns
    cell = ring * prior.sectors + sector
    count = np.bincount(cell, minlength=prior.rings * prior.sectors)
    full = count > 0

    def mean(values: Array) -> Array:
        return np.asarray(np.bincount(cell, values, len(count))[full] / count[full])

    rings = np.repeat(np.arange(prior.rings), prior.sectors)[full]
    return _ScanMeans(mean(scan.x), mean(within), mean(scan.reading), rings)


def _numbers(slide: SlideKnowledge, spindle: SpindleKnowledge, prior: FacePrior, scans: int) -> _Numbers:
    face = zernike_terms(np.zeros(1), np.zeros(1), prior.radius, prior.degree).shape[1] - PLANE
    sizes = [
        face,
        len(slide.nodes),
        len(spindle.axial),
        len(spindle.tilt),
        PLANE * scans,
        prior.rings * scans,
    ]
    ends = np.cumsum([0, *sizes])
    return _Numbers(int(ends[-1]), *(slice(int(s), int(e)) for s, e in pairwise(ends)))


def _rows(
    of: _ScanMeans, index: float, number: int, where: _Numbers, knowledge: tuple[SlideKnowledge, FacePrior]
) -> Array:
    slide, prior = knowledge
    px, py = of.x * np.cos(of.angle - index), of.x * np.sin(of.angle - index)
    a = np.zeros((len(of.x), where.size))
    a[:, where.face] = zernike_terms(px, py, prior.radius, prior.degree)[:, PLANE:]
    a[:, where.slide] = hats(slide.nodes, of.x)
    a[:, where.axial] = _waves(of.angle, where.axial)
    a[:, where.tilt] = -of.x[:, None] * _waves(of.angle, where.tilt)
    first = where.planes.start + PLANE * number
    a[:, first : first + PLANE] = np.stack([np.ones(len(of.x)), px, py], axis=1)
    a[np.arange(len(of.x)), where.rings.start + prior.rings * number + of.ring] = 1.0
    return a


def _half_turn_rows(half: HalfTurn, slide: SlideKnowledge, where: _Numbers) -> Array:
    a = np.zeros((len(half.place), where.size))
    a[:, where.slide] = (hats(slide.nodes, half.place) - hats(slide.nodes, -half.place)) / 2
    tilt = _waves(np.array([0.0, np.pi]), where.tilt).mean(axis=0)
    a[:, where.tilt] = -half.place[:, None] * tilt
    return a


def _knowledge(
    slide: SlideKnowledge, spindle: SpindleKnowledge, prior: FacePrior, where: _Numbers
) -> tuple[Array, Array]:
    """Return (mean, precision) of all numbers before the scans."""
    mean, covariance = np.zeros(where.size), np.zeros((where.size, where.size))
    mean[where.slide], covariance[where.slide, where.slide] = slide.value, slide.covariance
    for part, value, variance in (
        (where.axial, spindle.axial, spindle.axial_variance),
        (where.tilt, spindle.tilt, spindle.tilt_variance),
    ):
        mean[part], covariance[part, part] = value, np.diag(variance)
    for part, size in ((where.face, prior.size), (where.planes, prior.plane)):
        covariance[part, part] = size**2 * np.eye(part.stop - part.start)
    ring = np.arange(1, prior.rings + 1)
    walk = 6 * prior.wander**2 * np.minimum(ring[:, None], ring) / prior.rings  # of this rms about its mean
    for first in range(where.rings.start, where.rings.stop, prior.rings):
        covariance[first : first + prior.rings, first : first + prior.rings] = walk
    scale = np.sqrt(np.diag(covariance))
    return mean, np.linalg.inv(covariance / np.outer(scale, scale)) / np.outer(scale, scale)


def hats(nodes: Array, x: Array) -> Array:
    """Return linear interpolation between the nodes, (n, k)."""
    left = np.clip(np.searchsorted(nodes, x, side="right") - 1, 0, len(nodes) - 2)
    t = (x - nodes[left]) / (nodes[left + 1] - nodes[left])
    out = np.zeros((len(x), len(nodes)))
    out[np.arange(len(x)), left], out[np.arange(len(x)), left + 1] = 1 - t, t
    return out


def _waves(angle: Array, part: slice) -> Array:
    turns = np.outer(angle, np.arange(1, (part.stop - part.start) // 2 + 1))
    return np.stack([np.cos(turns), np.sin(turns)], axis=2).reshape(len(angle), -1)


def _scatter(means: Sequence[_ScanMeans], size: float) -> float:
    """Return a first guess of the noise of a mean: rms of differences of neighbours, and a hundredth of the face."""
    return float(np.mean([np.std(np.diff(of.reading)) for of in means]) / np.sqrt(2)) + 0.01 * size


def memory(left: Array, most: int) -> float:
    """Return 1 + 2 sum of correlations up to the first that is not above zero: neighbours with correlated errors count as fewer."""
    size, total = float((left**2).mean()), 1.0
    for lag in range(1, most):
        rho = float((left[lag:] * left[:-lag]).mean()) / size
        if rho <= 0:
            break
        total += 2 * rho
    return total
