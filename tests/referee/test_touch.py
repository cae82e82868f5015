"""The referee's five-axis machine: numbers by pencil."""

import math

import numpy as np
import pytest

from referee import touch as own


def test_a_place_of_the_table_where_contract_and_pencil_have_it():
    # C turned by +90 deg turns the table by -90 deg: (100, 0, 0) goes to (0, -100, 0); A by +90 deg: (0, -100, 0) to (0, 0, 100)
    turn, shift = own.on_table(own.Five(), math.pi / 2, math.pi / 2)
    assert turn @ [100, 0, 0] + shift == pytest.approx([0, 0, 100], abs=1e-12)
    # X0C = +20 um moves the table by +20 um along X at any C; Y0C turns with A: at A = 90 deg its +10 um are -10 um along Z
    turn, shift = own.on_table(own.Five({"X0C": 0.02, "Y0C": 0.01}), math.pi / 2, 1.0)
    assert shift == pytest.approx([0.02, 0, -0.01], abs=1e-12)


def test_a_touch_stops_where_the_ball_meets_and_goes_on_by_its_pre_travel():
    start = np.array([40.0, 0, 0])
    met = own.touch(own.Five(), np.zeros(3), start, np.array([-1.0, 0, 0]))
    assert met == pytest.approx([15.5, 0, 0], abs=1e-12)  # 12.5 + 3
    probe = {"offset": np.array([1e-3, 0, 0]), "lobes": np.array([0, 0, 5e-4, 0]), "axial": 0.0, "mean": 4e-3}
    late = own.touch(own.Five(probe=probe), np.zeros(3), start, np.array([-1.0, 0, 0]))
    # the ball is 1 um further out, so it meets at 15.499; pre-travel at 0 deg 4 + 0.5 um: 15.4945
    assert late == pytest.approx([15.4945, 0, 0], abs=1e-9)


def test_the_mean_of_a_tilt_is_no_angular_position_error():
    machine = own.Five(angle={"A": [(1, 1e-5, 0.3)]})
    grid = np.radians(np.linspace(-60, 60, 2001))
    assert abs(machine.angular("A", grid).mean()) < 1e-12
    assert np.ptp(machine.angular("A", grid)) == pytest.approx(1e-5 * np.ptp(np.sin(grid + 0.3)), rel=1e-6)


def test_the_table_counts_what_is_held():
    line = {"touches": {n: [1.0, 1.0, 1.0] for n in (*own.LOCATIONS, "EAA@0", "ECC@0")}}
    line["R-test"] = {n: [3.0, 1.0, 3.0] for n in line["touches"]}
    text = own.table([line, line])
    assert "| Y0A | 2 of 2 | 1 um | 1 um | 0 of 2 | 3 um | 1 um |" in text
    assert "touches: locations 16 of 16, 1.000, in 2 machines" in text
