"""First contacts of a ball, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.program.touching import Face, Round, box_faces, first_contact, left_contact, stopped_at


def test_a_ball_stops_its_radius_before_a_face():
    face = Face((10.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    tip, along, normal = first_contact([face], (0.0, 5.0, -2.0), (30.0, 5.0, -2.0), 3.0, (0.0, 0.0, 3.0))
    assert (tip, along, normal) == ((7.0, 5.0, -2.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0))


def test_a_slanted_way_is_longer_by_one_over_the_cosine():
    # 45 deg to the face: the centre is 3 mm off it where it has gone 7 mm in X, 7 sqrt 2 along the way
    face = Face((10.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    tip, along, _ = first_contact([face], (0.0, 0.0, 0.0), (20.0, 20.0, 0.0), 3.0)
    assert tip == pytest.approx((7.0, 7.0, 0.0), abs=1e-12)
    assert along == pytest.approx((math.sqrt(0.5), math.sqrt(0.5), 0.0))


def test_from_above_the_lowest_point_of_the_ball_touches():
    face = Face((0.0, 0.0, -200.0), (0.0, 0.0, 1.0))
    tip, _, _ = first_contact([face], (5.0, 5.0, -180.0), (5.0, 5.0, -210.0), 3.0, (0.0, 0.0, 3.0))
    assert tip == (5.0, 5.0, -200.0)


def test_in_a_bore_the_centre_goes_to_the_difference_of_the_radii():
    # R 15, r 3: 12 from the axis; 5 beside it sqrt(144 - 25) = 10.9087
    bore = Round((100.0, 50.0, 0.0), 15.0, inside=True)
    tip, _, normal = first_contact([bore], (100.0, 50.0, -5.0), (120.0, 50.0, -5.0), 3.0)
    assert tip == (112.0, 50.0, -5.0)
    assert normal == (-1.0, 0.0, 0.0)
    tip, _, _ = first_contact([bore], (100.0, 55.0, -5.0), (120.0, 55.0, -5.0), 3.0)
    assert tip[0] == pytest.approx(100.0 + math.sqrt(119.0), abs=1e-12)


def test_on_a_boss_it_stops_at_the_sum_of_the_radii():
    boss = Round((0.0, 0.0, 0.0), 15.0, inside=False)
    tip, _, normal = first_contact([boss], (-40.0, 0.0, 0.0), (0.0, 0.0, 0.0), 3.0)
    assert tip == (-18.0, 0.0, 0.0)
    assert normal == (-1.0, 0.0, 0.0)
    assert first_contact([boss], (-40.0, 18.5, 0.0), (40.0, 18.5, 0.0), 3.0) is None


def test_the_nearest_side_of_a_box_counts_and_what_passes_it_meets_nothing():
    box = box_faces((-50.0, -30.0, -30.0), (100.0, 60.0, 30.0))
    assert first_contact(box, (-70.0, 0.0, -8.0), (70.0, 0.0, -8.0), 3.0, (0.0, 0.0, 3.0))[0] == (
        -53.0,
        0.0,
        -8.0,
    )
    assert first_contact(box, (70.0, 0.0, -8.0), (-70.0, 0.0, -8.0), 3.0, (0.0, 0.0, 3.0))[0] == (
        53.0,
        0.0,
        -8.0,
    )
    assert first_contact(box, (-70.0, 0.0, 5.0), (70.0, 0.0, 5.0), 3.0, (0.0, 0.0, 3.0)) is None
    assert first_contact(box, (-70.0, 0.0, -8.0), (-60.0, 0.0, -8.0), 3.0) is None  # ends before it


def test_a_ball_that_touches_already_is_in_contact():
    boss = Round((0.0, 0.0, 0.0), 10.0, inside=False)
    for start in (-13.0, -13.000000001, -12.9999999999):
        tip, _, _ = first_contact([boss], (start, 0.0, 0.0), (0.0, 0.0, 0.0), 3.0)
        assert tip[0] == pytest.approx(-13.0, abs=1e-8)


def test_a_ball_over_the_edge_of_a_box_stops_on_the_edge():
    # 1 mm over the top at z 0, r 3: sqrt(9 - 1) = 2.8284 before the side at x -50; the normal leans by 1/3
    box = box_faces((-50.0, -30.0, -30.0), (100.0, 60.0, 30.0))
    tip, _, normal = first_contact(box, (-70.0, 0.0, 1.0), (70.0, 0.0, 1.0), 3.0)
    assert tip == pytest.approx((-50.0 - math.sqrt(8.0), 0.0, 1.0), abs=1e-12)
    assert normal == pytest.approx((-math.sqrt(8.0) / 3.0, 0.0, 1.0 / 3.0), abs=1e-12)
    # a corner: 1 mm over the top and 1 mm beside the side at y 30: sqrt(9 - 2) before
    tip, _, _ = first_contact(box, (-70.0, 31.0, 1.0), (70.0, 31.0, 1.0), 3.0)
    assert tip[0] == pytest.approx(-50.0 - math.sqrt(7.0), abs=1e-12)
    assert first_contact(box, (-70.0, 0.0, 3.1), (70.0, 0.0, 3.1), 3.0) is None


def test_a_boss_ends_where_it_ends():
    boss = Round((0.0, 0.0, 0.0), 15.0, inside=False, low=-10.0, high=0.0)
    assert first_contact([boss], (-40.0, 0.0, -5.0), (40.0, 0.0, -5.0), 3.0)[0][0] == -18.0
    assert first_contact([boss], (-40.0, 0.0, 1.0), (40.0, 0.0, 1.0), 3.0) is None
    assert first_contact([boss], (-40.0, 0.0, -11.0), (40.0, 0.0, -11.0), 3.0) is None


def test_a_ball_that_lies_on_a_surface_leaves_it_where_it_is():
    face = Face((10.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    assert left_contact([face], (7.0, 5.0, -2.0), (0.0, 5.0, -2.0), 3.0) == (
        (7.0, 5.0, -2.0), (-1.0, 0.0, 0.0), (-1.0, 0.0, 0.0),
    )  # fmt: skip
    assert left_contact([face], (6.9, 5.0, -2.0), (0.0, 5.0, -2.0), 3.0) is None


def test_what_is_expected_stops_a_way_beside_it():
    # 2 um beside the way it stops as far along it, on the way itself
    found = stopped_at((0.0, 0.0, 0.0), (5.0, 0.002, 0.0), (10.0, 0.0, 0.0))
    assert found == ((5.0, 0.0, 0.0), (1.0, 0.0, 0.0), (-1.0, 0.0, 0.0))
    assert stopped_at((0.0, 0.0, 0.0), (11.0, 0.0, 0.0), (10.0, 0.0, 0.0)) is None
    assert stopped_at((0.0, 0.0, 0.0), (-1.0, 0.0, 0.0), (10.0, 0.0, 0.0)) is None
