"""Task-specific measurement uncertainty: value, U, coverage interval, decision and budget of every characteristic.

The tier follows from the characteristic, not from the caller:
    closed form           smooth outputs (size, distance, angle): u = sqrt(G S G^T); interval by inversion of the
                          characteristic function, t-laws treated exactly
    Monte Carlo (linear model) form, orientation, position; smooth outputs that curve over their own spread or in which a
                          product of two Inputs matters
    exact                 on request: every trial with multiplied transforms, contact and iterated fits
A few hundred exact trials on the same draws certify what each tier used (vcmm.answer.evaluation.certify).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.budget import budget_line, form_line, product_line
from vcmm.answer.evaluation.certify import Check, check
from vcmm.answer.evaluation.indication import at_indication
from vcmm.answer.evaluation.interval import Linear
from vcmm.answer.evaluation.inversion import Inversion, TrueValueByBelt, inversion_of
from vcmm.answer.evaluation.linear import LinearModel, prepare_model
from vcmm.answer.evaluation.montecarlo import Summary, Term, marginal
from vcmm.answer.evaluation.montecarlo import uncertainty as closed_form_u
from vcmm.answer.evaluation.not_covered import between_touches
from vcmm.answer.evaluation.part_forms import FORM, true_values
from vcmm.answer.evaluation.result import (
    BudgetLine,
    CharacteristicResult,
    PlottedBudget,
    UncertaintyResult,
)
from vcmm.answer.evaluation.sampling import Sampler
from vcmm.answer.evaluation.truth import Additive, PredictedPart, Truth, holds
from vcmm.answer.evaluation.world import World
from vcmm.core.blocks import Progress, Sharing
from vcmm.core.laws import Law
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import choose_criteria, notes
from vcmm.part.gps.filters import words
from vcmm.part.part import Characteristic
from vcmm.task.measuring.settings import CORRECTED, Settings
from vcmm.task.measuring.task import Task, evaluate_all, fit_features, measured_points
from vcmm.task.response.influence import Influence

ROUNDING_SHARE_OF_U = 1e-9  # of U: rounding
LEAST_NOTE = 1e-5  # mm or rad: below 10 nm the linear model is not worth a note
PRODUCT_SHARE = 1e-4  # a product of two Inputs that adds more than this share of the variance is sampled
# a smooth output that departs from its tangent by more than this share of its spread is sampled
CURVATURE = 0.01
ERROR_SHARE = 0.1  # of U: an error of the linear model above this makes the interval one of another quantity
CLOSED = "closed form; interval by inversion of the characteristic function"
SAMPLED, EXACT = "Monte Carlo (linear model)", "exact transforms, contact and fits"


def evaluate(
    task: Task,
    settings: Settings | None = None,
    progress: Progress | None = None,
    world: World | None = None,
    sharing: Sharing | None = None,
    *,
    read: bool = True,
) -> UncertaintyResult:
    """Evaluate a task. world: where the errors come from (default: the task's machine); sharing: the workers that count the trials.

    read: also infer the true value of an extreme characteristic from its planned value, for which parts are sampled. Without it those
    results wait for `at_indication`, and no warnings are given (`warnings_of`).

    Raises UsageError without characteristics, and for a measurement in which nothing is uncertain (a prediction may be
    certain); see `linear.prepare_model` for the rest.
    """
    settings = settings or Settings()
    report = progress or (lambda text, share: None)
    model = prepare_model(task, world)
    report("certifying the linear model", 0.0)
    base = fit_features(task, measured_points(task, model.world.errors())) if task.forms else model.base
    indicated = evaluate_all(task, base)
    return Evaluation(model, settings, report, indicated, sharing).result(read)


@dataclass(frozen=True)
class _Outcome:
    """The result of a tier for one characteristic, before bias and decision.

    law: of the indicated value; error: its mean beyond the indicated value, where the laws of Inputs have one.
    """

    tier: str
    u: float
    law: Linear | Summary
    lines: tuple[BudgetLine, ...]
    linear_error: float
    tangent: bool  # linear over its own spread: noise moves it up as often as down
    error: float = 0.0
    half: float | None = None  # U of an extreme value
    inverse: Inversion | None = None

    @property
    def summary(self) -> Summary | None:
        return self.law if isinstance(self.law, Summary) else None


class Evaluation:
    """One run over all characteristics; terms, gradient and values are computed once."""

    def __init__(
        self,
        model: LinearModel,
        settings: Settings,
        progress: Progress,
        indicated: Array,
        sharing: Sharing | None,
    ) -> None:
        self.model, self.settings = model, settings
        self.features = model.task.part.features
        self.terms = model.terms()
        self.sampler = Sampler(model, self.terms, settings, progress, sharing)
        self.value = model.at_estimates
        self.indicated = np.where([c.type in gps.FORM for c in model.characteristics], indicated, self.value)
        self.bias = self.value - true_values(model.task)
        self.gradient = model.gradient()
        self.check: Check = check(model, self.gradient, settings)
        self.smooth = [gps.is_linear(c, self.features) for c in model.characteristics]

    def result(self, read: bool) -> UncertaintyResult:
        all_of_them = self.model.characteristics
        sampled = [i for i in range(len(all_of_them)) if not self._has_closed_form(i)]
        summaries = self.sampler.summaries(sampled) if sampled else {}
        extreme = [i for i in sampled if not self.smooth[i] or self._is_curved(i)]
        inverted = [i for i in extreme if self.is_invertible(i)]
        inversion = inversion_of(self.model.task, self.settings, inverted) if inverted else None
        if inversion is not None and read:
            inversion.expect((i, float(self.indicated[i]), None) for i in inverted)
        alone = np.zeros((len(self.terms), len(all_of_them)))
        if set(extreme) - set(inverted):
            alone = self.sampler.alone()
        results = []
        for i, c in enumerate(all_of_them):
            if inversion is not None and i in inverted:
                self.sampler.progress(f"true values of {c.name}", i / len(all_of_them))
                outcome = self._invert(i, summaries[i], inversion)
            else:
                outcome = (
                    self._sample(i, summaries[i], alone[:, i])
                    if i in summaries
                    else self._closed_form_outcome(i)
                )
            results.append(self._assemble(i, c, outcome, read))
        predicts = self.model.world.predicts
        warnings = tuple(w for r in results for w in warnings_of(r, predicts)) if read else ()
        warnings += tuple(notes(all_of_them, self.model.base))
        return UncertaintyResult(
            tuple(results), self.settings.trials, self.settings.seed, warnings, self.model
        )

    def is_tangent(self, i: int) -> bool:
        """Return whether result i is linear over its own spread."""
        return self.smooth[i] and not self._is_curved(i)

    def without_trials(self, i: int, inversion: Inversion | None) -> CharacteristicResult:
        """Return result i by its closed form; with an inversion by the uncertainty that the machine adds, without interval and decision."""
        outcome = (
            self._closed_form_outcome(i)
            if inversion is None
            else self._invert(i, Linear(float(self.value[i]), ()), inversion)
        )
        return self._assemble(i, self.model.characteristics[i], outcome, inversion is None)

    def _has_closed_form(self, i: int) -> bool:
        if not self.smooth[i] or self.settings.engine != "auto":
            return False
        first, second = self._variances(i)
        matters = second > PRODUCT_SHARE * (first + second) if np.isfinite(first) else second > 0
        return not self._is_curved(i) and not matters

    def _is_curved(self, i: int) -> bool:
        return bool(self.check.curvature[i] > CURVATURE)

    def _variances(self, i: int) -> tuple[float, float]:
        """Return the closed-form variance of a smooth output: sum of (c u)^2, and of (d2y u_i u_j)^2 over products (JCGM 100, 5.1.2)."""
        terms = self._terms_on(i)
        return float(closed_form_u(terms)[0]) ** 2 if terms else 0.0, sum(u**2 for u in self._products_on(i))

    def _products_on(self, i: int) -> list[float]:
        """Return the standard uncertainty of one characteristic by every product of two Inputs."""
        out = []
        for product in self.model.products:
            u = self._scalar_u(product.first) * self._scalar_u(product.second)
            gains = [float(self.gradient[i] @ gain) for _, _, gain in self.model.product_gains(product)]
            out.append(u * float(np.linalg.norm(gains)))
        return out

    def _scalar_u(self, j: int) -> float:
        law, factor = self.model.influences[j].input.spread(1)
        assert isinstance(law, Law)
        return float(law.u) * abs(float(factor[0, 0]))

    def _terms_on(self, i: int) -> list[Term]:
        """Return the terms acting on one characteristic: gain (1, L)."""
        return [replace(t, gain=(self.gradient[i] @ t.gain)[None]) for t in self.terms]

    def _closed_form_outcome(self, i: int) -> _Outcome:
        terms = self._terms_on(i)
        linear = marginal(float(self.value[i]), terms, 0)
        lines = self._lines(terms, [float(closed_form_u([t])[0]) for t in terms], linear.u, True)
        return _Outcome(
            tier=CLOSED, u=linear.u, law=linear, lines=lines, linear_error=float(self.check.tangent_error[i]), tangent=True,
            error=linear.centre - linear.mean,
        )  # fmt: skip

    def _sample(self, i: int, summary: Summary, alone: Array) -> _Outcome:
        exact = self.settings.engine == "exact"
        tangent = self.smooth[i] and not self._is_curved(i)
        terms = self._terms_on(i) if self.smooth[i] else list(self.terms)
        u = float(np.sqrt(sum(self._variances(i)))) if tangent and not exact else summary.u
        if not tangent and any(np.isinf(np.max(t.law.u)) for t, share in zip(self.terms, alone) if share > 0):
            u = np.inf  # the spread of a sample of infinite variance depends on the seed
        u_i = (
            [float(closed_form_u([t])[0]) for t in terms]
            if tangent
            else [float(share) * summary.u for share in alone]
        )
        lines = self._lines(terms, u_i, u, tangent)
        if tangent:
            of = [
                (self.model.influences[p.first], self.model.influences[p.second]) for p in self.model.products
            ]
            made = zip(of, self._products_on(i))
            lines += tuple(product_line(self.model.world, *pair, x, u) for pair, x in made if x > 0)
        error = float(self.check.linear_error[i])
        # a law of samples may have a mean: a smooth output then moves by it (JCGM 101, 7.6)
        moved = marginal(0.0, terms, 0).centre if tangent else 0.0
        return _Outcome(
            tier=EXACT if exact else SAMPLED, u=u, law=summary, lines=lines, linear_error=error, tangent=tangent, error=moved
        )  # fmt: skip

    def is_invertible(self, i: int) -> bool:
        """Return whether parts can be sampled for an extreme value: something is measured, on features whose forms are known by families."""
        c = self.model.characteristics[i]
        if self.model.world.predicts or not (gps.is_one_sided(c) or self._by_contact(c)):
            return False  # of a distance or angle of nearly nothing the error depends on the value itself
        named = gps.needs(c)
        return not any(self.features[n].kind in ("mesh", "point") for n in named if n in self.features)

    def _by_contact(self, c: Characteristic) -> bool:
        """Return whether it is a size, distance or angle of elements by contact, well away from zero."""
        return not choose_criteria(c).gauss and gps.nominal(c, self.features) > LEAST_NOTE

    def _invert(self, i: int, law: Linear | Summary, inversion: Inversion) -> _Outcome:
        exact, added, c = (
            self.settings.engine == "exact",
            inversion.added_uncertainty(i),
            self.model.characteristics[i],
        )
        u, form = added.u, added.by_form
        of_machine = [j for j, f in enumerate(self.model.influences) if f.input.effect != FORM]
        terms, u_i = [self.terms[j] for j in of_machine], [float(x) for x in added.by_input]
        if any(np.isinf(np.max(t.law.u)) for t, share in zip(terms, u_i) if share > 0):
            u = np.inf  # the spread of a sample of infinite variance depends on the seed
        lines = self._lines(terms, u_i, u, False, [self.model.influences[j] for j in of_machine])
        between = [form_line(c, self.features, form, u)] if form > 1e-3 * added.u else []
        return _Outcome(
            tier=EXACT if exact else SAMPLED, u=u, law=law, lines=(*lines, *between), linear_error=float(self.check.linear_error[i]),
            tangent=False, half=added.half, inverse=inversion,
        )  # fmt: skip

    def _lines(
        self,
        terms: Sequence[Term],
        u_i: Sequence[float],
        u: float,
        linear: bool,
        of: Sequence[Influence] = (),
    ) -> tuple[BudgetLine, ...]:
        """Return the lines of a budget. of: the Influences of the terms, where they are not all."""
        world = self.model.world
        rows = [
            budget_line(world, f, t, x, u, linear) for f, t, x in zip(of or self.model.influences, terms, u_i)
        ]
        return tuple(sorted(rows, key=lambda line: -line.u))

    def _shift(self, i: int) -> float:
        """Return the correction of the indicated value: its known bias, when the settings require it.

        A form or position is not corrected: it is no sum of a true value and an error.
        """
        tangent = self.smooth[i] and not self._is_curved(i)
        return float(self.bias[i]) if self.settings.known_bias == CORRECTED and tangent else 0.0

    def _assemble(self, i: int, c: Characteristic, outcome: _Outcome, read: bool) -> CharacteristicResult:
        nominal, shift, u = gps.nominal(c, self.features), self._shift(i), outcome.u
        predicts, law = self.model.world.predicts, outcome.law
        noise = (
            outcome.error
            if outcome.tangent or not outcome.summary
            else outcome.summary.mean - float(self.value[i])
        )
        additive = Additive(law, float(self.value[i]), noise, shift)
        # of an extreme value the mean of the trials is to be expected, which noise enlarges
        additive = replace(additive, bias=self._bias_left_in(outcome, i, additive))
        part = PredictedPart(law, float(self.value[i]) + (outcome.error if outcome.tangent else noise))
        why = "" if predicts else self._why_not_shown(c, outcome)
        why = why or _why_not_linear(outcome, self.settings)
        truth: Truth = part if predicts else additive
        truth = truth if outcome.inverse is None else TrueValueByBelt(outcome.inverse, i, limit=why)
        result = CharacteristicResult(
            name=c.name, type=c.type, unit=gps.unit(c), nominal=nominal, value=nominal,
            mean=(law.centre if isinstance(law, Linear) else law.mean) - shift, bias=float(self.bias[i]), corrected=shift != 0,
            u=u, k=float("nan"), p=self.settings.p, interval=(nominal, nominal), interval_kind=self.settings.kind,
            coverage_shown=not why, extreme=not outcome.tangent, tolerance=gps.tolerance(c, nominal), decision=None,
            budget=PlottedBudget(sorted(outcome.lines, key=lambda line: -line.u)),
            interaction_share=1.0 - sum(line.share for line in outcome.lines) if np.isfinite(u) and u > 0 else float("nan"),
            tier=outcome.tier, trials=outcome.summary.trials if outcome.summary else 0, linear_error=outcome.linear_error,
            summary=outcome.summary, indicated=float(self.indicated[i]), one_sided=gps.is_one_sided(c), why_not_shown=why,
            production=self.settings.production.get(c.name), filtered=self._filter(c), truth=truth, half_width=outcome.half,
            not_covered=() if predicts else between_touches(self.model.task, c),
        )  # fmt: skip
        if outcome.inverse is not None and not read:
            return result
        return at_indication(result, result.indicated, self.settings.rule)

    def _filter(self, c: Characteristic) -> str:
        """Filter, cut-off and tip with which a form is stated; empty without a filter."""
        if c.filter is None:
            return ""
        radii = sorted(
            {float(r) for r in self.model.task.touches.tip_radius[self.model.task.touches.rows[c.of[0]]]}
        )
        return f"{words(c.filter)}, tip radius {' and '.join(f'{r:g}' for r in radii)} mm"

    def _why_not_shown(self, c: Characteristic, outcome: _Outcome) -> str:
        """Return why the interval is not shown to hold the true value of a part that was measured; empty where it is."""
        if outcome.inverse is not None:
            return ""  # counted where the value is read
        if not outcome.tangent:
            bare = any(self.features[n].kind == "mesh" for n in gps.needs(c) if n in self.features)
            on_mesh = ", and no forms are drawn on a mesh" if bare else ""
            return f"{c.type} is an extreme value: its spread says nothing of the true value{on_mesh}"
        return ""

    def _bias_left_in(self, outcome: _Outcome, i: int, truth: Additive) -> float:
        """Return the known bias that the interval has to hold besides, mm or rad; 0 where it is corrected, or too small to matter."""
        bias = float(self.bias[i]) - truth.shift
        if self.model.world.predicts or not outcome.tangent or not bias:
            return 0.0
        kept = holds(truth.coverage(self.settings.p, self.settings.kind, bias), self.settings.p)
        return 0.0 if kept else bias


def _why_not_linear(outcome: _Outcome, settings: Settings) -> str:
    """Return why the linear model is not good enough for the interval; empty where it is, or where nothing was compared."""
    if outcome.tier == EXACT or not np.isfinite(outcome.linear_error):
        return ""
    low, high = outcome.law.interval(settings.p, settings.kind)
    half = (high - low) / 2 if outcome.half is None else outcome.half
    most = max(ERROR_SHARE * half, LEAST_NOTE)
    return "the linear model errs by more than a tenth of U" if outcome.linear_error > most else ""


def warnings_of(r: CharacteristicResult, predicts: bool = False) -> list[str]:
    """Return the warnings about one result. predicts: of a part still to be cut, whose errors are its deviation."""
    out = list(r.summary.warnings) if r.summary else []
    unit, scale = ("um", 1e3) if r.unit == "mm" else ("urad", 1e6)
    if r.bias_in_U:
        alone = (r.expanded - r.bias_in_U) * scale
        out.append(
            f"{r.name}: the known bias of {r.bias * scale:+.3g} {unit} is not corrected; interval, U and decision hold it: U = "
            f"{alone:.3g} {unit} + |bias| = {r.expanded * scale:.3g} {unit} (JCGM 100, F.2.4.5). Without it U is smaller: correct it, "
            '[job] known_bias = "corrected"'
        )
    if r.extreme and not predicts:
        text = f"{r.name}: {r.type} grows with noise and does not fall with it; "
        if r.why_not_shown:
            text += f"its coverage is not demonstrated: {r.why_not_shown}"
        elif abs(r.bias) <= ROUNDING_SHARE_OF_U * r.expanded:
            text += "no noise correction was applied"
        else:
            size = f"{abs(r.bias) * scale:.3g} {unit}"
            text += f"indicated value corrected by {'-' if r.bias > 0 else '+'}{size}"
        out.append(text)
    if not np.isfinite(r.u):
        out.append(
            f"{r.name}: u is infinite (a t-law with nu <= 2); the coverage interval is valid nevertheless"
        )
    if (
        r.tier != EXACT
        and np.isfinite(r.linear_error)
        and r.linear_error > max(0.01 * r.expanded, LEAST_NOTE)
    ):
        share = (
            f" ({r.linear_error / r.expanded:.1%} of U)" if r.expanded > r.linear_error else ", more than U"
        )
        size = f"{r.linear_error * 1e6:.3g} {'nm' if r.unit == 'mm' else 'urad'}"
        out.append(f"{r.name}: the linear model errs by up to {size}{share}; use --engine exact")
    return out
