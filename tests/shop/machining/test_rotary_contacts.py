"""Rotary axes that turn while the tool cuts: grooves by hand, and everything against a brute force of dense transforms."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import rotary_shop as rs
from vcmm.core.errors import ModelLimit
from vcmm.shop.cutting.envelope import CUT
from vcmm.shop.machining.contact_path import surface_at, tool_side
from vcmm.shop.machining.job import cut

ELSEWHERE = 'work_offset = { set_on = "elsewhere" }'
ROLL = "w A' X' Y' b Z t"  # the part turns about X, Z of the spindle leads to its axis
GROOVE = "G0 A0 X0 Y0\nG43 H1 Z60.\nG1 Z20. F300\nG1 A360. F3600\nG0 Z60.\n"


def roll(effects: str = "") -> str:
    return rs.machine(ROLL, rs.axis("A") + effects)


def floor(at: float, radius: float) -> str:
    return f'groove = {{ type = "cylinder", point = "{at} 0 0 mm", axis = [1, 0, 0], diameter = "{2 * radius:.9f} mm", length = "0.2 mm" }}\n'


def test_a_groove_around_a_cylinder_is_round(tmp_path):
    # the flat bottom at 20 mm from the axis: whatever of the disc passes a point, its middle line is nearest: radius 20 mm
    path = rs.write(tmp_path, roll(), GROOVE, floor(0.5, 20.0), 'diameter = "6 mm"\n')
    found = rs.patches(path)["groove"].height
    assert np.abs(found).max() < 1e-9
    # ball of 3 mm with its tip at 20 mm: 1 mm beside the middle of the groove a torus of 23 - sqrt(9 - 1) = 20.1716 mm
    path = rs.write(
        tmp_path, roll(), GROOVE, floor(1.0, 23 - np.sqrt(8)), 'diameter = "6 mm"\nshape = "ball"\n'
    )
    patch = rs.patches(path)["groove"]
    x = patch.net.points[:, 0]
    assert patch.height == pytest.approx(23 - np.sqrt(9 - x**2) - (23 - np.sqrt(8)), abs=1e-9)


def test_the_share_of_a_turning_move_tells_the_angle(tmp_path):
    shop = rs.shop_of(
        rs.write(tmp_path, roll(), GROOVE, floor(0.5, 20.0), 'diameter = "6 mm"\nshape = "ball"\n')
    )
    angle = np.array([0.4, 1.7, 3.0, 5.9])
    normals = np.stack([np.zeros(4), -np.sin(angle), np.cos(angle)], axis=1)
    found = surface_at(shop, 20.0 * normals, normals)
    tool, contacts = tool_side(shop, found, np.array(list("abcd")), np.array(["groove"] * 4))
    row = contacts.row[:, 0]
    # A turns the part by -q, so the tool meets the part at +q about X: (0, -sin q, cos q)
    assert tool.run.q("A")[row] == pytest.approx(angle, abs=1e-6)
    assert tool.run.q("Z")[row] == pytest.approx(np.full(4, -400 + 20 + 100.0))
    # F3600 is in degrees per minute where A moves alone: 60 deg/s; time runs with the angle
    assert np.diff(tool.run.columns["time_s"][row]) == pytest.approx(
        np.diff(np.degrees(angle)) / 60, rel=1e-3
    )
    assert tool.run.columns["speed_A_rad_s"][row] == pytest.approx(np.full(4, np.pi / 3), rel=1e-6)
    assert tool.run.tip[row] == pytest.approx(shop.pose.apply(20.0 * normals), abs=1e-9)


def test_a_table_centre_too_near_makes_the_groove_deep(tmp_path):
    near = '[[effects]]\neffect = "rotary_location"\ncomponent = "Z0A"\noffset = "5 um"\n'
    path = rs.write(tmp_path, roll(near), GROOVE, floor(0.5, 20.0), 'diameter = "6 mm"\n', ELSEWHERE)
    # the part 5 um nearer to the spindle all round: 5 um deeper
    assert rs.patches(path)["groove"].height * 1e3 == pytest.approx(-5.0, abs=1e-4)
    eccentric = '[[effects]]\neffect = "rotary_cyclic"\ncomponent = "EZA"\ncoefficients = ["4 um", "0 um"]\n'
    path = rs.write(tmp_path, roll(eccentric), GROOVE, floor(0.5, 20.0), 'diameter = "6 mm"\n', ELSEWHERE)
    patch = rs.patches(path)["groove"]
    _, y, z = patch.net.points.T
    # the part moves by 4 cos q along its own z; along the radius at q that is 4 cos^2 q nearer to the tool: deeper
    assert patch.height * 1e3 == pytest.approx(-4.0 * (z / np.hypot(y, z)) ** 2, abs=5e-3)


# ------------------------------------------------------------------------------- brute force
FIVE = "w C' A' X' Y' b Z t"
RADIUS = 4.0
# five axes at once over the top of a part that tilts and turns: lines and an arc, with A and C in every block
SIMULTANEOUS = """\
G0 X-12. Y-8. A4. C-10.
G43 H1 Z60.
G0 Z12.
G1 Z2. F500
G1 X14. Y-2. Z3. A16. C12. F500
G1 X-10. Y5. Z1. A-6. C-20.
G2 X-10. Y-6. I0 J-5.5 A9. C5.
G1 Z20.
G0 Z60.
"""
MOVES = [  # X Y Z A C from line to line, deg; the arc apart
    ((-12, -8, 2, 4, -10), (14, -2, 3, 16, 12)),
    ((14, -2, 3, 16, 12), (-10, 5, 1, -6, -20)),
]
ARC = ((-10, 5, 1, -6, -20), (-10, -6, 1, 9, 5), (-10, -0.5))
CENTRE_A, CENTRE_C = np.array([2.0, 3.0, -430.0]), np.array([1.0, -2.0, -410.0])
LENGTH, ZERO = 100.0, np.array([0.0, 0.0, -400.0])


def homogeneous(rotation: np.ndarray, centre: np.ndarray, shift: np.ndarray) -> np.ndarray:
    """(k, 4, 4): turn about a centre, then shift (k, 3)."""
    out = np.tile(np.eye(4), (len(rotation), 1, 1))
    out[:, :3, :3], out[:, :3, 3] = rotation, centre - rotation @ centre + shift
    return out


def part_from_tool(q: np.ndarray, errors: dict[str, np.ndarray]) -> np.ndarray:
    """(k, 4, 4) by multiplying one matrix per axis, written out for this machine; q (k, 5): X Y Z A C of the axes, mm and rad.

    errors: six numbers of each table axis' own motion (A, C), about its centre, after its turn.
    """
    k, nothing = len(q), np.zeros((len(q), 3))
    still = np.tile(np.eye(3), (k, 1, 1))
    tool = homogeneous(still, np.zeros(3), q[:, [2]] * [0, 0, 1])
    work = homogeneous(still, np.zeros(3), -q[:, :2] @ np.eye(3)[:2])  # carries the table by -q
    for i, letter, centre in ((3, "A", CENTRE_A), (4, "C", CENTRE_C)):
        turn = np.moveaxis(rs.about(letter, -q[:, i]), -1, 0)
        work = work @ homogeneous(turn, centre, nothing)
        t, r = errors.get(letter, np.zeros(6))[:3], errors.get(letter, np.zeros(6))[3:]
        small = np.eye(3) + np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
        work = work @ homogeneous(np.tile(small, (k, 1, 1)), centre, nothing + t)
    return np.linalg.inv(work) @ tool


def axes_at(way: int, u: np.ndarray) -> np.ndarray:
    """Axis positions (k, 5) at shares u of one of the feed moves; the arc is half a turn, clockwise."""
    start, end, *middle = (*MOVES, ARC)[way]
    q = np.array(start, float) + u[:, None] * (np.array(end, float) - np.array(start, float))
    if middle:
        (cx, cy), radius = middle[0], 5.5
        q[:, 0], q[:, 1] = cx + radius * np.sin(np.pi * u), cy + radius * np.cos(np.pi * u)
    q[:, :3] += ZERO + [0, 0, LENGTH]
    q[:, 3:] = np.radians(q[:, 3:])
    return q


def entries(frames: np.ndarray, p: np.ndarray, n: np.ndarray, ball: bool) -> np.ndarray:
    """s (k,) at which a ray enters the tool in poses (k, 4, 4): sphere, or cylinder with a flat end; inf where it misses."""
    tip = frames[:, :3, 3] + frames[:, :3, :3] @ np.array([0, 0, -LENGTH])
    axis = frames[:, :3, 2]
    with np.errstate(invalid="ignore", divide="ignore"):
        if ball:
            d = p - (tip + RADIUS * axis)
            b, c = d @ n, (d * d).sum(axis=1) - RADIUS**2
            s = -b - np.sqrt(b * b - c)
        else:
            d = p - tip
            h, hn = (d * axis).sum(axis=1), axis @ n
            across, way = d - h[:, None] * axis, n - hn[:, None] * axis
            a, b, c = (
                (way * way).sum(axis=1),
                (across * way).sum(axis=1),
                (across * across).sum(axis=1) - RADIUS**2,
            )
            root = np.sqrt(b * b - a * c)
            s = np.maximum((-b - root) / a, -h / hn)
            s = np.where((hn > 0) & (s <= (-b + root) / a), s, np.inf)
    return np.where(np.isnan(s), np.inf, s)


def brute(points: np.ndarray, normals: np.ndarray, ball: bool, errors: dict[str, np.ndarray]) -> np.ndarray:
    """Lowest s (n,) over 4001 poses of each feed move, then over ever closer poses about the lowest of each."""
    u = np.linspace(0, 1, 4001)
    dense = [part_from_tool(axes_at(way, u), errors) for way in range(3)]
    out = np.full(len(points), np.inf)
    for i, (p, n) in enumerate(zip(points, normals)):
        for way in range(3):
            at, step = u[np.argmin(entries(dense[way], p, n, ball))], 1 / 4000
            for _ in range(4):
                close = np.clip(at + np.linspace(-step, step, 41), 0, 1)
                s = entries(part_from_tool(axes_at(way, close), errors), p, n, ball)
                at, step, out[i] = close[np.argmin(s)], step / 20, min(out[i], s.min())
    return out


def five(effects: str = "") -> str:
    words = {a: " ".join(str(v) for v in c) for a, c in (("A", CENTRE_A), ("C", CENTRE_C))}
    return rs.machine(FIVE, rs.axis("A", words["A"]) + rs.axis("C", words["C"]) + effects)


def rays(seed: int, count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points about the top of the part with normals up to 20 deg from Z, machine axes with rotary axes at zero."""
    rng = np.random.default_rng(seed)
    points = np.column_stack(
        [rng.uniform(-12, 12, count), rng.uniform(-6, 4, count), rng.uniform(1, 3, count)]
    )
    tilt, turn = rng.uniform(0, 0.35, count), rng.uniform(0, 2 * np.pi, count)
    normals = np.column_stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt)])
    return points, normals


@pytest.mark.parametrize("ball", [True, False])
def test_simultaneous_motion_against_dense_transforms(tmp_path, ball):
    tool = 'diameter = "8 mm"\n' + ('shape = "ball"\n' if ball else "")
    shop = rs.shop_of(rs.write(tmp_path, five(), SIMULTANEOUS, floor(0, 1), tool))
    points, normals = rays(1, 40)
    points = points + [0, 0, -2.0 if ball else 0.0]
    found = surface_at(shop, points, normals)
    at = shop.pose.apply(points)
    assert shop.pose.shift is not None
    expected = brute(at, normals, ball, {})
    good = (
        (found.status == CUT)
        & np.isfinite(expected)
        & (found.s > -0.4)
        & (expected > -0.4)
        & (expected < 1.9)
    )
    assert good.sum() > 8
    assert np.abs(found.s - expected)[good].max() < 1e-7


def test_errors_of_turning_tables_against_dense_transforms(tmp_path):
    own = {
        "A": np.array([3e-3, -2e-3, 4e-3, 2e-5, -3e-5, 1e-5]),
        "C": np.array([-2e-3, 5e-3, 1e-3, 1e-5, 2e-5, -4e-5]),
    }
    effects = "".join(
        f'[[effects]]\neffect = "component_polynomial"\ncomponent = "E{c}{a}"\ncoefficients = ["{v * (1e3 if i < 3 else 1e6):.9g} {"um" if i < 3 else "urad"}"]\n'
        for a, six in own.items()
        for i, (c, v) in enumerate(zip("XYZABC", six))
    )
    tool = 'diameter = "8 mm"\nshape = "ball"\n'
    shop = rs.shop_of(rs.write(tmp_path, five(effects), SIMULTANEOUS, floor(0, 1), tool, ELSEWHERE))
    points, normals = rays(2, 40)
    points = points - [0, 0, 2.0]
    found = surface_at(shop, points, normals)
    at = shop.pose.apply(points)
    expected = brute(at, normals, True, own)
    kept = np.flatnonzero((found.status == CUT) & (found.s > -0.4) & (expected < 1.9))
    assert len(kept) > 8
    again = surface_at(shop, points[kept], normals[kept])
    tool_, contacts = tool_side(shop, again, np.array([f"p{i}" for i in kept]), np.full(len(kept), "f"))
    height = contacts.surface(tool_.errors() - tool_.known_error)  # the brute force rounds no corners
    # rotations of 40 urad on levers of 450 mm: errors of 20 um; their second order is 20^2 / 2 R = 0.05 um along the path
    assert np.abs(height - again.s).max() > 5e-3
    assert np.abs(height - expected[kept]).max() < 1e-4


@pytest.mark.thorough
def test_a_turned_groove_end_to_end(tmp_path):
    near = '[[effects]]\neffect = "rotary_location"\ncomponent = "Z0A"\noffset = "5 um"\n'
    inputs = '[[inputs]]\neffect = "rotary_location"\ncomponent = "Z0A"\nparameter = "offset"\nu = "2 um"\n'
    more = '[[part.characteristics]]\nname = "diameter"\ntype = "size"\nof = "groove"\nlimits = ["-0.02 mm", "0.02 mm"]\n'
    tool = 'diameter = "6 mm"\nshape = "ball"\n'
    feature = floor(-0.1, 20.0).replace("0.2 mm", "0.0002 mm").replace('"-0.1 0 0', '"-0.0001 0 0')
    path = rs.write(tmp_path, roll(near + inputs), GROOVE, feature, tool, ELSEWHERE, more)
    found = cut(vcmm.load_cut(path))
    (size,) = found.characteristics
    # 5 um deeper all round: 10 um of diameter; u = 2 x 2 um
    assert size.value == pytest.approx(40.0 - 0.010, abs=1e-6)
    assert size.u == pytest.approx(4e-3, rel=1e-3)
    assert size.linear_error < 1e-6  # mm, against transforms multiplied in every trial
    assert found.recut is not None
    assert found.recut.largest < 1e-5


def test_a_table_that_turns_inside_the_part_is_found(tmp_path):
    crash = "G0 A0 X0 Y0\nG43 H1 Z60.\nG1 Z20. F300\nG0 Z5.\nG0 A90.\nG0 Z60.\n"
    shop = rs.shop_of(rs.write(tmp_path, roll(), crash, floor(0.5, 20.0), 'diameter = "6 mm"\n'))
    normal = np.array([[0, -np.sqrt(0.5), np.sqrt(0.5)]])
    found = surface_at(shop, 20 * normal, normal)
    # the rapid turns with the tip at 5 mm from the axis: 15 mm below the floor at A = 45 deg, by line 10 of the program
    assert found.s == pytest.approx([-15.0], abs=1e-9)
    assert shop.program.moves[int(shop.sweep.move[found.row[0, 0]])].source.line == 10


def test_a_feed_that_turns_deep_inside_the_part_is_refused_with_its_line(tmp_path):
    deep = "G0 A0 X0 Y0\nG43 H1 Z60.\nG1 Z2. F300\nG1 A90. F3600\nG0 Z60.\n"
    path = rs.write(tmp_path, roll(), deep, floor(0.5, 20.0), 'diameter = "6 mm"\n')
    with pytest.raises(ModelLimit, match=r"rotary axis turns while the tool is in the part.*line 9"):
        rs.patches(path)
