"""Machines from perfect to their limit: shares of bounds, and the probability under all of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import SCATTER, scenario
from vcmm.answer.evaluation.bound_shares import FULL, at_share, doubtful, possible_shares, split
from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.pairs import Machines, machine_part


def model(bound: bool):
    return build(scenario(inputs=(replace(SCATTER, bound=bound),)).task())


def test_what_is_known_is_taken_as_it_is() -> None:
    assert possible_shares(model(False).influences) == (FULL,)


def test_a_bound_goes_down_to_nothing() -> None:
    shares = possible_shares(model(True).influences)
    assert shares == ((1.0, 0.0), (1.0, 0.5), FULL)
    assert at_share([np.array([1.0]), np.array([10.0]), np.array([100.0])], (0.5, 0.25)) == pytest.approx(
        31.0
    )  # 1 + 0.5 x 10 + 0.25 x 100


def test_drawn_machines_at_a_share() -> None:
    """The same draws, half as large; at the limit those of the model itself."""
    one = model(True)
    known, own, scatter = split(one)
    assert (len(known.influences), len(own.influences), len(scatter.influences)) == (0, 0, 1)
    machines = Machines(one)
    full = machines.errors(3, 0, 50)
    assert full == pytest.approx(machine_part(one, 3, 0, 50))
    assert full.std() == pytest.approx(1e-3, rel=0.1)
    assert machines.errors(3, 0, 50, (1.0, 0.5)) == pytest.approx(full / 2)
    assert not machines.errors(3, 0, 50, (1.0, 0.0)).any()


def test_all_machines_must_agree() -> None:
    assert doubtful([0.97, 0.99]) == 0.97
    assert doubtful([0.01, 0.04]) == 0.04
    assert doubtful([0.01, 0.99]) == 0.5
    assert doubtful([0.6, 0.99]) == 0.6
