"""Uncertainties at many poses at once, in closed form: u^2 = G Sigma G^T with the part of G that moves with the pose.

The alignment is in the part, so that fits and characteristics are the same numbers at every pose: W, how quantities
follow the displacement of each touch along its normal, is made once in the drawing frame. Only the effects, the lever
arms and the normals depend on the pose; they are asked for all rows of all poses in one call.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from vcmm.effect import Effect, projected_basis
from vcmm.errors import ModelLimit
from vcmm.fixture import six_of
from vcmm.influence import Influence, mixed, products, shared, shifted, targets
from vcmm.influence import STEP as CHANNEL_STEP
from vcmm.inputs import Input
from vcmm.kinematics import sensed
from vcmm.laws import MultivariateNormal, MultivariateSamples
from vcmm.linear import LinearModel, build
from vcmm.machine import Machine
from vcmm.placing.rows import Rows
from vcmm.run import Array, Run

AT_ONCE = 12_000  # rows in one call: the working arrays stay in the cache


@dataclass(frozen=True, eq=False)
class Known:
    """An Input ready for use: gain factor of its elements, its variance per draw, and which draw acts on which touch."""

    input: Input
    codes: Any
    copies: int
    effects: tuple[Effect, ...]

    def spread(self, k: int) -> Array:
        """(k, r) or (k,): departure of the k elements per independent unit draw; a vector where it is diagonal."""
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
class Closed:
    """Closed-form propagation for one scenario; `model` is that of a machine without errors at the present pose."""

    rows: Rows
    model: LinearModel
    at: Array | None = None  # a pose (6,) that can be used, where the present one cannot

    @classmethod
    def of(cls, rows: Rows) -> Closed:
        return cls(rows, build(rows.task))

    @cached_property
    def known(self) -> tuple[Known, ...]:
        run, machine = self.rows.placed.run, self.rows.machine
        out = []
        for one in machine.inputs:
            copies, codes = run.copies(one.redraw)
            effects = _readers(machine, one) if one.is_channel else tuple(targets(machine, one))
            out.append(Known(one, codes, len(copies), effects))
        return tuple(out)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the influences, then of the products of two."""
        return tuple(k.input.id for k in self.known)

    def looks(self, six: Array) -> Iterator[Look]:
        """The poses (m, 6) in batches that fit the cache, each with all that the effects say there."""
        size = max(1, AT_ONCE // self.rows.n)
        return (self.look(six[i : i + size]) for i in range(0, len(six), size))

    def look(self, six: Array) -> Look:
        run = self.rows.run(six)
        moved = [(k, self._moved(k, along, len(six))) for k, along in self._along(run)]
        return Look(self, run, len(six), moved, list(self._meetings(run, len(six))))

    def variances(self, six: Array, weights: Array) -> tuple[Array, Array]:
        """Of q = weights (C, n) . displacements at poses (m, 6): per influence (m, C, I), and of products (m, C)."""
        found = [look.variances(weights) for look in self.looks(six)]
        return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])

    def _along(self, run: Run) -> Iterator[tuple[Known, Array]]:
        """Change of every row along its normal per unit of the elements of each Input, (rows, k)."""
        maps: dict[tuple[str, str], Array] = {}
        for known in self.known:
            if known.input.is_channel:
                yield known, self._channel(run, known)
                continue
            total: Any = 0.0
            for effect in known.effects:
                self.rows.machine.asked(effect, run) if effect.required() else None
                seen = self._map(run, effect, maps)
                total = total + projected_basis(effect, known.input.parameter, run, seen)
            yield known, total

    def _map(self, run: Run, effect: Effect, maps: dict[tuple[str, str], Array]) -> Array:
        key = (effect.link, effect.place)
        if key not in maps:
            machine = self.rows.machine
            if effect.link == "reading":
                maps[key] = np.concatenate([run.normal, np.zeros((run.n, 3))], axis=1)
            else:
                maps[key] = -sensed(machine.chain, machine.axes, run, *key, run.normal)
        return self.rows.machine.sign(effect) * maps[key]

    def _channel(self, run: Run, known: Known) -> Array:
        name = known.input.parameter
        step = next((s for ending, s in CHANNEL_STEP.items() if name.endswith(ending)), 1e-3)
        machine = replace(self.rows.machine, effects=known.effects, inputs=())
        high = machine.indication_error(shifted(run, name, np.full(run.n, step)))
        low = machine.indication_error(shifted(run, name, np.full(run.n, -step)))
        return np.einsum("ni,ni->n", (high - low) / (2 * step), run.normal)[:, None]

    def _moved(self, known: Known, along: Array, m: int) -> Array:
        """(m, n, r): displacement of each touch per independent unit draw."""
        spread = known.spread(along.shape[1])
        moved = along * spread if spread.ndim == 1 else along @ spread
        return np.asarray(moved.reshape(m, self.rows.n, -1))

    def _meetings(self, run: Run, m: int) -> Iterator[Array]:
        """(m, n) per pair of draws that meet in a product: displacements times both standard uncertainties."""
        for first, second, machine in self._pairs:
            one, other = self.known[first], self.known[second]
            response = mixed(machine, run, one.input, other.input)
            u = float(np.abs(one.spread(1)).max()) * float(np.abs(other.spread(1)).max())
            along = u * np.einsum("ni,ni->n", response, run.normal).reshape(m, -1)
            for a, b in sorted(set(zip(one.codes.tolist(), other.codes.tolist()))):
                yield np.where((one.codes == a) & (other.codes == b), along, 0.0)

    @cached_property
    def _pairs(self) -> tuple[tuple[int, int, Machine], ...]:
        """Influences that meet in a product, and a machine of the effects in which they meet."""
        run, machine = self.rows.run(self.reference[None]), self.rows.machine
        sizes = [a.shape[1] for _, a in self._along(run)]
        found = [Influence(k.input, np.zeros((1, 3, s)), (), k.codes) for k, s in zip(self.known, sizes)]
        out = []
        for p in products(machine, run, found):
            effects = shared(machine, run, self.known[p.first].input, self.known[p.second].input)
            out.append((p.first, p.second, replace(machine, effects=tuple(effects), inputs=())))
        return tuple(out)

    @cached_property
    def reference(self) -> Array:
        """The pose at which coverage factors and products are looked at."""
        return six_of(self.rows.scenario.pose) if self.at is None else self.at


def _readers(machine: Machine, one: Input) -> tuple[Effect, ...]:
    """Effects that ask for a column."""
    return tuple(e for e in machine.effects if one.parameter in e.required())


@dataclass(frozen=True, eq=False)
class Look:
    """What the effects say at m poses: displacements of every touch per unit draw of every influence."""

    closed: Closed
    run: Run
    m: int
    moved: list[tuple[Known, Array]]
    meetings: list[Array]

    def variances(self, weights: Array) -> tuple[Array, Array]:
        """Of q = weights (C, n) . displacements: per influence (m, C, I), and of products (m, C)."""
        out = []
        for known, moved in self.moved:
            if known.copies == self.closed.rows.n:  # every touch has its own draw
                out.append((moved**2).sum(axis=2) @ (weights**2).T)
            else:
                out.append((self._lanes(known, moved, weights) ** 2).sum(axis=2))
        second = sum(((g @ weights.T) ** 2 for g in self.meetings), np.zeros((self.m, len(weights))))
        return np.stack(out, axis=2), np.asarray(second)

    def covariances(self, weights: Array) -> Array:
        """(m, C, C) of q = weights . displacements, all influences and products together."""
        total = np.zeros((self.m, len(weights), len(weights)))
        for known, moved in self.moved:
            if known.copies == self.closed.rows.n:
                total += (weights * (moved**2).sum(axis=2)[:, None, :]) @ weights.T
            else:
                lanes = self._lanes(known, moved, weights)
                total += lanes @ lanes.swapaxes(1, 2)
        for meeting in self.meetings:
            g = meeting @ weights.T
            total += g[:, :, None] * g[:, None, :]
        return total

    @cached_property
    def systematic(self) -> Array:
        """(m, n): what the known errors of the machine move each touch along its normal, mm."""
        error = self.closed.rows.machine.indication_error(self.run)
        return np.einsum("ni,ni->n", error, self.run.normal).reshape(self.m, -1)

    def _lanes(self, known: Known, moved: Array, weights: Array) -> Array:
        """(m, C, lanes): change of q per independent unit draw."""
        if known.copies == 1:
            return np.asarray(weights @ moved)
        copies = [known.codes == c for c in range(known.copies)]
        return np.concatenate([weights[:, rows] @ moved[:, rows] for rows in copies], axis=2)
