"""Advice after a placement, from made-up outcomes: move or leave, room to the edge, what is the same everywhere."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace as Made

import numpy as np
import pytest

from tests.answer.placing.test_words import placed as worded
from vcmm.answer.placing.advice import advice
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, StudentT


def placed(gain: float | None, confirmed: bool | None = True) -> Made:
    made = worded()
    made.gain = gain
    made.confirmation = (
        None if confirmed is None else Made(is_confirmed=confirmed, present=2.0, gain=2.0 * (gain or 0.0))
    )
    made.objective.scenario = Made(machine=Made(inputs=()), inputs=())
    made.map = Made(names=("x", "turn_z"), x=np.linspace(0.0, 130.0, 5), y=np.linspace(0.0, 3.0, 4))
    return made


@pytest.mark.parametrize(
    ("gain", "confirmed", "says"),
    [
        (0.031, True, "3.1%: leave the part where it is; U stated"),
        (0.0501, True, "5.0%: worth moving"),
        (0.4, False, "40.0%, not confirmed by independent trials: leave"),
        (0.4, None, "40.0%: worth moving"),
        (None, None, "The present pose cannot be used"),
    ],
)
def test_move_or_leave(gain: float | None, confirmed: bool | None, says: str) -> None:
    assert advice(placed(gain, confirmed))[0].startswith(says)  # type: ignore[arg-type]


def test_a_confirmed_gain_is_that_of_the_independent_trials() -> None:
    """Searched 0.3 %, confirmed 0.01 of 2: 0.5 %."""
    made = placed(0.003)
    made.confirmation = Made(is_confirmed=True, present=2.0, gain=0.01)
    assert advice(made)[0].startswith("0.5%: leave")  # type: ignore[arg-type]


def test_room_and_what_stays() -> None:
    """x = 100 of 0 to 130 mm: 30 mm. u² = 25: a goes from 16 to 1, b stays at 9, which is 36 %."""
    _, room, same = advice(placed(0.4))  # type: ignore[arg-type]
    assert room == "The pose found lies 30 mm from the end of its range in x (0 to 130 mm)."
    assert same.startswith("gap: 36% of u² is the same at both poses, most of it from b:")


def test_no_advice_from_nodes_that_are_drawn_independently() -> None:
    """Between independent nodes the interpolation alone makes U small: at the middle of two nodes of 1 um it is 1/sqrt(2) um."""
    made = placed(0.4)
    known = Input("residual_field", "", "values", StudentT(1.0, 13.0), "touch", scale=np.full(24, 1e-3))
    made.objective.scenario.machine.inputs = (known,)
    (only,) = advice(made)  # type: ignore[arg-type]
    assert only.startswith("No advice: residual_field interpolates independent draws")
    assert "worth moving" not in only
    made.objective.scenario.machine.inputs = (replace(known, law=MultivariateNormal(np.eye(24))),)
    assert advice(made)[0].startswith("40.0%: worth moving")  # type: ignore[arg-type]
