"""The linear model y = y0 + G z of a measuring task, from Inputs to fitted features.

    z (draws of the Inputs)  ->  indicated - true of each touch  ->  measured points  ->  fitted elements q
    q = (point, axis, sizes of every feature, and the residuals where a form or zone needs them)

Characteristics are then evaluated on q itself, so that extreme values (form, position) keep their non-linearity;
only the machine and the fit are linearised, and `certify` states by how much that errs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from vcmm.answer.evaluation.montecarlo import Term
from vcmm.answer.evaluation.part_forms import without_unknown
from vcmm.answer.evaluation.streams import copy_code
from vcmm.answer.evaluation.world import Measuring, World
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Array
from vcmm.part.fit import FittedElement, normal_matrix, sensitivity
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import criteria_needed, with_criteria
from vcmm.part.gps.datums import constrained_features
from vcmm.part.part import Characteristic, frame
from vcmm.task.measuring.task import (
    Task,
    check_densities,
    evaluate_all,
    fit_features,
    measured_points,
    per_normal,
)
from vcmm.task.response.influence import Influence, Product

MOST_POINTS = 3000  # of a feature whose single points count: 70 MB for the operator
IN_ALIGNMENT = ("position", *gps.PROFILE)  # evaluated in the frame of the alignment


@dataclass(frozen=True)
class FeatureBlock:
    """Places of one feature's numbers in q: point 3, axis 3, sizes s, residuals (n or 0), and displacements of its
    touches (n or 0), where a criterion of contact is evaluated on the points themselves.
    """

    kind: str
    start: int
    sizes: int
    residuals: int
    touches: int = 0

    @property
    def at_touches(self) -> int:
        """Index at which the displacements begin."""
        return self.start + 6 + self.sizes + self.residuals

    @property
    def stop(self) -> int:
        return self.at_touches + self.touches


@dataclass(frozen=True, eq=False)
class LinearModel:
    """q0 (K,), gains of every Input, and the functions that turn q into characteristics."""

    task: Task
    blocks: Mapping[str, FeatureBlock]
    base: Mapping[str, FittedElement]
    q0: Array
    operator: Array  # (K, n): q per displacement of each touch along its normal
    influences: tuple[Influence, ...]
    products: tuple[Product, ...]
    world: World
    points: Array  # (n, 3) measured points at the estimates

    @property
    def characteristics(self) -> tuple[Characteristic, ...]:
        return self.task.part.characteristics

    @cached_property
    def taken_up(self) -> dict[str, Array | None]:
        """Cache by feature for `vcmm.answer.evaluation.submodel.displace`: displacements that its element takes up."""
        return {}

    def unpack(self, q: Array) -> dict[str, FittedElement]:
        """Convert q (..., K) to fitted elements, axes of unit length."""
        fitted = {name: _unpack(block, self.base[name], q) for name, block in self.blocks.items()}
        part = self.task.part
        return with_criteria(
            part.characteristics, part.features, lambda name: self._displace(name, q), fitted, False
        )

    def _displace(self, name: str, q: Array) -> Array:
        """Return the points (..., n, 3) of a feature after the displacements in q, along the approach."""
        block, rows = self.blocks[name], self.task.touches.rows[name]
        along = q[..., block.at_touches : block.stop]
        return np.asarray(self.points[rows] + along[..., None] * per_normal(self.task.touches)[rows])

    @cached_property
    def at_estimates(self) -> Array:
        """Characteristics (C,) at q0, mm or rad."""
        return self.values(self.q0)

    def values(self, q: Array) -> Array:
        """Evaluate characteristics (..., C) of q (..., K), mm or rad."""
        return evaluate_all(self.task, self.unpack(q))

    def only(self, numbers: Sequence[int], aligned: bool = False) -> LinearModel:
        """Return the model with the same q, of which some characteristics are evaluated.

        aligned: in the frame of the alignment whatever they need, which keeps every bit of their values, and with no features
        beside theirs and its own.
        """
        kept, scheme = tuple(self.characteristics[i] for i in numbers), self.task.plan.alignment
        placed = any(c.type in IN_ALIGNMENT for c in kept)
        names = {n for c in kept for n in gps.needs(c)}
        if scheme and (placed or aligned):
            names |= set(self.blocks) & set(scheme.features) if aligned else set(self.blocks)
        plan = self.task.plan if placed or aligned else replace(self.task.plan, alignment=None)
        task = replace(self.task, part=replace(self.task.part, characteristics=kept), plan=plan)
        return replace(
            self, task=task, blocks={n: b for n, b in self.blocks.items() if n in names},
            base={n: f for n, f in self.base.items() if n in names},
        )  # fmt: skip

    def gradient(self) -> Array:
        """Return d characteristics / d q (C, K) at q0 by central differences; exact to 1e-7 for smooth characteristics."""
        step = np.full(len(self.q0), 1e-4)
        for block in self.blocks.values():
            step[block.start + 3 : block.start + 6] = 1e-6  # components of unit vectors
        high = self.values(self.q0 + np.diag(step))
        low = self.values(self.q0 - np.diag(step))
        return np.asarray(((high - low) / (2 * step[:, None])).T)

    def along_normal(self, influence: Influence) -> Array:
        """Change of each touch along its outward normal (n, k) per element of the Input."""
        return np.asarray(np.einsum("nik,ni->nk", influence.response, self.task.touches.run.normal))

    def term(self, influence: Influence, keep: bool = False) -> Term:
        """Return the Input as a term of the Monte Carlo (linear model): gain (K, L), one lane per element and copy.

        Lanes that act on nothing are dropped unless `keep` (their draws may act through a product).
        """
        return term_of(influence, self.along_normal(influence), self.operator, keep)

    def terms(self) -> tuple[Term, ...]:
        """Return one Term per Influence, in order."""
        kept = {i for p in self.products for i in (p.first, p.second)}
        return tuple(self.term(influence, i in kept) for i, influence in enumerate(self.influences))

    def product_gains(self, product: Product) -> list[tuple[int, int, Array]]:
        """Return (copy of the first, copy of the second, gain (K,) of q per product of their departures)."""
        along = np.einsum("ni,ni->n", product.response, self.task.touches.run.normal)
        first, second = (self.influences[i].codes for i in (product.first, product.second))
        out = []
        order = np.lexsort((second, first))  # stable: rows of one pair stand together, in their own order
        edges = np.flatnonzero(np.diff(first[order]) | np.diff(second[order])) + 1
        for rows in np.split(order, edges) if len(order) else ():
            a, b = int(first[rows[0]]), int(second[rows[0]])
            gain = self.operator[:, rows] @ along[rows]
            if np.abs(gain).max(initial=0.0) > 0:
                out.append((a, b, gain))
        return out


def term_of(influence: Influence, change: Array, operator: Array, keep: bool = False) -> Term:
    """Return the Input as a Term of K quantities operator (K, n) @ the change in n rows; change (n, k): per element of the Input.

    One lane per element and copy; lanes that act on nothing are dropped unless `keep`.
    """
    quantity = influence.input
    law, factor = quantity.spread(influence.response.shape[2])
    row_change = change @ factor
    elements = row_change.shape[1]
    order = np.argsort(influence.codes, kind="stable")  # rows of one copy stand together, in their own order
    ends = np.searchsorted(influence.codes[order], np.arange(len(influence.copies) + 1))
    if len(order) == len(influence.copies) and (np.diff(ends) == 1).all():  # one row each: products alone
        gain = (operator[:, order, None] * row_change[order]).reshape(len(operator), -1)
    else:
        groups = [order[a:b] for a, b in pairwise(ends)]
        gains = [operator[:, rows] @ row_change[rows] for rows in groups]
        gain = np.concatenate([np.zeros((len(operator), 0)), *gains], axis=1)
    codes = np.array([copy_code(label) for label in influence.copies], np.uint32)
    lane = np.stack(
        [np.tile(np.arange(elements, dtype=np.uint32), len(codes)), np.repeat(codes, elements)], axis=1
    )
    used = np.full(gain.shape[1], keep) | (np.abs(gain).max(axis=0, initial=0.0) > 0)
    return Term(quantity.id, law, gain[:, used], lane[used])


def prepare_model(task: Task, world: World | None = None) -> LinearModel:
    """Prepare a model: all steps of an evaluation before the first draw, with all their errors."""
    if not task.part.characteristics:
        raise UsageError(
            "the part has no characteristics; add [[part.characteristics]] with name, type and of"
        )
    if not task.inputs and not (world is not None and world.predicts):
        raise UsageError(
            "nothing is uncertain: add [repeatability], [errors] uncertainty or [[inputs]] to the machine or scenario"
        )
    check_densities(task)
    model = build(without_unknown(task) if task.forms else task, world)
    assert model.at_estimates is not None  # raises what the characteristics refuse
    return model


def build(task: Task, world: World | None = None) -> LinearModel:
    """Linearise a task about its estimates. world: where the errors come from (default: the task's machine).

    Raises ModelLimit/UsageError for targets, columns or fits that fail.
    """
    world = world or Measuring(task)
    base_points = measured_points(task, world.errors())
    base = _with_moments(task, fit_features(task, base_points), base_points)
    blocks, operator = _operator(task, base, base_points)
    influences = world.influences()
    return LinearModel(
        task=task, blocks=blocks, base=base, q0=_pack(blocks, base), operator=operator,
        influences=influences, products=world.products(influences), world=world, points=base_points,
    )  # fmt: skip


def _with_moments(task: Task, base: Mapping[str, FittedElement], points: Array) -> dict[str, FittedElement]:
    """Return datums whose orientation others constrain, with the normal matrix that determines their place."""
    out = dict(base)
    for name in constrained_features(task.part.characteristics, task.part.features) & set(base):
        out[name] = replace(base[name], moments=normal_matrix(base[name], points[task.touches.rows[name]]))
    return out


def _operator(
    task: Task, base: Mapping[str, FittedElement], points: Array
) -> tuple[dict[str, FeatureBlock], Array]:
    """Return blocks of q, and its change per displacement of each touch along the outward normal."""
    t = task.touches
    direction = per_normal(t)
    shapes = {c for name in base for c in (name,) if _needs_residuals(task.part.characteristics, name)}
    contact = criteria_needed(task.part.characteristics, task.part.features)
    blocks: dict[str, FeatureBlock] = {}
    rows_of, start = [], 0
    for name, fitted in base.items():
        rows = t.rows[name]
        feature = task.part.features[name]
        fixed = feature.axis if feature.kind == "circle" else None
        if len(rows) > MOST_POINTS and (name in shapes or name in contact):
            raise ModelLimit(
                f'"{name}" has {len(rows)} points: form, run-out, profile and elements by contact keep the square of their number; '
                f"take at most {MOST_POINTS} of them (sizes, distances and angles take any number)"
            )
        parts = [np.zeros((6, len(rows), 3))]
        if not feature.free:
            s = sensitivity(fitted, points[rows], fixed_axis=fixed, residuals=name in shapes)
            parts = [s.point, s.axis, s.sizes]
            if s.residuals is not None:
                along = s.deviations
                parts.append(
                    s.residuals if along is None else np.einsum("i,mipj->mpj", frame(feature)[0], along)
                )
        touches = len(rows) if name in contact else 0
        change = np.einsum("pni,ni->pn", np.concatenate(parts), direction[rows])
        change = np.concatenate([change, np.eye(touches, len(rows))])
        full = np.zeros((len(change), t.run.n))
        full[:, rows] = change
        row_count = len(rows) if name in shapes else 0
        blocks[name] = FeatureBlock(feature.kind, start, fitted.sizes.shape[-1], row_count, touches)
        rows_of.append(full)
        start = blocks[name].stop
    return blocks, np.concatenate(rows_of)


def _needs_residuals(characteristics: Sequence[Characteristic], name: str) -> bool:
    return any(c.type in gps.FORM and name in c.of for c in characteristics)


def _pack(blocks: Mapping[str, FeatureBlock], base: Mapping[str, FittedElement]) -> Array:
    parts = []
    for name, block in blocks.items():
        f = base[name]
        parts += [f.point, f.axis, f.sizes, f.residuals[: block.residuals], np.zeros(block.touches)]
    return np.concatenate(parts)


def _unpack(block: FeatureBlock, base: FittedElement, q: Array) -> FittedElement:
    if base.kind == "mesh":
        return replace(base, also={})
    at = block.start
    axis = q[..., at + 3 : at + 6]
    if np.any(base.axis):
        axis = axis / np.linalg.norm(axis, axis=-1, keepdims=True)
    sizes = q[..., at + 6 : at + 6 + block.sizes]
    residuals = q[..., at + 6 + block.sizes : block.at_touches]
    normals = base.normals[: block.residuals]
    return FittedElement(
        block.kind, q[..., at : at + 3], axis, sizes, residuals, normals, moments=base.moments
    )
