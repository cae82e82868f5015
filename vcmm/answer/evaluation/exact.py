"""The exact engine: trials with multiplied transforms, contact computed on the nominal surface, iterated fits.

Used to certify the linear model on the very same draws, and as an engine of its own for small numbers of trials.
"""

from __future__ import annotations

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.streams import copy_code, draw
from vcmm.core.run import Array
from vcmm.task.measuring.task import evaluate_all, fit_features, measured_points
from vcmm.task.response.trials import Draws

AT_ONCE = 200_000  # touches of all trials that are held at once


def draw_inputs(model: LinearModel, seed: int, first: int, count: int) -> list[Draws]:
    """Return the same numbers that the Monte Carlo tiers draw for trials first .. first + count - 1."""
    out = []
    for influence in model.influences:
        law, factor = influence.input.spread(influence.response.shape[2])
        r = factor.shape[1]
        lanes = [(k, copy_code(c)) for c in influence.copies for k in range(r)]
        raw = draw(seed, influence.input.id, np.array(lanes, dtype=np.uint32), law, first, count)
        raw = raw.reshape(count, len(influence.copies), r)
        out.append(Draws(influence, raw, _spread(raw, factor)))
    return out


def _spread(raw: Array, factor: Array) -> Array:
    """Return raw (m, copies, r) times the factor (k, r), which is diagonal for Inputs whose elements are independent."""
    if factor.shape[0] == factor.shape[1] and not (factor - np.diag(np.diag(factor))).any():
        return np.asarray(raw * np.diag(factor))
    return np.asarray(raw @ factor.T)


def linear_quantities(model: LinearModel, drawn: list[Draws]) -> Array:
    """Return q (m, K) of the linear model for given draws, products included."""
    q = np.broadcast_to(model.q0, (len(drawn[0].raw), len(model.q0))).copy() if drawn else model.q0[None]
    for draws in drawn:
        along = model.along_normal(draws.influence)
        codes = draws.influence.codes
        q += np.einsum("mnk,nk->mn", draws.departures[:, codes], along) @ model.operator.T
    for product in model.products:
        first, second = (drawn[i].departures[:, :, 0] for i in (product.first, product.second))
        for one_copy, other_copy, gain in model.product_gains(product):
            q += (first[:, one_copy] * second[:, other_copy])[:, None] * gain
    return np.asarray(q)


def exact_values(model: LinearModel, drawn: list[Draws]) -> Array:
    """Return characteristics (m, C) with transforms multiplied, contact computed and fits iterated."""
    if not drawn:
        return _exact(model, drawn)
    count = len(drawn[0].raw)
    size = max(1, AT_ONCE // model.task.touches.run.n)
    parts = [_exact(model, [d.part(i, i + size) for d in drawn]) for i in range(0, count, size)]
    return np.concatenate(parts)


def _exact(model: LinearModel, drawn: list[Draws]) -> Array:
    points = measured_points(model.task, model.world.exact_errors(drawn))
    return evaluate_all(model.task, fit_features(model.task, points))
