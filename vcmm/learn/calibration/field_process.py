"""Estimate the process of a residual field from readings at nodes: length scales and amplitudes by likelihood, correlation of X, Y, Z.

Deviations y_i of direction i at the nodes are taken as y_i ~ N(0, a_i^2 K(lengths) + diag(u_i^2)), K as in `core.residual_process`, u their standard
uncertainty. The likelihood is weighed over a grid, even in ln length and ln amplitude; the lengths are common to x, y and z errors.
Source: Rasmussen & Williams, Gaussian Processes (2006), eq. 5.8, averaged (section 5.2) in place of maximised.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.residual_process import FieldProcess, correlation_of
from vcmm.core.run import Array
from vcmm.learn.calibration.nodes import NodeScatter

COARSE, FINER, AMPLITUDES = 5, 7, 16  # points of a grid along x, y, z; of the sizes
MOST_NODES = 240  # nodes of a field with those filled in
FINE = 0.8  # lengths between nodes that are filled in: half way between them nine tenths of the variance is theirs


@dataclass(frozen=True, eq=False)
class ProcessFit:
    """lengths, amplitude (3,) mm, their central 95 % (2, 3); correlation (3, 3) of X, Y, Z of one approach, its u (3, 3).

    trial_range (2,) mm: shortest and longest length of the grid; an end of a range that lies there is a bound of the trial and no observation.
    """

    lengths: Array
    lengths_range: Array
    amplitude: Array
    amplitude_range: Array
    correlation: Array
    correlation_u: Array
    trial_range: tuple[float, float]


def fit_process(scatter: NodeScatter) -> ProcessFit:
    """Fit the process to the nodes."""
    extent = np.ptp(scatter.place, axis=0)
    apart = np.linalg.norm(scatter.place[:, None] - scatter.place, axis=2)
    np.fill_diagonal(apart, np.inf)
    near = float(np.median(apart.min(axis=1)))
    tried = near / 2, 2 * float(extent.max())
    sizes = [
        np.geomspace(0.1 * np.sqrt((u**2).mean()), 3 * max(np.sqrt((y**2).mean()), np.sqrt((u**2).mean())), AMPLITUDES)
        for y, u in zip(scatter.deviation.T, scatter.deviation_u.T)
    ]  # fmt: skip
    low, high = np.log(tried)
    grids = [np.linspace(low, high, COARSE)] * 3
    weights = _length_weights(scatter, grids, sizes)
    grids = [_around(g, w, np.log(tried)) for g, w in zip(grids, weights)]
    weights = _length_weights(scatter, grids, sizes)
    lengths = np.exp([w @ g for g, w in zip(grids, weights)])
    ends = np.exp(np.array([_ends(g, w) for g, w in zip(grids, weights)]).T)
    here = np.exp((logs := np.array(_likelihood(scatter, lengths, sizes))) - logs.max(axis=1, keepdims=True))
    here /= here.sum(axis=1, keepdims=True)
    amplitude = np.array([np.sqrt(w @ s**2) for w, s in zip(here, sizes)])
    spread = np.exp(np.array([_ends(np.log(s), w) for w, s in zip(here, sizes)]).T)
    return ProcessFit(lengths, ends, amplitude, spread, *_correlation(scatter), tried)


def _likelihood(scatter: NodeScatter, lengths: Array, sizes: list[Array]) -> Array:
    """Return ln likelihood of each amplitude of each direction, as (3, sizes). Whitened by u, all amplitudes share one set of eigenvectors."""
    correlation = correlation_of(scatter.place, scatter.place, lengths)
    out = np.zeros((3, AMPLITUDES))
    for i in range(3):
        u = scatter.deviation_u[:, i]
        values, vectors = np.linalg.eigh(correlation / np.outer(u, u))
        square = (vectors.T @ (scatter.deviation[:, i] / u)) ** 2
        variance = 1 + sizes[i][:, None] ** 2 * np.maximum(values, 0.0)
        out[i] = -0.5 * (np.log(variance) + square / variance).sum(axis=1)
    return out


def _length_weights(scatter: NodeScatter, grids: list[Array], sizes: list[Array]) -> list[Array]:
    """Return the weight of each ln length along x, y, z, the other two and the amplitudes summed over."""
    mesh = np.array(np.meshgrid(*grids, indexing="ij"))
    triples = np.exp(mesh.reshape(3, -1).T)
    ln = np.array([_likelihood(scatter, lengths, sizes) for lengths in triples])  # (triples, 3, sizes)
    whole = np.log(np.exp(ln - ln.max(axis=2, keepdims=True)).sum(axis=2)) + ln.max(axis=2)
    weight = np.exp((total := whole.sum(axis=1)) - total.max()).reshape(mesh.shape[1:])
    weight /= weight.sum()
    return [weight.sum(axis=tuple(k for k in range(3) if k != i)) for i in range(3)]


def _around(grid: Array, weight: Array, ends: Array) -> Array:
    """Return a finer grid over the range of the weights, three and a half of their standard deviations, within the ends."""
    mean = float(weight @ grid)
    spread = np.sqrt(weight @ (grid - mean) ** 2 + (grid[1] - grid[0]) ** 2 / 12)
    low, high = max(mean - 3.5 * spread, ends[0]), min(mean + 3.5 * spread, ends[1])
    return np.linspace(low, high, FINER)


def _ends(grid: Array, weight: Array) -> tuple[float, float]:
    """Return the central 95 % of an even grid, each weight spread over its cell; within the grid."""
    half = (grid[1] - grid[0]) / 2
    edges = np.concatenate([[grid[0] - half], grid + half])
    total = np.concatenate([[0.0], np.cumsum(weight)])
    low, high = np.interp([0.025, 0.975], total, edges)
    return float(max(low, grid[0])), float(min(high, grid[-1]))


def _correlation(scatter: NodeScatter) -> tuple[Array, Array]:
    """Return the correlation (3, 3) of X, Y, Z over all approaches, each less its node's mean and by its node's d; (1 - r^2) / sqrt(dof) is its u."""
    unit = scatter.at / np.maximum(scatter.d, 1e-300)[:, None]
    rows = unit[~np.isnan(unit).any(axis=2)]
    second = rows.T @ rows
    size = np.sqrt(np.diag(second))
    r = second / np.outer(size, size)
    np.fill_diagonal(r, 1.0)
    return r, (1 - r**2) / np.sqrt(scatter.dof.sum())


def support(place: Array, lengths: Array) -> Array:
    """Return the nodes and those that are filled in between them, FINE lengths apart, or as many as MOST_NODES allows, within the hull, (m, 3) mm."""
    from scipy.spatial import Delaunay

    mesh, low, high = Delaunay(place), place.min(axis=0), place.max(axis=0)
    share = FINE
    while True:
        count = np.maximum(np.ceil((high - low) / (share * lengths)).astype(int) + 1, 2)
        if int(np.prod(count)) <= 20 * MOST_NODES:
            axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, count)]
            grid = np.array(np.meshgrid(*axes, indexing="ij")).reshape(3, -1).T
            grid = grid[mesh.find_simplex(grid, tol=1e-9) >= 0]
            far = (((grid[:, None] - place) / lengths) ** 2).sum(axis=2).min(axis=1) > (share / 2) ** 2
            if len(place) + int(far.sum()) <= max(MOST_NODES, len(place)):
                return np.vstack([place, grid[far]])
        if (count == 2).all() and share > 1e6:
            return place
        share *= 1.1


def field_process(nodes_read: NodeScatter, fit: ProcessFit, scatter: Array) -> FieldProcess:
    """Return the process with its nodes, for the file. scatter (K, 3) mm: s of one approach at the nodes that were read."""
    nodes = support(nodes_read.place, fit.lengths)
    return FieldProcess(nodes, scatter, nodes_read.deviation_u, fit.lengths, fit.amplitude, fit.correlation)
