"""What nodes leave of a curve between them, where a spline runs through them and the curve need not.

Readings at just the nodes would not tell, but means and lines over the travel, and whoever uses the file between the nodes, do. A band
u that says nothing of a departure r u is too narrow by sqrt(1 + r^2).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.learn.calibration.model import Curve, ErrorModel
from vcmm.learn.calibration.prior import unit_factor
from vcmm.learn.calibration.solve import ErrorPosterior


def left_between(post: ErrorPosterior, coarse: ErrorModel) -> float:
    """What a spline through fewer nodes leaves of the curves, root mean square as expected by the posterior, over their u at the nodes
    left out: the largest of all curves.
    """
    out = 0.0
    for fine, few in zip(post.model.curves, coarse.curves):
        here = post.model.slices[fine.component]
        left, between = _departures(fine, few)
        covariance = post.covariance[here, here]
        missed = float(((left @ post.theta[here]) ** 2).sum() + (left @ covariance * left).sum())
        out = max(out, missed / float(np.diag(covariance)[between].sum()))
    return float(np.sqrt(out))


def expected_between(post: ErrorPosterior) -> float:
    """The same of twice as many nodes and these, before a fit: for processes of the most probable size and length, over the u here."""
    out = 0.0
    for few, size in zip(post.model.curves, post.smooth.sizes):
        fine = replace(few, nodes=np.linspace(few.nodes[0], few.nodes[-1], 2 * len(few.nodes) - 1))
        left, _ = _departures(fine, few)
        rough = left @ fine.free @ unit_factor(fine, post.smooth.lengths[few.component]) * size
        here = post.model.slices[few.component]
        out = max(out, float((rough**2).sum(axis=1).mean() / np.diag(post.covariance)[here].mean()))
    return float(np.sqrt(out))


def _departures(fine: Curve, few: Curve) -> tuple[Array, npt.NDArray[np.bool_]]:
    """(m, k): a curve by its k nodes to what a spline through few of them leaves at the m others, and which these are (k,) bool."""
    between = ~np.isin(fine.nodes, few.nodes)
    left = np.eye(len(fine.nodes))
    left[:, ~between] -= few.weights(fine.nodes)
    return left[between], between
