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
from vcmm.diagnosis.select import Selection, Setting, worth

HALVINGS = 60  # of an interval of ln s that spans the sizes of the rows


def huber_loss(r: Array, dof: int, clip: float) -> float:
    """Nats, up to a constant of the recording, that white residuals r (m,) cost at the best scale of the noise.

    At the best scale dof = sum of x psi(x), x = r / s, psi(x) = min(|x|, clip) sign x: the sum falls with s, so it is halved.
    Rows that are all zero, which no scale describes, cost -inf.
    """
    size = np.abs(r)
    if not size.any():
        return -np.inf
    high = float(np.log(np.sqrt(size @ size / dof)))  # psi(x) <= |x|: the scale of least squares is the largest
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
    sigma = state.fit.sigma if state.fit else float(np.sqrt(state.y @ state.y / setting.found.dof))
    signal = np.concatenate([t.white for t in state.terms], axis=1) @ state.fit.mean if state.fit else 0.0
    beyond = np.maximum(np.abs(setting.raw - signal) / sigma - setting.clip, 0.0)
    return float(setting.clip * np.sum(beyond)) if np.isfinite(setting.clip) else 0.0
