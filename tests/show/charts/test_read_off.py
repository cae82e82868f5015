"""Pictures that can be read: nothing lies over the title, no label ends in a word, a colour that means a number is that of its bar."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.build import scenario
from vcmm.show.charts import ChartSheet, bars, distribution
from vcmm.show.report.blocks import SceneMesh
from vcmm.show.report.colormap import bands
from vcmm.show.report.scene import figure_of


def test_keys_stand_below_the_title():
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    edges = np.linspace(-1.0, 1.0, 11)
    ax = distribution(
        edges, np.ones(10), interval=(-0.5, 0.5), limits=(-0.9, 0.9), marks={"y": 0.0, "a rather long name of a mark": 0.1},
        title="bore: deviation from 30 mm", ax=ChartSheet(420, 300),
    )  # fmt: skip
    canvas = FigureCanvasAgg(ax.figure)
    canvas.draw()
    key, title = ax.get_legend().get_window_extent(), ax._left_title.get_window_extent()
    assert key.y1 <= title.y0 + 1.0
    assert key.y0 >= ax.bbox.y1 - 1.0


@pytest.mark.usefixtures("few_parts")
def test_a_closed_form_has_a_curve():
    """Normal law, u = 0.5 um: the highest bar is 1 / (0.5 sqrt(2 pi)) = 0.798 per um, 95 % lie in the interval."""
    found = vcmm.uncertainty(scenario(), trials=1000)["diameter"]
    assert found.summary is None
    ax = found.plot(ChartSheet())
    heights = np.concatenate([np.asarray(p.get_data().values) for p in ax.patches if hasattr(p, "get_data")])
    assert heights.max() == pytest.approx(0.798, rel=0.005)


def test_labels_lose_whole_words():
    name = "stylus qualification down: offset x y z and radius, by the repeatability of the probing of the sphere"
    ax = bars([(name, 1.0), ("squareness", 2.0)], unit="µm", title="t", ax=ChartSheet())
    first, second = (t.get_text() for t in ax.get_yticklabels())
    assert second == "squareness"
    assert first.count("\n") == 1
    assert set(first.split()) - {"…"} <= set(name.split())
    assert first.split()[-1] == "sphere"


def test_colours_of_a_scene_are_those_of_its_bar():
    """No lighting: with it 89 % of the coloured pixels were none of the bar's."""
    corners, faces = (
        np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        np.array([[0, 1, 2], [0, 1, 3]]),
    )
    mesh = SceneMesh(corners, faces, values=np.array([1.0, 2.0]), unit="µm")
    (solid, *_), scale = figure_of([mesh])[0]["data"], figure_of([mesh])[1]
    assert scale is not None
    assert scale.colours == bands([1.0, 2.0]).colours
    assert set(solid["facecolor"]) <= set(scale.colours)
    light = solid["lighting"]
    assert (light["ambient"], light["diffuse"], light["specular"], light["fresnel"]) == (1.0, 0.0, 0.0, 0.0)
    assert solid["opacity"] == 1.0
    plain = figure_of([SceneMesh(corners, faces)])[0]["data"][0]
    assert plain["lighting"]["diffuse"] > 0.0  # a body without numbers keeps its shape
