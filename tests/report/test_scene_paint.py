"""Projection, camera, ellipses, labels."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import numpy as np
import pytest

from tests.report.drawn import display_of, the_svg, value
from vcmm import report
from vcmm.report.scene_paint import _polygon, basis, ellipse
from vcmm.report.text import text_width

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


def test_labels_do_not_touch_and_stay_inside() -> None:
    corner = report.Points([(100.0, 0.0, 100.0), (101.0, 0.0, 100.0)], labels=["a long label", "another one"])
    svg = the_svg(report.scene([CUBE, corner], title="t", width=300, height=400, view=(-90, 0)))
    first, second = (t for t in svg.iter("text") if t.get("paint-order"))
    for label in (first, second):
        assert 0 <= value(label, "x") <= 300 - text_width(label.text or "", 12)
    assert abs(value(first, "y") - value(second, "y")) >= 13


def test_glass_lets_through_and_has_no_stroke() -> None:
    solid, glass = (ET.fromstring(_polygon("M0 0H1V1Z", "#123456", opacity)) for opacity in (1.0, 0.4))
    assert (solid.get("fill-opacity"), solid.get("stroke")) == (None, "#123456")
    assert (glass.get("fill-opacity"), glass.get("stroke")) == ("0.4", None)
