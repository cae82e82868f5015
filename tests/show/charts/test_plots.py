"""What is drawn is what the result holds: bars, lines, arrows and colours read back from the Axes."""

from __future__ import annotations

from itertools import pairwise
from types import SimpleNamespace

import matplotlib as mpl
import numpy as np
import pytest

import vcmm
from tests.plate import edited
from vcmm.files.own.recording import load_recording
from vcmm.show import charts, views
from vcmm.show.charts.space import round_down


@pytest.fixture(autouse=True)
def _without_a_screen():
    from matplotlib import pyplot as plt

    with mpl.rc_context({"figure.max_open_warning": 0}):
        plt.switch_backend("agg")
        yield
        plt.close("all")


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    return vcmm.load_scenario(edited(tmp_path_factory.mktemp("plate")))


@pytest.fixture(scope="module")
def result(scenario):
    return vcmm.uncertainty(scenario)


def test_budgets_show_their_shares_largest_first_and_sum_the_rest():
    lines = [
        SimpleNamespace(what=f"n{i}", u=1.0, share=s) for i, s in enumerate([0.1, 0.5, float("nan"), 0.4])
    ]
    ax = charts.contributions(lines)
    assert [t.get_text() for t in ax.get_yticklabels()] == ["n1", "n3", "n0"]
    assert [b.get_width() for b in ax.patches] == pytest.approx([50.0, 40.0, 10.0])
    many = charts.contributions([SimpleNamespace(what=f"n{i}", u=1.0, share=0.05) for i in range(20)])
    assert many.get_yticklabels()[-1].get_text() == "9 others"
    assert [b.get_width() for b in many.patches] == pytest.approx([5.0] * 11 + [45.0])


def test_every_characteristic_of_a_result_is_drawn(result):
    drawn, budgets = result.plot(), result.budget.plot()
    assert len(drawn) == len(budgets) == len(result.characteristics)
    for c, ax, bars in zip(result.characteristics, drawn, budgets):
        assert ax.get_title(loc="left").startswith(f"{c.name}: deviation from")
        shaded = ax.patches[-1]
        assert shaded.get_width() == pytest.approx((c.interval[1] - c.interval[0]) * 1e3)
        largest = max(line.share for line in c.budget)
        assert bars.patches[0].get_width() == pytest.approx(100 * largest)
    assert result.characteristics[0].budget.plot().get_title(loc="left") == "budget"


def test_a_scenario_shows_its_touches(scenario):
    ax = scenario.plot()
    touches = scenario.task().touches
    shown = sum(
        len(c.get_offsets()) for c in ax.collections if len(c.get_offsets()) and c.get_label()[0] != "_"
    )
    assert shown == len(touches.points)
    assert [t.get_text() for t in ax.get_legend().get_texts()] == list(touches.rows)


def test_arrows_are_magnified_by_a_round_number(scenario):
    field = vcmm.field(scenario.machine, nodes=3)
    assert "arrows 10000 x" in charts.motions(np.array([[0.0, 0, 0], [100, 0, 0]]), np.array([[0.0, 0, 0], [1e-3, 0, 0]]), "t").get_title(loc="left")  # fmt: skip
    assert [round_down(v) for v in (1.0, 1.99, 2.0, 4.9, 730.0, 0.06)] == pytest.approx(
        [1, 1, 2, 2, 500, 0.05]
    )
    assert f"{1e3 * field.size.max():.3g} µm" in field.plot().get_title(loc="left")


def test_readings_stand_over_the_axis_that_moved_by_their_sense(tmp_path):
    (tmp_path / "machine.toml").write_text(
        'vcmm = "machine/1"\nstructure = "w b Y X Z t"\n[axes.X]\ntravel = ["0 mm", "600 mm"]\n[axes.Y]\n'
        'travel = ["0 mm", "500 mm"]\n[axes.Z]\ntravel = ["-400 mm", "0 mm"]\n'
    )
    (tmp_path / "r.toml").write_text(
        'vcmm = "recording/1"\ndata = "r.csv"\nmachine = "machine.toml"\nkind = "path"\n'
    )
    (tmp_path / "r.csv").write_text(
        "X_mm,Y_mm,Z_mm,sense_X,dx_um\n0,9,0,1,1\n50,9,0,1,2\n100,9,0,1,3\n50,9,0,-1,5\n0,9,0,-1,6\n"
    )
    ax = load_recording(tmp_path / "r.toml")[0].plot()
    up, down, _ = ax.get_lines()  # and the line of zero
    assert (up.get_xdata().tolist(), up.get_ydata().tolist()) == ([0, 50, 100], pytest.approx([1, 2, 3]))
    assert (down.get_xdata().tolist(), down.get_ydata().tolist()) == ([50, 0], pytest.approx([5, 6]))
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("X / mm", "µm")


def test_a_band_holds_95_percent():
    nodes, value, u = (
        np.array([0.0, 100.0, 300.0]),
        np.array([0.0, 2e-3, -1e-3]),
        np.array([1e-3, 5e-4, 1e-3]),
    )
    found = SimpleNamespace(
        band=lambda name: (nodes, value, u),
        along=lambda name: (nodes, value, u),
        kept_model=SimpleNamespace(curves=()),
    )
    ax = views.error_curve(found, "EXX")
    assert ax.get_lines()[0].get_ydata() == pytest.approx([0.0, 2.0, -1.0])
    edge = ax.collections[0].get_paths()[0].vertices[:, 1]
    assert (edge.min(), edge.max()) == pytest.approx((-2.96, 2.98))  # -1 - 1.96, 2 + 1.96 / 2
    turned = views.error_curve(found, "EBX")
    assert (ax.get_ylabel(), turned.get_ylabel()) == ("µm", "µrad")


def test_heights_have_symmetric_colours_and_no_point_where_no_tool_came():
    ax = charts.heights(np.eye(3), np.array([2.0, np.nan, -5.0]), "t")
    made = ax.collections[0]
    assert (made.norm.boundaries[0], made.norm.boundaries[-1]) == (-5.0, 5.0)
    assert sorted(made.get_array().tolist()) == [-5.0, 2.0]


@pytest.mark.parametrize("size", [(30, 30, 200), (1200, 300, 20)])
def test_names_of_a_long_box_stay_in_the_picture_and_its_numbers_apart(size):
    corners = np.array(np.meshgrid(*[(0.0, s) for s in size])).reshape(3, -1).T
    ax = charts.motions(corners, np.zeros_like(corners), "t", charts.ChartSheet())
    figure = ax.figure
    figure.draw_without_rendering()
    words = [ax.xaxis, ax.yaxis, ax.zaxis]
    boxes = [a.label.get_window_extent() for a in words]
    numbers = [[t.label1.get_window_extent() for t in a.get_major_ticks()] for a in words]
    assert all(figure.bbox.x0 <= b.x0 and b.x1 <= figure.bbox.x1 for b in boxes)
    assert all(figure.bbox.y0 <= b.y0 and b.y1 <= figure.bbox.y1 for b in boxes)
    for several in numbers:
        assert not [1 for one, other in pairwise(several) if one.overlaps(other)]


def test_pictures_in_space_of_nothing_are_empty():
    none = np.zeros((0, 3))
    assert charts.motions(none, none, "t", charts.ChartSheet()).get_title(loc="left") == "t, arrows 1 x"
    assert charts.touches(none, none, np.zeros(0, str), "t", charts.ChartSheet()).name == "3d"
