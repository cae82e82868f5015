"""Stated forms of features: the known part is a form, the unknown part is a separate Input.

form = { lobes = 3, amplitude = "1 um", phase = "20 deg" }   known: a bias where the points do not average it
form = { lobes = 3, amplitude = "1 um" }                     the phase is not known: any value
form = { amplitude = "1 um" }                                only its size is known: forms of the default families
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateSamples
from vcmm.core.run import Array
from vcmm.part.fit import FittedElement, gauss
from vcmm.part.form import Lobes
from vcmm.part.gps.criteria import with_criteria
from vcmm.part.part import Feature, normal
from vcmm.part.random_form import SINGLE, SMOOTH, random_forms, whole_surface
from vcmm.task.measuring.task import Task, evaluate_all, fit_features, measured_points, nominal_element
from vcmm.task.response.influence import Influence

FORM = "form"  # names the Inputs of unknown forms: form[bore].phase, form[bore].shape
PHASES, SHAPES = 720, 2000


def without_unknown(task: Task) -> Task:
    """Return the task with its known forms only: the unknown part of them is sampled. Measured points contain the form that they met: it stays."""
    if task.from_points:
        return task
    out = task.form.copy()
    for name, form in task.forms.items():
        rows = task.touches.rows.get(name)
        if rows is not None and not form.has_phase:
            out[rows] -= form.deviation(task.part.features[name], task.touches.points[rows])
    return replace(task, form=out)


def form_influences(task: Task) -> tuple[Influence, ...]:
    """Return the effect on the touches of forms of which the phase or the shape is not known; sampled per part."""
    out = []
    for name, form in task.forms.items():
        rows = task.touches.rows.get(name)
        if rows is None or form.has_phase or not form.amplitude:
            continue
        feature, points = task.part.features[name], task.touches.points[rows]
        height, law, what = _lobes(form, feature, points) if form.lobes else _shapes(form, feature, points)
        response = np.zeros((task.touches.run.n, 3, height.shape[1]))
        response[rows] = task.touches.run.normal[rows][:, :, None] * height[:, None, :]
        quantity = Input(FORM, name, what, law, "part", "form stated in the scenario")
        codes = np.zeros(task.touches.run.n, dtype=np.intp)
        out.append(Influence(quantity, response, ("",), codes))
    return tuple(out)


def _lobes(form: Lobes, feature: Feature, points: Array) -> tuple[Array, MultivariateSamples, str]:
    """Return heights (n, 2) of the cosine and of the sine, whose amounts go round a circle."""
    height = np.stack(
        [replace(form, amplitude=1.0, phase=p).deviation(feature, points) for p in (0.0, np.pi / (2 * form.lobes))], axis=1
    )  # fmt: skip
    turn = (np.arange(PHASES) + 0.5) * (2 * np.pi / PHASES)
    return (
        height,
        MultivariateSamples(form.amplitude * np.stack([np.cos(turn), np.sin(turn)], axis=1)),
        "phase",
    )


def _shapes(form: Lobes, feature: Feature, points: Array) -> tuple[Array, MultivariateSamples, str]:
    """Return separate heights (n, n) for all touches, sampled together from the default families."""
    rng = np.random.default_rng(20261122)
    values = [random_forms(feature, points, SHAPES // 2, family, rng) for family in (SMOOTH, SINGLE)]
    values = [np.concatenate([v, -v]) for v in values]  # as many one way up as the other
    return np.eye(len(points)), MultivariateSamples(2 * form.amplitude * np.concatenate(values)), "shape"


def true_values(task: Task) -> Array:
    """Return characteristics (C,) of the part itself: elements through the whole surface where a known form is stated."""
    forms = {n: f for n, f in task.forms.items() if f.has_phase and n in task.touches.rows}
    if not forms:
        return task.without_errors
    if task.from_points:
        return _less_known(task, forms)
    still = np.zeros((task.touches.run.n, 3))
    points = {n: measured_points(task, still)[rows] for n, rows in task.touches.rows.items()}
    fitted = fit_features(task, measured_points(task, still))
    for name, form in forms.items():
        feature = task.part.features[name]
        points[name], fitted[name] = _whole(feature, form)
    part = task.part
    return evaluate_all(task, with_criteria(part.characteristics, part.features, points.__getitem__, fitted))


def _less_known(task: Task, forms: Mapping[str, Lobes]) -> Array:
    """Return characteristics (C,) of measured points less the known forms at them, which have no size, place or direction of their own."""
    form = task.form.copy()
    for name, lobes in forms.items():
        rows = task.touches.rows[name]
        form[rows] -= lobes.deviation(task.part.features[name], task.touches.points[rows])
    return replace(task, form=form).without_errors


def _whole(feature: Feature, form: Lobes) -> tuple[Array, FittedElement]:
    dense = whole_surface(feature)
    points = dense + form.deviation(feature, dense)[:, None] * normal(feature, dense)
    fixed = feature.axis if feature.kind == "circle" else None
    return points, gauss(feature.kind, points, nominal_element(feature), fixed_axis=fixed)
