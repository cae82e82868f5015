"""Readings that stand out of a scanned face, by pencil."""

from __future__ import annotations

import numpy as np

from vcmm.learn.calibration.face_map import map_face
from vcmm.learn.calibration.face_outliers import outlier_remarks
from vcmm.task.instruments.face_scan import FaceScan

UM = 1e-3  # mm


def scan(reading: np.ndarray) -> FaceScan:
    """A spiral from 20 to -20 mm, 72 readings a turn."""
    n = len(reading)
    x, c = np.linspace(20.0, -20.0, n), 2 * np.pi * np.arange(n) / 72
    return FaceScan("face", True, x, c, reading, np.full(n, ""))


def test_one_reading_of_3000_is_named_with_its_place() -> None:
    """0.05 um of scatter and one reading of 500 um at row 900: X = 20 - 40 x 900 / 2999 = 7.996 mm, C = 5 x 900 = 4500 deg."""
    d = 0.05 * UM * np.random.default_rng(3).standard_normal(3000)
    assert not any("stand" in w for w in map_face(scan(d)).warnings)
    d[900] = 500 * UM
    (said,) = [w for w in map_face(scan(d)).warnings if "stand" in w]
    assert said.startswith("1 reading stands out of the ")
    assert "X 7.99" in said
    assert "C 4500 deg (500 um)" in said


def test_what_many_readings_show_is_of_the_face() -> None:
    """5 of 1000 (0.5 %) are told, 20 (2 %) are a feature of the face. 30 times the scatter stands out, 6 times does not."""
    rest = 0.05 * UM * np.random.default_rng(4).standard_normal(1000)
    for count, size, told in ((5, 30.0, True), (20, 30.0, False), (5, 6.0, False)):
        some = rest.copy()
        some[40 : 40 + 40 * count : 40] = size * 0.05 * UM
        assert bool(outlier_remarks(scan(some), np.ones((1000, 1)), some, some - some.mean())) == told
