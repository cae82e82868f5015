"""Report blocks: structure of the page, and every drawn number that can be computed by hand."""

from __future__ import annotations

import json
import math
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vcmm import report
from vcmm.core.errors import DataError, Environment, ModelLimit, UsageError
from vcmm.report.axes import Scale, nice_ticks, tick_text
from vcmm.report.bars import percent, shares
from vcmm.report.colormap import bands, ramp
from vcmm.report.curve import runs, thin
from vcmm.report.heatmap import cell_edges
from vcmm.report.page import scene_script
from vcmm.report.palette import DARK, LIGHT, hex_of
from vcmm.report.scene_items import Item
from vcmm.report.scene_mesh import banded, edge_faces, joined
from vcmm.report.scene_paint import basis, draw, ellipse
from vcmm.report.text import aligned, plain, shorten, text_width
from vcmm.report.zones import zone_list, zone_of

NAN = math.nan


def svgs(markup: str) -> list[ET.Element]:
    """Every SVG of the markup as a parsed tree: fails where one is not well-formed."""
    return [ET.fromstring(text) for text in re.findall(r"<svg .*?</svg>", markup, re.S)]


def the_svg(markup: str) -> ET.Element:
    (only,) = svgs(markup)
    return only


def display_of(markup: str) -> dict[str, Any]:
    """The JSON display list of a scene."""
    found = re.search(r"data-scene>(.*?)</script>", markup, re.S)
    assert found
    return dict(json.loads(found.group(1)))


def coordinates(path: ET.Element) -> list[tuple[float, float]]:
    flat = [float(v) for v in re.findall(r"-?\d+\.?\d*", path.get("d") or "")]
    return list(zip(flat[::2], flat[1::2]))


def rects(svg: ET.Element, role: str) -> list[ET.Element]:
    return [r for r in svg.iter("rect") if f"f-{role}" in (r.get("class") or "").split()]


def value(element: ET.Element, name: str) -> float:
    text = element.get(name)
    assert text is not None
    return float(text)


# ---------------------------------------------------------------- numbers and words


@pytest.mark.parametrize(
    ("x", "digits", "expected"),
    [
        (0.012345, 3, "0.0123"),
        (9.996, 3, "10.0"),  # rounds to 1.00e1: three digits again
        (12345.6, 3, "12346"),  # digits of the integer part are never destroyed
        (-1.5, 2, "−1.5"),
        (0.0, 3, "0"),
        (1.2e-7, 3, "1.20 × 10⁻⁷"),
        (NAN, 3, "–"),
        (math.inf, 3, "–"),
        (None, 3, "–"),
    ],
)
def test_number(x: float | None, digits: int, expected: str) -> None:
    assert report.number(x, digits) == expected


@pytest.mark.parametrize(
    ("x", "u", "expected"),
    [
        (110.00042, 0.00113, "110.0004 ± 0.0011"),
        (1.0, 0.0996, "1.00 ± 0.10"),  # 0.0996 -> 0.10, so the value goes to 0.01
        (4567.0, 123.0, "4570 ± 120"),  # the place is tens
        (-0.00004, 0.0012, "0.0000 ± 0.0012"),  # no minus zero
        (2.5, 0.0, "2.5 ± 0"),
        (NAN, 0.1, "–"),
        (1.0, math.inf, "–"),
        (0.125, 0.10, "0.13 ± 0.10"),  # half goes up
    ],
)
def test_with_uncertainty(x: float, u: float, expected: str) -> None:
    assert report.with_uncertainty(x, u) == expected


def test_numbers_refuse_nonsense() -> None:
    with pytest.raises(UsageError, match="significant digit"):
        report.number(1.0, 0)
    with pytest.raises(UsageError, match="negative"):
        report.with_uncertainty(1.0, -0.1)


def test_plain_and_aligned() -> None:
    assert plain(30.021) == "30.021"
    assert plain(100.0004) == "100.0004"
    assert plain(-0.0) == "0"
    # the largest, 0.62, shows three digits: three decimals for all; 0.0001 would read 0.000
    assert aligned([0.62, 0.09, 0.0001, NAN, 0.0]) == ["0.620", "0.090", "0.0001", "–", "0.000"]


def test_shorten_fits() -> None:
    text = shorten("thermal expansion of the part", 12.5, 80)
    assert text.endswith("…")
    assert text_width(text, 12.5) <= 80
    assert shorten("bore", 12.5, 80) == "bore"


def test_ticks() -> None:
    assert nice_ticks(0.0, 10.0, 5).tolist() == [0, 2, 4, 6, 8, 10]
    assert nice_ticks(-0.31, 0.29, 6) == pytest.approx([-0.3, -0.2, -0.1, 0, 0.1, 0.2])
    assert tick_text([-0.5, 0.0, 0.5]) == ["−0.5", "0", "0.5"]
    assert tick_text([30.0, 30.005, 30.01]) == ["30.000", "30.005", "30.010"]
    assert Scale(10, 20, 100, 300)(15) == 200


# ---------------------------------------------------------------- page


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
            report.bars([("a<b", 1.0), ("c", NAN)], unit="µm", title="Bars & more"),
            report.stacked([("a", 1.0), ("c", NAN)], title="Shares"),
        ),
        report.details(
            "More", report.curve([report.PlotSeries(x, y, "s")], x_label="x", y_label="y", title="C")
        ),
        report.histogram([0, 1, 2], [3, 4], x_label="d / mm", title="H", marks=(("n", 0.5), ("none", NAN))),
        report.zones(0.0, None, NAN, NAN, 0.1, unit="mm", title="Z"),
        report.heat_map(grid, range(4), range(3), x_label="x", y_label="y", unit="µm", title="M"),
        report.polar(np.linspace(0, 6, 30), np.sin(np.linspace(0, 6, 30)), title="P"),
        report.scene(
            [report.SceneMesh(v, f, values=colour, unit="µm"), report.Label((0, 0, 0), "</script><b>")],
            title="S",
        ),
    ]


def test_page_is_self_contained_and_well_formed() -> None:
    html = report.page("Plate <1>", sample_blocks(), subtitle="a & b", footer="c < d")
    assert len(svgs(html)) == 8
    for svg in svgs(html):
        assert svg[0].tag == "title"
        assert svg[0].text
    bare = re.sub(r"<style>.*?</style>|<script>.*?</script>", "", html, flags=re.S)
    assert "nan" not in re.sub(r"data-scene>.*?</script>", "", bare, flags=re.S).lower().replace(
        "finance", ""
    )
    assert not re.search(r"https?:|//\w|\bsrc=|\bhref=|@import|url\((?!#hatch)", html)
    assert "<title>Plate &lt;1&gt;</title>" in html
    assert "5 &lt; 6 &amp; 7" in html
    assert html.count("addEventListener") == 0
    assert html.count("requestAnimationFrame") == 1  # the script comes once
    assert html.count("</script>") == 2  # data and script: text of a label cannot end them


def test_page_without_scene_has_no_script() -> None:
    assert "<script" not in report.page("t", [report.paragraph("p")])


def test_scene_script_is_tiny() -> None:
    assert len(scene_script().encode()) <= 4096


def test_every_role_has_both_themes() -> None:
    assert LIGHT.keys() == DARK.keys()
    html = report.page("t", [])
    for role in LIGHT:
        assert html.count(f"--{role}:") == 2
    with pytest.raises(UsageError, match='Did you mean "accent"'):
        hex_of("acent")


def test_standalone_svg_has_a_namespace() -> None:
    text = report.standalone(report.bars([("a", 1.0)], unit="µm", title="B"))
    assert ET.fromstring(text).tag == "{http://www.w3.org/2000/svg}svg"


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


# ---------------------------------------------------------------- table


def test_table_has_scopes_and_dashes() -> None:
    html = report.table(
        ["name", "value"],
        [["a", NAN], ["b", 0.12345], ["c", report.Cell("bad & ugly", "bad")], ["d", report.Raw("<svg/>")]],
        caption="T",
        numeric=[1],
        emphasise=[1],
        foot=[["sum", None]],
    )
    tree = ET.fromstring(html)
    assert [th.get("scope") for th in tree.iter("th")] == ["col"] * 2 + ["row"] * 5
    missing = [s for s in tree.iter("span") if s.get("title") == "not available"]
    assert [s.text for s in missing] == ["–", "–"]
    assert "0.1235" in html  # a bare float: four significant digits
    assert '<span class="badge bad">bad &amp; ugly</span>' in html
    assert "<svg/>" in html
    assert html.count('class="strong"') == 1


def test_table_refuses_ragged_rows() -> None:
    with pytest.raises(DataError, match="Table row 2 has 1 cells but the table has 2 columns"):
        report.table(["a", "b"], [["x", 1], ["y"]])


# ---------------------------------------------------------------- bars


def test_bar_lengths_are_proportional() -> None:
    svg = the_svg(report.bars([("a", 4.0), ("b", 1.0), ("c", -2.0)], unit="µm", title="t"))
    (a, b), (c,) = rects(svg, "accent"), rects(svg, "c2")
    assert value(a, "width") / value(b, "width") == pytest.approx(4, rel=2e-3)
    assert value(c, "width") / value(b, "width") == pytest.approx(2, rel=2e-3)
    zero = value(a, "x")
    assert value(c, "x") + value(c, "width") == pytest.approx(zero, abs=0.02)  # grows to the left


def test_shares() -> None:
    assert shares([3.0, 4.0]) == pytest.approx([0.36, 0.64])  # 9/25, 16/25
    assert shares([3.0, 4.0], total=10.0) == pytest.approx([0.09, 0.16])  # 9/100, 16/100
    assert shares([3.0, -1.0], share="linear") == pytest.approx([0.75, 0.25])
    assert math.isnan(shares([0.0])[0])
    assert [percent(p) for p in (0.377, 0.004, 0.0, NAN)] == ["38 %", "<1 %", "0 %", "–"]
    with pytest.raises(UsageError, match="Unknown share"):
        shares([1.0], share="cubic")  # type: ignore[arg-type]


def test_stacked_parts_fill_the_width() -> None:
    svg = the_svg(report.stacked([("a", 3.0), ("b", 4.0)], title="t", width=500))
    parts = [r for r in svg.iter("rect") if r.get("height") == "24"]
    # shares 0.36 and 0.64 of 500 px, less 1 px of gap
    assert [value(r, "width") for r in parts] == pytest.approx([179, 319])


# ---------------------------------------------------------------- curve


def test_curve_interrupts_at_nan_and_scales() -> None:
    y = [0.0, 1.0, NAN, 1.0, 0.0]
    svg = the_svg(report.curve([report.PlotSeries(range(5), y, "s")], x_label="x", y_label="y", title="t"))
    lines = [p for p in svg.iter("path") if "s-c1" in (p.get("class") or "") and p.find("title") is not None]
    assert [len(coordinates(p)) for p in lines] == [2, 2]
    (x0, y0), (x1, y1) = coordinates(lines[0])
    (x3, y3), (x4, y4) = coordinates(lines[1])
    assert (y1, y0) == (y3, y4)
    assert y1 < y0  # larger values are higher up
    assert x3 - x1 == pytest.approx(2 * (x1 - x0), abs=0.03)
    assert x4 - x3 == pytest.approx(x1 - x0, abs=0.03)


def test_curve_band_and_limits() -> None:
    series = report.PlotSeries([0, 1], [0, 0], "s", low=[-1, -2], high=[1, 2])
    limit = report.Band(-4.0, 4.0, "MPE")
    svg = the_svg(report.curve([series], x_label="x", y_label="y", title="t", bands=[limit]))
    fills = [p for p in svg.iter("path") if p.get("opacity") and p.get("fill") != "none"]
    heights = [max(y for _, y in coordinates(p)) - min(y for _, y in coordinates(p)) for p in fills]
    assert heights[0] == pytest.approx(2 * heights[1], abs=0.05)  # +-4 against +-2


def test_curve_refuses_other_lengths() -> None:
    with pytest.raises(DataError, match='Curve "s"'):
        report.curve([report.PlotSeries([0, 1], [0], "s")], x_label="", y_label="", title="t")


def test_runs_and_thin() -> None:
    assert runs(np.array([True, True, False, True])) == [slice(0, 2), slice(3, 4)]
    x = np.arange(100_000.0)
    y = np.zeros_like(x)
    y[54_321] = 7.0
    xs, ys = thin(x, y)
    assert xs.size < 3000
    assert ys.max() == 7.0  # a single peak survives
    assert (xs[0], xs[-1]) == (0.0, 99_999.0)


# ---------------------------------------------------------------- histogram


def test_histogram_areas_are_proportional_to_counts() -> None:
    # densities 2/1, 6/2, 4/1 = 2, 3, 4
    svg = the_svg(report.histogram([0, 1, 3, 4], [2, 6, 4], x_label="x", title="t"))
    areas = [value(r, "width") * value(r, "height") for r in rects(svg, "accent")]
    assert np.array(areas) / areas[0] == pytest.approx([1, 3, 2], rel=1e-3)


def test_histogram_interval_cuts_bars() -> None:
    # one bar from 0 to 4, interval 1 to 3: half of the area is inside
    svg = the_svg(report.histogram([0, 4], [8], interval=(1, 3), x_label="x", title="t"))
    inside = sum(value(r, "width") for r in rects(svg, "accent"))
    outside = sum(value(r, "width") for r in rects(svg, "accent-soft"))
    assert inside == pytest.approx(outside, abs=0.05)


def test_histogram_labels_do_not_touch() -> None:
    marks = [("nominal value", 1.0), ("mean value", 1.01)]
    svg = the_svg(report.histogram([0, 2], [1], marks=marks, x_label="x", title="t"))
    heights = {t.text: value(t, "y") for t in svg.iter("text")}
    assert abs(heights["nominal value"] - heights["mean value"]) >= 14


@pytest.mark.parametrize(
    ("edges", "counts"), [([0, 1], [1, 2]), ([1, 0], [1]), ([0, 1], [NAN]), ([0, 1], [-1])]
)
def test_histogram_refuses(edges: list[float], counts: list[float]) -> None:
    with pytest.raises(DataError):
        report.histogram(edges, counts, x_label="x", title="t")


# ---------------------------------------------------------------- zones


def test_zone_list() -> None:
    zones = zone_list(10.0, 20.0, 1.0)
    assert [(z.low, z.high, z.kind) for z in zones] == [
        (-math.inf, 9.0, "bad"),
        (9.0, 11.0, "warning"),
        (11.0, 19.0, "good"),
        (19.0, 21.0, "warning"),
        (21.0, math.inf, "bad"),
    ]
    assert zone_of(11.0, zones).kind == "good"
    assert zone_of(20.5, zones).kind == "warning"
    assert [z.kind for z in zone_list(None, 5.0, 1.0)] == ["good", "warning", "bad"]
    assert [z.kind for z in zone_list(0.0, 1.0, 0.6)] == ["bad", "warning", "warning", "bad"]


def test_zones_drawn_at_the_right_place() -> None:
    markup = report.zones(10.0, 20.0, 12.5, 1.0, 1.0, unit="mm", title="t", width=500)
    svg = the_svg(markup)

    # the axis holds 9 to 21 and 14 % of 12 on each side: 7.32 to 22.68, 15.36 long
    def place(x: float) -> float:
        return (x - 7.32) / 15.36 * 500

    (good,) = rects(svg, "good-soft")[:1]
    assert value(good, "x") == pytest.approx(place(11.0), abs=0.01)
    assert value(good, "x") + value(good, "width") == pytest.approx(place(19.0), abs=0.02)
    whiskers = [line for line in svg.iter("line") if line.get("stroke-width") == "1.6"]
    assert value(whiskers[0], "x1") == pytest.approx(place(11.5), abs=0.01)
    assert value(whiskers[0], "x2") == pytest.approx(place(13.5), abs=0.01)
    assert "The result lies in the conformance zone." in markup
    assert "12.5 ± 1.0 mm" in markup


def test_zones_without_result_and_bad_limits() -> None:
    assert "The result is not available." in report.zones(None, 1.0, NAN, 0.1, 0.1, unit="mm", title="t")
    for lower, upper, guard in ((None, None, 0.1), (2.0, 1.0, 0.1), (0.0, 1.0, -1.0), (0.0, 1.0, NAN)):
        with pytest.raises(UsageError):
            report.zones(lower, upper, 0.5, 0.1, guard, unit="mm", title="t")


# ---------------------------------------------------------------- heat map and colours


def test_bands_are_round_and_hold_the_data() -> None:
    found = bands([0.0, 7.9], count=8)
    assert found.levels.tolist() == [0, 1, 2, 3, 4, 5, 6, 7, 8]
    assert found.index([0.0, 3.0, 7.9, 8.0, NAN]).tolist() == [0, 3, 7, 7, -1]
    both = bands([-1.0, 4.0], symmetric=True)
    assert both.levels.tolist() == [-4, -3, -2, -1, 0, 1, 2, 3, 4]
    assert bands([5.0, 5.0]).index([5.0])[0] >= 0
    assert bands([NAN]).levels.tolist() == [0, 1]


def test_ramps_are_monotone_in_lightness() -> None:
    def light(colour: str) -> float:
        return float(np.dot([int(colour[k : k + 2], 16) for k in (1, 3, 5)], [0.2126, 0.7152, 0.0722]))

    sequential = [light(c) for c in ramp(9)]
    assert sequential == sorted(sequential)
    diverging = [light(c) for c in ramp(8, diverging=True)]
    assert diverging[:4] == sorted(diverging[:4])
    assert diverging[4:] == sorted(diverging[4:], reverse=True)


def test_heat_map_cells_and_holes() -> None:
    markup = report.heat_map([[0.0, 0.0, 4.0], [NAN, 4.0, 4.0]], [0, 1, 2], [0, 1], x_label="x", y_label="y", unit="µm", title="t")  # fmt: skip
    svg = the_svg(markup)
    assert cell_edges(np.array([0.0, 1.0, 3.0])).tolist() == [-0.5, 0.5, 2.0, 4.0]
    cells = [p for p in svg.iter("path") if p.get("shape-rendering") == "crispEdges"]
    boxes = [len(re.findall("M", p.get("d") or "")) for p in cells]
    assert boxes == [
        1,
        1,
        2,
    ]  # hole; the two zeros as one box; 4 in the first row, two 4s as one box in the second
    assert (cells[0].get("fill") or "").startswith("url(#hatch-")
    spans = [[float(x) for x in re.findall(r"[MH](\d+\.?\d*)", p.get("d") or "")] for p in cells]
    assert spans[1][1] - spans[1][0] == pytest.approx(2 * (spans[0][1] - spans[0][0]), abs=0.03)
    assert "not evaluated" in markup
    with pytest.raises(DataError, match="ny, nx"):
        report.heat_map(np.zeros((2, 2)), [0, 1, 2], [0, 1], x_label="", y_label="", unit="", title="t")
    with pytest.raises(DataError, match="x positions"):
        report.heat_map(np.zeros((1, 2)), [1, 0], [0], x_label="", y_label="", unit="", title="t")


# ---------------------------------------------------------------- polar


def test_polar_radii() -> None:
    # deviations -1 and 2 um: rings from -1 to 2 (step 0.5), inner 0.34, outer 1 of 174 px (400 / 2 - 26)
    svg = the_svg(report.polar([0.0, math.pi / 2, math.pi], [2.0, -1.0, 0.0], title="t"))
    profile = next(p for p in svg.iter("path") if p.get("stroke-width") == "1.6")
    (x0, y0), (x1, y1), (x2, _) = coordinates(profile)
    assert (x0 - 250, y0) == pytest.approx((174, 200), abs=0.02)
    assert (x1, 200 - y1) == pytest.approx((250, 0.34 * 174), abs=0.02)
    assert 250 - x2 == pytest.approx(174 * (0.34 + 0.66 / 3), abs=0.02)
    with pytest.raises(DataError, match="polar"):
        report.polar([0.0], [NAN], title="t")


# ---------------------------------------------------------------- meshes


def volume(solid: tuple[np.ndarray, np.ndarray]) -> float:
    v, f = solid
    a, b, c = (v[f[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def test_mesh_volumes() -> None:
    def polygon(radius: float, n: int) -> float:
        return n / 2 * radius**2 * math.sin(2 * math.pi / n)

    assert volume(report.box_mesh((1, 1, 1), (2, 3, 4))) == pytest.approx(6)
    assert volume(report.cylinder_mesh((9, 8, 7), (0, 1, 1), 2, 5)) == pytest.approx(5 * polygon(2, 48))
    tube = report.tube_mesh((9, 8, 7), (1, 0, 0), 3, 2, 4)
    assert volume(tube) == pytest.approx(4 * (polygon(3, 48) - polygon(2, 48)))
    assert volume(report.cone_mesh((0, 0, 1), (0, 0, 1), 2, 3)) == pytest.approx(polygon(2, 48))  # A h / 3
    assert volume(report.sphere_mesh((5, 5, 5), 2, n=96)) == pytest.approx(4 / 3 * math.pi * 8, rel=2e-3)
    torus = report.torus_mesh((0, 0, 0), (0, 0, 1), 5, 1, n=192)
    assert volume(torus) == pytest.approx(2 * math.pi**2 * 5, rel=2e-3)


def test_open_meshes_face_the_right_way() -> None:
    v, f = report.cylinder_mesh((0, 0, 0), (0, 0, 1), 2, 5, inside=True)
    normal = np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])
    assert (np.einsum("ij,ij->i", normal[:, :2], v[f].mean(axis=1)[:, :2]) < 0).all()
    for axis in ((0, 0, 1), (0, -1, 0), (1, 0, 0), (1, 1, 1)):
        v, f = report.plane_mesh((1, 2, 3), axis, 4, 2)
        assert np.cross(v[1] - v[0], v[2] - v[0]) == pytest.approx(8 * np.array(axis) / np.linalg.norm(axis))
    v, f = report.disc_mesh((0, 0, 1), (0, 0, -1), 1.0)
    assert (np.cross(v[f[:, 1]] - v[f[:, 0]], v[f[:, 2]] - v[f[:, 0]])[:, 2] < 0).all()
    with pytest.raises(UsageError, match="lo < hi"):
        report.box_mesh((0, 0, 0), (1, 0, 1))
    with pytest.raises(UsageError, match="no direction"):
        report.disc_mesh((0, 0, 0), (0, 0, 0), 1)


def test_coplanar_triangles_join_to_the_sides_of_a_box() -> None:
    v, f = report.box_mesh((0, 0, 0), (1, 2, 3))
    edge, pair = edge_faces(f)
    assert len(edge) == 18  # 12 edges and 6 diagonals
    assert sorted(len(g) for g in joined(v, f, edge, pair)) == [2] * 6


def test_band_borders_cut_triangles() -> None:
    # value = x on a triangle (0,0) (2,0) (0,2), bands 0..1..2: the part beyond x = 1 has a quarter of the area
    corners = np.array([[0.0, 0, 0], [2, 0, 0], [0, 2, 0]])
    parts = banded(corners, corners[:, 0], bands([0.0, 2.0], count=2))

    def area(p: np.ndarray) -> float:
        return abs(float(np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)[2])) / 2

    assert [(round(area(p), 12), k) for p, k in parts] == [(1.5, 0), (0.5, 1)]
    assert banded(corners, np.array([0.0, NAN, 1.0]), bands([0.0, 2.0]))[0][1] == -1


# ---------------------------------------------------------------- scene

CUBE = report.SceneBox((-100, -100, -100), (100, 100, 100), opacity=0.0)


def test_projection_of_a_known_point() -> None:
    # Front view (azimuth -90, elevation 0): x to the right, z up. The cube fills 200 mm in the height of
    # 400 - 26 (axes) - 36 (margins) = 338 px: 1.69 px/mm about (250, 187).
    markup = report.scene(
        [CUBE, report.Points([(50.0, 70.0, 20.0)])], title="t", width=500, height=400, view=(-90, 0)
    )
    (dot,) = (c for c in the_svg(markup).iter("circle") if c.get("r") == "3")
    assert value(dot, "cx") == pytest.approx(250 + 1.69 * 50, abs=0.05)
    assert value(dot, "cy") == pytest.approx(187 - 1.69 * 20, abs=0.05)


def test_basis_is_a_right_handed_camera() -> None:
    r, u, d = basis(30.0, 40.0)
    assert np.cross(d, r) == pytest.approx(u)
    # d = (cos 40 cos 30, cos 40 sin 30, sin 40)
    assert d == pytest.approx([0.766044 * 0.866025, 0.766044 * 0.5, 0.642788], abs=1e-6)


def test_ellipse_is_the_projected_covariance() -> None:
    a = np.random.default_rng(1).normal(size=(3, 3))
    covariance, view, magnification = a @ a.T * 1e-4, (25.0, 35.0), 1000.0
    item = report.Ellipsoids([(0.0, 0.0, 0.0)], covariance[None], magnification)
    markup = report.scene([CUBE, item], title="t", width=500, height=400, view=view)
    found = next(e for e in the_svg(markup).iter("ellipse") if e.get("transform"))
    display = display_of(markup)
    camera = np.array(display["v"]) @ basis(*view).T  # px per mm from the fit rule, independent of `project`
    per_mm = min(display["fit"][2 + k] / np.abs(camera[:, k]).max() for k in range(2)) / display["grain"]
    flat = basis(*view)[:2] @ covariance @ basis(*view)[:2].T
    expected = magnification * per_mm * np.sqrt(np.linalg.eigvalsh(flat))
    assert sorted([value(found, "rx"), value(found, "ry")]) == pytest.approx(expected, abs=0.02)
    assert "magnified 1\u202f000 ×" in markup
    long, short, turn = ellipse(np.diag([4.0, 9.0, 1.0]), np.eye(3))
    assert (long, short, abs(turn)) == pytest.approx((3, 2, 90))


def test_scene_refuses_what_cannot_be_drawn() -> None:
    with pytest.raises(DataError, match="not finite"):
        report.scene([report.Points([(0, 0, NAN)])], title="t")
    with pytest.raises(DataError, match=r"shape \(n, 3\)"):
        report.scene([report.Points([(0, 0)])], title="t")
    with pytest.raises(DataError, match="negative eigenvalue"):
        report.scene([report.Ellipsoids([(0, 0, 0)], [np.diag([1.0, 1.0, -1.0])])], title="t")
    with pytest.raises(DataError, match="index base"):
        report.scene([report.SceneMesh(np.eye(3), [[1, 2, 3]])], title="t")
    with pytest.raises(DataError, match="at least one item"):
        report.scene([], title="t")
    v, f = report.box_mesh((0, 0, 0), (1, 1, 1))
    with pytest.raises(ModelLimit, match="decimate"):
        report.scene([report.SceneMesh(v, np.tile(f, (2501, 1)))], title="t")


def test_hidden_faces_and_edges_are_left_out() -> None:
    box = report.SceneBox((0, 0, 0), (1, 1, 1), "#ff0000")
    stage = the_svg(report.scene([box], title="t", axes=False))[1]
    faces = [p for p in stage if p.get("fill") != "none"]
    assert len(faces) == 3
    assert len(stage) - len(faces) == 9  # of 12 edges, three meet in the hidden corner
    inside_out = report.box_mesh((0, 0, 0), (1, 1, 1))
    mesh = report.SceneMesh(inside_out[0], inside_out[1][:, ::-1], edges=False)
    assert len(the_svg(report.scene([mesh], title="t", axes=False))[1]) == 3


COLOURS = ("#ff0000", "#00ff00", "#0000ff", "#ffff00", "#ff00ff", "#00ffff")
BOXES = (  # a table, legs, a beam on them, a ram that runs through the beam, a part on the table
    ((-50, -50, -10), (50, 50, 0)),
    ((-48, -5, 0), (-40, 5, 60)),
    ((40, -5, 0), (48, 5, 60)),
    ((-48, -6, 60), (48, 6, 72)),
    ((0, -9, 20), (8, 3, 100)),
    ((-20, -40, 0), (15, -15, 12)),
)


def front_item(origin: np.ndarray, towards: np.ndarray) -> tuple[int, float]:
    """SceneBox that a viewer at +towards sees on the line through origin (-1: none), and how clear the case is."""
    entries = []
    for lo, hi in BOXES:
        with np.errstate(divide="ignore"):
            t = np.sort((np.array([lo, hi]) - origin) / towards, axis=0)
        entries.append(t[1].min() if t[0].max() < t[1].min() else -math.inf)
    ranked = np.sort(entries)
    if ranked[-1] == -math.inf:
        return -1, math.inf
    return int(np.argmax(entries)), float(ranked[-1] - ranked[-2])


def contains(polygon: list[tuple[float, float]], x: float, y: float) -> bool:
    inside = False
    for (x1, y1), (x2, y2) in zip(polygon, polygon[1:] + polygon[:1]):
        if (y1 > y) != (y2 > y) and x < x1 + (y - y1) / (y2 - y1) * (x2 - x1):
            inside = not inside
    return inside


@pytest.mark.parametrize("view", [(-60, 22), (30, 5), (140, 60), (-130, -25), (5, 85)])
def test_painter_shows_what_a_ray_hits(view: tuple[float, float]) -> None:
    items = [report.SceneBox(lo, hi, c, wire=False) for (lo, hi), c in zip(BOXES, COLOURS)]
    markup = report.scene(items, title="t", view=view, axes=False)
    faces = [(p.get("fill") or "", coordinates(p)) for p in the_svg(markup)[1]]
    display, frame = display_of(markup), basis(*view)
    camera = np.array(display["v"]) @ frame.T
    scale = min(display["fit"][2 + k] / np.abs(camera[:, k]).max() for k in range(2))
    centre = np.array(BOXES).reshape(-1, 3)
    middle = (centre.min(axis=0) + centre.max(axis=0)) / 2
    seen = (np.array([[b[i][0], b[j][1], b[k][2]] for b in BOXES for i in (0, 1) for j in (0, 1) for k in (0, 1)]) - middle) @ frame.T  # fmt: skip
    shift = (seen.min(axis=0) + seen.max(axis=0))[:2] / 2
    checked = doubtful = 0
    for right, up in np.random.default_rng(7).uniform(-55, 55, size=(400, 2)):
        item, margin = front_item(
            middle + (right + shift[0]) * frame[0] + (up + shift[1]) * frame[1], frame[2]
        )
        x = display["fit"][0] + scale * right / display["grain"]
        y = display["fit"][1] - scale * up / display["grain"]
        hits = [colour for colour, polygon in faces if contains(polygon, x, y)]
        if margin < 0.5 or bool(hits) != (
            item >= 0
        ):  # two surfaces meet, or the outline passes within a rounding
            continue
        if hits:
            pattern = [int(hits[-1][k : k + 2], 16) > 0 for k in (1, 3, 5)]
            assert pattern == [int(COLOURS[item][k : k + 2], 16) > 0 for k in (1, 3, 5)]
            checked += 1
    assert checked > 100
    assert doubtful <= 2


def test_labels_do_not_touch_and_stay_inside() -> None:
    corner = report.Points([(100.0, 0.0, 100.0), (101.0, 0.0, 100.0)], labels=["a long label", "another one"])
    svg = the_svg(report.scene([CUBE, corner], title="t", width=300, height=400, view=(-90, 0)))
    first, second = (t for t in svg.iter("text") if t.get("paint-order"))
    for label in (first, second):
        assert 0 <= value(label, "x") <= 300 - text_width(label.text or "", 12)
    assert abs(value(first, "y") - value(second, "y")) >= 13


@pytest.mark.parametrize("view", [(-60, 22), (20, 3), (140, 60), (-130, -25)])
def test_a_part_on_a_table_cuts_nothing(view: tuple[float, float]) -> None:
    table = report.SceneBox((-50, -50, -10), (50, 50, 0), "#ff0000")
    part = report.SceneBox((30, -45, 0), (33, -40, 1), "#00ff00")
    faces = [
        p for p in the_svg(report.scene([part, table], title="t", view=view))[1] if p.get("fill") != "none"
    ]
    below = view[1] < 0  # then the table hides the part and is drawn last
    assert [(p.get("fill") or "").startswith("#00") for p in faces] == [below] * 3 + [not below] * 3


@pytest.mark.skipif(
    not shutil.which("chromium"), reason="chromium is not installed: the script cannot be run"
)
def test_script_draws_what_python_draws(tmp_path: Path) -> None:
    v, f = report.tube_mesh((0, 0, 0), (1, 2, 3), 60, 40, 50)
    items: list[Item] = [
        report.SceneBox((-80, -80, -60), (80, 80, -40)),
        report.SceneMesh(v, f, values=v[:, 0], unit="µm", symmetric=True),
        report.Lines([(0, 0, 0), (90, 0, 0), (90, 90, 90)], dashed=True),
        report.Points([(50, 60, 70)], labels=["P <1>"]),
        report.Arrows([(0, 0, 80)], [(0.01, 0.02, 0.0)], 1000),
        report.Ellipsoids([(0, 0, 90)], [np.diag([1e-4, 4e-4, 9e-4])], 1000),
    ]
    block = report.scene(items, title="t")
    # a busy browser may print the page before its next frame: draw at once instead
    press = "window.requestAnimationFrame = draw => { draw(); return 0; }; for (const k of ['ArrowRight', 'ArrowDown']) document.querySelector('svg').dispatchEvent(new KeyboardEvent('keydown', {key: k}));"  # fmt: skip
    page = report.page("t", [block]).replace("</body>", f"<script>{press}</script></body>")
    stage = _rendered(tmp_path, page)
    turned = draw(display_of(block), (-60.0 - 5.0, 22.0 + 5.0))
    expected = ET.fromstring(f"<g>{turned}</g>")[0]
    assert len(stage) == len(expected)
    for got, want in zip(stage, expected):
        if want.tag == "path":
            numbers = [[float(n) for n in re.findall(r"-?\d+\.?\d*", e.get("d") or "")] for e in (got, want)]
            assert numbers[0] == pytest.approx(numbers[1], abs=0.11)
        if want.tag == "ellipse":
            matrix = np.array(
                [float(n) for n in re.findall(r"-?[\d.]+(?:e-?\d+)?", got.get("transform") or "")]
            )
            axes = np.linalg.svd(matrix[:4].reshape(2, 2), compute_uv=False)
            assert axes == pytest.approx([value(want, "rx"), value(want, "ry")], abs=0.02)
        if want.tag == "text":
            assert got.text == want.text


def _rendered(folder: Path, page: str) -> ET.Element:
    """The stage of the only scene after the script has run in a browser."""
    path = report.write(folder / "page.html", page)
    command = [
        "chromium", "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run",
        "--disable-background-networking", "--disable-component-update", "--disable-sync",
        f"--user-data-dir={folder / 'profile'}", "--virtual-time-budget=2000", "--dump-dom", path.as_uri(),
    ]  # fmt: skip
    dom = subprocess.run(command, capture_output=True, text=True, timeout=60).stdout
    found = re.search(r'(<g class="stage".*?</g>)<g class="bar"', dom, re.S)
    if not found:
        pytest.skip("chromium does not run here")
    return ET.fromstring(found.group(1))
