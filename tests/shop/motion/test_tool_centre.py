"""Programs that lead the tip over the workpiece, against transforms written out by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool
from vcmm.shop.motion.posture import rotary_position
from vcmm.shop.motion.tool_centre import CHORD, in_machine_axes, leads, orient_moves
from vcmm.shop.motion.tool_pose import tip_and_axis, tip_as_at_zero
from vcmm.show.tables.program import move_json

CENTRE = {"A": (0.0, 5.0, -450.0), "B": (0.0, 0.0, -450.0), "C": (20.0, 10.0, -450.0)}
LENGTH = 100.0
SETUP = Setup(offsets={"G54": (0.0, 0.0, -400.0)}, tools={1: Tool(1, LENGTH, 10.0, "ball")})
TABLES, HEAD, MIXED = "w C' B' X' Y' b Z t", "w X' Y' b Z C B t", "w C' X' Y' b Z B t"


def machine(structure: str, travel: float = 2 * math.pi, **limits: float) -> Machine:
    chain = parse_structure(structure)
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    for a in chain.letters:
        if a in "ABC":
            most = limits.get(a, travel)
            axes[a] = Axis(a, (-most, most), CENTRE[a])
    return Machine("mill", "machine-tool", chain, axes)


def moves(text: str, dialect: str = "fanuc"):
    head = "G21 G90 G54 G94\nT1 M6\n" if dialect == "fanuc" else ""
    return interpret(head + text, dialect, SETUP, "part.nc").moves


def about(letter: str, angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    rows = {"A": [[1, 0, 0], [0, c, -s], [0, s, c]], "B": [[c, 0, s], [0, 1, 0], [-s, 0, c]], "C": [[c, -s, 0], [s, c, 0], [0, 0, 1]]}  # fmt: skip
    return np.array(rows[letter], dtype=float)


def by_hand(structure: str, tip: np.ndarray, rotary: np.ndarray) -> np.ndarray:
    """Tip in the workpiece from the position of the axes: the tables turn the point back about their centres, the head the tool.

    A primed axis is commanded as the tool moves past it: the table itself turns by -q, so that the point turns by +q seen from
    it. Tables are undone from the bed outwards; a head turns the tool about its pivot, which X, Y and Z carry.
    """
    words = structure.split()
    bed = words.index("b")
    p = tip + np.array([0.0, 0.0, LENGTH])
    tool = np.array([0.0, 0.0, -LENGTH])
    for letter in (w for w in reversed(words[bed + 1 : -1]) if w in "ABC"):
        turned = about(letter, rotary["ABC".index(letter)])
        centre = np.array(CENTRE[letter])
        tool = centre + turned @ (tool - centre)
    p = p + tool
    for word in reversed(words[1:bed]):
        if word[0] in "ABC":
            centre = np.array(CENTRE[word[0]])
            p = centre + about(word[0], rotary["ABC".index(word[0])]) @ (p - centre)
    return p


@pytest.mark.parametrize("structure", [TABLES, HEAD, MIXED])
def test_the_tip_runs_on_the_programmed_line_while_both_rotary_axes_turn(structure):
    program = moves("G43.4 H1 G0 X-40. Y-30. Z5.\nG1 Z-2. F500\nX40. Y30. Z-6. B30. C40.\n")
    done, said = in_machine_axes(program, machine(structure))
    assert leads(program)
    assert not leads(done)
    assert said == ()
    a, b = np.array([-40.0, -30.0, -402.0]), np.array([40.0, 30.0, -406.0])
    way = (b - a) / np.linalg.norm(b - a)
    pieces = [m for m in done if m.source.line == 5]
    seen = []
    for m in pieces:
        for t in (0.0, 0.5, 1.0):
            start, end = np.array(m.start), np.array(m.end)
            angle = np.array(m.rotary_start) + t * (np.array(m.rotary_end) - np.array(m.rotary_start))
            seen.append(by_hand(structure, start + t * (end - start), angle))
    off = np.array(seen) - a
    off = off - np.outer(off @ way, way)
    assert np.linalg.norm(off, axis=1).max() < 2 * CHORD
    assert seen[-1] == pytest.approx(b, abs=1e-9)
    assert np.degrees(pieces[-1].rotary_end) == pytest.approx([0.0, 30.0, 40.0])
    # F is that of the tip: 100.08 mm at 500 mm/min are 12.01 s
    seconds = sum(60 * math.dist(m.start, m.end) / m.feed for m in pieces)
    assert seconds == pytest.approx(60 * np.linalg.norm(b - a) / 500, rel=1e-4)


@pytest.mark.parametrize("structure", [TABLES, HEAD, MIXED])
def test_axes_and_pose_are_each_others_way_back(structure):
    mill, rng = machine(structure), np.random.default_rng(2)
    at, angle = rng.uniform(-100, 100, (20, 3)), rng.uniform(-1.5, 1.5, (20, 3))
    offset = np.tile([0.0, 0.0, LENGTH], (20, 1))
    tip = tip_as_at_zero(mill, at, angle, offset)
    assert tip_and_axis(mill, tip, angle, offset)[0] == pytest.approx(at, abs=1e-9)
    angle[:, 0] = 0.0  # these machines have no A
    found = np.array([by_hand(structure, one, q) for one, q in zip(tip, angle)])
    assert found == pytest.approx(at, abs=1e-9)


@pytest.mark.parametrize("structure", [TABLES, HEAD, MIXED])
def test_a_direction_is_found_again_at_the_nearest_position(structure):
    mill, zero = machine(structure), np.zeros((1, 3))
    for b, c in ((0.3, 1.0), (-0.7, 2.5), (1.2, -0.4)):
        angle = np.array([[0.0, b, c]])
        axis = tip_and_axis(mill, zero, angle, zero)[1][0]
        found = rotary_position(mill, axis, angle[0] + [0.0, 0.05, 0.05])
        assert found == pytest.approx(angle[0], abs=1e-9)


def test_a_singular_direction_leaves_the_axis_that_does_not_matter():
    """The tool along C: any C does. It stays at 1 rad."""
    found = rotary_position(machine(TABLES), np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.2, 1.0]))
    assert found == pytest.approx([0.0, 0.0, 1.0], abs=1e-7)


def test_g43_5_points_the_tool_along_its_vector():
    """I0.5 K0.8660254: 30 deg from Z towards +X. On a head C carrying B that is B 30, C 0."""
    program = moves("G43.5 H1 G0 X0 Y0 Z5.\nG1 X10. Y0 Z0 I0.5 J0 K0.8660254 F500\n")
    done, _ = in_machine_axes(program, machine(HEAD))
    assert np.degrees(done[-1].rotary_end) == pytest.approx([0.0, 30.0, 0.0], abs=1e-5)
    assert done[-1].tool_axis_end == pytest.approx((0.5, 0.0, math.sqrt(0.75)), abs=1e-6)
    assert by_hand(HEAD, np.array(done[-1].end), np.array(done[-1].rotary_end)) == pytest.approx(
        [10.0, 0.0, -400.0], abs=1e-9
    )


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("fanuc", "G43 H1 G0 X0 Y0 Z50.\nG68.2 X10. Y0 Z0 I90. J30. K-90.\nG53.1\nG0 X0 Y0 Z20.\nG1 Z-3. F200\nX8.\nG69\nG0 Z50.\n"),
        ("heidenhain", "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+50 FMAX\nCYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+10\nPLANE SPATIAL SPA+0 SPB+30 SPC+0 TURN FMAX\n"
         "L X+0 Y+0 Z+20 FMAX\nL Z-3 F200\nL X+8\nPLANE RESET TURN FMAX\nL Z+50 FMAX\nEND PGM A MM\n"),
    ],
)  # fmt: skip
def test_a_tilted_plane_turns_the_tool_square_to_it_and_stays_a_line(dialect, text):
    """About Y by 30 deg through X 10: the normal is (sin 30, 0, cos 30), the point (8, 0, -3) of the plane lies at
    10 + 8 cos 30 - 3 sin 30 = 15.4282, -8 sin 30 - 3 cos 30 = -6.5981 from the work zero."""
    done, _ = in_machine_axes(moves(text, dialect), machine(TABLES))
    cut = [m for m in done if m.kind == "line"]
    assert len(cut) == 2  # the rotary axes stand: no pieces
    assert cut[-1].tool_axis_end == pytest.approx((0.5, 0.0, math.sqrt(0.75)), abs=1e-12)
    at = by_hand(TABLES, np.array(cut[-1].end), np.array(cut[-1].rotary_end))
    assert at == pytest.approx([15.428203, 0.0, -406.598076], abs=1e-6)
    turn = next(m for m in done if m.rotary_start != m.rotary_end)
    assert (turn.kind, turn.start == turn.end) == ("rapid", True)
    # PLANE RESET TURN takes the axes back; G69 leaves them where they stand (FANUC: it ends the feature coordinates, no axis moves)
    back = 0.0 if dialect == "heidenhain" else 30.0
    assert np.degrees(done[-1].rotary_end) == pytest.approx([0.0, back, 0.0], abs=1e-6)


@pytest.mark.parametrize(
    "text",
    ["G54 G90 G0 X0 Y0 Z50 T1 D1\nTRAORI\nG1 X10 Y5 Z-2 A3=0.5 B3=0 C3=0.8660254 F500\nTRAFOOF\nM30\n",
     "G54 G90 G0 X0 Y0 Z50 T1 D1\nTRAORI\nG1 X10 Y5 Z-2 B30 F500\nTRAFOOF\nM30\n",
     'G54 G90 G0 X0 Y0 Z50 T1 D1\nCYCLE800(1,"",0,57,10,5,-2,0,30,0,0,0,0,1)\nG0 X0 Y0 Z20\nG1 Z0 F200\nCYCLE800()\nM30\n'],
    ids=["vector", "angle", "swivelled"],
)  # fmt: skip
def test_sinumerik_leads_the_tip_and_swivels(text):
    """Always to (10, 5, -2) of the workpiece with the tool 30 deg from Z towards X."""
    done, _ = in_machine_axes(moves(text, "sinumerik"), machine(HEAD))
    last = [m for m in done if m.kind == "line"][-1]
    assert by_hand(HEAD, np.array(last.end), np.array(last.rotary_end)) == pytest.approx(
        [10.0, 5.0, -402.0], abs=1e-9
    )
    assert last.tool_axis_end == pytest.approx((0.5, 0.0, math.sqrt(0.75)), abs=1e-6)


def test_klartext_leads_the_tip_under_m128():
    text = "BEGIN PGM A MM\nTOOL CALL 1 Z S1000\nL X+0 Y+0 Z+50 FMAX M128\nL X+10 Y+5 Z-2 B+20 C+30 F500\nM129\nEND PGM A MM\n"
    done, _ = in_machine_axes(moves(text, "heidenhain"), machine(HEAD))
    last = [m for m in done if m.kind == "line"][-1]
    assert by_hand(HEAD, np.array(last.end), np.array(last.rotary_end)) == pytest.approx(
        [10.0, 5.0, -402.0], abs=1e-9
    )


def test_a_swing_beside_a_singular_position_is_told_with_its_line():
    """From 1 deg on one side of Z to 1 deg on the side square to it: C swings by 90 deg while the tool tilts by 1.41 deg."""
    s, c = math.sin(math.radians(1.0)), math.cos(math.radians(1.0))
    text = f"G43.5 H1 G0 X0 Y0 Z5. \nG1 X1. I{s:.9f} J0 K{c:.9f} F500\nX2. I0 J{s:.9f} K{c:.9f}\n"
    _, said = in_machine_axes(moves(text), machine(TABLES, B=0.5))
    assert [r.line for r in said] == [5]
    assert "axis C swings by 90.0 deg while the tool tilts by 1.41 deg" in said[0].text


def test_an_orientation_beyond_the_travels_names_line_and_axes():
    with pytest.raises(ModelLimit, match=r"part.nc:4: no position of B and C within their travels .*0\.8660"):
        in_machine_axes(
            moves("G43.5 H1 G0 Z5.\nG1 X1. I0.8660254 J0 K0.5 F500\n"), machine(TABLES, B=0.5), "part.nc"
        )


def test_a_machine_without_rotary_axes_is_refused_with_what_to_add():
    with pytest.raises(UsageError, match=r"part.nc:3: .*mill has no rotary axes; add them to its structure"):
        in_machine_axes(moves("G43.4 H1 G0 Z5.\n"), machine("w X' Y' b Z t"), "part.nc")


def test_other_programs_are_left_as_they_are():
    program = moves("G43 H1 G0 X0 Y0 Z5. B30.\nG1 Z0 F100\n")
    assert in_machine_axes(program, machine(TABLES)) == (program, ())


def test_moves_of_a_program_carry_their_angles_and_tool_axes():
    """G43.5 along (sin 30, 0, cos 30): on a head C carrying B the axes end at B 30, C 0; the move itself stays one line."""
    program = moves("G43.5 H1 G0 X0 Y0 Z5.\nG1 X10. Y0 Z0 I0.5 J0 K0.8660254 F500\n")
    done, _ = orient_moves(program, machine(HEAD))
    assert len(done) == len(program)
    last = done[-1]
    assert (last.start, last.end) == (program[-1].start, program[-1].end)
    assert np.degrees(last.rotary_end) == pytest.approx([0.0, 30.0, 0.0], abs=1e-5)
    assert last.tool_axis_start == pytest.approx((0.0, 0.0, 1.0))
    assert last.tool_axis_end == pytest.approx((0.5, 0.0, math.sqrt(0.75)), abs=1e-6)
    written = move_json(last)
    assert written["rotary_end_rad"] == {
        "A": 0.0,
        "B": pytest.approx(math.pi / 6),
        "C": pytest.approx(0.0, abs=1e-6),
    }
    assert written["tool_axis_end"] == list(last.tool_axis_end)


def test_a_table_that_stands_turned_has_its_tool_axis_in_the_workpiece():
    """No tool centre point control: B of the table at 90 deg, the tool lies along X of the workpiece."""
    done, _ = orient_moves(moves("G43 H1 G0 X0 Y0 Z50. B90.\nG1 Z40. F500\n"), machine(TABLES))
    assert done[-1].tool_axis_end == pytest.approx(
        tuple(about("B", math.pi / 2) @ [0.0, 0.0, 1.0]), abs=1e-12
    )


def test_angles_that_only_the_machine_knows_are_not_written():
    last = moves("G43.5 H1 G0 X0 Y0 Z5.\nG1 X10. Y0 Z0 I0.5 J0 K0.8660254 F500\n")[-1]
    written = move_json(last)
    assert written["rotary_end_rad"] is None
    assert written["tool_axis_end"] == pytest.approx([0.5, 0.0, math.sqrt(0.75)], abs=1e-6)


def test_centres_that_are_not_stated_are_told():
    mill = machine(HEAD)
    bare = replace(mill, axes={**mill.axes, "B": replace(mill.axes["B"], centre=(0.0, 0.0, 0.0))})
    _, said = in_machine_axes(moves("G43.4 H1 G0 X0 Y0 Z5.\nG1 Z0 F100\n"), bare)
    assert [r.line for r in said] == [3]
    assert "axis B turns about the zero of the machine frame" in said[0].text


def test_polar_interpolation_on_a_lathe_keeps_the_angles_of_the_program():
    """Without Y nothing is solved: C is what the reading of the program says; simulated, X and C follow: (20, 20) is 28.28 mm at 45 deg."""
    structure = "w C' b Z X t"
    axes = {a: Axis(a, (-500.0, 500.0)) for a in "XZ"} | {"C": Axis("C", (-99.0, 99.0))}
    lathe = Machine("turn", "machine-tool", parse_structure(structure), axes, ())
    text = "G21 G98 T0101\nG0 X120. C0 Z2.\nG12.1\nG1 X40. F200\nC20.\nG13.1\nM30\n"
    moves = interpret(text, "fanuc-lathe", Setup(strict=False)).moves
    found, said = orient_moves(moves, lathe)
    assert found == moves
    assert not said
    assert moves[-1].rotary_end[2] == pytest.approx(math.pi / 4)
    last = in_machine_axes(moves, lathe)[0][-1]
    assert last.end == pytest.approx((math.sqrt(800.0), 0.0, 2.0))
    assert last.rotary_end[2] == pytest.approx(math.pi / 4)


def test_a_tool_change_leaves_the_axes_where_they_stand():
    """Tool 2 is 30 mm longer: after the change Z of the machine is still 500 mm, so its tip begins 30 mm lower than that of tool 1 ended."""
    axes = {a: Axis(a, (-500.0, 900.0)) for a in "XZ"} | {"C": Axis("C", (-99.0, 99.0))}
    machine = Machine("turn", "lathe", parse_structure("w C' b Z X t"), axes, ())
    tools = {n: Tool(n, length=60.0 + 30.0 * (n - 1), shape="flat", diameter=8.0, driven="z") for n in (1, 2)}
    text = "G21 G98\nT0101\nG0 X60. Z440.\nT0202\nG0 X50.\nG12.1\nG1 X40. F200\nG13.1\nM30\n"
    moves = in_machine_axes(interpret(text, "fanuc-lathe", Setup(strict=False, tools=tools)).moves, machine)[
        0
    ]
    first = next(m for m in moves if m.tool == 2)
    assert first.start[2] + first.tool_offset[2] == pytest.approx(500.0)
    assert first.start[2] == pytest.approx(410.0)
