"""Reduce a linear model to some of its characteristics: no touch, feature or draw that they do not need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel
from vcmm.core.run import Array
from vcmm.task.measuring.plan import Ints, Touches
from vcmm.task.response.influence import Influence

EXACT = 1e-9  # mm per mm


def needed_rows(model: LinearModel) -> Ints:
    """Return the numbers of the touches (n,) of the features that a model still has, in their order."""
    rows = model.task.touches.rows
    return np.sort(np.concatenate([rows[n] for n in rows if n in model.blocks or n in _pointwise(model)]))


def narrow_model(
    model: LinearModel, numbers: Sequence[int], aligned: bool = False
) -> tuple[LinearModel, Ints]:
    """Return the model of characteristics number `numbers` alone, and the touches that it keeps. q keeps its places. aligned: see `only`."""
    few = model.only(numbers, aligned)
    kept = needed_rows(few)
    task = replace(few.task, touches=_touches(few.task.touches, kept), form=few.task.form[kept])
    return (
        replace(
            few, task=task, operator=few.operator[:, kept], points=few.points[kept],
            influences=tuple(_influence(f, kept) for f in few.influences),
            products=tuple(replace(p, response=p.response[kept]) for p in few.products),
        ),
        kept,
    )  # fmt: skip


def displace(model: LinearModel, displacements: Array) -> Array:
    """Return q (m, K) after displacements (m, n) of the touches along their normals, feature by feature."""
    out = np.zeros((len(displacements), len(model.q0)))
    for name, block in model.blocks.items():
        out[:, block.start : block.stop] = model.q0[block.start : block.stop]
        rows = model.task.touches.rows[name]
        ends = block.start, block.start + 6 + block.sizes, block.at_touches, block.stop
        element, residuals, touches = (slice(a, b) for a, b in pairwise(ends))
        mine = displacements[:, rows]
        fit = mine @ model.operator[element, rows].T
        out[:, element] += fit
        if name not in model.taken_up:
            model.taken_up[name] = _taken_up(model.operator[element, rows], model.operator[residuals, rows])
        taken = model.taken_up[name]
        left = (
            mine @ model.operator[residuals, rows].T
            if taken is None
            else mine[:, : len(taken)] - fit @ taken.T
        )
        out[:, residuals] += left
        out[:, touches] += mine[:, : block.touches]
    return out


def _taken_up(element: Array, residuals: Array) -> Array | None:
    """Return the displacements of its n touches that an element takes up, by its k quantities (n, k); computed once for all trials.

    Residuals are displacements less that, which has few freedoms: n times cheaper than the operator (n, n) itself. None where touches
    did not approach along normals, and the operator serves.
    """
    if not len(residuals):
        return np.zeros((0, len(element)))
    taken = (np.eye(len(residuals)) - residuals) @ np.linalg.pinv(element)
    errs = np.abs(np.eye(len(residuals)) - taken @ element - residuals).max() > EXACT
    return None if errs else np.asarray(taken)


def _pointwise(model: LinearModel) -> set[str]:
    """Return the features without an element, whose points are read."""
    return {n for c in model.characteristics for n in c.features}


def _touches(t: Touches, kept: Ints) -> Touches:
    place = {int(row): i for i, row in enumerate(kept)}
    rows = {n: np.array([place[int(i)] for i in r]) for n, r in t.rows.items() if int(r[0]) in place}
    return replace(
        t, run=t.run.take(kept), points=t.points[kept], normals=t.normals[kept], approach=t.approach[kept],
        tip_radius=t.tip_radius[kept], rows=rows,
    )  # fmt: skip


def _influence(f: Influence, kept: Ints) -> Influence:
    acting, codes = np.unique(f.codes[kept], return_inverse=True)
    return replace(f, response=f.response[kept], copies=tuple(f.copies[i] for i in acting), codes=codes)
