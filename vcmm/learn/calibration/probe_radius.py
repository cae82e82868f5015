"""How much larger a touch probe reads all round than stated: ball of the stylus, less its mean pre-travel, with half of a sphere's diameter.

The nuisance `radius` of a touch is one number per label along the outward normal. It is found beside the errors that were identified, the own
errors of the probe and all other nuisance by generalised least squares, so that its u counts what they are not known to:

    [S B, C, N]' W [S B, C, N] + diag(0, 1, 0)      S errors (their free shapes B), C own errors in units of their u, N nuisance

It is + where surfaces were indicated further out of the material than they are. The probe goes on by its pre-travel p after it has met a surface, so
it reads -p; a ball that is larger by d in diameter than stated stops earlier and reads +d/2.
Source: JCGM 102:2011 (generalised least squares).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.calibration.model import ErrorModel
from vcmm.learn.calibration.readings import Readings
from vcmm.learn.calibration.solve import Before, ErrorPosterior, columns_of

NOTHING = 1e-9  # of the largest eigenvalue: what is below is not found


def probe_radii(
    parts: Sequence[Readings], post: ErrorPosterior, identified: Sequence[str]
) -> list[dict[str, object]]:
    """Per recording of touches and copy of its nuisance `radius`: input, value and u in um. Those that nothing parts from the errors are left out."""
    named = [
        (i, k, n) for i, p in enumerate(parts) for k, n in enumerate(p.names) if n.split("[")[0] == "radius"
    ]
    named = [one for one in named if parts[one[0]].recording.kind == "probe"]
    if not named:
        return []
    columns, names = columns_of(parts, Before.nothing(post.model))
    shapes = _shapes(post.model, identified)
    before = shapes.shape[1] + len(names)
    starts = before + np.cumsum([0, *(p.nuisance.shape[1] for p in parts)])
    gram, right = np.zeros((starts[-1], starts[-1])), np.zeros(starts[-1])
    for part, seen, noise, start in zip(parts, columns, post.noise, starts):
        x = np.zeros((part.m, starts[-1]))
        x[:, : shapes.shape[1]] = seen[:, : post.model.size] @ shapes
        x[:, shapes.shape[1] : before] = seen[:, post.model.size :]
        x[:, start : start + part.nuisance.shape[1]] = part.nuisance
        x = x / (noise.u * part.u)[:, None]
        gram += x.T @ x
        right += x.T @ (part.value / (noise.u * part.u))
    gram[shapes.shape[1] : before, shapes.shape[1] : before] += np.eye(len(names))
    found, covariance, known = _solve(gram, right)
    out: list[dict[str, object]] = []
    for i, k, name in named:
        at = starts[i] + k
        if known[at] > 1 - 1e-6:
            u = float(np.sqrt(covariance[at, at]))
            out.append(
                {
                    "input": f"{parts[i].recording.name}: {name}",
                    "value_um": float(found[at]) * 1e3,
                    "u_um": u * 1e3,
                }
            )
    return out


def _shapes(model: ErrorModel, names: Sequence[str]) -> Array:
    """(size, k): free shapes of the curves of these names, and unit columns of their pairs."""
    blocks = []
    for curve in (c for c in model.curves if c.component in names):
        full = np.zeros((model.size, curve.free.shape[1]))
        full[model.slices[curve.component]] = curve.free
        blocks.append(full)
    for pair in (p for p in model.pairs if p in names):
        full = np.zeros((model.size, 1))
        full[model.slices[pair]] = 1.0
        blocks.append(full)
    return np.concatenate(blocks, axis=1) if blocks else np.zeros((model.size, 0))


def _solve(gram: Array, right: Array) -> tuple[Array, Array, Array]:
    """Least squares with columns scaled to unit length: values, covariance, and of each number the share that is determined."""
    size = np.sqrt(np.maximum(np.diag(gram), 1e-300))
    values, ways = np.linalg.eigh(gram / np.outer(size, size))
    kept = values > NOTHING * values[-1]
    half = ways[:, kept] / np.sqrt(values[kept])
    covariance = (half @ half.T) / np.outer(size, size)
    share = (ways[:, kept] ** 2).sum(axis=1)
    return covariance @ right, covariance, share
