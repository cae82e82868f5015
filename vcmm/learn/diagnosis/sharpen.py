"""Time constants, distances and periods of all competitors at their best, before names are compared.

A coarse grid of trial values decides nothing between two names that both need a value off the grid: with a strong signal the
half step that is missing costs tens of nats. So after a first search the names that explain most, given nothing and given all
chosen terms but one, get an option at their own best values, every shape of them (one lag or two); then the search runs again.

Such an option weighs as the cell of the grid that it stands in, times the share of the cell that the rows leave open:
sqrt(2 pi) s / width, s from the curvature of the evidence (Laplace's approximation of the mean over the cell).

Of a wave the highest lines of the spectrum are searched and not the highest alone: half a step off its best, the true line may
stand below a side lobe that the grid happens to hit. Lines that no trial period stands on come from the continuous spectrum (see spectrum).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Ints, without_span
from vcmm.core.effect import parameter_fields
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Option
from vcmm.learn.diagnosis.evidence import Dictionary
from vcmm.learn.diagnosis.periods import coordinate
from vcmm.learn.diagnosis.refine import scanned_names
from vcmm.learn.diagnosis.select import (
    Selection,
    Setting,
    Term,
    basis_of,
    conditional,
    family_scores,
    options_of,
)
from vcmm.learn.diagnosis.spectrum import lines_of

MOST = 6  # competitors that are looked at, given some terms
LINES = 3  # of a spectrum whose best values are searched: the highest on the grid may be a side lobe
LINE_SPACING = 0.75  # of 1 / range: two trial frequencies that are closer stand on one line
Sharp = tuple[int, Option, float]  # family, option at its best, ln weight within the family


def sharpen(setting: Setting, state: Selection) -> Setting:
    """The setting with further options; the same one where no competitor has a value to be searched."""
    if not setting.found.families:
        return setting
    new: dict[tuple[int, str, tuple[float, ...]], Sharp] = {}
    for given in _conditioning_sets(state):
        for sharp in _of_competitors(given, setting, state):
            values = tuple(
                round(float(np.log(getattr(sharp[1].effect, n))), 2) for n in scanned_names(sharp[1])
            )
            new.setdefault((sharp[0], type(sharp[1].effect).__name__, values), sharp)
    return replace(setting, found=_extend_dictionary(setting, list(new.values()))) if new else setting


def _conditioning_sets(state: Selection) -> list[Sequence[Term]]:
    every = range(len(state.terms))
    others = [[state.terms[j] for j in every if j != i] for i in every]
    return [[], *(o for o in others if o)]


def _of_competitors(given: Sequence[Term], setting: Setting, state: Selection) -> list[Sharp]:
    options = conditional(given, state, setting)
    scores = family_scores(setting.found, options)
    taken = {t.family.id for t in given}
    order = [int(j) for j in np.argsort(-scores, kind="stable") if scores[j] > setting.threshold]
    asked = [j for j in order if setting.found.families[j].id not in taken and _has_scans(setting.found, j)]
    basis = basis_of(given, len(state.y))
    r = without_span(state.y, basis)
    listed = [s for j in asked[:MOST] for s in _of_family(j, options, r, basis, setting)]
    waves = [j for j in range(len(scores)) if setting.found.families[j].id not in taken]
    return listed + [s for j in waves for s in _off_the_list(j, r, basis, setting)]


def _off_the_list(j: int, r: Array, basis: Array, setting: Setting) -> list[Sharp]:
    """The highest lines of the spectrum that no trial period of a family stands on, at their best values."""
    own = [setting.found.options[k] for k in options_of(setting.found, j)]
    wave = next((o for o in own if _is_wave(o)), None)
    if wave is None:
        return []
    refine = setting.refine
    known = [f for o in own if (f := _frequency(o, setting)) is not None]
    found = lines_of(wave, r, basis, setting.white, refine.problem, setting.threshold, known, LINES)
    sharp = [(refine(option, r, basis), weight) for option, weight in found]
    return [(j, option, weight + refine.open_share(option, r, basis)) for option, weight in sharp]


def _is_wave(option: Option) -> bool:
    """A sine and a cosine of one period that is to be searched, once per period."""
    effect = option.effect
    single = effect is not None and {"sine", "cosine"} <= {f.name for f in parameter_fields(effect)}
    return single and "period" in scanned_names(option) and int(getattr(effect, "harmonic", 1)) == 1


def _has_scans(found: Dictionary, j: int) -> bool:
    return any(scanned_names(found.options[k]) for k in options_of(found, j))


def _of_family(j: int, options: Array, r: Array, basis: Array, setting: Setting) -> list[Sharp]:
    """The best options of every shape of a family, at their best values: one, or of a spectrum the highest lines."""
    found = setting.found
    shapes: dict[str, list[int]] = {}
    for k in sorted(options_of(found, j), key=lambda k: -float(options[k])):
        if scanned_names(found.options[k]):
            shapes.setdefault(type(found.options[k].effect).__name__, []).append(k)
    out = []
    for k in (k for own in shapes.values() for k in _lines(own, setting)):
        option = setting.refine(found.options[k], r, basis)
        out.append((j, option, float(found.weight[k]) + setting.refine.open_share(option, r, basis)))
    return out


def _lines(own: Sequence[int], setting: Setting) -> list[int]:
    """Of options in the order of their evidence the first, and of waves the first on LINES different lines."""
    kept: list[int] = []
    for k in own:
        wave = _frequency(setting.found.options[k], setting)
        others = [_frequency(setting.found.options[i], setting) for i in kept]
        if not kept or (
            wave is not None and all(o is not None and abs(wave - o) > LINE_SPACING for o in others)
        ):
            kept.append(k)
        if len(kept) == LINES or wave is None:
            break
    return kept


def _frequency(option: Option, setting: Setting) -> float | None:
    """Periods within the range of the places; None where the option has none to be searched."""
    if option.effect is None or "period" not in scanned_names(option):
        return None
    q = coordinate(option.effect, setting.refine.problem.run)
    period = float(getattr(option.effect, "period")) / int(getattr(option.effect, "harmonic", 1))  # noqa: B009
    return None if q is None else float(np.ptp(q)) / period


def _extend_dictionary(setting: Setting, new: Sequence[Sharp]) -> Dictionary:
    """The dictionary with further options, each beside the others of its family."""
    found = setting.found
    options: list[Option] = []
    columns: list[Array] = []
    weight: list[float] = []
    first: list[int] = []
    for j in range(len(found.families)):
        first.append(len(options))
        own = options_of(found, j)
        options += [found.options[k] for k in own]
        weight += [float(found.weight[k]) for k in own]
        stop = int(found.start[own[-1] + 1]) if own[-1] + 1 < len(found.start) else found.white.shape[1]
        columns.append(found.white[:, int(found.start[own[0]]) : stop])
        for _, option, share in (s for s in new if s[0] == j):
            options.append(option)
            weight.append(share)
            columns.append(setting.white.apply(option.columns))
    widths = [o.columns.shape[1] for o in options]
    start: Ints = np.cumsum([0, *widths])[:-1].astype(np.intp)
    families = tuple(
        replace(f, options=tuple(options[k] for k in range(a, b)))
        for f, a, b in zip(found.families, first, [*first[1:], len(options)])
    )
    return replace(
        found, families=families, options=tuple(options), white=np.concatenate(columns, axis=1), start=start,
        first=np.array(first, dtype=np.intp), weight=np.array(weight),
    )  # fmt: skip
