"""Fixtures and goals: which poses are allowed, faces turned down, departures of a pose, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.task.measuring.fixture import (
    DOWN,
    Fixture,
    Freedom,
    Goal,
    format_freedom,
    off_fixture,
    pose_of,
    six_of,
    turned_down,
)


@pytest.mark.parametrize("direction", [*DOWN.values(), (0.6, 0.0, -0.8), (0.36, 0.48, 0.8)])
def test_a_face_is_turned_down(direction):
    a, b = turned_down(direction)
    assert np.allclose(
        pose_of(np.array([0, 0, 0, a, b, 0])).turn(np.array(direction)), [0, 0, -1], atol=1e-12
    )


def test_plus_x_down_by_hand():
    # Ry(90 deg) takes x = (1, 0, 0) to (cos 90, 0, -sin 90) = (0, 0, -1)
    assert turned_down((1, 0, 0)) == pytest.approx((0.0, np.pi / 2)) or turned_down((1, 0, 0))[
        1
    ] == pytest.approx(np.pi / 2)


def test_departures_by_hand():
    """Ranges, lists (turns go round), slots, faces: mm and rad by which a pose misses them."""
    fixture = Fixture((Freedom("x", 10.0, 20.0), Freedom("turn_z", values=(0.0, np.pi / 2))))
    six = np.array(
        [[7.0, 0, 0, 0, 0, -0.1], [21.5, 0, 0, 0, 0, 2 * np.pi - 0.2], [15.0, 9, 9, 0, 0, np.pi / 2]]
    )
    shift, turn = off_fixture(fixture, six)
    assert shift == pytest.approx([3.0, 1.5, 0.0])
    assert turn == pytest.approx([0.1, 0.2, 0.0])
    slots = Fixture(slots=((0.0, 0.0, 0.0), (100.0, 0.0, 0.0)))
    assert off_fixture(slots, np.array([[97.0, 4.0, 0, 0, 0, 0]]))[0] == pytest.approx([5.0])
    down = Fixture(faces={"bottom": (0.0, 0.0, -1.0), "side": (1.0, 0.0, 0.0)})
    assert off_fixture(down, np.array([[0, 0, 0, 0.3, 0, 1.0]]))[1] == pytest.approx([0.3])
    fixed = Fixture((Freedom("y", values=(5.0, 9.0)),))
    assert off_fixture(fixed, np.array([[0, 6.5, 0, 0, 0, 0.0]]))[0] == pytest.approx([1.5])


def test_a_range_must_not_be_empty():
    assert Freedom("x", 0.0, 1.0).continuous
    assert not Freedom("turn_z", values=(0.0, 1.0)).continuous
    with pytest.raises(UsageError, match="2 is not below 1"):
        Freedom("x", 2.0, 1.0)
    with pytest.raises(UsageError, match="no degree of freedom"):
        Freedom("w", 0.0, 1.0)


def test_one_freedom_is_said_once():
    with pytest.raises(UsageError, match="x is given 2 times"):
        Fixture((Freedom("x", 0.0, 1.0), Freedom("x", 0.0, 2.0)))
    with pytest.raises(UsageError, match="slots sets x already"):
        Fixture((Freedom("x", 0.0, 1.0),), slots=((0.0, 0.0, 0.0),))


def test_every_combination_of_the_choices():
    fixture = Fixture(
        (Freedom("turn_z", values=(0.0, np.pi / 2)), Freedom("turn_x", 0.0, 1.0)),
        slots=((10.0, 0.0, 0.0), (20.0, 0.0, 0.0), (30.0, 0.0, 0.0)),
    )
    orientations = fixture.orientations(np.array([1.0, 2.0, 3.0, 0.0, 0.0, 9.0]))
    assert len(orientations) == 3 * 2
    assert orientations[0][0] == "slot 1, turn_z 0 deg"
    assert orientations[-1][0] == "slot 3, turn_z 90 deg"
    assert orientations[-1][1].tolist() == [30.0, 0.0, 0.0, 0.0, 0.0, np.pi / 2]
    assert [f.name for f in fixture.continuous] == ["turn_x"]


def test_turns_by_hand():
    # +y down: about x by -90 deg takes (0, 1, 0) to (0, 0, -1)
    a, b = turned_down((0.0, 1.0, 0.0))
    assert pose_of(np.array([0, 0, 0, a, b, 0.0])).turn(np.array([0.0, 1.0, 0.0])) == pytest.approx(
        [0, 0, -1]
    )
    assert (a, b) == (pytest.approx(-np.pi / 2), 0.0)


def test_six_numbers_and_back():
    six = np.array([[1.0, 2.0, 3.0, 0.1, -0.2, 0.3], [4.0, 5.0, 6.0, 0.0, 0.0, 3.0]])
    assert six_of(pose_of(six)) == pytest.approx(six)
    assert (format_freedom("turn_x", np.pi), format_freedom("x", 2.5)) == ("180 deg", "2.5 mm")


def test_shares_sum_to_one():
    Goal({"U/T": 0.75, "risk": 0.25}, {"a": 1.0})
    with pytest.raises(
        UsageError, match=r'sum to 2, not to 1; in the same proportion: \{ "U" = 0.5, "U/T" = 0.5'
    ):
        Goal({"U": 1.0, "U/T": 1.0})
    with pytest.raises(UsageError, match="negative"):
        Goal({"U": 1.5, "U/T": -0.5})
    with pytest.raises(UsageError, match="needs costs"):
        Goal({"cost": 1.0})
    with pytest.raises(UsageError, match="is not known"):
        Goal(costs={"coffee": 1.0})
