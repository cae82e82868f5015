"""What the rows owe that were pulled in: outliers are paid for before answers are compared.

Rows beyond `clip` robust standard deviations of a fit are pulled in, so that a few bad readings do not bend it. Done about a fit
that lacks a name this hides the name: a bed that is hot before the first readings are over shows in a dozen rows alone, and
about a frame with two lags all of them are outliers. Done about a fit that takes every row as it is, it may make one: two bad
readings before the end are a step. What is pulled in costs c^2 / 2 nats however far it stood out, so the evidence about such
rows compares different rows. Here every row counts as it is, by the t law of HEAVY degrees of freedom (the heaviest that is
thought of, in which an outlier costs the logarithm of its size), with the scale of the noise at its best:

    loss = min over s of  dof ln s + dof / m * sum of (h + 1) / 2 ln(1 + (r / s)^2 / (h - 2))

h - 2 in place of h, as s is the standard deviation (Lange, Little & Taylor, J. Am. Stat. Assoc. 84 (1989) 881).

One reading that stands out alone, where a name says much of it and little of the others (the first, of a lag of half a minute), is
a bad reading or that name, and no row tells which: how far it stands out is no evidence. So a name that is found only because
rows are taken as they are has to be worth it without the one row that speaks most for it.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import HEAVY, NOTHING
from vcmm.learn.diagnosis.null import Noise, clip_residuals, draws, upper_quantile
from vcmm.learn.diagnosis.select import Selection, Setting, net_evidence

RECORDINGS = 400  # simulated
SPAN = 40.0  # of ln s that is searched
HALVINGS = 60  # of it


def heavy_loss(r: Array, dof: int) -> float:
    """Nats, up to a constant of the recording, that white residuals r (m,) cost at the best scale of the noise.

    Rows that are all zero, which no scale describes, cost -inf.
    """
    return float(np.sum(heavy_losses(r, dof))) if r.any() else -np.inf


def heavy_losses(r: Array, dof: int) -> Array:
    """The same of every row (m,), not all of them zero.

    At the best scale the mean of (h + 1) x^2 / (h - 2 + x^2) is one, x = r / s: it falls with s, so it is halved.
    """
    square = r**2
    high = float(np.log(square.mean() * (HEAVY + 1) / (HEAVY - 2))) / 2  # the largest: _pull is concave
    low = high - SPAN
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if _pull(square / np.exp(2 * middle)) > 1 else (low, middle)
    far = np.log1p(square / np.exp(2 * high) / (HEAVY - 2))
    return np.asarray(dof / len(r) * (high + (HEAVY + 1) / 2 * far))


def _pull(x: Array) -> float:
    """How much rows of squared size x (m,), in squared scales, widen the scale: one where it is at its best."""
    return float(np.mean((HEAVY + 1) * x / (HEAVY - 2 + x)))


def worth_of_all_rows(state: Selection, setting: Setting) -> float:
    """Nats of all terms together, each having paid the threshold, with every row as it is; up to a constant of the recording."""
    dof = setting.found.dof
    if state.fit is None:
        return -heavy_loss(setting.raw, dof)
    fitted = 0.5 * dof * float(np.log(state.fit.sigma**2 * dof / (state.y @ state.y)))
    return net_evidence(state, setting) + fitted - heavy_loss(_left(state, setting), dof)


def one_row_speaks(state: Selection, setting: Setting, plain: Selection) -> float:
    """Nats of the row that speaks most for an answer and against a plain one, every row as it is."""
    dof = setting.found.dof
    rests = [_left(s, setting) for s in (plain, state)]
    if not all(r.any() for r in rests):
        return 0.0
    before, after = (heavy_losses(r, dof) for r in rests)
    return float(np.max(before - after))


def _left(state: Selection, setting: Setting) -> Array:
    """White rows (m,) less the terms, nothing pulled in."""
    if state.fit is None:
        return setting.raw
    return np.asarray(setting.raw - np.concatenate([t.white for t in state.terms], axis=1) @ state.fit.mean)


def pulled_cost(state: Selection, setting: Setting) -> float:
    """Nats by which the rows that were pulled in cost more as they are, at the scale of the noise that the others show."""
    return _debt(_left(state, setting), state.rest, setting.found.dof, setting.clip)


def heavy_tail_allowance(setting: Setting) -> float:
    """What noise of heavy tails owes, the t law of HEAVY degrees of freedom: all but 1 % of recordings owe less."""
    dof, clip = setting.found.dof, setting.clip
    sample = draws(Noise(HEAVY), setting.white, 0, "what heavy tails owe", RECORDINGS)
    near = clip_residuals(sample, setting.white, clip)
    return upper_quantile(np.array([_debt(r, y, dof, clip) for r, y in zip(sample.T, near.T)]))


def _debt(r: Array, near: Array, dof: int, clip: float) -> float:
    """clip (|r| / sigma - clip) summed over what lies beyond: r (m,) as it is, near (m,) pulled in, which tells sigma."""
    sigma = max(float(np.sqrt(near @ near / dof)), NOTHING)
    return float(np.sum(clip * np.maximum(np.abs(r) / sigma - clip, 0.0))) if np.isfinite(clip) else 0.0
