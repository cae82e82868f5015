"""Which position of the rotary axes a program asks for, against tables of manuals and matrices written out here."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.shop.motion.test_tool_centre import HEAD, MIXED, TABLES, about, by_hand, machine, moves
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.program.moves import Posture
from vcmm.shop.motion.posture import first_axis, positions, primary_axis, rotary_position, swept_angles
from vcmm.shop.motion.tool_centre import in_machine_axes
from vcmm.shop.motion.tool_pose import tip_and_axis

TRUNNION = "w C' A' X' Y' b Z t"  # table C on a trunnion A
ROTARY = "ABC"


def tables(angle: np.ndarray, order: str) -> np.ndarray:
    """Tool axis in the workpiece of a machine that turns the part only; order: from the part outwards. A primed axis is commanded as
    the tool moves past it: the axis of the tool turns by +q, of the outermost axis first."""
    axis = np.array([0.0, 0.0, 1.0])
    for letter in reversed(order):
        axis = about(letter, angle[ROTARY.index(letter)]) @ axis
    return axis


def klartext(*lines: str) -> str:
    return "\n".join(["BEGIN PGM A MM", "TOOL CALL 1 Z S1000", *lines, "END PGM A MM", ""])


def reached(text: str, mill, dialect: str = "heidenhain") -> np.ndarray:
    """Angles at the end, deg."""
    return np.degrees(in_machine_axes(moves(text, dialect), mill, "part")[0][-1].rotary_end)


def same_turn(found, wanted) -> bool:
    return all(abs(math.remainder(f - w, 360.0)) < 1e-6 for f, w in zip(found, wanted))


@pytest.mark.parametrize(
    ("limit", "start", "word", "wanted"),
    [
        (None, 0, "", (45, 90)), (None, 0, "SEQ+", (45, 90)), (None, 0, "SEQ-", (-45, -90)),
        (None, -105, "", (-45, -90)), (None, -105, "SEQ+", (45, 90)), (None, -105, "SEQ-", (-45, -90)),
        ((-90, 10), 0, "", (-45, -90)), ((-90, 10), 0, "SEQ+", None), (None, -135, "SEQ+", (45, 90)),
    ],
)  # fmt: skip
def test_the_table_of_the_manual(limit, start, word, wanted):
    """HEIDENHAIN, iTNC 530, example for a rotary table C on a tilting table A with PLANE SPATIAL SPA+0 SPB+45 SPC+0; None: an error.

    The normal is (sin 45, 0, cos 45) = Rz(90) Rx(45) z = Rz(-90) Rx(-45) z."""
    mill = machine(TRUNNION)
    if limit is not None:
        axis = mill.axes["A"]
        object.__setattr__(axis, "travel", tuple(map(math.radians, limit)))
    text = klartext(
        f"L X+0 Y+0 Z+50 A+0 C{start:+d} FMAX",
        f"PLANE SPATIAL SPA+0 SPB+45 SPC+0 TURN FMAX {word}",
        "L X+0 Y+0 Z+5 FMAX",
    )
    if wanted is None:
        with pytest.raises(
            ModelLimit, match=r"part:5: no position of A and C within their travels as SEQ\+ asks for"
        ):
            reached(text, mill)
        return
    found = reached(text, mill)
    assert same_turn(found, (wanted[0], 0, wanted[1]))
    assert tables(np.radians(found), "CA") == pytest.approx([math.sqrt(0.5), 0.0, math.sqrt(0.5)], abs=1e-9)


def test_sym_is_the_side_of_the_point_between_both_positions():
    """A tilting table whose travel is -200 to -10 deg, as with a symmetry point at A -90: SPA+80 needs A 80 or, beside it, none; with
    SPA-80 (the normal (0, sin 80, cos 80)) the positions are A -80, C 0 and A -280 + 360 = 80, C 180. Both angles are seen without the
    travel: SYM+ is A 80, SYM- A -80."""
    mill = machine(TRUNNION)
    lines = ["L X+0 Y+0 Z+50 FMAX", "PLANE SPATIAL SPA-80 SPB+0 SPC+0 TURN FMAX {}", "L X+0 Y+0 Z+5 FMAX"]
    plus, minus = (reached(klartext(*[x.format(w) for x in lines]), mill) for w in ("SYM+", "SYM-"))
    assert same_turn(plus, (80, 0, 180))
    assert same_turn(minus, (-80, 0, 0))


def test_the_axes_that_manuals_mean():
    """HEIDENHAIN: first seen from the tool, last seen from the table. FANUC, Siemens: of the head, nearer to the bed."""
    names = [
        (ROTARY[primary_axis(machine(s))], ROTARY[first_axis(machine(s))])
        for s in (TRUNNION, TABLES, HEAD, MIXED)
    ]
    assert names == [("A", "A"), ("B", "B"), ("B", "C"), ("B", "B")]


@pytest.mark.parametrize(("word", "sign"), [("P1", 1), ("P2", -1)])
@pytest.mark.parametrize("structure", [TABLES, MIXED])
def test_g53_1_p_chooses_the_sign_of_the_first_axis(structure, word, sign):
    """The normal (sin 30, 0, cos 30) is B 30, C 0 and B -30, C 180; the tip is where the plane says in both."""
    text = f"G43 H1 G0 X0 Y0 Z50.\nG68.2 X10. Y0 Z0 I90. J30. K-90.\nG53.1 {word}\nG0 X0 Y0 Z20.\nG1 Z-3. F200\nX8.\n"
    last = in_machine_axes(moves(text), machine(structure))[0][-1]
    assert same_turn(np.degrees(last.rotary_end), (0, 30, 0) if sign > 0 else (0, -30, 180))
    at = by_hand(structure, np.array(last.end), np.array(last.rotary_end))
    assert at == pytest.approx([15.428203, 0.0, -406.598076], abs=1e-6)  # as in test_tool_centre


def test_cycle800_takes_the_larger_or_the_smaller_value():
    """828D manual: head B -90 to 90, table C, reference B, 10 deg about X: the normal (0, -sin 10, cos 10) is B 10, C -90 or B -10, C 90."""
    text = 'G54 G90 G0 X0 Y0 Z50 T1 D1\nCYCLE800(0,"",0,57,0,0,0,10,0,0,0,0,0,{})\nG0 X0 Y0 Z20\nM30\n'
    found = {d: reached(text.format(d), machine(MIXED, B=math.pi / 2), "sinumerik") for d in (1, -1)}
    assert same_turn(found[1], (0, 10, -90))
    assert same_turn(found[-1], (0, -10, 90))
    # a head that leans to one side only: the other position is taken whatever DIR says
    leaning = machine(MIXED)
    object.__setattr__(leaning.axes["B"], "travel", (-0.5, 0.05))
    assert same_turn(reached(text.format(1), leaning, "sinumerik"), (0, -10, 90))


def test_table_rot_turns_the_free_table():
    """PLANE SPATIAL SPC+30 leaves the tool along Z: TABLE ROT turns C so that X of the plane lies along X of the machine, COORD ROT leaves
    it. X of the plane is (cos 30, sin 30) of the part; the part turns by -C, so that C 30 brings it to (1, 0)."""
    mill = machine(TRUNNION)
    lines = ["L X+0 Y+0 Z+50 FMAX", "PLANE SPATIAL SPA+0 SPB+0 SPC+30 TURN FMAX {}", "L X+10 Y+0 Z+5 FMAX"]
    for word, c in (("TABLE ROT", 30.0), ("COORD ROT", 0.0), ("", 0.0)):
        last = in_machine_axes(moves(klartext(*[x.format(word) for x in lines]), "heidenhain"), mill)[0][-1]
        assert np.degrees(last.rotary_end) == pytest.approx([0, 0, c], abs=1e-6)
        at = by_hand(TRUNNION, np.array(last.end), np.array(last.rotary_end))
        assert at == pytest.approx([10 * math.cos(math.pi / 6), 5.0, -395.0], abs=1e-9)


def test_all_positions_of_a_direction_are_seen():
    for structure, order in ((TRUNNION, "CA"), (TABLES, "CB")):
        mill, rng = machine(structure), np.random.default_rng(5)
        for _ in range(5):
            axis = rng.normal(size=3)
            axis[2] = abs(axis[2])
            axis /= np.linalg.norm(axis)
            found = positions(mill, axis, np.zeros(3))
            assert len(found) == 2
            for q in found:
                assert tables(q, order) == pytest.approx(axis, abs=1e-8)
            tilt = ROTARY.index(order[1])
            assert math.remainder(found[0][tilt] + found[1][tilt], 2 * math.pi) == pytest.approx(0, abs=1e-7)


def test_of_two_equally_near_positions_the_positive_one():
    found = rotary_position(machine(TRUNNION), np.array([math.sqrt(0.5), 0, math.sqrt(0.5)]), np.zeros(3))
    assert np.degrees(found) == pytest.approx([45, 0, 90], abs=1e-6)
    other = rotary_position(
        machine(TRUNNION), np.array([math.sqrt(0.5), 0, math.sqrt(0.5)]), np.zeros(3), Posture(sign=-1)
    )
    assert np.degrees(other) == pytest.approx([-45, 0, -90], abs=1e-6)


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("heidenhain", klartext("L X+0 Y+0 Z+50 FMAX", "FUNCTION TCPM F TCP AXIS POS PATHCTRL {}", "L X+0 Y+0 Z+0 B+40 C+0 F500", "L X+10 B+40 C+60 F500")),
        ("sinumerik", "G54 G90 G0 X0 Y0 Z50 T1 D1\nTRAORI\n{}\nG1 X0 Y0 Z0 B40 C0 F500\nX10 B40 C60\nM30\n"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("sweeps", [True, False])
def test_a_tool_that_sweeps_the_plane_of_its_directions(dialect, text, sweeps):
    """From B 40, C 0 to B 40, C 60 of a table: d0 = (s, 0, c), d1 = Rz(60) d0. Swept, every direction between lies in the plane of both:
    (d0 x d1) . d = 0. With the axes in proportion B stays 40 and d leaves it by up to

        n . d(30 deg) = s c (2 sin 30 - sin 60) s / |d0 x d1| > 0.05."""
    words = {"heidenhain": ("VECTOR", "AXIS"), "sinumerik": ("ORIVECT", "ORIAXES")}[dialect]
    program = moves(text.format(words[0] if sweeps else words[1]), dialect)
    done = in_machine_axes(program, machine(TABLES))[0]
    last = max(m.source.line for m in done)
    pieces = [m for m in done if m.source.line == last]
    d0, d1 = (tables(np.radians([0, 40, c]), "CB") for c in (0, 60))
    normal = np.cross(d0, d1) / np.linalg.norm(np.cross(d0, d1))
    off = max(abs(float(normal @ tables(np.array(m.rotary_end), "CB"))) for m in pieces)
    assert np.degrees(pieces[-1].rotary_end) == pytest.approx([0, 40, 60], abs=1e-6)
    assert (off < 1e-8) if sweeps else (off > 0.05)
    for m in pieces:  # the tip stays on its line all the same
        at = by_hand(TABLES, np.array(m.end), np.array(m.rotary_end))
        assert at[1:] == pytest.approx([0.0, -400.0], abs=1e-6)


def test_a_sweep_through_the_pole_is_refused():
    """From B 40, C 0 to B 40, C 180 the plane of both directions holds Z, where C would have to jump by half a turn."""
    assert (
        swept_angles(machine(TABLES), np.radians([0, 40, 0]), np.radians([0, 40, 180]), np.linspace(0, 1, 30))
        is None
    )


def test_axes_stay_where_the_control_has_left_them():
    """G69 ends the plane and moves nothing: G0 Z50 moves Z alone; X, Y, B and C stand as the plane has left them until a word names them."""
    text = "G43 H1 G0 X0 Y0 Z50.\nG68.2 X10. Y0 Z0 I90. J30. K-90.\nG53.1\nG0 X0 Y0 Z20.\nG1 X8. F200\nG69\nG0 Z60.\nX3.\nB0 C0\n"
    done = in_machine_axes(moves(text), machine(TABLES))[0]
    plane, z, x, turned = done[-4:]
    assert z.start == plane.end
    assert z.end[:2] == plane.end[:2]
    assert z.end[2] == -340.0  # Z60 from the work zero at -400
    assert np.degrees(z.rotary_end) == pytest.approx([0, 30, 0], abs=1e-6)
    assert (x.end[0], x.end[1]) == (3.0, plane.end[1])
    assert turned.rotary_end == (0.0, 0.0, 0.0)


def test_g53_6_keeps_the_tip_while_the_axes_turn():
    """G53.1 turns B with X, Y, Z standing, G53.6 about the tip: it stays at (0, 0, 50) over the work zero."""
    text = "G43 H1 G0 X0 Y0 Z50.\nG68.2 X0 Y0 Z0 I90. J30. K-90.\n{}\nG0 X0 Y0 Z20.\n"
    for code, keeps in (("G53.6", True), ("G53.1", False)):
        done = in_machine_axes(moves(text.format(code)), machine(HEAD))[0]
        turning = [m for m in done if m.rotary_start != m.rotary_end]
        at = np.array([by_hand(HEAD, np.array(m.end), np.array(m.rotary_end)) for m in turning])
        off = np.linalg.norm(at - [0.0, 0.0, -350.0], axis=1).max()
        assert (off < 1e-4) if keeps else (off > 10.0)


@pytest.mark.parametrize(
    ("dialect", "text"),
    [
        ("fanuc", "G43 H1 G0 X0 Y0 Z50.\nG1 X10. A90. F200\n"),
        ("heidenhain", klartext("L X+0 Y+0 Z+50 FMAX M128", "L X+10 A+30 F500")),
        ("sinumerik", "G54 G90 G0 X0 Y0 Z50 T1 D1\nTRAORI\nG1 X0 A40 F500\nM30\n"),
    ],
)  # fmt: skip
def test_no_machine_turns_an_axis_that_it_lacks(dialect, text):
    with pytest.raises(
        UsageError,
        match=r"part:[34]: the machine has no axis A \(it has B C X Y Z\), and its control stops here",
    ):
        in_machine_axes(moves(text, dialect), machine(HEAD), "part")


def test_an_endless_axis_takes_the_nearest_turn():
    """C stands at 725 deg; the direction that C 0 gives is found at 720 deg, two whole turns on, whatever travel the others have."""
    mill = machine(TRUNNION)
    object.__setattr__(mill.axes["C"], "is_endless", True)
    near = np.radians([-30.0, 0.0, 725.0])
    axis = tables(np.radians([-40.0, 0.0, 0.0]), "CA")
    assert np.degrees(rotary_position(mill, axis, near)) == pytest.approx([-40, 0, 720], abs=1e-6)


def fanuc(*lines: str) -> str:
    return "\n".join(["S1000 M3", *lines, "M30", ""])


def test_g53_1_of_fanuc_compares_the_master_axis_first():
    """FANUC 16i/18i-MB operator's manual, "angle of rotation axis": of a machine that turns the table alone the pair is taken whose master axis, the
    one nearer to the bed, turns least; the other axis counts only between equals.

    Table C on a trunnion A. The plane G68.2 I170 J20 K-170 is that of A20 C170, and of A-20 C-10. From A10 C0 the master axis turns by 10 to the
    first and by 30 to the second, the other by 170 and 10: the largest turn is least for the second (10 < 30 < 170), FANUC takes the first."""
    mill = machine(TRUNNION)
    text = fanuc("G0 X0. Y0. Z50. A10. C0.", "G68.2 X0. Y0. Z0. I170. J20. K-170.", "G53.1", "G0 X1. Y0.")
    assert same_turn(reached(text, mill, "fanuc"), (20, 0, 170))
    assert same_turn(reached(text.replace("A10. C0.", "A-1. C0."), mill, "fanuc"), (-20, 0, -10))  # 21 and 19
    assert same_turn(reached(text.replace("G53.1", "G53.1 P2"), mill, "fanuc"), (-20, 0, -10))


def test_g53_1_of_fanuc_on_head_and_table_compares_the_table_first():
    """The same page, mixed type: the turn of the table first. Head B, table C: the plane of B20 C30 is that of B-20 C-150 too. From B-10 C80 the table
    turns by 50 or 230 (130 the other way round), the head by 30 or 10: the first."""
    mill = machine(MIXED)
    near = np.radians([0.0, -10.0, 80.0])
    none = np.zeros((1, 3))
    aim = tip_and_axis(mill, none, np.radians([[0.0, 20.0, 30.0]]), none)[1][0]
    taken = rotary_position(mill, aim, near, Posture("first", by_axis=True))
    assert taken is not None
    assert same_turn(np.degrees(taken), (0, 20, 30))
