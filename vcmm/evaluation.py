"""Task-specific measurement uncertainty: value, U, coverage interval, decision and budget of every characteristic.

The tier follows from the characteristic, not from the caller:
    closed form           smooth outputs (size, distance, angle): u = sqrt(G S G^T); interval by inversion of the
                          characteristic function, t-laws treated exactly
    collapsed Monte Carlo form, orientation, position, and outputs in which a product of two Inputs matters
    exact                 on request: every trial with multiplied transforms, contact and iterated fits
A few hundred exact trials on the same draws certify the linear model in every case.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.effect import parameter
from vcmm.errors import UsageError
from vcmm.exact import draw_inputs, exact_values, linear_values
from vcmm.gps import characteristics as gps
from vcmm.gps.decision import Decision, decide
from vcmm.influence import targets
from vcmm.inputs import Input
from vcmm.laws import Law
from vcmm.linear import LinearModel, build
from vcmm.montecarlo import Term, marginal
from vcmm.montecarlo import uncertainty as closed_form_u
from vcmm.part import Characteristic
from vcmm.result import BudgetLine, CharacteristicResult, UncertaintyResult
from vcmm.run import Array
from vcmm.sampling import Progress, Sampler
from vcmm.settings import Settings
from vcmm.task import Task, evaluate_all, fit_features, measured_points
from vcmm.units import channel_unit

PRODUCT_SHARE = 1e-4  # a product of two Inputs that adds more than this share of the variance is sampled
CLOSED = "closed form; interval by inversion of the characteristic function"


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
    report = progress or (lambda text, share: None)
    model = build(task)
    report("certifying the linear model", 0.0)
    return _Evaluation(model, settings, report).result(certify(model, settings))


def certify(model: LinearModel, settings: Settings) -> Array:
    """(C,) largest |linear - exact| over `settings.certify` trials on common draws, mm or rad; inf for 0 trials."""
    if settings.certify == 0:
        return np.full(len(model.characteristics), np.inf)
    drawn = draw_inputs(model, settings.seed, 0, settings.certify)
    return np.asarray(np.abs(linear_values(model, drawn) - exact_values(model, drawn)).max(axis=0))


class _Evaluation:
    """One run over all characteristics; terms, gradient and values are made once."""

    def __init__(self, model: LinearModel, settings: Settings, progress: Progress) -> None:
        self.model, self.settings = model, settings
        self.features = model.task.part.features
        self.terms = model.terms()
        self.sampler = Sampler(model, self.terms, settings, progress)
        self.value = model.values(model.q0)
        self.perfect = _perfect(model.task)
        self.gradient = model.gradient()

    def result(self, errors: Array) -> UncertaintyResult:
        all_of_them = self.model.characteristics
        sampled = [i for i in range(len(all_of_them)) if not self._has_closed_form(i)]
        summaries = self.sampler.summaries(sampled) if sampled else {}
        alone = self.sampler.alone() if sampled else np.zeros((len(self.terms), len(all_of_them)))
        results = []
        for i, c in enumerate(all_of_them):
            found = self._sampled(i, c, summaries[i], alone[:, i]) if i in summaries else self._closed(i, c)
            results.append(replace(found, linear_error=float(errors[i])))
        warnings = tuple(w for r in results for w in warnings_of(r))
        return UncertaintyResult(
            tuple(results), self.settings.trials, self.settings.seed, warnings, self.model
        )

    def _has_closed_form(self, i: int) -> bool:
        smooth = gps.is_linear(self.model.characteristics[i], self.features)
        return smooth and self.settings.engine == "auto" and self._product_share(i) < PRODUCT_SHARE

    def _product_share(self, i: int) -> float:
        """Share of the variance that products of two Inputs add."""
        first, second = self._variances(i)
        return second / (first + second) if 0 < first + second < np.inf else 0.0

    def _variances(self, i: int) -> tuple[float, float]:
        """Closed-form variance of a smooth output: sum of (c u)^2, and of (d2y u_i u_j)^2 over products (JCGM 100, 5.1.2)."""
        scalar = {t.name: float(t.law.u) for t in self.terms if isinstance(t.law, Law)}
        second = 0.0
        for product in self.model.products:
            u = [scalar[self.model.influences[j].input.id] for j in (product.first, product.second)]
            second += (float(self.gradient[i] @ self.model.product_gain(product)) * u[0] * u[1]) ** 2
        return float(closed_form_u(self._projected(i))[0]) ** 2, second

    def _projected(self, i: int) -> list[Term]:
        """The terms acting on one characteristic: gain (1, L)."""
        return [replace(t, gain=(self.gradient[i] @ t.gain)[None]) for t in self.terms]

    def _closed(self, i: int, c: Characteristic) -> CharacteristicResult:
        terms = self._projected(i)
        linear = marginal(float(self.value[i]), terms, 0)
        interval = linear.interval(self.settings.p, self.settings.kind)
        lines = [
            self._line(j, float(closed_form_u([t])[0]), linear.u, _sensitivity(t))
            for j, t in enumerate(terms)
        ]
        limits = self._limits(i, c)
        p_conform = None if limits is None else linear.probability(*limits)
        return self._assembled(i, c, float(self.value[i]), linear.u, interval, lines, p_conform, CLOSED)

    def _sampled(self, i: int, c: Characteristic, found: object, alone: Array) -> CharacteristicResult:
        from vcmm.summary import Summary

        assert isinstance(found, Summary)
        smooth = gps.is_linear(c, self.features)
        if smooth:  # products aside it is linear: its contributions have a closed form
            parts = [(float(closed_form_u([t])[0]), _sensitivity(t)) for t in self._projected(i)]
            u = float(np.sqrt(sum(self._variances(i))))
        else:
            parts, u = [(float(alone_u), None) for alone_u in alone], found.u
        lines = [self._line(j, u_j, u, sensitivity) for j, (u_j, sensitivity) in enumerate(parts)]
        limits = self._limits(i, c)
        p_conform = None if limits is None else found.probability(*limits)
        tier = (
            "exact transforms, contact and fits"
            if self.settings.engine == "exact"
            else "collapsed Monte Carlo"
        )
        interval = found.interval(self.settings.p, self.settings.kind)
        value = float(self.value[i]) if smooth else found.mean
        result = self._assembled(i, c, value, u, interval, lines, p_conform, tier)
        return replace(result, trials=found.trials, summary=found, coverage_shown=smooth)

    def _limits(self, i: int, c: Characteristic) -> tuple[float, float] | None:
        tolerance = gps.tolerance(c, gps.nominal(c, self.features))
        if tolerance is None:
            return None
        return (-np.inf, tolerance[1]) if gps.one_sided(c) else tolerance

    def _decision(
        self, i: int, c: Characteristic, value: float, u: float, half: float, p: float | None
    ) -> Decision | None:
        limits = self._limits(i, c)
        if limits is None:
            return None
        finite_u = u if np.isfinite(u) else None
        return decide(
            value, limits, p, u=finite_u, U=half, rule=self.settings.rule, one_sided=gps.one_sided(c)
        )

    def _assembled(
        self, i: int, c: Characteristic, value: float, u: float, interval: tuple[float, float],
        lines: Sequence[BudgetLine], p_conform: float | None, tier: str,
    ) -> CharacteristicResult:  # fmt: skip
        nominal = gps.nominal(c, self.features)
        half = (interval[1] - interval[0]) / 2
        known = np.isfinite(u) and u > 0
        return CharacteristicResult(
            name=c.name, type=c.type, unit=gps.unit(c), nominal=nominal, value=value,
            bias=value - float(self.perfect[i]), u=u, k=half / u if known else float("nan"), p=self.settings.p,
            interval=interval, interval_kind=self.settings.kind, coverage_shown=True,
            tolerance=gps.tolerance(c, nominal), decision=self._decision(i, c, value, u, half, p_conform),
            budget=tuple(sorted(lines, key=lambda line: -line.u)),
            interaction_share=1.0 - sum(line.share for line in lines) if known else float("nan"),
            tier=tier, trials=0, linear_error=float("nan"), summary=None,
        )  # fmt: skip

    def _line(self, j: int, u_j: float, u: float, sensitivity: float | None) -> BudgetLine:
        influence = self.model.influences[j]
        one = influence.input
        estimate, unit = estimate_of(self.model.task, one)
        share = (u_j / u) ** 2 if np.isfinite(u) and u > 0 else float("nan")
        scalar = influence.response.shape[2] == 1
        law, factor = one.spread(influence.response.shape[2])
        u_input = float(np.ravel(law.u)[0]) * float(abs(factor[0, 0])) if scalar else None
        return BudgetLine(
            one.id, one.law.name, float(getattr(law, "dof", np.inf)), one.redraw, estimate, u_input, unit,
            sensitivity, u_j, share, one.evidence,
        )  # fmt: skip


def _perfect(task: Task) -> Array:
    """Characteristics of the same points on a machine without errors."""
    return evaluate_all(task, fit_features(task, measured_points(task, np.zeros((task.touches.run.n, 3)))))


def _sensitivity(term: Term) -> float | None:
    """dy/dx of a scalar Input; None for arrays and redrawn Inputs."""
    return float(term.gain[0, 0]) if term.gain.shape[1] == 1 else None


def estimate_of(task: Task, one: Input) -> tuple[float | None, str]:
    """(estimate, unit) of a scalar Input for the budget; None for arrays. Canonical units."""
    if one.is_channel:
        return float(np.mean(task.touches.run.column(one.parameter))), channel_unit(one.parameter)
    effect = targets(task.machine, one)[0]
    spec = parameter(effect, one.parameter)
    if spec.metadata["shape"]:
        return None, spec.metadata["show"]
    return float(getattr(effect, spec.name)), spec.metadata["show"]


def warnings_of(r: CharacteristicResult) -> list[str]:
    """What a reader must know about one result."""
    out = list(r.summary.warnings) if r.summary else []
    if not r.coverage_shown:
        out.append(
            f"{r.name}: {r.type} is an extreme value; the interval perturbs measured points and evaluates them again "
            "(the classic virtual-CMM recipe); its coverage was not shown"
        )
    if not np.isfinite(r.u):
        out.append(
            f"{r.name}: u is infinite (a t-law with nu <= 2); the coverage interval stands all the same"
        )
    if r.tier != CLOSED and r.tier.startswith("exact"):
        return out
    if r.linear_error > 0.01 * r.expanded:
        size = f"{r.linear_error * 1e6:.3g} {'nm' if r.unit == 'mm' else 'urad'}"
        out.append(
            f"{r.name}: the linear model errs by up to {size} ({r.linear_error / r.expanded:.1%} of U); use --engine exact"
        )
    return out
