"""Results, measurements and scenarios in one line, and by the name of a characteristic."""

from __future__ import annotations

import pytest

import vcmm
from tests.build import scenario
from vcmm.core.errors import UsageError
from vcmm.core.pose import Pose


@pytest.mark.usefixtures("few_parts")
def test_every_object_is_one_line():
    job = scenario()
    found, measured = vcmm.uncertainty(job, trials=1000), vcmm.measure(job)
    for one in (job, found, measured, *found.characteristics):
        assert "\n" not in repr(one)
        assert len(repr(one)) < 400
    # 16 touches of 1 um: u = 0.5 um, U = 1.96 x 0.5 = 0.98 um
    said = repr(found["diameter"]).replace("\u00a0", " ")
    assert said == "<diameter: 30.00000 mm ± 0.98 µm (k = 1.96, p = 95 %), conforms, > 99.9 %>"
    assert measured["diameter"].value == pytest.approx(30.0)
    assert "0.98 µm" in found._repr_html_()
    with pytest.raises(KeyError, match="diameter"):
        found["diametre"]


def test_a_scenario_changes_by_its_own_words_only():
    job = scenario()
    assert job.with_(name="other").name == "other"
    with pytest.raises(UsageError, match='Did you mean "constants"'):
        job.with_(constant={})
    with pytest.raises(UsageError, match=r"takes a pose, not int"):
        job.at(3)
    there = Pose.from_turns([1.0, 2.0, 3.0], [0.0, 0.0, 0.0])
    assert job.at(there).pose is there
