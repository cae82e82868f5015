"""Task-specific measurement uncertainty: value, U, coverage interval, decision and budget of every characteristic.

The tier follows from the characteristic, not from the caller:
    closed form           smooth outputs (size, distance, angle): u = sqrt(G S G^T); interval by inversion of the
                          characteristic function, t-laws treated exactly
    collapsed Monte Carlo form, orientation, position; smooth outputs that curve over their own spread or in which a
                          product of two Inputs matters
    exact                 on request: every trial with multiplied transforms, contact and iterated fits
A few hundred exact trials on the same draws certify what each tier used (vcmm.evaluation.certify).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.charts import PlottedBudget
from vcmm.core.errors import UsageError
from vcmm.core.laws import Law
from vcmm.core.run import Array
from vcmm.evaluation.blocks import Sharing
from vcmm.evaluation.budget import budget_line
from vcmm.evaluation.certify import Check, check
from vcmm.evaluation.linear import LinearModel, build
from vcmm.evaluation.montecarlo import Summary, Term, marginal
from vcmm.evaluation.montecarlo import uncertainty as closed_form_u
from vcmm.evaluation.result import BudgetLine, CharacteristicResult, UncertaintyResult
from vcmm.evaluation.sampling import Progress, Sampler
from vcmm.evaluation.world import World
from vcmm.gps import characteristics as gps
from vcmm.gps.criteria import notes
from vcmm.gps.decision import GUARD_BAND, Decision, decide
from vcmm.measuring.settings import CORRECTED, Settings
from vcmm.measuring.task import Task, evaluate_all, fit_features, measured_points
from vcmm.part.part import Characteristic

NOTED = 1e-5  # mm or rad: below 10 nm the linear model is not worth a note
PRODUCT_SHARE = 1e-4  # a product of two Inputs that adds more than this share of the variance is sampled
CURVATURE = (
    0.01  # a smooth output that departs from its tangent by more than this share of its spread is sampled
)
BIAS_SHARE = (
    0.1  # |bias| <= 0.1 U: 95 % become 94.5 %; above that the interval is not shown to hold the true value
)
CLOSED = "closed form; interval by inversion of the characteristic function"
SAMPLED, EXACT = "collapsed Monte Carlo", "exact transforms, contact and fits"


def evaluate(
    task: Task,
    settings: Settings | None = None,
    progress: Progress | None = None,
    world: World | None = None,
    sharing: Sharing | None = None,
) -> UncertaintyResult:
    """Evaluate a task. world: where the errors come from (default: the task's machine); sharing: who counts the trials. Raises UsageError without Inputs or characteristics; see `linear.build` for the rest."""
    settings = settings or Settings()
    if not task.part.characteristics:
        raise UsageError(
            "the part has no characteristics; add [[part.characteristics]] with name, type and of"
        )
    if not task.inputs:
        raise UsageError(
            "nothing is uncertain: add [repeatability], [errors] uncertainty or [[inputs]] to the machine or scenario"
        )
    report = progress or (lambda text, share: None)
    model = build(task, world)
    report("certifying the linear model", 0.0)
    return _Evaluation(model, settings, report, sharing).result()


@dataclass(frozen=True)
class _Outcome:
    """What a tier says about one characteristic, before bias and decision."""

    tier: str
    u: float
    value: float
    mean: float
    interval: tuple[float, float]
    lines: tuple[BudgetLine, ...]
    probability: float | None
    linear_error: float
    tangent: bool  # linear over its own spread: noise moves it up as often as down
    summary: Summary | None = None


class _Evaluation:
    """One run over all characteristics; terms, gradient and values are made once."""

    def __init__(
        self, model: LinearModel, settings: Settings, progress: Progress, sharing: Sharing | None
    ) -> None:
        self.model, self.settings = model, settings
        self.features = model.task.part.features
        self.terms = model.terms()
        self.sampler = Sampler(model, self.terms, settings, progress, sharing)
        self.value = model.values(model.q0)
        self.bias = self.value - _perfect(model.task)
        self.gradient = model.gradient()
        self.check: Check = check(model, self.gradient, settings)
        self.smooth = [gps.is_linear(c, self.features) for c in model.characteristics]

    def result(self) -> UncertaintyResult:
        all_of_them = self.model.characteristics
        sampled = [i for i in range(len(all_of_them)) if not self._has_closed_form(i)]
        summaries = self.sampler.summaries(sampled) if sampled else {}
        curved = any(not self.smooth[i] or self._curved(i) for i in sampled)
        alone = self.sampler.alone() if curved else np.zeros((len(self.terms), len(all_of_them)))
        results = []
        for i, c in enumerate(all_of_them):
            outcome = self._sampled(i, summaries[i], alone[:, i]) if i in summaries else self._closed(i)
            results.append(self._assembled(i, c, outcome))
        predicts = self.model.world.predicts
        warnings = tuple(w for r in results for w in warnings_of(r, predicts))
        warnings += tuple(notes(all_of_them, self.model.base))
        return UncertaintyResult(
            tuple(results), self.settings.trials, self.settings.seed, warnings, self.model
        )

    def _has_closed_form(self, i: int) -> bool:
        if not self.smooth[i] or self.settings.engine != "auto":
            return False
        first, second = self._variances(i)
        matters = second > PRODUCT_SHARE * (first + second) if np.isfinite(first) else second > 0
        return not self._curved(i) and not matters

    def _curved(self, i: int) -> bool:
        return bool(self.check.curvature[i] > CURVATURE)

    def _variances(self, i: int) -> tuple[float, float]:
        """Closed-form variance of a smooth output: sum of (c u)^2, and of (d2y u_i u_j)^2 over products (JCGM 100, 5.1.2)."""
        second = 0.0
        for product in self.model.products:
            u = [self._scalar_u(j) for j in (product.first, product.second)]
            for _, _, gain in self.model.product_gains(product):
                second += (float(self.gradient[i] @ gain) * u[0] * u[1]) ** 2
        return float(closed_form_u(self._projected(i))[0]) ** 2, second

    def _scalar_u(self, j: int) -> float:
        law, factor = self.model.influences[j].input.spread(1)
        assert isinstance(law, Law)
        return float(law.u) * abs(float(factor[0, 0]))

    def _projected(self, i: int) -> list[Term]:
        """The terms acting on one characteristic: gain (1, L)."""
        return [replace(t, gain=(self.gradient[i] @ t.gain)[None]) for t in self.terms]

    def _closed(self, i: int) -> _Outcome:
        terms = self._projected(i)
        linear = marginal(float(self.value[i]), terms, 0)
        interval = linear.interval(self.settings.p, self.settings.kind)
        lines = self._lines(terms, [float(closed_form_u([t])[0]) for t in terms], linear.u, True)
        limits = self._limits(i)
        p = None if limits is None else linear.probability(*limits)
        return _Outcome(
            tier=CLOSED, u=linear.u, value=linear.centre, mean=linear.centre, interval=interval, lines=lines,
            probability=p, linear_error=float(self.check.tangent_error[i]), tangent=True,
        )  # fmt: skip

    def _sampled(self, i: int, summary: Summary, alone: Array) -> _Outcome:
        exact = self.settings.engine == "exact"
        tangent = self.smooth[i] and not self._curved(i)
        terms = self._projected(i) if self.smooth[i] else list(self.terms)
        u = float(np.sqrt(sum(self._variances(i)))) if tangent and not exact else summary.u
        if not tangent and any(np.isinf(np.max(t.law.u)) for t, share in zip(self.terms, alone) if share > 0):
            u = np.inf  # the spread of a sample of infinite variance depends on the seed
        u_i = (
            [float(closed_form_u([t])[0]) for t in terms]
            if tangent
            else [float(share) * summary.u for share in alone]
        )
        lines = self._lines(terms, u_i, u, tangent)
        limits = self._limits(i)
        p = None if limits is None else summary.probability(*limits)
        interval = summary.interval(self.settings.p, self.settings.kind)
        # a law of samples may have a mean: a smooth output then moves by it (JCGM 101, 7.6)
        value = marginal(float(self.value[i]), terms, 0).centre if tangent else float(self.value[i])
        return _Outcome(
            tier=EXACT if exact else SAMPLED, u=u, value=value, mean=summary.mean, interval=interval, lines=lines,
            probability=p, linear_error=float(self.check.linear_error[i]), tangent=tangent, summary=summary,
        )  # fmt: skip

    def _lines(
        self, terms: Sequence[Term], u_i: Sequence[float], u: float, linear: bool
    ) -> tuple[BudgetLine, ...]:
        world = self.model.world
        rows = [budget_line(world, f, t, x, u, linear) for f, t, x in zip(self.model.influences, terms, u_i)]
        return tuple(sorted(rows, key=lambda line: -line.u))

    def _shift(self, i: int) -> float:
        """What is taken off the indicated value: its known bias, when the settings say so.

        A form or position is not corrected: it is no sum of a true value and an error.
        """
        tangent = self.smooth[i] and not self._curved(i)
        return float(self.bias[i]) if self.settings.known_bias == CORRECTED and tangent else 0.0

    def _limits(self, i: int) -> tuple[float, float] | None:
        """Limits for the indicated value; the 0 of a zone is no limit."""
        c = self.model.characteristics[i]
        tolerance = gps.tolerance(c, gps.nominal(c, self.features))
        if tolerance is None:
            return None
        low, high = (limit + self._shift(i) for limit in tolerance)
        return (-np.inf, high) if gps.one_sided(c) else (low, high)

    def _decision(
        self, c: Characteristic, interval: tuple[float, float], value: float, outcome: _Outcome
    ) -> Decision | None:
        tolerance = gps.tolerance(c, gps.nominal(c, self.features))
        if tolerance is None:
            return None
        low, high = interval
        half, rule = (high - low) / 2, self.settings.rule
        where = (
            (low + high) / 2 if rule == GUARD_BAND else value
        )  # the guard band is that of the interval's own ends
        finite_u = outcome.u if np.isfinite(outcome.u) else None
        return decide(
            where, tolerance, outcome.probability, u=finite_u, U=half, rule=rule, one_sided=gps.one_sided(c)
        )

    def _assembled(self, i: int, c: Characteristic, outcome: _Outcome) -> CharacteristicResult:
        nominal, shift, u = gps.nominal(c, self.features), self._shift(i), outcome.u
        interval = (outcome.interval[0] - shift, outcome.interval[1] - shift)
        half = (interval[1] - interval[0]) / 2
        known = bool(np.isfinite(u) and u > 0)
        value = outcome.value - shift
        unbiased = shift != 0 or abs(float(self.bias[i])) <= BIAS_SHARE * half
        shown = self.model.world.predicts or (outcome.tangent and unbiased)
        if np.isfinite(outcome.linear_error) and outcome.tier != EXACT:
            shown = shown and outcome.linear_error <= BIAS_SHARE * max(half, 1e-12)
        return CharacteristicResult(
            name=c.name, type=c.type, unit=gps.unit(c), nominal=nominal, value=value, mean=outcome.mean - shift,
            bias=float(self.bias[i]), corrected=shift != 0, u=u,
            k=half / u if known else float("nan"), p=self.settings.p, interval=interval,
            interval_kind=self.settings.kind, coverage_shown=shown, extreme=not outcome.tangent,
            tolerance=gps.tolerance(c, nominal), decision=self._decision(c, interval, value, outcome), budget=PlottedBudget(outcome.lines),
            interaction_share=1.0 - sum(line.share for line in outcome.lines) if known else float("nan"),
            tier=outcome.tier, trials=outcome.summary.trials if outcome.summary else 0,
            linear_error=outcome.linear_error, summary=outcome.summary,
        )  # fmt: skip


def _perfect(task: Task) -> Array:
    """Characteristics of the same points on a machine without errors."""
    return evaluate_all(task, fit_features(task, measured_points(task, np.zeros((task.touches.run.n, 3)))))


def warnings_of(r: CharacteristicResult, predicts: bool = False) -> list[str]:
    """What a reader must know about one result. predicts: of a part still to be cut, whose errors are its deviation."""
    out = list(r.summary.warnings) if r.summary else []
    unit, scale = ("um", 1e3) if r.unit == "mm" else ("urad", 1e6)
    if not (predicts or r.corrected) and abs(r.bias) > BIAS_SHARE * r.expanded and abs(r.bias) > 1e-9:
        out.append(
            f"{r.name}: the known bias of {r.bias * scale:+.3g} {unit} is not corrected; the interval and the decision are about "
            'the indicated value. Correct it ([job] known_bias = "corrected") or enlarge U (JCGM 100, F.2.4.5)'
        )
    if r.extreme and not predicts:
        moved = (r.mean - r.value) * scale
        out.append(
            f"{r.name}: {r.type} grows with noise and does not fall with it (here by {moved:+.3g} {unit} on average); perturbing "
            "measured points and evaluating them again (the classic virtual-CMM recipe) has no shown coverage"
        )
    if not np.isfinite(r.u):
        out.append(
            f"{r.name}: u is infinite (a t-law with nu <= 2); the coverage interval stands all the same"
        )
    if r.tier != EXACT and np.isfinite(r.linear_error) and r.linear_error > max(0.01 * r.expanded, NOTED):
        share = (
            f" ({r.linear_error / r.expanded:.1%} of U)" if r.expanded > r.linear_error else ", more than U"
        )
        size = f"{r.linear_error * 1e6:.3g} {'nm' if r.unit == 'mm' else 'urad'}"
        out.append(f"{r.name}: the linear model errs by up to {size}{share}; use --engine exact")
    return out
