from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.pose import Array
from vcmm.part.mesh import Mesh, closest, sweep
from vcmm.part.part import Feature, signed_distance
from vcmm.task.measuring.contact import touch
from vcmm.task.measuring.strategies import Around, Grid, Helix, Ring, Spiral, plan_points

Z = np.array([0.0, 0.0, 1.0])
TOP = Feature("top", "plane", np.array([0.0, 0.0, 20.0]), Z, np.array([]), False, (80.0, 80.0))


def shaft(inside: bool = False) -> Feature:
    return Feature("shaft", "cylinder", np.zeros(3), Z, np.array([10.0]), inside, (30.0,))


def departure(
    feature: Feature, point: Any, outward: Any, direction: Any, error: Any, tip_radius: float
) -> Array:
    """Corrected point minus true nominal point, for a touch that starts 3 mm before contact."""
    point, outward, direction = (np.asarray(a, dtype=np.float64)[None] for a in (point, outward, direction))
    start = point + tip_radius * outward - 3.0 * direction
    travel = touch(feature, start, direction, tip_radius, np.asarray(error, dtype=np.float64)[None])
    corrected = start + travel[:, None] * direction - tip_radius * outward
    return np.asarray(corrected[0] - point[0])


def test_without_error_the_tip_touches_the_nominal_point() -> None:
    out = departure(TOP, (5, 6, 20), Z, -Z, (0, 0, 0), 2.0)
    assert np.abs(out).max() < 1e-14


def test_on_a_plane_along_the_normal_the_reading_is_minus_the_tip_error_exactly() -> None:
    out = departure(TOP, (5, 6, 20), Z, -Z, (0.3, -0.2, 0.05), 2.0)
    np.testing.assert_allclose(out, [0.0, 0.0, -0.05], atol=1e-14)


def test_an_oblique_approach_divides_by_its_share_along_the_normal() -> None:
    # approach at 60 deg to the normal: direction . n = -0.5. Along the direction -(e . n) / (d . n) = 0.05 / 0.5
    # = 0.1 mm, that is sin 60 * 0.1 = 0.0866025 sideways and -0.05 in height
    direction = np.array([math.sin(math.pi / 3), 0.0, -0.5])
    out = departure(TOP, (5, 6, 20), Z, direction, (0.3, -0.2, 0.05), 2.0)
    np.testing.assert_allclose(out, [0.0866025, 0.0, -0.05], atol=1e-7)


def test_a_shaft_reads_smaller_by_the_curvature_term() -> None:
    # exact: sqrt((R + r)^2 - e_t^2) - (R + r) - e_n = sqrt(144 - 0.09) - 12 - 0.05 = -0.00375059 - 0.05
    # first curvature term: -e_t^2 / (2 (R + r)) = -0.09 / 24 = -0.00375
    out = departure(shaft(), (10, 0, 5), (1, 0, 0), (-1, 0, 0), (0.05, 0.3, 0.7), 2.0)
    np.testing.assert_allclose(out, [-0.05 - 0.00375059, 0.0, 0.0], atol=1e-8)


def test_a_bore_reads_smaller_too() -> None:
    # at x = 10 the outward normal is -x, the tip moves along +x, e_n = -0.05. Centre: sqrt(64 - 0.09) - 8 - 0.05
    # = -0.00562698 - 0.05 along x; along n that is -e_n + e_t^2 / (2 (R - r)) = 0.05 + 0.005625
    out = departure(shaft(inside=True), (10, 0, 5), (-1, 0, 0), (1, 0, 0), (0.05, 0.3, 0.7), 2.0)
    np.testing.assert_allclose(out, [-0.05 - 0.00562698, 0.0, 0.0], atol=1e-8)


def test_a_ball_counts_both_sideways_components() -> None:
    # e_t^2 = 0.09 + 0.16 = 0.25 ; sqrt(144 - 0.25) - 12 = -0.01042119
    ball = Feature("ball", "sphere", np.zeros(3), np.zeros(3), np.array([10.0]))
    out = departure(ball, (0, 0, 10), Z, -Z, (0.3, 0.4, 0.0), 2.0)
    np.testing.assert_allclose(out, [0.0, 0.0, -0.01042119], atol=1e-8)


def test_a_cone_is_touched_where_its_slope_says() -> None:
    # half angle 30 deg, along the axis-square direction -x: the tip error along z by 0.1 meets a surface that is
    # 0.1 tan 30 = 0.0577350 mm further out
    cone = Feature("cone", "cone", np.zeros(3), Z, np.array([5.0, math.pi / 6]), False, (20.0,))
    outward = np.array([math.cos(math.pi / 6), 0.0, -0.5])
    out = departure(cone, (5, 0, 0), outward, (-1, 0, 0), (0, 0, 0.1), 1.0)
    np.testing.assert_allclose(out, [0.0577350, 0.0, 0.0], atol=1e-7)


CURVED = [
    (shaft(), Helix(40, 2.3, 1.0), 6.0),
    (shaft(inside=True), Helix(40, 2.3, 1.0), 2.0),
    (Feature("ring", "circle", np.ones(3), Z, np.array([6.0]), True), Around(9), 2.0),
    (Feature("ball", "sphere", np.ones(3), np.zeros(3), np.array([9.0])), Spiral(40), 6.0),
    (Feature("socket", "sphere", np.ones(3), np.zeros(3), np.array([9.0]), True), Spiral(40), 2.0),
    (Feature("cone", "cone", np.ones(3), Z, np.array([8.0, 0.4]), False, (20.0,)), Helix(40, 2.3, 1.0), 6.0),
    (Feature("seat", "cone", np.ones(3), Z, np.array([8.0, 0.4]), True, (20.0,)), Helix(40, 2.3, 1.0), 2.0),
    (Feature("tyre", "torus", np.ones(3), Z, np.array([20.0, 4.0])), Ring((6, 7), tube_start=0.1), 6.0),
    (Feature("pipe", "torus", np.ones(3), Z, np.array([20.0, 4.0]), True), Ring((6, 7), tube_start=0.1), 2.0),
    (TOP, Grid((4, 4)), 6.0),
]


@pytest.mark.parametrize(("feature", "pattern", "back"), CURVED, ids=lambda v: getattr(v, "name", ""))
def test_oblique_touches_end_at_the_first_contact_to_rounding(
    feature: Feature, pattern: Any, back: float
) -> None:
    rng = np.random.default_rng(3)
    points, normals = plan_points(feature, pattern)
    direction = -normals + 0.2 * rng.normal(size=normals.shape)
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    start = points + normals - back * direction
    error = 0.05 * rng.normal(size=(50, *points.shape))
    travel = touch(feature, start, direction, 1.0, error)
    assert travel.shape == (50, len(points))

    def gap(share: float) -> Array:
        return signed_distance(feature, start + error + (share * travel)[..., None] * direction) - 1.0

    assert np.abs(gap(1.0)).max() < 2e-14
    assert min(gap(share).min() for share in np.linspace(0.0, 0.999, 50)) > 0.0


def test_a_batch_equals_its_members() -> None:
    start, direction = np.array([[13.0, 0.5, 2.0], [0.0, 14.0, 3.0]]), np.array([[-1.0, 0, 0], [0, -1.0, 0]])
    error = np.random.default_rng(4).normal(size=(3, 5, 2, 3)) * 0.01
    batch = touch(shaft(), start, direction, 1.5, error)
    assert batch.shape == (3, 5, 2)
    np.testing.assert_array_equal(batch[2, 4], touch(shaft(), start, direction, 1.5, error[2, 4]))
    assert touch(shaft(), start, direction, 1.5).shape == (2,)


def ball_mesh(radius: float) -> Mesh:
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    return Mesh(ball.vertices, ball.faces)


def test_a_fine_mesh_of_a_ball_agrees_within_the_sagitta_of_its_facets() -> None:
    mesh = ball_mesh(10.0)
    centres = mesh.triangles().mean(axis=1)
    sagitta = 10.0 - np.linalg.norm(centres, axis=1).min()  # facets lie inside the ball
    assert 0.001 < sagitta < 0.02
    ball = Feature("ball", "sphere", np.zeros(3), np.zeros(3), np.array([10.0]))
    points, normals = plan_points(ball, Spiral(30, math.pi))
    error = 0.02 * np.random.default_rng(5).normal(size=(4, 30, 3))
    start = points + 5.0 * normals
    later = touch(mesh, start, -normals, 1.0, error) - touch(ball, start, -normals, 1.0, error)
    assert later.min() > -1e-13
    assert 0.3 * sagitta < later.max() < 1.001 * sagitta


def box() -> Mesh:
    """A cube of 2 mm about the origin."""
    trimesh = pytest.importorskip("trimesh")
    cube = trimesh.creation.box(extents=(2.0, 2.0, 2.0))
    return Mesh(cube.vertices, cube.faces)


def test_a_mesh_is_touched_on_face_edge_and_corner() -> None:
    # tip radius 1, from z = 5 downwards. Face: centre at z = 2, travel 3.
    # Edge x = 1, 0.6 mm beside it: centre sqrt(1 - 0.36) = 0.8 above the edge: travel 5 - 1.8 = 3.2.
    # Corner, 0.6 mm beside it in x and in y: sqrt(1 - 0.72) = 0.5291503: travel 5 - 1.5291503.
    start = np.array([[0.3, -0.2, 5.0], [1.6, 0.0, 5.0], [1.6, 1.6, 5.0]])
    travel = touch(box(), start, -Z, 1.0)
    np.testing.assert_allclose(travel, [3.0, 3.2, 3.4708497], atol=1e-7)


def test_mesh_contact_does_not_depend_on_a_displacement_along_the_approach_twice() -> None:
    # 0.1 mm too high: the machine goes 0.1 mm further; 0.1 mm sideways on a face: nothing
    error = np.array([[[0.0, 0.0, 0.1]], [[0.1, 0.0, 0.0]]])
    np.testing.assert_allclose(
        touch(box(), np.array([[0.3, -0.2, 5.0]]), -Z, 1.0, error), [[3.1], [3.0]], atol=1e-14
    )


def test_no_contact_names_the_point() -> None:
    start = np.array([[13.0, 0.0, 2.0], [13.0, 12.5, 2.0]])
    with pytest.raises(ModelLimit, match=r'Point 2 does not meet "shaft" within 100 mm'):
        touch(shaft(), start, (-1.0, 0.0, 0.0), 1.0)
    with pytest.raises(ModelLimit, match=r"Point 1 does not meet .* within 1 mm"):
        touch(shaft(), start[:1], (-1.0, 0.0, 0.0), 1.0, search=1.0)
    with pytest.raises(ModelLimit, match=r"Point 2 does not meet the mesh"):
        touch(box(), np.array([[0.0, 0.0, 5.0], [5.0, 0.0, 5.0]]), -Z, 1.0)
    error = np.zeros((2, 1, 3))
    error[1, 0, 1] = 20.0
    with pytest.raises(ModelLimit, match=r"Point 1 of trial \(1,\)"):
        touch(shaft(), start[:1], (-1.0, 0.0, 0.0), 1.0, error)


@pytest.mark.parametrize(
    ("feature", "direction"),
    [(TOP, Z), (TOP, np.array([1.0, 0.0, 0.0])), (shaft(), Z), (shaft(), np.array([1.0, 0, 0]))],
)
def test_moving_away_or_along_is_no_contact(feature: Feature, direction: Array) -> None:
    with pytest.raises(ModelLimit, match="does not meet"):
        touch(feature, np.array([[13.0, 0.0, 30.0]]), direction, 1.0)


def test_starting_in_the_material_or_a_tip_too_large_is_refused() -> None:
    with pytest.raises(ModelLimit, match="starts in contact"):
        touch(TOP, np.array([[0.0, 0.0, 20.5]]), -Z, 1.0)
    with pytest.raises(ModelLimit, match="starts in contact"):
        touch(box(), np.array([[0.0, 0.0, 1.5]]), -Z, 1.0)
    with pytest.raises(ModelLimit, match="does not fit"):
        touch(shaft(inside=True), np.zeros((1, 3)), (1.0, 0.0, 0.0), 10.0)


def test_bad_calls_are_refused() -> None:
    start = np.array([[0.0, 0.0, 25.0]])
    with pytest.raises(UsageError, match="unit vectors"):
        touch(TOP, start, (0.0, 0.0, -2.0), 1.0)
    with pytest.raises(UsageError, match="does not fit 1 points"):
        touch(TOP, start, -Z, 1.0, np.zeros((2, 2, 2)))
    with pytest.raises(UsageError, match="tip radius above zero"):
        touch(box(), start, -Z, 0.0)
    with pytest.raises(UsageError, match="finite"):
        touch(TOP, start * np.nan, -Z, 1.0)


def test_mesh_contact_against_the_distance_to_the_mesh() -> None:
    # 100 random triangles, 200 balls: at contact the distance to the soup is the radius, before it is larger
    rng = np.random.default_rng(6)
    soup = Mesh(rng.uniform(-5.0, 5.0, (300, 3)), np.arange(300).reshape(100, 3))
    start = rng.uniform(-4.0, 4.0, (200, 3))
    start[:, 2] = 14.0
    direction = np.array([0.1, -0.2, -1.0]) / math.sqrt(1.05)
    travel = sweep(soup, start[:, None], direction[None], 0.7, 60.0)[:, 0]
    hit = np.isfinite(travel)
    assert 100 < hit.sum() < 200
    at_contact = start[hit] + travel[hit, None] * direction
    np.testing.assert_allclose(closest(soup, at_contact)[0], 0.7, atol=1e-13)
    for share in np.linspace(0.1, 0.99, 30):
        assert closest(soup, start[hit] + share * travel[hit, None] * direction)[0].min() > 0.7
    for way in np.linspace(5.0, 25.0, 40):
        assert closest(soup, start[~hit] + way * direction)[0].min() > 0.7


def test_a_bore_that_opens_at_45_deg_is_met_along_its_own_generator() -> None:
    # inside the cone x = 10 + z; the centre of a tip of 1 mm runs on x = 10 - sqrt(2) + z. From the axis towards (1, 0, -1) it
    # goes against the generator: the quadratic has no square term. x = t / sqrt(2) = 10 - sqrt(2) - t / sqrt(2): t = 5 sqrt(2) - 1
    bore = Feature("bore", "cone", np.zeros(3), Z, np.array([10.0, math.pi / 4]), True, (12.0,))
    way = np.array([[1.0, 0.0, -1.0]]) / math.sqrt(2.0)
    assert touch(bore, np.zeros((1, 3)), way, 1.0, np.zeros((1, 3))) == pytest.approx(
        5.0 * math.sqrt(2.0) - 1.0, abs=1e-12
    )
