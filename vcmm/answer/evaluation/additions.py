"""Uncertainty that the machine adds to parts that are off or rough: u and half of where p lie, by Input, by the form."""

from __future__ import annotations

import numpy as np

from vcmm.answer.evaluation.exact import draw_inputs
from vcmm.answer.evaluation.form_family import KNOWN
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.pairs import Drawing, Largest, machine_part, of_input, surfaces, values
from vcmm.core.run import Array
from vcmm.task.measuring.settings import Settings

ADDED, ADDED_BY_CONTACT = 2000, 300  # parts from which U is estimated


def of_parts(
    drawing: Drawing, settings: Settings, form: float, off: float, by_contact: bool
) -> tuple[Array, Array, Array, Array]:
    """Return u (C,), half (C,), by Input (m, C), by the form (C,). by_contact: elements by contact are searched in every part."""
    count = ADDED_BY_CONTACT if by_contact else ADDED
    model, place = drawing.measured, (settings.seed + 4, 0)
    touched, surface = surfaces(drawing, count, place, (KNOWN[0], Largest(), form), off)
    true, still = values(drawing.surface, surface), values(model, touched)
    error = values(model, touched + machine_part(model, *place, count)) - true
    low, high = np.nanquantile(error, [(1 - settings.p) / 2, (1 + settings.p) / 2], axis=0)
    alone = [
        _alone(model, touched, still, moved)
        for moved in (of_input(model, d) for d in draw_inputs(model, *place, count))
    ]
    by_form = np.nanstd(still - true, axis=0)
    return np.nanstd(error, axis=0), (high - low) / 2, np.array(alone).reshape(-1, len(low)), by_form


def _alone(model: LinearModel, touched: Array, still: Array, moved: Array) -> Array:
    """Return the standard deviation (C,) that one Input adds."""
    if not moved.any():
        return np.zeros(still.shape[1])
    return np.asarray(np.nanstd(values(model, touched + moved) - still, axis=0))
