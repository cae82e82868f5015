"""Pictures of the trade: their numbers by pencil, and the same as those of the table."""

from __future__ import annotations

import html
import json
import math
import re

import numpy as np
import pytest

from tests.learn.calibration.drawn import bare
from tests.learn.calibration.test_standard_figures import ball_bar
from tests.learn.calibration.test_standards import DOWN, UP
from vcmm.core.errors import DataError
from vcmm.learn.calibration.deviations import RecordedTest
from vcmm.learn.calibration.standard_figures import evaluate_recordings
from vcmm.show.charts import (
    ChartSheet,
    PolarTrace,
    ReferenceCircle,
    boxes,
    is_grouped,
    on_page,
    positioning_band,
    traces,
    waterfall,
)
from vcmm.show.pages.acceptance import acceptance_page


def numbers(page: str) -> list[dict]:
    return [json.loads(html.unescape(m)) for m in re.findall(r'data-chart="([^"]*)"', page)]


def test_a_waterfall_adds_in_quadrature():
    """3 and 4 make 5, with 12 they make 13; the table's 13 needs no interaction, 14 needs sqrt(14^2 - 13^2) = 5.196 more."""
    (shown,) = numbers(on_page(waterfall, [("a", 3.0), ("b", 12.0), ("c", 4.0)], 13.0, unit="µm", title="t"))
    assert shown["names"] == ["b", "c", "a"]
    assert shown["ends"] == pytest.approx([12.0, math.sqrt(160.0), 13.0])
    assert shown["total"] == 13.0
    (more,) = numbers(on_page(waterfall, [("a", 5.0), ("b", 12.0)], 14.0, unit="µm", title="t"))
    assert more["names"][-1] == "interaction"
    assert more["values"][-1] == pytest.approx(math.sqrt(27.0))
    (less,) = numbers(on_page(waterfall, [("a", 5.0), ("b", 12.0)], 12.0, unit="µm", title="t"))
    assert less["values"][-1] == pytest.approx(-5.0)
    assert less["ends"][-1] == 12.0


def test_a_waterfall_sums_up_what_is_small():
    items = [(str(i), 1.0) for i in range(12)]
    (shown,) = numbers(on_page(waterfall, items, math.sqrt(12.0), unit="µm", title="t"))
    assert shown["names"][-1] == "4 others"
    assert shown["values"][-1] == pytest.approx(2.0)
    assert shown["ends"][-1] == pytest.approx(math.sqrt(12.0))


def test_a_band_is_two_standard_deviations_of_the_mean_line():
    """Up 1, 3 at one target: mean 2, s = sqrt(2); down 0, 0: mean 0, s = 0. A = 2 + 2 sqrt 2 - min(2 - 2 sqrt 2, 0) = 4 sqrt 2."""
    (shown,) = numbers(
        on_page(positioning_band, [0.0], [[1.0, 3.0]], [[0.0, 0.0]], {"A": 1.0}, title="t", unit="µm")
    )
    assert shown["mean_up"] == [2.0]
    assert shown["band_up"] == pytest.approx([2.0 * math.sqrt(2.0)])
    assert shown["band_down"] == [0.0]
    low, high = shown["spans"]["A"]
    assert high - low == pytest.approx(4.0 * math.sqrt(2.0))
    with pytest.raises(DataError, match="two runs"):
        positioning_band([0.0], [[1.0]], [[1.0]], {}, title="t", ax=ChartSheet())


def test_the_span_of_a_band_chart_is_a_of_the_table():
    from vcmm.learn.calibration.standards import positioning

    table = {n: 1e3 * float(v) for n, v in positioning(UP, DOWN).items()}
    (shown,) = numbers(on_page(positioning_band, np.arange(len(UP)), 1e3 * UP, 1e3 * DOWN, table, title="t"))
    for name in ("A", "E"):
        low, high = shown["spans"][name]
        assert high - low == pytest.approx(table[name], rel=1e-9)
        assert shown["figures"][name] == table[name]


def test_the_trace_of_a_ball_bar_has_the_widths_of_its_table():
    """By hand (test_recorded): G = 3 um in each sense; the page states the same figure that its picture carries."""
    tests = [RecordedTest(ball_bar(), bare())]
    found, _ = evaluate_recordings(tests, "230-4")
    (shown,) = numbers(acceptance_page(tests, "230-4", found))
    stated = {f.name: f.value_um for f in found}
    assert shown["width"]["counter-clockwise"] == pytest.approx(stated["G+ XY"], abs=1e-9)
    assert shown["width"]["clockwise"] == pytest.approx(stated["G- XY"], abs=1e-9)
    assert shown["width"]["clockwise"] == pytest.approx(3.0, abs=2e-3)


def test_a_trace_and_its_circles():
    angle = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
    line = PolarTrace("unfiltered", angle, 2.0 * np.cos(angle) + np.cos(2 * angle))
    circle = ReferenceCircle("least squares", 0.0, 2.0, 0.0, 2.0)
    ax = traces([line], title="t", circles=[circle], ax=ChartSheet())
    assert ax.vcmm_numbers["width"] == {"unfiltered": pytest.approx(4.5)}  # from 3 at 0 to -1.5 at 120 deg
    assert ax.vcmm_numbers["circles"]["least squares"]["width"] == 2.0
    assert circle.at([0.0, np.pi]).tolist() == pytest.approx([2.0, -2.0])
    with pytest.raises(DataError, match="finite"):
        traces([PolarTrace("a", [0.0], [math.nan])], title="t", ax=ChartSheet())


def test_a_covariate_of_two_values_is_two_boxes():
    x = np.repeat([-1.0, 1.0], 101)
    y = np.concatenate([np.linspace(0.0, 10.0, 101), np.linspace(5.0, 6.0, 101)])
    (shown,) = numbers(on_page(boxes, x, [("before", y, "c2")], label="sense", y_label="um", title="t"))
    assert shown["groups"] == [-1.0, 1.0]
    assert shown["quantiles"]["before"][0] == pytest.approx([0.5, 2.5, 5.0, 7.5, 9.5])
    assert shown["quantiles"]["before"][1] == pytest.approx([5.05, 5.25, 5.5, 5.75, 5.95])
    assert is_grouped(x)
    assert not is_grouped(np.arange(9))


def test_the_residual_of_a_diagnosis_stands_at_its_own_rows():
    """The trace of a diagnosis before anything is fitted has the widths that the table of ISO 230-4 states for the same file.

    The rows of a diagnosis are sorted by position; drawn over the rows of the file they made a zigzag of the same rms.
    """
    from vcmm.files.own.library import example
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.diagnosis.comparison import misfit_without_covariates
    from vcmm.learn.diagnosis.row_order import in_file_order
    from vcmm.show.pages.diagnosis_pictures import bar_traces

    recording, machine = load_recording(example("ballbar"))
    before = in_file_order(recording, machine, misfit_without_covariates(recording, machine).residual)
    found, _ = evaluate_recordings([RecordedTest(recording, machine)], "230-4")
    stated = {f.name: f.value_um for f in found}
    first, second = numbers("".join(bar_traces(recording, machine, before, 0.1 * before)))
    assert first["width"]["counter-clockwise"] == pytest.approx(stated["G+ XY"], rel=1e-3)
    assert first["width"]["clockwise"] == pytest.approx(stated["G- XY"], rel=1e-3)
    assert second["width"]["clockwise"] == pytest.approx(0.1 * first["width"]["clockwise"], rel=1e-9)
    assert first["scale"] == second["scale"]  # one scale for both


def test_maps_that_are_compared_have_one_scale():
    from vcmm.show.charts import heat_map, is_of_one_colour

    before, after = np.array([[1.0, 2.0], [3.0, 4.0]]), np.array([[0.1, 0.2], [0.1, 0.2]])
    both = np.concatenate([before.ravel(), after.ravel()])
    options = {"x_label": "x", "y_label": "y", "unit": "um", "title": "t", "over": both}
    maps = [
        heat_map(v, [0.0, 1.0], [0.0, 1.0], ax=ChartSheet(), **options).vcmm_numbers for v in (before, after)
    ]
    assert list(maps[0]["levels"]) == list(maps[1]["levels"])
    assert (maps[1]["least"], maps[1]["most"]) == (0.1, 0.2)
    assert is_of_one_colour(after, both)
    assert not is_of_one_colour(before, both)


def test_a_band_about_a_trace_is_one_key_and_no_width_of_its_own():
    """+-1 um about a circle of 2 um: the scale goes from 0 to 3, and the width that is stated is that of the trace."""
    angle = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
    ax = traces([PolarTrace("forecast", angle, np.full(72, 2.0), half_um=1.0)], title="t", ax=ChartSheet())
    assert ax.vcmm_numbers["width"] == {"forecast": pytest.approx(0.0)}
    assert ax.vcmm_numbers["scale"] == [0.0, 3.0]
