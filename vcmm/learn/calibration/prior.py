"""Prior of an error curve: a Gaussian process of unknown size and smoothness.

The kind of a curve says which: smooth (splines), with two derivatives only, a polynomial, or a table of numbers apart.

    curve = size * smooth process of the length l, without its mean or line     size from the readings (evidence)
    a positioning error also has a line of any slope (scale error), squareness any angle

Factors F with unit-variance numbers z, theta = F z. Rasmussen & Williams, Gaussian Processes (2006), eq. 2.31, 5.8.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.calibration.model import Curve, ErrorModel, usual_pairs

SPREAD = 2.5  # of ln size: machines from 20 nm to 0.5 mm
SLOPE = 2e-4  # prior u of a scale error: far beyond any machine
FAR_TIMES_USUAL = 100.0  # times the usual squareness or location error: far beyond any machine
BROAD = 5.0  # times the usual size: nothing is known
GRAIN = 1e-6  # share of the variance without correlation from node to node


@dataclass(frozen=True, eq=False)
class CurvePrior:
    """factor (size, r) for unit sizes; block (r,): number of the curve whose size scales a column, -1 for a fixed one."""

    factor: Array
    block: np.ndarray


def gaps(curve: Curve) -> Array:
    """Return the distances (k, k) of the nodes; over a whole turn the chord, so that the curve repeats itself after it (MacKay 1998)."""
    gap = curve.nodes[:, None] - curve.nodes
    return 2 * np.sin(gap / 2) if curve.periodic else gap


def smooth(curve: Curve, length: float) -> Array:
    """Return the squared exponential (k, k)."""
    return np.asarray(np.exp(-((gaps(curve) / length) ** 2) / 2))


def matern(curve: Curve, length: float) -> Array:
    """Return the Matern kernel of order 5/2 (k, k), whose curves have two derivatives only. Rasmussen & Williams eq. 4.17."""
    r = np.sqrt(5.0) * np.abs(gaps(curve)) / length
    return np.asarray((1 + r + r**2 / 3) * np.exp(-r))


def powers(curve: Curve, length: float) -> Array:
    """Return the kernel (k, k) of a polynomial with independent Legendre coefficients; its degree is 1 + travel / length, 2 at least."""
    x = 2 * (curve.nodes - curve.nodes[0]) / curve.travel - 1
    degree = 1 + max(1, round(curve.travel / length))
    basis = np.polynomial.legendre.legvander(x, degree) * np.sqrt(2 * np.arange(degree + 1) + 1)
    return np.asarray(basis @ basis.T)


def independent_nodes(curve: Curve, length: float) -> Array:
    """Return the kernel (k, k) of independent nodes."""
    return np.eye(len(curve.nodes))


KERNELS: Mapping[str, Callable[[Curve, float], Array]] = {
    "spline": smooth,
    "gaussian process": matern,
    "polynomial": powers,
    "table": independent_nodes,
}


@lru_cache(maxsize=2048)
def unit_factor(curve: Curve, length: float) -> Array:
    """Return the factor (g, g) in free coordinates: process of correlation length (mm) without mean or line, of mean variance 1.

    A millionth of the variance is without correlation: it keeps every shape possible and matrices invertible.
    """
    kernel = curve.coordinates @ KERNELS[curve.kind](curve, length) @ curve.coordinates.T
    kernel = kernel / np.trace(kernel) * len(curve.nodes)
    factor = np.linalg.cholesky(kernel + GRAIN * np.eye(len(kernel)))
    factor.setflags(write=False)  # it is handed out again
    return factor


def line_factor(curve: Curve) -> Array:
    """Return the line that a positioning error may have besides, of a scale error of 1 SLOPE, as (k, 0 or 1)."""
    if curve.turns or curve.straightness or curve.reversal or curve.rotary:
        return np.zeros((len(curve.nodes), 0))
    return SLOPE * (curve.projector @ curve.nodes)[:, None]


def prior(model: ErrorModel, lengths: Mapping[str, float]) -> CurvePrior:
    """Return the factor for the lengths (mm) of the curves, by component; columns: smooth curves, then lines and squareness."""
    columns: list[Array] = []
    blocks: list[int] = []
    for number, curve in enumerate(model.curves):
        unit = curve.free @ unit_factor(curve, lengths[curve.component])
        columns.append(_embed(model, curve.component, unit))
        blocks += [number] * unit.shape[1]
        line = line_factor(curve)
        columns.append(_embed(model, curve.component, line))
        blocks += [-1] * line.shape[1]
    for pair, u in zip(model.pairs, widest_pairs(model)):
        columns.append(_embed(model, pair, np.array([[u]])))
        blocks.append(-1)
    return CurvePrior(np.concatenate(columns, axis=1), np.array(blocks))


def _embed(model: ErrorModel, name: str, block: Array) -> Array:
    out = np.zeros((model.size, block.shape[1]))
    out[model.slices[name]] = block
    return out


def widest_pairs(model: ErrorModel) -> Array:
    """Return (pairs,): prior u of squareness and location errors, rad or mm."""
    return FAR_TIMES_USUAL * usual_pairs(model)


def usual(model: ErrorModel) -> Array:
    """Return (curves,): usual size, mm or rad."""
    return np.array([c.usual for c in model.curves])


def scale_factor(prior: CurvePrior, sizes: Array) -> Array:
    """Return the factor with the sizes of the curves, as (size, r)."""
    return np.asarray(prior.factor * column_sizes(prior, sizes))


def column_sizes(prior: CurvePrior, sizes: Array) -> Array:
    return np.append(sizes, 1.0)[prior.block]  # -1 is the last
