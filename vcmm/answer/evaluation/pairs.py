"""Sample parts at random and measure them with the machine as it is known: true and indicated values, side by side.

Every part has forms of a family on all its features and, where location and orientation are toleranced, features that are
shifted and tilted; sizes of forms and motions are spread evenly over the decades from far below the noise of the machine to
far above the measured value. The errors of the machine follow its Inputs; both sides are evaluated by the linear model of the task.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from zlib import crc32

import numpy as np

from vcmm.answer.evaluation.bound_shares import FULL, Share, at_share, possible_shares, split
from vcmm.answer.evaluation.exact import draw_inputs
from vcmm.answer.evaluation.form_family import FAMILIES, KNOWN, Ground, left_over, motions
from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.answer.evaluation.montecarlo import simulate
from vcmm.answer.evaluation.sampling import multiplying
from vcmm.answer.evaluation.submodel import displace, narrow_model
from vcmm.answer.evaluation.true_values import surface_model
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.task.measuring.plan import Ints
from vcmm.task.measuring.task import Task
from vcmm.task.response.trials import Draws

BLOCK = 2000
MOST_FOLDED = 300  # touches beyond which Inputs are drawn one by one
# of the first parts, so many without an element are too many to look for the others one by one
SHOWN = 20
GIVEN_UP = 4
LEAST_FORM_RATIO, MOST_FORM_RATIO = (
    0.05,
    40.0,
)  # form over noise of the machine: from nothing to so much that noise does not matter
UNIT = 1e-4  # mm: takes the place of the noise where only a limit of it is known; forms then begin at 5 nm
SMALLEST = 1e-7  # mm: no noise is taken for less
FORMLESS = 0.1  # share of parts without form
# lognormal spread of the features of one part about the size of its forms: one process made them
FORM_SPREAD = 0.5


PartValues = tuple[Array, Array, Array]  # of parts: true, indicated, rest


@dataclass(frozen=True)
class Largest:
    """Largest departures of sampled parts: the largest form over the noise, the largest displacement of features over that by the
    machine, or both over UNIT (`Drawing.unit`, `Drawing.away`).
    """

    form: float = MOST_FORM_RATIO
    off: float = MOST_FORM_RATIO


@dataclass(frozen=True, eq=False)
class Pairs:
    """true, indicated (N, C) mm or rad, NaN where a part has no such element; rest (N, C): root mean square of the residuals of
    the features of each characteristic. C: the characteristics that parts are sampled for.
    """

    true: Array
    indicated: Array
    rest: Array

    def of(self, column: int, parts: Ints | slice = slice(None)) -> Pairs:
        """Return one characteristic of some of the parts, (N, 1)."""
        return Pairs(*(a[parts, column : column + 1] for a in (self.true, self.indicated, self.rest)))


@dataclass(frozen=True, eq=False)
class Machines:
    """Effect of sampled machines on the `touches` of a model (None: all); sampled once for parts of every size and kind.

    shares: the machines allowed, from the least to those of the model itself (`vcmm.answer.evaluation.bound_shares`).
    """

    model: LinearModel
    touches: Ints | None = None
    _draws: dict[tuple[int, int, int], Sequence[Array]] = field(default_factory=dict, repr=False)

    @cached_property
    def shares(self) -> tuple[Share, ...]:
        return possible_shares(self.model.influences)

    def errors(self, seed: int, first: int, count: int, share: Share = FULL) -> Array:
        """Return displacements (count, n) of the touches along their normals, see `machine_part`."""
        place = seed, first, count
        if place not in self._draws:
            parts = [self.model] if len(self.shares) == 1 else split(self.model)
            self._draws[place] = [machine_part(part, *place) for part in parts]
        drawn = self._draws[place]
        displacements = drawn[0] if len(drawn) == 1 else at_share(drawn, share)
        return displacements if self.touches is None else displacements[:, self.touches]


@dataclass(frozen=True, eq=False)
class Drawing:
    """Models from which pairs are sampled: the measured and the dense model of the characteristics, and per feature the noise
    that remains after a fit. touches: those of the whole task that they need.
    """

    measured: LinearModel
    surface: LinearModel
    noise: Mapping[str, float]
    attitude: float  # mm: how far the machine moves a feature as a whole
    bound: bool  # whether limits are all that is known of some errors
    noise_left: Mapping[str, Array]
    free_features: frozenset[str]  # features whose place and direction are toleranced
    touches: Ints
    machines: Machines

    @property
    def task(self) -> Task:
        return self.measured.task

    def unit(self, name: str) -> float:
        """Return the unit in mm of the sizes of the forms of a feature: the noise.

        Where the noise comes from a limit, parts must not depend on it: otherwise a worse limit would give other parts, and other ends.
        """
        return UNIT if self.bound else self.noise[name]

    @property
    def away(self) -> float:
        """Unit in mm of the displacement of features."""
        return UNIT if self.bound else self.attitude

    def only(self, columns: Sequence[int]) -> Drawing:
        """Return the same parts and machines, of which some characteristics are evaluated: features that these do not need are not sampled."""
        if list(columns) == list(range(len(self.measured.characteristics))):
            return self
        (measured, kept), (surface, _) = (
            narrow_model(m, columns, True) for m in (self.measured, self.surface)
        )
        names = measured.task.touches.rows
        return replace(
            self, measured=measured, surface=surface, noise={n: self.noise[n] for n in self.noise if n in names},
            noise_left={n: self.noise_left[n] for n in names}, touches=self.touches[kept], machines=replace(self.machines, touches=kept),
        )  # fmt: skip

    @cached_property
    def grounds(self) -> Mapping[str, Ground]:
        """Touches of each feature and its points all over."""
        models = (self.measured, self.surface)
        return {
            n: Ground(f, tuple(m.task.touches.points[m.task.touches.rows[n]] for m in models))
            for n, f in ((n, self.task.part.features[n]) for n in self.noise)
        }


def prepare_drawing(task: Task, seed: int, numbers: Sequence[int]) -> Drawing:
    """Prepare models of the characteristics `numbers` about the nominal part, and the noise of the machine at each feature."""
    plain = replace(task, form=np.zeros_like(task.form), forms={})
    model, kept = narrow_model(build(plain), numbers)
    t = model.task.touches
    left = {n: left_over(task.part.features[n], t.points[r], t.normals[r]) for n, r in t.rows.items()}
    noise = machine_part(model, seed, 0, 400)
    noise = noise - noise.mean(axis=0)
    moved = {n for c in model.characteristics if gps.is_one_sided(c) and c.type not in gps.FORM for n in c.of}
    return Drawing(
        measured=model, surface=surface_model(model.task), bound=any(f.input.bound for f in model.influences), noise={n: _size(noise[:, r], left[n]) for n, r in t.rows.items()},
        attitude=max(float(noise.std()), SMALLEST), noise_left=left, free_features=frozenset(moved), touches=kept,
        machines=Machines(model),
    )  # fmt: skip


def _size(noise: Array, left: Array) -> float:
    """Return the standard deviation of the noise at a feature after a fit; of all of it where a fit leaves nothing."""
    remains = noise @ left if np.trace(left) > 0.5 else noise
    return max(float(remains.std()), SMALLEST)


def machine_part(model: LinearModel, seed: int, first: int, count: int) -> Array:
    """Return displacements (count, n) of the touches along their normals by sampled machines, without the known errors.

    Trials of the collapsed model whose quantities are the touches themselves: Inputs of normal law are sampled together.
    """
    n = model.task.touches.run.n
    if not model.influences:
        return np.zeros((count, n))
    if n > MOST_FOLDED:
        return _one_by_one(model, seed, first, count)
    of_touches = replace(model, operator=np.eye(n), q0=np.zeros(n))
    terms, multiplied = multiplying(of_touches, of_touches.terms())
    carried = len(terms[0].gain) if terms else n
    drawn = np.concatenate(list(simulate(np.zeros(carried), terms, seed=seed, trials=count, first=first)))
    return drawn if multiplied is None else np.ascontiguousarray(multiplied(drawn))


def _one_by_one(model: LinearModel, seed: int, first: int, count: int) -> Array:
    """Return the result of `machine_part` with every Input by itself: in time proportional to the touches."""
    drawn = draw_inputs(model, seed, first, count)
    total = np.zeros((count, model.task.touches.run.n))
    for draws in drawn:
        total += of_input(model, draws)
    for product in model.products:
        a, b = drawn[product.first], drawn[product.second]
        along = np.einsum("ni,ni->n", product.response, model.task.touches.run.normal)
        departures = a.departures[:, a.influence.codes, 0] * b.departures[:, b.influence.codes, 0]
        total += departures * along
    return total


def of_input(model: LinearModel, draws: Draws) -> Array:
    """Return displacements (count, n) of the touches along their normals by the draws of one Input."""
    codes, along = draws.influence.codes, model.along_normal(draws.influence)
    if draws.departures.shape[1] == 1:
        return np.asarray(draws.departures[:, 0] @ along.T)
    each = np.array_equal(codes, np.arange(draws.departures.shape[1]))  # a draw for every touch
    return np.asarray(
        np.einsum("mnk,nk->mn", draws.departures if each else draws.departures[:, codes], along)
    )


def families(
    drawing: Drawing,
    count: int,
    seed: int,
    names: Sequence[str] = KNOWN,
    most: Largest = Largest(),
    ratio: float | None = None,
    shares: Sequence[Share] = (FULL,),
) -> list[list[Pairs]]:
    """Return `count` parts of each family, measured by the same machines; a list of families for every share. ratio: form over noise of all."""
    blocks: list[list[list[PartValues]]] = [[[] for _ in names] for _ in shares]
    for at in range(0, count, BLOCK):
        size = min(BLOCK, count - at)
        noise = [drawing.machines.errors(seed, at, size, share) for share in shares]
        for k, name in enumerate(names):
            for of_share, part_values in zip(blocks, _block(drawing, noise, (seed, at), (name, most, ratio))):
                of_share[k].append(part_values)
    return [[Pairs(*(np.concatenate(x) for x in zip(*family))) for family in of_share] for of_share in blocks]


def pairs(
    drawing: Drawing,
    count: int,
    seed: int,
    family: str,
    most: Largest = Largest(),
    ratio: float | None = None,
) -> Pairs:
    """Return `count` parts of one family."""
    return families(drawing, count, seed, (family,), most, ratio)[0][0]


def both(
    drawing: Drawing, count: int, seed: int, most: Largest = Largest(), ratio: float | None = None
) -> Pairs:
    """Return parts of the families that the inverse knows, equal numbers of each."""
    return concatenate_pairs(families(drawing, count // len(KNOWN), seed, KNOWN, most, ratio)[0])


def concatenate_pairs(drawn: Sequence[Pairs]) -> Pairs:
    """Join parts one after the other."""
    return Pairs(*(np.concatenate([getattr(d, n) for d in drawn]) for n in ("true", "indicated", "rest")))


def _block(
    drawing: Drawing, noise: Sequence[Array], place: tuple[int, int], how: tuple[str, Largest, float | None]
) -> list[PartValues]:
    """Return the same parts for every noise (count, n)."""
    touched, surface = surfaces(drawing, len(noise[0]), place, how)
    true = values(drawing.surface, surface)
    return [
        (true, values(drawing.measured, touched + displacements), _rest(drawing, touched + displacements))
        for displacements in noise
    ]


def surfaces(
    drawing: Drawing,
    count: int,
    place: tuple[int, int],
    how: tuple[str, Largest, float | None],
    off: float | None = None,
) -> tuple[Array, Array]:
    """Return departures of `count` parts at the touches (count, n), and all over (count, N); mm along the outward normals.

    place: seed, number of the first part; how: family, how far they go, the form of all (None: any); off: how far all are
    out of place and direction (None: as their forms, in the units of `Drawing`), over the noise.
    """
    own_stream = [*place, sorted(FAMILIES).index(how[0])]
    ratio = _ratios(np.random.default_rng(own_stream), count, how[1].form, how[2])
    touched = np.zeros((count, drawing.measured.task.touches.run.n))
    surface = np.zeros((count, drawing.surface.task.touches.run.n))
    for name in drawing.noise:
        rng = np.random.default_rng([*own_stream, crc32(name.encode())])
        size = ratio if how[2] is not None else ratio * np.exp(FORM_SPREAD * rng.normal(size=(count, 1)))
        of_feature = _departures(drawing, name, rng, size, how, off)
        touched[:, drawing.measured.task.touches.rows[name]] = of_feature[0]
        surface[:, drawing.surface.task.touches.rows[name]] = of_feature[1]
    return touched, surface


def values(model: LinearModel, displacements: Array) -> Array:
    """Return characteristics (m, C) after displacements (m, n); NaN where a part has no such element.

    Where some parts have none, every characteristic is evaluated by itself, and is NaN for its own parts only.
    """
    q = displace(model, displacements)
    try:
        return model.values(q)
    except ModelLimit:
        columns = [_each(model.only([i]), q) for i in range(len(model.characteristics))]
        return np.concatenate(columns, axis=1)


def _each(model: LinearModel, q: Array) -> Array:
    """Return the one characteristic (m, 1) of a model, NaN for parts without it: for all of them where many of the first have none."""
    few = _values_by_halves(model, q[:SHOWN])
    return np.full((len(q), 1), np.nan) if np.isnan(few).sum() >= GIVEN_UP else _values_by_halves(model, q)


def _values_by_halves(model: LinearModel, q: Array) -> Array:
    try:
        return model.values(q)
    except ModelLimit:
        if len(q) == 1:
            return np.full((1, 1), np.nan)
        return np.concatenate([_values_by_halves(model, half) for half in np.array_split(q, 2)])


def _departures(
    drawing: Drawing,
    name: str,
    rng: np.random.Generator,
    ratio: Array,
    how: tuple[str, Largest, float | None],
    off: float | None,
) -> list[Array]:
    """Sample departures of one feature at its touches and all over.

    ratio (count, 1): form over noise of every part. Place and direction vary by themselves.
    """
    count, (family, most, fixed) = len(ratio), how
    ground = drawing.grounds[name]
    formed = ground.feature.kind not in ("point", "mesh")
    shapes = (
        FAMILIES[family](rng, ground, count) if formed else [np.zeros((count, len(p))) for p in ground.sets]
    )
    size, away = (
        (drawing.unit(name), drawing.away) if off is None else (drawing.noise[name], drawing.attitude)
    )
    drawn = [size * ratio * shape for shape in shapes]
    if name in drawing.free_features:
        far = away * _ratios(rng, count, most.off, fixed if off is None else off)
        way = rng.normal(size=(count, 6)) * far
        way[:, 3:] *= 2.0 / max(float(np.ptp(ground.sets[1], axis=0).max()), 1.0)
        touches = [m.task.touches for m in (drawing.measured, drawing.surface)]
        bases = [motions(ground.feature, p, t.normals[t.rows[name]]) for p, t in zip(ground.sets, touches)]
        drawn = [d + way @ basis[:, :6].T for d, basis in zip(drawn, bases)]
    return drawn


def _ratios(rng: np.random.Generator, count: int, most: float, fixed: float | None) -> Array:
    """Sample the ratios (count, 1): evenly over the decades, some of them 0; or all the same."""
    if fixed is not None:
        return np.full((count, 1), fixed)
    ratio = np.exp(rng.uniform(np.log(LEAST_FORM_RATIO), np.log(most), (count, 1)))
    return np.where(rng.uniform(size=(count, 1)) < FORMLESS, 0.0, ratio)


def _rest(drawing: Drawing, displacements: Array) -> Array:
    """Return the residuals of the fits of a characteristic's features, root mean square (N, C) mm."""
    rows = drawing.task.touches.rows
    square = {n: ((displacements[:, r] @ drawing.noise_left[n]) ** 2).mean(axis=1) for n, r in rows.items()}
    columns = [
        np.sqrt(np.mean([square[n] for n in gps.needs(c) if n in square], axis=0))
        for c in drawing.task.part.characteristics
    ]
    return np.stack(columns, axis=1)


def rest_of(drawing: Drawing, points: Array) -> Array:
    """Return the same residuals (C,) mm of the measured points (n, 3) of the whole task."""
    t = drawing.task.touches
    displacements = ((points[drawing.touches] - t.points) * t.normals).sum(axis=1)
    return _rest(drawing, displacements[None])[0]
