"""Spread of extreme values (form, orientation, location) at many poses: an approximation for the search.

Such a value has no gradient where the part is perfect. The inputs are taken as normal with the closed-form covariance
of the fitted elements, and the characteristic is evaluated on the same few draws at every pose (common random numbers,
in pairs of opposite sign). Mean and standard deviation over the draws are smooth in the pose. `vcmm.answer.placing.confirmation`
checks the outcome with the full Monte Carlo.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.answer.placing.closed_form import AtPoses, ClosedForm
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.part.alignment import align
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import Characteristic

PAIRS = 64  # pairs of draws at least, the same at every pose
JITTER = 1e-10


@dataclass(frozen=True, eq=False)
class ExtremeValues:
    """Mean and standard deviation of the characteristics that are extreme values."""

    closed: ClosedForm
    characteristics: tuple[Characteristic, ...]

    @cached_property
    def quantities(self) -> Array:
        """Numbers (r,) of the quantities q that these characteristics read."""
        blocks, scheme = self.closed.model.blocks, self.closed.rows.scenario.plan.alignment
        names = {n for c in self.characteristics for n in gps.needs(c)}
        if scheme is not None and any(c.type == "position" for c in self.characteristics):
            names = set(blocks)
        spans = [np.arange(b.start, b.stop) for name, b in blocks.items() if name in names]
        return np.concatenate(spans)

    @cached_property
    def draws(self) -> Array:
        """Standard normals (S, r) in pairs of opposite sign, the same for every pose.

        Their second moments are made exactly those of the law, so that linear quantities have no sampling error.
        """
        r = len(self.quantities)
        half = np.random.default_rng(20140425).standard_normal((max(PAIRS, 2 * r), r))
        half = np.linalg.solve(np.linalg.cholesky(half.T @ half / len(half)), half.T).T
        return np.concatenate([half, -half])

    @cached_property
    def perfect(self) -> Array:
        """Values on a machine without errors (C,); the known form of the part is in them."""
        return self._values(self.closed.model.q0[None, None])[0, 0]

    def moments(self, batch: AtPoses) -> tuple[Array, Array]:
        """Return the mean less the value on a perfect machine, and standard deviation, (m, C) mm each."""
        model, which = self.closed.model, self.quantities
        factors = _factors(batch.covariances(self.closed.operator[which]))
        middle = model.q0 + batch.systematic @ self.closed.operator.T
        mean, u = (
            np.empty((batch.m, len(self.characteristics))),
            np.empty((batch.m, len(self.characteristics))),
        )
        for i in range(0, batch.m, 50):
            s = slice(i, i + 50)
            q = np.repeat(middle[s, None, :], len(self.draws), axis=1)
            q[:, :, which] += self.draws @ factors[s].swapaxes(1, 2)
            values = self._values(q)
            mean[s], u[s] = values.mean(axis=1) - self.perfect, values.std(axis=1)
        return mean, u

    def _values(self, q: Array) -> Array:
        """Evaluate quantities (m, S, K): values (m, S, C)."""
        task, fitted = self.closed.model.task, self.closed.model.unpack(q)
        features, scheme = task.part.features, task.plan.alignment
        pose = None
        if scheme is not None and any(c.type == "position" for c in self.characteristics):
            pose = align(scheme, features, fitted, Pose.identity())
        return np.stack([gps.evaluate(c, features, fitted, pose) for c in self.characteristics], axis=-1)


def _factors(covariance: Array) -> Array:
    """Lower triangular factors (m, r, r) of positive semidefinite matrices.

    Rows differ in size by orders of magnitude (mm, unit vectors): correlations are factored, with a jitter that keeps
    singular ones factorable.
    """
    u = np.sqrt(np.maximum(np.einsum("mii->mi", covariance), 1e-300))
    correlation = covariance / (u[:, :, None] * u[:, None, :])
    r = covariance.shape[1]
    return np.asarray(u[:, :, None] * np.linalg.cholesky(correlation + JITTER * np.eye(r)))
