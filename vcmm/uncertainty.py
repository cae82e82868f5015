"""Task-specific measurement uncertainty: value, U, coverage interval, decision and budget of every characteristic.

The tier follows from the characteristic, not from the caller:
    closed form + exact interval   smooth outputs (size, distance, angle): u = sqrt(G S G^T), interval by inversion of the
                                   characteristic function, t-laws treated exactly
    collapsed Monte Carlo          form, orientation, position, and outputs with a product of two Inputs
    points / exact                 on request: every trial with contact and iterated fits (exact: and transforms)
A few hundred exact trials on the same draws certify the linear model in every case.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.errors import UsageError
from vcmm.exact import draw_inputs, exact_values, linear_values
from vcmm.gps import characteristics as gps
from vcmm.gps.decision import Decision, decide
from vcmm.inputs import Input
from vcmm.interval import Linear
from vcmm.linear import LinearModel, build
from vcmm.montecarlo import Accumulator, Summary, Term, simulate
from vcmm.part import Characteristic
from vcmm.run import Array
from vcmm.settings import Settings
from vcmm.task import Task, evaluate_all, fit_features, measured_points

BUDGET_TRIALS = 20_000
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class BudgetLine:
    """One row of the budget. u_input and estimate in `unit`; u is the contribution, mm or rad."""

    input: str
    distribution: str
    dof: float
    redraw: str
    estimate: float | None
    u_input: float | None
    unit: str
    sensitivity: float | None
    u: float
    share: float
    evidence: str


@dataclass(frozen=True, eq=False)
class CharacteristicResult:
    """Result of one characteristic; lengths in mm, angles in rad (`unit`).

    value: indicated at the estimates (smooth outputs) or the mean over the trials (JCGM 101); bias: value minus what
    a machine without errors would indicate at the same points, not corrected (ISO 15530 reports it apart).
    """

    name: str
    type: str
    unit: str
    nominal: float
    value: float
    bias: float
    u: float
    k: float
    p: float
    interval: tuple[float, float]
    interval_kind: str
    coverage_shown: bool
    tolerance: tuple[float, float] | None
    decision: Decision | None
    budget: tuple[BudgetLine, ...]
    interaction_share: float
    tier: str
    trials: int
    linear_error: float
    summary: Summary | None

    @property
    def expanded(self) -> float:
        """U: half the width of the coverage interval."""
        return (self.interval[1] - self.interval[0]) / 2


@dataclass(frozen=True, eq=False)
class UncertaintyResult:
    """All characteristics of a task."""

    characteristics: tuple[CharacteristicResult, ...]
    trials: int
    seed: int
    warnings: tuple[str, ...]
    model: LinearModel


def evaluate(
    task: Task, settings: Settings | None = None, progress: Progress | None = None
) -> UncertaintyResult:
    """Evaluate a task. Raises UsageError without Inputs or characteristics; see `linear.build` for the rest."""
    settings = settings or Settings()
    if not task.part.characteristics:
        raise UsageError(
            "the part has no characteristics; add [[part.characteristics]] with name, type and of"
        )
    if not task.inputs:
        raise UsageError(
            "nothing is uncertain: add [repeatability], [errors] uncertainty or [[inputs]] to the machine or scenario"
        )
    model = build(task)
    report = progress or (lambda text, share: None)
    report("certifying the linear model", 0.0)
    errors = certify(model, settings)
    return _Evaluation(model, settings, report).results(errors)


def certify(model: LinearModel, settings: Settings) -> Array:
    """(C,) largest |linear - exact| over `settings.certify` trials on common draws, mm or rad."""
    if settings.certify == 0:
        return np.full(len(model.characteristics), np.nan)
    drawn = draw_inputs(model, settings.seed, 0, settings.certify)
    return np.asarray(np.abs(linear_values(model, drawn) - exact_values(model, drawn)).max(axis=0))


class _Evaluation:
    """One run over all characteristics; keeps the terms so that they are made once."""

    def __init__(self, model: LinearModel, settings: Settings, progress: Progress) -> None:
        self.model, self.settings, self.progress = model, settings, progress
        self.terms = model.terms()
        self.q_terms, self.q_values = with_products(model, self.terms)
        self.value = model.values(model.q0)
        self.perfect = evaluate_all(
            model.task, fit_features(model.task, measured_points(model.task, np.zeros((1, 3))))
        )
        self.gradient = model.gradient()
        self.smooth = [gps.is_linear(c, model.task.part.features) for c in model.characteristics]

    def results(self, errors: Array) -> UncertaintyResult:
        chosen = self.settings
        if chosen.engine == "exact":
            summaries = self._exact()
        else:
            needed = [i for i in range(len(self.smooth)) if not self._in_closed_form(i)]
            summaries = dict(zip(needed, self._simulate(needed))) if needed else {}
        lone = self._alone([i for i in summaries]) if summaries else {}
        results = []
        for i, c in enumerate(self.model.characteristics):
            if i in summaries:
                results.append(self._from_trials(i, c, summaries[i], lone[i], float(errors[i])))
            else:
                results.append(self._closed(i, c, float(errors[i])))
        warnings = self._warnings(results)
        return UncertaintyResult(tuple(results), chosen.trials, chosen.seed, warnings, self.model)

    def _in_closed_form(self, i: int) -> bool:
        return self.settings.engine == "auto" and self.smooth[i] and not self._product_matters(i)

    def _product_matters(self, i: int) -> bool:
        """A product term that adds more than 1e-4 of the variance is sampled, not neglected."""
        first = sum(float((self.gains(i, t) ** 2).sum()) * t.law.u**2 for t in self.terms)
        second = 0.0
        for product in self.model.products:
            u = [self._scalar_u(j) for j in (product.first, product.second)]
            second += float(self.gradient[i] @ self.model.product_gain(product)) ** 2 * (u[0] * u[1]) ** 2
        return bool(second > 1e-4 * (first + second))

    def _scalar_u(self, j: int) -> float:
        one = self.model.influences[j].input
        law, factor = one.spread(1)
        return float(law.u * abs(factor[0, 0]))

    def gains(self, i: int, term: Term) -> Array:
        return np.asarray(self.gradient[i] @ term.gain)

    # --- smooth outputs -------------------------------------------------------------------------------------------
    def _closed(self, i: int, c: Characteristic, error: float) -> CharacteristicResult:
        parts = [(t.law, self.gains(i, t)) for t in self.terms]
        linear = Linear(float(self.value[i]), parts)
        interval = linear.interval(self.settings.p, self.settings.kind)
        u_i = [float(np.sqrt((g**2).sum())) * law.u for law, g in parts]
        sensitivities = [float(g[0]) if len(g) == 1 else None for _, g in parts]
        limits = self._limits(i, c)
        p_conform = None if limits is None else linear.probability(*limits)
        tier = "closed form; interval by inversion of the characteristic function"
        return self._assemble(
            i,
            c,
            float(self.value[i]),
            linear.u,
            interval,
            u_i,
            sensitivities,
            p_conform,
            tier,
            0,
            error,
            None,
            True,
        )

    # --- sampled outputs ------------------------------------------------------------------------------------------
    def _simulate(self, needed: Sequence[int]) -> list[Summary]:
        scale = self._pilot(needed)
        accumulators = [Accumulator(*s) for s in scale]
        done = 0
        for block in simulate(
            self._start(), self.q_terms, seed=self.settings.seed, trials=self.settings.trials
        ):
            values = self.q_values(block)
            for column, accumulator in zip(needed, accumulators):
                accumulator.add(values[:, column])
            done += len(block)
            self.progress("Monte Carlo", done / self.settings.trials)
        return [a.summary() for a in accumulators]

    def _pilot(self, needed: Sequence[int]) -> list[tuple[float, float]]:
        """Centre and u of every output from a first block: the histogram's place."""
        blocks = list(
            simulate(
                self._start(), self.q_terms, seed=self.settings.seed, trials=min(8192, self.settings.trials)
            )
        )
        values = self.q_values(np.concatenate(blocks))
        low, high = np.quantile(values, [0.1587, 0.8413], axis=0)
        return [(float(np.median(values[:, i])), max(float(high[i] - low[i]) / 2, 1e-12)) for i in needed]

    def _alone(self, needed: Sequence[int]) -> dict[int, list[float]]:
        """Standard deviation of each output with one Input at a time (JCGM 101 has no sensitivity coefficients)."""
        out: dict[int, list[float]] = {i: [] for i in needed}
        trials = min(BUDGET_TRIALS, self.settings.trials)
        for done, term in enumerate(self.terms):
            self.progress("budget", done / len(self.terms))
            blocks = [
                self.model.values(b)
                for b in simulate(self.model.q0, [term], seed=self.settings.seed, trials=trials)
            ]
            spread = np.concatenate(blocks).std(axis=0)
            for i in needed:
                out[i].append(float(spread[i]))
        return out

    def _start(self) -> Array:
        extra = self.q_terms[0].gain.shape[0] - len(self.model.q0) if self.q_terms else 0
        return np.concatenate([self.model.q0, np.zeros(extra)])

    def _exact(self) -> dict[int, Summary]:
        """Every trial exact, in blocks; the histogram is placed by the first block."""
        accumulators: list[Accumulator] = []
        block = 500
        for first in range(0, self.settings.trials, block):
            count = min(block, self.settings.trials - first)
            values = exact_values(self.model, draw_inputs(self.model, self.settings.seed, first, count))
            if not accumulators:
                spread = np.maximum(values.std(axis=0), 1e-12)
                accumulators = [Accumulator(float(m), float(s)) for m, s in zip(values.mean(axis=0), spread)]
            for column, accumulator in enumerate(accumulators):
                accumulator.add(values[:, column])
            self.progress("exact trials", (first + count) / self.settings.trials)
        return {i: a.summary() for i, a in enumerate(accumulators)}

    def _from_trials(
        self, i: int, c: Characteristic, found: Summary, u_i: list[float], error: float
    ) -> CharacteristicResult:
        interval = found.interval(self.settings.p, self.settings.kind)
        limits = self._limits(i, c)
        p_conform = None if limits is None else found.probability(*limits)
        name = (
            "exact transforms, contact and fits"
            if self.settings.engine == "exact"
            else "collapsed Monte Carlo"
        )
        if self.smooth[i]:
            sensitivities = [
                float(g[0]) if len(g) == 1 else None for g in (self.gains(i, t) for t in self.terms)
            ]
        else:
            sensitivities = [None for _ in self.terms]
        return self._assemble(
            i,
            c,
            found.mean,
            found.u,
            interval,
            u_i,
            sensitivities,
            p_conform,
            name,
            found.trials,
            error,
            found,
            self.smooth[i],
        )

    # --- common ---------------------------------------------------------------------------------------------------
    def _limits(self, i: int, c: Characteristic) -> tuple[float, float] | None:
        tolerance = gps.tolerance(c, gps.nominal(c, self.model.task.part.features))
        if tolerance is None:
            return None
        return (-np.inf, tolerance[1]) if gps.one_sided(c) else tolerance

    def _assemble(
        self, i: int, c: Characteristic, value: float, u: float, interval: tuple[float, float], u_i: list[float],
        sensitivities: Sequence[float | None], p_conform: float | None, tier: str, trials: int, error: float,
        summary: Summary | None, shown: bool,
    ) -> CharacteristicResult:  # fmt: skip
        nominal = gps.nominal(c, self.model.task.part.features)
        expanded = (interval[1] - interval[0]) / 2
        lines = tuple(self._line(j, u_i[j], u, sensitivities[j]) for j in range(len(self.terms)))
        lines = tuple(sorted(lines, key=lambda line: -line.u))
        tolerance = gps.tolerance(c, nominal)
        decision = None
        if tolerance is not None:
            limits = self._limits(i, c)
            assert limits is not None
            finite_u = u if np.isfinite(u) else None
            decision = decide(
                value,
                limits,
                p_conform,
                u=finite_u,
                U=expanded,
                rule=self.settings.rule,
                one_sided=gps.one_sided(c),
            )
        share = sum(line.share for line in lines)
        return CharacteristicResult(
            c.name, c.type, gps.unit(c), nominal, value, value - float(self.perfect[i]), u, expanded / u if u > 0 else float("nan"),
            self.settings.p, interval, self.settings.kind, shown, tolerance, decision, lines,
            1.0 - share if np.isfinite(u) and u > 0 else float("nan"), tier, trials, error, summary,
        )  # fmt: skip

    def _line(self, j: int, u_j: float, u: float, sensitivity: float | None) -> BudgetLine:
        influence, term = self.model.influences[j], self.terms[j]
        one = influence.input
        estimate, unit = estimate_of(self.model.task, one)
        share = (u_j / u) ** 2 if np.isfinite(u) and u > 0 else float("nan")
        scalar = influence.response.shape[2] == 1
        u_input = (
            float(term.law.u * (1.0 if one.scale is None else float(np.mean(one.scale)))) if scalar else None
        )
        law = (
            one.law.name
            if not hasattr(one.law, "factor")
            else f"normal, {one.law.factor.shape[0]} correlated"
        )
        return BudgetLine(
            one.id,
            law,
            float(term.law.dof),
            one.redraw,
            estimate,
            u_input,
            unit,
            sensitivity,
            u_j,
            share,
            one.evidence,
        )

    def _warnings(self, results: Sequence[CharacteristicResult]) -> tuple[str, ...]:
        out = []
        for r in results:
            if not r.coverage_shown:
                out.append(
                    f"{r.name}: {r.type} is an extreme value; the interval perturbs measured points and re-evaluates them, "
                    "its coverage was not shown"
                )
            if not np.isfinite(r.u):
                out.append(
                    f"{r.name}: u is infinite (a t-law with nu <= 2); the coverage interval is exact all the same"
                )
            if r.linear_error > 0.01 * r.expanded:
                out.append(
                    f"{r.name}: the linear model errs by up to {r.linear_error * 1e6:.3g} n{r.unit[-1] if r.unit == 'mm' else 'rad'} "
                    f"({r.linear_error / r.expanded:.1%} of U); use --engine exact"
                )
        return tuple(out)


def with_products(model: LinearModel, terms: Sequence[Term]) -> tuple[list[Term], Callable[[Array], Array]]:
    """Terms whose extra rows carry the draws that meet in products, and the evaluation that multiplies them."""
    names = sorted({model.influences[j].input.id for p in model.products for j in (p.first, p.second)})
    if not names:
        return list(terms), model.values
    k = len(model.q0)
    wide = []
    for term in terms:
        rows = np.zeros((len(names), term.gain.shape[1]))
        if term.name in names and term.gain.shape[1]:
            rows[names.index(term.name), 0] = 1.0
        wide.append(replace(term, gain=np.concatenate([term.gain, rows])))
    pairs = [
        (
            names.index(model.influences[p.first].input.id),
            names.index(model.influences[p.second].input.id),
            model.product_gain(p),
        )
        for p in model.products
    ]

    def values(block: Array) -> Array:
        q = block[:, :k].copy()
        for a, b, gain in pairs:
            q += (block[:, k + a] * block[:, k + b])[:, None] * gain
        return model.values(q)

    return wide, values


def estimate_of(task: Task, one: Input) -> tuple[float | None, str]:
    """(estimate, unit) of a scalar Input for the budget; None for arrays."""
    from vcmm.effect import parameter
    from vcmm.influence import targets

    if one.is_channel:
        from vcmm.files.effects import channel_unit

        return float(np.mean(task.touches.run.column(one.parameter))), channel_unit(one.parameter)
    effect = targets(task.machine, one)[0]
    spec = parameter(effect, one.parameter)
    value = getattr(effect, spec.name)
    return (None, spec.metadata["show"]) if spec.metadata["shape"] else (float(value), spec.metadata["show"])
