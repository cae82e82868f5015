"""The page: self-contained, well-formed, written whole."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from tests.show.report.drawn import NAN, svgs
from vcmm.core.errors import Environment
from vcmm.show.charts import PlotSeries, bars, curve, distribution, heat_map, on_page, polar, zones
from vcmm.show.report import blocks as report
from vcmm.show.report.page import scene_script


def sample_blocks() -> list[str]:
    """One of every block, with hostile text and missing numbers."""
    x = np.linspace(0, 100, 11)
    y = np.where(x == 50, NAN, np.sin(x))
    grid = np.arange(12.0).reshape(3, 4)
    grid[1, 2] = NAN
    v, f = report.sphere_mesh((0, 0, 30), 10)
    colour = np.where(v[:, 2] > 38, NAN, v[:, 0])
    return [
        report.heading("A & B <heading>"),
        report.paragraph("5 < 6 & 7"),
        report.note("careful", "warning"),
        report.table(["a", "b"], [["x", NAN], ["y", report.Cell("conforms", "good")]], numeric=[1]),
        report.columns(
            on_page(bars, [("a<b", 1.0), ("c", NAN)], unit="µm", title="Bars & more"),
            report.paragraph("beside"),
        ),
        report.details("More", on_page(curve, [PlotSeries(x, y, "s")], x_label="x", y_label="y", title="C")),
        on_page(distribution, [0, 1, 2], [3, 4], title="H", marks={"n": 0.5, "none": NAN}),
        on_page(zones, 0.0, None, NAN, NAN, 0.1, unit="mm", title="Z"),
        on_page(heat_map, grid, range(4), range(3), x_label="x", y_label="y", unit="µm", title="M"),
        on_page(polar, np.linspace(0, 6, 30), np.sin(np.linspace(0, 6, 30)), title="P"),
        report.scene(
            [report.SceneMesh(v, f, values=colour, unit="µm"), report.Label((0, 0, 0), "</script><b>")],
            title="S",
        ),
    ]


@pytest.mark.thorough
def test_page_is_self_contained_and_well_formed() -> None:
    html = report.page("Plate <1>", sample_blocks(), subtitle="a & b", footer="c < d")
    assert len(svgs(html)) == 6
    for svg in svgs(html):
        assert svg[0].tag == "title"
        assert svg[0].text
    bare = re.sub(
        r"<style>.*?</style>|<script>.*?</script>|plotly-gz\">.*?</script>|base64,[^\"]*",
        "",
        html,
        flags=re.S,
    )
    assert "nan" not in re.sub(r"data-scene>.*?</script>", "", bare, flags=re.S).lower().replace(
        "finance", ""
    )
    assert not re.search(
        r"https?:|//\w|\bsrc=(?!.data:image/png;)|\bhref=(?!.(?:#|data:image/png;))|@import|url\((?!#)", bare
    )
    assert "<title>Plate &lt;1&gt;</title>" in html
    assert "5 &lt; 6 &amp; 7" in html
    assert html.count("DecompressionStream(") == 1  # the script comes once
    assert html.count("</script>") == 3  # data, library and script: text of a label cannot end them


def test_page_without_scene_has_no_script() -> None:
    assert "<script" not in report.page("t", [report.paragraph("p")])


@pytest.mark.thorough
def test_a_page_with_a_scene_stays_below_two_and_a_half_mb() -> None:
    assert len(scene_script().encode()) <= 5120
    assert len(report.page("t", sample_blocks()).encode()) < 2_500_000


def test_write(tmp_path: Path) -> None:
    target = tmp_path / "report.html"
    target.write_text("old")
    assert report.write(target, "new ±") == target
    assert target.read_text(encoding="utf-8") == "new ±"
    assert [p.name for p in tmp_path.iterdir()] == ["report.html"]


def test_write_leaves_nothing_behind(tmp_path: Path) -> None:
    folder = tmp_path / "taken"  # a folder of the same name cannot be replaced
    folder.mkdir()
    (tmp_path / "file").write_text("x")
    for target in (folder, tmp_path / "absent" / "r.html", tmp_path / "file" / "r.html"):
        with pytest.raises(Environment, match="cannot be written"):
            report.write(target, "html")
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["file", "taken"]
