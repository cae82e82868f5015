"""Monte Carlo over the linear model (or with exact trials) for the characteristics that need it.

Monte Carlo in blocks of trials: tallies of whole numbers, whose sum does not depend on the workers, the order of blocks or
the number of interruptions.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from vcmm import __version__
from vcmm.answer.evaluation.certify import out_of_range
from vcmm.answer.evaluation.exact import draw_inputs, exact_values
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.montecarlo import Summary, Term, adaptive, simulate
from vcmm.answer.evaluation.streams import copy_code
from vcmm.answer.evaluation.summary import Accumulator
from vcmm.core.blocks import Block, Progress, Sharing, blocks_of
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.part.gps.criteria import choose_criteria
from vcmm.task.measuring.settings import Settings

PackedAccumulator = dict[str, Any]
Count = Callable[[Any, Block], list[PackedAccumulator]]  # (job, block) -> one tally per characteristic


def sum_blocks(
    sharing: Sharing,
    key: str,
    count: Count,
    job: Any,
    blocks: Sequence[Block],
    progress: Callable[[float], None],
) -> list[Accumulator]:
    """Return the sum of all blocks, one accumulator per characteristic. Raises ShardDone where a share is wanted."""
    wanted = sharing.share.take(blocks) if sharing.share else blocks
    total = _Total(sum(n for _, n in wanted), progress)
    for block, tallies in sharing.run_blocks(key, count, job, {b: b for b in blocks}):
        total.add(block, tallies)
    return total.sums


class _Total:
    """Running total that adds tallies as they come."""

    def __init__(self, trials: int, progress: Callable[[float], None]) -> None:
        self.trials, self.progress, self.seen = trials, progress, 0
        self.sums: list[Accumulator] = []

    def add(self, block: Block, tallies: Iterable[PackedAccumulator]) -> None:
        accumulators = [unpack(t) for t in tallies]
        if not self.sums:
            self.sums = accumulators
        else:
            for mine, more in zip(self.sums, accumulators):
                mine.merge(more)
        self.seen += block[1]
        self.progress(self.seen / self.trials)


def pack(accumulator: Accumulator) -> PackedAccumulator:
    """Return the integers of an accumulator as JSON holds them; floats by their hexadecimal digits, so that no bit is lost."""
    bins = np.flatnonzero(accumulator.counts)
    return {
        "place": [accumulator.centre.hex(), accumulator.scale.hex()],
        "bins": bins.tolist(),
        "counts": accumulator.counts[bins].tolist(),
        "trials": accumulator.trials,
        "range": [accumulator.minimum.hex(), accumulator.maximum.hex()],
        "sums": [str(n) for n in accumulator.sums],
    }


def unpack(packed_sums: PackedAccumulator) -> Accumulator:
    """Return the accumulator that `pack` wrote."""
    centre, scale = (float.fromhex(text) for text in packed_sums["place"])
    low, high = (float.fromhex(text) for text in packed_sums["range"])
    out = Accumulator(centre, scale, trials=int(packed_sums["trials"]), minimum=low, maximum=high)
    out.counts[np.array(packed_sums["bins"], dtype=np.intp)] = packed_sums["counts"]
    out.take(*map(int, packed_sums["sums"]))
    return out


BUDGET_TRIALS = 20_000
EXACT_BLOCK = 500
PLACING = 8192  # trials that say where a histogram stands
WORK_BLOCK = 32 * 8192  # trials that a worker counts at a time: the same pieces as one process alone takes


class Sampler:
    """Draws q for a task and evaluates the characteristics; products of two Inputs are multiplied trial by trial."""

    def __init__(
        self,
        model: LinearModel,
        terms: Sequence[Term],
        settings: Settings,
        progress: Progress,
        sharing: Sharing | None = None,
    ) -> None:
        self.model, self.terms, self.settings, self.progress = model, terms, settings, progress
        self.sharing = sharing or Sharing()
        self.wide, self.values = with_products(model, terms)
        rows = self.wide[0].gain.shape[0] if self.wide else len(model.q0)
        self.start = np.concatenate([model.q0, np.zeros(rows - len(model.q0))])

    def summaries(self, needed: Sequence[int]) -> dict[int, Summary]:
        """Return the distribution of the chosen characteristics."""
        exact = self.settings.engine == "exact"
        self.progress("exact trials" if exact else "Monte Carlo", 0.0)
        if self.settings.digits and not exact:
            return {i: self._adaptive(i) for i in needed}
        size = EXACT_BLOCK if exact else WORK_BLOCK
        first = self.draw(0, min(EXACT_BLOCK if exact else PLACING, self.settings.trials))
        places = tuple(_place(column) for column in first[:, list(needed)].T)
        job = SampledJob(self.model, tuple(self.terms), self.settings, tuple(needed), places)
        text = "exact trials" if exact else "Monte Carlo"
        blocks = blocks_of(self.settings.trials, size)
        sums = sum_blocks(
            self.sharing, self._key(first, needed), count, job, blocks, partial(self.progress, text)
        )
        return {i: a.summary() for i, a in zip(needed, sums)}

    def _key(self, first: Array, needed: Sequence[int]) -> str:
        """Return the key of the job by its draws: the first values of all characteristics, gains, laws, seed, engine and version."""
        digest = hashlib.sha256(
            f"{__version__} {self.settings.seed} {self.settings.engine} {list(needed)}".encode()
        )
        digest.update(np.ascontiguousarray(first).tobytes())
        for term in self.wide:
            digest.update(
                f"{term.name} {term.gain.shape}".encode() + np.ascontiguousarray(term.gain).tobytes()
            )
        return digest.hexdigest()[:24]

    def draw(self, first: int, trials: int) -> Array:
        """Return characteristics (trials, C) of trials from `first` on, by the engine of the settings."""
        if self.settings.engine == "exact":
            trial_values = exact_values(
                self.model, draw_inputs(self.model, self.settings.seed, first, trials)
            )
            return (
                trial_values if self.terms else np.repeat(trial_values, trials, axis=0)
            )  # all alike where nothing is drawn
        return self._trials(first, trials)

    def tally(
        self, block: Block, needed: Sequence[int], places: Sequence[tuple[float, float]]
    ) -> list[Accumulator]:
        """Count the trials of one block."""
        accumulators = [Accumulator(*place) for place in places]
        first, trials = block
        if self.settings.engine == "exact":
            blocks: Iterable[Array] = [self.draw(first, trials)]
        else:
            draws = simulate(
                self.start,
                self.wide,
                seed=self.settings.seed,
                trials=trials,
                first=first,
                of=self.settings.trials,
            )
            blocks = map(self._values, draws)
        for values in blocks:
            for i, accumulator in zip(needed, accumulators):
                accumulator.add(values[:, i])
        return accumulators

    def _values(self, block: Array) -> Array:
        """Return characteristics of a block of draws. A ModelLimit there means useless draws, not a wrong pose."""
        try:
            return self.values(block)
        except ModelLimit as error:
            raise out_of_range(error) from None

    def _trials(self, first: int, count: int) -> Array:
        blocks = simulate(self.start, self.wide, seed=self.settings.seed, trials=count, first=first)
        return np.concatenate([self._values(b) for b in blocks])

    def _adaptive(self, i: int) -> Summary:
        """Run the adaptive Monte Carlo of JCGM 101, 7.9; a pilot fixes the tolerance, so that it cannot jump."""
        self.progress(f"adaptive Monte Carlo, {self.settings.digits} digits", 0.5)
        u0 = float(self._trials(0, 8192)[:, i].std())
        chosen = self.settings
        return adaptive(
            lambda first, count: self._trials(first, count)[:, i],
            digits=chosen.digits, p=chosen.p, kind=chosen.kind, u0=max(u0, 1e-15),
        )  # fmt: skip

    def alone(self) -> Array:
        """Return the standard deviation with one Input at a time over that with all, on the same draws (terms, C).

        A non-linear output has no sensitivity coefficient; the interaction of the inputs is `interaction`.
        """
        trials = min(BUDGET_TRIALS, self.settings.trials)
        total = self._spread(self.wide, trials, self.start, self.values)
        out = []
        for done, term in enumerate(self.terms):
            self.progress("budget", done / len(self.terms))
            out.append(self._spread([term], trials, self.model.q0, self.model.values))
        return np.array(out).reshape(-1, len(total)) / np.where(total > 0, total, 1.0)

    def _spread(
        self, terms: Sequence[Term], trials: int, start: Array, values: Callable[[Array], Array]
    ) -> Array:
        blocks = simulate(start, terms, seed=self.settings.seed, trials=trials, fold=False)
        return np.concatenate([values(b) for b in blocks]).std(axis=0)


@dataclass(frozen=True, eq=False)
class SampledJob:
    """Input of a worker that counts blocks: the model, the characteristics, and the places of the histograms."""

    model: LinearModel
    terms: tuple[Term, ...]
    settings: Settings
    columns: tuple[int, ...]
    places: tuple[tuple[float, float], ...]


def count(job: SampledJob, block: Block) -> list[PackedAccumulator]:
    """Count one block of a job; any worker can do it."""
    sampler = Sampler(job.model, job.terms, job.settings, lambda text, share: None)
    return [pack(a) for a in sampler.tally(block, job.columns, job.places)]


def _place(values: Array) -> tuple[float, float]:
    low, centre, high = np.quantile(values, [0.1587, 0.5, 0.8413])
    return float(centre), max(float(high - low) / 2, 1e-12)


def with_products(model: LinearModel, terms: Sequence[Term]) -> tuple[list[Term], Callable[[Array], Array]]:
    """Return terms whose extra rows carry the departures that meet in products, and the evaluation that multiplies them."""
    widened, multiply = multiplying(model, terms)
    if multiply is None:
        return widened, model.values
    layout: Callable[[Array], Array] = np.asarray if _of_sizes(model) else np.ascontiguousarray
    return widened, lambda block: model.values(layout(multiply(block)))


def _of_sizes(model: LinearModel) -> bool:
    """Return whether all characteristics are Gauss sizes: each is read from one quantity, so that the layout of q changes no digit.

    Quantity after quantity then takes a third of the time. Sums over the components of a vector, as any position has them, are
    rounded another way in another layout (2e-14 mm), so those keep trial after trial.
    """
    return all(c.type == "size" and choose_criteria(c).gauss for c in model.characteristics)


def multiplying(
    model: LinearModel, terms: Sequence[Term]
) -> tuple[list[Term], Callable[[Array], Array] | None]:
    """Return the result of `with_products`, with the function that turns a block of trials into q (m, K), one quantity after another;
    None where nothing meets."""
    pairs = [
        ((p.first, a), (p.second, b), gain) for p in model.products for a, b, gain in model.product_gains(p)
    ]
    carried = sorted({end for first, second, _ in pairs for end in (first, second)})
    if not carried:
        return list(terms), None
    k, place = len(model.q0), {end: i for i, end in enumerate(carried)}

    def multiply(block: Array) -> Array:
        q = block[:, :k].copy(order="F")
        for first, second, gain in pairs:
            product = block[:, k + place[first]] * block[:, k + place[second]]
            for i in np.flatnonzero(gain):
                q[:, i] += product * gain[i]
        return q

    return [_with_departures(model, j, t, carried) for j, t in enumerate(terms)], multiply


def _with_departures(model: LinearModel, j: int, term: Term, carried: Sequence[tuple[int, int]]) -> Term:
    """Return the term with one more row per carried (Influence, copy): the departure itself, canonical units."""
    rows = np.zeros((len(carried), term.gain.shape[1]))
    influence = model.influences[j]
    for i, (number, copy) in enumerate(carried):
        if number == j:
            lane = np.flatnonzero(term.lanes[:, 1] == copy_code(influence.copies[copy]))[0]
            rows[i, lane] = influence.input.spread(1)[1][0, 0]
    return replace(term, gain=np.concatenate([term.gain, rows]))
