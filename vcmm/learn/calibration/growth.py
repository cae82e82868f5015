"""Growth of errors since their calibration: a random walk of smooth curves, the state growth of a chain of calibrations.

    theta(now) = theta(then) + growth      growth: a smooth process of the stated u, independent from error to error

Variances add, so that g per month is g sqrt(t) after t months (Kalman, J. Basic Eng. 82 (1960) 35, with the identity as transition).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.calibration.checks import log_likelihood
from vcmm.learn.calibration.evidence import SPAN, append_identity
from vcmm.learn.calibration.model import ErrorModel
from vcmm.learn.calibration.prior import unit_factor
from vcmm.learn.calibration.prior_knowledge import PriorKnowledge
from vcmm.learn.calibration.readings import Readings
from vcmm.learn.calibration.solve import project

METRE = 1e3  # mm: rotations and angles change by the growth over this length
CHANCE = 1e-4  # of readings so far from the machine file


def growth_factor(model: ErrorModel, names: Sequence[str], growth: float) -> Array:
    """Return the factor of the covariance of the growth of the named errors, as (size, r); growth mm, its root mean square over the travel.

    A positioning error also grows by a line, of the same root mean square.
    """
    blocks = []
    for curve in (c for c in model.curves if c.component in names):
        size = growth / METRE if curve.turns else growth
        parts = [curve.free @ unit_factor(curve, SPAN * curve.travel)]
        if not curve.turns and not curve.straightness and not curve.reversal and not curve.rotary:
            away = curve.projector @ curve.nodes
            parts = [parts[0] / np.sqrt(2), away[:, None] / np.sqrt(2 * (away**2).mean())]
        blocks.append((model.slices[curve.component], size * np.concatenate(parts, axis=1)))
    for pair in (p for p in model.pairs if p in names):
        size = growth if pair[0] in "XYZ" else growth / METRE
        blocks.append((model.slices[pair], np.array([[size]])))
    out = np.zeros((model.size, sum(b.shape[1] for _, b in blocks)))
    at = 0
    for rows, block in blocks:
        out[rows, at : at + block.shape[1]] = block
        at += block.shape[1]
    return out


def growth_remarks(
    growth: float, parts: Sequence[Readings], model: ErrorModel, prior: PriorKnowledge
) -> list[str]:
    """Return remarks on the assumptions, and on readings that are further from the machine file than its uncertainty and the growth allow."""
    from scipy.special import chdtrc

    out = [
        f"every error of the machine file may have changed by u = {growth * 1e3:.3g} um ({growth / METRE * 1e6:.3g} urad) since; errors that no "
        "reading tells keep their value with that much more uncertainty"
    ]
    factor = np.concatenate([prior.factor, growth_factor(model, prior.names, growth)], axis=1)
    for part in parts:
        own_columns = [c for _, c in part.instrument_errors]
        white = project(part, np.concatenate([part.errors, *own_columns], axis=1), 1.0 / part.u**2)
        whole = append_identity(factor, white.columns.shape[1])
        _, misfit = log_likelihood(white, np.zeros(len(whole)), whole, 1.0)
        left = part.m - white.rank
        if part.stated and left > 0 and chdtrc(left, misfit) < CHANCE:
            out.append(
                f"{part.recording.name}: the readings lie {np.sqrt(misfit / left):.2g} times further from what the machine file says than its "
                "uncertainty, the stated growth and the noise allow: state more growth, or look for what happened"
            )
    return out
