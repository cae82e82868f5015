"""The referee's cutter against a pencil."""

import math
from functools import partial

import numpy as np
import pytest

from referee.cutter import Cutter, read_program
from referee.forces import Blank, forces
from referee.loops import FORWARD, GAIN, known

WALL = """G54 G0 X-20. Y-30. S2000 M3
T1 M6
G0 Z-5.
G1 X-18. Y-30. F600
G1 X-18. Y30. F600
G1 X20. Y30. F1200
G4 P2000
G1 X20. Y20. F600
G0 Z30.
"""


def test_a_move_takes_length_over_speed_and_the_ramps():
    path = read_program(WALL)
    # 60 mm at 10 mm/s, and 10/3000 s for speeding up and slowing down
    row = int(np.flatnonzero(path.end[:, 1] == 30.0)[0])
    assert path.ended[row] - path.began[row] == pytest.approx(6.0 + 10 / 3000)
    # 38 mm at 20 mm/s, then 2 s of standing
    assert path.began[row + 2] - path.began[row + 1] == pytest.approx(1.9 + 20 / 3000 + 2.0)
    assert path.cutting.tolist()[:2] == [-1, -1]
    assert set(path.cutting.tolist()[2:-1]) == {0}


def test_a_wall_is_made_beside_the_tool():
    # the centre runs along x = -18: a tool of 8 mm leaves the wall of normal -x at x = -10, one of 8.002 mm goes 2 um deeper
    points, normals = np.array([[-10.0, 3.0, -4.0]]), np.array([[-1.0, 0.0, 0.0]])
    assert Cutter(read_program(WALL), {1: 8.0}).cut(points, normals, [])[0] == pytest.approx([0.0], abs=1e-12)
    assert Cutter(read_program(WALL), {1: 8.002}).cut(points, normals, [])[0] == pytest.approx([-0.002])
    # a tip that stands 3 um too far in +x, of a wall that looks to -x: 3 um of material too little
    tip = lambda m, n: (np.tile([0.003, 0.0, 0.0], (len(m.time), 1)), np.zeros(len(m.time)))  # noqa: E731
    deviation, moments = Cutter(read_program(WALL), {1: 8.0}).cut(points, normals, [tip])
    assert deviation == pytest.approx([-0.003])
    # it was made 33 mm after the start of that move, at 10 mm/s
    assert moments.q[0].tolist() == pytest.approx([-18.0, 3.0, -5.0])
    assert moments.sense[0, :2].tolist() == [1.0, 1.0]


def test_of_two_passes_over_a_floor_the_deeper_counts():
    text = "T1 M6\nG0 X0. Y0. S100\nG1 Z-5. F100\nG1 X30. F600\nG1 Z-5.004\nG1 X0. F600\n"
    deviation, moments = Cutter(read_program(text), {1: 8.0}).cut(
        np.array([[15.0, 2.0, -5.0]]), np.array([[0.0, 0, 1]]), []
    )
    assert deviation == pytest.approx([-0.004])
    assert moments.sense[0, 0] == -1.0


def test_a_circle_is_cut_small_by_a_lagging_drive():
    # v^2/r / k^2 (1 - f^2)/2 = (20 mm/s)^2 / 10 mm / (33/s)^2 * (1 - 0.98^2) / 2 = 0.727 um
    text = "T1 M6\nG0 X10. Y0. S100\nG1 Z-5. F1200\nG3 X10. Y0. I-10. J0. F1200\n"
    angle = 0.7
    inwards = -np.array([[np.cos(angle), np.sin(angle), 0]])
    cutter = Cutter(read_program(text), {1: 6.0})
    error = lambda m, n: (m.pull * (1 - FORWARD**2) / GAIN**2 / 2, np.zeros(len(m.time)))  # noqa: E731
    deviation, _ = cutter.cut(-16 * inwards + (0, 0, -4), inwards, [error])
    assert deviation[0] * 1e3 == pytest.approx(0.727, abs=0.006)  # chords of 0.1 deg: 4 nm


def test_the_machine_file_moves_walls_by_pencil():
    # at (-83, -49): X 20 um/m too long: -1.66 um; Y leans: +20 urad * 49 mm = 0.98 um; sum -0.68 um in x
    text = "T1 M6\nG0 X-83. Y-60. S100\nG0 Z-14.\nG1 Y60. F300\n"
    cutter = Cutter(read_program(text), {1: 8.0})
    deviation, _ = cutter.cut(np.array([[-75.0, -49.0, -7.0]]), np.array([[-1.0, 0, 0]]), [known])
    assert deviation[0] * 1e3 == pytest.approx(0.68)


def test_a_word_that_the_cutter_does_not_know_is_refused():
    with pytest.raises(ValueError, match="line 2: G81"):
        read_program("G0 X0.\nG81 Z-5. R2. F100\n")


def test_the_axes_of_a_circle_turn_back_and_small_steps_along_a_straight_do_not():
    # counter-clockwise from (10, 0): X goes back on the first half of the turn and forward on the second; Y turns at 90 and 270 deg.
    # The last quarter turn of Y begins at 270 deg; chords are 0.0175 mm long
    text = "T1 M6\nG0 X10. Y0. S100\nG1 Z-5. F600\nG3 X10. Y0. I-10. J0. F600\nG1 X40. F600\nG1 X50. Y0.003\nG1 X60. Y0.\n"
    cutter = Cutter(read_program(text), {1: 6.0})
    middle = (cutter.path.start + cutter.path.end) / 2
    angle = np.degrees(np.arctan2(middle[:, 1], middle[:, 0])) % 360
    circle = cutter.path.block == 3
    for low, high, senses in (
        (20, 80, [-1, 1]),
        (100, 170, [-1, -1]),
        (190, 260, [1, -1]),
        (280, 350, [1, 1]),
    ):
        within = circle & (angle > low) & (angle < high)
        assert within.sum() > 500
        assert np.unique(cutter.senses[within, :2], axis=0).tolist() == [senses]
    assert cutter.senses[-1, :2].tolist() == [1.0, 1.0]


@pytest.mark.parametrize(("x", "normal", "side"), [(-10.0, -1.0, "left"), (10.0, 1.0, "right")])
def test_the_force_of_half_a_mill_in_a_wall(x, normal, side):
    # feed along +Y, the mill left (climb) or right (conventional) of the wall with half of it in the blank, 5 mm deep, 0.1 mm per tooth of 4.
    # With s from the way of the feed towards the wall: F = 4/(2 pi) kc1 b f^0.74 (integrals over a quarter turn):
    #   along the normal, climb          int cos^1.74 + 0.35 int cos^0.74 sin     away from the wall
    #   along the normal, conventional  -int cos^1.74 + 0.35 int cos^0.74 sin
    tip = -18.0 if side == "left" else 18.0
    text = f"T1 M6\nG0 X{tip} Y-60. S1000 M3\nG0 Z-5.\nG1 Y60. F400\n"
    cutter = Cutter(read_program(text), {1: 8.0})
    cutter.force_of = partial(forces, cutter, Blank(36.0, 100.0, 30.0), {1: 4})
    moments = cutter.cut(np.array([[x, 0.0, -3.0]]), np.array([[normal, 0.0, 0.0]]), [])[1]
    whole, sine = math.sqrt(math.pi) / 2 * math.gamma(1.37) / math.gamma(1.87), 1 / 1.74
    size = 4 / (2 * math.pi) * 2100 * 5 * 0.1**0.74
    across = size * ((whole if side == "left" else -whole) + 0.35 * sine)
    assert moments.force[0, 0] * normal == pytest.approx(
        across, rel=0.005
    )  # the middles of 90 pieces of half a turn
    assert moments.force[0, 2] == 0.0
