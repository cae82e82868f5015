"""Who owns a contribution, what scatters in a batch, and the extremes of a surface, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.machining.result import Patch, batch, expected, extremes, group_of, grouped


def line(name: str, u: float = 1.0, share: float = 0.5, redraw: str = "machine") -> SimpleNamespace:
    return SimpleNamespace(input=name, u=u, share=share, redraw=redraw)


@pytest.mark.parametrize(
    ("name", "group"),
    [
        ("tool_length[1].value", "tool"),
        ("work_offset[G54].offset", "setup"),
        ("part_expansion.alpha", "part"),
        ("channel.temp_part_C", "part"),
        ("cmm: scale_factor[X].k", "measurement"),
        ("scale_factor[X].k", "machine"),
    ],
)
def test_groups_of_contributions(name, group):
    assert group_of(line(name)) == group


def test_shares_and_what_scatters():
    """u 5: 3 scatters from part to part, sqrt(25 - 9) = 4 repeats."""
    budget = [line("scale_factor[X].k", 4.0, 0.64), line("scatter.value", 3.0, 0.36, "touch")]
    c = SimpleNamespace(u=5.0, budget=budget)
    assert batch(c) == pytest.approx((4.0, 3.0))
    assert grouped(c)["machine"] == pytest.approx(1.0)
    assert sum(grouped(SimpleNamespace(u=1e-9, budget=budget)).values()) == 0.0


def test_of_an_extreme_value_the_mean_is_expected():
    c = SimpleNamespace(extreme=True, mean=5.0, value=3.0, nominal=1.0)
    assert expected(c) == 4.0
    assert expected(SimpleNamespace(**{**vars(c), "extreme": False})) == 2.0


def test_extremes_of_a_surface():
    """3, -4 um and one uncut: largest 4, rms sqrt(12.5); one place is gouged by the program alone."""
    patch = Patch(None, np.array([3e-3, -4e-3, np.nan]), np.array([0.0, -0.02, np.nan]))
    found = extremes((patch,), 0.01)
    assert (found.max_um, found.points, found.uncut, found.gouges) == (pytest.approx(4.0), 3, 1, 1)
    assert found.rms_um == pytest.approx(np.sqrt(12.5))
