"""Long recordings: names are searched in some of the rows, chosen evenly, and fitted to all of them.

Time and memory of a search grow with the rows, its power only with their root. So rows beyond LARGEST observations are
thinned for the search: one row at random of each stretch of successive rows (random, so that no wave is as long as the
step), of every pose, stylus and label and of every sense of the motion by itself. Rows that are few stay: of every label and
sense, and of every doubling of the distance from a reversal, FEWEST rows where there are so many. Every row keeps the data about
its past (senses, distances, logs of temperatures), and rows further apart agree less: the correlation of neighbours that the
search meets is theirs.

The choice follows the order of the rows in time (see row_order) and nothing else: neither the order of the file, nor units, nor the
words of labels. A note states the loss: an effect must be sqrt(all / searched) times as large to be found.

Long recordings: which shapes of every candidate are worth comparing in all rows.

Most columns of a search are trial values of one number: hundreds of periods, moments, zones. In some of the rows
the whole catalogue is searched; of every candidate the KEPT shapes that explain most there, alone, beside everything that was found
and beside all of it but one, go on to the search in all rows. No candidate is left out, and the look elsewhere stays paid for: dropped
shapes keep their share of the prior.

Recordings of millions of rows: the diagnosis takes MOST_OBSERVATIONS of their observations, with a note.

The information of a diagnosis grows with the root of the rows, its cost with the rows. So of more than MOST_OBSERVATIONS observations some are
taken before anything else: one at random of each stretch of successive rows, by the rule of vcmm.learn.diagnosis.thinning (every label and
sense by itself, rows near a reversal and rare labels in full), by the clock and not by the file. All that follows, held-out rows,
intervals and rms too, is computed from the taken rows: rows that were not taken are not fitted, and errors in them do no harm.
Every row keeps the data of the whole recording about its past (senses, distances, temperatures at its time). Logs of temperatures of
more than ENTRIES are means of ENTRIES stretches: at a day of 10^7 rows one every 4 s, where the quickest lag looked for is a minute.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation.gaussian import Ints, Whitener
from vcmm.core.run import Array, Run, Series, encode_labels
from vcmm.learn.diagnosis.candidates import Family, rebuild_option
from vcmm.learn.diagnosis.constants import FEWEST, LEAST_FRACTION
from vcmm.learn.diagnosis.evidence import Dictionary, dictionary, scorer
from vcmm.learn.diagnosis.problem import Problem, generator, make_problem
from vcmm.learn.diagnosis.row_order import rows_in_order
from vcmm.learn.diagnosis.search import SearchResult
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, all_but_one, white_columns
from vcmm.task.response.recording import Recording

Mask = npt.NDArray[np.bool_]
MOST_SCREENED = 2500  # observations in which the whole catalogue is searched
LARGEST = 10_000  # observations of any search


def thin_problem(problem: Problem, largest: int) -> Problem:
    """Return the problem with no more than about `largest` of its observations; the same one where it has no more.

    Nuisance parameters need rows too: ten for each, however many that are.
    """
    wanted = max(largest, 10 * problem.nuisance.shape[1])
    if problem.m <= wanted:
        return problem
    rows = np.unique(problem.recording.row)
    kept = np.zeros(problem.run.n, dtype=bool)
    kept[rows[choose_rows(problem.run.take(rows), wanted / problem.m)]] = True
    return make_problem(take_rows(problem.recording, kept), problem.machine)


def choose_rows(run: Run, share: float) -> Mask:
    """Return which rows (n,) of a run, in their order, make up about that share of it."""
    factors = list(_factors(run))
    group = np.zeros(run.n, dtype=np.intp)
    for codes in factors:
        finer = by_first_row(group * (codes.max() + 1) + codes)
        group = finer if share * run.n >= FEWEST * (finer.max() + 1) else group
    out = np.zeros(run.n, dtype=bool)
    order = np.argsort(group, kind="stable")
    out[order[one_per_stretch(run.n, round(share * run.n))]] = True
    for codes in [*factors, *_distances(run)]:
        _top_up(out, codes, share)
    return out


def _factors(run: Run) -> Iterator[Ints]:
    """Yield the codes (n,) of every label, and of the sense of every axis."""
    for name in sorted(run.labels):
        yield by_first_row(encode_labels(run.labels[name])[1])
    for name in sorted(c for c in run.columns if c.startswith("sense_")):
        yield by_first_row(run.columns[name].astype(np.intp) + 1)


def _distances(run: Run) -> Iterator[Ints]:
    """Yield the codes (n,) of the distance from the last reversal of every axis: how often it doubles up to the longest."""
    for name in sorted(c for c in run.columns if c.startswith("since_reversal_")):
        way = run.columns[name]
        halves = np.log2(max(float(way.max()), LEAST_FRACTION) / np.maximum(way, LEAST_FRACTION))
        yield by_first_row(np.minimum(halves, FEWEST).astype(np.intp))


def by_first_row(codes: Ints) -> Ints:
    """Return the codes (n,) counted in the order in which they first appear, so that names of labels do not matter."""
    _, first, number = np.unique(codes, return_index=True, return_inverse=True)
    rank = np.empty(len(first), dtype=np.intp)
    rank[np.argsort(first)] = np.arange(len(first))
    return rank[np.ravel(number)]


def one_per_stretch(n: int, count: int) -> Ints:
    """Return one number at random of each of `count` stretches of 0 ... n - 1, as equal as they can be."""
    edges = np.linspace(0, n, count + 1).astype(np.intp)
    draw: Array = generator(0, "rows that are searched").random(count)
    return np.asarray(edges[:-1] + (draw * np.diff(edges)).astype(np.intp), dtype=np.intp)


def _top_up(out: Mask, codes: Ints, share: float) -> None:
    """Set further rows so that every code has FEWEST of its rows, or all; unless that would be as many rows again."""
    if FEWEST * (codes.max() + 1) > share * len(codes):
        return
    have, of = np.bincount(codes[out], minlength=codes.max() + 1), np.bincount(codes)
    for code in np.flatnonzero((have < FEWEST) & (have < of)):
        left = np.flatnonzero((codes == code) & ~out)
        out[left[one_per_stretch(len(left), min(FEWEST - int(have[code]), len(left)))]] = True


def take_rows(recording: Recording, kept: Mask) -> Recording:
    """Return the observations at some of the run rows, the others gone; second ends stay."""
    some = recording.take(kept[recording.row])
    needed = kept.copy()
    needed[some.other[some.other >= 0]] = True
    place = np.cumsum(needed) - 1
    other = np.where(some.other >= 0, place[np.maximum(some.other, 0)], -1)
    lines = None if some.lines is None else some.lines[needed]
    unread = tuple((name, rows[needed]) for name, rows in some.unread)
    run = some.run.take(np.flatnonzero(needed))
    return replace(some, run=run, row=place[some.row], other=other, lines=lines, unread=unread)


def size_loss(searched: int, of: int) -> float:
    """Return how many times larger an effect must be to be found in some of the observations as in all, for white noise."""
    return float(np.sqrt(of / searched))


def thinning_text(searched: int, of: int, sizes_too: bool) -> str:
    """Return a sentence on the information that is lost."""
    sizes = (
        "sizes and intervals are computed from the same rows, because a field without a name is fitted with the names; rms of"
        " the written result is of all rows"
        if sizes_too
        else "sizes, intervals, held-out rows and rms are of all rows"
    )
    return (
        f"names were searched in {searched} of {of} observations, chosen evenly: an effect has to be {size_loss(searched, of):.1f} times"
        f" as large as with all of them to be found; {sizes}"
    )


SHAPES_KEPT = 5  # shapes of one candidate


def screen_families(chosen: SearchResult, whole: Problem) -> tuple[Family, ...]:
    """Return the candidates of a search with columns for the observations of `whole`, each with its best shapes only."""
    candidates, selection = chosen.stage.candidates, chosen.selection
    given = [white_columns(terms) for terms in contexts(selection.terms)]
    scores = [scorer(candidates, x).options(selection.y[:, None])[:, 0] for x in given]
    best = (best_options(candidates, i, scores) for i in range(len(candidates.families)))
    out = (_in_all_rows(family, whole) for family in best)
    return tuple(f for f in out if f.options)


def contexts(terms: Sequence[SelectedTerm]) -> list[Sequence[SelectedTerm]]:
    """Return nothing, all terms, and all of several terms but one."""
    return [[], *([terms] if terms else []), *all_but_one(terms)]


def screen_shapes(
    families: Iterable[Family], chosen: SearchResult, whole: Problem, white: Whitener
) -> tuple[Family, ...]:
    """Return the shapes without physics over the observations of `whole`, family by family, each with its best only."""
    y = white.apply(whole.residual)
    columns = _seen_terms(chosen.selection, whole, white)
    return tuple(_best_shapes(families, y, [None, columns], white))


def _best_shapes(
    families: Iterable[Family], y: Array, given: Sequence[Array | None], white: Whitener
) -> Iterator[Family]:
    for family in families:
        candidates = dictionary([family], white)
        if candidates.families:
            yield best_options(
                candidates, 0, [scorer(candidates, x).options(y[:, None])[:, 0] for x in given]
            )


def best_options(candidates: Dictionary, i: int, scores: Sequence[Array]) -> Family:
    """Return the family i with its best options by any of the scores (options,); its prior is less by what was dropped."""
    members = np.array(candidates.of_family(i))
    weight = candidates.weight[members]
    first = [members[np.argsort(-(s[members] + weight), kind="stable")[:SHAPES_KEPT]] for s in scores]
    kept = np.unique(np.concatenate(first))
    share = float(np.logaddexp.reduce(candidates.weight[kept]))
    options = tuple(replace(candidates.options[k], log_prior=float(candidates.weight[k])) for k in kept)
    family = candidates.families[i]
    return replace(family, options=options, log_prior=family.log_prior + share)


def _in_all_rows(family: Family, whole: Problem) -> Family:
    made = (rebuild_option(o, whole) for o in family.options)
    return replace(family, options=tuple(o for o in made if o is not None))


def _seen_terms(selection: Selection, whole: Problem, white: Whitener) -> Array | None:
    """Return the white columns (m, k) of the terms in all rows; None where there are none."""
    made = [rebuild_option(t.option, whole) for t in selection.terms]
    columns = [white.apply(o.columns) for o in made if o is not None]
    return np.concatenate(columns, axis=1) if columns else None


MOST_OBSERVATIONS = 100_000  # observations of a diagnosis
ENTRIES = 20_000  # of a log


def limit_observations(recording: Recording, most: int = MOST_OBSERVATIONS) -> Recording:
    """Return the recording with about `most` of its observations, or as it is where it has no more."""
    if recording.m <= most:
        return recording
    run = recording.run
    kept = _choose_rows(recording, most / recording.m)
    if recording.kind == "displacement":  # lengths are counted from the first row of a set-up
        kept[np.unique(run.copies("setup")[1], return_index=True)[1]] = True
    some = take_rows(recording, kept)
    series = {
        name: log if name.startswith("accel_") else average_log(log) for name, log in run.series.items()
    }
    return replace(
        some, run=replace(some.run, series=series), chosen_from=recording.chosen_from or recording.m
    )


def limit_together(recordings: Sequence[Recording], most: int = MOST_OBSERVATIONS) -> Sequence[Recording]:
    """Return the recordings that together have about `most` observations, each the same share of its own."""
    whole = sum(r.m for r in recordings)
    if whole <= most:
        return recordings
    return [limit_observations(r, max(most * r.m // whole, 1)) for r in recordings]


def _choose_rows(recording: Recording, share: float) -> Mask:
    """Return which run rows (n,) are taken: about that share of those that were observed, evenly in time."""
    run = recording.run
    observed = np.zeros(run.n, dtype=bool)
    observed[recording.row] = True
    rows = rows_in_order(run, recording)
    rows = rows[observed[rows]]
    as_it_is = np.array_equal(rows, np.arange(run.n))
    out = np.zeros(run.n, dtype=bool)
    out[rows[choose_rows(run if as_it_is else run.take(rows), share)]] = True
    return out


def average_log(log: Series, entries: int = ENTRIES) -> Series:
    """Return the log, or means of time and value over `entries` stretches of it: linear courses stay as they are."""
    n = len(log.time)
    if n <= entries:
        return log
    first = np.linspace(0, n, entries + 1).astype(np.intp)
    count = np.diff(first)
    return Series(*(np.add.reduceat(v, first[:-1]) / count for v in (log.time, log.value)))


def thinning_notes(recording: Recording) -> tuple[str, ...]:
    """Return a note on the rows taken and the loss, in words; nothing where all rows are there."""
    of = recording.chosen_from
    if not of:
        return ()
    time = recording.run.columns.get("time_s")
    apart = ""
    if time is not None and np.ptp(time) > 0:
        apart = f", on average {np.ptp(time) / max(recording.run.n - 1, 1):.3g} s apart"
    return (
        f'of {of} observations {recording.m} were taken, evenly over the rows{apart}; "all rows" are these. Intervals are up to'
        f" {size_loss(recording.m, of):.1f} times as wide as with all; what is shorter than the rows taken lie apart is not followed:"
        " for that, diagnose a shorter stretch of the recording",
    )
