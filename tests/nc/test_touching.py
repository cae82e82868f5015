"""First contacts of a ball, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.nc.touching import Face, Round, box_faces, first_contact


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
