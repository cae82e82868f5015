"""The drawing language by hand: every case has points of known answer, found with a pencil."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from vcmm.core.errors import DataError, UsageError
from vcmm.core.pose import Pose
from vcmm.part.fit import FittedElement, gauss
from vcmm.part.gps.characteristics import evaluate, needs, nominal
from vcmm.part.gps.criteria import choose_criteria, with_criteria
from vcmm.part.part import Characteristic, Feature
from vcmm.task.measuring.task import nominal_element

UP, EAST = np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0])
TURN = np.arange(24) * (2 * np.pi / 24)


def cylinder(
    name: str, point: Any, length: float = 20.0, radius: float = 10.0, inside: bool = False
) -> Feature:
    return Feature(name, "cylinder", np.array(point, float), UP, np.array([radius]), inside, (length,))


def circle(name: str, point: Any, radius: float = 5.0, inside: bool = True) -> Feature:
    return Feature(name, "circle", np.array(point, float), UP, np.array([radius]), inside)


def plane(name: str, point: Any, normal: Any = UP, size: tuple[float, float] = (80.0, 80.0)) -> Feature:
    return Feature(name, "plane", np.array(point, float), np.array(normal, float), np.zeros(0), extent=size)


def round_points(radius: Any, heights: Any, centre: Any = (0.0, 0.0)) -> np.ndarray:
    """Points at every height (a list), radius (24,) or a number, about a centre that may be one per height."""
    middle = np.broadcast_to(np.asarray(centre, float), (len(heights), 2))
    rows = [
        np.column_stack([c[0] + radius * np.cos(TURN), c[1] + radius * np.sin(TURN), np.full(24, z)])
        for z, c in zip(heights, middle)
    ]
    return np.concatenate(rows)


def value(
    c: Characteristic, features: list[Feature], points: dict[str, np.ndarray], pose: Pose | None = None
) -> float:
    """The characteristic of measured points in the drawing frame."""
    named = {f.name: f for f in features}
    fitted: dict[str, FittedElement] = {}
    for name, p in points.items():
        fixed = named[name].axis if named[name].kind == "circle" else None
        fitted[name] = gauss(named[name].kind, p, nominal_element(named[name]), fixed_axis=fixed)
    full = with_criteria([c], named, lambda name: points[name], fitted)
    assert nominal(c, named) >= 0.0
    return float(evaluate(c, named, full, pose))


def found(features: list[Feature], places: dict[str, Any], c: Characteristic) -> float:
    """The same where features are found perfect at other places: name -> (point, axis, sizes)."""
    named = {f.name: f for f in features}
    fitted = {
        n: FittedElement(
            named[n].kind,
            np.array(p, float),
            np.array(a, float) / np.linalg.norm(a),
            np.atleast_1d(s),
            np.zeros(1),
            np.zeros((1, 3)),
        )
        for n, (p, a, s) in places.items()
    }
    return float(evaluate(c, named, fitted))


# ------------------------------------------------------------------ run-out

AXIS = cylinder("axis", (0, 0, 0))


def test_circular_runout_of_a_ring_that_lies_off_the_axis_is_twice_the_offset() -> None:
    ring = circle("ring", (0, 0, 30), 15.0, inside=False)
    c = Characteristic("c", "circular_runout", of=("ring",), datums=("axis",), zone=0.1)
    off = {"axis": round_points(10.0, [2, 18]), "ring": round_points(15.0, [30], (0.03, 0.0))}
    assert value(c, [AXIS, ring], off) == pytest.approx(0.06, abs=1e-9)


def test_runout_in_sections_and_over_the_whole() -> None:
    """A cone of 0.05 mm on the radius: every section is round; the whole runs out by 0.05. Section 2 oval by +-0.01."""
    seat = cylinder("seat", (0, 0, 30), 20.0, 15.0)
    points = np.concatenate([round_points(15.0, [32]), round_points(15.05 + 0.01 * np.cos(2 * TURN), [48])])
    measured = {"axis": round_points(10.0, [2, 18]), "seat": points}
    c = Characteristic("c", "circular_runout", of=("seat",), datums=("axis",), zone=0.1)
    assert value(c, [AXIS, seat], measured) == pytest.approx(0.02, abs=1e-9)
    total = Characteristic("t", "total_runout", of=("seat",), datums=("axis",), zone=0.1)
    assert value(total, [AXIS, seat], measured) == pytest.approx(0.06, abs=1e-9)


def test_axial_runout_of_a_face() -> None:
    """A face tilted by 1 mrad: at radius 20 it runs out by 0.04, over radii 10 and 20 in total by 0.04; dished 0.01: 0.05."""
    face = plane("face", (0, 0, 20))
    r = np.repeat([10.0, 20.0], 24)
    x, y = r * np.cos(np.tile(TURN, 2)), r * np.sin(np.tile(TURN, 2))
    z = 20.0 + 1e-3 * x - np.where(r < 15.0, 0.03, 0.0)
    measured = {"axis": round_points(10.0, [2, 18]), "face": np.column_stack([x, y, z])}
    c = Characteristic("c", "circular_runout", of=("face",), datums=("axis",), zone=0.1)
    assert value(c, [AXIS, face], measured) == pytest.approx(0.04, abs=1e-8)
    total = Characteristic("t", "total_runout", of=("face",), datums=("axis",), zone=0.1)
    assert value(total, [AXIS, face], measured) == pytest.approx(
        0.06, abs=1e-8
    )  # -0.02 .. 0.02 and -0.04 .. -0.02


def test_runout_of_a_cone_counts_square_to_its_surface() -> None:
    cone = Feature("cone", "cone", np.array([0.0, 0, 30]), UP, np.array([10.0, np.pi / 6]), False, (20.0,))
    radius = 10.0 + 4.0 * np.tan(np.pi / 6)
    measured = {"axis": round_points(10.0, [2, 18]), "cone": round_points(radius, [34], (0.03, 0.0))}
    measured["cone"] = np.concatenate(
        [measured["cone"], round_points(10.0 + 16.0 * np.tan(np.pi / 6), [46], (0.03, 0.0))]
    )
    c = Characteristic("c", "circular_runout", of=("cone",), datums=("axis",), zone=0.1)
    assert value(c, [AXIS, cone], measured) == pytest.approx(0.06 * np.cos(np.pi / 6), abs=1e-8)


def test_runout_about_a_common_axis_of_two_journals() -> None:
    """Journals off by +-0.02 at heights 10 and 90: the common axis passes the middle at 50 on the drawn axis."""
    a, b = cylinder("a", (0, 0, 0)), cylinder("b", (0, 0, 80))
    ring = circle("ring", (0, 0, 50), 15.0, inside=False)
    c = Characteristic("c", "circular_runout", of=("ring",), datums=(("a", "b"),), zone=0.1)
    assert needs(c) == ("ring", "a", "b")
    measured = {
        "a": round_points(10.0, [2, 18], (0.02, 0.0)), "b": round_points(10.0, [82, 98], (-0.02, 0.0)),
        "ring": round_points(15.0, [50]),
    }  # fmt: skip
    assert value(c, [a, b, ring], measured) == pytest.approx(
        0.0, abs=3e-6
    )  # the axis is tilted by 0.5 mrad: 15 mm (1 - cos)
    measured["ring"] = round_points(15.0, [50], (0.01, 0.0))
    assert value(c, [a, b, ring], measured) == pytest.approx(0.02, abs=3e-6)


def test_a_runout_that_cannot_turn_is_refused() -> None:
    named = {f.name: f for f in (AXIS, circle("ring", (3, 0, 30)), plane("top", (0, 0, 20)))}
    c = Characteristic("c", "circular_runout", of=("ring",), datums=("axis",), zone=0.1)
    with pytest.raises(UsageError, match='"ring" does not turn about "axis"'):
        nominal(c, named)
    c = Characteristic("c", "circular_runout", of=("axis",), datums=("top",), zone=0.1)
    with pytest.raises(UsageError, match="a plane gives none"):
        nominal(c, named)
    with pytest.raises(DataError, match="toleranced to itself"):
        Characteristic("c", "circular_runout", of=("axis",), datums=("axis",))


# ------------------------------------------------------------------ profile

GRID = np.array([[x, y] for x in (-30.0, 0.0, 30.0) for y in (-30.0, 0.0, 30.0)])


def grid(height: Any) -> np.ndarray:
    return np.column_stack([GRID, np.broadcast_to(height, (9,))])


def test_surface_profile_to_datums_and_without() -> None:
    """A plane 0.03 too high and bent by 0.01 at its corners: to the base 2 x 0.04; by itself +-0.005 at best."""
    top, base = plane("top", (0, 0, 20)), plane("base", (0, 0, 0), -UP)
    corner = (np.abs(GRID).sum(axis=1) > 50).astype(float)
    points = {"top": grid(20.03 + 0.01 * corner), "base": grid(0.0)}
    to_base = Characteristic("c", "surface_profile", of=("top",), datums=("base",), zone=0.1)
    assert value(to_base, [top, base], points) == pytest.approx(0.08, abs=1e-9)
    alone = Characteristic("c", "surface_profile", of=("top",), criterion="C", zone=0.1)
    assert value(alone, [top, base], points) == pytest.approx(0.01, abs=2e-5)
    gauss_fit = Characteristic(
        "c", "surface_profile", of=("top",), zone=0.1
    )  # least squares: 4 of 9 are 0.01 high
    assert value(gauss_fit, [top, base], points) == pytest.approx(2 * 0.01 * 5 / 9, abs=1e-9)


def test_a_profile_keeps_the_exact_size_and_moves_freely() -> None:
    """A bore 0.02 too large on the radius and 0.3 um beside its place: without datums only the size is left, 2 x 0.02."""
    bore = cylinder("bore", (0, 0, 0), inside=True)
    points = {"bore": round_points(10.02, [2, 18], (0.0003, 0.0))}
    c = Characteristic("c", "surface_profile", of=("bore",), zone=0.1)
    assert value(c, [bore], points) == pytest.approx(
        0.04, abs=3e-6
    )  # the fit is of first order: 0.02 / 10 of the 0.3 um


def test_line_profile_of_a_section() -> None:
    """Three lobes of 0.01 on a section of exact size: +-0.01, so 0.02."""
    ring = circle("ring", (0, 0, 10), 10.0, inside=False)
    points = {"ring": round_points(10.0 + 0.01 * np.cos(3 * TURN), [10])}
    c = Characteristic("c", "line_profile", of=("ring",), zone=0.1)
    assert value(c, [ring], points) == pytest.approx(0.02, abs=1e-6)


# ------------------------------------------------------------------ patterns

HOLES = [
    circle(f"h{i}", (20 * x, 20 * y, 0)) for i, (x, y) in enumerate([(1, 1), (-1, 1), (-1, -1), (1, -1)])
]
NAMES = tuple(h.name for h in HOLES)


def holes(shift: Any = (0.0, 0.0), turn: float = 0.0, own: Any = None) -> dict[str, Any]:
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    out = {}
    for i, h in enumerate(HOLES):
        at = rotation @ h.point[:2] + np.asarray(shift) + (0.0 if own is None else own[i])
        out[h.name] = ((*at, 0.0), UP, 5.0)
    return out


def test_a_pattern_moves_as_a_whole_where_no_datum_holds_it() -> None:
    alone = Characteristic("c", "position", of=NAMES, zone=0.1)
    assert found(HOLES, holes((0.3, -0.2), 1e-4), alone) == pytest.approx(0.0, abs=1e-6)
    apart = [
        np.array([0.01, 0.01]) * np.sign(h.point[:2]) for h in HOLES
    ]  # 0.01 sqrt 2 outwards each: no motion helps
    assert found(HOLES, holes(own=apart), alone) == pytest.approx(2 * 0.01 * np.sqrt(2), abs=1e-9)


def test_datums_hold_a_pattern_and_a_composite_lets_it_go() -> None:
    """Upper line: to base and side, 0.1 to the right counts. Lower line: to the base only, nothing is left."""
    base, side = plane("base", (0, 0, 0), -UP), plane("side", (-40, 0, 0), -EAST)
    front = plane("front", (0, -40, 0), (0, -1, 0))
    drawn = {
        "base": ((0, 0, 0), -UP, ()),
        "side": ((-40, 0, 0), -EAST, ()),
        "front": ((0, -40, 0), (0, -1, 0), ()),
    }
    features = [*HOLES, base, side, front]
    upper = Characteristic("u", "position", of=NAMES, datums=("base", "side", "front"), zone=0.3)
    lower = Characteristic("l", "position", of=NAMES, datums=("base",), zone=0.05)
    places = holes((0.1, 0.0)) | drawn
    assert found(features, places, upper) == pytest.approx(0.2, abs=1e-9)
    assert found(features, places, lower) == pytest.approx(0.0, abs=1e-9)
    one_off = [np.zeros(2), np.zeros(2), np.zeros(2), np.array([0.04, 0.0])]
    both = holes((0.1, 0.0), own=one_off) | drawn
    assert found(features, both, upper) == pytest.approx(0.28, abs=1e-9)
    assert 0.02 < found(features, both, lower) < 0.08


def test_separate_zones_and_the_smallest_largest() -> None:
    separate = Characteristic("c", "position", of=NAMES, zones="SZ", zone=0.1)
    assert found(HOLES, holes(own=np.array([[0.02, 0], [0, 0], [0, 0], [0, 0]])), separate) == pytest.approx(
        0.0, abs=1e-9
    )
    pair = HOLES[:2]
    c = Characteristic("c", "position", of=NAMES[:2], criterion="C", zone=0.1)
    points = {"h0": round_points(5.0, [0.0], (20.03, 20.0)), "h1": round_points(5.0, [0.0], (-20.0, 20.0))}
    assert value(c, pair, points) == pytest.approx(
        0.03, abs=1e-6
    )  # 0.015 each: the distance is 0.03 too large


# ------------------------------------------------------------------ projected zone, material requirements

HOLE = cylinder("hole", (0, 0, -20), radius=5.0, inside=True)


def test_a_projected_zone_stands_where_the_stud_will_be() -> None:
    """Tilted by 1 mrad about the upper face: 0.04 in the hole (2 x 0.02), 0.06 over 30 mm above it."""
    tilted = {"hole": ((0, 0, 0), (1e-3, 0, 1), 5.0)}
    within = Characteristic("c", "position", of=("hole",), zone=0.1)
    above = Characteristic("c", "position", of=("hole",), zone=0.1, projected=30.0)
    assert found([HOLE], tilted, within) == pytest.approx(0.04, rel=1e-5)
    assert found([HOLE], tilted, above) == pytest.approx(0.06, rel=1e-5)
    below = Characteristic("c", "position", of=("hole",), zone=0.1, projected=-10.0)
    assert found([HOLE], tilted, below) == pytest.approx(0.06, rel=1e-5)  # 20 .. 30 mm below the face


@pytest.mark.parametrize(
    ("inside", "material", "diameter", "expected"),
    [
        (True, "M", 10.06, 0.19), (True, "M", 10.0, 0.25), (True, "L", 10.06, 0.21), (True, "L", 10.1, 0.25),
        (False, "M", 10.06, 0.21), (False, "M", 10.1, 0.25), (False, "L", 10.06, 0.19), (True, "M", 10.3, 0.0),
    ],
)  # fmt: skip
def test_size_pays_for_position(inside: bool, material: str, diameter: float, expected: float) -> None:
    """Limits 10.0 to 10.1, the axis 0.125 beside its place: 0.25 less what the size has left (ISO 2692)."""
    feature = cylinder("hole", (0, 0, -20), radius=5.0, inside=inside)
    c = Characteristic("c", "position", of=("hole",), zone=0.2, material=material, size_limits=(10.0, 10.1))
    places = {"hole": ((0.125, 0, -10), UP, diameter / 2)}
    assert found([feature], places, c) == pytest.approx(expected, abs=1e-9)


def test_words_of_a_drawing_that_contradict_are_refused() -> None:
    with pytest.raises(DataError, match="needs the limits of the size"):
        Characteristic("c", "position", of=("hole",), zone=0.2, material="M")
    with pytest.raises(DataError, match="material requirement goes with"):
        Characteristic("c", "roundness", of=("hole",), zone=0.2, material="M", size_limits=(1.0, 2.0))
    for kind in ({"type": "surface_profile", "of": ("blade",)}, {"type": "distance", "between": ("a", "b")}):
        with pytest.raises(DataError) as told:  # and nothing of limits of a size, which these have not
            Characteristic("c", **kind, material="M")
        assert len(told.value.problems) == 1
        assert "goes with position" in str(told.value)
    with pytest.raises(DataError, match='between "hole" and itself'):
        Characteristic("c", "distance", between=("hole", "hole"))
    with pytest.raises(DataError, match="combined, one pattern"):
        Characteristic("c", "position", of=("hole",), zones="XZ")
    named = {f.name: f for f in (AXIS, cylinder("b", (1, 0, 40)), circle("ring", (0, 0, 30)))}
    apart = Characteristic("c", "circular_runout", of=("ring",), datums=(("axis", "b"),))
    with pytest.raises(UsageError, match="apart from one axis or plane"):
        nominal(apart, named)


# ------------------------------------------------------------------ common planes, datums in contact


def test_a_common_plane_of_two_pads() -> None:
    """Pads at x = -30 and 30, the right one 0.006 high: the common plane is tilted by 0.006 / 60; a bore of 20 mm sees 2 um."""
    left, right = plane("left", (-30, 0, 0), size=(10, 40)), plane("right", (30, 0, 0), size=(10, 40))
    bore = cylinder("bore", (0, 0, 0), inside=True)
    c = Characteristic("c", "perpendicularity", of=("bore",), datums=(("left", "right"),), zone=0.01)
    places = {
        "left": ((-30, 0, 0), UP, ()),
        "right": ((30, 0, 0.006), UP, ()),
        "bore": ((0, 0, 10), UP, 10.0),
    }
    slope = 0.006 * 60 / (60**2 + 10**2)  # least squares over the corners at 25, 35 on either side
    assert found([left, right, bore], places, c) == pytest.approx(20 * slope, rel=1e-4)


def test_a_datum_in_contact_outside_the_material() -> None:
    """Two edges are high: 0.06 at x = 30 and 0 at x = -30, between them 0.03 low on the side x = -10, of two points each.

    Least squares: slope = sum x z / sum x^2. The plane that touches rests on the edges: slope 0.06 / 60.
    """
    top, bore = plane("top", (0, 0, 0), size=(60, 60)), cylinder("bore", (0, 0, -20), inside=True)
    x, z = np.array([-30.0, 30.0, -10.0]), np.array([0.0, 0.06, -0.03])
    points = np.array([[a, y, h] for a, h in zip(x, z) for y in (-30.0, 30.0)])
    measured = {"top": points, "bore": round_points(10.0, [-18, -2])}
    by_gauss = Characteristic("c", "perpendicularity", of=("bore",), datums=("top",), zone=0.1)
    slope = ((x - x.mean()) @ (z - z.mean())) / ((x - x.mean()) ** 2).sum()
    assert value(by_gauss, [top, bore], measured) == pytest.approx(20 * slope, rel=1e-4)
    touching = Characteristic(
        "c", "perpendicularity", of=("bore",), datums=("top",), datum_criterion="T", zone=0.1
    )
    assert value(touching, [top, bore], measured) == pytest.approx(20 * 0.001, rel=1e-4)


def test_the_size_that_pays_may_be_named_as_a_size() -> None:
    """docs/drawing.md: beside a material requirement GX and GN name the mating size; the letters X and N mean the same."""
    limits = {"material": "M", "size_limits": (10.0, 10.1), "datums": ("top",), "zone": 0.1}
    for word, letter in (("GX", "X"), ("GN", "N"), ("GG", "G"), ("X", "X")):
        c = Characteristic("c", "position", of=("bore",), criterion=word, **limits)  # type: ignore[arg-type]
        assert choose_criteria(c).of == (letter,)
    with pytest.raises(UsageError, match=r"is a criterion of sizes; position takes .* \(for GX: X\)"):
        choose_criteria(
            Characteristic("c", "position", of=("bore",), criterion="GX", datums=("top",), zone=0.1)
        )
