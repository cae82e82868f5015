"""Orientation of the extracted surface (ISO 1101) beside pencil and a truth by scipy that shares no code with the package."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from tests.build import LEFT, scenario
from vcmm.answer.evaluation.exact import draw_inputs, exact_values, linear_quantities
from vcmm.answer.evaluation.linear import build
from vcmm.core.errors import UsageError
from vcmm.part.fit import gauss
from vcmm.part.gps.characteristics import evaluate, nominal
from vcmm.part.gps.criteria import with_criteria
from vcmm.part.part import Characteristic, Feature, surface_point
from vcmm.task.measuring.task import nominal_element

X, Y, Z = np.eye(3)
BASE = Feature("base", "plane", np.zeros(3), Z, np.zeros(0), extent=(100.0, 100.0))
LEDGE = Feature("ledge", "plane", np.array([0.0, 0, 20]), Z, np.zeros(0), extent=(80.0, 40.0))
FRONT = Feature("front", "plane", np.array([0.0, -50, 10]), -Y, np.zeros(0), extent=(80.0, 20.0))
SLOPE = Feature(
    "slope",
    "plane",
    np.array([0.0, 0, 30]),
    np.array([0.0, 0.5, np.sqrt(0.75)]),
    np.zeros(0),
    extent=(60.0, 40.0),
)
PIN = Feature("pin", "cylinder", np.array([0.0, 0, 20]), Z, np.array([10.0]), extent=(30.0,))
STRIP = Feature("strip", "line", np.array([-40.0, 0, 20]), X, np.zeros(0), extent=(80.0,), u=Z)
ALL = {f.name: f for f in (BASE, LEDGE, FRONT, SLOPE, PIN, STRIP)}


def grid(f: Feature, n: int = 21) -> np.ndarray:
    if f.kind == "cylinder":
        return surface_point(f, np.tile(np.arange(24) * np.pi / 12, 4), np.repeat([3.0, 10, 20, 27], 24))
    if f.kind == "line":
        return surface_point(f, np.linspace(0, f.extent[0], n))
    u, v = (np.linspace(-e / 2, e / 2, n) for e in f.extent)
    return surface_point(f, np.repeat(u, n), np.tile(v, n))


def value(kind: str, of: str, datum: str, points: np.ndarray, **more: str) -> float:
    c = Characteristic("c", kind, of=of, datums=(datum,), zone=0.02, **more)  # type: ignore[arg-type]
    measured = {of: points, datum: grid(ALL[datum])}
    fitted = {n: gauss(ALL[n].kind, p, nominal_element(ALL[n])) for n, p in measured.items()}
    assert nominal(c, ALL) == pytest.approx(0.0, abs=1e-12)
    return 1e3 * float(evaluate(c, ALL, with_criteria([c], ALL, measured.__getitem__, fitted)))


def bowed(f: Feature, along: np.ndarray, height: float = 0.015) -> np.ndarray:
    """Its middle lies `height` lower than two opposite edges."""
    p = grid(f)
    way = (p - f.point) @ along
    return p + np.outer(height * (way / np.abs(way).max()) ** 2, f.axis)


@pytest.mark.parametrize(("kind", "of", "datum", "along"), [
    ("parallelism", "ledge", "base", X), ("parallelism", "ledge", "base", Y), ("perpendicularity", "front", "base", X),
    ("perpendicularity", "front", "base", Z), ("perpendicularity", "ledge", "pin", X), ("parallelism", "front", "pin", X),
    ("angularity", "slope", "base", X), ("angularity", "slope", "pin", X),
])  # fmt: skip
def test_a_bow_of_15_um_is_an_orientation_of_15_um(kind: str, of: str, datum: str, along: np.ndarray) -> None:
    """The surface between two planes at the angle to the datum: 15 um. Its least-squares plane lies square to that: 0; so do the
    middle of its zone and, on both edges, the tangent plane.
    """
    points = bowed(ALL[of], along)
    assert value(kind, of, datum, points) == pytest.approx(15.0, abs=1e-6)
    for modifier in "GCT":
        assert value(kind, of, datum, points, criterion=modifier) == pytest.approx(0.0, abs=0.01)


def test_a_line_on_a_surface_is_the_extracted_line() -> None:
    line = grid(STRIP)
    line = line + np.outer(0.015 * (line[:, 0] / 40) ** 2 + 1e-4 * line[:, 0], Z)
    # 0.1 mrad over x = -40 .. 40 and the bow: 15 + 4 at the right end; lowest where 2 x 0.015 / 40^2 + 1e-4 = 0: x = -5.33, -0.267
    lowest = line[:, 2].min() - 20.0
    assert value("parallelism", "strip", "base", line) == pytest.approx(19.0 - 1e3 * lowest, abs=1e-6)
    assert value("parallelism", "strip", "base", line, criterion="G") == pytest.approx(
        8.0, abs=1e-3
    )  # 0.1 mrad x 80 mm


def test_the_turn_that_a_datum_leaves_is_free() -> None:
    """Front turned by 1 mrad about the normal of the base: nothing; leaning by 1 mrad over its height of 20 mm: 20 um."""
    p = grid(FRONT)
    turned, leaning = p + np.outer(1e-3 * p[:, 0], Y), p + np.outer(1e-3 * (p[:, 2] - 10), Y)
    assert value("perpendicularity", "front", "base", turned) == pytest.approx(0.0, abs=2e-5)
    assert value("perpendicularity", "front", "base", leaning) == pytest.approx(20.0, abs=2e-5)


@pytest.mark.parametrize("seed", range(5))
def test_a_rough_front_beside_scipy(seed: int) -> None:
    """The narrowest pair of planes square to the base, by search over the turn."""
    rng = np.random.default_rng(seed)
    p = grid(FRONT, 9)
    p = p + np.outer(3e-3 * rng.normal(size=len(p)) + 1e-4 * p[:, 0] + 1e-4 * p[:, 2], Y)

    def width(turn: float) -> float:
        return float(np.ptp(p @ np.array([np.sin(turn * 1e-3), np.cos(turn * 1e-3), 0.0])))

    around = np.linspace(-0.5, 0.5, 401)
    best = around[np.argmin([width(t) for t in around])]
    right = minimize_scalar(
        width, bounds=(best - 0.01, best + 0.01), method="bounded", options={"xatol": 1e-9}
    ).fun
    assert value("perpendicularity", "front", "base", p) == pytest.approx(1e3 * right, abs=2e-3)


def test_without_points_nothing_else_is_said() -> None:
    c = Characteristic("c", "parallelism", of="ledge", datums=("base",), zone=0.02)
    points = {"ledge": bowed(LEDGE, X), "base": grid(BASE)}
    fitted = {n: gauss("plane", p, nominal_element(ALL[n])) for n, p in points.items()}
    with pytest.raises(
        UsageError, match='criterion = "G" asks for the orientation of the least-squares element'
    ):
        evaluate(c, ALL, fitted)


def test_the_linear_model_and_the_exact_engine_see_the_same_surface() -> None:
    """Trials of 1 um scatter on faces with 3 um of form: linear and exact to some nm, and larger than the tilt of the planes."""
    found = Characteristic("p", "parallelism", of=("left",), datums=("right",), zone=0.02)
    task = scenario(characteristics=(found, replace(found, name="g", criterion="G"))).task()
    rows = task.touches.rows["left"]
    form = np.zeros(len(task.form))
    at = task.touches.points[rows] - LEFT.point
    form[rows] = 3e-3 * np.sign(at[:, 1] * at[:, 2])  # twisted: no tilt at all
    model = build(replace(task, form=form))
    assert model.at_estimates == pytest.approx([6e-3, 0.0], abs=1e-6)
    drawn = draw_inputs(model, 1, 0, 50)
    linear, exact = model.values(linear_quantities(model, drawn)), exact_values(model, drawn)
    assert np.abs(linear - exact).max() < 5e-6
    assert (exact[:, 0] > exact[:, 1]).mean() > 0.9
