"""Choose the next measurement: the feasible add-on that separates the tied answers best per minute.

Each add-on repeats a sample of the recording's own rows with one thing changed (see addons). The rows are simulated,
not measured: only the columns of the rivals on old and new rows together decide. separability s as in `rivals`. Where no add-on
helps, the catalogue says what confirms a name.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, left_beside, whitener
from vcmm.core.axes import is_rotary
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.addons import (
    ADDONS,
    PER_TOUCH,
    ROWS,
    AddOn,
    along_axes,
    extend_recording,
    instruction,
    minutes_of,
)
from vcmm.learn.diagnosis.candidates import Option
from vcmm.learn.diagnosis.constants import LEAST_FRACTION, SUREST, UNSEEN
from vcmm.learn.diagnosis.discrepancy import covariate_values
from vcmm.learn.diagnosis.evidence import best_mimic
from vcmm.learn.diagnosis.problem import Problem, predecessors
from vcmm.learn.diagnosis.result import NextStep, Unknown
from vcmm.learn.diagnosis.rivals import Standing
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, Setting
from vcmm.physics import BY_NAME
from vcmm.task.response.observe import Observer, nuisance_columns

PLACES = 60  # along the covariate of something unknown
LEAST_GAIN = 0.08  # gain of separability below which an add-on is not proposed
MOST_SHOWN = 3
CONFIRMED = 30.0  # minutes for a measurement of another kind


def next_steps(
    problem: Problem, setting: Setting, selection: Selection, standings: Sequence[Standing]
) -> tuple[NextStep, ...]:
    """Return the best add-ons for every answer that has rivals, at other places too; where none of them helps, the confirmation of the name."""
    out: list[NextStep] = []
    for i, standing in enumerate(standings):
        here = list(zip(standing.twins, standing.shares))[:1] or list(
            standing.elsewhere[:1]
        )  # the same name at another place
        candidates = [*here, *((j, standing.rival_probability) for j in standing.families[:1])]
        rivals = [j for j, _ in candidates]
        steps = [
            f
            for j, share in candidates
            for f in _for_rival(problem, setting, selection, i, j, log_odds(standing.probability, share))
        ]
        if rivals and not steps:
            steps = _confirmation_steps(problem, selection, i, _pair(selection, i, setting, rivals[0]))
        elif standing.names and not steps:  # a rival that these rows do not resolve is no candidate
            steps = _confirmation_steps(
                problem, selection, i, (selection.terms[i].family.name, standing.names[0])
            )
        out += steps
    return tuple(out)


def _for_rival(
    problem: Problem, setting: Setting, selection: Selection, i: int, family: int, odds: float
) -> list[NextStep]:
    """Return the add-ons that separate term i from one rival, the best per minute first. odds: ln of term over rival."""
    rival = _nearest(setting, selection, family, i)
    pair = _pair(selection, i, setting, family)
    columns = (selection.terms[i].option.columns, rival.columns)
    question = _RivalPair(pair, odds, pair_separability(columns, problem.whitener(), selection, i))
    steps = [
        _try_addon(problem, addon, selection, i, rival, question) for addon in (*ADDONS, *along_axes(problem))
    ]
    return sorted((f for f in steps if f is not None), key=lambda f: -f.gain / f.minutes)[:MOST_SHOWN]


@dataclass(frozen=True)
class _RivalPair:
    """Two names, ln of their odds, and the share of the first one's signal that the other cannot mimic, as length and in noise."""

    pair: tuple[str, str]
    odds: float
    now: tuple[float, float]


def _pair(selection: Selection, i: int, setting: Setting, family: int) -> tuple[str, str]:
    """Return the pair that is separated: two names, or one name at two places."""
    mine, rival = selection.terms[i].family, setting.candidates.families[family]
    return (mine.id, rival.id) if mine.name == rival.name else (mine.name, rival.name)


def _confirmation_steps(
    problem: Problem, selection: Selection, i: int, pair: tuple[str, str]
) -> list[NextStep]:
    """Return the instruction of the catalogue, where repeated rows do not separate the two."""
    do = confirmation_text(selection.terms[i], pair[1], problem.run)
    return [NextStep(pair, do, CONFIRMED, 0.0)] if do else []


def steps_for_unknown(problem: Problem, unknown: Unknown | None) -> tuple[NextStep, ...]:
    """Return how to find the law of a departure without a name: its first covariate varied finely, all else equal."""
    if unknown is None or not unknown.covariates:
        return ()
    name = unknown.covariates[0]
    values = covariate_values(problem, name)
    if name.removeprefix("tip_").upper() in problem.run.position and values is not None:
        low, high = float(values.min()), float(values.max())
        step = (high - low) / PLACES
        axis = name.removeprefix("tip_").upper()
        do = f"measure {axis} from {low:.4g} to {high:.4g} in steps of {step:.2g}, both ways, all else equal"
    elif name.startswith("temp_"):
        do = f"repeat some touches at three values of {name}, at the same places"
    elif name == "time":
        do = "touch one place again and again, as fast as possible, for as long as the log was"
    elif name == "speed" or name.startswith("speed_"):
        do = "repeat some touches at three speeds, at the same places"
    else:
        return ()
    pace = PER_TOUCH if problem.recording.kind == "probe" else 1.0
    return (NextStep(("unknown", name), do, float(round(2 * PLACES * pace / 60)), 0.0),)


def _nearest(setting: Setting, selection: Selection, family: int, i: int) -> Option:
    """Return the rival's option that mimics the answer best."""
    return setting.candidates.options[best_mimic(setting.candidates, family, selection.signal(i))]


def pair_separability(
    columns: tuple[Array, Array], white: Whitener, selection: Selection, i: int
) -> tuple[float, float]:
    """Return the share of the answer's signal, as length, that the rival cannot mimic; and the same in units of the noise of this whitener."""
    assert selection.fit is not None
    signal = white.apply(columns[0] @ selection.fit.mean[selection.span(i)])
    length = float(np.linalg.norm(left_beside(signal, white.apply(columns[1]))))
    return length / max(float(np.linalg.norm(signal)), LEAST_FRACTION), length / selection.fit.sigma


def _try_addon(
    problem: Problem,
    addon: AddOn,
    selection: Selection,
    i: int,
    rival: Option,
    question: _RivalPair,
) -> NextStep | None:
    """Return the add-on with its expected result; None where it cannot be done, separates no better, or decides no more."""
    try:
        longer = extend_recording(problem, addon)
        if longer is None:
            return None
        recording, u = longer
        observer = Observer(recording, problem.machine)
        columns = tuple(_columns_on(observer, o) for o in (selection.terms[i].option, rival))
        nuisance, _ = nuisance_columns(recording, problem.machine)
        calibrations = [c for _, c in observer.calibration()]
        calibration = np.concatenate([np.zeros((recording.m, 0)), *calibrations], axis=1)
        white = whitener(u, nuisance, calibration, predecessors(recording.row))
        then = pair_separability((columns[0], columns[1]), white, selection, i)
    except (ModelLimit, UsageError):
        return None
    gain = then[0] - question.now[0]
    before, after = (
        expected_probability(question.odds, more) for more in (0.0, then[1] ** 2 - question.now[1] ** 2)
    )
    if gain <= LEAST_GAIN or after - before <= LEAST_GAIN * (1.0 - before):
        return None
    return NextStep(question.pair, instruction(addon, problem), minutes_of(addon, problem), gain, after)


def _columns_on(observer: Observer, option: Option) -> Array:
    """Return the columns of an option on another recording. Raises UsageError for random copies, whose number would differ."""
    if option.effect is None or any("@" in label for label in option.labels):
        raise UsageError("this effect has one copy per label; it cannot be carried to another recording")
    names = dict.fromkeys(label.split("[")[0] for label in option.labels)
    parts = [observer.of_parameter(option.effect, name) for name in names]
    return np.concatenate(parts, axis=1) * option.unit


def confirmation_text(term: SelectedTerm, rival: str, run: Run) -> str:
    """Return what confirms the name, or, where the axes of a run cannot do that, what confirms its rival; "" where there is neither."""
    effect = term.option.effect
    words = [
        effect.about.words if effect is not None else None,
        BY_NAME[rival].about.words if rival in BY_NAME else None,
    ]
    sentences = [w.confirm for w in words if w is not None and _is_possible(w.confirm, run)]
    if effect is None or not sentences:
        return ""
    values = defaultdict(str, {k: str(v) for k, v in term.family.where.items()})
    values["where"] = " ".join(term.family.where.values())
    return sentences[0].format_map(values)


def _is_possible(confirm: str, run: Run) -> bool:
    """Return whether the confirmation is possible; a circle takes two linear axes."""
    return "circular test" not in confirm or sum(not is_rotary(a) for a in run.position) > 1


def log_odds(first: float, other: float) -> float:
    return float(np.log(max(first, UNSEEN) / max(other, UNSEEN)))


def expected_probability(odds: float, more: float) -> float:
    """Return the probability of whichever of two names is right, expected after an add-on that adds `more` of squared distance between them.

    The added ln BF is normal about +more/2 where the first is right and about -more/2 where the other is, with variance `more`
    (Lindley, Ann. Math. Stat. 27 (1956) 986); it is evaluated at ROWS even quantiles.
    """
    z = np.array([NormalDist().inv_cdf((k + 0.5) / ROWS) for k in range(ROWS)])
    added = 0.5 * more + np.sqrt(max(more, 0.0)) * z
    first = 1.0 / (1.0 + np.exp(-odds))
    right = np.mean(1.0 / (1.0 + np.exp(np.clip(-odds - added, -SUREST, SUREST))))
    other = np.mean(1.0 / (1.0 + np.exp(np.clip(odds - added, -SUREST, SUREST))))
    return float(first * right + (1.0 - first) * other)
