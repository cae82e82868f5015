"""Check the linear model against the exact engine: the same draws through the tangent, the linear model and the exact engine."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.exact import draw_inputs, exact_values, linear_quantities
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.task.measuring.settings import Settings

TANGENT_DRAWS = 200  # for the curvature, even where no exact trials are requested


AT_ONCE, LEAST_DRAWS = 2_000_000, 20  # touches of all trials; of a scan fewer trials say as much


@dataclass(frozen=True, eq=False)
class Check:
    """Per characteristic (C,), mm or rad: largest |tangent - exact| and |linear model - exact| over the trials (inf when
    not checked), and the rms of (linear model - tangent) over the spread of the tangent.
    """

    tangent_error: Array
    linear_error: Array
    curvature: Array


def check(model: LinearModel, gradient: Array, settings: Settings) -> Check:
    """Compare the three on common draws. Raises ModelLimit when a draw leaves the model (a t-law with very small nu)."""
    most = max(LEAST_DRAWS, AT_ONCE // model.task.touches.run.n)
    certify = min(settings.certify, most)
    drawn = draw_inputs(model, settings.seed, 0, min(max(settings.certify, TANGENT_DRAWS), most))
    q = linear_quantities(model, drawn)
    tangent = model.at_estimates + (q - model.q0) @ gradient.T
    try:
        linear = model.values(q)
    except ModelLimit as error:
        raise out_of_range(error) from None
    low, high = np.quantile(tangent, [0.1587, 0.8413], axis=0)
    spread = np.maximum((high - low) / 2, 1e-15)
    curvature = np.sqrt(np.median((linear - tangent) ** 2, axis=0)) / spread
    if certify == 0:
        unknown = np.full(len(spread), np.inf)
        return Check(unknown, unknown, curvature)
    exact = exact_values(model, [d.head(certify) for d in drawn])
    return Check(
        np.abs(tangent[:certify] - exact).max(axis=0),
        np.abs(linear[:certify] - exact).max(axis=0),
        curvature,
    )


def out_of_range(error: ModelLimit) -> ModelLimit:
    """Return the error for draws so large that a fitted element no longer resembles its feature."""
    return ModelLimit(
        f"the draws leave the range of the model ({error}); a t-law with nu < 2 has no useful Monte Carlo for form, "
        "orientation or position: measure more repeats"
    )
