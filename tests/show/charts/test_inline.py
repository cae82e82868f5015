"""Charts inside a page: text stays text, the page paints, nothing comes from outside, two on one page do not disturb each other."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.show.report.drawn import svgs, the_svg
from vcmm.show.charts import PlotSeries, bars, curve, heat_map, on_page
from vcmm.show.report.palette import LIGHT


@pytest.fixture(scope="module")
def drawn():
    return on_page(
        bars, [("a < b & $x^2$ and _c_", 4.0), ('"c"', 1.0)], unit="µm", title="Bars & <more>\nsmall $1 to $2"
    )


def test_words_stand_as_they_are(drawn):
    picture = the_svg(drawn)
    words = [t.text for t in picture.iter("text")]
    assert "a < b & $x^2$ and _c_" in words
    assert '"c"' in words
    assert next(t.text for t in picture.iter("title")) == "Bars & <more>"
    assert "<figcaption>Bars &amp; &lt;more&gt;" in drawn
    assert '<span class="caption">small $1 to $2</span>' in drawn


def test_a_bar_says_its_name_and_value_under_the_pointer(drawn):
    said = [g.find("title").text for g in the_svg(drawn).iter("g") if g.find("title") is not None]
    assert said == ["a < b & $x^2$ and _c_: 4.00", '"c": 1.00']


def test_every_colour_is_a_role_of_the_page(drawn):
    styles = " ".join(e.get("style") or "" for e in the_svg(drawn).iter())
    assert not re.search(r"#[0-9a-f]{6}", styles)
    assert set(re.findall(r"var\(--([a-z0-9-]+)\)", styles)) <= set(LIGHT)
    assert "var(--muted)" in styles


def test_nothing_from_outside_and_no_rule_for_the_page(drawn):
    assert "<style" not in drawn
    assert "http" not in drawn
    assert "font-family" not in drawn
    assert "<metadata" not in drawn


def test_marks_of_two_charts_keep_apart():
    one = [on_page(curve, [PlotSeries([0, 1], [0, k], marker=True)], x_label="x", y_label="y", title=f"t{k}") for k in (1, 2)]  # fmt: skip
    ids = [[e.get("id") for e in svg.iter() if e.get("id")] for svg in svgs("".join(one))]
    assert ids[0]
    assert not set(ids[0]) & set(ids[1])
    for made, known in zip(one, ids):
        assert set(re.findall(r'(?:href="#|url\(#)(\w+)', made)) <= set(known)


def test_a_map_is_one_small_image():
    made = on_page(heat_map, np.random.default_rng(1).normal(size=(60, 80)), range(80), range(60), x_label="x", y_label="y", unit="µm", title="t")  # fmt: skip
    assert len(made) < 40_000
    assert len([e for e in the_svg(made).iter() if e.tag.endswith("image")]) == 1


def test_the_same_numbers_make_the_same_picture():
    made = {on_page(bars, [("a", 1.0)], unit="µm", title="t") for _ in range(2)}
    assert len(made) == 1
