"""Long recordings: which shapes of every candidate are worth comparing in all rows.

Most columns of a search are trial values of one number: hundreds of periods, moments, zones. In some of the rows (see thinning)
the whole catalogue is searched; of every candidate the KEPT shapes that explain most there, alone, beside everything that was found
and beside all of it but one, go on to the search in all rows. No candidate is left out, and the look elsewhere stays paid for: what was
dropped keeps its share of the prior.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family, rebuild_option
from vcmm.learn.diagnosis.evidence import Dictionary, dictionary, scorer
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.search import SearchResult
from vcmm.learn.diagnosis.select import Selection, Term

MOST_SHAPES = 5  # shapes of one candidate


def screen_families(chosen: SearchResult, whole: Problem) -> tuple[Family, ...]:
    """The candidates of a search with columns for the observations of `whole`, each with its best shapes only."""
    found, selection = chosen.stage.found, chosen.selection
    given = [_white(terms, selection) for terms in contexts(selection.terms)]
    scores = [scorer(found, x).options(selection.y[:, None])[:, 0] for x in given]
    best = (kept_of(found, i, scores) for i in range(len(found.families)))
    out = (_in_all_rows(family, whole) for family in best)
    return tuple(f for f in out if f.options)


def contexts(terms: Sequence[Term]) -> list[Sequence[Term]]:
    """Nothing, all terms, and all of several terms but one."""
    but_one = [[t for t in terms if t is not one] for one in terms] if len(terms) > 1 else []
    return [[], *([terms] if terms else []), *but_one]


def screened_shapes(
    families: Iterable[Family], chosen: SearchResult, whole: Problem, white: Whitener
) -> tuple[Family, ...]:
    """Shapes without physics over the observations of `whole`, family by family, each with its best only."""
    y = white.apply(whole.residual)
    columns = _seen_terms(chosen.selection, whole, white)
    return tuple(_best_shapes(families, y, [None, columns], white))


def _best_shapes(
    families: Iterable[Family], y: Array, given: Sequence[Array | None], white: Whitener
) -> Iterator[Family]:
    for family in families:
        found = dictionary([family], white)
        if found.families:
            yield kept_of(found, 0, [scorer(found, x).options(y[:, None])[:, 0] for x in given])


def kept_of(found: Dictionary, i: int, scores: Sequence[Array]) -> Family:
    """Family i with its best options by any of the scores (options,); its prior is less by what was dropped."""
    own = np.array(found.of_family(i))
    weight = found.weight[own]
    first = [own[np.argsort(-(s[own] + weight), kind="stable")[:MOST_SHAPES]] for s in scores]
    kept = np.unique(np.concatenate(first))
    share = float(np.logaddexp.reduce(found.weight[kept]))
    options = tuple(replace(found.options[k], log_prior=float(found.weight[k])) for k in kept)
    family = found.families[i]
    return replace(family, options=options, log_prior=family.log_prior + share)


def _in_all_rows(family: Family, whole: Problem) -> Family:
    made = (rebuild_option(o, whole) for o in family.options)
    return replace(family, options=tuple(o for o in made if o is not None))


def _white(terms: Sequence[Term], selection: Selection) -> Array | None:
    return np.concatenate([selection.y[:, None][:, :0], *(t.white for t in terms)], axis=1) if terms else None


def _seen_terms(selection: Selection, whole: Problem, white: Whitener) -> Array | None:
    """White columns (m, k) of the terms in all rows; None where there are none."""
    made = [rebuild_option(t.option, whole) for t in selection.terms]
    columns = [white.apply(o.columns) for o in made if o is not None]
    return np.concatenate(columns, axis=1) if columns else None
