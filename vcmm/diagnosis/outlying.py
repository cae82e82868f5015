"""What the rows owe that were pulled in: outliers are paid for before answers are compared.

Rows beyond `clip` robust standard deviations of a fit are pulled in, so that a few bad readings do not bend it. Done about a fit
that lacks a name this hides the name: a bed that is hot before the first readings are over shows in a dozen rows alone, and
about a frame with two lags all of them are outliers. What is pulled in costs c^2 / 2 nats however far it stood out, so the
evidence about such rows compares different rows. Here every row counts as it is, by Huber's law (normal within c standard
deviations, exponential beyond; Huber, Robust Statistics (1981), 4.5), with the scale of the noise at its best:

    loss = min over s of  dof ln s + sum of rho(r / s),   rho(x) = x^2 / 2 up to c, then c |x| - c^2 / 2
"""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.diagnosis.constants import HEAVY, NOTHING
from vcmm.diagnosis.null import Noise, clipped, draws, upper_quantile
from vcmm.diagnosis.select import Selection, Setting, worth

RECORDINGS = 400  # simulated
HALVINGS = 60  # of an interval of ln s that spans the sizes of the rows


def huber_loss(r: Array, dof: int, clip: float) -> float:
    """Nats, up to a constant of the recording, that white residuals r (m,) cost at the best scale of the noise.

    At the best scale dof = sum of x psi(x), x = r / s, psi(x) = min(|x|, clip) sign x: the sum falls with s, so it is halved.
    Rows that are all zero, which no scale describes, cost -inf.
    """
    size = np.abs(r)
    if not size.any():
        return -np.inf
    high = float(
        np.log(np.sqrt(size @ size / dof))
    )  # psi(x) <= |x|: the scale of least squares is the largest
    low = high - 40.0
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        x = size / np.exp(middle)
        low, high = (middle, high) if float(x @ np.minimum(x, clip)) > dof else (low, middle)
    x = size / np.exp(high)
    inner = np.minimum(x, clip)
    return dof * high + float(np.sum(inner * (x - inner / 2)))


def worth_of_all_rows(state: Selection, setting: Setting) -> float:
    """Nats of all terms together, each having paid the threshold, with every row as it is; up to a constant of the recording."""
    dof = setting.found.dof
    if state.fit is None:
        return -huber_loss(setting.raw, dof, setting.clip)
    signal = np.concatenate([t.white for t in state.terms], axis=1) @ state.fit.mean
    fitted = 0.5 * dof * float(np.log(state.fit.sigma**2 * dof / (state.y @ state.y)))
    return worth(state, setting) + fitted - huber_loss(setting.raw - signal, dof, setting.clip)


def owed(state: Selection, setting: Setting) -> float:
    """Nats by which the rows that were pulled in cost more as they are, at the scale of the noise that the others show."""
    if state.fit is None:
        return _debt(setting.raw, state.y, setting.found.dof, setting.clip)
    signal = np.concatenate([t.white for t in state.terms], axis=1) @ state.fit.mean
    return _debt(setting.raw - signal, state.rest, setting.found.dof, setting.clip)


def excused(setting: Setting) -> float:
    """What noise of heavy tails owes, the t law of HEAVY degrees of freedom: all but 1 % of recordings owe less."""
    dof, clip = setting.found.dof, setting.clip
    sample = draws(Noise(HEAVY), setting.white, 0, "what heavy tails owe", RECORDINGS)
    near = clipped(sample, setting.white, clip)
    return upper_quantile(np.array([_debt(r, y, dof, clip) for r, y in zip(sample.T, near.T)]))


def _debt(r: Array, near: Array, dof: int, clip: float) -> float:
    """clip (|r| / sigma - clip) summed over what lies beyond: r (m,) as it is, near (m,) pulled in, which tells sigma."""
    sigma = max(float(np.sqrt(near @ near / dof)), NOTHING)
    return float(np.sum(clip * np.maximum(np.abs(r) / sigma - clip, 0.0))) if np.isfinite(clip) else 0.0
