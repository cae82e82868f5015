"""Criteria in characteristics: words, which features they suit, values by hand, never another one in silence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.part.fit import FittedElement, gauss
from vcmm.part.gps.characteristics import evaluate, is_linear, nominal
from vcmm.part.gps.criteria import choose_criteria, criteria_needed, notes, with_criteria
from vcmm.part.part import Characteristic, Feature

Z = np.array([0.0, 0.0, 1.0])
NONE = np.array([])
FEATURES = {
    f.name: f
    for f in (
        Feature("rim", "circle", np.zeros(3), Z, np.array([10.0]), True),
        Feature("bore", "cylinder", np.zeros(3), Z, np.array([10.0]), True, (20.0,)),
        Feature("top", "plane", np.array([0, 0, 20.0]), Z, NONE, False, (40.0, 40.0)),
        Feature("side", "plane", np.array([-20.0, 0, 10]), np.array([-1.0, 0, 0]), NONE, False, (40.0, 20.0)),
        Feature("edge", "line", np.array([-20.0, 0, 20]), np.array([1.0, 0, 0]), NONE, False, (40.0,), Z),
        Feature("ball", "sphere", np.zeros(3), np.zeros(3), np.array([5.0])),
        Feature("cone", "cone", np.zeros(3), Z, np.array([5.0, 0.3]), False, (10.0,)),
    )
}


def ring(radii: Any, z: float = 0.0) -> Any:
    turn = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    return np.stack([radii * np.cos(turn), radii * np.sin(turn), np.full(len(radii), z)], axis=1)


def value(type_: str, points: dict[str, Any], **fields: Any) -> float:
    c = Characteristic("c", type_, **fields)
    fitted = {}
    for name, p in points.items():
        f = FEATURES[name]
        start = FittedElement(f.kind, f.point, f.axis, f.sizes, np.empty(0), np.empty((0, 3)))
        fitted[name] = gauss(f.kind, p, start, fixed_axis=f.axis if f.kind == "circle" else None)
    return float(evaluate(c, FEATURES, with_criteria([c], FEATURES, points.__getitem__, fitted)))


SQUARE = ring(np.array([10.0, 10.2, 10.0, 10.2]))
ROOF = np.array([[-20, 0, 20.0], [0, 0, 20.3], [20, 0, 20.0]])
# a top with its four corners at 20 and a bump of 0.3 in the middle
BUMP = np.array([[20, 20, 20.0], [20, -20, 20.0], [-20, 20, 20.0], [-20, -20, 20.0], [0, 0, 20.3]])


def test_sizes_by_hand() -> None:
    assert value("size", {"rim": SQUARE}, of="rim", criterion="GG") == pytest.approx(20.2, abs=1e-2)
    assert value("size", {"rim": SQUARE}, of="rim", criterion="GC") == pytest.approx(20.2, abs=1e-12)
    assert value("size", {"rim": SQUARE}, of="rim", criterion="GN") == pytest.approx(20.4, abs=1e-9)
    assert value("size", {"rim": SQUARE}, of="rim", criterion="GX") == pytest.approx(20.0, abs=5e-3)
    # two-point sizes 20.0 and 20.4
    for rank, wanted_size in {
        "SX": 20.4,
        "SN": 20.0,
        "SA": 20.2,
        "SM": 20.2,
        "SD": 20.2,
        "SR": 0.4,
        "SQ": 0.2,
    }.items():
        found = value("size", {"rim": SQUARE}, of="rim", criterion=f"LP {rank}")
        assert found == pytest.approx(wanted_size, abs=1e-9), rank


def test_local_sizes_without_a_rank_are_the_one_farthest_from_the_middle_of_the_limits() -> None:
    # nominal 20: 20.4 is farther than 20.0; limits +0.3 .. +0.5, middle 20.4: then it is 20.0
    assert value("size", {"rim": SQUARE}, of="rim", criterion="LP") == pytest.approx(20.4, abs=1e-9)
    assert value("size", {"rim": SQUARE}, of="rim", criterion="LP", limits=(0.3, 0.5)) == pytest.approx(
        20.0, abs=1e-9
    )
    levels = np.concatenate(
        [ring(np.full(6, 10.0)), ring(np.full(6, 10.1), 10.0), ring(np.full(6, 10.0), 20.0)]
    )
    assert value("size", {"bore": levels}, of="bore", criterion="LS SX") == pytest.approx(20.2, abs=1e-9)
    assert value("size", {"bore": levels}, of="bore", criterion="LS SN") == pytest.approx(20.0, abs=1e-9)


def test_form_by_hand() -> None:
    assert value("roundness", {"rim": SQUARE}, of="rim", criterion="C") == pytest.approx(0.2, abs=1e-12)
    assert value("roundness", {"rim": SQUARE}, of="rim", criterion="N") == pytest.approx(0.2, abs=1e-9)
    # 0, 0.3, 0: least squares -0.1, 0.2, -0.1 and minimum zone both 0.3 wide
    assert value("straightness", {"edge": ROOF}, of="edge", criterion="C") == pytest.approx(0.3, abs=1e-9)
    steps = np.array([[-20, 0, 20.0], [-10, 0, 20.001], [10, 0, 20.0], [20, 0, 20.001]])
    # level lines through (-10, 1 um), (20, 1 um) above and (-20, 0), (10, 0) below; least squares has the slope
    # (-10 + 20) / 1000 of a um per mm and is 1 + 20 * 0.01 = 1.2 um wide
    assert value("straightness", {"edge": steps}, of="edge", criterion="C") == pytest.approx(1e-3, abs=1e-10)
    assert value("straightness", {"edge": steps}, of="edge") == pytest.approx(1.2e-3, abs=1e-9)
    assert value("flatness", {"top": BUMP}, of="top", criterion="C") == pytest.approx(0.3, abs=1e-9)


def test_a_distance_from_a_tangent_plane() -> None:
    # the tangent plane lies on the bump, 0.3 above the corners; the least-squares plane at their mean, 0.06
    ball = np.array([[5, 0, 0], [-5, 0, 0], [0, 5, 0], [0, -5, 0], [0, 0, 5], [0, 0, -5.0]])
    points = {"top": BUMP, "ball": ball}
    assert value("distance", points, between=("top", "ball")) == pytest.approx(20.06, abs=1e-9)
    assert value("distance", points, between=("top", "ball"), criterion="T G") == pytest.approx(
        20.3, abs=1e-9
    )
    assert value("distance", points, between=("top", "ball"), criterion="T N") == pytest.approx(
        20.3, abs=1e-9
    )


def test_a_datum_in_contact() -> None:
    # a ridge of 0.1 at z = 5 on a side from z = 0 to 20.
    side = np.array([[-20 - out, y, z] for z, out in ((0, 0.0), (5, 0.1), (20, 0.0)) for y in (-20, 20)])
    top = np.array([[x, y, 20.0] for x in (-20, 20) for y in (-20, 20)], dtype=float)
    points = {"side": side, "top": top}
    fields = {"of": "top", "datums": "side"}
    # sum (z - zm) v = -10/3 * 0.1, sum (z - zm)^2 = 650/3: slope 1/650, over the 40 mm of the top
    assert value("perpendicularity", points, **fields) == pytest.approx(40 / 650, abs=1e-5)
    # tangent: through the ridge with slope b, gaps 0.1 - 5 b and 0.1 + 15 b; least sum of squares at b = -0.004
    tangent = value("perpendicularity", points, **fields, datum_criterion="T")
    assert tangent == pytest.approx(0.004 * 40, abs=1e-5)
    # a side leaning by 0.1 over its 20 mm, all points in one plane: every criterion sees the same 0.1/20 * 40 = 0.2
    leaning = np.array([[-20, -20, 0.0], [-20, 20, 0.0], [-20.1, -20, 20.0], [-20.1, 20, 20.0]])
    for criterion in "GCT":
        found = value("perpendicularity", points | {"side": leaning}, **fields, datum_criterion=criterion)
        assert found == pytest.approx(0.2, abs=1e-4), criterion


def test_words_and_what_they_mean() -> None:
    assert choose_criteria(Characteristic("c", "size", of="rim")).of == ("G",)
    assert choose_criteria(Characteristic("c", "size", of="rim", criterion="GX")).of == ("X",)
    assert choose_criteria(Characteristic("c", "size", of="rim", criterion="LP SX")).rank == "SX"
    pair = Characteristic("c", "distance", between=("top", "rim"), criterion="T X")
    assert choose_criteria(pair).of == ("T", "X")
    two = Characteristic(
        "c", "position", of="rim", datums=("top", "side"), criterion="X", datum_criterion="T"
    )
    assert choose_criteria(two).datums == ("T", "T")
    # the secondary datum is fitted once more, with its orientation constrained by the primary (ISO 5459)
    assert criteria_needed([pair, two], {}) == {"top": ("T",), "rim": ("X",), "side": ("T", "points")}


@pytest.mark.parametrize(
    ("type_", "fields", "message"),
    [
        (
            "size",
            {"of": "rim", "criterion": "GT"},
            'a size has no criterion "GT".*Allowed: GG, GC, GN, GX, LP, LS',
        ),
        ("size", {"of": "rim", "criterion": "GX SX"}, "a rank goes with LP and LS, not with GX"),
        ("size", {"of": "rim", "criterion": "LP SY"}, 'unknown rank "SY"'),
        ("size", {"of": "ball", "criterion": "LS"}, 'LS is for circle, cylinder, not for a sphere; .*"GX"'),
        (
            "roundness",
            {"of": "rim", "criterion": "GX"},
            '"GX" is a criterion of sizes; roundness takes G, C, N, X',
        ),
        ("roundness", {"of": "rim", "criterion": "T"}, "T is for orientation and location"),
        ("flatness", {"of": "top", "criterion": "N"}, "not for a plane; a plane takes G, C, T"),
        ("flatness", {"of": "top", "criterion": "M"}, 'unknown criterion "M"'),
        (
            "distance",
            {"between": ("top", "rim"), "criterion": "T T"},
            'feature "rim": .*outside the material is "X"',
        ),
        ("distance", {"between": ("top", "rim"), "criterion": "T X X"}, "names 3; give one, or 2"),
        ("flatness", {"of": "top", "datum_criterion": "T"}, "datum_criterion is given, but no datums"),
    ],
)
def test_words_that_mean_nothing_are_refused(type_: str, fields: dict[str, Any], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        nominal(Characteristic("c", type_, **fields), FEATURES)


def test_never_another_criterion_in_silence() -> None:
    plain = {"rim": gauss("circle", SQUARE, fixed_axis=Z)}
    with pytest.raises(UsageError, match='criterion "X" of "rim" needs its measured points'):
        evaluate(Characteristic("c", "size", of="rim", criterion="GX"), FEATURES, plain)
    with pytest.raises(ModelLimit, match='feature "rim": circle: no two measured points lie opposite'):
        value("size", {"rim": ring(np.full(5, 10.0))}, of="rim", criterion="LP")


def test_contact_is_not_smooth_and_what_slides_is_said() -> None:
    c = Characteristic("c", "size", of="rim", criterion="GX")
    assert not is_linear(c, FEATURES)
    assert is_linear(Characteristic("c", "size", of="rim", criterion="G"), FEATURES)
    points = {"rim": SQUARE}
    made = with_criteria([c], FEATURES, points.__getitem__, {"rim": gauss("circle", SQUARE, fixed_axis=Z)})
    assert notes([c], made)[0].startswith(
        "rim: the element by criterion X (maximum inscribed) is not the only one"
    )
    round_ = ring(np.array([10.0, 10.1, 10.1, 10.0, 10.1, 10.1, 10.0, 10.1, 10.1]))
    made = with_criteria([c], FEATURES, lambda _: round_, {"rim": gauss("circle", round_, fixed_axis=Z)})
    assert notes([c], made) == []
