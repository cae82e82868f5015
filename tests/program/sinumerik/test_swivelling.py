"""CYCLE800, DIAMON with I=AC(), directions of the tool: numbers by hand."""

from __future__ import annotations

import math

import pytest

from tests.program.sinumerik.programs import SETUP, SURVEY, check, moves, told
from vcmm.core.errors import DataError
from vcmm.program.sinumerik.reader import read

TURN = "G18 G90 G54 DIAMON F100\nG0 X40 Z0\n"


def test_solid_angle_turns_about_z_then_the_new_y():
    """MODE 64, A = 90 about Z, B = 90 about the new Y, which is -X of the part: Z of the plane lies along Rz(90) Ry(90) z = Rz(90) x = y,
    X along Rz(90) Ry(90) x = Rz(90) (-z) = -z."""
    text = 'CYCLE800(0,"TC",0,64,0,0,0,90,90,0,0,0,0,1)\nG0 X1 Y0 Z0\nZ1\n'
    check(text, (0, 0, -1), (0, 1, -1))
    with pytest.raises(DataError, match="CYCLE800 by solid angle takes A"):
        moves('CYCLE800(0,"TC",0,64,0,0,0,90,90,5,0,0,0,1)\nG0 X1')


def test_mode_that_is_not_understood_is_refused():
    """SINUMERIK 828D, operating manual: with direct swivelling "you can derive the resulting direction of the X and Y axis by traversing"."""
    text = 'CYCLE800(0,"TC",0,192,0,0,0,30,10,0,0,0,0,1)\nG0 X1'
    with pytest.raises(
        DataError, match=r"the rotary axes themselves .MODE 192. of CYCLE800 are not understood"
    ):
        moves(text)
    assert any("MODE 192" in what for what in told(text))
    assert moves(text, SURVEY)[-1].end == (1.0, 0.0, 0.0)  # no plane is made up


# A = 30, B = 40 by pencil. X of the plane is Ry(40) x = (cos 40, 0, -sin 40); the plane holds (0, cos 30, sin 30) too, so that its normal is the
# product of both, (sin 40 cos 30, -cos 40 sin 30, cos 40 cos 30) = (0.556670, -0.383022, 0.663414) over its length 0.946946; Y = normal x X
X_OF_PLANE = (math.cos(math.radians(40)), 0.0, -math.sin(math.radians(40)))
NORMAL = tuple(v / 0.9469456279049849 for v in (0.5566703992264194, -0.38302222155948895, 0.6634139481689384))
Y_OF_PLANE = (
    NORMAL[1] * X_OF_PLANE[2],
    NORMAL[2] * X_OF_PLANE[0] - NORMAL[0] * X_OF_PLANE[2],
    -NORMAL[1] * X_OF_PLANE[0],
)


@pytest.mark.parametrize(
    "mode", [128, 185]
)  # without and with the axes named: 185 = 128 + 3 * 16 + 2 * 4 + 1
def test_projection_angles_by_pencil(mode):
    assert pytest.approx((0.259996, 0.914546, 0.309851), abs=1e-6) == Y_OF_PLANE
    check(f'CYCLE800(0,"TC",0,{mode},0,0,0,30,40,0,0,0,0,1)\nG0 X1 Y0 Z0\nX0 Y1\n', X_OF_PLANE, Y_OF_PLANE)
    # one angle alone is a turn about that axis, and the third turns about the new Z: Rz(90) x = y
    check(f'CYCLE800(0,"TC",0,{mode},0,0,0,0,0,90,0,0,0,1)\nG0 X10 Y0 Z0\n', (0, 10, 0))
    check(f'CYCLE800(0,"TC",0,{mode},0,0,0,30,0,0,0,0,0,1)\nG0 X0 Y2 Z0\n', (0, math.sqrt(3), 1))


@pytest.mark.parametrize(("mode", "angles"), [(158, "30,40"), (155, "40,30")])
def test_projection_angles_of_other_axes_are_the_same_in_turn(mode, angles):
    """Axes Y, Z (128 + 1 * 16 + 3 * 4 + 2 = 158): Y of the plane lies in the old XY plane. What is X, Y, Z above is Y, Z, X here, and axes Z, Y
    (128 + 16 + 8 + 3 = 155) have their angles exchanged."""
    points = [(v[2], v[0], v[1]) for v in (X_OF_PLANE, Y_OF_PLANE)]
    check(f'CYCLE800(0,"TC",0,{mode},0,0,0,{angles},0,0,0,0,1)\nG0 X0 Y1 Z0\nY0 Z1\n', *points)
    with pytest.raises(DataError, match="projects twice along one axis"):
        moves('CYCLE800(0,"TC",0,133,0,0,0,30,10,0,0,0,0,1)\nG0 X1')


def test_direction_of_the_rotary_axes():
    text = 'CYCLE800(1,"TC",0,57,0,0,0,90,0,0,0,0,0{})\nG0 X1'
    for given, larger in ((",1", 1), (",-1", -1)):
        program = read(text.format(given), "part.mpf", SURVEY)
        posture = program.moves[-1].posture
        assert (posture.axis, posture.larger, posture.binding) == ("first", larger, False)
    assert moves(text.format(""))[-1].posture is None
    with pytest.raises(
        DataError, match="DIR = 0 of CYCLE800 turns the coordinates and leaves the rotary axes"
    ):
        moves(text.format(",0"))
    stays = moves(text.format(",0"), SURVEY)[-1]
    assert (stays.is_tip_led, stays.tool_axis_end) == (False, None)
    with pytest.raises(DataError, match="DIR is -1, 0 or 1, found 2"):
        moves(text.format(",2"))
    said = [r.text for r in read(text.format(",1"), "part.mpf", SETUP).warnings]
    assert any("FR = 1 of CYCLE800" in s for s in said)
    assert any("DIR = 1 of CYCLE800: the larger value of rotary axis 1" in s for s in said)


def test_centres_from_the_work_zero_are_diameters_with_diamon():
    """From X40 to X60 (radii 20, 30) about X 60 / Z 0 of the diameter: I=AC(60) is 30 mm from the axis; without AC I is a way, 10 mm."""
    for centre in ("I=AC(60) K=AC(0)", "I10 K0"):
        arc = moves(f"{TURN}G3 X60 Z-10 {centre}")[-1]
        assert arc.end == pytest.approx((30, 0, -10))
        assert arc.centre == pytest.approx((30, 0, 0))
    radius = moves(f"{TURN}DIAMOF\nG3 X30 Z-10 I=AC(30) K=AC(0)")[-1]
    assert radius.centre == pytest.approx((30, 0, 0))
    with pytest.raises(DataError, match="arc does not fit"):
        moves(f"{TURN}G3 X60 Z-10 I=AC(30) K=AC(0)")


def test_diam90_counts_by_the_word():
    """DIAM90: absolute words are diameters, increments radii, whatever G90 or G91 is in force."""
    check("DIAM90 G90 G0 X40\nX=IC(5)\nG91 X5\nX=AC(40)\n", (20, 0, 0), (25, 0, 0), (30, 0, 0), (20, 0, 0))


def test_point_between_of_cip_with_diamon():
    """From X40 (radius 20), Z0 through radius 30, Z-10 to X40 Z-20: I1=60 as a diameter, I1=IC(10) as a way; the centre is (20, -10)."""
    for via in ("I1=60 K1=-10", "I1=IC(10) K1=IC(-10)"):
        arc = moves(f"{TURN}CIP X40 Z-20 {via}")[-1]
        assert arc.centre == pytest.approx((20, 0, -10))


def test_sweeping_is_switched_by_its_words():
    text = "TRAORI\n{}\nG1 X1 A3=0.5 C3=0.8660254 F100\n"
    for word in ("ORIWKS", "ORIVECT", "ORIPLANE"):
        assert moves(text.format(word))[-1].sweeps
    for word in ("ORIMKS", "ORIAXES", ""):
        assert not moves(text.format(word))[-1].sweeps
    assert moves(text.format("ORIVECT"))[-1].tool_axis_end == pytest.approx((0.5, 0.0, math.sqrt(0.75)))


@pytest.mark.parametrize("word", ["TOFRAME", "TCARR=1", "TCOABS", "TOROTZ", "ORIEULER", "G41 CUT3DC"])
def test_words_that_turn_frames_or_tools_are_refused(word):
    with pytest.raises(DataError, match="is not understood"):
        moves(f"T1 D1\nG17 G1 F100\n{word}\nX10")
    assert moves("TCARR=0\nTCOABS\n".replace("TCOABS\n", "") + "G0 X1")[-1].end[0] == 1


def test_words_that_nothing_uses_reach_the_list_and_those_of_speeds_are_told_once():
    program = read("G90 G54 F100\nG0 X1 K-2\nG1 X5 CR=3 FRC=20\nX6 FRC=20\nM30\n", "part.mpf", SURVEY)
    assert [(u.line, u.word) for u in program.unused] == [(2, "K-2"), (3, "CR=3")]
    assert sum("FRC= changes speeds" in r.text for r in program.warnings) == 1
    with pytest.raises(DataError, match='nothing in this block uses the word "CR"; remove it'):
        moves("G1 F100 X5 CR=3")
    for text, said in (
        ("DL=1", "sum offset of the tool"),
        ("PRESETON(X,0)", "actual values of axes are set"),
    ):
        with pytest.raises(DataError, match=said):
            moves(f"G1 F100 X5\n{text}\nX6")
