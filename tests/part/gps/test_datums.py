"""Datum systems of ISO 5459 beside a truth that shares no code with the package: nominal features laid onto points by scipy.

The truth lays the drawing onto the points of each datum in order: one rotation for all of them, a shift and sizes of its own for each.
The first datum takes what it can of the rotation, the next what is left, so that its orientation is constrained.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares, minimize
from scipy.spatial.transform import Rotation

from vcmm.part.fit import gauss, hold_axis, normal_matrix
from vcmm.part.fit.fixed_orientation import at_angle
from vcmm.part.gps.characteristics import evaluate
from vcmm.part.gps.criteria import with_criteria
from vcmm.part.gps.datums import constrained_features
from vcmm.part.part import Characteristic, Feature, normal, surface_point
from vcmm.task.measuring.task import nominal_element

X, Y, Z = np.eye(3)


def feature(name: str, kind: str, point: Any, axis: Any, sizes: Any = (), extent: Any = ()) -> Feature:
    return Feature(
        name,
        kind,
        np.array(point, float),
        np.array(axis, float),
        np.array(sizes, float),
        False,
        tuple(extent),
    )


TARGET = feature("target", "sphere", (15, 30, 12), (0, 0, 0), (4.0,))
FEATURES = {
    f.name: f
    for f in (
        TARGET,
        feature("top", "plane", (0, 0, 0), Z, (), (80, 60)),
        feature("front", "plane", (0, -40, -10), -Y, (), (80, 20)),
        feature("side", "plane", (50, 0, -10), X, (), (60, 20)),
        feature("slope", "plane", (30, 10, 5), (0.5, 0, np.sqrt(0.75)), (), (40, 20)),
        feature("bore", "cylinder", (-20, 0, -20), Z, (6.0,), (20,)),
        feature("hole", "cylinder", (20, 10, -20), Z, (5.0,), (20,)),
        feature("cross", "cylinder", (-30, 20, -10), X, (4.0,), (30,)),
        feature("oblique", "cylinder", (0, 5, -10), (0.5, 0.0, np.sqrt(0.75)), (5.0,), (25,)),
        feature("seat", "cone", (-20, 0, -20), Z, (6.0, 0.3), (15,)),
        feature("edge", "line", (-30, -40, 0), X, (), (60,)),
        feature("ball", "sphere", (30, -5, 10), (0, 0, 0), (8.0,)),
        feature("ball 2", "sphere", (-25, 15, 3), (0, 0, 0), (6.0,)),
        feature("rim", "circle", (25, 20, 0), Z, (5.0,)),
    )
}  # fmt: skip
SYSTEMS = [
    ("top", "bore", "hole"), ("top", "bore", "front"), ("top", "front", "side"), ("top", "cross", "side"), ("top", "front", "bore"),
    ("top", "bore", "cross"), ("top", "oblique", "front"), ("top", "slope", "front"), ("top", "edge", "side"), ("top", "rim", "front"),
    ("top", "ball", "front"), ("top", "ball", "ball 2"), ("bore", "top", "hole"), ("bore", "front", "top"), ("bore", "ball", "front"),
    ("bore", "hole", "top"), ("bore", "cross", "top"), ("cross", "top", "side"), ("seat", "front", "top"), ("seat", "hole", "front"),
    ("cross", "seat", "top"), ("ball", "top", "front"), ("ball", "ball 2", "front"), ("ball", "cross", "top"), ("slope", "cross", "front"),
    ("edge", "top", "side"),
]  # fmt: skip


def places(f: Feature, rng: np.random.Generator) -> np.ndarray:
    """Points that no symmetry helps: uneven over length and round."""
    if f.kind == "plane":
        u, v = (e * rng.uniform(-0.5, 0.35, 25) for e in f.extent)
        return surface_point(f, u, v)
    if f.kind == "line":
        return surface_point(f, np.linspace(0.0, 0.8 * f.extent[0], 12))
    if f.kind == "sphere":
        return surface_point(f, rng.uniform(0, 5.0, 30), rng.uniform(-1.2, 0.8, 30))
    along = f.extent[0] * rng.uniform(0.0, 0.8, 40) if f.extent else 0.0
    return surface_point(f, np.linspace(0, 5.5, 40), along)


def measured(rng: np.random.Generator, out: float) -> dict[str, np.ndarray]:
    """Every feature out of place and direction by `out` mm, with form; the target where the drawing has it."""
    points = {}
    for name, f in FEATURES.items():
        p = places(f, rng)
        if f is not TARGET:
            middle = p.mean(axis=0)
            turn = Rotation.from_rotvec(rng.normal(size=3) * out / 20.0)
            wave = 0.3 * out * np.sin(p @ rng.normal(size=3) * 0.2)
            p = turn.apply(p - middle) + middle + rng.normal(size=3) * out + wave[:, None] * normal(f, p)
        points[name] = p
    return points


def distances(f: Feature, p: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    arm = p - f.point
    along = arm @ f.axis
    if f.kind == "plane":
        return along
    if f.kind == "sphere":
        return np.linalg.norm(arm, axis=1) - sizes[0]
    if f.kind == "line":
        other = np.array([f.axis[1], -f.axis[0], 0.0])
        return np.concatenate([arm @ other, arm @ np.cross(f.axis, other)])
    rho = np.linalg.norm(arm - along[:, None] * f.axis, axis=1)
    if f.kind == "cone":
        return (rho - sizes[0]) * np.cos(sizes[1]) - along * np.sin(sizes[1])
    return rho - sizes[0]


def laid(f: Feature, p: np.ndarray, turns: np.ndarray, start: Rotation) -> tuple[Rotation, np.ndarray]:
    """Rotation about the rows of turns (k, 3) after start, and shift, of the drawing's feature laid onto p by least squares."""
    k = len(turns)
    sizes, fixed = (
        np.array(f.sizes, float),
        int(f.kind == "cone"),
    )  # a cone lies where it has its nominal diameter

    def pose(x: np.ndarray) -> np.ndarray:
        r = Rotation.from_rotvec(x[:k] / 50.0 @ turns) if k else Rotation.identity()
        return (r * start).apply(p) + x[k : k + 3]

    def cost(x: np.ndarray) -> np.ndarray:
        return distances(f, pose(x), np.concatenate([sizes[:fixed], sizes[fixed:] + x[k + 3 :]]))

    found = least_squares(cost, np.zeros(k + 3 + len(sizes) - fixed), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
    turn = Rotation.from_rotvec(found[:k] / 50.0 @ turns) if k else Rotation.identity()
    return turn * start, found[k : k + 3]


def truth(names: tuple[str, ...], points: dict[str, np.ndarray]) -> float:
    """Twice the way of the target from its place after the drawing is laid onto the datums in order."""
    turns, rotation, held, away = np.eye(3), Rotation.identity(), [], None

    def hold(axis: np.ndarray) -> np.ndarray:
        """What is left of the turns when the direction `axis` is held."""
        if len(turns) == 3:
            return axis[None]
        return turns if np.linalg.norm(np.cross(turns[0], axis)) < 0.02 else np.zeros((0, 3))

    for name in names:
        f = FEATURES[name]
        if f.kind not in ("sphere", "circle") and len(turns):
            over = hold(f.axis)
            if len(turns) == 3 or len(over) < len(turns):
                rotation, _ = laid(f, points[name], turns, rotation)
                turns = over
        if f.kind in ("sphere", "circle", "cylinder", "cone"):
            if away is not None and len(turns):
                first, drawn = FEATURES[away], middle(f) - middle(FEATURES[away])
                if len(turns) == 3 or np.linalg.norm(np.cross(turns[0], drawn)) > 1.0:
                    for _ in range(5):  # the way between them onto the drawn one
                        ends = [place(g, points[g.name], rotation, names) for g in (first, f)]
                        way = ends[1] - ends[0]
                        if len(turns) == 1:
                            flat = [v - (v @ turns[0]) * turns[0] for v in (way, drawn)]
                        else:
                            flat = [way, drawn]
                        flat = [v / np.linalg.norm(v) for v in flat]
                        rotation = Rotation.from_rotvec(np.cross(flat[0], flat[1])) * rotation
                    turns = hold(drawn / np.linalg.norm(drawn))
            away = away or name
        held.append(f)
    shift, free = np.zeros(3), np.eye(3)
    for f in held:
        _, wanted = laid(f, points[f.name], np.zeros((0, 3)), rotation)
        rows = held_rows(f, names)
        across = np.linalg.svd(rows, full_matrices=False)[2]
        basis = np.where(np.abs(across @ free) > 1e-6, across @ free, 0.0)
        shift = shift + free @ np.linalg.lstsq(basis, across @ (wanted - shift), rcond=1e-3)[0]
        _, size, right = np.linalg.svd(basis)
        free = free @ right[int((size > 1e-3).sum()) :].T
    assert free.shape[1] == 0
    _, target = laid(TARGET, points["target"], np.zeros((0, 3)), rotation)
    return float(2.0 * np.linalg.norm(shift - target))


def held_rows(f: Feature, names: tuple[str, ...]) -> np.ndarray:
    if f.kind == "plane":
        return f.axis[None]
    if f.kind == "line":
        return Y[None]  # the edge is one of the front
    if f.kind == "sphere" or (f.kind == "cone" and FEATURES[names[0]].kind != "plane"):
        return np.eye(3)
    u = np.cross(f.axis, [0.3, 0.5, 0.7])
    return np.array([u, np.cross(f.axis, u)]) / np.linalg.norm(u)


def middle(f: Feature) -> np.ndarray:
    if f.kind == "cone":
        return f.point
    return f.point + 0.5 * f.extent[0] * f.axis if f.extent else f.point


def place(f: Feature, p: np.ndarray, rotation: Rotation, names: tuple[str, ...]) -> np.ndarray:
    """Where the feature stands after the rotation, its place along an axis as drawn."""
    _, shift = laid(f, p, np.zeros((0, 3)), rotation)
    rows = held_rows(f, ("bore",))
    basis = np.linalg.svd(rows, full_matrices=False)[2]
    return middle(f) - basis.T @ (basis @ shift)


def value(names: tuple[str, ...], points: dict[str, np.ndarray], by_matrix: bool) -> float:
    c = Characteristic("c", "position", of=("target",), datums=names, zone=0.1)
    used = {n: FEATURES[n] for n in (*names, "target")}
    fitted = {
        n: gauss(f.kind, points[n], nominal_element(f), fixed_axis=f.axis if f.kind == "circle" else None)
        for n, f in used.items()
    }
    kept = constrained_features([c], used)
    if by_matrix:
        fitted |= {n: replace(fitted[n], moments=normal_matrix(fitted[n], points[n])) for n in kept}
        kept = frozenset()
    full = with_criteria([c], used, lambda n: points[n], fitted, pointed=kept)
    return float(evaluate(c, used, full))


@pytest.mark.parametrize("names", SYSTEMS, ids="-".join)
def test_a_datum_system_is_the_drawing_laid_onto_its_datums_in_order(names: tuple[str, ...]) -> None:
    """Datums out by 20 um: position of a perfect sphere, by the points, within what the ends of two iterations differ."""
    points = measured(np.random.default_rng(5), 0.02)
    right = truth(names, points)
    assert right > 0.005
    assert value(names, points, False) == pytest.approx(right, abs=2e-6)


@pytest.mark.parametrize("names", SYSTEMS, ids="-".join)
def test_the_linear_model_lays_it_there_too(names: tuple[str, ...]) -> None:
    """By the normal matrix of the free fits: right to the first order. Tilts of 0.1 mrad over 20 to 80 mm beside radii of 4 mm
    leave (8 um)^2 / 4 mm = 16 nm at most; without the matrix a datum turns about its point, and errs by um.
    """
    points = measured(np.random.default_rng(5), 0.002)
    assert value(names, points, True) == pytest.approx(truth(names, points), abs=1.6e-5)


BALL = feature("ball", "sphere", (0, 25, -10), (0, 0, 0), (5.0,))
TOP = feature("top", "plane", (0, 0, 0), Z, (), (80, 80))
B1, B2 = (feature(n, "cylinder", (x, 0, -20), Z, (5.0,), (20,)) for n, x in (("b1", -20), ("b2", 20)))
FRONT = feature("front", "plane", (0, -40, -10), -Y, (), (60, 20))
TURN = np.arange(24) * (2 * np.pi / 24)


def around(x: float, lean: float) -> np.ndarray:
    """A bore that leans along x by `lean` mm over 20 mm about its middle at z = -10; touched at -18, -10, -2."""
    rings = [
        (x + lean * (z + 10) / 20 + 5 * np.cos(TURN), 5 * np.sin(TURN), np.full(24, z))
        for z in (-18.0, -10.0, -2.0)
    ]
    return np.concatenate([np.column_stack(r) for r in rings])


def found(c: Characteristic, features: list[Feature], points: dict[str, np.ndarray]) -> float:
    named = {f.name: f for f in features}
    inside = {n: replace(f, inside=f.kind == "cylinder") for n, f in named.items()}
    fitted = {n: gauss(f.kind, points[n], nominal_element(f)) for n, f in named.items()}
    full = with_criteria([c], inside, lambda n: points[n], fitted, pointed=constrained_features([c], named))
    return float(evaluate(c, inside, full))


FLAT = surface_point(TOP, np.repeat([-35.0, 0.0, 35.0], 3), np.tile([-35.0, 0.0, 35.0], 3))
PERFECT = surface_point(BALL, np.tile(TURN, 3), np.repeat([-0.6, 0.0, 0.9], 24))


@pytest.mark.parametrize("criterion", ["G", "C", "N"])
def test_a_leaning_secondary_bore_stands_square_to_the_primary_plane(criterion: str) -> None:
    """The bore leans by 10 um, its middle is exact: it stands square there, and the ball is where the drawing has it."""
    c = Characteristic(
        "c", "position", of="ball", datums=("top", "b1", "b2"), datum_criterion=f"G {criterion} G", zone=0.1
    )
    points = {"top": FLAT, "b1": around(-20, 0.010), "b2": around(20, 0.0), "ball": PERFECT}
    assert found(c, [TOP, B1, B2, BALL], points) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(("criterion", "right"), [("G", 0.0), ("C", 0.0), ("T", 0.02)])
def test_a_leaning_secondary_plane_stands_square_to_the_primary_plane(criterion: str, right: float) -> None:
    """A front that leans by 1 mrad about its middle, over heights of +-10 mm: its lowest edge stands out by 10 um, which a tangent
    plane square to the top touches: the ball lies 10 um nearer to it than drawn, position 20 um; the middle is where it should be.
    """
    places = surface_point(FRONT, np.repeat([-30.0, 0.0, 30.0], 3), np.tile([-10.0, 0.0, 10.0], 3))
    front = places + np.outer(1e-3 * (places[:, 2] + 10.0), Y)
    side = feature("side", "plane", (50, 0, -10), X, (), (60, 20))
    points = {"top": FLAT, "front": front, "ball": PERFECT}
    points["side"] = surface_point(side, np.repeat([-25.0, 0.0, 25.0], 3), np.tile([-10.0, 0.0, 10.0], 3))
    c = Characteristic(
        "c",
        "position",
        of="ball",
        datums=("top", "front", "side"),
        datum_criterion=f"G {criterion} G",
        zone=0.1,
    )
    assert found(c, [TOP, FRONT, side, BALL], points) == pytest.approx(right, abs=1e-6)


def test_a_common_secondary_plane_stands_square_to_the_primary_plane() -> None:
    """Two pads of one front, both 1 mrad out of square about their middles."""
    left, right = (
        feature(n, "plane", (x, -40, -10), -Y, (), (10, 20)) for n, x in (("left", -25), ("right", 25))
    )
    points = {"top": FLAT, "ball": PERFECT, "b1": around(-20, 0.0)}
    for f in (left, right):
        places = surface_point(f, np.repeat([-5.0, 0.0, 5.0], 3), np.tile([-10.0, 0.0, 10.0], 3))
        points[f.name] = places + np.outer(1e-3 * (places[:, 2] + 10.0), Y)
    c = Characteristic("c", "position", of="ball", datums=("top", ("left", "right"), "b1"), zone=0.1)  # type: ignore[arg-type]
    assert found(c, [TOP, left, right, B1, BALL], points) == pytest.approx(0.0, abs=1e-6)


def test_a_runout_about_an_axis_that_a_plane_constrains() -> None:
    """Shoulder turned true about the middle of the leaning bore, square to the top: run-out 0 about top, bore; about the bore alone
    the axis at z = 10 lies 10 um / 20 mm x 20 mm = 10 um aside: 20 um.
    """
    shoulder = Feature("shoulder", "circle", np.array([-20.0, 0, 10]), Z, np.array([8.0]), False)
    ring = np.column_stack([-20 + 8 * np.cos(TURN), 8 * np.sin(TURN), np.full(24, 10.0)])
    points = {"top": FLAT, "b1": around(-20, 0.010), "shoulder": ring}
    for datums, right in ((("top", "b1"), 0.0), (("b1",), 0.02)):
        c = Characteristic("c", "circular_runout", of="shoulder", datums=datums, zone=0.1)
        used = [TOP, B1, shoulder] if len(datums) > 1 else [B1, shoulder]
        assert found(c, used, points) == pytest.approx(right, abs=1e-6)


@pytest.mark.parametrize("criterion", ["C", "N", "X"])
def test_an_axis_that_turns_about_one_direction_by_contact(criterion: str) -> None:
    """A shaft along x that leans by 1 mrad, with form; only turns about z are free. Beside scipy: largest or smallest radius, or zone,
    under the constraints of all points.
    """
    rng = np.random.default_rng(3)
    along, turn = np.repeat(np.linspace(-15, 15, 5), 24), np.tile(TURN, 5)
    radius = 5.0 + 2e-3 * np.cos(3 * turn + along) + 1e-3 * rng.uniform(-1, 1, along.size)
    points = np.column_stack([along, radius * np.cos(turn), radius * np.sin(turn) + 1e-3 * along])

    def apart(x: np.ndarray) -> np.ndarray:
        c, s = np.cos(x[0] * 1e-3), np.sin(x[0] * 1e-3)
        across = -s * points[:, 0] + c * points[:, 1] - x[1] * 1e-3
        return np.asarray(1e3 * (np.hypot(across, points[:, 2] - x[2] * 1e-3) - 5.0))  # um

    sign = -1.0 if criterion == "X" else 1.0
    bounds = [
        {"type": "ineq", "fun": lambda x: sign * (x[3] - apart(x)) + (x[4] if criterion == "C" else 0.0)}
    ]
    if criterion == "C":
        bounds.append({"type": "ineq", "fun": lambda x: x[4] + apart(x) - x[3]})
    goal = (lambda x: x[4]) if criterion == "C" else (lambda x: sign * x[3])
    best = minimize(
        goal, [0.1, 0.1, 0.1, sign * 20.0, 20.0], constraints=bounds, options={"ftol": 1e-12, "maxiter": 500}
    )
    base = gauss("cylinder", points)
    axis = at_angle(base.axis, Z, 0.0, 1.0)
    element = hold_axis(base, axis, Z, points, criterion)
    assert element.axis[2] == pytest.approx(0.0, abs=1e-12)
    if criterion == "C":
        assert 1e3 * np.ptp(element.residuals) / 2 == pytest.approx(best.x[4], abs=1e-3)
    else:
        assert 1e3 * (element.sizes[0] - 5.0) == pytest.approx(best.x[3], abs=1e-3)


@pytest.mark.parametrize("slip", [0.0, 1e-33, 1e-17, 1e-12, 1e-9, 1e-7, 1e-5])
def test_a_bore_that_stands_as_drawn_but_for_rounding_does_not_slip_along_its_axis(slip: float) -> None:
    """An axis off by 1e-33 made the way along it a shift that the points hold: it slipped by 1e12 mm, and U of a position was 2e15 um.

    Points at 3, 10 and 17 mm, their middle at 10 mm. The axis through (0, 0, 0) turns by 1e-4 towards x about that middle:
    at z = 0 it then lies at x = -10 x 1e-4 = -0.001 mm; the radius stays, and nothing moves along z.
    """
    axis = np.array([-slip, slip, 1.0]) / np.sqrt(1 + 2 * slip * slip)
    turn = 2 * np.pi * np.arange(12) / 12
    around_it = 15 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
    points = np.concatenate([around_it + [0, 0, z] for z in (3.0, 10.0, 17.0)])
    start = replace(nominal_element(feature("b", "cylinder", (0, 0, 0), Z, (15.0,), (20,))), axis=axis)
    base = replace(start, moments=normal_matrix(start, points))
    there = hold_axis(base, np.array([1e-4, 0.0, 1.0]))
    assert there.point == pytest.approx([-1e-3, 0.0, 0.0], abs=2e-3 * slip / 1e-4 + 1e-9)
    assert there.sizes == pytest.approx([15.0], abs=1e-6)
