"""Parts drawn at random and measured by the machine as it is known: true and indicated values, side by side.

Every part has forms of a family on all its features and, where location and orientation are toleranced, features that are
shifted and tilted; sizes of forms and motions are spread evenly over the decades from far below the noise of the machine to
far above what was found. The machine errs as its Inputs say; both sides are evaluated by the linear model of the task.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.evaluation.exact import draw_inputs
from vcmm.evaluation.linear import LinearModel, build
from vcmm.gps import characteristics as gps
from vcmm.inference.dense import surface_model
from vcmm.inference.form_family import FAMILIES, KNOWN, left_over, motions
from vcmm.measuring.task import Task

BLOCK = 2000
LOST = 0.02  # of the drawn parts may have no element by a criterion of contact: rarer than what the quantiles tell
LEAST, MOST = 0.05, 40.0  # form over noise of the machine: from nothing to so much that noise does not matter
FORMLESS = 0.1  # share of parts without form
APART = 0.5  # lognormal spread of the features of one part about the size of its forms: one process made them


@dataclass(frozen=True, eq=False)
class Pairs:
    """true, indicated (N, C) mm or rad; rest (N, C): root mean square of the residuals of the features of each characteristic."""

    true: Array
    indicated: Array
    rest: Array


@dataclass(frozen=True, eq=False)
class Drawing:
    """What pairs are drawn from: the measured and the dense model, and per feature the noise left over by a fit."""

    task: Task
    measured: LinearModel
    surface: LinearModel
    noise: Mapping[str, float]
    attitude: float  # mm: how far the machine moves a feature as a whole
    left: Mapping[str, Array]
    moved: frozenset[str]  # features whose place and direction are toleranced


def prepared(task: Task, seed: int) -> Drawing:
    """Models about the nominal part, and how large the noise of the machine is at each feature."""
    plain = replace(task, form=np.zeros_like(task.form))
    model = build(plain)
    t = task.touches
    left = {n: left_over(task.part.features[n], t.points[r], t.normals[r]) for n, r in t.rows.items()}
    noise = machine_part(model, seed, 0, 400)
    noise = noise - noise.mean(axis=0)
    sizes = {n: max(float((noise[:, r] @ left[n]).std()), 1e-7) for n, r in t.rows.items()}
    moved = {
        n for c in task.part.characteristics if gps.one_sided(c) and c.type not in gps.FORM for n in c.of
    }
    return Drawing(
        task=plain, measured=model, surface=surface_model(plain), noise=sizes, attitude=max(float(noise.std()), 1e-7),
        left=left, moved=frozenset(moved),
    )  # fmt: skip


def machine_part(model: LinearModel, seed: int, first: int, count: int) -> Array:
    """Displacements (count, n) of the touches along their normals by drawn machines, the known errors not among them."""
    total = np.zeros((count, model.task.touches.run.n))
    drawn = draw_inputs(model, seed, first, count)
    for one in drawn:
        codes = one.influence.codes
        total += np.einsum("mnk,nk->mn", one.departures[:, codes], model.along_normal(one.influence))
    for product in model.products:
        one, other = drawn[product.first], drawn[product.second]
        along = np.einsum("ni,ni->n", product.response, model.task.touches.run.normal)
        departures = one.departures[:, one.influence.codes, 0] * other.departures[:, other.influence.codes, 0]
        total += departures * along
    return total


def pairs(
    drawing: Drawing,
    count: int,
    seed: int,
    family: str = "waves",
    most: float = MOST,
    ratio: float | None = None,
) -> Pairs:
    """`count` parts of a family. most: largest form over noise; ratio: the form of all parts is this many times the noise."""
    parts = [
        _block(drawing, min(BLOCK, count - at), (seed, at), (family, most, ratio))
        for at in range(0, count, BLOCK)
    ]
    return Pairs(*(np.concatenate(x) for x in zip(*parts)))


def both(drawing: Drawing, count: int, seed: int, most: float = MOST, ratio: float | None = None) -> Pairs:
    """Parts of the families that the inverse knows, as many of each."""
    drawn = [pairs(drawing, count // len(KNOWN), seed, family, most, ratio) for family in KNOWN]
    return Pairs(*(np.concatenate([getattr(d, n) for d in drawn]) for n in ("true", "indicated", "rest")))


def _block(
    drawing: Drawing, count: int, place: tuple[int, int], how: tuple[str, float, float | None]
) -> tuple[Array, Array, Array]:
    seed, first = place
    rng = np.random.default_rng([seed, first, sorted(FAMILIES).index(how[0])])
    touched = np.zeros((count, drawing.measured.task.touches.run.n))
    surface = np.zeros((count, drawing.surface.task.touches.run.n))
    ratio = _ratios(rng, count, how[1], how[2])
    for name in drawing.noise:
        own = ratio if how[2] is not None else ratio * np.exp(APART * rng.normal(size=(count, 1)))
        for total, part in zip((touched, surface), _departures(drawing, name, rng, own, how)):
            total += part
    found = touched + machine_part(drawing.measured, seed, first, count)
    true = _values(drawing.surface, surface)
    indicated = _values(drawing.measured, found)
    kept = np.isfinite(true).all(axis=1) & np.isfinite(indicated).all(axis=1)
    if kept.mean() < 1.0 - LOST:
        raise ModelLimit(
            f"{1.0 - kept.mean():.0%} of the drawn parts have no element by the criteria asked for; measure more points, or use criterion G"
        )
    return true[kept], indicated[kept], _rest(drawing, found[kept])


def _values(model: LinearModel, displacements: Array) -> Array:
    """Characteristics (m, C) after displacements (m, n); NaN for the few parts whose elements by contact are not found."""
    try:
        return model.values(model.q0 + displacements @ model.operator.T)
    except ModelLimit:
        if len(displacements) == 1:
            return np.full((1, len(model.characteristics)), np.nan)
        return np.concatenate([_values(model, half) for half in np.array_split(displacements, 2)])


def _departures(
    drawing: Drawing, name: str, rng: np.random.Generator, ratio: Array, how: tuple[str, float, float | None]
) -> list[Array]:
    """Departures of one feature at its touches and all over, spread out over the columns of all touches.

    ratio (count, 1): form over noise of every part. Place and direction vary by themselves.
    """
    count, (family, most, fixed) = len(ratio), how
    feature, models = drawing.task.part.features[name], (drawing.measured, drawing.surface)
    sets = [m.task.touches.points[m.task.touches.rows[name]] for m in models]
    normals = [m.task.touches.normals[m.task.touches.rows[name]] for m in models]
    formed = feature.kind not in ("point", "mesh")
    shapes = (
        FAMILIES[family](rng, feature, sets, count) if formed else [np.zeros((count, len(p))) for p in sets]
    )
    drawn = [drawing.noise[name] * ratio * shape for shape in shapes]
    if name in drawing.moved:
        way = rng.normal(size=(count, 6)) * drawing.attitude * _ratios(rng, count, most, fixed)
        way[:, 3:] *= 2.0 / max(float(np.ptp(sets[1], axis=0).max()), 1.0)
        drawn = [d + way @ motions(feature, p, n)[:, :6].T for d, p, n in zip(drawn, sets, normals)]
    out = []
    for model, values in zip(models, drawn):
        full = np.zeros((count, model.task.touches.run.n))
        full[:, model.task.touches.rows[name]] = values
        out.append(full)
    return out


def _ratios(rng: np.random.Generator, count: int, most: float, fixed: float | None) -> Array:
    """(count, 1): evenly over the decades, some of nothing; or all the same."""
    if fixed is not None:
        return np.full((count, 1), fixed)
    ratio = np.exp(rng.uniform(np.log(LEAST), np.log(most), (count, 1)))
    return np.where(rng.uniform(size=(count, 1)) < FORMLESS, 0.0, ratio)


def _rest(drawing: Drawing, found: Array) -> Array:
    """(N, C) mm: what the fits of a characteristic's features leave, root mean square."""
    rows = drawing.task.touches.rows
    square = {n: ((found[:, r] @ drawing.left[n]) ** 2).mean(axis=1) for n, r in rows.items()}
    columns = [
        np.sqrt(np.mean([square[n] for n in gps.needs(c) if n in square], axis=0))
        for c in drawing.task.part.characteristics
    ]
    return np.stack(columns, axis=1)


def rest_of(drawing: Drawing, points: Array) -> Array:
    """(C,) mm: the same of measured points (n, 3)."""
    t = drawing.task.touches
    found = ((points - t.points) * t.normals).sum(axis=1)
    return _rest(drawing, found[None])[0]
