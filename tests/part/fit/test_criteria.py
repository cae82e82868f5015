"""Elements by contact: by hand, against certified and constructed sets, against linear programs; what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import data_file
from tests.part.fit.lp_twin import sequential_lp
from tests.part.fit.test_reference import MM, RAD, assert_same, differences, read_pair
from tests.refdata import Array, Recipe, Reference, touching
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.part.fit import FittedElement, associate, gauss, profile_line, sphere_radii, two_point_radii
from vcmm.part.fit.criteria import ROUND, SUITS

Z = np.array([0.0, 0.0, 1.0])
LETTER = {"mz": "C", "mcc": "N", "mic": "X"}
SETS = {
    "mz": ["plane", "sphere", "cylinder", "cone", "torus"], "mcc": ["sphere", "cylinder"], "mic": ["sphere", "cylinder"],
}  # fmt: skip
COUNT = {"plane": 2, "sphere": 2, "cylinder": 2, "cone": 1, "torus": 1}
CERTIFIED = [
    f"{kind}_{word}{i + 1}"
    for word, kinds in SETS.items()
    for kind in kinds
    for i in range(COUNT[kind] + (kind == "cylinder" and word == "mz"))
]


def ring(radii: list[float], z: float = 0.0) -> Array:
    """Points (n, 3) at equal angles, from +x on."""
    turn = 2.0 * np.pi * np.arange(len(radii)) / len(radii)
    return np.stack([radii * np.cos(turn), radii * np.sin(turn), np.full(len(radii), z)], axis=1)


def circle(criterion: str, points: Array):
    return associate("circle", criterion, points, fixed_axis=Z)


def certified(name: str) -> tuple[Reference, float | None]:
    """The reference set, and its zone width where it has one."""
    kind, word = name.split("_")
    want = read_pair(data_file(f"data/fitting/certified_chebyshev/{name}.ds"), kind)
    if not word.startswith("mz"):
        return want, None
    numbers = data_file(f"data/fitting/certified_chebyshev/{name}.fit").read_text().split()
    sizes = want.sizes if kind == "cone" else want.sizes[:-1]
    return Reference(kind, want.points, want.point, want.axis, sizes[:2]), float(numbers[-1])


@pytest.mark.parametrize("name", CERTIFIED)
def test_certified_sets(name: str) -> None:
    want, width = certified(name)
    found = associate(want.kind, LETTER[name.split("_")[1].rstrip("123")], want.points)
    assert_same(found.element, want)
    assert found.unique
    if width is not None:
        assert np.ptp(found.element.residuals) == pytest.approx(width, abs=MM)


def test_all_certified_sets_are_there() -> None:
    folder = data_file("data/fitting/certified_chebyshev/plane_mz1.ds").parent
    assert sorted(CERTIFIED) == sorted(path.stem for path in folder.glob("*.ds"))


def test_square_by_hand() -> None:
    # two corners on radius 10, the other two on 10.2: zone 10..10.2, the circle between them 10.1
    c = circle("C", ring([10.0, 10.2, 10.0, 10.2]))
    assert c.element.sizes[0] == pytest.approx(10.1, abs=1e-12)
    assert np.ptp(c.element.residuals) == pytest.approx(0.2, abs=1e-12)
    assert c.contacts.all()
    assert c.unique
    # the smallest circle around it stands on the far pair, the largest inside it on the near one
    n = circle("N", ring([10.0, 10.2, 10.0, 10.2]))
    assert n.element.sizes[0] == pytest.approx(10.2, abs=1e-12)
    assert n.element.point == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)
    assert n.contacts.tolist() == [False, True, False, True]
    assert n.unique


def test_an_inscribed_circle_between_two_points_slides() -> None:
    # the near pair lies at (+-10, 0): a circle about (0, y) touches both with radius hypot(10, y), until it meets one
    # of the points (0, +-10.2), when 10.2 - y = hypot(10, y): y = (10.2^2 - 10^2) / 20.4, radius 10.2 - y
    x = circle("X", ring([10.0, 10.2, 10.0, 10.2]))
    y = (10.2**2 - 10.0**2) / 20.4
    assert x.element.sizes[0] == pytest.approx(10.2 - y, abs=1e-4)
    assert not x.unique


def test_five_points_where_the_criteria_differ() -> None:
    # a square on radius 10 and a fifth point on radius 9, midway between the corners (10, 0) and (0, 10)
    points = np.array([[10.0, 0, 0], [0, 10.0, 0], [-10.0, 0, 0], [0, -10.0, 0], [0, 0, 0]])
    points[4] = [9.0 * np.cos(0.25 * np.pi), 9.0 * np.sin(0.25 * np.pi), 0.0]
    n = circle("N", points)
    assert n.element.sizes[0] == pytest.approx(10.0, abs=1e-12)
    assert n.element.point == pytest.approx([0, 0, 0], abs=1e-12)
    assert n.contacts.tolist() == [True, True, True, True, False]
    # inscribed: touches the fifth point and the two opposite corners, (-10, 0) and (0, -10); by symmetry its centre
    # is (-s, -s), and (10 - s)^2 + s^2 = (9 + sqrt(2) s)^2: 100 - 20 s = 81 + 18 sqrt(2) s
    s = 19.0 / (20.0 + 18.0 * np.sqrt(2.0))
    x = circle("X", points)
    assert x.element.point == pytest.approx([-s, -s, 0.0], abs=1e-10)
    assert x.element.sizes[0] == pytest.approx(9.0 + np.sqrt(2.0) * s, abs=1e-10)
    assert x.contacts.tolist() == [False, False, True, True, True]
    # minimum zone: the same centre, by symmetry; inside the same three points, outside the corners (10, 0) and (0, 10)
    c, inner, outer = circle("C", points), 9.0 + np.sqrt(2.0) * s, np.hypot(10.0 + s, s)
    assert c.element.point == pytest.approx([-s, -s, 0.0], abs=1e-10)
    assert c.element.sizes[0] == pytest.approx(0.5 * (inner + outer), abs=1e-10)
    assert np.ptp(c.element.residuals) == pytest.approx(outer - inner, abs=1e-10)
    assert c.contacts.all()


def test_plane_by_hand() -> None:
    # corners of a square twisted by 2 mm: two diagonals 1 mm up and down; the zone is level and 2 mm wide
    points = np.array([[10, 10, 1.0], [-10, -10, 1.0], [10, -10, -1.0], [-10, 10, -1.0], [1, 2, 0.3]])
    c = associate("plane", "C", points)
    assert np.ptp(c.element.residuals) == pytest.approx(2.0, abs=1e-12)
    assert c.element.axis == pytest.approx([0, 0, 1], abs=1e-12)
    assert c.contacts.tolist() == [True] * 4 + [False]
    # tangent from above: it rests on one diagonal; tilting about it gains on one side what it loses on the other
    t = associate("plane", "T", points[:4], gauss("plane", points[:4]))
    assert t.element.residuals == pytest.approx([0, 0, -2, -2], abs=1e-9)


def test_tangent_plane_rests_on_one_point_where_least_squares_say_so() -> None:
    # a pyramid 0.3 mm high: the least-squares plane under constraint is level at the top
    points = np.array([[10, 0, 0.0], [-10, 0, 0.0], [0, 10, 0.0], [0, -10, 0.0], [0, 0, 0.3]])
    t = associate("plane", "T", points, gauss("plane", points))
    assert t.element.residuals == pytest.approx([-0.3, -0.3, -0.3, -0.3, 0.0], abs=1e-12)
    assert t.contacts.tolist() == [False] * 4 + [True]


def test_line_in_space_and_in_a_plane_by_hand() -> None:
    # points of a triangle of circumradius 0.1 at three heights, repeated: the cylinder about them has that radius
    turn = np.radians([0.0, 120.0, 240.0])
    flat = 0.1 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    points = np.concatenate([flat + [0, 0, z] for z in (0.0, 20.0, 40.0)])
    c = associate("line", "C", points)
    assert c.element.residuals == pytest.approx(np.full(9, 0.1), abs=1e-9)
    # a roof: 0, 0.3, 0 over 40 mm: zone 0.3 wide; tangent from above level at 0.3
    roof = np.array([[0, 0, 0.0], [20, 5, 0.3], [40, -3, 0.0]])  # what lies across the plane does not count
    found = profile_line("C", roof, np.array([1.0, 0, 0]), Z)
    assert found.element.residuals == pytest.approx([-0.15, 0.15, -0.15], abs=1e-12)
    assert found.element.axis == pytest.approx([1, 0, 0], abs=1e-12)
    assert found.unique
    assert profile_line("T", roof, np.array([1.0, 0, 0]), Z).element.residuals == pytest.approx(
        [-0.3, 0, -0.3]
    )
    assert profile_line("T", roof, np.array([1.0, 0, 0]), Z, inside=True).element.residuals == pytest.approx(
        [0, 0.3, 0], abs=1e-12
    )
    # least squares: mean 0.1
    assert profile_line("G", roof, np.array([1.0, 0, 0]), Z).element.residuals == pytest.approx(
        [-0.1, 0.2, -0.1]
    )


def test_a_leaning_profile_line_by_hand() -> None:
    """The roof of 40 mm and 0.3 mm, turned by atan(3/4): along u = (0.8, 0, 0.6), up w = (-0.6, 0, 0.8). The line of criterion C runs
    0.15 up; its point is the foot of the centroid (20 along, 0.1 up): 20 u + 0.15 w. T from above lies 0.3 up."""
    u, w = np.array([0.8, 0.0, 0.6]), np.array([-0.6, 0.0, 0.8])
    across = np.array([0.0, 5.0, -3.0])  # does not count; its mean stays in the point
    roof = np.outer([0.0, 20.0, 40.0], u) + np.outer([0.0, 0.3, 0.0], w) + np.outer(across, [0, 1, 0])
    for criterion, up, residuals in (("C", 0.15, [-0.15, 0.15, -0.15]), ("T", 0.3, [-0.3, 0.0, -0.3])):
        found = profile_line(criterion, roof, np.array([1.0, 0, 0]), Z).element
        assert found.residuals == pytest.approx(residuals, abs=1e-9)
        assert found.axis == pytest.approx(u, abs=1e-9)
        assert found.point == pytest.approx(20 * u + up * w + [0, 2 / 3, 0], abs=1e-9)
    # least squares of three points on a line that rises by 1 in 100
    rising = np.array([[0.0, 0, 0], [10, 0, 0.1], [20, 0, 0.2]])
    found = profile_line("G", rising, np.array([1.0, 0, 0]), Z).element
    assert found.axis == pytest.approx(np.array([100, 0, 1]) / np.sqrt(10001), abs=1e-12)
    assert found.point == pytest.approx([10, 0, 0.1], abs=1e-12)


def test_oval_cylinder_by_hand() -> None:
    # axes 2 x 20.01 and 2 x 19.99 on two levels: circumscribed 20.01, held at two points of each level
    turn = 2.0 * np.pi * np.arange(24) / 24
    radius = 20.0 + 0.01 * np.cos(2 * turn)
    points = np.concatenate([ring(radius, z) for z in (-20.0, 20.0)])
    n = associate("cylinder", "N", points)
    assert n.element.sizes[0] == pytest.approx(20.01, abs=1e-10)
    assert n.contacts.sum() == 4
    assert n.unique
    # a barrel: one section is wider, contact at its two points only: the tilt is free, and that is said
    barrel = np.concatenate([ring(radius, -20.0), ring(radius + 0.05, 0.0), ring(radius, 20.0)])
    n = associate("cylinder", "N", barrel)
    assert n.element.sizes[0] == pytest.approx(20.06, abs=1e-9)
    assert not n.unique


POSSIBLE = [(k, c) for c, kinds in SUITS.items() for k in kinds if c != "G" and k != "line"]


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    pair=st.sampled_from(POSSIBLE),
    seed=st.integers(0, 2**32 - 1),
    n=st.integers(20, 60),
    size=st.floats(2.0, 200.0),
    form=st.floats(1e-5, 1e-3),
)
def test_constructed_contacts(pair: tuple[str, str], seed: int, n: int, size: float, form: float) -> None:
    kind, criterion = pair
    made = touching(
        kind, criterion, np.random.default_rng(seed), Recipe(n, size, form * size, length=2 * size)
    )
    fixed = made.reference.axis if kind == "circle" else None
    want = made.reference
    start = FittedElement(kind, want.point, want.axis, want.sizes, np.empty(0), np.empty((0, 3)))
    known = start if kind == "plane" else None  # where the material is
    found = associate(kind, criterion, want.points, known, fixed_axis=fixed)
    length, angle = differences(found.element, want)
    assert length < MM
    assert angle < RAD
    assert np.flatnonzero(found.contacts).tolist() == made.contacts.tolist()
    assert np.ptp(found.element.residuals) == pytest.approx(made.width, abs=MM)


@pytest.mark.parametrize(("kind", "criterion"), [("plane", "C"), *((k, c) for k in ROUND for c in "CNX")])
def test_linear_programs_agree(kind: str, criterion: str) -> None:
    rng = np.random.default_rng(3)
    for seed in range(3):
        want = touching(kind, "C", np.random.default_rng(seed), Recipe(24, offset=5.0)).reference
        points = want.points + 0.01 * rng.standard_normal(want.points.shape)
        fixed = want.axis if kind == "circle" else None
        found = associate(kind, criterion, points, fixed_axis=fixed).element
        start = np.concatenate([want.point, want.axis if kind != "sphere" else Z, want.sizes])
        p, level, _ = sequential_lp(kind, criterion, points, start, kind == "circle", trust=0.1)
        if criterion == "C":
            assert np.max(np.abs(found.residuals)) == pytest.approx(level, abs=1e-8)
        else:
            assert found.sizes[0] == pytest.approx(p[6], abs=1e-8)


def test_a_batch_is_its_members() -> None:
    rng = np.random.default_rng(5)
    points = ring(np.full(12, 10.0)) + 1e-3 * rng.standard_normal((3, 2, 12, 3))
    together = associate("circle", "X", points, fixed_axis=Z)
    alone = associate("circle", "X", points[2, 1], fixed_axis=Z)
    assert together.element.sizes.shape == (3, 2, 1)
    assert together.contacts.shape == (3, 2, 12)
    assert np.array_equal(together.element.sizes[2, 1], alone.element.sizes)


def test_perfect_points_are_no_trouble() -> None:
    points = np.concatenate([ring(np.full(8, 15.0), z) for z in (0.0, 10.0)])
    for criterion in "CNX":
        found = associate("cylinder", criterion, points)
        assert found.element.sizes[0] == pytest.approx(15.0, abs=1e-12)
        assert found.unique


def test_degenerate_points_are_refused() -> None:
    level = ring(np.full(8, 10.0))
    for criterion in "CNX":
        with pytest.raises(ModelLimit, match="do not determine the tilt of the cylinder"):
            associate("cylinder", criterion, level)  # one circle
        with pytest.raises(ModelLimit, match="at least 5 points, got 4"):
            associate("cylinder", criterion, level[:4])
        with pytest.raises(ModelLimit, match=r"do not determine|converge"):
            associate("cylinder", criterion, np.repeat(level[:2], 5, axis=0))  # two places, five times each
        with pytest.raises(ModelLimit, match="all points lie in one plane"):
            associate(
                "cylinder", criterion, np.stack([np.array([i % 3, i // 3, 0.0]) for i in range(9)])
            )  # coplanar
        with pytest.raises(ModelLimit, match="do not determine"):
            associate("sphere", criterion, level)
    with pytest.raises(ModelLimit, match="do not determine the tilt of the plane"):
        associate("plane", "C", np.array([[0, 0, 0.0], [1, 0, 0], [2, 0, 0], [5, 0, 0]]))
    with pytest.raises(ModelLimit, match="all lie at one place"):
        profile_line("C", np.zeros((4, 3)), np.array([1.0, 0, 0]), Z)


def test_short_arcs_are_refused_where_contact_needs_surrounding_points() -> None:
    turn = np.linspace(0.0, 2.0, 12)
    arc = np.stack([10 * np.cos(turn), 10 * np.sin(turn), 0 * turn], axis=1)
    arc += 1e-3 * np.random.default_rng(1).standard_normal(arc.shape) * [1, 1, 0]
    for criterion, word in (("N", "shrink"), ("X", "grow")):
        with pytest.raises(ModelLimit, match=f"do not surround it.*{word} on and on"):
            circle(criterion, arc)
    assert circle("C", arc).element.sizes[0] == pytest.approx(10.0, abs=0.05)


def test_words() -> None:
    points = ring(np.full(8, 10.0))
    with pytest.raises(UsageError, match=r'"Q" is no criterion of association.*G, C, N, X, T'):
        associate("circle", "Q", points)
    with pytest.raises(UsageError, match="not for a plane; a plane takes G, C, T"):
        associate("plane", "N", points)
    with pytest.raises(UsageError, match='in contact outside the material is "X"'):
        associate("cylinder", "T", points, inside=True)
    assert circle("G", points).element.sizes[0] == pytest.approx(10.0)


def test_local_sizes_by_hand() -> None:
    # opposite radii 10.0 + 10.2, 10.1 + 9.9, 10.1 + 10.1 about the centre of the section; least-squares centre moves
    # with the first harmonic, which opposite points do not feel
    radii = np.array([10.0, 10.1, 10.1, 10.2, 9.9, 10.1])
    points = np.concatenate([ring(radii, 0.0), ring(np.full(6, 12.0), 10.0)])
    base = gauss("cylinder", points, fixed_axis=Z)
    found = np.sort(2.0 * two_point_radii(points, base))
    assert found[:3] == pytest.approx([20.0, 20.2, 20.2], abs=2e-3)  # second order: 0.1^2 / 10
    assert found[3:] == pytest.approx([24.0] * 3, abs=1e-9)
    lowest = circle("X", points[:6]).element.sizes[0]
    assert sphere_radii(points, base) == pytest.approx([lowest, 12.0], abs=1e-9)
    with pytest.raises(ModelLimit, match="no two measured points lie opposite"):
        two_point_radii(ring(np.full(5, 10.0)), gauss("circle", ring(np.full(5, 10.0)), fixed_axis=Z))
    with pytest.raises(UsageError, match="a plane has no sections"):
        two_point_radii(points, gauss("plane", points))
