"""Evidence of every family at once: all columns side by side, whitened, and one matrix product per batch of residuals.

score of a family = ln mean over options of BF(option) + ln prior(family)     (nats; nothing scores 0)

Power of a recording: the amplitude of every effect at which it would be seen, and the invisible effects.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation import gaussian
from vcmm.answer.evaluation.gaussian import (
    SCALES,
    ColumnBlocks,
    Ints,
    Whitener,
    blocks,
    left_beside,
    log_evidence,
    without_span,
)
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family, Option, unseen_places
from vcmm.learn.diagnosis.constants import LEAST_FRACTION, SECURE_DELTA, UNSEEN, VANISHING_SHARE

BATCH = 256
MOST_SCORERS = 2  # scorers of one dictionary, each as large as the dictionary: the last ones used
IMPOSSIBLE = -700.0  # nats of a number that would have to be negative; exp of it is still a number


@dataclass(frozen=True, eq=False)
class Dictionary:
    """Families that this recording can show, their white columns, and what it cannot show.

    white (m, K), start (options,); first (families,): first option of each family; weight (options,): ln prior of the
    option within its family.
    """

    families: tuple[Family, ...]
    options: tuple[Option, ...]
    white: Array
    start: Ints
    first: Ints
    weight: Array
    dof: int
    invisible: tuple[str, ...]
    scorers: dict[bytes, Scorer] = field(default_factory=dict, init=False)  # see `scorer`

    @property
    def prior(self) -> Array:
        """ln prior (families,)."""
        return np.array([f.log_prior for f in self.families])

    @cached_property
    def unconditional(self) -> Scorer:
        """Scores of every family, given nothing: cached, since they are needed often."""
        size = np.add.reduceat((self.white**2).sum(axis=0), self.start)
        return Scorer(self, blocks(self.white, self.start), np.zeros((len(self.white), 0)), size)

    def of_family(self, family: int) -> range:
        """Return the numbers of the options of a family."""
        stop = self.first[family + 1] if family + 1 < len(self.first) else len(self.options)
        return range(int(self.first[family]), int(stop))

    def columns(self, option: int) -> Array:
        """Return white columns (m, k) of one option."""
        stop = self.start[option + 1] if option + 1 < len(self.start) else self.white.shape[1]
        return self.white[:, self.start[option] : stop]


def dictionary(families: Sequence[Family], white: Whitener) -> Dictionary:
    """Whiten the columns of all families; options and families that vanish are left out and named."""
    kept: list[Family] = []
    options: list[Option] = []
    parts: list[Array] = []
    first: list[int] = []
    whitened = iter(all_visible_columns([o.columns for f in families for o in f.options], white))
    for family in families:
        pairs = [(o, x) for o, x in zip(family.options, whitened) if x is not None]
        if pairs:
            first.append(len(options))
            kept.append(family)
            options += [o for o, _ in pairs]
            parts += [x for _, x in pairs]
    start = _starts(parts)
    columns = np.concatenate([np.zeros((len(white.weight), 0)), *parts], axis=1)
    names = {f.name for f in kept}
    lost = [f for f in families if not any(f is k for k in kept)]
    invisible = (
        *dict.fromkeys(f.name for f in families if f.name not in names),
        *unseen_places([f for f in lost if f.name in names], kept),
    )
    weight = _renormalise(np.array([o.log_prior for o in options]), np.array(first, dtype=np.intp))
    return Dictionary(
        tuple(kept),
        tuple(options),
        columns,
        start,
        np.array(first, dtype=np.intp),
        weight,
        white.dof,
        invisible,
    )


def dictionary_of_family(dictionary: Dictionary, family: int) -> Dictionary:
    """Return the dictionary of one family."""
    members = dictionary.of_family(family)
    a, b = members.start, members.stop
    low, high = (
        int(dictionary.start[a]),
        int(dictionary.start[b]) if b < len(dictionary.start) else dictionary.white.shape[1],
    )
    return replace(
        dictionary, families=(dictionary.families[family],), options=dictionary.options[a:b], white=dictionary.white[:, low:high],
        start=dictionary.start[a:b] - low, first=np.zeros(1, dtype=np.intp), weight=dictionary.weight[a:b],
    )  # fmt: skip


def visible_columns(columns: Array, white: Whitener) -> Array | None:
    """Return white columns, or None where nothing of them survives."""
    return all_visible_columns([columns], white)[0]


def all_visible_columns(parts: Sequence[Array], white: Whitener) -> list[Array | None]:
    """Return the same of many, in products of BATCH at once."""
    return [x for i in range(0, len(parts), BATCH) for x in _visible(parts[i : i + BATCH], white)]


def _visible(parts: Sequence[Array], white: Whitener) -> Iterator[Array | None]:
    columns = np.concatenate(parts, axis=1)
    before, after = white.scale(columns), white.apply(columns)
    start = _starts(parts)
    long = (np.sqrt(np.add.reduceat((x**2).sum(axis=0), start)) for x in (before, after))
    for i, part, size, left in zip(start, parts, *long):
        is_visible = left > VANISHING_SHARE * max(size, LEAST_FRACTION) and size > UNSEEN**2
        yield after[:, i : i + part.shape[1]] if is_visible else None


def _starts(parts: Sequence[Array]) -> Ints:
    """Return the first column of each of some blocks side by side."""
    return np.cumsum([0, *(x.shape[1] for x in parts)])[:-1].astype(np.intp)


def _renormalise(weight: Array, first: Ints) -> Array:
    if not len(first):
        return weight
    total = np.logaddexp.reduceat(weight, first)
    return weight - np.repeat(total, np.diff(np.append(first, len(weight))))


@dataclass(frozen=True, eq=False)
class Scorer:
    """A dictionary given some chosen columns: these are projected out of templates and residuals."""

    candidates: Dictionary
    blocks: ColumnBlocks
    basis: Array
    size: Array  # squared length of every option before projection

    @property
    def dof(self) -> int:
        return self.candidates.dof - self.basis.shape[1]

    @property
    def is_seen(self) -> npt.NDArray[np.bool_]:
        """Whether a column (K,) of an option keeps more than UNSEEN of the energy of the option."""
        whole = np.repeat(self.size, np.diff(np.append(self.blocks.start, len(self.blocks.size))))
        return np.asarray(self.blocks.size > UNSEEN * whole)

    def explained_energy(self, rest: Array) -> Array:
        """Return the sum of squares (options,) that each option explains of a white residual (m,) outside the basis."""
        square, is_seen = (self.blocks.column.T @ rest) ** 2, self.is_seen
        return np.add.reduceat(
            np.where(is_seen, square / np.where(is_seen, self.blocks.size, 1.0), 0.0), self.blocks.start
        )

    def options(self, r: Array) -> Array:
        """Return ln BF (options, M) for white residuals r (m, M)."""
        r = without_span(r, self.basis)
        parts = [
            log_evidence(self.blocks, r[:, i : i + BATCH], self.dof) for i in range(0, r.shape[1], BATCH)
        ]
        out = np.concatenate(parts, axis=1)
        square = [
            k
            for k, o in enumerate(self.candidates.options)
            if o.effect is not None and o.effect.diagnosis.is_never_negative
        ]
        against = self.candidates.white[:, self.candidates.start[square]].T @ r < 0
        out[square] = np.where(against, IMPOSSIBLE, out[square])
        return np.asarray(out)

    def families(self, options: Array) -> Array:
        """Return scores (families, M) from the options' (options, M)."""
        weighted = options + self.candidates.weight[:, None].astype(options.dtype)
        top = np.maximum.reduceat(weighted, self.candidates.first, axis=0)
        over = np.exp(
            weighted - np.repeat(top, np.diff(np.append(self.candidates.first, len(weighted))), axis=0)
        )
        total = np.add.reduceat(over, self.candidates.first, axis=0)
        return np.asarray(top + np.log(total) + self.candidates.prior[:, None])

    def scores(self, r: Array) -> Array:
        """Return the scores (families, M) of white residuals, batch by batch."""
        parts = [self.families(self.options(r[:, i : i + BATCH])) for i in range(0, r.shape[1], BATCH)]
        return np.concatenate(parts, axis=1)

    def largest(self, r: Array) -> Array:
        """Return the largest score (M,) of each of many white residuals, in single precision: to 0.001 nats in half the time."""
        column: Any = self.blocks.column.astype(np.float32)
        light = replace(self, blocks=replace(self.blocks, column=column))
        return np.asarray(light.scores(cast(Any, r.astype(np.float32))).max(axis=0), dtype=float)


def scorer(candidates: Dictionary, chosen: Array | None = None) -> Scorer:
    """Return scores of every family, given chosen white columns (m, k); the last one is cached, since each name is tested beside the others
    when it is pruned, exchanged, sharpened and judged.
    """
    if chosen is None or not chosen.shape[1]:
        return candidates.unconditional
    key = np.ascontiguousarray(chosen).tobytes()
    if key not in candidates.scorers:
        basis = orthonormal(chosen)
        while len(candidates.scorers) >= MOST_SCORERS:
            del candidates.scorers[next(iter(candidates.scorers))]  # the oldest
        rotated = blocks(without_span(candidates.white, basis), candidates.start)
        candidates.scorers[key] = Scorer(candidates, rotated, basis, candidates.unconditional.size)
    return candidates.scorers[key]


def orthonormal(x: Array) -> Array:
    """Return the orthonormal basis (m, p) of the span of white columns; directions below 1e-6 of the longest are dropped."""
    return gaussian.orthonormal(x, UNSEEN)


def best_mimic(candidates: Dictionary, family: int, signal: Array) -> int:
    """Return the number of the option of a family that repeats a white signal (m,) best."""
    return min(
        candidates.of_family(family),
        key=lambda k: float(np.sum(left_beside(signal, candidates.columns(k)) ** 2)),
    )


LARGEST = SCALES[-1]


@dataclass(frozen=True)
class Detectable:
    """effect at its best place; amplitude: rms over the recording, mm or rad; typical: the same in typical amplitudes."""

    effect: str
    where: dict[str, str]
    amplitude: float
    typical: float


def detectable_effects(
    candidates: Dictionary, sigma: float
) -> tuple[tuple[Detectable, ...], tuple[str, ...]]:
    """Return the smallest visible amplitude of every effect name; names and places that even LARGEST typical amplitudes do not show.

    sigma: noise in units of u. Of several shapes the median one counts (of equal ones the order of the list decides, not rounding), of several
    parameters the best seen.
    """
    best: dict[str, Detectable] = {}
    small: list[Family] = []
    large: list[Family] = []
    for i, family in enumerate(candidates.families):
        sizes = np.array([_largest(candidates.columns(o)) for o in candidates.of_family(i)])
        order = np.argsort(np.round(sizes / max(UNSEEN * sizes.max(), LEAST_FRACTION)), kind="stable")
        middle = int(candidates.first[i]) + int(order[len(sizes) // 2])
        typical = SECURE_DELTA * sigma / max(_largest(candidates.columns(middle)), LEAST_FRACTION)
        rms = typical * float(np.sqrt(np.mean(candidates.options[middle].columns ** 2, axis=0)).max())
        (small if typical > LARGEST else large).append(family)
        if family.name not in best or rms < best[family.name].amplitude:
            best[family.name] = Detectable(family.name, dict(family.where), rms, typical)
    shown = tuple(d for d in best.values() if d.typical <= LARGEST)
    hidden = tuple(d.effect for d in best.values() if d.typical > LARGEST)
    places = unseen_places([f for f in small if f.name not in hidden], large)
    return tuple(sorted(shown, key=lambda d: d.effect)), (*hidden, *places)


def _largest(x: Array) -> float:
    return float(np.sqrt((x**2).sum(axis=0).max()))
