"""Choose the association criteria of a characteristic and fit the elements by them: letters of ISO 1101, sizes of ISO 14405-1.

criterion        one letter for all features that are toleranced, or one for each ("T X"):
                 G C N X T (vcmm.part.fit.criteria.CRITERIA); GG is G.
datum_criterion  the same for the datums; G when left out.
of a size        GG GC GN GX, or local sizes: LP (two-point), LS (sphere), alone or with a rank (RANKS): "LP SX". A
                 local size without a rank means all of them: the value is the one farthest from the middle of
                 the limits (from nominal without limits), so that it is within them when all are.
of an orientation  none: of a plane or line the extracted surface, all its measured points between two planes (ISO 1101); a letter is
                 the modifier of ISO 1101 for the associated element: C minimax, G least squares, T tangential
of a form        the reference element, G C N X: the value is the range of the distances from it (C: minimum zone).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError, choose_from
from vcmm.core.pose import Array
from vcmm.part.fit import CRITERIA, FittedElement, associate, profile_line, sphere_radii, two_point_radii
from vcmm.part.fit.criteria import check_criterion
from vcmm.part.part import Characteristic, Feature, frame, members

SIZES: dict[str, str] = {
    "GG": "least-squares size",
    "GC": "minimax size",
    "GN": "minimum circumscribed size",
    "GX": "maximum inscribed size",
    "LP": "two-point size, opposite points in sections",
    "LS": "size of the largest sphere in each section",
}
RANKS: dict[str, tuple[str, Callable[[Array], Array]]] = {
    "SX": ("largest", lambda v: v.max(axis=-1)),
    "SN": ("smallest", lambda v: v.min(axis=-1)),
    "SA": ("average", lambda v: v.mean(axis=-1)),
    "SM": ("median", lambda v: np.asarray(np.median(v, axis=-1))),
    "SD": ("mid-range", lambda v: 0.5 * (v.max(axis=-1) + v.min(axis=-1))),
    "SR": ("range", lambda v: v.max(axis=-1) - v.min(axis=-1)),
    "SQ": ("standard deviation", lambda v: v.std(axis=-1)),
}
LOCAL = {"LP": ("circle", "cylinder", "sphere"), "LS": ("circle", "cylinder")}
FORMS = ("straightness", "flatness", "roundness", "cylindricity")
ORIENTATION_TYPES = ("parallelism", "perpendicularity", "angularity")
EXTRACTED_KINDS = ("plane", "line")  # surfaces, and lines on them: their points are the extracted feature
DEFAULT_CRITERION = "GG"  # the criterion of a characteristic that names none
POINTS = "points"  # asked for like a criterion: the measured points themselves
ON_POINTS = ("circular_runout", "total_runout", "line_profile", "surface_profile")


@dataclass(frozen=True)
class ChosenCriteria:
    """Criterion of each toleranced feature and of each datum; `rank` of a local size, "" for all of them."""

    of: tuple[str, ...]
    datums: tuple[str, ...]
    rank: str = ""
    fit: str = "G"  # of points or patterns within what the datums leave free, or of a filtered profile

    @property
    def gauss(self) -> bool:
        return set(self.of) | set(self.datums) <= {"G"}


def choose_criteria(c: Characteristic) -> ChosenCriteria:
    """Parse the criteria of a characteristic. Raises UsageError for words without a meaning here."""
    words = c.criterion.split()
    if not c.datums and c.datum_criterion.split() not in (["G"], ["GG"]):
        raise UsageError(f'"{c.name}": datum_criterion is given, but no datums. Name them, or leave it out.')
    if c.type == "size":
        size, rank = _size(c, words)
        return ChosenCriteria((size,), (), rank)
    datums = _letters(c, "datum_criterion", c.datum_criterion.split(), len(c.datums))
    letters = _letters(c, "criterion", words, len(c.of) + len(c.between))
    if (
        c.type in ON_POINTS or c.filter is not None
    ):  # a filtered form: of the deviations from the Gauss element
        return ChosenCriteria(("G",) * len(letters), datums, fit=letters[0])
    return ChosenCriteria(letters, datums, fit=letters[0] if letters else "G")


def _size(c: Characteristic, words: list[str]) -> tuple[str, str]:
    size = {"G": "GG"}.get(words[0], words[0]) if words else ""
    if size not in SIZES:
        raise UsageError(f'"{c.name}": a size has no criterion "{size}".{choose_from(size, SIZES)}')
    if len(words) == 1:
        return (size if size in LOCAL else size[1]), ""
    if size not in LOCAL:
        raise UsageError(
            f'"{c.name}": "{c.criterion}": a rank goes with {" and ".join(LOCAL)}, not with {size}.'
        )
    if len(words) > 2 or words[1] not in RANKS:
        raise UsageError(
            f'"{c.name}": unknown rank "{words[1]}" of local sizes.{choose_from(words[1], RANKS)}'
        )
    return size, words[1]


def _paying(c: Characteristic, key: str, word: str) -> str:
    """Return the letter of a word: GG is G; beside a material requirement the size that provides the bonus may be named, GX of a bore, GN
    of a shaft."""
    mating = c.material and key == "criterion" and word in SIZES and word not in LOCAL
    return word[1] if mating or word == "GG" else word


def _letters(c: Characteristic, key: str, words: list[str], count: int) -> tuple[str, ...]:
    letters = tuple(_paying(c, key, word) for word in words)
    for letter in letters:
        if letter in SIZES:
            raise UsageError(
                f'"{c.name}": {key} = "{letter}" is a criterion of sizes; {c.type} takes {", ".join(CRITERIA)}'
                + (f" (for {letter}: {letter[1]})." if letter[1] in CRITERIA and letter not in LOCAL else ".")
            )
        if letter not in CRITERIA:
            raise UsageError(f'"{c.name}": unknown {key} "{letter}".{choose_from(letter, CRITERIA)}')
        if letter == "T" and c.type in FORMS:
            raise UsageError(f'"{c.name}": T is for orientation and location; {c.type} takes G, C, N or X.')
        if letter not in ("G", "C") and c.type in ON_POINTS and key == "criterion":
            raise UsageError(
                f'"{c.name}": {c.type} is evaluated on the points; criterion G or C says how they are fitted.'
            )
    if len(letters) not in (1, count) and count:
        raise UsageError(f'"{c.name}": {key} = "{" ".join(words)}" names {len(words)}; give one, or {count}.')
    return letters * count if len(letters) == 1 else letters


class HasKind(Protocol):
    """A feature, or an element fitted to one."""

    @property
    def kind(self) -> str: ...


def is_extracted(c: Characteristic, kind: str) -> bool:
    """Return whether an orientation is that of the extracted surface or line itself (ISO 1101), not of an element that a modifier names."""
    return c.type in ORIENTATION_TYPES and kind in EXTRACTED_KINDS and c.criterion == DEFAULT_CRITERION


def _demands(c: Characteristic, shapes: Mapping[str, HasKind]) -> Iterable[tuple[str, str]]:
    """Yield (feature, criterion) of all associations of a characteristic. shapes: features or elements with a kind each."""
    choice = choose_criteria(c)
    yield from zip((*c.of, *c.between), choice.of)
    for datum, letter in zip(c.datums, choice.datums):
        yield from ((name, letter) for name in members(c, datum))
    pointed = c.type in ON_POINTS or c.filter is not None
    yield from ((n, POINTS) for n in c.of if pointed or (n in shapes and is_extracted(c, shapes[n].kind)))
    if c.type in ("position", *ON_POINTS):  # by contact with a given orientation: anew, by the points
        yield from (
            (n, POINTS)
            for n, k in zip(c.datums[1:], choice.datums[1:])
            if k != "G" and n not in dict(c.common)
        )


def check_kinds(c: Characteristic, features: Mapping[str, Feature]) -> None:
    """Raise UsageError for a criterion that a feature of its kind does not have."""
    for name, criterion in _demands(c, features):
        if name not in features or criterion in ("G", POINTS):
            continue
        feature = features[name]
        if criterion in LOCAL and feature.kind not in LOCAL[criterion]:
            hint = '; the sphere itself is "GX"' if feature.kind == "sphere" else ""
            raise UsageError(
                f'"{c.name}": {criterion} is for {", ".join(LOCAL[criterion])}, not for a {feature.kind}{hint}.'
            )
        if criterion not in LOCAL:
            try:
                check_criterion(feature.kind, criterion, feature.inside)
            except UsageError as error:
                raise UsageError(f'"{c.name}", feature "{name}": {error}') from None


def criteria_needed(
    characteristics: Iterable[Characteristic], shapes: Mapping[str, HasKind]
) -> dict[str, tuple[str, ...]]:
    """Return the criteria other than G per feature, in alphabetical order; features without any are left out. shapes: features or elements."""
    out: dict[str, set[str]] = {}
    for c in characteristics:
        for name, criterion in _demands(c, shapes):
            if criterion != "G":
                out.setdefault(name, set()).add(criterion)
    return {name: tuple(sorted(letters)) for name, letters in out.items()}


def with_criteria(
    characteristics: Iterable[Characteristic],
    features: Mapping[str, Feature],
    points: Callable[[str], Array],
    fitted: Mapping[str, FittedElement],
    judged: bool = True,
    pointed: Collection[str] = (),
) -> dict[str, FittedElement]:
    """Return the Gauss elements, each with the elements by other criteria that the characteristics require, in `also`. pointed: features
    that keep their points.

    points: measured points (..., n, 3) of a feature by name, in the frame of the elements. judged: whether elements by
    contact are unique is judged (trials need not). ModelLimit, with the name of the feature: points that do not hold
    such an element.
    """
    out = dict(fitted)
    needs = criteria_needed(characteristics, features)
    for name in {**needs, **dict.fromkeys(pointed)}:
        if name not in fitted:
            continue
        criteria = {*needs.get(name, ()), *((POINTS,) if name in pointed else ())}
        try:
            also = {
                criterion: _associate(criterion, features[name], points(name), fitted[name], judged)
                for criterion in sorted(criteria)
            }
        except ModelLimit as error:
            raise ModelLimit(f'feature "{name}": {error}') from None
        out[name] = replace(fitted[name], also=also)
    return out


def _associate(
    criterion: str, feature: Feature, points: Array, base: FittedElement, judged: bool
) -> FittedElement:
    if criterion == POINTS:
        return replace(base, points=points)
    if criterion in LOCAL:
        radii = (two_point_radii if criterion == "LP" else sphere_radii)(points, base)
        return replace(base, sizes=radii)
    if feature.kind == "line":
        fit = profile_line(criterion, points, feature.axis, frame(feature)[0])
    else:
        fixed = feature.axis if feature.kind == "circle" else None
        fit = associate(
            feature.kind, criterion, points, base, fixed_axis=fixed, inside=feature.inside, judged=judged
        )
    return replace(fit.element, unique=fit.unique)


def by_criterion(name: str, fitted: FittedElement, criterion: str) -> FittedElement:
    """Return the element by a criterion. Raises UsageError where it was not made: no other element takes its place."""
    if criterion == "G":
        return fitted
    if criterion not in fitted.also:
        raise UsageError(
            f'criterion "{criterion}" of "{name}" needs its measured points, which this calculation does not keep; '
            'measure, uncertainty and cut do. Use criterion = "G" here.'
        )
    return fitted.also[criterion]


def local_size(c: Characteristic, sizes: Array, nominal: float) -> Array:
    """Return one value (...) of local sizes (..., k) by the rank that the characteristic names."""
    rank = choose_criteria(c).rank
    if rank:
        return np.asarray(RANKS[rank][1](sizes))
    middle = nominal + (0.0 if c.limits is None else 0.5 * (c.limits[0] + c.limits[1]))
    worst = np.argmax(np.abs(sizes - middle), axis=-1)
    return np.take_along_axis(sizes, worst[..., None], axis=-1)[..., 0]


def notes(characteristics: Iterable[Characteristic], fitted: Mapping[str, FittedElement]) -> list[str]:
    """Return remarks on elements that touch the points and are not unique."""
    out = []
    for name, criteria in criteria_needed(characteristics, fitted).items():
        for criterion in criteria:
            fit = fitted[name].also.get(criterion) if name in fitted else None
            if fit is not None and fit.unique is not None and not fit.unique.all():
                out.append(
                    f"{name}: the element by criterion {criterion} ({CRITERIA[criterion]}) is not the only one: its size "
                    "or width holds, its place and direction are one of several as good; measure more points, or use G"
                )
    return out
