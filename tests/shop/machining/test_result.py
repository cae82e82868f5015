"""Who owns a contribution, what scatters in a batch, and the extremes of a surface, by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.answer.evaluation.truth import PredictedPart
from vcmm.shop.machining.result import Patch, batch, expected_deviation, extremes, group_of, shares_by_group
from vcmm.show.tables.cut import surface_text


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
    assert shares_by_group(c)["machine"] == pytest.approx(1.0)
    assert sum(shares_by_group(SimpleNamespace(u=1e-9, budget=budget)).values()) == 0.0


def test_of_an_extreme_value_the_mean_is_expected():
    c = SimpleNamespace(extreme=True, mean=5.0, value=3.0, nominal=1.0, truth=None)
    assert expected_deviation(c) == 4.0  # of what a machine would read
    assert expected_deviation(SimpleNamespace(**{**vars(c), "extreme": False})) == 2.0
    part = PredictedPart(law=None, estimate=5.0)  # of the finished part the value is what is expected
    assert expected_deviation(SimpleNamespace(**{**vars(c), "value": 5.0, "truth": part})) == 4.0


def test_extremes_of_a_surface():
    """3, -4 um and one uncut: largest 4, rms sqrt(12.5); one place is gouged by the program alone."""
    patch = Patch(
        SimpleNamespace(feature="top"), np.array([3e-3, -4e-3, np.nan]), np.array([0.0, -0.02, np.nan])
    )
    found = extremes((patch,), 0.01)
    assert (found.max_um, found.points, found.uncut, found.gouges) == (pytest.approx(4.0), 3, 1, 1)
    assert found.rms_um == pytest.approx(np.sqrt(12.5))


def test_a_surface_that_was_not_looked_at_is_none_and_not_zero():
    """A feature of points has no net; a net that no tool reaches has no departure."""
    nothing = extremes((), 0.01, ("blade",))
    assert (nothing.max_um, nothing.rms_um, nothing.points, nothing.without) == (None, None, 0, ("blade",))
    assert "blade: points, lines and meshes have no net" in nothing.reason
    assert surface_text(nothing).startswith("surface: no figure; blade")
    net = SimpleNamespace(feature="top")
    missed = extremes((Patch(net, np.full(3, np.nan), np.full(3, np.nan)),), 0.01, ("top",))
    assert (missed.max_um, missed.uncut, missed.without) == (None, 3, ())
    assert missed.reason == "the tools reach none of the 3 points of the nets on the features"
    cut = extremes((Patch(net, np.array([1e-3]), np.zeros(1)),), 0.01, ("top", "blade"))
    assert cut.reason == ""
    assert surface_text(cut).endswith("not in it, since they have no net: blade")
