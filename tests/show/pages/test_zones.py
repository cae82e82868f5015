"""Pictures of zones: what they carry is the value that the table states for the same points."""

from __future__ import annotations

import html
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vcmm.answer.evaluation import inversion
from vcmm.face import api
from vcmm.files.own.scenario import load_scenario
from vcmm.part.gps.zone_points import least_squares_circle, minimum_zone_circles
from vcmm.show.charts import ChartSheet, flatness_zone, position_zone
from vcmm.show.pages.uncertainty import zone_picture

PART = """vcmm = "scenario/1"
[machine]
structure = "w b Y X Z t"
[machine.axes.X]
travel = ["0 mm", "600 mm"]
[machine.axes.Y]
travel = ["0 mm", "500 mm"]
[machine.axes.Z]
travel = ["-400 mm", "0 mm"]
[machine.repeatability]
law = "normal"
u = "0.5 um"
[pose]
shift = "300 250 -200 mm"
[part.features]
top = { type = "plane", point = "0 0 0 mm", normal = [0, 0, 1], size = "80 60 mm" }
ring = { type = "circle", point = "0 0 -5 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true }
[[part.characteristics]]
name = "flat"
type = "flatness"
of = "top"
zone = "0.03 mm"
[[part.characteristics]]
name = "round"
type = "roundness"
of = "ring"
zone = "0.03 mm"
[[part.characteristics]]
name = "placed"
type = "position"
of = "ring"
zone = "0.03 mm"
material = "M"
[[part.characteristics]]
name = "bore"
type = "size"
of = "ring"
limits = ["-0.010 mm", "0.020 mm"]
[plan]
styli.down = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
[[plan.steps]]
feature = "top"
stylus = "down"
points = { strategy = "grid", n = [4, 3], margin = "5 mm" }
[[plan.steps]]
feature = "ring"
stylus = "down"
points = { strategy = "even", n = 24 }
[job]
trials = 1000
"""


def numbers(page: str) -> dict[str, Any]:
    return dict(json.loads(html.unescape(re.findall(r'data-chart="([^"]*)"', page)[0])))


@pytest.fixture
def evaluated(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A warped top and a ring of two lobes, 30.006 mm, (12, -9) um off."""
    monkeypatch.setattr(inversion, "PARTS", (2000, 2000))
    monkeypatch.setattr(inversion, "COUNT_TRIALS", (400, 400))
    (tmp_path / "p.toml").write_text(PART)
    scenario = load_scenario(tmp_path / "p.toml")
    touches = scenario.task().touches
    rows = ["feature,x_mm,y_mm,z_mm"]
    for name, which in touches.rows.items():
        for x, y, z in touches.points[which]:
            if name == "top":
                z += 4e-3 * (x / 35.0) * (y / 25.0)
            else:
                t = math.atan2(y, x)
                r = 15.003 + 2e-3 * math.cos(2 * t)
                x, y = r * math.cos(t) + 12e-3, r * math.sin(t) - 9e-3
            rows.append(f"{name},{x:.9f},{y:.9f},{z:.9f}")
    (tmp_path / "points.csv").write_text("\n".join(rows) + "\n")
    (found,) = api.evaluate(scenario, points=tmp_path / "points.csv")
    return found


@pytest.mark.thorough
def test_the_picture_is_the_table(evaluated: Any) -> None:
    """Flat by pencil: corners of the twist at +-4 um are 8 um apart and no plane is nearer. Round: two lobes of 2 um are 4 um.

    Placed: 2 sqrt(12^2 + 9^2) = 30 um, of which 30.006 - 29.990 = 16 um are paid: 14 um.
    """
    model = evaluated.uncertainty.model
    flat, round_, placed = (numbers(zone_picture(model, c)[0]) for c in model.characteristics[:3])
    assert flat["value"] == pytest.approx(8.0, abs=2e-3)
    assert round_["width"]["unfiltered"] == pytest.approx(4.0, abs=0.02)
    assert round_["circles"]["LSC"]["width"] == pytest.approx(4.0, abs=0.02)
    assert round_["circles"]["MZC"]["width"] == pytest.approx(4.0, abs=0.02)
    assert placed["circle"] == pytest.approx(30.0, abs=0.02)
    assert placed["paid"] == pytest.approx(16.0, abs=0.02)
    assert placed["value"] == pytest.approx(14.0, abs=0.04)
    for shown, i in ((flat["value"], 0), (round_["width"]["unfiltered"], 1), (placed["value"], 2)):
        assert shown == pytest.approx(1e3 * model.at_estimates[i], rel=1e-6)
        assert shown == pytest.approx(1e3 * evaluated.characteristics[i].measured, rel=1e-6)


def test_circles_by_pencil() -> None:
    """Deviations 1, 0, 0, 0 at 0, 90, 180, 270 deg: least squares 1/4 + 1/2 cos t, residuals +-1/4, so 1/2 by both criteria."""
    angle = np.radians([0.0, 90.0, 180.0, 270.0])
    dev = np.array([1.0, 0.0, 0.0, 0.0])
    circle, width = least_squares_circle(angle, dev)
    assert circle == pytest.approx([0.25, 0.5, 0.0], abs=1e-12)
    assert width == pytest.approx(0.5)
    assert minimum_zone_circles(angle, dev)[1] == pytest.approx(0.5)
    # one spike among 36 points: least squares leaves nearly all of it, the minimum zone takes some off by moving the centre
    angle = np.radians(np.arange(0.0, 360.0, 10.0))
    dev = np.where(np.arange(36) == 0, 1.0, 0.0)
    assert minimum_zone_circles(angle, dev)[1] < least_squares_circle(angle, dev)[1] < 1.0
    shifted = (
        dev + 3.0 + 2.0 * np.cos(angle) - 5.0 * np.sin(angle)
    )  # another centre and radius change nothing
    assert minimum_zone_circles(angle, shifted)[1] == pytest.approx(
        minimum_zone_circles(angle, dev)[1], abs=1e-9
    )


def test_zones_by_themselves() -> None:
    shown = flatness_zone([0.0, 1.0], [-1.0, 2.0], 5.0, title="t", ax=ChartSheet()).vcmm_numbers
    assert shown["value"] == 3.0
    assert shown["planes"] == [-1.0, 2.0]
    shown = position_zone([[3.0, 4.0]], 6.0, 20.0, title="t", ax=ChartSheet()).vcmm_numbers
    assert (shown["circle"], shown["value"]) == (10.0, 0.0)
