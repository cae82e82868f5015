"""Which parameters of a candidate are numbers, and which are draws of many."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from vcmm.core.run import Run
from vcmm.learn.diagnosis.candidates import make_option
from vcmm.physics.catalogue.clamping import Clamping


@pytest.mark.parametrize(
    ("clamps", "measuring", "copies"), [("11", False, 1), ("12", False, 2), ("11", True, 1), ("12", True, 2)]
)
def test_the_bend_of_a_part_that_was_clamped_once_is_a_number(clamps, measuring, copies):
    """A part is cut in one clamping: three coefficients with names of their own. Else a set of three for every clamping."""
    run = Run({}, np.zeros((2, 3)), {}, {"clamp": np.array(list(clamps))})
    problem: Any = SimpleNamespace(
        run=run, recording=SimpleNamespace(measuring=measuring, row=np.arange(2)), columns=lambda effect, names: np.ones((2, 3)),
    )  # fmt: skip
    option = make_option(Clamping(), problem)
    assert option is not None
    assert len(option.labels) == 3 * copies
    assert any("@" in label for label in option.labels) == (measuring or copies > 1)
