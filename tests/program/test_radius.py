"""Cutter radius compensation: numbers made by hand, the distance law as a property, and LinuxCNC's own centre paths."""

from __future__ import annotations

import itertools
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import data_file
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.program.moves import ORIGIN, PLANES, Move, Source
from vcmm.program.radius import FANUC_B, LINUXCNC, SINUMERIK, RadiusCompensation, Style, centre_path

FANUC_A = Style("perpendicular", "lines")


def compensated(moves, sides, radii, style=LINUXCNC, nose=ORIGIN):
    """The path of the centre with a side (None: off) and a radius for each move."""
    rows = zip(sides, radii, strict=True)
    return centre_path(
        moves, [None if side is None else RadiusCompensation(side, r, style, nose) for side, r in rows]
    )


def line(start, end, n=1, kind="line", plane="XY", feed=100.0):
    return Move(
        kind, Source(n, 1, 2), start, end, plane=plane, feed=None if kind in ("rapid", "dwell") else feed
    )


def arc(start, end, centre, clockwise, n=1, plane="XY", turns=1):
    return Move(
        "arc", Source(n, 1, 2), start, end, plane=plane, centre=centre, clockwise=clockwise, turns=turns, feed=100.0
    )  # fmt: skip


def polyline(points, z=0.0):
    """Lines through (x, y) points, numbered from line 1."""
    xyz = [(float(x), float(y), z) for x, y in points]
    return [line(a, b, n + 1) for n, (a, b) in enumerate(itertools.pairwise(xyz))]


def ends(path):
    return np.array([m.end for m in path])


def test_square_from_outside_gets_arcs_at_its_corners():
    # left of the direction +y at x = 0, +x at y = 10: the tool of radius 2 stands at x = -2, then y = 12
    moves = polyline([(0, -10), (0, 10), (20, 10)])
    path = compensated(moves, ["left"] * 2, [2.0] * 2)
    assert [m.kind for m in path] == ["line", "arc", "line"]
    assert np.allclose(ends(path), [[-2, 10, 0], [0, 12, 0], [20, 12, 0]], atol=1e-12)
    assert path[1].centre == (0.0, 10.0, 0.0)
    assert path[1].clockwise
    assert path[1].source.line == 2
    assert path[1].feed == 100.0
    assert {m.compensation for m in path} == {"left"}


def test_inside_corner_is_the_intersection():
    # lines y = 0 and x = 20, tool of radius 3 on the left, inside: the corner of the centre path is (17, 3)
    moves = polyline([(-10, 0), (0, 0), (20, 0), (20, 30)])
    path = compensated(moves, ["left"] * 3, [3.0] * 3)
    assert np.allclose(ends(path), [[0, 3, 0], [17, 3, 0], [17, 30, 0]], atol=1e-12)


def test_arcs_shrink_inside_and_grow_outside():
    # contour: line along +x, then a quarter counterclockwise about (10, 5) with R = 5; on the left R - 2, on the right R + 2
    moves = [
        line((-5, 0, 0), (0, 0, 0)),
        line((0, 0, 0), (10, 0, 0)),
        arc((10, 0, 0), (15, 5, 0), (10, 5, 0), False),
    ]
    for side, y, x in (("left", 2.0, 13.0), ("right", -2.0, 17.0)):
        path = compensated(moves, [side] * 3, [2.0] * 3)
        assert np.allclose(ends(path), [[0, y, 0], [10, y, 0], [x, 5, 0]], atol=1e-12)
        assert path[2].centre == (10, 5, 0)


def test_line_into_arc_inside_corner():
    # line y = 0 to (0, 0), then clockwise about (5, 0), R = 5, from heading +x to heading +y: inside on the left.
    # offset: y = 1 and the circle of radius 5 + 1: x = 5 - sqrt(36 - 1) = -0.916079783
    moves = [
        line((-9, 0, 0), (-8, 0, 0)),
        line((-8, 0, 0), (0, 0, 0)),
        arc((0, 0, 0), (5, 5, 0), (5, 0, 0), True),
    ]
    path = compensated(moves, ["left"] * 3, [0.9] * 3)
    # with radius 0.9: x = 5 - sqrt(5.9^2 - 0.9^2) = 5 - sqrt(34.0) = -0.830951895
    assert np.allclose(path[1].end, (5 - math.sqrt(34.0), 0.9, 0), atol=1e-12)
    assert np.allclose(path[2].end, (5, 5.9, 0), atol=1e-12)


def test_arc_into_arc_inside_corner():
    # two half circles of radius 5 that meet in (0, 0) as a W; centres (-5, 0) and (5, 0), both clockwise, tool above,
    # left; offset circles of radius 6 meet on x = 0 at y = sqrt(36 - 25) = sqrt(11)
    moves = [
        line((-10, -9, 0), (-10, 0, 0)), arc((-10, 0, 0), (0, 0, 0), (-5, 0, 0), True),
        arc((0, 0, 0), (10, 0, 0), (5, 0, 0), True),
    ]  # fmt: skip
    path = compensated(moves, ["left"] * 3, [1.0] * 3)
    assert np.allclose(ends(path), [[-11, 0, 0], [0, math.sqrt(11), 0], [11, 0, 0]], atol=1e-12)


def test_entry_of_the_three_styles_at_an_outside_corner():
    # entry along +x to (0, 0), contour then along -y: outside corner of 90 deg for the left, radius 2.
    # linuxcnc: (0, 2), arc to (2, 0). Type A: straight to (2, 0). Type B: the intersection (2, 2), no way round.
    moves = polyline([(-10, 0), (0, 0), (0, -10)])
    got = {s: ends(compensated(moves, ["left"] * 2, [2.0] * 2, s)) for s in (LINUXCNC, FANUC_A, FANUC_B)}
    assert np.allclose(got[LINUXCNC], [[0, 2, 0], [2, 0, 0], [2, -10, 0]], atol=1e-12)
    assert np.allclose(got[FANUC_A], [[2, 0, 0], [2, -10, 0]], atol=1e-12)
    assert np.allclose(got[FANUC_B], [[2, 2, 0], [2, -10, 0]], atol=1e-12)


def test_entry_at_an_inside_corner():
    # entry along +x to (0, 0), then +y: inside on the left. linuxcnc: intersection (-2, 2); both Fanuc types: (-2, 0)
    moves = polyline([(-10, 0), (0, 0), (0, 10)])
    got = {s: ends(compensated(moves, ["left"] * 2, [2.0] * 2, s)) for s in (LINUXCNC, FANUC_A, FANUC_B)}
    assert np.allclose(got[LINUXCNC][0], [-2, 2, 0], atol=1e-12)
    for style in (FANUC_A, FANUC_B):
        assert np.allclose(got[style][0], [-2, 0, 0], atol=1e-12)


def test_sharp_corner_with_lines_is_cut_off_across():
    # direction +x, then back by 135 deg to (-1, -1)/sqrt 2, tool of radius 1 on the left: one radius beyond each
    # perpendicular: (10 + 1, 1), then (10, 0) + (-0.7071, 0.7071) n with n = (0.7071, -0.7071) minus the direction
    moves = polyline([(-5, 0), (0, 0), (10, 0), (0, -10)])
    path = compensated(moves, ["left"] * 3, [1.0] * 3, FANUC_A)
    s = math.sqrt(0.5)
    assert np.allclose(ends(path), [[0, 1, 0], [11, 1, 0], [10 + 2 * s, 0, 0], [s, -10 - s, 0]], atol=1e-12)


def test_exit_and_what_follows():
    moves = polyline([(-5, 0), (0, 0), (10, 0), (20, 10)])
    moves.insert(3, line((10, 0, 0), (10, 0, 5), 9))
    sides = ["left", "left", None, None]
    moves = [moves[0], moves[1], moves[3], moves[2]._replace(start=(10, 0, 5), end=(20, 10, 5))]
    expected = {
        "linuxcnc": [[0, 1, 0], [10, 1, 0], [10, 0, 5], [20, 10, 5]],  # any first move takes the offset off
        "perpendicular": [[0, 1, 0], [10, 1, 0], [10, 1, 5], [20, 10, 5]],  # the first one in the plane does
    }
    for entry, points in expected.items():
        path = compensated(moves, sides, [1.0] * 4, Style(entry))
        assert np.allclose(ends(path), points, atol=1e-12)
        assert [m.compensation for m in path] == ["left", "left", None, None]
        assert all(a.end == b.start for a, b in itertools.pairwise(path))


def test_type_b_leaves_around_an_outside_corner():
    # contour along +x to (10, 0), exit along -y: outside for the left; type B runs on to (11, 1), type A leaves from (10, 1)
    moves = polyline([(-5, 0), (0, 0), (10, 0), (10, -20)])
    sides = ["left", "left", None]
    b = ends(compensated(moves, sides, [1.0] * 3, FANUC_B))
    a = ends(compensated(moves, sides, [1.0] * 3, FANUC_A))
    assert np.allclose(b[1:], [[11, 1, 0], [10, -20, 0]], atol=1e-12)
    assert np.allclose(a[1:], [[10, 1, 0], [10, -20, 0]], atol=1e-12)


def test_negative_radius_is_the_other_side():
    moves = polyline([(0, -10), (0, 10), (20, 10), (25, 0)])
    one = compensated(moves, ["left"] * 3, [2.0] * 3)
    two = compensated(moves, ["right"] * 3, [-2.0] * 3)
    assert np.array_equal(ends(one), ends(two))


def test_zero_radius_changes_nothing():
    moves = polyline([(0, -10), (0, 10), (20, 10)])
    path = compensated(moves, ["left"] * 2, [0.0] * 2)
    assert [m._replace(compensation=None) for m in path] == moves


def test_helix_keeps_its_height_and_plunges_are_carried():
    # a plunge between entry and contour, then a helix of one and a half turns inside a bore of R = 10, tool radius 4
    moves = [
        line((0, 0, 0), (0, -10, 0)), line((0, -10, 0), (0, -10, -1)),
        arc((0, -10, -1), (0, 10, -4), (0, 0, -1), False, turns=2),
    ]  # fmt: skip
    path = compensated(moves, ["left"] * 3, [4.0] * 3, SINUMERIK)
    assert np.allclose(ends(path), [[0, -6, 0], [0, -6, -1], [0, 6, -4]], atol=1e-12)
    assert path[2].turns == 2
    assert np.allclose(path[2].centre, (0, 0, -1))


@pytest.mark.parametrize("plane", ["XY", "ZX", "YZ"])
def test_the_same_in_every_plane(plane):
    moves = polyline([(0, -10), (0, 10), (20, 10)], z=7.0)
    flat = ends(compensated(moves, ["left"] * 2, [2.0] * 2))
    k = PLANES[plane]

    def turned(p):
        out = [0.0] * 3
        for axis, value in zip(k, p):
            out[axis] = value
        return tuple(out)

    there = [m._replace(start=turned(m.start), end=turned(m.end), plane=plane) for m in moves]
    path = compensated(there, ["left"] * 2, [2.0] * 2)
    assert np.allclose(ends(path)[:, k], flat, atol=1e-12)


def test_lathe_nose_set_at_its_imaginary_tip():
    # ZX plane, nose radius 0.8, imaginary tip towards -X -Z: shift (-0.8, 0, -0.8). Turning along -Z at X = 20 with the
    # tool on the right, the outside (+X): the centre is at X 20.8, the controlled point at X 20, as without compensation.
    # A facing cut along -X at Z = 0, tool on the +Z side: the centre at Z 0.8, the controlled point at Z 0.
    shift = (-0.8, 0.0, -0.8)
    outside = [
        line((30, 0, 5), (20, 0, 2), plane="ZX"), line((20, 0, 2), (20, 0, -30), plane="ZX"),
    ]  # fmt: skip
    path = compensated(outside, ["right"] * 2, [0.8] * 2, Style("perpendicular"), shift)
    assert np.allclose(path[0].end, (20, 0, 2 - 0.8), atol=1e-12)
    assert np.allclose(path[1].end, (20, 0, -30.8), atol=1e-12)
    # a 45 deg chamfer: the controlled point lies beside it by 0.8 (sqrt 2 - 1) ... (X, Z) = (P + 0.8 n - 0.8 (1, 1))
    chamfer = [line((18, 0, 5), (18, 0, 2), plane="ZX"), line((18, 0, 2), (20, 0, 0), plane="ZX")]
    path = compensated(chamfer, ["right"] * 2, [0.8] * 2, Style("perpendicular"), shift)
    n = 0.8 * math.sqrt(0.5)
    assert np.allclose(path[1].end, (20 + n - 0.8, 0, 0 + n - 0.8), atol=1e-12)


@pytest.mark.parametrize(
    ("moves", "sides", "radius", "what"),
    [
        (polyline([(0, 0), (1, 0), (9, 0)]), ["left"] * 2, 1.5, r"line 1: the lead-in of 1 mm is not longer"),
        (polyline([(-9, 0), (0, 0), (1, 0), (1, 1.5), (9, 1.5)]), ["right", "right", "right", "right"], 2, "line 3: .*gouging"),
        (polyline([(-9, 0), (0, 0), (9, 0), (18, 0)]), ["left", "left", "right"], 1, "line 3: the side changes"),
        (
            [*polyline([(-9, 0), (0, 0)]), arc((0, 0, 0), (0, 2, 0), (0, 1, 0), False, 7)],
            ["left"] * 2, 1.0, "line 7: an inside arc of radius 1 mm",
        ),
        ([arc((0, 0, 0), (0, 20, 0), (0, 10, 0), False, 3)], ["left"], 1.0, "line 3: radius compensation begins with an arc"),
        (
            [*polyline([(-9, 0), (0, 0)]), arc((0, 0, 0), (0, 2, 0), (0, 1, 0), False, 7)],
            ["left", None], 1.0, "line 7: the first move after",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_refused(moves, sides, radius, what):
    with pytest.raises(ModelLimit, match=what):
        compensated(moves, sides, [radius] * len(moves))


def test_wrong_words_are_refused():
    with pytest.raises(UsageError, match="linuxcnc, perpendicular, along"):
        Style("type C")
    with pytest.raises(UsageError, match='"up"'):
        compensated(polyline([(0, 0), (9, 0)]), ["up"], [1.0])


# The distance law: every point of the centre path is at the radius from the programmed contour, none is closer.


def sampled(move, n=60):
    t = np.linspace(0.0, 1.0, n)
    if move.kind != "arc":
        return np.outer(1 - t, move.start[:2]) + np.outer(t, move.end[:2])
    centre = np.array(move.centre[:2])
    a, b = (np.array(p[:2]) - centre for p in (move.start, move.end))
    begin, sweep = math.atan2(a[1], a[0]), math.atan2(a[0] * b[1] - a[1] * b[0], a @ b)
    sign = -1.0 if move.clockwise else 1.0
    sweep = sign * (sign * sweep % (2 * math.pi)) or sign * 2 * math.pi
    # the radius at the end must be that at the start
    assert abs(np.hypot(*a) - np.hypot(*b)) < 1e-9
    angle = begin + t * sweep
    return centre + np.hypot(*a) * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def distances(points, move):
    """Distance of points (n, 2) from a programmed move, closed form."""
    p, q = np.array(move.start[:2]), np.array(move.end[:2])
    if move.kind != "arc":
        t = np.clip((points - p) @ (q - p) / ((q - p) @ (q - p)), 0, 1)
        return np.hypot(*(points - p - t[:, None] * (q - p)).T)
    centre = np.array(move.centre[:2])
    r = np.hypot(*(p - centre))
    sign = -1.0 if move.clockwise else 1.0
    angle = np.arctan2(*(points - centre).T[::-1]) - math.atan2(*(p - centre)[::-1])
    whole = (
        sign * (math.atan2(*(q - centre)[::-1]) - math.atan2(*(p - centre)[::-1])) % (2 * math.pi)
        or 2 * math.pi
    )
    inside = sign * angle % (2 * math.pi) <= whole
    ends_only = np.minimum(np.hypot(*(points - p).T), np.hypot(*(points - q).T))
    return np.where(inside, np.abs(np.hypot(*(points - centre).T) - r), ends_only)


@st.composite
def contours(draw):
    """A contour that winds slowly forwards: lines and arcs of 20 to 40 mm, turns of at most 100 deg, no narrow places."""
    here = (0.0, 0.0)
    moves = [line((-20.0, 0.0, 0.0), (0.0, 0.0, 0.0), 1)]
    for n in range(draw(st.integers(1, 6))):
        wanted = draw(st.floats(-0.9, 0.9))  # heading stays within +-0.9 rad of +x: no narrow places
        if draw(st.booleans()):
            length = draw(st.floats(20, 40))
            end = (here[0] + length * math.cos(wanted), here[1] + length * math.sin(wanted))
            moves.append(line((*here, 0.0), (*end, 0.0), n + 2))
        else:  # an arc from one heading to another
            after = draw(st.floats(-0.9, 0.9))
            if abs(after - wanted) < 0.2:
                after = wanted + 0.4 if wanted < 0 else wanted - 0.4
            r = draw(st.floats(60, 90))
            s = 1.0 if after > wanted else -1.0
            centre = (here[0] - s * r * math.sin(wanted), here[1] + s * r * math.cos(wanted))
            end = (centre[0] + s * r * math.sin(after), centre[1] - s * r * math.cos(after))
            moves.append(arc((*here, 0.0), (*end, 0.0), (*centre, 0.0), s < 0, n + 2))
        here = end
    return moves


@settings(max_examples=150, deadline=None)
@given(contours(), st.sampled_from(["left", "right"]), st.floats(0.5, 5.0))
def test_every_point_is_at_the_radius_and_none_is_closer(moves, side, radius):
    path = compensated(moves, [side] * len(moves), [radius] * len(moves))
    assert all(a.end == b.start for a, b in itertools.pairwise(path))
    points = np.concatenate([sampled(m) for m in path[1:]])
    nearest = np.min([distances(points, m) for m in moves], axis=0)
    assert np.max(np.abs(nearest - radius)) < 1e-9


# LinuxCNC's own centre paths.

WORD = re.compile(r"([A-Z])\s*([-+]?[\d.]+)")


def programmed(path: Path, tools):
    """Moves, sides and radii of a plain G-code file: just enough of a reader for the three reference programs."""
    scale, here, motion, side, plane, tool, called = 1.0, [0.0] * 3, 0, None, "XY", 0, 0
    out = []
    for n, text in enumerate(path.read_text().splitlines(), 1):
        words, skip = {}, False
        for letter, value in WORD.findall(re.sub(r"\(.*?\)", "", text).upper()):
            number = float(value)
            if letter == "G":
                scale = {20: 25.4, 21: 1.0}.get(number, scale)
                plane = {17: "XY", 18: "ZX"}.get(number, plane)
                side = {40: None, 41: "left", 42: "right"}.get(number, side)
                motion = number if number in (0, 1, 2, 3) else motion
                skip = skip or number == 28
            elif letter == "T":
                called = int(number)
            elif letter == "M" and number == 6:
                tool = called
            else:
                words[letter] = number if letter in "NH" else number * scale
        if skip or not set(words) & set("XYZIJKR"):
            continue
        end = [words.get(c, here[k]) for k, c in enumerate("XYZ")]
        centre = _centre(here, end, words, PLANES[plane], motion == 3) if motion > 1 else None
        move = Move(
            {0: "rapid", 1: "line"}.get(motion, "arc"), Source(n, 1, 2), tuple(here), tuple(end), plane=plane,
            centre=centre, clockwise=None if centre is None else motion == 2, feed=100.0 if motion else None,
        )  # fmt: skip
        out.append((move, side, tools.get(tool, 0.25)))
        here = end
    return zip(*out)


def _centre(here, end, words, plane, ccw):
    a, b, normal = plane
    centre = [p + words.get(c, 0.0) for p, c in zip(here, "IJK")]
    centre[normal] = here[normal]
    if "R" in words:
        dx, dy = end[a] - here[a], end[b] - here[b]
        chord = math.hypot(dx, dy)
        h = math.sqrt(max(0.0, words["R"] ** 2 - chord**2 / 4)) * (1 if ccw else -1)
        centre[a], centre[b] = here[a] + dx / 2 - h * dy / chord, here[b] + dy / 2 + h * dx / chord
    return tuple(centre)


@pytest.mark.parametrize(
    "program",
    [
        "gpl_test_only/linuxcnc_comp_g1.ngc",
        "gpl_test_only/linuxcnc_lathecomp.ngc",
        "mit/autodesk_hsm_fanuc_mill.nc",
    ],
)
def test_linuxcnc_agrees(program):
    moves, sides, radii = programmed(data_file(f"data/nc/{program}"), {1: 5.0, 2: 3.0, 3: 1.5})
    expected = json.loads(data_file(f"data/nc/expected_rs274/{Path(program).name}.json").read_text())[
        "events"
    ]
    path = compensated(moves, sides, radii)
    compared = 0
    for n in sorted({m.source.line for m in path if m.compensation}):
        mine = [m for m in path if m.source.line == n]
        theirs = [e for e in expected if e[1] == n and e[0] in "TFA"]
        assert len(mine) == len(theirs), n
        for move, event in zip(mine, theirs):
            assert _gap(move, event) < 1e-6, (n, move, event)
            compared += 1
    assert compared >= 8


def _gap(move, event):
    if event[0] != "A":
        return max(abs(p - q) for p, q in zip(move.end, event[2]))
    a, b, _ = PLANES[move.plane]
    assert move.clockwise == (event[2][4] < 0)
    mine = (move.end[a], move.end[b], move.centre[a], move.centre[b])
    return max(abs(p - q) for p, q in zip(mine, event[2]))
