from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.pose import Pose
from vcmm.part.fit.elements import FittedElement
from vcmm.part.gps.characteristics import (
    evaluate,
    is_linear,
    is_one_sided,
    needs,
    nominal,
    tolerance,
    unit,
)
from vcmm.part.part import Characteristic, Feature

NONE = np.array([])


def feature(
    name: str, kind: str, point: Any, axis: Any, sizes: Any, inside: bool = False, extent: Any = ()
) -> Feature:
    return Feature(name, kind, point, axis, sizes, inside, extent)


def plane(name: str, point: Any, normal: Any, size: tuple[float, float] = (80.0, 40.0)) -> Feature:
    return feature(name, "plane", point, normal, NONE, False, size)


def cylinder(name: str, point: Any, axis: Any, length: float = 20.0) -> Feature:
    return feature(name, "cylinder", point, axis, np.array([15.0]), True, (length,))


FEATURES = {
    f.name: f
    for f in (
        plane("top", (0, 0, 20), (0, 0, 1)),
        plane("bottom", (0, 0, 0), (0, 0, -1)),
        plane("front", (0, -40, 10), (0, -1, 0), (80.0, 20.0)),
        plane("left", (-5, 0, 10), (1, 0, 0), (30.0, 10.0)),  # the two walls of a slot 10 mm wide
        plane("right", (5, 0, 10), (-1, 0, 0), (30.0, 10.0)),
        plane("mid", (0, 0, 0), (1, 0, 0)),
        plane("roof", (0, 0, 50), (0, math.sin(math.radians(30)), math.cos(math.radians(30)))),
        cylinder("bore", (0, 0, 0), (0, 0, 1)),
        cylinder("hole", (30, 40, 0), (0, 0, 1), 10.0),
        cylinder("cross", (0, 0, 10), (1, 0, 0), 60.0),
        feature("cone", "cone", (0, 0, 0), (0, 0, 1), np.array([5.0, 0.3]), False, (10.0,)),
        feature("ball", "sphere", (3, 4, 32), np.zeros(3), np.array([5.0])),
        feature("ball 2", "sphere", (3, 16, 37), np.zeros(3), np.array([5.0])),
        feature("rim", "circle", (0, 0, 20), (0, 0, 1), np.array([15.0]), True),
        feature("tyre", "torus", (0, 0, 0), (0, 0, 1), np.array([20.0, 4.0])),
        feature("edge", "line", (0, 0, 0), (1, 0, 0), NONE, False, (50.0,)),
        feature("tip", "point", (1, 2, 3), (0, 0, 1), NONE),
        feature("free", "mesh", np.zeros(3), np.zeros(3), NONE),
    )
}


def fit(
    name: str, point: Any = None, axis: Any = None, sizes: Any = None, residuals: Any = (0.0,)
) -> FittedElement:
    f = FEATURES[name]
    point = np.asarray(f.point if point is None else point, dtype=float)
    axis = np.asarray(f.axis if axis is None else axis, dtype=float)
    axis = axis / np.maximum(np.linalg.norm(axis, axis=-1, keepdims=True), 1e-300)
    sizes = np.asarray(f.sizes if sizes is None else sizes, dtype=float)
    residuals = np.asarray(residuals, dtype=float)
    return FittedElement(
        f.kind, point, axis, sizes, residuals, np.broadcast_to([0.0, 1.0, 0.0], (*residuals.shape, 3))
    )


def value(type_: str, *fits: tuple[str, FittedElement], pose: Pose | None = None, **fields: Any) -> Any:
    fitted = {name: fit(name) for name in FEATURES} | dict(fits)
    return evaluate(Characteristic("c", type_, **fields), FEATURES, fitted, pose)


def test_size_is_a_diameter() -> None:
    assert value("size", ("bore", fit("bore", sizes=[15.01])), of="bore") == pytest.approx(30.02)
    assert value("size", ("ball", fit("ball", sizes=[5.001])), of="ball") == pytest.approx(10.002)
    assert value("size", of="rim") == pytest.approx(30.0)
    assert value("size", ("tyre", fit("tyre", sizes=[20.0, 4.1])), of="tyre") == pytest.approx(8.2)
    with pytest.raises(UsageError, match="angle"):
        value("size", of="cone")
    with pytest.raises(UsageError, match="a plane has no size"):
        value("size", of="top")


def test_distances() -> None:
    # balls: (0, 12, 5) apart = 13
    assert value("distance", between=("ball", "ball 2")) == pytest.approx(13.0)
    # ball above top: 32 - 20
    assert value("distance", between=("top", "ball")) == pytest.approx(12.0)
    # parallel bores: hypot(30, 40)
    assert value("distance", between=("bore", "hole")) == pytest.approx(50.0)
    # ball to the axis of the bore: hypot(3, 4)
    assert value("distance", between=("bore", "ball")) == pytest.approx(5.0)
    # faces; the second one 0.02 low
    assert value(
        "distance", ("bottom", fit("bottom", point=(7, 8, -0.02))), between=("top", "bottom")
    ) == pytest.approx(20.02)


def test_a_distance_from_a_plane_has_a_sign() -> None:
    # the rim lies in the plane top: 20 um below it is -0.02, above it +0.02
    for z in (19.98, 20.02):
        rim = ("rim", fit("rim", point=(0, 0, z)))
        assert value("distance", rim, between=("top", "rim")) == pytest.approx(z - 20.0)
    assert is_linear(Characteristic("step", "distance", between=("top", "rim")), FEATURES)
    # top and bottom are 20 mm apart on the side to which no normal points; passed by, it is negative, not mirrored
    low = ("bottom", fit("bottom", point=(0, 0, 20.01)))
    assert value("distance", low, between=("top", "bottom")) == pytest.approx(-0.01)


def test_the_centre_of_a_plane_or_axis_is_at_its_nominal_centre() -> None:
    # top leans by 1 mrad in x and was probed around x = 30: at its nominal centre x = 0 it is 30e-3 mm lower
    top = fit("top", point=(30, 0, 20.0), axis=(-1e-3, 0, 1))
    assert value("distance", ("top", top), between=("bottom", "top")) == pytest.approx(19.97, abs=1e-5)
    # a hole that leans by 1 mrad through (30, 40, 0): at its middle, z = 5, its axis is at x = 30.005
    hole = fit("hole", axis=(1e-3, 0, 1))
    # hypot(30.005, 40) = 50 + 0.005 * 30/50
    assert value("distance", ("hole", hole), between=("bore", "hole")) == pytest.approx(50.003, abs=1e-6)


def test_a_distance_whose_order_hides_the_meaning_is_refused_with_the_fix() -> None:
    with pytest.raises(UsageError, match=r'between = \["top", "ball"\]'):
        value("distance", between=("ball", "top"))


def test_angles() -> None:
    assert value("angle", between=("top", "roof")) == pytest.approx(math.radians(30.0))
    assert value("angle", between=("bottom", "roof")) == pytest.approx(
        math.radians(30.0)
    )  # -z and the roof: acute
    assert value("angle", between=("bore", "cross")) == pytest.approx(math.pi / 2)
    # an axis and a plane: between the axis and the surface
    assert value("angle", between=("bore", "top")) == pytest.approx(math.pi / 2)
    assert value("angle", between=("top", "cross")) == pytest.approx(0.0)
    assert value("angle", between=("bore", "roof")) == pytest.approx(math.radians(60.0))


def test_a_right_angle_is_not_folded() -> None:
    for lean in (
        1e-4,
        -1e-4,
    ):  # front leans about x; its normal (0, -1, lean) towards the top is at acos(lean)
        front = fit("front", axis=(0, -1, lean))
        assert value("angle", ("front", front), between=("top", "front")) == pytest.approx(
            math.pi / 2 - lean, abs=1e-9
        )


def test_an_axis_that_a_fit_turned_round_gives_the_same_values() -> None:
    back = ("bore", fit("bore", axis=(0, 0, -1)))
    assert value("angle", back, between=("bore", "roof")) == pytest.approx(math.radians(60.0))
    assert value("perpendicularity", back, of="bore", datums="top") == pytest.approx(0.0)


@pytest.mark.parametrize(
    ("type_", "name"),
    [("flatness", "top"), ("roundness", "rim"), ("roundness", "ball"), ("cylindricity", "bore")],
)
def test_form_is_the_range_of_the_residuals(type_: str, name: str) -> None:
    residuals = [[0.001, -0.004, 0.002], [0.0, 0.0, 0.003]]
    np.testing.assert_allclose(value(type_, (name, fit(name, residuals=residuals)), of=name), [0.006, 0.003])


def test_straightness_counts_along_the_surface_normal_of_the_line() -> None:
    # distances from a line are never negative; their direction says on which side of the line the point is.
    # the surface normal of a line along x is u = y: +0.003, -0.002, and 0.009 square to it does not count
    line = fit("edge", residuals=[0.003, 0.002, 0.009])
    line = FittedElement(
        "line", line.point, line.axis, NONE, line.residuals, np.array([[0, 1.0, 0], [0, -1, 0], [0, 0, 1]])
    )
    assert value("straightness", ("edge", line), of="edge") == pytest.approx(0.005)


def test_form_of_the_wrong_feature_and_other_criteria_are_refused() -> None:
    with pytest.raises(UsageError, match="roundness is for a circle or a sphere, not for a plane"):
        value("roundness", of="top")
    with pytest.raises(UsageError, match='criterion "N" of "bore" needs its measured points'):
        value("size", of="bore", criterion="GN")


def test_perpendicularity_of_an_axis_to_a_plane_is_a_cylindrical_zone() -> None:
    # the bore leans by (0.3, 0.4) mrad: its ends are 20 mm * 0.5e-3 = 0.01 mm apart in projection
    bore = fit("bore", axis=(3e-4, 4e-4, 1))
    assert value("perpendicularity", ("bore", bore), of="bore", datums="top") == pytest.approx(0.01, rel=1e-6)
    # a datum that leans alike takes it away
    top = fit("top", axis=(3e-4, 4e-4, 1))
    assert value("perpendicularity", ("bore", bore), ("top", top), of="bore", datums="top") == pytest.approx(
        0.0, abs=1e-13
    )


def test_perpendicularity_of_planes_counts_only_the_angle_between_them() -> None:
    # front is 80 along x and 20 along z. Leaning by 1 mrad out of the vertical: 20e-3; turned about z: nothing
    lean, turn = fit("front", axis=(0, -1, 1e-3)), fit("front", axis=(1e-3, -1, 0))
    assert value("perpendicularity", ("front", lean), of="front", datums="top") == pytest.approx(
        0.02, rel=1e-6
    )
    assert value("perpendicularity", ("front", turn), of="front", datums="top") == pytest.approx(
        0.0, abs=1e-13
    )


def test_parallelism_of_planes_is_the_height_range_of_the_rectangle() -> None:
    # slopes 1 mrad along 80 mm and 2 mrad along 40 mm: 0.08 + 0.08
    top = fit("top", axis=(-1e-3, 2e-3, 1))
    assert value("parallelism", ("top", top), of="top", datums="bottom") == pytest.approx(0.16, rel=1e-5)


def test_parallelism_of_axes_and_of_an_axis_to_a_plane() -> None:
    # hole, 10 mm long, leans by 0.5 mrad against the bore: 5 um
    hole = ("hole", fit("hole", axis=(3e-4, 4e-4, 1)))
    assert value("parallelism", hole, of="hole", datums="bore") == pytest.approx(0.005, rel=1e-6)
    # cross, 60 mm long along x: climbing by 1 mrad against the top 0.06, turning in the plane nothing
    climb, turn = fit("cross", axis=(1, 0, 1e-3)), fit("cross", axis=(1, 1e-3, 0))
    assert value("parallelism", ("cross", climb), of="cross", datums="top") == pytest.approx(0.06, rel=1e-6)
    assert value("parallelism", ("cross", turn), of="cross", datums="top") == pytest.approx(0.0, abs=1e-13)


def test_angularity_keeps_the_drawn_angle() -> None:
    # the roof at 30 deg: turned further about x by 1 mrad, its 40 mm side (along the slope) gives 0.04
    a = math.radians(30.0) + 1e-3
    roof = ("roof", fit("roof", axis=(0, math.sin(a), math.cos(a))))
    assert value("angularity", roof, of="roof", datums="top") == pytest.approx(0.04, rel=1e-6)
    assert value("angularity", of="roof", datums="top") == pytest.approx(0.0, abs=1e-14)
    # turning about the datum's normal is not angularity
    b = 1e-3
    roof = ("roof", fit("roof", axis=(-math.sin(b) * 0.5, math.cos(b) * 0.5, math.sqrt(0.75))))
    assert value("angularity", roof, of="roof", datums="top") == pytest.approx(0.0, abs=1e-13)


def test_orientation_needs_a_drawing_that_agrees_and_directions() -> None:
    with pytest.raises(UsageError, match="30 deg off parallelism"):
        value("parallelism", of="roof", datums="top")
    with pytest.raises(UsageError, match="not for a sphere"):
        value("parallelism", of="ball", datums="top")
    with pytest.raises(UsageError, match="no datum direction"):
        value("parallelism", of="top", datums="ball")


def test_position_of_centres_axes_and_planes() -> None:
    # ball off by (0.01, 0.02, 0.02) = 0.03: sphere of 0.06
    assert value("position", ("ball", fit("ball", point=(3.01, 4.02, 32.02))), of="ball") == pytest.approx(
        0.06
    )
    # circle: only within its plane: hypot(0.03, 0.04) * 2
    assert value("position", ("rim", fit("rim", point=(0.03, 0.04, 20.5))), of="rim") == pytest.approx(0.1)
    # axis off by 0.01 at z = 0 and leaning by 1 mrad: 0.01 + 0.02 at its far end, twice
    bore = fit("bore", point=(0.01 - 3e-3, 0, -3), axis=(1e-3, 0, 1))
    assert value("position", ("bore", bore), of="bore") == pytest.approx(0.06)
    # plane 0.01 high and leaning by 1 mrad over 80 mm: 0.01 + 0.04, twice
    assert value(
        "position", ("top", fit("top", point=(0, 0, 20.01), axis=(1e-3, 0, 1))), of="top"
    ) == pytest.approx(0.1)
    # a point along its normal, a line along the normal of its surface (y): leaning by 1 mrad over 50 mm
    assert value("position", ("tip", fit("tip", point=(9, 9, 3.01))), of="tip") == pytest.approx(0.02)
    assert value("position", ("edge", fit("edge", axis=(1, 1e-3, 5e-3))), of="edge") == pytest.approx(0.1)
    with pytest.raises(UsageError, match="free-form surface"):
        value("position", of="free")


def test_position_follows_the_alignment_or_its_own_datums() -> None:
    # everything measured 0.1 mm to the right, hole a further 0.01
    shifted = [(n, fit(n, point=FEATURES[n].point + [0.1, 0, 0])) for n in ("top", "front", "bore")]
    hole = ("hole", fit("hole", point=(30.11, 40, 0)))
    assert value("position", hole, of="hole") == pytest.approx(0.22)
    pose = Pose(np.eye(3), np.array([-0.1, 0.0, 0.0]))
    assert value("position", hole, of="hole", pose=pose) == pytest.approx(0.02)
    assert value("position", *shifted, hole, of="hole", datums=("top", "bore", "front")) == pytest.approx(
        0.02
    )
    # bore alone leaves the turn about it free: of 0.01 along x at (30, 40) that takes up what is across, 0.8, and leaves 0.6 along the arm
    assert value("position", *shifted, hole, of="hole", datums=("bore",), pose=pose) == pytest.approx(0.012)


def test_coaxiality() -> None:
    # rim centre 0.03 off the axis of the bore: 0.06; the cone axis (10 mm) leaning by 1 mrad: 2 * 0.01 at its end
    assert value(
        "coaxiality", ("rim", fit("rim", point=(0, 0.03, 20))), of="rim", datums="bore"
    ) == pytest.approx(0.06)
    cone = ("cone", fit("cone", axis=(1e-3, 0, 1)))
    assert value("coaxiality", cone, of="cone", datums="bore") == pytest.approx(0.02, rel=1e-6)
    with pytest.raises(UsageError, match="50 mm off coaxiality"):
        value("coaxiality", of="hole", datums="bore")
    with pytest.raises(UsageError, match="no datum axis"):
        value("coaxiality", of="bore", datums="top")
    with pytest.raises(UsageError, match="no axis or centre"):
        value("coaxiality", of="top", datums="bore")


def test_symmetry_of_an_axis_and_of_a_slot() -> None:
    assert value(
        "symmetry", ("bore", fit("bore", point=(0.01, 5, 0))), of="bore", datums="mid"
    ) == pytest.approx(0.02)
    # the slot's walls at -5 and 5.02: its middle is 0.01 off: 0.02. Turned alike by 1 mrad about z: 15 mm * 1e-3
    # further at the ends of the 30 mm walls: 2 * (0.01 + 0.015)
    right = ("right", fit("right", point=(5.02, 0, 10)))
    slot = ("left", "right")
    assert value("symmetry", right, of=slot, datums="mid") == pytest.approx(0.02)
    left = ("left", fit("left", axis=(1, 1e-3, 0)))
    right = ("right", fit("right", point=(5.02, 0, 10), axis=(-1, -1e-3, 0)))
    assert value("symmetry", left, right, of=slot, datums="mid") == pytest.approx(0.05, rel=1e-5)
    # walls that open by +-1 mrad keep their middle
    right = ("right", fit("right", axis=(-1, 1e-3, 0)))
    assert value("symmetry", left, right, of=slot, datums="mid") == pytest.approx(0.0, abs=1e-12)
    # the slot as a datum, the other way round
    assert value(
        "symmetry", ("bore", fit("bore", point=(0.01, 5, 0))), of="bore", datums=slot
    ) == pytest.approx(0.02)
    with pytest.raises(UsageError, match="off symmetry"):
        value("symmetry", of="hole", datums="mid")
    with pytest.raises(UsageError, match="planes"):
        value("symmetry", of="bore", datums="cross")


def test_values_do_not_depend_on_where_the_part_lies() -> None:
    machine_from_part = Pose.from_turns((300.0, 250.0, -200.0), (0.3, -0.2, 2.0))
    f = fit("bore", point=(0.01, 0.02, 0), axis=(1e-3, 0, 1))
    there = FittedElement(
        "cylinder",
        machine_from_part.apply(f.point),
        machine_from_part.turn(f.axis),
        f.sizes,
        f.residuals,
        f.normals,
    )
    top = fit("top", point=machine_from_part.apply((0, 0, 20)), axis=machine_from_part.turn((0, 0, 1)))
    cases: list[tuple[str, dict[str, Any]]] = [
        ("perpendicularity", {"datums": "top"}),
        ("position", {}),
        ("size", {}),
    ]
    for type_, fields in cases:
        here = value(type_, ("bore", f), of="bore", **fields)
        moved = value(
            type_, ("bore", there), ("top", top), of="bore", pose=machine_from_part.inverse(), **fields
        )
        assert moved == pytest.approx(here, abs=1e-12)
    with pytest.raises(ModelLimit, match="the pose of the part is missing"):
        value("perpendicularity", ("bore", there), ("top", top), of="bore", datums="top")


BATCHED = [
    ("size", {"of": "bore"}), ("distance", {"between": ("bore", "ball")}), ("angle", {"between": ("bore", "roof")}),
    ("cylindricity", {"of": "bore"}), ("perpendicularity", {"of": "bore", "datums": "top"}),
    ("parallelism", {"of": "hole", "datums": "bore"}), ("position", {"of": "bore"}),
    ("position", {"of": "hole", "datums": ("top", "bore", "front")}), ("coaxiality", {"of": "cone", "datums": "bore"}),
    ("symmetry", {"of": "bore", "datums": "mid"}),
]  # fmt: skip


@pytest.mark.parametrize(("type_", "fields"), BATCHED)
def test_batches_equal_their_members(type_: str, fields: dict[str, Any]) -> None:
    rng = np.random.default_rng(7)
    point, axis = 0.01 * rng.normal(size=(4, 3)), [0, 0, 1] + 1e-3 * rng.normal(size=(4, 3))
    sizes, residuals = 15.0 + 0.01 * rng.normal(size=(4, 1)), 1e-3 * rng.normal(size=(4, 8))
    poses = Pose.from_turns(1e-3 * rng.normal(size=(4, 3)), 1e-4 * rng.normal(size=(4, 3)))
    batch = value(type_, ("bore", fit("bore", point, axis, sizes, residuals)), pose=poses, **fields)
    assert batch.shape == (4,)
    for i in range(4):
        one = fit("bore", point[i], axis[i], sizes[i], residuals[i])
        pose = Pose(poses.rotation[i], poses.shift[i])
        assert value(type_, ("bore", one), pose=pose, **fields) == pytest.approx(
            batch[i], rel=1e-9, abs=1e-14
        )


def test_nominal_values_of_the_drawing() -> None:
    def drawn(type_: str, **fields: Any) -> float:
        return nominal(Characteristic("c", type_, **fields), FEATURES)

    assert drawn("size", of=("bore",)) == 30.0
    assert drawn("distance", between=("bore", "hole")) == pytest.approx(50.0)
    assert drawn("distance", between=("top", "bore")) == pytest.approx(
        10.0
    )  # the middle of the bore is at z = 10
    assert drawn("angle", between=("top", "roof")) == pytest.approx(math.radians(30.0))
    assert drawn("perpendicularity", of=("bore",), datums=("top",)) == 0.0
    assert drawn("position", of=("hole",), datums=("top", "bore")) == 0.0
    assert drawn("cylindricity", of=("bore",)) == 0.0
    with pytest.raises(UsageError, match="off parallelism"):
        drawn("parallelism", of=("roof",), datums=("top",))


def test_run_out_needs_an_axis() -> None:
    with pytest.raises(UsageError, match="turns about a datum axis; a plane gives none"):
        nominal(Characteristic("c", "total_runout", of=("bore",), datums=("top",)), FEATURES)


def test_unknown_and_unmeasured_features() -> None:
    size = Characteristic("c", "size", of=("bor",))
    with pytest.raises(UsageError, match='Did you mean "bore"'):
        evaluate(size, FEATURES, {})
    with pytest.raises(UsageError, match="not measured"):
        evaluate(Characteristic("c", "size", of=("bore",)), FEATURES, {})


def test_what_a_report_needs_to_know() -> None:
    size = Characteristic("c", "size", of=("bore",), limits=(0.0, 0.021))
    square = Characteristic("s", "perpendicularity", of=("bore",), datums=("top",), zone=0.01)
    angle = Characteristic("a", "angle", between=("top", "roof"), limits=(-1e-3, 1e-3))
    assert needs(square) == ("bore", "top")
    assert needs(angle) == ("top", "roof")
    assert (unit(size), unit(angle)) == ("mm", "rad")
    assert tolerance(size, 30.0) == pytest.approx((30.0, 30.021))
    assert tolerance(square, 0.0) == (0.0, 0.01)
    assert tolerance(Characteristic("c", "size", of=("bore",)), 30.0) is None
    assert (is_linear(size), is_linear(angle), is_linear(square)) == (True, True, False)
    assert (is_one_sided(size), is_one_sided(square)) == (False, True)
    concentric = Characteristic("d", "distance", between=("bore", "cone"))
    assert is_linear(concentric)
    assert not is_linear(concentric, FEATURES)
