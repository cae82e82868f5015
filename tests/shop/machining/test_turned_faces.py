"""Faces of a turned part: rings about the spindle, from where the program leaves the face, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shop.machining import lathe
from vcmm.shop.machining.turned_faces import OFF, _ring_points, is_face, radii


@pytest.fixture(scope="module")
def job(tmp_path_factory):
    return lathe.shop(lathe.write(tmp_path_factory.mktemp("shaft")))


def test_the_shoulder_reaches_from_the_journal_to_the_taper(job):
    """Drawn 30 mm across; the journal of 20 mm and the fillet of the nose of 0.8 mm bound it inside: sqrt(2 x 0.8 x 0.01) more."""
    step = job.scenario.part.features["step"]
    assert is_face(step, job.pose, job.process.turning)
    assert not is_face(job.scenario.part.features["seat"], job.pose, job.process.turning)
    inner, outer = radii(step, job.pose, job.process.turning)
    assert outer == 15.0
    assert 10.0 < inner < 11.2


def test_a_net_of_rings(job):
    over = job.process.net(job, job.scenario.part.features["step"], 11)
    r = np.hypot(over.points[:, 0], over.points[:, 1])
    assert len(over.first) == 21
    assert (r.min(), r.max()) == (pytest.approx(over.second[0]), pytest.approx(over.second[-1]))
    assert over.points[:, 2] == pytest.approx(np.full(len(r), -30.0))
    assert pytest.approx(0.05) == OFF


def test_a_cylinder_keeps_from_its_fillets(job):
    """20 mm long: 1.25 noses, 1 mm, at either end."""
    over = job.process.net(job, job.scenario.part.features["journal"], 11)
    assert (over.second[0], over.second[-1]) == pytest.approx((1.0, 19.0))


def test_the_usual_points_of_a_face(job):
    """Four rings of 24 points each, 15 deg apart, from a tenth of the width inside either edge: 10 to 20 mm gives 11 and 19 mm."""
    points = _ring_points(10.0, 20.0, job.scenario.part.features["step"])
    angle, r = np.arctan2(points[:, 1], points[:, 0]), np.hypot(points[:, 0], points[:, 1])
    assert len(points) == 96
    assert r[::24] == pytest.approx([11.0, 11.0 + 8 / 3, 11.0 + 16 / 3, 19.0])
    assert r == pytest.approx(np.repeat(r[::24], 24))
    steps = np.degrees(np.diff(angle[:24])) % 360.0
    assert np.minimum(steps, 360.0 - steps) == pytest.approx(np.full(23, 15.0))
