"""What holds for every program: inches and millimetres, absolute and incremental, centre and radius."""

from __future__ import annotations

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from vcmm.program.interpret import interpret
from vcmm.program.moves import Move

# the same examples every time; a busy machine is no fault of the code
quick = settings(
    max_examples=60, deadline=None, derandomize=True, suppress_health_check=[HealthCheck.too_slow]
)


coordinate = st.integers(-500_000, 500_000).map(lambda n: n / 1000)


points = st.lists(st.tuples(coordinate, coordinate, coordinate), min_size=1, max_size=8)


def path(text: str, dialect: str = "linuxcnc") -> tuple[Move, ...]:
    return interpret(text + "\nM2", dialect).moves


def close(a: tuple[Move, ...], b: tuple[Move, ...], tolerance: float = 1e-9) -> bool:
    return len(a) == len(b) and all(
        x.kind == y.kind and math.dist(x.start, y.start) < tolerance and math.dist(x.end, y.end) < tolerance
        for x, y in zip(a, b)
    )


@quick
@given(points)
def test_inches_and_millimetres(points: list[tuple[float, float, float]]):
    metric = "\n".join(
        f"G1 X{x * 25.4!r} Y{y * 25.4:.12f} Z{z * 25.4:.12f} F254"
        for x, y, z in points
        if "e" not in repr(x * 25.4)
    )
    inch = "\n".join(f"G1 X{x} Y{y} Z{z} F10" for x, y, z in points if "e" not in repr(x * 25.4))
    a, b = path("G21\n" + metric), path("G20\n" + inch)
    assert close(a, b, 1e-7)
    assert all(m.feed == pytest.approx(n.feed) for m, n in zip(a, b))


@quick
@given(points)
def test_absolute_and_incremental(points: list[tuple[float, float, float]]):
    absolute = ["G21 G90 F100"] + [f"G1 X{x} Y{y} Z{z}" for x, y, z in points]
    here, incremental = (0.0, 0.0, 0.0), ["G21 G91 F100"]
    for p in points:
        incremental.append("G1 " + " ".join(f"{a}{v - w:.6f}" for a, v, w in zip("XYZ", p, here)))
        here = p
    assert close(path("\n".join(absolute)), path("\n".join(incremental)), 1e-5)


@quick
@given(
    st.floats(1, 200),
    st.floats(-3.1, 3.1),
    st.floats(0.05, 6.2),
    st.booleans(),
    st.sampled_from(["G17", "G18", "G19"]),
)
def test_arcs_by_centre_and_by_radius(radius: float, begin: float, sweep: float, clockwise: bool, plane: str):
    if abs(sweep - math.pi) < 0.05:
        return  # near the half circle R fixes the centre badly
    a, b = {"G17": "XY", "G18": "ZX", "G19": "YZ"}[plane]
    i, j = {"X": "I", "Y": "J", "Z": "K"}[a], {"X": "I", "Y": "J", "Z": "K"}[b]
    turned = begin - sweep if clockwise else begin + sweep
    start = (radius * math.cos(begin), radius * math.sin(begin))
    end = (radius * math.cos(turned), radius * math.sin(turned))
    head = f"G21 F100 {plane}\nG0 {a}{start[0]:.9f} {b}{start[1]:.9f}\n{'G2' if clockwise else 'G3'} {a}{end[0]:.9f} {b}{end[1]:.9f} "
    by_centre = path(head + f"{i}{-start[0]:.9f} {j}{-start[1]:.9f}")[-1]
    by_radius = path(head + f"R{radius if sweep < math.pi else -radius:.9f}")[-1]
    assert by_centre.centre is not None
    assert by_radius.centre is not None
    assert math.dist(by_centre.centre, by_radius.centre) < 1e-3
    assert math.dist(by_centre.centre, (0, 0, 0)) < 1e-8


@quick
@given(points, st.sampled_from(["linuxcnc", "fanuc"]))
def test_the_short_cut_for_plain_lines_changes_nothing(
    points: list[tuple[float, float, float]], dialect: str
):
    text = (
        "G21 G54 F100.\n"
        + "\n".join(f"N{n} G{n % 2} X{x:.3f} Y{y:.3f} Z{z:.3f}" for n, (x, y, z) in enumerate(points))
        + "\nM30"
    )
    assert interpret(text, dialect).moves == interpret(text, dialect, trace=True).moves
