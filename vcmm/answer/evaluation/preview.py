"""Evaluate without trials: value, U and budget of every result, fast enough while a knob moves.

The same code and the same draws as the whole evaluation (`vcmm.answer.evaluation.uncertainty`), so that U is the same number:

    closed form      the closed form itself; where the whole evaluation would take trials its U is the same within their error
    extreme values   the uncertainty that the machine adds to sampled parts that are off or rough (`Inversion.added`), without the belts
    the rest         (forms on meshes) None, since these need trials
"""

from __future__ import annotations

from dataclasses import replace

from vcmm.answer.evaluation.inversion import inversion_of
from vcmm.answer.evaluation.linear import prepare_model
from vcmm.answer.evaluation.result import CharacteristicResult
from vcmm.answer.evaluation.uncertainty import Evaluation
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.task import Task, evaluate_all, fit_features, measured_points

CERTIFIED = 20  # exact trials: they only tell whether a smooth output is curved


def at_once(task: Task, settings: Settings) -> tuple[CharacteristicResult | None, ...]:
    """Return results without interval and decision where they are extreme, None where trials are needed. Raises the errors of the task."""
    model = prepare_model(task, None)
    base = fit_features(task, measured_points(task, model.world.errors())) if task.forms else model.base
    quick = replace(settings, certify=min(settings.certify, CERTIFIED))
    whole = Evaluation(model, quick, lambda text, share: None, evaluate_all(task, base), None)
    numbers = range(len(model.characteristics))
    extreme = [i for i in numbers if not whole.is_tangent(i)]
    inverted = [i for i in extreme if whole.is_invertible(i)]
    inversion = inversion_of(task, settings, inverted) if inverted else None
    out: list[CharacteristicResult | None] = []
    for i in numbers:
        if i not in extreme:
            out.append(whole.without_trials(i, None))
        elif inversion is not None and i in inverted:
            out.append(whole.without_trials(i, inversion))
        else:
            out.append(None)
    return tuple(out)
