"""Weigh names against physics without a name: test whether a smooth field explains more than some of them.

A name with many free numbers, or two names together, can follow signals of other causes: a scale glued from pieces looks
much like a changed guide, or like the gaps of a table. The unknown gets the same freedom. Its law is a Gaussian process (see
kernels) over a covariate that the residual follows, with or without the other names; its evidence is the mean over its
smoothness and size, and it pays VERY_STRONG nats, since the catalogue holds what machines usually have. The shapes of the localisation
are in the same list and share the prior of one name, which is their price.

    S(names, field) = evidence(names, field) - price(names) - price(field) - mismatch - [the threshold, where names are left out]
    p(name) = sum of exp S of what was weighed with it / sum of exp S of all that was weighed

price: the prior of places and scanned values of the names, and the threshold for each of them; the unknown is one hypothesis, while several
names that together follow one smooth course are a coincidence. Weighed are the names with
nothing beside them, and every subset of them beside each of the fields and shapes that explain most, or with nothing but these.

The names of the best are kept. Where all are, the field is no rival: it is the residual.

A field or a shape has no part that a simple name has: what is linear (a scale, a squareness), a wave of one period or a step that is named is outside its span (Plumlee,
J. Am. Stat. Assoc. 112 (2017) 1274: orthogonal discrepancy). A course in time that no column records is a field: the part warms smoothly where a step is fitted to it, so a step and a straight drift
keep their whole part of a smooth course in time. Nor does it lie over the axis of a named change of geometry, which is as free as itself.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Ints, Whitener, evidence_from, posterior
from vcmm.core.effect import required
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.constants import SUREST, UNSEEN, VANISHING_SHARE, VERY_STRONG
from vcmm.learn.diagnosis.evidence import Dictionary, orthonormal, scorer
from vcmm.learn.diagnosis.kernels import (
    KernelTest,
    all_kernels,
    component_kernels,
    components_of,
    kernel_tests,
    principal_coefficients,
    propose_unknown,
    pull_back,
    time_kernels,
)
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import MOMENTS, scanned_names
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.select import (
    SelectedTerm,
    Selection,
    Setting,
    all_but_one,
    best_option,
    mismatch,
    white_columns,
)
from vcmm.learn.diagnosis.unknown_shapes import describe_family
from vcmm.physics.structure.geometric_change import GeometricChange

TRIAL_KERNELS = 8  # kernels that the residual follows most
SHORT = 4  # fields that are weighed with every subset of the names
NULLS = 200
COUNTS = (10, 20, 40, 80)  # principal functions: the fewer, the smoother
WIDTHS = (0.125, 0.5, 2.0, 8.0)  # of the first function, in units of the noise
WAVE = 2  # numbers of a wave: a cosine and a sine

Subset = tuple[int, ...]


@dataclass(frozen=True)
class Hypothesis:
    """Some names, by their ids, with a field or without. score: S, nats."""

    names: frozenset[str]
    score: float


def probability_left(name: str, weighed: Sequence[Hypothesis]) -> float:
    """Return the probability of a name: the share of the hypotheses that contain it."""
    has = [np.array([h.score for h in weighed if (name in h.names) is with_it]) for with_it in (True, False)]
    mine, others = (float(np.logaddexp.reduce(np.append(s, -np.inf))) for s in has)
    return float(1.0 / (1.0 + np.exp(min(others - mine, SUREST))))


@dataclass(frozen=True, eq=False)
class Field:
    """A field instead of the terms with the numbers `superfluous`. lead: nats beyond theirs and the price; shares: probability left to each."""

    lead: float
    unknown: Unknown
    superfluous: Subset
    columns: Array  # (m, k) of the observation, mm or rad: covariance = columns @ columns.T
    shares: tuple[float, ...] = ()

    @property
    def is_probable(self) -> bool:
        """Whether it is more probable than the names without it."""
        return self.lead > 0

    @property
    def replaces_names(self) -> bool:
        """Whether it is more probable than some names, and makes them superfluous."""
        return self.is_probable and bool(self.superfluous)


def rival_field(
    problem: Problem,
    selection: Selection,
    setting: Setting,
    null: Array,
    generic: Dictionary | None = None,
) -> Field | None:
    """Return the best field and the names that it makes superfluous, if any; None where the rows show no field. null (m, M):
    white null recordings; generic: shapes that compete too.
    """
    white, threshold = setting.white, setting.threshold
    every = tuple(range(len(selection.terms)))
    pays = [threshold - t.family.log_prior - t.option.log_prior for t in selection.terms]
    net = (selection.fit.log_evidence if selection.fit else 0.0) - sum(pays)
    price = mismatch(selection)

    def score(w: _Weighing, kept: Subset) -> float:
        """S: a field beside all names is what they leave, and instead of some it is one more name."""
        instead = threshold if kept != every else 0.0
        return w.evidence(kept) - sum(pays[i] for i in kept) - instead - price

    few = [(), *(tuple(j for j in every if j != i) for i in every)]
    fields = heapq.nlargest(
        SHORT,
        _field_weighings(problem, selection, setting, null),
        key=lambda w: max(score(w, kept) for kept in few),
    )
    shapes = [] if generic is None else _shape_weighings(generic, selection, setting)
    if not (fields or (shapes and every)):
        return None
    choices = [*itertools.product([*fields, *shapes], _subsets(every))]
    scores = [score(w, kept) for w, kept in choices]
    ids = [t.family.id for t in selection.terms]
    weighed = (
        Hypothesis(frozenset(ids), net),
        *(Hypothesis(frozenset(ids[i] for i in kept), s) for (_, kept), s in zip(choices, scores)),
    )
    # a shape beside all names competes with them in the list; the test of the residual reports it
    rivals = [w in fields or kept != every for w, kept in choices]
    best = int(np.argmax(np.where(rivals, scores, -np.inf)))
    w, kept = choices[best]
    refused = tuple(i for i in every if i not in kept)
    says = "explains more than {}, which add little to it" if refused else "beside which the names stand"
    sigma = selection.fit.sigma if selection.fit else 1.0
    return Field(
        scores[best] - net,
        w.describe(problem, selection, kept, white, says),
        refused,
        w.covariance(kept, sigma, setting),
        tuple(probability_left(i, weighed) for i in ids),
    )


def _field_weighings(
    problem: Problem, selection: Selection, setting: Setting, null: Array
) -> list[_Weighing]:
    """Return the fields that the residual follows most, without their part in the span of simple names."""
    of_place, of_both = (_simple_columns(selection, setting, timed) for timed in (True, False))
    out = []
    for question in _trial_kernels(problem, selection, setting.white, null):
        is_course = {n for k in question.kernels for n in k.names} == {"time"}  # over the clock alone
        simple = of_place if is_course else of_both
        w = _Weighing.of_kernels(question, simple, selection, setting.white)
        out += [w] if w is not None else []
    return out


def _simple_columns(selection: Selection, setting: Setting, timed: bool) -> Array:
    """What the simple names do to the observation (m, p); timed: those of the clock alone left out."""
    simple = (t.option for t in selection.terms if is_simple(t) and not (timed and _is_of_time(t)))
    return _columns([*simple], setting)


def is_simple(term: SelectedTerm) -> bool:
    """Return whether a term is one number in proportion to a recorded quantity, a wave and its harmonics, or a step; not a course with a
    time constant."""
    effect = term.option.effect
    waves = term.white.shape[1] <= WAVE or (effect is not None and effect.diagnosis.size_name == "amplitude")
    return waves and set(scanned_names(term.option)) <= {"period", *MOMENTS}


def _is_of_time(term: SelectedTerm) -> bool:
    """Return whether a term is a step or a straight drift: a course of the clock alone."""
    effect = term.option.effect
    return effect is not None and required(effect) == ("time_s",)


def _columns(options: Sequence[Option], setting: Setting) -> Array:
    """Return the effect of options on the observation (m, p)."""
    return np.concatenate([setting.raw[:, None][:, :0], *(o.columns for o in options)], axis=1)


def remove_simple_part(columns: Array, simple: Array, white: Whitener) -> Array:
    """Return columns (m, k) of the observation without the part in the span of simple ones (m, p), as the rows see it."""
    if not simple.shape[1]:
        return columns
    x = white.apply(simple)
    length = np.linalg.norm(x, axis=0)
    is_visible = length > VANISHING_SHARE * np.linalg.norm(white.scale(simple), axis=0)
    x, simple = x[:, is_visible] / length[is_visible], simple[:, is_visible] / length[is_visible]
    return np.asarray(columns - simple @ np.linalg.lstsq(x, white.apply(columns), rcond=UNSEEN)[0])


def _curve_axes(selection: Selection) -> set[str]:
    """Return the axes whose change of geometry is named, by one free curve: a field over such an axis is the same once more. Another
    free curve of the component claims a structure, and a field may do without it.
    """
    free = [
        t for t in selection.terms if t.option.effect is not None and t.option.effect.diagnosis.is_free_curve
    ]
    places = [str(t.family.where.get("component", "")) for t in free]
    alone = [
        t for t, p in zip(free, places) if t.family.name == GeometricChange.name and places.count(p) == 1
    ]
    return {str(t.family.where["component"])[2:] for t in alone}


def _subsets(every: Subset) -> Iterator[Subset]:
    return itertools.chain.from_iterable(itertools.combinations(every, k) for k in range(len(every) + 1))


@dataclass(frozen=True, eq=False)
class _Weighing:
    """One field, or shape, beside the names. gram, b: products of all white columns, the names' first, and the residual.

    counts, sizes: numbers of functions and prior widths that share its evidence; prior: ln.
    """

    source: KernelTest | tuple[Dictionary, int]  # kernels, or a family of shapes
    functions: Array
    effects: Array  # what the functions are of the observation (m, k), mm or rad
    y: Array
    gram: Array
    b: Array
    dof: int
    spans: tuple[Ints, ...]
    widths: tuple[Array, ...]
    counts: tuple[int, ...] = COUNTS
    sizes: tuple[float, ...] = WIDTHS
    prior: float = 0.0

    @staticmethod
    def of_kernels(
        question: KernelTest, simple: Array, selection: Selection, white: Whitener
    ) -> _Weighing | None:
        """Return the weighing; None where nothing of the field is seen. simple (m, p): effect of simple names on the observation."""
        bumps = np.concatenate([k.bumps * k.factor[:, None] for k in question.kernels], axis=1)
        free = remove_simple_part(bumps, simple, white)
        x = white.apply(free)
        turn = principal_coefficients(x, COUNTS[-1])
        if turn is None or np.linalg.norm(x) <= VANISHING_SHARE * np.linalg.norm(white.scale(bumps)):
            return None
        columns = free @ turn
        weighing = _Weighing.beside(selection, question, white.apply(columns), columns, white.dof)
        return replace(weighing, prior=-VERY_STRONG)

    @staticmethod
    def of_shape(
        generic: Dictionary, family: int, option: int, simple: Array, selection: Selection, white: Whitener
    ) -> _Weighing | None:
        """Return the weighing of a shape of the localisation; None where simple names contain it."""
        columns = generic.options[option].columns
        free = remove_simple_part(columns, simple, white)
        x = white.apply(free)
        if np.linalg.norm(x) <= VANISHING_SHARE * np.linalg.norm(white.scale(columns)):
            return None
        prior = generic.families[family].log_prior + float(generic.weight[option])
        weighing = _Weighing.beside(selection, (generic, family), x, free, generic.dof)
        return replace(weighing, counts=(x.shape[1],), sizes=SCALES, prior=prior)

    @staticmethod
    def beside(
        selection: Selection,
        source: KernelTest | tuple[Dictionary, int],
        functions: Array,
        effects: Array,
        dof: int,
    ) -> _Weighing:
        """Return the weighing. functions (m, k) white, and the same on the observation."""
        whole = np.concatenate([*(t.white for t in selection.terms), functions], axis=1)
        spans = tuple(np.arange(whole.shape[1])[selection.span(i)] for i in range(len(selection.terms)))
        widths = tuple(np.full(t.white.shape[1], t.width) for t in selection.terms)
        gram, b = whole.T @ whole, whole.T @ selection.y
        return _Weighing(source, functions, effects, selection.y, gram, b, dof, spans, widths)

    def evidence(self, kept: Subset) -> float:
        """Return the nats of the field and some of the names, the mean over the smoothness and size of the field."""
        out = [nats for nats, _, _ in self._at_sizes(kept)]
        return self.prior + float(np.logaddexp.reduce(out) - np.log(len(out)))

    def covariance(self, kept: Subset, sigma: float, setting: Setting) -> Array:
        """Return columns (m, k) of the observation at the smoothness and size of highest evidence, without the part of any simple name of
        the catalogue; sigma: noise over stated.
        """
        _, count, width = max(self._at_sizes(kept))
        options = (
            o for o in setting.candidates.options if o.effect is not None and o.effect.diagnosis.is_uniform
        )
        simple = _columns([o for o in options if o.columns.shape[1] == 1], setting)
        return width * sigma * remove_simple_part(self.effects[:, :count], simple, setting.white)

    def _at_sizes(self, kept: Subset) -> list[tuple[float, int, float]]:
        """Return nats, number of functions and prior width of each."""
        names = [self.spans[i] for i in kept]
        first = len(self.b) - self.functions.shape[1]
        total = float(self.y @ self.y)
        out = []
        for count, width in itertools.product(self.counts, self.sizes):
            field = np.arange(first, min(first + count, len(self.b)))
            at = np.concatenate([*names, field])
            widths = np.concatenate([*(self.widths[i] for i in kept), np.full(len(field), width)])
            nats = evidence_from(self.gram[np.ix_(at, at)], self.b[at], total, self.dof, widths)
            out.append((nats, count, width))
        return out

    def describe(
        self, problem: Problem, selection: Selection, kept: Subset, white: Whitener, says: str
    ) -> Unknown:
        """Return the field in words."""
        if isinstance(self.source, KernelTest):
            return propose_unknown(self.source.clearest, problem, self.rms(white), says)
        generic, family = self.source
        given = scorer(generic, white_columns([selection.terms[i] for i in kept]))
        options = given.options(selection.y[:, None])[:, 0]
        return describe_family(generic, given.basis, selection, white, (), family, options)

    def rms(self, white: Whitener) -> float:
        """Return the size of the field alone, mm or rad."""
        fits = [
            posterior(self.functions, self.y, self.dof, np.full(self.functions.shape[1], w)) for w in WIDTHS
        ]
        signal = self.functions @ max(fits, key=lambda f: f.log_evidence).mean
        return float(np.sqrt(np.mean((signal / white.weight) ** 2)))


def _trial_kernels(problem: Problem, selection: Selection, white: Whitener, null: Array) -> list[KernelTest]:
    """Return the kernels that the residual follows most clearly, nothing named or all names but one; and every smooth course of time, before which a
    finer bump that follows the scatter too may rank by its score but not by its evidence.
    """
    by_identity: dict[tuple[object, ...], KernelTest] = {}
    curves = _curve_axes(selection)
    for terms in ([], *all_but_one(selection.terms)):
        basis = orthonormal(np.concatenate([null[:, :0], *(t.white for t in terms)], axis=1))
        rows = pull_back(white, basis, np.column_stack([selection.y, null[:, :NULLS]]))
        over = itertools.chain(
            component_kernels(problem, components_of(selection.terms)), all_kernels(problem)
        )
        groups = (g for g in over if not any({n for k in g for n in k.names} == {axis} for axis in curves))
        clearest = heapq.nlargest(TRIAL_KERNELS, kernel_tests(groups, rows), key=lambda a: float(a.z[0]))
        for question in (*clearest, *([] if terms else kernel_tests(time_kernels(problem), rows))):
            key = tuple(
                (k.names, k.direction, k.component, k.what, k.bumps.tobytes()) for k in question.kernels
            )
            by_identity.setdefault(key, question)
    return list(by_identity.values())


def _covariates_of(family: Family) -> set[str]:
    """Return the covariate of a change of geometry or of a drift with a temperature: a freer curve over the same axis or the same
    thermometer is the same physics, better fitted.
    """
    if "sensor" in family.where:
        return {f"temp_{family.where['sensor']}"}
    axis = str(family.where.get("component", ""))[2:]
    free = any(o.effect is not None and o.effect.diagnosis.is_free_curve for o in family.options)
    return {axis, f"{axis} (periodic)"} if free else set()


def _shape_weighings(generic: Dictionary, selection: Selection, setting: Setting) -> list[_Weighing]:
    """Return the shapes that explain most alone or beside all names but one, without those that describe the same as a name."""
    if not generic.families:
        return []
    names = set[str]().union(*(_covariates_of(t.family) for t in selection.terms))
    weighings: dict[int, _Weighing | None] = {}
    simple = _simple_columns(selection, setting, timed=False)
    for terms in ([], *all_but_one(selection.terms)):
        given = scorer(generic, white_columns(terms))
        options = given.options(selection.y[:, None])
        scores = given.families(options)[:, 0]
        order = (int(k) for k in np.argsort(-scores, kind="stable") if generic.families[k].name not in names)
        for k in itertools.islice(order, SHORT):
            option = best_option(generic, options[:, 0], k)
            if option not in weighings:
                weighings[option] = _Weighing.of_shape(generic, k, option, simple, selection, setting.white)
    return [w for w in weighings.values() if w is not None]


def kept_terms(selection: Selection, field: Field) -> list[SelectedTerm]:
    """Return the terms that are kept beside the field."""
    return [t for i, t in enumerate(selection.terms) if i not in field.superfluous]
