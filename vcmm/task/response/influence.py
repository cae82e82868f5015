"""Influence: the change of every observation by one Input. These are the columns of G before any fit.

For an Input on `effect[where].parameter` the unit response of the effect is carried to the tip and seen along x, y and z
(`vcmm.task.response.carrier`); for an Input on a run column the whole machine is evaluated a little to either side. Both give
d(indicated - true) / d(input) in workpiece axes, (n, 3, k). Two Inputs of one effect (a coefficient and its temperature)
also have a product term.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.knowledge import acted_on, targets
from vcmm.core.laws import MultivariateNormal, MultivariateSamples
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.response.carrier import Carrier, Sight, meet, responses, runs_one_step_apart


@dataclass(frozen=True, eq=False)
class Influence:
    """response (n, 3, k): change of indicated - true per unit of each element of the Input; workpiece axes, mm.

    copies: labels of the independent draws; codes (n,): which draw acts on which row.
    """

    input: Input
    response: Array
    copies: tuple[str, ...]
    codes: Any


def influences(machine: Machine, run: Run, inputs: Sequence[Input]) -> tuple[Influence, ...]:
    """Return one Influence per Input. `run` is prepared. Raises UsageError for a target that does not exist."""
    along, out = _carriers(machine, run), []
    for quantity in inputs:
        response = _response(machine, run, quantity, along)
        _check_size(quantity, response.shape[2])
        copies, codes = run.copies(quantity.redraw)
        out.append(Influence(quantity, response, tuple(copies), codes))
    return tuple(out)


def _response(machine: Machine, run: Run, quantity: Input, along: Sequence[Carrier]) -> Array:
    if quantity.members:
        acting = [m.is_channel or bool(acted_on(machine, m)) for m in quantity.members]
        parts = [
            _response(machine, run, m, along) if acts else np.zeros((run.n, 3, width))
            for m, acts, width in zip(quantity.members, acting, quantity.member_widths)
        ]
        return quantity.join_responses(parts)
    if quantity.is_channel:
        return _of_column(machine, run, quantity.parameter)
    return _of_parameter(machine, run, quantity, along)


def _check_size(quantity: Input, k: int) -> None:
    """Check that the law fits the number of elements of the parameter."""
    law, scale = quantity.law, quantity.scale
    given = None if scale is None or np.size(scale) == 1 else np.size(scale)
    if isinstance(law, MultivariateNormal):
        given = len(law.covariance)
    elif isinstance(law, MultivariateSamples):
        given = law.values.shape[1]
    if given is not None and given != k:
        raise UsageError(
            f"{quantity.id}: the law is for {given} numbers, but the parameter has {k}; give one for each"
        )


def _carriers(machine: Machine, run: Run) -> tuple[Carrier, ...]:
    """Return carriers of indicated - true along x, y and z of every row."""
    first = Carrier(machine, run, Sight(np.tile([1.0, 0.0, 0.0], (run.n, 1))))
    return (first, *(first.along(np.tile(axis, (run.n, 1))) for axis in np.eye(3)[1:]))


def _of_column(machine: Machine, run: Run, column: str) -> Array:
    """Return the response to a column (n, 3, 1): the whole machine with the column a little to either side."""
    high, low, step = runs_one_step_apart(run, column)
    return ((machine.indication_error(high) - machine.indication_error(low)) / (2 * step))[:, :, None]


def _of_parameter(machine: Machine, run: Run, quantity: Input, along: Sequence[Carrier]) -> Array:
    """Return the response to a parameter (n, 3, k): unit motions of the effects, carried to the tip."""
    effects = targets(machine, quantity)
    for effect in effects:
        machine.check_columns(effect, run)
    return np.stack(responses(along, quantity, effects), axis=1)


@dataclass(frozen=True, eq=False)
class Product:
    """Second-order term of two scalar Inputs: response (n, 3) per product of their departures at each row.

    first, second: numbers of the Influences. Their codes say which copies meet in a row.
    """

    first: int
    second: int
    response: Array


def products(machine: Machine, run: Run, influences: Sequence[Influence]) -> tuple[Product, ...]:
    """Return the mixed terms d2(indicated - true) / dx_i dx_j for pairs of scalar Inputs that meet in one effect.

    GUM H.1: alpha_s dTheta + theta dAlpha; the product of the two departures remains where an estimate is zero.
    """
    along: tuple[Carrier, ...] = ()
    out = []
    scalar = [i for i, f in enumerate(influences) if f.response.shape[2] == 1]
    scalar = [i for i in scalar if not isinstance(influences[i].input.law, MultivariateSamples)]
    for a, i in enumerate(scalar):
        for j in scalar[a + 1 :]:
            quantity, other = influences[i].input, influences[j].input
            if meet(machine, quantity, other):
                along = along or _carriers(machine, run)
                response = np.stack([carrier.product(quantity, other) for carrier in along], axis=1)
                if np.abs(response).max(initial=0.0) > 1e-12:
                    out.append(Product(i, j, response))
    return tuple(out)
