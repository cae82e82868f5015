"""Infer true values of extreme characteristics: the belts of a task, their counted coverage, and the uncertainty that the machine adds.

`uncertainty`, `evaluate` and `audit` read extreme values (form, orientation, location, run-out, profile, sizes by contact)
with the same belts, which depend on the task alone, so the same indicated value has the same true value in all of them.
Belts reach to parts some times rougher than the indicated value; they are sampled when first needed, and cached.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from vcmm.answer.evaluation.additions import of_parts
from vcmm.answer.evaluation.belts import (
    Reading,
    UnitedInverse,
    coverage,
    inverse_of,
    lost_share,
    sorted_by_roughness,
)
from vcmm.answer.evaluation.ends import ends_u, inverses_without
from vcmm.answer.evaluation.form_family import KNOWN, OTHER
from vcmm.answer.evaluation.pairs import (
    MOST_FORM_RATIO,
    Drawing,
    Largest,
    Pairs,
    concatenate_pairs,
    families,
    prepare_drawing,
)
from vcmm.answer.evaluation.truth import Limits, Statement
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import POINTS, criteria_needed
from vcmm.part.part import Characteristic
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.task import Task

PARTS, BY_CONTACT = (6000, 24_000), (6000, 8000)  # drawn for the belts, between these as many as trials;
# fewer where elements by contact are searched in every one of them
NUMBERS = 6e6  # points of all parts for the belts, at most
COUNT_TRIALS = 600, 2000  # drawn anew to count, between these as many as trials
FIXED, FIXED_BLIND = (0.0, 20.0), (0.0, 6.0)  # form over noise, counted by themselves; of values alone
FIXED_RATIOS = (0.0, 6.0, 20.0)
EXCLUDED = 0.005  # a tenth of what an interval may miss: sizes of form that leave residuals as small no more often are not counted
LEAST_COVERAGE, LEAST_OTHER_COVERAGE = (
    0.93,
    0.90,
)  # least coverage for p = 95 % of parts of the family, and of another one
REACH = 3.0  # parts are drawn with forms up to so many times what was indicated
OFFSET_OVER_NOISE, FORM_OVER_NOISE = (
    20.0,
    1.0,
)  # over the noise: how far off, or how rough, the parts are for which U is stated
BLIND = 0.1  # of the true value: parts far off that indicate less are not seen
MOST_LOST = 0.02  # of the drawn parts may have no such element: fewer than what the quantiles tell
HIDDEN_FORM = (
    "the points hardly meet some forms: a part of any true value could indicate as little; more points help"
)
NO_ELEMENT = (
    "{:.0%} of the parts drawn with forms of up to {:.3g} um have no such element: the points span too little of the feature; "
    "measure more of it"
)
TOO_FEW = (
    "the coverage of the interval about the true value was counted and is too small: {:.0%} of drawn parts, {:.0%} of "
    "parts of another kind; more points help"
)


@dataclass(frozen=True, eq=False)
class CountedInverse:
    """The inverse of one characteristic with its counted coverage: of parts of the family, and of parts of another one."""

    inverse: Reading
    counted_coverage: tuple[float, float]
    without: Callable[[], tuple[Reading, ...]] = (
        tuple  # made of all drawn parts but a group, group after group
    )

    @cached_property
    def groups(self) -> tuple[Reading, ...]:
        """Inverses from which the uncertainty of the ends is estimated."""
        return self.without()

    def state(self, y: float, rest: float | None, p: float, limits: Limits | None) -> Statement:
        indicated, rests = np.array([y]), None if rest is None else np.array([rest])
        low, high = (float(end[0]) for end in self.inverse.interval(p, indicated, rests))
        within = None if limits is None else float(np.clip(self.inverse.within(*limits, y, rest), 0.0, 1.0))
        estimate = float(self.inverse.estimate(indicated, rests)[0])
        if self.blind(p):
            estimate, high = np.nan, np.inf
        u = ends_u(self.groups, p, indicated, rests)
        return Statement(estimate, (low, high), within, self.shortfall(p), self.counted_coverage, u)

    def blind(self, p: float) -> bool:
        """Return whether some parts, however far off, indicate next to nothing: then no indication bounds the true value."""
        return self.inverse.sight(p) < BLIND

    def shortfall(self, p: float) -> str:
        """Return why the coverage of the interval is not claimed; empty where it is."""
        if self.blind(p):
            return HIDDEN_FORM
        return "" if self.is_enough(p) else TOO_FEW.format(*self.counted_coverage)

    def is_enough(self, p: float) -> bool:
        """Return whether enough of the sampled parts of both kinds had their true value in the interval for p."""
        return self.counted_coverage[0] >= p - (0.95 - LEAST_COVERAGE) and self.counted_coverage[1] >= p - (
            0.95 - LEAST_OTHER_COVERAGE
        )


@dataclass(frozen=True)
class NoInverse:
    """The inverse of a characteristic that too many parts lack: its true value exists, and nothing else is known about it."""

    why: str

    def state(self, y: float, rest: float | None, p: float, limits: Limits | None) -> Statement:
        return Statement(np.nan, (-np.inf, np.inf), None, self.why)

    def shortfall(self, p: float) -> str:
        return self.why


@dataclass(frozen=True, eq=False)
class AddedUncertainty:
    """Uncertainty that the machine adds to one characteristic of parts that are off or rough: u and half of where p lie; by Input (m,),
    by the form."""

    u: float
    half: float
    by_input: Array
    by_form: float


FixedParts = tuple[tuple[int, ...], Sequence[Pairs]]  # numbers of characteristics, parts with their values
Reach = tuple[int, int]  # doublings of the largest form, and of the largest way out of place


def _doublings(over_noise: float) -> int:
    """Return how often MOST is doubled to be REACH times as large as the measured value."""
    ratio = REACH * over_noise / MOST_FORM_RATIO
    return max(int(np.ceil(np.log2(ratio))), 0) if ratio > 1.0 else 0


@dataclass(frozen=True, eq=False)
class Inversion:
    """Belts of the extreme characteristics of a task, number `numbers` of all, by how far they reach."""

    drawing: Drawing
    settings: Settings
    numbers: tuple[int, ...]
    _expected_pairs: dict[Reach, set[int]] = field(default_factory=dict, repr=False)
    _parts: dict[Reach, list[DrawnParts]] = field(default_factory=dict, repr=False)
    _inverses: dict[tuple[int, Reach, tuple[float, ...] | None], CountedInverse | NoInverse] = field(
        default_factory=dict, repr=False
    )
    _form_parts: dict[float, list[FixedParts]] = field(default_factory=dict, repr=False)

    def column(self, i: int) -> int:
        """Return the column of characteristic i of the task among those that parts are sampled for."""
        return self.numbers.index(i)

    def characteristic(self, i: int) -> Characteristic:
        return self.drawing.task.part.characteristics[self.column(i)]

    def reach(self, i: int, y: float, rest: float | None = None) -> Reach:
        """Return how often the largest form, and the largest departure of place, are doubled so that they are well beyond the
        indicated value. Orientation and location may be far off without any form: there the residuals say how rough the part may be.
        """
        c, drawing = self.characteristic(i), self.drawing
        unit, away = min(drawing.unit(n) for n in gps.needs(c)), drawing.away
        noise, attitude = min(drawing.noise[n] for n in gps.needs(c)), drawing.attitude  # less tells no more
        if not gps.is_one_sided(c):  # up to MOST times the noise, however rough the part is
            return (_doublings(MOST_FORM_RATIO / REACH * noise / unit), 0) if drawing.bound else (0, 0)
        if c.type in gps.LOCATED_TYPES:
            return _doublings(max(rest or 0.0, noise) / unit), _doublings(max(y, attitude) / away)
        both = _doublings(max(y, noise) / min(unit, away))
        return both, both

    def inverse(self, i: int, y: float, rest: float | None) -> CountedInverse | NoInverse:
        """Return the belt of characteristic i for an indicated value, mm or rad. rest: root mean square of the residuals, None: not known."""
        c = self.characteristic(i)
        reach = self.reach(i, y, rest)
        drawn, ratios = self.draw_parts(i, reach), None
        if rest is not None and sorted_by_roughness(c):
            ratios = tuple(r for r in FIXED if r == 0.0 or drawn.is_possible(r, i, rest))
        place = (i, reach, ratios)
        if place not in self._inverses:
            self._inverses[place] = _count_coverage(c, drawn.column(i), drawn, self.settings.p, ratios)
        return self._inverses[place]

    def expect(self, readings: Iterable[tuple[int, float, float | None]]) -> None:
        """Announce later requests (characteristic, indicated value, residuals): parts of one reach are then evaluated for these alone."""
        for i, y, rest in readings:
            if i in self.numbers:
                self._expected_pairs.setdefault(self.reach(i, y, rest), set()).add(i)

    def draw_parts(self, i: int, reach: Reach = (0, 0)) -> DrawnParts:
        """Return parts sampled with forms up to MOST 2^reach[0] times the noise, and departures of place by reach[1], with the values of
        characteristic i and of the others expected of such parts (all, where nothing was announced).
        """
        kept = self._parts.setdefault(reach, [])
        numbers_held = {n for parts in kept for n in parts.numbers}
        if i not in numbers_held:
            numbers = sorted({i} | (self._expected_pairs.get(reach, set(self.numbers)) - numbers_held))
            form, off = (MOST_FORM_RATIO * 2.0**n for n in reach)
            kept.append(DrawnParts(self, tuple(numbers), Largest(form, off)))
        return next(parts for parts in kept if i in parts.numbers)

    def parts_with_form(self, i: int, ratio: float) -> tuple[int, Sequence[Pairs]]:
        """Return the column of characteristic i in parts whose forms are all `ratio` times the noise, and these parts.

        They do not depend on the reach: all reaches share them.
        """
        kept = self._form_parts.setdefault(ratio, [])
        entry = next((pair for pair in kept if i in pair[0]), None)
        if entry is None:
            numbers_held = {n for pair in kept for n in pair[0]}
            expected = (
                set().union(*self._expected_pairs.values()) if self._expected_pairs else set(self.numbers)
            )
            numbers = tuple(sorted({i} | (expected - numbers_held)))
            entry = numbers, DrawnParts(self, numbers, ANY).with_form(ratio)
            kept.append(entry)
        return entry[0].index(i), entry[1]

    def added_uncertainty(self, i: int) -> AddedUncertainty:
        """Return the added uncertainty of parts without form that are far off for orientation and location, of parts as rough as the
        noise for the others.

        There the machine acts as on every part that is off by more; the difference of indicated and true value is the error.
        """
        u, half, by_input, by_form = (
            self._far if self.characteristic(i).type in gps.LOCATED_TYPES else self._draw_rough_parts
        )
        k = self.column(i)
        return AddedUncertainty(float(u[k]), float(half[k]), by_input[:, k], float(by_form[k]))

    @cached_property
    def _far(self) -> tuple[Array, Array, Array, Array]:
        return of_parts(self.drawing, self.settings, 0.0, OFFSET_OVER_NOISE, in_contact(self.drawing.task))

    @cached_property
    def _draw_rough_parts(self) -> tuple[Array, Array, Array, Array]:
        return of_parts(self.drawing, self.settings, FORM_OVER_NOISE, 0.0, in_contact(self.drawing.task))


@dataclass(frozen=True, eq=False)
class TrueValueByBelt:
    """The true value of characteristic i by its belt. rest: root mean square of the residuals, mm, None where no points are
    known; limit: why coverage may not be claimed in spite of the counts.
    """

    inversion: Inversion
    i: int
    rest: float | None = None
    limit: str = ""

    def state(self, y: float, p: float, kind: str, limits: Limits | None = None) -> Statement:
        statement = self.inversion.inverse(self.i, y, self.rest).state(y, self.rest, p, limits)
        return replace(statement, short=statement.short or self.limit)


ANY = Largest()


@dataclass(frozen=True, eq=False)
class DrawnParts:
    """Sampled parts of every kind up to `most`, sampled on demand; characteristics number `numbers` of the task."""

    inversion: Inversion
    numbers: tuple[int, ...]
    most: Largest
    _pairs: dict[str, Sequence[Sequence[Pairs]]] = field(default_factory=dict, repr=False)

    @cached_property
    def drawing(self) -> Drawing:
        return self.inversion.drawing.only([self.inversion.column(i) for i in self.numbers])

    @property
    def settings(self) -> Settings:
        return self.inversion.settings

    @property
    def count(self) -> int:
        return int(np.clip(self.settings.trials, *COUNT_TRIALS))

    def column(self, i: int) -> int:
        """Return the column of characteristic i of the task in `Pairs` of these parts."""
        return self.numbers.index(i)

    @property
    def own_families(self) -> Sequence[Pairs]:
        """Parts for the belts, one family after another, on machines at their limit."""
        return self.known_of_shares[-1]

    @property
    def known_of_shares(self) -> Sequence[Sequence[Pairs]]:
        """Parts for the belts on all machines that the bounds allow."""
        task = self.inversion.drawing.task  # as many parts for all characteristics
        few, many = BY_CONTACT if in_contact(task) else PARTS
        many = int(np.clip(NUMBERS / task.touches.run.n, few, many))
        count = int(np.clip(self.settings.trials, few, many)) // len(KNOWN)
        return self._families("known", count, self.settings.seed, most=self.most)

    @property
    def anew(self) -> Sequence[Pairs]:
        """Further parts of the same families, for counting, on all machines that the bounds allow."""
        drawn = self._families("anew", self.count // len(KNOWN), self.settings.seed + 1, most=self.most)
        return [pairs for of_share in drawn for pairs in of_share]

    @property
    def other_families(self) -> Sequence[Pairs]:
        """Parts of another kind, for counting."""
        drawn = self._families("other", self.count, self.settings.seed + 2, (OTHER,), self.most)
        return [of_share[0] for of_share in drawn]

    def with_form(self, ratio: float) -> Sequence[Pairs]:
        """Return parts whose forms are all `ratio` times the noise."""
        seed = self.settings.seed + 3 + FIXED_RATIOS.index(ratio)
        drawn = self._families(f"form {ratio:g}", self.count // len(KNOWN), seed, ratio=ratio)
        return [concatenate_pairs(of_share) for of_share in drawn]

    def is_possible(self, ratio: float, i: int, rest: float) -> bool:
        """Return whether parts whose form is so many times the noise leave residuals as small as the measured ones (root mean square, mm) more often
        than EXCLUDED: otherwise the part is none of them, and their coverage does not matter for it.
        """
        column, parts = self.inversion.parts_with_form(i, ratio)
        residuals = np.concatenate([pairs.rest[:, column] for pairs in parts])
        return bool((residuals <= rest).mean() >= EXCLUDED)

    def _families(
        self,
        what: str,
        count: int,
        seed: int,
        names: Sequence[str] = KNOWN,
        most: Largest = ANY,
        ratio: float | None = None,
    ) -> Sequence[Sequence[Pairs]]:
        """Return a list of families for every share of the machines, sampled once."""
        if what not in self._pairs:
            shares = self.drawing.machines.shares
            self._pairs[what] = families(
                self.drawing, count, seed, names=names, most=most, ratio=ratio, shares=shares
            )
        return self._pairs[what]


def inversion_of(task: Task, settings: Settings, numbers: Sequence[int]) -> Inversion:
    """Return the inversion for the extreme values of a task (characteristics number `numbers`)."""
    return Inversion(prepare_drawing(task, settings.seed, numbers), settings, tuple(numbers))


def in_contact(task: Task) -> bool:
    """Return whether a characteristic needs elements by contact, which take a hundred times as long as least squares."""
    contact = any(
        set(criteria) - {POINTS}
        for criteria in criteria_needed(task.part.characteristics, task.part.features).values()
    )
    return contact or any(c.filter is not None and c.criterion == "C" for c in task.part.characteristics)


def _count_coverage(
    c: Characteristic, k: int, drawn: DrawnParts, p: float, ratios: tuple[float, ...] | None
) -> CountedInverse | NoInverse:
    """Count the coverage. k: its column. ratios: read with the roughness of every part, as points show it, and the fixed sizes of form that
    it leaves possible;
    None: blind, from the value alone."""
    without = max(lost_share(k, pairs) for pairs in drawn.own_families)
    if without > MOST_LOST:
        largest = 1e3 * drawn.most.form * max(drawn.drawing.unit(n) for n in gps.needs(c))
        return NoInverse(NO_ELEMENT.format(without, largest))
    of_share = [inverse_of(c, k, families) for families in drawn.known_of_shares]
    inverse = of_share[0] if len(of_share) == 1 else UnitedInverse(tuple(of_share))
    blind = sorted_by_roughness(c) and ratios is None
    at = FIXED_BLIND if blind else FIXED if ratios is None else ratios
    coverages = [coverage(inverse, k, pairs, p, not blind) for pairs in drawn.anew]
    for ratio in at:
        column, parts = drawn.inversion.parts_with_form(drawn.numbers[k], ratio)
        coverages += [coverage(inverse, column, pairs, p, not blind) for pairs in parts]
    least, other = (
        min(coverages),
        min(coverage(inverse, k, pairs, p, not blind) for pairs in drawn.other_families),
    )
    return CountedInverse(inverse, (least, other), lambda: inverses_without(c, k, drawn.known_of_shares))
