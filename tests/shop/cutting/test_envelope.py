"""Swept envelopes: numbers by hand, and every kernel against dense sampling of the path by another formula."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.shop.cutting.numpy_twin import lowest
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.shop.cutting.envelope import BEYOND, CUT, UNCUT, surface_left, tips
from vcmm.shop.cutting.sweeps import Sweep, arcs, join, lines, path, position
from vcmm.shop.cutting.tools import Cutter, ball, bull, cone, drill, flat

UP = np.array([[0.0, 0.0, 1.0]])
CASES, FAR = 1000, 60.0
_NUMBER = np.arange(CASES)
APART = 250.0 * np.stack([_NUMBER % 32 - 16, _NUMBER // 32 - 16, 0 * _NUMBER], axis=1)
TOOLS = {
    "flat": flat(5.0),
    "ball": ball(5.0),
    "bull": bull(5.0, 1.5),
    "cone": cone(5.0, math.radians(90.0), 1.0),
    "drill": drill(5.0),
    "short": flat(5.0, 6.0),
}


def paths(kind: str, tool: Cutter, rng: np.random.Generator) -> Sweep:
    """CASES random moves of a few to a few tens of mm, so far apart that no ray meets two of them."""
    a, b = rng.uniform(-15.0, 15.0, (2, CASES, 3)) + APART
    if kind == "level":
        b[:, 2] = a[:, 2]
    if kind == "plunge":
        b[:, :2] = a[:, :2]
    if kind in ("level", "plunge", "ramp"):
        return lines(a, b, (tool,))
    radius, start, turn = (
        rng.uniform(1.0, 20.0, CASES),
        rng.uniform(0, 6.28, CASES),
        rng.uniform(-6.28, 6.28, CASES),
    )
    first, second, normal = np.eye(3) if kind != "upright" else np.roll(np.eye(3), 1, axis=0)
    grown = radius * (rng.uniform(0.8, 1.2, CASES) if kind == "helix" else 1.0)

    def at(r: Array, angle: Array) -> Array:
        return (r * np.cos(angle))[:, None] * first + (r * np.sin(angle))[:, None] * second

    rise = rng.uniform(-8.0, 8.0, CASES)[:, None] * normal * (kind == "helix")
    begin, end = a + at(radius, start), a + at(grown, start + turn) + rise
    return arcs(begin, end, a, turn, (tool,), normal=normal)


def rays(sweep: Sweep, rng: np.random.Generator) -> tuple[Array, Array]:
    """Points near the swept volume, all directions."""
    n = rng.normal(size=(CASES, 3))
    n /= np.linalg.norm(n, axis=1)[:, None]
    on = position(sweep, rng.uniform(0, 1, CASES))
    return on + rng.normal(size=(CASES, 3)) * 3.0 + [0, 0, 2.0], n


@pytest.mark.thorough
@pytest.mark.parametrize("shape", TOOLS)
@pytest.mark.parametrize("kind", ["level", "plunge", "ramp", "level arc", "upright", "helix"])
def test_every_kernel_against_dense_sampling(kind: str, shape: str) -> None:
    """The lowest entry of the ray into one sweep, from far below, agrees to 1e-9 mm in 10^3 random cases."""
    rng = np.random.default_rng([len(kind), len(shape), 5])
    sweep = paths(kind, TOOLS[shape], rng)
    p, n = rays(sweep, rng)
    want = lowest(sweep, p, n, 201, 9)
    far = p - FAR * n  # nominal far outside on the lower side: the surface is the first entry
    got = surface_left(far, n, sweep, depth=1.0, height=2 * FAR).s - FAR
    there = np.isfinite(want)
    hit = there & (want > -FAR)  # some rays come down the endless shank
    assert hit.mean() > 0.4
    assert np.isfinite(got[hit]).all()
    assert np.max(np.abs(got - want)[hit]) < 1e-9
    # The twin samples the path and may miss a ray that grazes; the kernel may not find what is not there.
    assert (np.isfinite(got) & ~there).sum() <= 3


def test_scallop_of_a_ball_mill_by_hand() -> None:
    """R 5, lines 0.5 mm apart: between the lines 5 - sqrt(5^2 - 0.25^2) = 6.2539 um, s^2 / 8 R = 6.25 um; below a line 0."""
    raster = join(lines([[-10, y, 0.0]], [[20, y, 0.0]], (ball(5.0),)) for y in np.arange(0.0, 10.1, 0.5))
    left = surface_left(np.array([[5, 5.25, 0.0], [5, 5.0, 0.0]]), UP.repeat(2, axis=0), raster)
    assert left.s[0] == pytest.approx(5 - math.sqrt(25 - 0.0625), abs=1e-14)
    assert left.s[1] == pytest.approx(0.0, abs=1e-14)
    assert np.allclose(
        left.normal[0, 0] @ [0, 0, 1.0], -math.sqrt(25 - 0.0625) / 5
    )  # cos of the contact angle
    assert left.row[0, :2].tolist() in ([10, 11], [11, 10])
    assert np.allclose(tips(left, raster)[0, 0, 2], 0.0)


def test_signs_uncut_and_gouge_by_hand() -> None:
    """A flat mill 0.1 mm too high leaves +0.1, too low -0.1; 0.8 deep with a search depth of 0.5: beyond; beside it: uncut."""
    p, n = np.array([[0.0, 0.0, 0.0]]), UP
    for z, s, status in ((0.1, 0.1, CUT), (-0.1, -0.1, CUT), (0.0, 0.0, CUT), (-0.8, -0.5, BEYOND)):
        left = surface_left(p, n, lines([[-9, 0, z]], [[9, 0, z]], (flat(5.0),)))
        assert left.status[0] == status
        assert left.s[0] == pytest.approx(s, abs=1e-14)
    beside = surface_left(p + [0, 5.1, 0], n, lines([[-9, 0, 0]], [[9, 0, 0]], (flat(5.0),)))
    assert beside.status[0] == UNCUT
    assert np.isnan(beside.s[0])
    assert beside.counts() == {"cut": 0, "uncut": 1, "gouge beyond the search depth": 0}


def test_a_wall_and_its_far_side_by_hand() -> None:
    """A slot at y = -20 behind a wall of 10 mm is no gouge of the wall at y = 5; a pocket that undercuts it by 0.2 is."""
    p, n = np.array([[0.0, -5.0, 3.0]]), np.array([[0.0, 1.0, 0.0]])  # wall facing +y, cut by R 5 along y = 0
    near, far = (
        lines([[-9, 0, 0]], [[9, 0, 0]], (flat(5.0),)),
        lines([[-9, -20, 0]], [[9, -20, 0]], (flat(5.0),)),
    )
    assert surface_left(p, n, join([near, far]), depth=30.0).s[0] == pytest.approx(0.0, abs=1e-14)
    under = lines([[-9, -10.0, 0]], [[9, -10.0, 0]], (flat(5.0),))  # reaches y = -5, from below: joins
    assert surface_left(p, n, join([near, under]), depth=30.0).s[0] == pytest.approx(-10.0, abs=1e-12)


def test_bore_by_a_full_circle_by_hand() -> None:
    """Flat R 5 around a circle of radius 20.01: the bore of nominal radius 25 is 10 um too large: s = -10 um."""
    circle = arcs([[20.01, 0, 0]], [[20.01, 0, 0]], [[0, 0, 0]], 2 * np.pi, (flat(5.0),))
    angle = np.linspace(0, 6.2, 50)
    out = np.stack([np.cos(angle), np.sin(angle), np.zeros(50)], axis=1)
    left = surface_left(25.0 * out + [0, 0, 4.0], -out, circle)
    assert np.allclose(left.s, -0.01, atol=1e-12)
    assert np.allclose(left.normal[:, 0], out, atol=1e-12)


def test_ramp_of_a_flat_mill_by_hand() -> None:
    """Down 45 deg along x: the lowest point over x = 10 is cut by the trailing rim: c_x - 5 = 10, so z = -15, not -10."""
    ramp = lines([[0, 0, 0]], [[30, 0, -30.0]], (flat(5.0),))
    left = surface_left(np.array([[10.0, 0, -15.0]]), UP, ramp)
    assert left.s[0] == pytest.approx(0.0, abs=1e-12)
    assert left.t[0, 0] == pytest.approx(0.5, abs=1e-9)
    # the rim leaves the ellipse c_x + sqrt(25 - y^2): at y = 3 it is 4 mm behind the axis, z = -14
    assert surface_left(np.array([[10.0, 3.0, -14.0]]), UP, ramp).s[0] == pytest.approx(0.0, abs=1e-12)
    assert left.normal[0, 0] == pytest.approx(-np.array([1, 0, 1]) / math.sqrt(2), abs=1e-6)


def test_drill_point_by_hand() -> None:
    """118 deg, R 5, tip at z = -10: at radius 3 the hole ends at -10 + 3 / tan 59 deg = -8.19742."""
    hole = lines([[0, 0, 5.0]], [[0, 0, -10.0]], (drill(5.0),))
    depth = -10 + 3 / math.tan(math.radians(59))
    assert depth == pytest.approx(-8.19742, abs=1e-5)
    assert surface_left(np.array([[3.0, 0, depth]]), UP, hole).s[0] == pytest.approx(0.0, abs=1e-12)


def test_indexed_tool_axis() -> None:
    """The raster turned as a whole, tool and all, leaves the same scallop."""
    c, s = math.cos(0.7), math.sin(0.7)
    turn = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    y = np.arange(0.0, 10.1, 0.5)
    a, b = np.stack([-10 + 0 * y, y, 0 * y], 1), np.stack([20 + 0 * y, y, 0 * y], 1)
    raster = lines(a @ turn.T, b @ turn.T, (ball(5.0),), axis=turn[:, 2])
    left = surface_left(np.array([[5, 5.25, 0.0]]) @ turn.T, UP @ turn.T, raster)
    assert left.s[0] == pytest.approx(5 - math.sqrt(25 - 0.0625), abs=1e-13)
    assert left.normal[0, 0] @ turn[:, 2] == pytest.approx(-math.sqrt(25 - 0.0625) / 5, abs=1e-12)


@pytest.mark.thorough
def test_the_index_changes_nothing() -> None:
    """Many moves of four tools against the lowest of all moves one by one, for points that no move gouges."""
    rng = np.random.default_rng(3)
    z = rng.uniform(1.0, 3.0, 400)
    xy = rng.uniform(-30, 30, (400, 2))
    end = np.column_stack([xy + rng.uniform(-4, 4, (400, 2)), z + rng.uniform(-0.5, 0.5, 400)])
    tools = (ball(3.0), flat(2.0), bull(4.0, 1.0), cone(3.0, 1.5))
    sweep = lines(np.column_stack([xy, z]), end, tools, rng.integers(0, 4, 400))
    p = np.column_stack([rng.uniform(-30, 30, (60, 2)), np.zeros(60)])
    left = surface_left(p, UP.repeat(60, axis=0), sweep, height=8.0, band=0.2)
    for i in range(60):
        every = np.sort(lowest(sweep, np.tile(p[i], (400, 1)), np.tile(UP[0], (400, 1)), 101))
        found = left.contact_s[i][np.isfinite(left.contact_s[i])]
        assert len(found) == min(np.sum(np.isfinite(every) & (every <= every[0] + 0.2)), 4)
        assert np.allclose(found, every[: len(found)], atol=1e-9)


def test_wrong_use_is_explained() -> None:
    with pytest.raises(UsageError, match="misses its end"):
        arcs([[1, 0, 0]], [[0, 2, 0]], [[0, 0, 0]], np.pi, (flat(1.0),))
    with pytest.raises(UsageError, match="unit normal"):
        surface_left(np.zeros((1, 3)), np.array([[0, 0, 2.0]]), path(np.eye(3), (flat(1.0),)))
    with pytest.raises(UsageError, match="corner radius"):
        bull(5.0, 5.0)


def test_a_ray_along_the_path_meets_the_end_that_looks_at_it() -> None:
    """Ball of 5 mm along x from 0 to 30, centre at height 5: from -20 forwards at -5, from 50 backwards at 35, 15 mm on."""
    sweep = lines([[0, 0, 0]], [[30, 0, 0]], (ball(5.0),))
    points, normals = np.array([[-20.0, 0, 5], [50.0, 0, 5]]), np.array([[1.0, 0, 0], [-1.0, 0, 0]])
    left = surface_left(points, normals, sweep, depth=1.0, height=100.0)
    assert left.s == pytest.approx([15.0, 15.0], abs=1e-12)
    assert left.t[:, 0] == pytest.approx([0.0, 1.0])
    assert left.normal[:, 0] == pytest.approx(-normals, abs=1e-12)
