"""Rotary axes about directions of their own: a head whose axis leans by 45 degrees, and axes that turn the other way; by pencil."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import DataError, UsageError
from vcmm.core.kinematics import Axis, nominal_tip, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.files.own.machine import load_machine
from vcmm.physics.structure.component import ComponentTable
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool
from vcmm.shop.motion.tool_centre import in_machine_axes
from vcmm.shop.motion.tool_pose import tip_and_axis, tip_as_at_zero

HEAD, TABLE = "w X' Y' b Z C B t", "w C' B' X' Y' b Z t"
LEANING = (0.0, math.sqrt(0.5), math.sqrt(0.5))  # between +Y and +Z
ROOT = math.sqrt(0.5)


def machine(structure: str, direction=LEANING, effects=(), centre=(0.0, 0.0, 0.0), **more) -> Machine:
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    axes["C"] = Axis("C", (-2 * math.pi, 2 * math.pi))
    axes["B"] = Axis("B", (-0.2, math.pi + 0.2), centre, direction=direction, **more)
    return Machine("mill", "machine-tool", parse_structure(structure), axes, tuple(effects))


def at(structure: str, angle_b: float, offset=(0.0, 0.0, -100.0), angle_c: float = 0.0) -> Run:
    zero = {a: np.zeros(1) for a in "XYZ"}
    both = zero | {"B": np.array([math.radians(angle_b)]), "C": np.array([math.radians(angle_c)])}
    return Run({a: both[a] for a in parse_structure(structure).letters}, np.array([offset]))


def test_a_head_that_leans_by_45_degrees_by_pencil():
    """d = (0, 1, 1) / sqrt 2. z turned by q about d is z cos q + d x z sin q + d (d.z) (1 - cos q): at 180 deg 2 d (d.z) - z = (0, 1, 0),
    the tool lies; at 90 deg (sqrt 1/2, 1/2, 1/2). The tip is 100 mm below the axis, at -100 times that."""
    mill = machine(HEAD)
    for angle, tip in ((0, (0, 0, -100)), (180, (0, -100, 0)), (90, (-100 * ROOT, -50, -50))):
        run = at(HEAD, angle)
        assert nominal_tip(mill.chain, mill.axes, run)[0] == pytest.approx(tip, abs=1e-12)


def test_a_table_that_leans_by_45_degrees_by_pencil():
    """A primed axis is commanded as the tool moves past it: the point of the tool turns by +q. (0, 0, -100) at B 180: (0, -100, 0)."""
    mill = machine(TABLE)
    assert nominal_tip(mill.chain, mill.axes, at(TABLE, 180))[0] == pytest.approx([0, -100, 0], abs=1e-12)


def test_the_other_sense_turns_the_other_way():
    """B about -Y: +90 takes (0, 0, -100) where -90 about +Y does, Ry(-90) z = -x, so to (100, 0, 0)."""
    mill = machine(HEAD, (0.0, -1.0, 0.0))
    assert nominal_tip(mill.chain, mill.axes, at(HEAD, 90))[0] == pytest.approx([100, 0, 0], abs=1e-12)


def constant(component: str, size: float) -> ComponentTable:
    return ComponentTable(component, ("B",), (np.array([-1.0, 4.0]),), np.array([size, size]))


@pytest.mark.parametrize("exact", [False, True])
@pytest.mark.parametrize(
    ("component", "wanted"),
    [
        (
            "EBB",
            (-100 * ROOT, 0, 0),
        ),  # d x (0, 0, -100) = (-100, 0, 0) / sqrt 2, times 1e-5: the axis turns too far
        ("EXB", (1, 0, 0)),  # X of the axis frame is that of the machine: Y goes to d by a turn about X
        ("EYB", (0, ROOT, ROOT)),  # along the axis itself
        ("EZB", (0, -ROOT, ROOT)),  # Rx(45) z
    ],
)
def test_errors_are_those_of_the_axis_frame(component, wanted, exact):
    size = 1e-5 if component == "EBB" else 1e-3
    mill = machine(HEAD, effects=(constant(component, size),))
    found = mill.tip_error(at(HEAD, 0), exact=exact)[0] / size
    assert found == pytest.approx(wanted, abs=2e-3 if component == "EBB" else 1e-9)


def about(d: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = d
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross


def test_both_engines_agree_with_matrices_written_here():
    """Head C carrying B about d through c, with EBB, EXB and EZB at once: C · (c + R0 (turn by q, then the error) R0^T (p - c))."""
    rng, centre = np.random.default_rng(5), np.array([3.0, -7.0, 40.0])
    d = np.array([0.6, 0.48, 0.64])
    sizes = {"EBB": 2e-5, "EXB": 4e-3, "EZB": -3e-3}
    mill = machine(
        HEAD,
        tuple(d),
        [constant(k, v) for k, v in sizes.items()],
        tuple(centre),
        measured_at=(5.0, 0.0, 10.0),
    )
    axis = np.cross([0.0, 1.0, 0.0], d)
    turn = about(axis / np.linalg.norm(axis), math.acos(d[1]))  # Y into d by the shortest way
    for _ in range(5):
        b, c, offset = rng.uniform(0, 3), rng.uniform(-3, 3), rng.uniform(-200, 200, 3)
        run = at(HEAD, math.degrees(b), tuple(offset), math.degrees(c))
        p = turn.T @ (offset - centre)
        m = turn.T @ (np.array([5.0, 0.0, 10.0]) - centre)  # of the axis frame, from its centre
        wrong = m + about(np.array([0.0, 1.0, 0.0]), sizes["EBB"]) @ (p - m) + [sizes["EXB"], 0, sizes["EZB"]]
        spin = about(np.array([0.0, 1.0, 0.0]), b)
        error = about(np.array([0.0, 0.0, 1.0]), c) @ turn @ spin @ (wrong - p)
        assert mill.tip_error(run, exact=True)[0] == pytest.approx(error, abs=1e-12)
        assert mill.tip_error(run)[0] == pytest.approx(error, abs=1e-6)  # second order: 200 mm x (2e-5)^2


def test_tip_and_tool_axis_go_there_and_back():
    mill, rng = machine(HEAD, centre=(3.0, -7.0, 40.0)), np.random.default_rng(2)
    points, angle = rng.uniform(-100, 100, (20, 3)), rng.uniform(0, 3, (20, 3)) * [0, 1, 1]
    offset = np.tile([0.0, 0.0, 120.0], (20, 1))
    tip = tip_as_at_zero(mill, points, angle, offset)
    found, axis = tip_and_axis(mill, tip, angle, offset)
    assert found == pytest.approx(points, abs=1e-9)
    wanted = [about(np.array([0, 0, 1.0]), c) @ about(np.array(LEANING), b) @ [0, 0, 1] for _, b, c in angle]
    assert axis == pytest.approx(np.array(wanted), abs=1e-12)


def test_a_program_turns_a_leaning_head_square_to_a_plane():
    """The plane of J-90 has the normal Rx(-90) z = +y. Head C, B about d: B 180 lays the tool along +y, with C 0 (see above)."""
    text = "G21 G90 G54\nT1 M6\nS1000 M3\nG43 H1 G0 X0 Y0 Z50.\nG68.2 X0 Y0 Z0 I0 J-90. K0\nG53.1\nG0 X5. Y0 Z0\nM30\n"
    moves = interpret(text, "fanuc", Setup(tools={1: Tool(1, 100.0, 10.0)}), "part.nc").moves
    last = in_machine_axes(moves, machine(HEAD), "part.nc")[0][-1]
    assert np.degrees(last.rotary_end) == pytest.approx([0, 180, 0], abs=1e-6)
    assert last.tool_axis_end == pytest.approx((0, 1, 0), abs=1e-9)


TEXT = """vcmm = "machine/1"
name = "nutating head"
kind = "machine-tool"
structure = "w X' Y' b Z C B t"
[axes.X]
travel = ["-500 mm", "500 mm"]
[axes.Y]
travel = ["-500 mm", "500 mm"]
[axes.Z]
travel = ["-500 mm", "500 mm"]
[axes.C]
travel = "endless"
[axes.B]
travel = ["0 deg", "180 deg"]
direction = [0, 1, 1]
"""


def test_the_file_says_the_direction(tmp_path: Path):
    from vcmm.files.learned.calibrated_machine import bare_text

    path = tmp_path / "machine.toml"
    path.write_text(TEXT)
    mill = load_machine(path)
    assert mill.axes["B"].direction == pytest.approx(LEANING)
    path.write_text(bare_text(mill))
    assert load_machine(path).axes["B"].direction == pytest.approx(LEANING, abs=1e-15)
    path.write_text(TEXT.replace("[0, 1, 1]", "[0, 1, 0]"))
    assert load_machine(path).axes["B"].direction is None
    path.write_text(TEXT.replace('"500 mm"]\n[axes.C]', '"500 mm"]\ndirection = [0, 1, 1]\n[axes.C]'))
    with pytest.raises(
        (DataError, UsageError), match="direction of Z: only rotary axes have one of their own"
    ):
        load_machine(path)
