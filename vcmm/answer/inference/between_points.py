"""Form between the points: estimate the form of a feature from its residuals, and its effect on a size or distance.

    f = s (c1 b1 + c2 b2 + ...)      form of the surface, waves around and along it without size, place or direction; s its root mean square
    r = M (f + e)                    residuals of the fit at the points; e: errors of the machine, known from its Inputs
    a f                              how far the form moves a result: a = d result / d point along its normal, the fit included

The shape of the form is unknown, so several are tried: one number of lobes (or half waves) alone, waves of all numbers that
fall by different powers, and of planes and lines polynomials of second and third degree. A parabola of 1 touched at -0.9, 0 and 0.9
moves the mean by 2/3 0.81 - 1/3 = 0.207, a cosine as high at these points (0.81) by 0.125: neither can replace the other. For each of
them the residuals determine s (evidence over a grid of s, evenly over the decades) with as few degrees of freedom as they have, and then
how large a f may be; its sign is left open, so that no fitted model is subtracted from the result. The interval holds for every shape
that the residuals leave plausible: it takes the widest, not the mean of them. A shape that the points do not meet (four lobes at four
points) has no bound, and then no coverage is claimed. Means over a surface are those of the middles of equal pieces of it.

Form as a random process of harmonics: M. M. Dowling, P. M. Griffin, K.-L. Tsui, C. Zhou, Technometrics 39 (1997) 3; H. Xia, Y. Ding,
J. Wang, IIE Transactions 40 (2008) 931. A shape is left out when its evidence is `slim` times less than the mean of all: by Markov's
inequality the true one is lost with a probability of at most 1 / `slim` (L. Wasserman, A. Ramdas, S. Balakrishnan, PNAS 117 (2020) 16880).
Law of s before: H. Jeffreys, Proc. R. Soc. A 186 (1946) 453, which favours no size that the points cannot show.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from statistics import NormalDist

import numpy as np

from vcmm.answer.evaluation.form_family import ALONG, AROUND, Ground, Ints, motions
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.pairs import LEAST_FORM_RATIO, MOST_FORM_RATIO
from vcmm.answer.evaluation.true_values import all_over
from vcmm.answer.evaluation.truth import MORE_MISSES
from vcmm.answer.inference.noises import STATED, Noises, Rung, noises_of
from vcmm.core.run import Array
from vcmm.part.part import Feature, normal

ROUND = ("circle", "cylinder", "cone", "sphere", "torus")
FORM_KINDS = (*ROUND, "plane", "line")
# single shapes: lobes; half waves along each side of a plane; waves of a plane in all
LOBES = (2, 8)
HALF_WAVES = 3
FLAT = 5
BENT = (2, 3)  # degrees of planes and lines as clamping, heat or a bent guideway leaves them
BENT_WORDS = {2: "a bow", 3: "a bow of third degree"}
POWERS = (0.0, 1.0, 2.0)  # by which waves fall with their number
DRAWS, SIZES = 400, 64
NORMAL = np.array([NormalDist().inv_cdf((i + 0.5) / DRAWS) for i in range(DRAWS)])  # equal parts of the law
MOST_POINTS = 2000  # points of a feature of which residuals are read: forms of a few waves ask for no more
CAP = 1000.0  # largest form over noise or residuals that is thought of
LEAST_SHAPE = 1e-4  # of a shape, left by the fit: less is the spacing of the points by chance
MOVES = 0.03  # an end that moves by more when the largest form is halved has no bound


@dataclass(frozen=True, eq=False)
class Shape:
    """One kind of form at the points of one feature, its root mean square over the surface 1.

    The form is a sum of c waves of amounts y, standard normal for a form of size 1. filter (k, n), strength (k,): information in residuals (n,)
    about the first k amounts, in units of the noise, and how strongly; reach: per characteristic what each amount moves it by (c,).
    """

    words: str
    filter: Array
    strength: Array
    reach: Mapping[int, Array]

    def evidence(self, residuals: Array, grid: Array) -> Array:
        """Return log P(residuals | size), with the prior probability of each size (g,), for every size of the grid, mm.

        The prior of the sizes is the law of Jeffreys, root of the Fisher information: sizes that the points could not show
        count little, and above that all decades count alike.
        """
        z, more = self.filter @ residuals, 1.0 + np.multiply.outer(grid**2, self.strength**2)
        share = 1.0 - 1.0 / more
        before = np.sqrt((share**2).sum(axis=1)) if len(z) else np.ones(len(grid))
        likelihood = 0.5 * (z**2 * share - np.log(more)).sum(axis=1)
        return np.asarray(likelihood + np.log(before / before.sum()))

    def motion(self, characteristic: int, residuals: Array, size: Array, normal: Array) -> Array:
        """(m,) mm or rad: drawn given the residuals, of forms of these sizes (m,); normal (m,): standard normal numbers.

        Given its size the amounts of a form are normal and independent, so that what they move together is normal too: no axes of
        the shape are chosen, and neither the order of the points nor the last digit of a place moves the answer.
        """
        z, s, reach = self.filter @ residuals, self.strength, self.reach[characteristic]
        less, k = 1.0 / (1.0 + np.multiply.outer(size**2, s**2)), len(s)  # (m, k)
        mean = size**2 * (less @ (reach[:k] * s * z))
        variance = size**2 * (less @ reach[:k] ** 2 + (reach[k:] ** 2).sum())
        return np.asarray(mean + np.sqrt(variance) * normal)


@dataclass(frozen=True, eq=False)
class Waves:
    """Waves of one feature: words and weights (c,) of every kind of form; their residuals after the fit at the points (n, c), and all
    over (N, c); basis (n, d): orthonormal, of these residuals; effects: change of each characteristic by each wave (c,).
    """

    kinds: tuple[tuple[str, Array], ...]
    residuals: Array
    whole: Array
    basis: Array
    effects: Mapping[int, Array]

    def shapes(self, whitening: Array) -> tuple[Shape, ...]:
        """Return shapes for residuals whose noise this (d, d) makes independent."""
        seeing = whitening @ self.basis.T
        return tuple(
            _shape(words, w, (self.residuals, self.whole), seeing, self.effects) for words, w in self.kinds
        )


@dataclass(frozen=True, eq=False)
class FeatureForms:
    """All shapes of one feature, and the errors of the machine in its residuals. Of many points one residual in `every` is read."""

    name: str
    points: int
    every: int
    waves: Waves
    noises: Noises
    machine_share: Array  # (n,) what of the known errors of the machine stands in the residuals
    _shapes: dict[Rung, tuple[Shape, ...]] = field(default_factory=dict, repr=False)

    @property
    def moves(self) -> tuple[int, ...]:
        """Numbers of the characteristics that this form moves."""
        return tuple(self.waves.effects)

    @property
    def noise(self) -> float:
        """Noise of a point, root mean square, mm: all errors that the machine may add."""
        return self.noises.whitening(STATED)[1]

    def without_form(self, rung: Rung, residuals: Array) -> float:
        """Return log P(residuals) with this noise alone, but for a constant."""
        whitening = self.noises.whitening(rung)[0]
        independent = whitening @ (self.waves.basis.T @ residuals)
        return float(np.log(np.diag(whitening)).sum() - 0.5 * independent @ independent)

    def shapes(self, rung: Rung) -> tuple[Shape, ...]:
        """Return shapes for residuals with this noise."""
        if rung not in self._shapes:
            self._shapes[rung] = self.waves.shapes(self.noises.whitening(rung)[0])
        return self._shapes[rung]


@dataclass(frozen=True, eq=False)
class FormTold:
    """Effect of the form of one feature on one characteristic: sampled sizes (m,), mm or rad, of either sign; unseen: shapes of any size
    that the points do not meet, in words.
    """

    feature: str
    points: int
    sizes: Array
    shape: str
    unseen: tuple[str, ...]


def forms_of(
    model: LinearModel, characteristics: Sequence[int], stated: Mapping[str, object]
) -> tuple[FeatureForms, ...]:
    """Return the forms of every feature that moves one of the characteristics (their numbers) and of which no form is stated."""
    gradient, out = model.gradient(), []
    for name, rows in model.task.touches.rows.items():
        feature = model.task.part.features[name]
        if name in stated or feature.kind not in FORM_KINDS:
            continue
        across = {i: gradient[i] @ model.operator[:, rows] for i in characteristics}
        across = {i: a for i, a in across.items() if np.abs(a).max() > 1e-9}
        if across:
            out.append(_forms(model, feature, rows, across))
    return tuple(out)


def _forms(model: LinearModel, feature: Feature, rows: Ints, across: Mapping[int, Array]) -> FeatureForms:
    t, every = model.task.touches, -(-len(rows) // MOST_POINTS)
    few = rows[::every]
    at, dense = t.points[few], all_over(feature, t.points[few], middles=True)
    here, whole = (w.T for w in _waves(feature, at, dense))  # (n, c), (N, c)
    met = {i: _moved_by_waves(feature, t.points[rows], dense, a) for i, a in across.items()}
    moved = _motions(feature, at)
    left = here - moved @ (moved.T @ here)
    error = (model.world.errors()[few] * t.run.normal[few]).sum(axis=1)
    kept = np.linalg.norm(whole, axis=0) > 1e-6 * np.sqrt(len(whole))
    basis, strengths, _ = np.linalg.svd(left[:, kept] / np.sqrt(len(few)), full_matrices=False)
    basis = basis[:, strengths > LEAST_SHAPE]
    kinds = [(words, weight * kept) for words, weight in _kinds(feature) if (weight * kept).any()]
    waves = Waves(tuple(kinds), left, whole, basis, met)
    machine_share = error - moved @ (moved.T @ error)
    return FeatureForms(
        name=feature.name, points=len(rows), every=every, waves=waves, noises=noises_of(model, few, basis), machine_share=machine_share,
    )  # fmt: skip


def _moved_by_waves(feature: Feature, points: Array, dense: Array, across: Array) -> Array:
    """Return the change (c,) by each wave of a result that changes by across (n,) per height of the points, a block of them at a time."""
    blocks = range(0, len(points), MOST_POINTS)
    waves = (
        (_waves(feature, points[k : k + MOST_POINTS], dense)[0], across[k : k + MOST_POINTS]) for k in blocks
    )
    return np.asarray(sum(w @ a for w, a in waves))


def _waves(feature: Feature, at: Array, dense: Array) -> tuple[Array, Array]:
    """Return waves (c, n) at points (n, 3), and all over: waves, then of planes and lines polynomials, motions and sizes left out of both."""
    ground = Ground(feature, (at, dense))
    waves = ground.waves
    bent = [_polynomials(feature, *place) for place in ground.coordinates]
    bent = [b - bent[-1] @ columns for b, columns in zip(bent, ground.motion_columns)]
    here, whole = (np.concatenate(pair) for pair in zip(waves, bent))
    return here, whole


def _polynomials(feature: Feature, first: Array, along: Array) -> Array:
    """Return products of the polynomials of Legendre along both sides, in the order of `_degrees`, (k, n)."""
    p = np.polynomial.legendre.legvander
    a, b = (p(x, BENT[-1]).T for x in (first, along))
    return np.array([a[i] * b[j] for i, j in _degrees(feature)]).reshape(-1, len(along))


def _degrees(feature: Feature) -> list[tuple[int, int]]:
    """Return the degrees of the polynomials along both sides of a plane, along a line; none for round features."""
    most = BENT[-1]
    return [
        (i, j)
        for i in range(most + 1)
        for j in range(most + 1)
        if BENT[0] <= i + j <= most and (feature.kind == "plane" or (feature.kind == "line" and i == 0))
    ]


def _motions(feature: Feature, points: Array) -> Array:
    """Return orthonormal displacements (n, k) of its points by motions and sizes of the feature."""
    columns = motions(feature, points, normal(feature, points))
    largest = np.abs(columns).max(axis=0)
    columns = columns[:, largest > 1e-9] / largest[largest > 1e-9]
    basis, sizes, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(basis[:, sizes > 1e-9 * sizes[0]])


def _kinds(feature: Feature) -> list[tuple[str, Array]]:
    """Return words and the weights (c,) of `_waves` for every kind of form."""
    around = np.repeat(np.arange(AROUND + 1), ALONG + 1)
    along = np.tile(np.arange(ALONG + 1), AROUND + 1)
    if feature.kind in ROUND:
        single = [(f"{m} lobes", (around == m) & (along == 0)) for m in range(LOBES[0], LOBES[1] + 1)]
        within = around >= 0 if feature.kind != "circle" else along == 0
    else:
        flat = feature.kind == "plane"
        numbers = [(m, n) for m in range(HALF_WAVES * flat + 1) for n in range(HALF_WAVES + 1) if m + n > 1]
        single = [(_half_waves(m, n, flat), (around == m) & (along == n)) for m, n in numbers]
        within = (around <= FLAT) if flat else (around == 0)
    power = [("waves", within * (1.0 + around + along) ** -p) for p in POWERS]
    degrees = _degrees(feature)
    none = np.zeros(len(degrees))
    waves = [(words, np.r_[np.tile(w, 4).astype(float), none]) for words, w in (*single, *power)]
    bent = [(BENT_WORDS[k], np.array([float(i + j <= k) for i, j in degrees])) for k in BENT * bool(degrees)]
    bent += [
        (f"a bow along its {side} side", np.array([float(d == only) for d in degrees]))
        for side, only in (("first", (2, 0)), ("second", (0, 2)))
        if feature.kind == "plane"
    ]
    return [*waves, *((words, np.r_[np.zeros(4 * len(around)), w]) for words, w in bent)]


def _half_waves(m: int, n: int, flat: bool) -> str:
    if not flat:
        return f"{n} half waves along"
    across = [
        f"{k} half wave{'s' * (k > 1)} along its {side} side"
        for k, side in ((m, "first"), (n, "second"))
        if k
    ]
    return " by ".join(across)


def _shape(
    words: str, weight: Array, waves: tuple[Array, Array], seeing: Array, met: Mapping[int, Array]
) -> Shape:
    """Return a shape.

    waves: their residuals after the fit at the points (n, c), and all over (N, c). seeing (d, n): residuals to independent
    numbers. met: change of each characteristic by each wave (c,).
    """
    used = weight > 0
    left, whole = (w[:, used] * weight[used] for w in waves)
    size = np.sqrt((whole**2).sum() / len(whole))
    none = np.zeros((0, 0)), np.zeros(0), np.eye(left.shape[1])
    p, s, q = np.linalg.svd(seeing @ left / size) if len(seeing) else none
    k = int((s > LEAST_SHAPE * max(float(s.max(initial=0.0)), 1.0)).sum())
    reach = {i: q @ (m[used] * weight[used]) / size for i, m in met.items()}
    return Shape(words, p[:, :k].T @ seeing, s[:k], reach)


def told_by(
    forms: FeatureForms, residuals: Array, p: float, floors: Mapping[int, float]
) -> dict[int, FormTold]:
    """Return, from residuals (n,) along the normals, the effect of the form on each characteristic. floors: half of its U without any
    form, mm or rad.

    Of all noises that the machine may have, the one that leaves the widest result counts.
    """
    residuals = residuals[:: forms.every] - forms.machine_share
    moved: dict[int, tuple[Array, str]] = {i: (np.zeros(1), "") for i in floors}
    unseen: dict[int, dict[str, None]] = {i: {} for i in floors}
    for rungs in forms.noises.rungs(residuals, 1.0 / slim(p)):
        _read_with(forms, rungs, residuals, p, floors, (moved, unseen))
    return {i: FormTold(forms.name, forms.points, *moved[i], tuple(unseen[i])) for i in floors}


def _read_with(
    forms: FeatureForms,
    rungs: Sequence[Rung],
    residuals: Array,
    p: float,
    floors: Mapping[int, float],
    findings: tuple[dict[int, tuple[Array, str]], dict[int, dict[str, None]]],
) -> None:
    """Put into `findings` the effects that exceed those already there, and shapes that have no bound. rungs: noises of
    which the residuals give the probability of each.
    """
    (moved, unseen), of_rungs = findings, [forms.shapes(rung) for rung in rungs]
    noises, rms = [forms.noises.whitening(r)[1] for r in rungs], float(np.sqrt((residuals**2).mean()))
    grid = np.geomspace(LEAST_FORM_RATIO * min(noises), CAP * max(*noises, rms), SIZES)
    alone = np.array([forms.without_form(rung, residuals) for rung in rungs])
    of_shapes = list(zip(*of_rungs))  # (shape, rung)
    logs = [
        np.array([s.evidence(residuals, grid) for s in shapes]) + alone[:, None] for shapes in of_shapes
    ]  # each (rung, size)
    weights = [np.exp(log - max(float(x.max()) for x in logs)) for log in logs]
    evidence = np.array([w.sum() for w in weights])
    weights = [w / max(float(w.sum()), 1e-300) for w in weights]
    endless = [float(w[:, grid > grid[-1] / 2].sum()) > MOVES * (1.0 - p) for w in weights]
    for i, floor in floors.items():
        open_ones = [shapes[-1] for shapes, e in zip(of_shapes, endless) if e]
        unseen[i] |= {s.words: None for s in open_ones if _matters(s.reach[i], forms, floor)}
    for shapes, weight, likelihood, is_open in zip(of_shapes, weights, evidence, endless):
        if is_open or likelihood * slim(p) < evidence.mean():
            continue
        rung, size = _sizes_drawn(grid, weight)
        for i in floors:
            parts = [(s, rung == k) for k, s in enumerate(shapes)]
            sizes = np.abs(np.concatenate([s.motion(i, residuals, size[of], NORMAL[of]) for s, of in parts]))
            if np.quantile(sizes, p) > np.quantile(moved[i][0], p):
                moved[i] = sizes, shapes[0].words


def _sizes_drawn(grid: Array, weight: Array) -> tuple[Ints, Array]:
    """Rung and size, mm, of DRAWS forms, as many of each as its weights (rung, size) say, in an order of their own."""
    at = np.searchsorted(np.cumsum(weight), (np.arange(DRAWS) + 0.5) / DRAWS).clip(0, weight.size - 1)
    rung, size = np.divmod(np.random.default_rng(2).permutation(at), len(grid))
    return rung, grid[size]


def _matters(reach: Array, forms: FeatureForms, floor: float) -> bool:
    """Return whether a shape that is MOST times as large as the noise would move a result by more than a tenth of U."""
    return float(np.linalg.norm(reach)) * MOST_FORM_RATIO * forms.noise > MORE_MISSES * floor


def slim(p: float) -> float:
    """Return the factor below the mean evidence of all at which shapes are left out: an interval for p may miss 1 - p, of which a tenth
    goes to these shapes."""
    return 1.0 / (MORE_MISSES * (1.0 - p))
