"""Uncertainties at many poses at once, in closed form: u^2 = G Sigma G^T with the part of G that moves with the pose.

The alignment is in the part, so that fits and characteristics are the same numbers at every pose: W, how quantities
follow the displacement of each touch along its normal, is made once in the drawing frame. Only the effects, the lever
arms and the normals depend on the pose; they are asked for all rows of all poses in one call.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from vcmm.core.effect import Effect, parameter, projected_basis, with_parameter
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.kinematics import link_frames, sensed
from vcmm.core.laws import MultivariateNormal, MultivariateSamples
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.evaluation.linear import LinearModel, build
from vcmm.measuring.fixture import six_of
from vcmm.measuring.plan import Ints
from vcmm.placing.rows import Rows
from vcmm.response.influence import STEP as CHANNEL_STEP
from vcmm.response.influence import Influence, products, shared, shifted, targets

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
        run, machine = self.rows.still, self.rows.machine
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
        seen = Seen(self.rows.machine, run)
        moved = [(k, self._moved(k, along, len(six))) for k, along in self._along(seen)]
        return Look(self, run, len(six), moved, list(self._meetings(seen, len(six))))

    def only(self, touches: Ints) -> Closed:
        """The same for some of the touches: those that no characteristic of interest reads are left out."""
        return replace(self, rows=self.rows.only(touches))

    @property
    def operator(self) -> Array:
        """(K, n): quantities per displacement of the touches that are looked at."""
        kept = self.rows.kept
        return self.model.operator if kept is None else self.model.operator[:, kept]

    def variances(self, six: Array, weights: Array) -> tuple[Array, Array]:
        """Of q = weights (C, n) . displacements at poses (m, 6): per influence (m, C, I), and of products (m, C)."""
        found = [look.variances(weights) for look in self.looks(six)]
        return np.concatenate([f[0] for f in found]), np.concatenate([f[1] for f in found])

    def _along(self, seen: Seen) -> Iterator[tuple[Known, Array]]:
        """Change of every row along its normal per unit of the elements of each Input, (rows, k)."""
        for known in self.known:
            yield known, seen.channel(known) if known.input.is_channel else seen.parameter(known)

    def along(self, six: Array) -> list[tuple[Known, Array]]:
        """`_along` at some poses (m, 6): (m n, k) per Input."""
        return list(self._along(Seen(self.rows.machine, self.rows.run(six))))

    def _moved(self, known: Known, along: Array, m: int) -> Array:
        """(m, n, r): displacement of each touch per independent unit draw."""
        spread = known.spread(along.shape[1])
        moved = along * spread if spread.ndim == 1 else along @ spread
        return np.asarray(moved.reshape(m, self.rows.n, -1))

    def _meetings(self, seen: Seen, m: int) -> Iterator[Array]:
        """(m, n) per pair of draws that meet in a product: displacements times both standard uncertainties."""
        for first, second, effects in self._pairs:
            one, other = self.known[first], self.known[second]
            u = float(np.abs(one.spread(1)).max()) * float(np.abs(other.spread(1)).max())
            along = u * seen.product(one.input, other.input, effects).reshape(m, -1)
            for a, b in sorted(set(zip(one.codes.tolist(), other.codes.tolist()))):
                yield np.where((one.codes == a) & (other.codes == b), along, 0.0)

    @cached_property
    def _pairs(self) -> tuple[tuple[int, int, tuple[Effect, ...]], ...]:
        """Influences that meet in a product, and the effects in which they meet."""
        run, machine = self.rows.run(self.reference[None]), self.rows.machine
        sizes = [a.shape[1] for _, a in self.along(self.reference[None])]
        found = [Influence(k.input, np.zeros((1, 3, s)), (), k.codes) for k, s in zip(self.known, sizes)]
        out = []
        for p in products(machine, run, found):
            effects = shared(machine, run, self.known[p.first].input, self.known[p.second].input)
            out.append((p.first, p.second, tuple(effects)))
        return tuple(out)

    @cached_property
    def reference(self) -> Array:
        """The pose at which coverage factors and products are looked at."""
        return six_of(self.rows.scenario.pose) if self.at is None else self.at


def _readers(machine: Machine, one: Input) -> tuple[Effect, ...]:
    """Effects that ask for a column."""
    return tuple(e for e in machine.effects if one.parameter in e.required())


@dataclass(eq=False)
class Seen:
    """Effects of a machine projected on the normals of a run; the way of every link to the normals is made once.

    First order is linear in the motions of the links, so that derivatives need no kinematics of their own.
    """

    machine: Machine
    run: Run

    def __post_init__(self) -> None:
        self.maps: dict[tuple[str, str], Array] = {}
        self.moved_runs: dict[str, tuple[Run, Run, float]] = {}

    @cached_property
    def frames(self) -> Any:
        return link_frames(self.machine.chain, self.machine.axes, self.run)

    def of(self, effect: Effect) -> Array:
        """(rows, 6): indicated - true along the normal per unit of the six numbers of an effect."""
        key = (effect.link, effect.place)
        if key not in self.maps:
            if effect.link == "reading":
                self.maps[key] = np.concatenate([self.run.normal, np.zeros((self.run.n, 3))], axis=1)
            else:
                self.maps[key] = -sensed(self.frames, self.machine.axes, self.run, *key, self.run.normal)
        return self.maps[key] if effect.link == "reading" else self.machine.sign(effect) * self.maps[key]

    def parameter(self, known: Known) -> Array:
        """(rows, k) per unit of each element of a parameter."""
        total: Any = 0.0
        for effect in known.effects:
            total = total + projected_basis(effect, known.input.parameter, self.run, self.of(effect))
        return np.asarray(total)

    def channel(self, known: Known) -> Array:
        """(rows, 1) per unit of a column."""
        high, low, step = self.beside(known.input.parameter)
        total = np.zeros(self.run.n)
        for effect in known.effects:
            total += self.along(effect, effect.error_motion(high) - effect.error_motion(low)) / (2 * step)
        return total[:, None]

    def along(self, effect: Effect, six: Array) -> Array:
        return np.einsum("ni,ni->n", self.of(effect), six)

    def beside(self, column: str) -> tuple[Run, Run, float]:
        """The run with a column a step higher and lower."""
        if column not in self.moved_runs:
            step = next((s for ending, s in CHANNEL_STEP.items() if column.endswith(ending)), 1e-3)
            pair = [shifted(self.run, column, np.full(self.run.n, v)) for v in (step, -step)]
            self.moved_runs[column] = pair[0], pair[1], step
        return self.moved_runs[column]

    def product(self, one: Input, other: Input, effects: Sequence[Effect]) -> Array:
        """(rows,) per product of the departures of two Inputs: the response to a parameter a step to both sides."""
        if one.is_channel:
            one, other = other, one  # the first is a parameter: temperatures do not meet one another
        total = np.zeros(self.run.n)
        for effect in effects:
            if other.is_channel:
                high, low, step = self.beside(other.parameter)
                pair = [projected_basis(effect, one.parameter, run, self.of(effect)) for run in (high, low)]
            else:
                step = 1.0
                name = parameter(effect, other.parameter).name
                value = float(getattr(effect, name))
                moved = [with_parameter(effect, name, value + v) for v in (step, -step)]
                pair = [projected_basis(e, one.parameter, self.run, self.of(effect)) for e in moved]
            total += (pair[0] - pair[1])[:, 0] / (2 * step)
        return total


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
        machine = self.closed.rows.machine
        seen, total = Seen(machine, self.run), np.zeros(self.run.n)
        for effect in machine.effects:
            total += seen.along(effect, effect.error_motion(self.run))
        return total.reshape(self.m, -1)

    def _lanes(self, known: Known, moved: Array, weights: Array) -> Array:
        """(m, C, lanes): change of q per independent unit draw."""
        if known.copies == 1:
            return np.asarray(weights @ moved)
        copies = [known.codes == c for c in range(known.copies)]
        return np.concatenate([weights[:, rows] @ moved[:, rows] for rows in copies], axis=2)
