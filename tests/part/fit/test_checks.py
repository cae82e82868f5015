"""What a fit refuses, and how it names what the points leave open."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.part.fit.checks import check_convergence, check_points, check_rank, element_of
from vcmm.part.fit.elements import ELEMENTS


def test_words_and_shapes():
    with pytest.raises(UsageError, match="cylinder"):
        element_of("cylindre")
    with pytest.raises(UsageError, match=r"shape \(\.\.\., n, 3\)"):
        check_points(ELEMENTS["plane"], np.zeros((3, 2)), False, "top")
    with pytest.raises(UsageError, match="has no axis"):
        check_points(ELEMENTS["sphere"], np.zeros((4, 3)), True, "ball")
    with pytest.raises(UsageError, match=r"coordinate \(1, 2\) is not a finite"):
        check_points(ELEMENTS["plane"], np.array([[0.0, 0, 0], [0, 1, np.nan], [1, 0, 0]]), False, "top")


def test_least_numbers_of_points():
    # a cylinder: two shifts, two tilts, a radius; with a known axis two and a radius
    with pytest.raises(ModelLimit, match="at least 5 points, got 4"):
        check_points(ELEMENTS["cylinder"], np.zeros((4, 3)), False, "bore")
    with pytest.raises(ModelLimit, match="with a fixed axis needs at least 3 points, got 2"):
        check_points(ELEMENTS["cylinder"], np.zeros((2, 3)), True, "bore")
    check_points(ELEMENTS["line"], np.zeros((2, 3)), False, "edge")  # two numbers each


def test_the_member_that_did_not_converge():
    check_convergence(ELEMENTS["cone"], np.array([True, True]), "cone")
    with pytest.raises(ModelLimit, match=r"2 of 3 fits did not converge \(the first is number 1\)"):
        check_convergence(ELEMENTS["cone"], np.array([True, False, False]), "cone")


def test_the_direction_left_open_is_named():
    # a normal matrix of a plane without curvature about x
    plane = ELEMENTS["plane"]
    with pytest.raises(ModelLimit, match=r"tilt of the plane about \(1\.000, 0\.000, 0\.000\)"):
        check_rank(plane, plane.pose, np.diag([1.0, 0.0, 1.0])[None], np.eye(3)[None], "top")
    check_rank(plane, plane.pose, np.eye(3)[None], np.eye(3)[None], "top")
