"""The referee's cutter against a pencil."""

import numpy as np
import pytest

from referee.cutter import Cutter, read_program
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
