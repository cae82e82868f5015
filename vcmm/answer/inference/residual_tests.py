"""Test whether the residuals of measured points agree with the stated machine and a part with form: outliers, memory.

A fit leaves r = (1 - Q Q') d of the departures d of a feature, Q an orthonormal base of its motions and sizes, then also of the
longest waves of its surface (form is smooth, a speck of dust is not). Two questions, each with a false-alarm rate of ALARM per
part, whatever the size of the form:

outliers  the externally studentised residual t_i, which compares a point with the prediction of all others for its place (R. D. Cook,
          S. Weisberg, Residuals and Influence in Regression, 1982, 2.2.9), point after point (B. Rosner, Technometrics 25
          (1983) 165, which two outliers that hide one another do not deceive).
memory    likelihood ratio of noise with memory, e_t = rho e_(t-1) + a_t in the order of the file, against none, restricted to
          what Q leaves (H. D. Patterson, R. Thompson, Biometrika 58 (1971) 545), all features together.

The null laws are simulated: parts with forms of the default families are sampled, measured by the stated machine, and tested in
the same way (Monte Carlo test: M. Dwass, Ann. Math. Stat. 28 (1957) 181; its p value is exact). The p value is that of the
form that makes it largest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from zlib import crc32

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation.form_family import ALONG, AROUND, FAMILIES, KNOWN, Ground, motions
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.pairs import SMALLEST, machine_part
from vcmm.answer.inference.memory import RHOS, Whitening, likelihood_ratio, whitening
from vcmm.core.run import Array
from vcmm.part.part import Feature

Ints = npt.NDArray[np.integer]
ALARM = 0.01  # false alarms per part and test
RATIOS = (0.0, 1.0, 4.0, 16.0, 64.0)  # form over noise of the parts of the null
NOISES = (1.0, 0.5, 0.25)  # of what is stated: machines are often better than stated
SHARES = (0.25, 0.5)  # of the points of a feature: so many motions, sizes and waves are fitted at most
LEFT = 2  # degrees of freedom that a studentised residual needs at least
LEAST_SCAN = 12  # points of a feature whose order is looked at
MOST_FORM_POINTS = 3000  # points of a feature up to which forms are drawn for its null: beyond, 384 waves there take too much memory
NUMBERS, DRAWS = 2e5, (199, 1999)  # numbers of a null, about; parts, between these
BLOCK = 4_000_000  # numbers drawn at a time
FIRST_DRAWS, ENOUGH_EXCEEDANCES = (
    100,
    20,
)  # draws of a test of memory at first; it ends where so many show as much
STAGES, PER_OUTLIER = 8, 8  # outliers looked for: one in so many points, at most so many
NEW = 0.1  # of a wave lies outside of the base: less, and it is one of those already there
UNSEEN = 0.05  # of a point's departure is left by the fit: less, and the fit follows the point


@dataclass(frozen=True)
class Outlier:
    """A point that the others of its feature contradict. place: its number in the feature; size: mm outwards from their element."""

    feature: str
    place: int
    size: float
    p: float


@dataclass(frozen=True)
class Memory:
    """Noise with memory: correlation of neighbouring touches, and the share p of machines without it that would show as much."""

    rho: float
    p: float

    def effective(self, points: int) -> float:
        """Return the number of independent points with the same information about the mean: n (1 - rho) / (1 + rho), to 1/n (G. E. P. Box
        et al., 1994, 2.1)."""
        return max(points * (1.0 - self.rho) / (1.0 + self.rho), 1.0)


@dataclass(frozen=True, eq=False)
class ResidualTests:
    """The tests of one task, with their nulls."""

    model: LinearModel
    seed: int
    _shapes: dict[str, Array] = field(default_factory=dict, repr=False)

    @cached_property
    def features(self) -> Mapping[str, FeatureTest]:
        """Features that can be tested: those with an element and with residuals."""
        t, parts = self.model.task.touches, self.model.task.part.features
        tests = {n: _feature_test(parts[n], t.points[r], t.normals[r]) for n, r in t.rows.items()}
        return {n: f for n, f in tests.items() if f is not None}

    @cached_property
    def draws(self) -> int:
        """Number of parts of the null. ALARM (draws + 1) is a whole number, so that the rate of the test is ALARM and no less."""
        few, many = DRAWS
        count = int(np.clip(NUMBERS / max(self.model.task.touches.run.n, 1), few, many))
        return int((count + 1) * ALARM) * round(1 / ALARM) - 1

    @property
    def block(self) -> int:
        """Number of parts sampled and tested at a time."""
        return max(BLOCK // max(self.model.task.touches.run.n, 1), 1)

    @cached_property
    def noise(self) -> Mapping[str, Array]:
        """Effect of sampled machines on the touches of each feature (draws, n), mm."""
        rows = self.model.task.touches.rows
        out: dict[str, list[Array]] = {n: [] for n in self.features}
        for at in range(0, self.draws, self.block):
            drawn = machine_part(self.model, self.seed, at, min(self.block, self.draws - at))
            for n, blocks in out.items():
                blocks.append(drawn[:, rows[n]])
        return {n: np.concatenate(blocks) for n, blocks in out.items()}

    @cached_property
    def scale(self) -> Mapping[str, float]:
        """Standard deviation of the noise after a fit, by feature, mm."""
        return {
            n: max(float(np.sqrt((f.rest(self.noise[n]) ** 2).sum(axis=1).mean() / f.free)), SMALLEST)
            for n, f in self.features.items()
        }

    def shapes(self, name: str, family: str) -> Array:
        """Return forms (draws, n) of one family at the touches, of unit size; none where the points are too many."""
        f = self.features[name]
        if f.n > MOST_FORM_POINTS or f.feature.kind in ("point", "mesh"):
            return np.zeros((self.draws, f.n))
        rng = np.random.default_rng([self.seed, KNOWN.index(family), crc32(name.encode())])
        return FAMILIES[family](rng, f.ground, self.draws)[-1]

    @cached_property
    def nulls(self) -> tuple[Array, Array]:
        """Scores of the most suspicious point of every sampled part (strata, draws), sorted; its size over the noise without form."""
        best, size = np.zeros((len(KNOWN) * len(RATIOS), self.draws)), np.zeros(self.draws)
        for name, f in self.features.items():
            for k, family in enumerate(KNOWN):
                shapes = self.shapes(name, family) if f.n <= MOST_FORM_POINTS else None
                for j, ratio in enumerate(RATIOS):
                    if (ratio == 0.0 and k) or (ratio > 0.0 and shapes is None):
                        continue
                    place = k * len(RATIOS) + j
                    for at in range(0, self.draws, self.block):
                        part = slice(at, at + self.block)
                        d = self.noise[name][part]
                        d = d if shapes is None else d + ratio * self.scale[name] * shapes[part]
                        for _, score, away, _ in outlier_scores(f, d):
                            best[place, part] = np.maximum(best[place, part], score)
                            if ratio == 0.0:
                                size[part] = np.maximum(size[part], np.abs(away) / self.scale[name])
        return np.sort(best, axis=1), np.sort(size)

    def outliers(self, residuals: Mapping[str, Array], least: float = 0.0) -> tuple[Outlier, ...]:
        """Return the outliers. residuals: per feature (n,) mm outwards, in the order of its touches; least: mm, the rounding of the file.

        A point is named where no form makes it likely, and where it is larger than the errors of the stated machine.
        """
        outliers: dict[tuple[str, int], Outlier] = {}
        for name, f in self.features.items():
            listed = list(outlier_scores(f, residuals[name][None]))
            for base in range(len(f.bases)):
                stages = [outlier for outlier in listed if outlier[0] == base]
                odds = [self._p(float(s[0]), float(a[0]) / self.scale[name]) for _, s, a, _ in stages]
                last = max((i for i, p in enumerate(odds) if p <= ALARM), default=-1)
                for p, (_, _, away, at) in zip(odds[: last + 1], stages):
                    key, outlier = (
                        (name, int(at[0])),
                        Outlier(name, int(at[0]), float(away[0]), min(p, odds[last])),
                    )
                    if abs(outlier.size) > least and (key not in outliers or outlier.p < outliers[key].p):
                        outliers[key] = outlier
        return tuple(outliers.values())

    def _p(self, score: float, size: float) -> float:
        """Return the p value of the most suspicious point of a part, the largest over possible forms.

        Errors that are only bounded by limits do not excuse a point that contradicts the others: otherwise a worse limit would excuse more.
        """
        scores, sizes = self.nulls
        above = self.draws - np.min([np.searchsorted(row, score, side="left") for row in scores])
        if any(f.input.bound for f in self.model.influences):
            return float(1 + above) / (self.draws + 1)
        larger = self.draws - np.searchsorted(sizes, abs(size), side="left")
        return float(1 + max(above, larger)) / (self.draws + 1)

    def memory(self, residuals: Mapping[str, Array], order: Mapping[str, Ints]) -> Memory | None:
        """Return the memory. order: per feature its touches in the order of the file. None where no feature has enough points, and few enough
        for forms to be sampled: a form that the null lacks would be taken for memory."""
        scans = {n: f for n, f in self.features.items() if LEAST_SCAN <= f.n <= MOST_FORM_POINTS}
        if not scans:
            return None
        sizes = {n: float(np.linalg.norm(f.rest(residuals[n][None]))) for n, f in scans.items()}
        tests = []
        for number in (
            0,
            -1,
        ):  # with all that the elements leave, and without the waves that forms may be made of
            white = {n: [whitening(f.bases[number][order[n]], rho) for rho in RHOS] for n, f in scans.items()}
            ratio, rho = likelihood_ratio(white, {n: residuals[n][order[n]][None] for n in scans})
            p = 0.0
            for k, share in product(range(len(KNOWN)), NOISES):
                p = max(p, self._as_much(white, order, float(ratio[0]), (k, share, sizes)))
            tests.append(Memory(float(rho[0]), min(2.0 * p, 1.0)))  # two tests (Bonferroni)
        return min(tests, key=lambda test: test.p)

    def _as_much(
        self,
        white: Mapping[str, Sequence[Whitening]],
        order: Mapping[str, Ints],
        ratio: float,
        how: tuple[int, float, Mapping[str, float]],
    ) -> float:
        """Return the p value of a likelihood ratio among parts with residuals as large as the measured ones: form makes up for the missing noise.

        how: number of the family, noise over what is stated, lengths of the residuals. Draws end where it is clear that they show
        as much often enough: after ENOUGH_EXCEEDANCES of them p is that number over the draws (J. Besag, P. Clifford, Biometrika 78 (1991) 301).
        """
        above, done, size = 0, 0, FIRST_DRAWS
        while done < self.draws:
            part = slice(done, min(done + size, self.draws))
            drawn = {
                n: as_large(how[1] * self._rests(n)[part], self._rest_shapes(n, how[0])[part], how[2][n])[
                    :, order[n]
                ]
                for n in white
            }
            above += int((likelihood_ratio(white, drawn)[0] >= ratio).sum())
            done = part.stop
            if above >= ENOUGH_EXCEEDANCES:
                return above / done
            size *= 4
        return (1 + above) / (1 + done)

    def _rests(self, name: str) -> Array:
        """Return the noise (draws, n) after the fit of the element."""
        if name not in self._shapes:
            self._shapes[name] = self.features[name].rest(self.noise[name])
        return self._shapes[name]

    def _rest_shapes(self, name: str, family: int) -> Array:
        """Return forms of a family (draws, n) after the fit of the element."""
        place = f"{name} {KNOWN[family]}"
        if place not in self._shapes:
            self._shapes[place] = self.features[name].rest(self.shapes(name, KNOWN[family]))
        return self._shapes[place]


def as_large(noise: Array, shapes: Array, size: float) -> Array:
    """Return noise + a shape (m, n) with a >= 0 such that every row has the length `size`; noise alone where it is longer."""
    unit = shapes / np.maximum(np.linalg.norm(shapes, axis=1, keepdims=True), 1e-300)
    along, whole = (noise * unit).sum(axis=1), (noise**2).sum(axis=1)
    missing = np.maximum(size**2 - whole, 0.0)  # (a + along)^2 = along^2 + size^2 - whole
    return noise + (np.sqrt(along**2 + missing) - along)[:, None] * (missing > 0)[:, None] * unit


@dataclass(frozen=True, eq=False)
class FeatureTest:
    """A feature with its bases Q (n, k): motions and sizes, then also waves; each has freedoms left."""

    feature: Feature
    ground: Ground
    bases: tuple[Array, ...]

    @property
    def n(self) -> int:
        return len(self.bases[0])

    @property
    def free(self) -> int:
        """Degrees of freedom after the fit of the element."""
        return self.n - self.bases[0].shape[1]

    def rest(self, d: Array) -> Array:
        """Return departures d (m, n) after the fit of the element."""
        q = self.bases[0]
        return np.asarray(d - (d @ q) @ q.T)


def _feature_test(feature: Feature, points: Array, normals: Array) -> FeatureTest | None:
    """Return the test of a feature; None where no residuals remain, or there is no element with residuals."""
    if feature.kind in ("point", "mesh"):
        return None
    ground = Ground(feature, (points,))
    base = orthonormal(motions(feature, points, normals))
    n = len(points)
    if n - base.shape[1] - 1 < LEFT:
        return None
    bases = [base]
    for share in SHARES if n <= MOST_FORM_POINTS else ():
        most = int(share * n)
        wider = _with_waves(base, ground, most)
        if wider.shape[1] > bases[-1].shape[1] and n - wider.shape[1] - 1 >= LEFT:
            bases.append(wider)
    return FeatureTest(feature, ground, tuple(bases))


def _with_waves(base: Array, ground: Ground, most: int) -> Array:
    """Extend the base by the longest waves of the surface, by the sum of their numbers around and along, up to `most` columns."""
    waves = ground.waves[-1]
    number = np.add.outer(np.arange(AROUND + 1), np.arange(ALONG + 1)).ravel()
    order = np.argsort(np.tile(number, 4), kind="stable")
    room = np.empty((len(base), max(most, base.shape[1])))
    room[:, : base.shape[1]] = base
    k = base.shape[1]
    for i in order:
        if k >= most:
            break
        q = room[:, :k]
        left = waves[i] - q @ (q.T @ waves[i])
        left -= q @ (q.T @ left)
        if np.linalg.norm(left) > NEW * np.linalg.norm(waves[i]):
            room[:, k] = left / np.linalg.norm(left)
            k += 1
    return room[:, :k].copy()


def orthonormal(columns: Array) -> Array:
    """Return an orthonormal base (n, k) of columns (n, m), without those that move no point."""
    scale = np.abs(columns).max(axis=0)
    used = columns[:, scale > 1e-9] / scale[scale > 1e-9]
    basis, sizes, _ = np.linalg.svd(used, full_matrices=False)
    return np.asarray(basis[:, sizes > 1e-9 * sizes[0]])


def outlier_scores(f: FeatureTest, d: Array) -> Iterator[tuple[int, Array, Array, Ints]]:
    """Yield, for departures d (m, n), number of the base, score (m,), size (m,) and place (m,) of the most suspicious point, stage by stage.

    Score: -log10 of n P(|t| > |t_i|), dof n - k - 1 - points taken out; size: distance of the point from the prediction of the others.
    """
    from scipy.special import stdtr

    for number, q in enumerate(f.bases):
        n, k = q.shape
        r, h = d - (d @ q) @ q.T, np.tile(1.0 - (q**2).sum(axis=1), (len(d), 1))
        out: list[Array] = []  # unit vectors (m, n): what taking out a point takes out
        rows = np.arange(len(d))
        for stage in range(int(np.clip(n // PER_OUTLIER, 1, STAGES))):
            dof = n - k - stage - 1
            if dof < LEFT:
                break
            is_visible = h > UNSEEN
            left = np.maximum((r**2).sum(axis=1, keepdims=True) - r**2 / np.maximum(h, UNSEEN), 1e-300)
            t = np.where(is_visible, np.abs(r) * np.sqrt(dof / (left * np.maximum(h, UNSEEN))), 0.0)
            at = t.argmax(axis=1)
            tail = 2.0 * (n - stage) * stdtr(dof, -t[rows, at])
            yield (
                number,
                -np.log10(np.maximum(tail, 1e-300)),
                r[rows, at] / np.maximum(h[rows, at], UNSEEN),
                at,
            )
            column = -(q[at] @ q.T)
            column[rows, at] += 1.0
            for v in out:
                column -= v * v[rows, at][:, None]
            v = column / np.sqrt(np.maximum(h[rows, at], 1e-12))[:, None]
            r, h = r - v * (v * r).sum(axis=1, keepdims=True), h - v**2
            out.append(v)
