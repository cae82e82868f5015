from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array, Pose
from vcmm.part.alignment import Alignment, align, datum_system
from vcmm.part.fit.elements import FittedElement
from vcmm.part.part import Feature, feature_to_frame

NONE = np.array([])


def feature(
    name: str, kind: str, point: Any, axis: Any, sizes: Any, inside: bool = False, extent: Any = ()
) -> Feature:
    return Feature(name, kind, point, axis, sizes, inside, extent)


def plane(name: str, point: Any, normal: Any) -> Feature:
    return feature(name, "plane", point, normal, NONE, False, (80.0, 20.0))


def cylinder(name: str, point: Any, axis: Any) -> Feature:
    return feature(name, "cylinder", point, axis, np.array([15.0]), True, (20.0,))


FEATURES = {
    f.name: f
    for f in (
        plane("top", (0, 0, 20), (0, 0, 1)),
        plane("front", (0, -40, 10), (0, -1, 0)),
        plane("side", (-40, 0, 10), (-1, 0, 0)),
        cylinder("bore", (0, 0, 0), (0, 0, 1)),
        cylinder("hole", (30, 10, 0), (0, 0, 1)),
        cylinder("cross", (0, 0, 5), (1, 0, 0)),
        feature("ball", "sphere", (10, 20, 30), np.zeros(3), np.array([5.0])),
        feature("ball 2", "sphere", (-10, 20, 30), np.zeros(3), np.array([5.0])),
        feature("ball 3", "sphere", (10, -20, 35), np.zeros(3), np.array([5.0])),
        feature("rim", "circle", (0, 0, 20), (0, 0, 1), np.array([15.0]), True),
    )
}
MACHINE_FROM_PART = Pose.from_turns((300.0, 250.0, -200.0), (0.02, -0.01, math.pi / 2))


def fitted(feature: Feature, point: Any = None, axis: Any = None) -> FittedElement:
    point = np.asarray(feature.point if point is None else point, dtype=float)
    axis = np.asarray(feature.axis if axis is None else axis, dtype=float)
    axis = axis / np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-300)
    return FittedElement(feature.kind, point, axis, feature.sizes, np.zeros(1), np.zeros((1, 3)))


def measured(pose: Pose = MACHINE_FROM_PART, slide: float = 0.0) -> dict[str, FittedElement]:
    """Everything as drawn, seen from the machine; the point of an axis or plane may lie anywhere on it."""
    out = {}
    for name, feature in FEATURES.items():
        there = feature_to_frame(feature, pose)
        along = there.axis if feature.kind == "cylinder" else np.cross(there.axis, [0.1, 0.2, 0.3])
        out[name] = fitted(there, there.point + slide * along * (feature.kind in ("plane", "cylinder")))
    return out


def assert_same(pose: Pose, expected: Pose, atol: float = 1e-11) -> None:
    np.testing.assert_allclose(
        pose.rotation, np.broadcast_to(expected.rotation, pose.rotation.shape), atol=atol
    )
    np.testing.assert_allclose(pose.shift, np.broadcast_to(expected.shift, pose.shift.shape), atol=atol)


SCHEMES = [
    Alignment("top", "front", "bore"),
    Alignment("top", "front", "ball"),
    Alignment("top", "front", "rim"),
    Alignment("top", "cross", ("front", "side")),
    Alignment("top", ("bore", "hole"), "bore"),
    Alignment("top", ("ball", "ball 2"), "hole"),
    Alignment("front", "side", ("top", "side")),
    Alignment("bore", ("bore", "hole"), ("top",)),
    Alignment("top", "front", ("side",)),  # the line gives what the origin leaves
]


@pytest.mark.parametrize("scheme", SCHEMES, ids=str)
def test_a_part_as_drawn_is_found_where_it_lies(scheme: Alignment) -> None:
    assert_same(align(scheme, FEATURES, measured(slide=7.0)), MACHINE_FROM_PART.inverse())


@pytest.mark.parametrize(
    "datums",
    [("top", "front", "side"), ("top", "bore", "hole"), ("top", "bore", "front"), ("bore", "top", "front"),
     ("cross", "top", "side"), ("top", "ball", "ball 2")],
)  # fmt: skip
def test_datum_systems_find_it_too(datums: tuple[str, ...]) -> None:
    assert_same(datum_system(datums, FEATURES, measured(slide=7.0)), MACHINE_FROM_PART.inverse())


def test_a_batch_of_trials_gets_a_pose_each() -> None:
    shifts, turns = (
        np.array([[1.0, 2, 3], [-4, 5, 6], [0, 0, 0]]),
        np.array([[0.1, 0, 0], [0, 0.2, 0.3], [0, 0, 0]]),
    )
    each = [measured(Pose.from_turns(s, t)) for s, t in zip(shifts, turns)]
    batch = {
        name: replace(
            each[0][name],
            point=np.stack([e[name].point for e in each]),
            axis=np.stack([e[name].axis for e in each]),
        )
        for name in FEATURES
    }
    pose = align(Alignment("top", "front", "bore"), FEATURES, batch)
    assert pose.rotation.shape == (3, 3, 3)
    assert_same(pose, Pose.from_turns(shifts, turns).inverse())


def drawing() -> dict[str, FittedElement]:
    return measured(Pose.identity())


def shift_of(scheme: Alignment, **changed: FittedElement) -> Pose:
    return align(scheme, FEATURES, {**drawing(), **changed})


CONTRACT = Alignment("top", "front", "bore")


def test_a_bore_that_leans_is_located_where_it_pierces_the_top() -> None:
    # axis through (0, 0, 0) leaning by 0.01 in x: at z = 20 it is at x = 0.2, so the part is shifted by -0.2
    pose = shift_of(CONTRACT, bore=fitted(FEATURES["bore"], axis=(0.01, 0.0, 1.0)))
    np.testing.assert_allclose(pose.rotation, np.eye(3), atol=1e-15)
    np.testing.assert_allclose(pose.shift, [-0.2, 0.0, 0.0], atol=1e-12)


def test_a_high_top_shifts_in_height_and_a_turned_front_turns_about_the_normal() -> None:
    top = fitted(FEATURES["top"], point=(3.0, 4.0, 20.5))
    front = fitted(
        FEATURES["front"], axis=(math.sin(0.001), -math.cos(0.001), 0.0)
    )  # turned by +0.001 about z
    pose = shift_of(CONTRACT, top=top, front=front)
    np.testing.assert_allclose(pose.turns(), [0.0, 0.0, -0.001], atol=1e-15)
    np.testing.assert_allclose(pose.shift, [0.0, 0.0, -0.5], atol=1e-12)


def test_the_tilt_of_the_front_out_of_the_plane_does_not_count() -> None:
    front = fitted(FEATURES["front"], axis=(0.0, -1.0, 0.05))
    np.testing.assert_allclose(shift_of(CONTRACT, front=front).turns(), 0.0, atol=1e-15)


def test_the_plane_holds_the_height_even_when_the_origin_is_a_ball() -> None:
    ball = fitted(FEATURES["ball"], point=(10.1, 20.2, 30.3))
    pose = shift_of(Alignment("top", "front", "ball"), ball=ball)
    np.testing.assert_allclose(pose.shift, [-0.1, -0.2, 0.0], atol=1e-12)


def test_what_is_left_free_follows_the_rough_pose_or_is_refused() -> None:
    rough = MACHINE_FROM_PART.inverse()
    assert_same(align(Alignment("top"), FEATURES, measured(), rough), rough)
    assert_same(datum_system(("bore",), FEATURES, measured(), rough), rough)
    with pytest.raises(UsageError, match='turn about the direction of "top" free'):
        align(Alignment("top", (), "bore"), FEATURES, measured())
    with pytest.raises(UsageError, match=r"shift along \[.*1\.0, .*0\.0, .*0\.0\] free"):
        align(Alignment("top", "front"), FEATURES, measured())


def test_directions_against_the_rough_pose_are_turned_over() -> None:
    found = measured()
    found = {name: replace(f, axis=-f.axis) for name, f in found.items()}
    assert_same(align(CONTRACT, FEATURES, found, MACHINE_FROM_PART.inverse()), MACHINE_FROM_PART.inverse())


def test_names_and_directions_are_checked() -> None:
    with pytest.raises(UsageError, match='Did you mean "front"'):
        align(Alignment("top", "fron", "bore"), FEATURES, drawing())
    with pytest.raises(UsageError, match="not measured"):
        align(CONTRACT, FEATURES, {"top": drawing()["top"]})
    with pytest.raises(UsageError, match='"bore" is parallel to "top"'):
        align(Alignment("top", "bore", "hole"), FEATURES, drawing())
    with pytest.raises(UsageError, match="has no direction"):
        align(Alignment("ball", "front", "bore"), FEATURES, drawing())
    with pytest.raises(UsageError, match="not 3"):
        align(Alignment("top", ("front", "side", "cross"), "bore"), FEATURES, drawing())


def corners() -> Array:
    return np.array([[0.0, 0, 0], [60, 0, 0], [0, 30, 0], [0, 0, 20]])
