from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from vcmm.core.errors import DataError, UsageError
from vcmm.core.pose import Pose
from vcmm.part.mesh import closest
from vcmm.part.part import (
    Characteristic,
    Feature,
    Mesh,
    Part,
    centre,
    ends,
    feature_to_frame,
    frame,
    load_mesh,
    normal,
    signed_distance,
    surface_point,
)

Z = (0.0, 0.0, 1.0)


def make(
    kind: str, sizes: Any = (), extent: Any = (), axis: Any = Z, inside: bool = False, **more: Any
) -> Feature:
    return Feature("f", kind, np.array([1.0, 2.0, 3.0]), axis, sizes, inside, extent, **more)


ALL = [
    make("point"),
    make("plane", extent=(80, 40), axis=(0.1, 0.2, -1.0)),
    make("line", extent=(30,), axis=(0.1, 0.2, -1.0)),
    make("circle", (5.0,), axis=(0.3, 0.2, 1.0)),
    make("sphere", (5.0,), axis=(0, 0, 0)),
    make("sphere", (5.0,), axis=(0, 0, 0), inside=True),
    make("cylinder", (5.0,), (20,), axis=(0.3, -0.2, 1.0)),
    make("cylinder", (5.0,), (20,), axis=(0.3, -0.2, 1.0), inside=True),
    make("cone", (5.0, 0.3), (20,), axis=(0.3, -0.2, 1.0)),
    make("cone", (5.0, 0.3), (20,), axis=(0.3, -0.2, 1.0), inside=True),
    make("torus", (20.0, 4.0), axis=(0.3, -0.2, 1.0)),
    make("torus", (20.0, 4.0), axis=(0.3, -0.2, 1.0), inside=True),
]


def test_signed_distance_by_hand() -> None:
    p = np.array([1.0 + 3.0, 2.0 + 4.0, 3.0 + 2.0])  # 5 mm from the axis, 2 mm along it
    assert signed_distance(make("plane", extent=(1, 1)), p) == pytest.approx(2.0)
    assert signed_distance(make("point"), p) == pytest.approx(2.0)
    assert signed_distance(make("cylinder", (4.0,), (9,)), p) == pytest.approx(1.0)
    assert signed_distance(make("circle", (4.0,), inside=True), p) == pytest.approx(-1.0)
    # sphere: sqrt(9 + 16 + 4) - 5 = 0.385165
    assert signed_distance(make("sphere", (5.0,), axis=(0, 0, 0)), p) == pytest.approx(0.3851648, abs=1e-7)
    # cone, half angle 30 deg: (5 - 4) cos 30 - 2 sin 30 = 0.8660254 - 1
    assert signed_distance(make("cone", (4.0, math.pi / 6), (9,)), p) == pytest.approx(-0.1339746, abs=1e-7)
    # torus: sqrt((5 - 6)^2 + 2^2) - 2 = 0.236068
    assert signed_distance(make("torus", (6.0, 2.0)), p) == pytest.approx(0.2360680, abs=1e-7)
    # a line along z lies on a surface whose normal is u = x
    assert signed_distance(make("line", extent=(9,)), p) == pytest.approx(3.0)
    assert signed_distance(make("line", extent=(9,), u=np.array([0.0, -1.0, 0.0])), p) == pytest.approx(-4.0)


@pytest.mark.parametrize("feature", ALL, ids=lambda f: f.kind + " inside" * f.inside)
def test_normal_is_the_gradient_of_the_distance(feature: Feature) -> None:
    points = np.random.default_rng(1).normal(size=(20, 3)) * 3.0 + [1.0, 2.0, 3.0]
    step = 1e-6
    pairs = [(points + step * e, points - step * e) for e in np.eye(3)]
    gradient = [(signed_distance(feature, a) - signed_distance(feature, b)) / (2.0 * step) for a, b in pairs]
    np.testing.assert_allclose(normal(feature, points), np.stack(gradient, axis=-1), atol=1e-8)


@pytest.mark.parametrize("feature", ALL, ids=lambda f: f.kind + " inside" * f.inside)
def test_surface_points_lie_on_the_surface_and_move_with_it(feature: Feature) -> None:
    a, b = np.random.default_rng(2).uniform(-1.0, 1.0, (2, 30))
    points = surface_point(feature, a, b)
    assert np.abs(signed_distance(feature, points)).max() < 1e-14
    pose = Pose.from_turns((9.0, -5.0, 4.0), (0.4, -0.9, 2.0))
    there = feature_to_frame(feature, pose)
    assert np.abs(signed_distance(there, pose.apply(points))).max() < 1e-13
    if feature.kind != "sphere":  # a sphere has no frame of its own
        np.testing.assert_allclose(surface_point(there, a, b), pose.apply(points), atol=1e-13)


def test_normals_where_every_direction_fits_are_still_unit_vectors() -> None:
    for feature in ALL:
        assert np.linalg.norm(normal(feature, feature.point)) == pytest.approx(1.0)


def test_frame_and_centre() -> None:
    front = make("plane", extent=(80, 20), axis=(0, -1, 0))  # sizes run along x and z
    np.testing.assert_allclose(frame(front), [[1, 0, 0], [0, 0, 1], [0, -1, 0]])
    bore = make("cylinder", (15.0,), (20,), inside=True)
    np.testing.assert_allclose(centre(bore), [1, 2, 13])
    np.testing.assert_allclose(ends(bore), [[1, 2, 3], [1, 2, 23]])
    np.testing.assert_allclose(centre(front), [1, 2, 3])
    np.testing.assert_allclose(np.linalg.norm(make("line", extent=(3,), axis=(0, 0, 7)).axis), 1.0)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda: make("cilinder"), 'Did you mean "cylinder"'),
        (lambda: make("plane", extent=(1, 1), axis=(0, 0, 0)), "direction is zero"),
        (lambda: make("plane", extent=(80,)), "first size, second size"),
        (lambda: make("plane", extent=(80, -1)), "second size must be positive"),
        (lambda: make("cylinder", (-5.0,), (20,)), "radius must be positive"),
        (lambda: make("cylinder", (5.0,)), "length"),
        (lambda: make("cylinder", (float("nan"),), (20,)), "finite"),
        (lambda: make("cone", (5.0, 2.0), (20,)), "apex angle"),
        (lambda: make("cone", (5.0, -0.1), (20,)), "half apex angle must be positive"),
        (lambda: make("torus", (4.0, 5.0)), "smaller than the ring"),
        (lambda: make("plane", extent=(1, 1), u=np.array([0.0, 0.0, 3.0])), "parallel"),
        (
            lambda: Feature("f", "point", np.array([0.0, np.inf, 0.0]), np.array(Z), np.array([])),
            "point must be",
        ),
    ],
)
def test_impossible_features_are_refused(wrong: Any, words: str) -> None:
    with pytest.raises(DataError, match=words):
        wrong()


def test_a_cone_may_start_at_its_apex() -> None:
    assert make("cone", (0.0, 0.5), (20,)).sizes[0] == 0.0


def bore_part(*characteristics: Characteristic) -> Part:
    return Part({"f": make("cylinder", (5.0,), (20,))}, characteristics)


def test_a_part_reports_every_problem_at_once() -> None:
    a = Characteristic("a", "size", of=("g",))
    b = Characteristic("b", "distance", between=("f", "bor"))
    with pytest.raises(DataError) as caught:
        bore_part(a, b, b)
    assert len(caught.value.problems) == 4  # unknown g, unknown bor twice, b twice
    assert "Known features: f" in caught.value.problems[0]
    with pytest.raises(DataError, match='Did you mean "bore"'):
        Part(
            {"bore": Feature("bore", "point", np.zeros(3), np.array(Z), np.array([]))},
            (Characteristic("c", "size", ("bor",)),),
        )
    with pytest.raises(DataError, match="listed as"):
        Part({"g": make("point")})


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"type": "perpendicular", "of": "f"}, 'Did you mean "perpendicularity"'),
        ({"type": "size", "of": ("f", "g")}, 'size takes 1 feature.s. in "of", not 2'),
        ({"type": "distance", "of": ("f", "g")}, 'distance takes 2 feature.s. in "between", not 0'),
        ({"type": "perpendicularity", "of": "f"}, "datums"),
        ({"type": "position", "of": "f", "datums": "abcd"[:4].split() * 4}, "0 to 3"),
        ({"type": "size", "of": "f", "limits": (0.02, 0.0)}, "exchange"),
        ({"type": "flatness", "of": "f", "zone": -0.01}, "positive"),
        ({"type": "size", "of": "f", "zone": 0.01}, "limits for size"),
        ({"type": "flatness", "of": "f", "zone": 0.01, "limits": (0.0, 0.01)}, "never both"),
    ],
)
def test_impossible_characteristics_are_refused(fields: dict[str, Any], words: str) -> None:
    with pytest.raises(DataError, match=words):
        Characteristic("c", **fields)


def test_a_single_name_stands_for_itself() -> None:
    assert Characteristic("c", "size", of="bore").of == ("bore",)  # type: ignore[arg-type]


def tetrahedron() -> Mesh:
    return Mesh(
        np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]),
        np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]),
    )


def test_closest_point_of_a_mesh_on_face_edge_and_corner() -> None:
    points = np.array([[0.2, 0.2, -3.0], [0.5, -1.0, -1.0], [-2.0, -1.0, -2.0], [1.0, 1.0, 1.0]])
    distance, normals = closest(tetrahedron(), points)
    # below the face z = 0; beside the edge along x; off the corner at 0; off x + y + z = 1: (3 - 1) / sqrt 3
    np.testing.assert_allclose(distance, [3.0, math.sqrt(2.0), 3.0, 2.0 / math.sqrt(3.0)], rtol=1e-15)
    np.testing.assert_allclose(normals[0], [0, 0, -1])
    np.testing.assert_allclose(normals[3], np.ones(3) / math.sqrt(3.0))


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".obj"])
def test_meshes_are_read_in_mm(tmp_path: Path, suffix: str) -> None:
    trimesh = pytest.importorskip("trimesh")
    path = tmp_path / f"box{suffix}"
    trimesh.creation.box(extents=(10.0, 20.0, 30.0)).export(path)
    mesh = load_mesh(path)
    assert len(mesh.faces) == 12
    np.testing.assert_allclose(np.ptp(mesh.vertices, axis=0), [10.0, 20.0, 30.0])


def test_bad_meshes_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"part\.stl does not exist"):
        load_mesh(tmp_path / "part.stl")
    with pytest.raises(DataError, match="read from"):
        load_mesh(tmp_path / "part.step")
    (tmp_path / "empty.stl").write_text("solid empty\nendsolid empty\n")
    with pytest.raises(DataError, match=r"empty\.stl"):
        load_mesh(tmp_path / "empty.stl")
    with pytest.raises(DataError, match="Vertex 1"):
        Mesh(np.array([[0, 0, 0], [np.nan, 0, 0], [0, 1, 0.0]]), np.array([[0, 1, 2]]))
    with pytest.raises(DataError, match=r"outside 0\.\.2"):
        Mesh(np.eye(3), np.array([[0, 1, 3]]))


def test_a_mesh_feature_needs_a_mesh() -> None:
    free = Feature("free", "mesh", np.zeros(3), np.zeros(3), np.array([]))
    with pytest.raises(DataError, match="mesh"):
        Part({"free": free})
    assert Part({"free": free}, mesh=tetrahedron()).mesh is not None
    for call in (signed_distance, normal):
        with pytest.raises(UsageError, match="closest"):
            call(free, np.zeros(3))
    with pytest.raises(UsageError, match="points instead"):
        surface_point(free, 0.0)
