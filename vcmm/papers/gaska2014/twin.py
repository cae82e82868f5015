"""Twin of Gaska et al. 2014: a compressor body at five places of a Leitz PMM 12106.

Int. J. Adv. Manuf. Technol. 73 (2014) 497-507. Typed in from the paper: the nodes (Table 1), eight rows of standard
deviations (Table 2), the results (Table 3). Everything else the paper leaves unpublished is drawn, and the range over
many draws that agree with its published maxima and means is shown beside one draw. No agreement is claimed: the paper
does not say that Table 3's U is an output of its model.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, StudentT
from vcmm.core.run import Array
from vcmm.evaluation.linear import LinearModel
from vcmm.evaluation.montecarlo import Term
from vcmm.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.evaluation.streams import copy_code, draw
from vcmm.evaluation.uncertainty import evaluate
from vcmm.measuring.scenario import Scenario
from vcmm.papers.gaska2014.nodes import NU, draw_deviations
from vcmm.response.influence import Influence

PAPER_FORM_U = {"1": 0.6, "2": 0.8, "3": 0.5, "4": 0.9, "5": 0.5}  # Table 3, um
PAPER_DISTANCE_U = {"1": 0.4, "2": 0.5, "3": 0.4, "4": 0.6, "5": 0.3}
FIELD = "residual_field"
REDRAWS = ("run", "touch")
CAPTION = (
    "Form: by the paper's recipe, coverage not shown. paper: U of Table 3, not stated to be the output of its model.\n"
    "44 of 52 nodes, part, places, plan, probe and tolerances are drawn; the range is over machines that all agree\n"
    "with the published maxima and means. No agreement is claimed."
)


@dataclass(frozen=True)
class Row:
    """One place: form and distance results for one redraw rule, and the range of U over consistent draws (mm)."""

    place: str
    redraw: str
    form: CharacteristicResult
    distance: CharacteristicResult
    form_range: tuple[float, float]
    distance_range: tuple[float, float]
    result: UncertaintyResult


def with_field(scenario: Scenario, redraw: str, deviations: Array | None = None) -> Scenario:
    """The scenario with the residual field redrawn per `redraw`, and other standard deviations (52, 3) um if given."""

    def changed(one: Input) -> Input:
        if one.effect != FIELD:
            return one
        scale = one.scale if deviations is None else deviations.ravel() * 1e-3
        return replace(one, redraw=redraw, scale=scale)

    inputs = tuple(changed(i) for i in scenario.machine.inputs)
    return replace(scenario, machine=replace(scenario.machine, inputs=inputs))


def field_scales(scenario: Scenario) -> Array:
    """(52, 3) mm: the scale of the t-law at each node."""
    one = next(i for i in scenario.machine.inputs if i.effect == FIELD)
    assert one.scale is not None
    return one.scale.reshape(-1, 3)


def run(
    scenario: Scenario,
    draws: int = 200,
    trials: int | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> list[Row]:
    """All places, both redraw rules. draws: machines consistent with the published figures, for the ranges."""
    report = progress or (lambda text, share: None)
    settings = replace(scenario.settings, trials=trials or scenario.settings.trials, certify=50)
    fields = [draw_deviations(seed) for seed in range(1, draws + 1)]
    rows: list[Row] = []
    total = len(scenario.places) * len(REDRAWS)
    for place, pose in scenario.places.items():
        for redraw in REDRAWS:
            report(f"place {place}, field per {redraw}", len(rows) / total)
            task = with_field(scenario, redraw).at(pose).task()
            result = evaluate(task, settings)
            form, distance = (
                next(c for c in result.characteristics if c.type == t) for t in ("cylindricity", "distance")
            )
            form_range, distance_range = _ranges(result.model, fields, form, distance, settings.seed)
            rows.append(
                Row(
                    place=place,
                    redraw=redraw,
                    form=by_recipe(form),
                    distance=distance,
                    form_range=form_range,
                    distance_range=distance_range,
                    result=result,
                )
            )
    return rows


def by_recipe(form: CharacteristicResult) -> CharacteristicResult:
    """As the paper takes it: U is half of where 95 % of the indicated values lie, whatever they say of the true one."""
    assert form.summary is not None
    low, high = form.summary.interval(form.p, form.interval_kind)
    u = form.summary.u
    return replace(form, interval=(low, high), half_width=None, u=u, k=(high - low) / 2 / u)


RANGE_TRIALS = 2000


def _ranges(
    model: LinearModel,
    fields: list[Array],
    form: CharacteristicResult,
    distance: CharacteristicResult,
    seed: int,
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Smallest and largest U over the draws. The standard t-draws are common to all draws of the field: only the
    deviations differ. U of the distance = k u with k of the shown draw; U of the form from 2000 trials each.
    """
    index = {c.name: i for i, c in enumerate(model.characteristics)}
    gradient = model.gradient()[index[distance.name]]
    others = [model.term(i) for i in model.influences if i.input.effect != FIELD]
    influence = next(i for i in model.influences if i.input.effect == FIELD)
    rest = sum(float(((gradient @ t.gain) ** 2).sum()) * t.law.u**2 for t in others)
    per_lane = _per_lane(gradient @ model.operator, model.along_normal(influence), influence.codes)
    form_trials = _FormTrials(model, influence, others, form.name, seed)
    scales = np.array([deviations.ravel() * 1e-3 for deviations in fields])
    variance = scales**2 @ (per_lane**2).sum(axis=0) * StudentT(1.0, NU).u ** 2 + rest
    u_distance = distance.k * np.sqrt(variance)
    u_form = np.concatenate(
        [form_trials.expanded(part) for part in np.array_split(scales, max(1, len(scales) // 25))]
    )
    return (float(u_form.min()), float(u_form.max())), (float(u_distance.min()), float(u_distance.max()))


def _per_lane(weights: Array, along: Array, codes: npt.NDArray[np.intp]) -> Array:
    """(copies, k): change of one output per draw, for weights (n,) of the touches and their responses (n, k)."""
    out = np.zeros((int(codes.max()) + 1, along.shape[1]))
    np.add.at(out, codes, weights[:, None] * along)
    return out


class _FormTrials:
    """Trials of the bore's form whose standard draws are kept, so that 200 fields cost 200 small products."""

    def __init__(
        self, model: LinearModel, influence: Influence, others: list[Term], name: str, seed: int
    ) -> None:
        feature = next(c for c in model.characteristics if c.name == name).of[0]
        block, rows = model.blocks[feature], model.task.touches.rows[feature]
        residuals = slice(block.stop - block.residuals, block.stop)
        self.operator = model.operator[residuals][:, rows]
        along = model.along_normal(influence)[rows]
        self.used = [np.flatnonzero(touch) for touch in along]
        self.draws = []  # per touch: (nodes that act on it, trials) standard draws times their response
        for row, touch, used in zip(rows, along, self.used):
            code = copy_code(influence.copies[influence.codes[row]])
            lanes = np.array([(k, code) for k in used], dtype=np.uint32)
            z = draw(seed, influence.input.id, lanes, StudentT(1.0, NU), 0, RANGE_TRIALS)
            self.draws.append(touch[used, None] * z.T)
        self.base = np.tile(model.q0[residuals, None], (1, RANGE_TRIALS))
        for term in others:
            assert not isinstance(
                term.law, MultivariateNormal
            )  # its draws are standard normals times a factor
            self.base += term.gain[residuals] @ draw(seed, term.name, term.lanes, term.law, 0, RANGE_TRIALS).T

    def expanded(self, scales: Array) -> Array:
        """Half the 95 % interval of the form (m,) mm, for m sets of standard deviations (m, 3 nodes)."""
        touches = np.stack([scales[:, used] @ z for used, z in zip(self.used, self.draws)])
        residuals = self.operator @ touches.reshape(len(self.used), -1)
        residuals = residuals.reshape(touches.shape) + self.base[:, None, :]
        form = residuals.max(axis=0) - residuals.min(axis=0)
        low, high = np.quantile(form, [0.025, 0.975], axis=1)
        return np.asarray(high - low) / 2
