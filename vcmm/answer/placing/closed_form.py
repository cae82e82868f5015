"""Uncertainties at many poses at once, in closed form: u^2 = G Sigma G^T with the part of G that moves with the pose.

The alignment is in the part, so that fits and characteristics are the same numbers at every pose: W, how quantities
follow the displacement of each touch along its normal, is made once in the drawing frame. Only the effects, the lever
arms and the normals depend on the pose; they are evaluated for all rows of all poses in one call.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.answer.placing.rows import Rows
from vcmm.core.effect import Effect
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.knowledge import acted_on, targets
from vcmm.core.laws import MultivariateNormal, MultivariateSamples
from vcmm.core.run import Array, Run
from vcmm.task.measuring.fixture import six_of
from vcmm.task.measuring.plan import Ints
from vcmm.task.response.carrier import Carrier, Sight
from vcmm.task.response.influence import Influence, products

AT_ONCE = 12_000  # rows in one call: the working arrays stay in the cache


@dataclass(frozen=True, eq=False)
class KnownInput:
    """An Input ready for use: gain factor of its elements, its variance per draw, and which draw acts on which touch."""

    input: Input
    codes: Any
    copies: int
    effects: tuple[Effect, ...]

    def spread(self, k: int) -> Array:
        """Return the departure of the k elements per independent unit draw, (k, r) or (k,); a vector where it is diagonal."""
        if k not in self._spreads:
            self._spreads[k] = self._spread(k)
        return self._spreads[k]

    @cached_property
    def _spreads(self) -> dict[int, Array]:
        return {}

    def _spread(self, k: int) -> Array:
        law, factor = self.input.spread(k)
        if isinstance(law, MultivariateSamples):
            return MultivariateNormal(law.covariance).factor
        u = float(np.ravel(law.u)[0])
        if not np.isfinite(u):
            raise ModelLimit(
                f"{self.input.id} has no variance (a t-law with nu <= 2): poses cannot be compared by u; measure more repeats"
            )
        diagonal = factor.shape[0] == factor.shape[1] and not (factor - np.diag(np.diag(factor))).any()
        return u * (np.diag(factor) if diagonal else factor)


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """Closed-form propagation for one scenario; `model` is that of a machine without errors at the present pose."""

    rows: Rows
    model: LinearModel
    at: Array | None = None  # a pose (6,) that can be used, where the present one cannot

    @classmethod
    def of(cls, rows: Rows) -> ClosedForm:
        return cls(rows, build(rows.task))

    @cached_property
    def known_inputs(self) -> tuple[KnownInput, ...]:
        run, machine = self.rows.still, self.rows.machine
        out = []
        for quantity in machine.inputs:
            copies, codes = run.copies(quantity.redraw)
            single = quantity.is_channel or quantity.members
            effects = acted_on(machine, quantity) if single else tuple(targets(machine, quantity))
            out.append(KnownInput(quantity, codes, len(copies), effects))
        return tuple(out)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the influences, then of the products of two."""
        return tuple(k.input.id for k in self.known_inputs)

    def batches(self, six: Array) -> Iterator[AtPoses]:
        """Yield the poses (m, 6) in batches that fit the cache, each with the responses of all effects there."""
        size = max(1, AT_ONCE // self.rows.n)
        return (self.at_poses(six[i : i + size]) for i in range(0, len(six), size))

    def at_poses(self, six: Array) -> AtPoses:
        run = self.rows.run(six)
        touches = self._carrier(run)
        moved = [(k, self._displacements(k, along, len(six))) for k, along in self._along(touches)]
        return AtPoses(self, touches, len(six), moved, list(self._product_moves(touches, len(six))))

    def _carrier(self, run: Run) -> Carrier:
        """Return the carrier of indicated - true along the normal of every touch."""
        return Carrier(self.rows.machine, run, Sight(run.normal))

    def only(self, touches: Ints) -> ClosedForm:
        """Return the same for some of the touches: those that no characteristic of interest reads are left out."""
        return replace(self, rows=self.rows.only(touches))

    @property
    def operator(self) -> Array:
        """Quantities per displacement of the touches in use (K, n)."""
        kept = self.rows.subset
        return self.model.operator if kept is None else self.model.operator[:, kept]

    def variances(self, six: Array, weights: Array) -> tuple[Array, Array]:
        """Return the variances of q = weights (C, n) . displacements at poses (m, 6): per influence (m, C, I), and of products (m, C)."""
        parts = [batch.variances(weights) for batch in self.batches(six)]
        return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])

    def _along(self, touches: Carrier) -> Iterator[tuple[KnownInput, Array]]:
        """Change of every row along its normal per unit of the elements of each Input, (rows, k)."""
        for known_input in self.known_inputs:
            yield known_input, touches.of_input(known_input.input, known_input.effects)

    def along(self, six: Array) -> list[tuple[KnownInput, Array]]:
        """Return `_along` at some poses (m, 6): (m n, k) per Input."""
        return list(self._along(self._carrier(self.rows.run(six))))

    def _displacements(self, known_input: KnownInput, along: Array, m: int) -> Array:
        """Return the displacement of each touch per independent unit draw, (m, n, r)."""
        spread = known_input.spread(along.shape[1])
        moved = along * spread if spread.ndim == 1 else along @ spread
        return np.asarray(moved.reshape(m, self.rows.n, -1))

    def _product_moves(self, touches: Carrier, m: int) -> Iterator[Array]:
        """Yield, per pair of draws that meet in a product, displacements times both standard uncertainties (m, n)."""
        for first, second in self._pairs:
            first_input, other = self.known_inputs[first], self.known_inputs[second]
            u = float(np.abs(first_input.spread(1)).max()) * float(np.abs(other.spread(1)).max())
            along = u * touches.product(first_input.input, other.input).reshape(m, -1)
            for a, b in sorted(set(zip(first_input.codes.tolist(), other.codes.tolist()))):
                yield np.where((first_input.codes == a) & (other.codes == b), along, 0.0)

    @cached_property
    def _pairs(self) -> tuple[tuple[int, int], ...]:
        """Pairs of influences that meet in a product."""
        run, machine = self.rows.run(self.reference[None]), self.rows.machine
        sizes = [a.shape[1] for _, a in self.along(self.reference[None])]
        influences = [
            Influence(k.input, np.zeros((1, 3, s)), (), k.codes) for k, s in zip(self.known_inputs, sizes)
        ]
        return tuple((p.first, p.second) for p in products(machine, run, influences))

    @cached_property
    def reference(self) -> Array:
        """Pose at which coverage factors and products are evaluated."""
        return six_of(self.rows.scenario.pose) if self.at is None else self.at


@dataclass(frozen=True, eq=False)
class AtPoses:
    """Responses of the effects at m poses: displacements of every touch per unit draw of every influence."""

    closed: ClosedForm
    touches: Carrier
    m: int
    input_moves: list[tuple[KnownInput, Array]]
    product_moves: list[Array]

    def variances(self, weights: Array) -> tuple[Array, Array]:
        """Return the variances of q = weights (C, n) . displacements: per influence (m, C, I), and of products (m, C)."""
        out = []
        for known_input, moved in self.input_moves:
            if known_input.copies == self.closed.rows.n:  # every touch has its own draw
                out.append((moved**2).sum(axis=2) @ (weights**2).T)
            else:
                out.append((self._lanes(known_input, moved, weights) ** 2).sum(axis=2))
        second = sum(((g @ weights.T) ** 2 for g in self.product_moves), np.zeros((self.m, len(weights))))
        return np.stack(out, axis=2), np.asarray(second)

    def covariances(self, weights: Array) -> Array:
        """Return the covariances (m, C, C) of q = weights . displacements, all influences and products together."""
        total = np.zeros((self.m, len(weights), len(weights)))
        for known_input, moved in self.input_moves:
            if known_input.copies == self.closed.rows.n:
                total += (weights * (moved**2).sum(axis=2)[:, None, :]) @ weights.T
            else:
                lanes = self._lanes(known_input, moved, weights)
                total += lanes @ lanes.swapaxes(1, 2)
        for moves in self.product_moves:
            g = moves @ weights.T
            total += g[:, :, None] * g[:, None, :]
        return total

    @cached_property
    def systematic(self) -> Array:
        """Displacement of each touch along its normal by the known errors of the machine, (m, n) mm."""
        run, total = self.touches.run, np.zeros(self.touches.run.n)
        for effect in self.touches.machine.effects:
            total += self.touches.through(effect, effect.error_motion(run))
        return total.reshape(self.m, -1)

    def _lanes(self, known_input: KnownInput, moved: Array, weights: Array) -> Array:
        """Return the change of q per independent unit draw, (m, C, lanes)."""
        if known_input.copies == 1:
            return np.asarray(weights @ moved)
        copies = [known_input.codes == c for c in range(known_input.copies)]
        return np.concatenate([weights[:, rows] @ moved[:, rows] for rows in copies], axis=2)
