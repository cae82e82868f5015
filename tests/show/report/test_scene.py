"""Scenes: refusals, what every item becomes, the page around them, and a browser that draws them."""

from __future__ import annotations

import base64
import json
import math
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.show.report.drawn import NAN, figure_in
from vcmm.core.errors import DataError, ModelLimit
from vcmm.show.report import blocks as report
from vcmm.show.report.meshes import creases
from vcmm.show.report.scene import eye, figure_of
from vcmm.show.report.scene_items import Item


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
    with pytest.raises(DataError, match="1 texts for 2 points"):
        report.scene([report.Points([(0, 0, 0), (1, 1, 1)], hover=["one"])], title="t")
    v, f = report.box_mesh((0, 0, 0), (1, 1, 1))
    with pytest.raises(ModelLimit, match="decimate"):
        report.scene([report.SceneMesh(v, np.tile(f, (2501, 1)))], title="t")


def everything() -> list[Item]:
    v, f = report.tube_mesh((0, 0, 0), (1, 2, 3), 60, 40, 50)
    return [
        report.SceneBox((-80, -80, -60), (80, 80, -40), name="table"),
        report.SceneMesh(v, f, values=v[:, 0], unit="µm", symmetric=True),
        report.Lines([(0, 0, 0), (90, 0, 0), (90, 90, 90)], dashed=True),
        report.Points([(50, 60, 70)], labels=["P <1>"], hover=["bore, point 1\nu = 0.4 um"]),
        report.Arrows([(0, 0, 80), (0, 9, 80)], [(0.01, 0.02, 0.0), (0.0, 0.0, 0.0)], 1000),
        report.Ellipsoids([(0, 0, 90)], [np.diag([1e-4, 4e-4, 9e-4])], 1000),
        report.Label((1, 2, 3), "<b>here</b>"),
    ]


def test_every_item_becomes_its_trace() -> None:
    figure, scale = figure_of(everything())
    kinds = [t["type"] for t in figure["data"]]
    # box: solid and edges; mesh: solid and creases; lines; points; shafts and heads; ellipsoids and centres; label
    assert kinds == ["mesh3d", "scatter3d", "mesh3d", "scatter3d", "scatter3d", "scatter3d", "scatter3d", "cone", "mesh3d", "scatter3d", "scatter3d"]  # fmt: skip
    assert scale is not None
    assert scale.levels[0] == -scale.levels[-1]
    head = figure["data"][7]
    assert len(head["x"]) == 1  # an arrow without length has no head
    assert head["x"][0] == 10.0  # 0.01 mm, a thousand times
    assert head["hovertext"] == ["22.4 µm at 0, 0, 80 mm"]
    assert [head["u"][0], head["v"][0], head["w"][0]] == pytest.approx(
        [1 / math.sqrt(5), 2 / math.sqrt(5), 0.0], abs=1e-6
    )
    assert figure["data"][8]["hovertext"] == ["semi-axes 30, 20, 10 µm (k = 1)"]
    assert figure["data"][8]["meta"]["centres"] == [[0.0, 0.0, 90.0]]
    assert figure["data"][9]["hoverinfo"] == "skip"
    assert figure["data"][5]["hovertext"] == ["bore, point 1<br>u = 0.4 um"]
    assert figure["data"][10]["text"] == ["&lt;b&gt;here&lt;/b&gt;"]  # names from files are words, not tags


def grown(trace: dict[str, Any]) -> np.ndarray:
    """Vertices (n, 3) of the first ellipsoid, as scene.js makes them of the ball."""
    ball = np.array([trace[c] for c in "xyz"], float)
    root = np.array(trace["meta"]["roots"][0], float).reshape(3, 3)
    return (root @ ball).T + trace["meta"]["centres"][0]


def test_an_ellipsoid_has_its_semi_axes() -> None:
    data = figure_of([report.Ellipsoids([(5, 0, 0)], [np.diag([1.0, 4.0, 9.0])], 2.0)])[0]["data"][0]
    assert grown(data).max(axis=0) == pytest.approx([7.0, 4.0, 6.0])
    turned = np.array(
        [[2.5, 1.5, 0], [1.5, 2.5, 0], [0, 0, 1.0]]
    )  # semi-axes 2 and 1 along (1, 1) and (1, -1)
    data = figure_of([report.Ellipsoids([(0, 0, 0)], [turned])])[0]["data"][0]
    xy = grown(data)[:, :2]
    assert np.hypot(*xy.T).max() == pytest.approx(2.0, rel=0.04)  # 12 meridians
    far = xy[np.hypot(*xy.T).argmax()]
    assert abs(far[0] - far[1]) < 0.6


def test_colours_of_a_mesh_are_its_bands() -> None:
    v, f = report.box_mesh((0, 0, 0), (1, 1, 1))
    values = np.arange(12.0)
    values[0] = NAN
    figure, scale = figure_of([report.SceneMesh(v, f, values=values, unit="um")])
    assert scale is not None
    solid = figure["data"][0]
    assert solid["facecolor"][0] == "#b4bac2"
    assert solid["facecolor"][11] == scale.colours[scale.index([11.0])[0]]
    assert solid["hovertext"][7].endswith(" um")


def test_rims_and_creases_of_a_box() -> None:
    v, f = report.box_mesh((0, 0, 0), (1, 1, 1))
    assert len(creases(v, f)) == 12  # not the diagonals of its sides
    assert len(creases(v, f[:-1])) == 13  # a hole of one triangle: its diagonal is a rim now
    assert creases(v, f[:0]).shape == (0, 2, 3)


def test_camera_stands_where_the_view_says() -> None:
    """Azimuth from +x towards +y, elevation upwards."""
    assert [eye((0.0, 0.0))[c] for c in "xyz"] == pytest.approx([1.6, 0.0, 0.0])
    assert [eye((90.0, 30.0))[c] for c in "xyz"] == pytest.approx(
        [0.0, 1.6 * math.cos(math.pi / 6), 0.8], abs=1e-12
    )


def test_a_long_scene_fits_as_a_cube_does_and_is_true_to_scale() -> None:
    """1200 x 300 x 24 mm beside its axes: 48 mm more at either end; from corner to corner the root of 3, as a cube of 1."""
    points = report.Points([[0.0, 0.0, 0.0], [1200.0, 300.0, 24.0]])
    scene = figure_of([points], (-60.0, 22.0))[0]["layout"]["scene"]
    ranges = [scene[f"{c}axis"]["range"] for c in "xyz"]
    assert ranges == [[-48.0, 1248.0], [-48.0, 348.0], [-48.0, 72.0]]
    edges = np.array([scene["aspectratio"][c] for c in "xyz"])
    assert edges / edges[0] == pytest.approx([1.0, 396 / 1296, 120 / 1296])
    assert np.linalg.norm(edges) == pytest.approx(math.sqrt(3.0))
    assert [scene[f"{c}axis"]["nticks"] for c in "xyz"] == [7, 2, 2]


def test_the_block_holds_figure_poster_and_words() -> None:
    block = report.scene(everything(), title="a <b> scene", caption="seen from the front")
    figure = figure_in(block)
    assert figure["layout"]["scene"]["camera"]["projection"] == {"type": "orthographic"}
    assert "seen from the front" in block
    assert "magnified 1\u202f000 ×." in block
    assert "a &lt;b&gt; scene" in block
    assert "NaN" not in re.sub(r"base64,[^\"]+", "", block)
    poster = re.search(r'src="data:image/png;base64,([^"]+)"', block)
    assert poster is not None
    raw = base64.b64decode(poster.group(1))
    assert raw[:8] == b"\x89PNG\r\n\x1a\n"
    assert len(raw) < 150_000


@pytest.mark.thorough
@pytest.mark.skipif(
    not shutil.which("chromium"), reason="chromium is not installed: the script cannot be run"
)
def test_a_browser_draws_turns_and_clips_the_scene(tmp_path: Path) -> None:
    """Offline, under the page's own policy: traces arrive, a key turns the camera by 5 degrees, a slider clips."""
    act = """
    const wait = () => {
      const figure = document.querySelector(".drawn"), live = document.querySelector(".live");
      if (!figure) return setTimeout(wait, 50);
      document.querySelector(".scene").dispatchEvent(new KeyboardEvent("keydown", {key: "ArrowRight"}));
      const slider = document.querySelectorAll(".clip input")[2];
      slider.value = 50; slider.oninput();
      setTimeout(() => {
        const s = live.layout.scene, mark = document.createElement("pre");
        mark.id = "found";
        mark.textContent = JSON.stringify({traces: live.data.length, eye: s.camera.eye, z: s.zaxis.range, edge: s.aspectratio.z, ink: live.layout.font.color, canvas: document.querySelectorAll("canvas").length});
        document.body.append(mark);
      }, 300);
    };
    wait();"""
    page = report.page("t", [report.scene(everything(), title="t", view=(0.0, 0.0))])
    found = _found(tmp_path, page.replace("</body>", f"<script>{act}</script></body>"))
    given = figure_of(everything(), (0.0, 0.0))[0]
    assert found["traces"] == len(given["data"])
    assert found["canvas"] >= 1
    turn = math.radians(5.0)
    assert [found["eye"][c] for c in "xyz"] == pytest.approx(
        [1.6 * math.cos(turn), 1.6 * math.sin(turn), 0.0], abs=1e-6
    )
    low, high = given["layout"]["scene"]["zaxis"]["range"]
    assert found["z"] == pytest.approx([low, (low + high) / 2])
    assert found["edge"] == pytest.approx(given["layout"]["scene"]["aspectratio"]["z"] / 2)  # true to scale
    assert found["ink"].startswith("#")


def _found(folder: Path, page: str) -> Any:
    """What the script of the page has written into #found, after it has run in a browser."""
    path = report.write(folder / "page.html", page)
    command = [
        "chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
        "--ignore-gpu-blocklist", "--disable-quic", "--no-first-run", "--disable-background-networking",
        "--disable-component-update", "--disable-sync", f"--user-data-dir={folder / 'profile'}",
        "--virtual-time-budget=20000", "--dump-dom", path.as_uri(),
    ]  # fmt: skip
    dom = subprocess.run(command, capture_output=True, text=True, timeout=120).stdout
    found = re.search(r'<pre id="found">(.*?)</pre>', dom, re.S)
    if not found:
        pytest.skip("chromium does not run here, or has no WebGL")
    return json.loads(found.group(1))
