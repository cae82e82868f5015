"""Scenes: refusals, hidden parts, and the script in the page."""

from __future__ import annotations

import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

from tests.report.drawn import NAN, display_of, the_svg, value
from vcmm import report
from vcmm.core.errors import DataError, ModelLimit
from vcmm.report.scene_items import Item
from vcmm.report.scene_paint import draw


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
