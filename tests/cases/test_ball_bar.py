"""The ball bar that `vcmm new ballbar` copies: what was concealed in it is found."""

from __future__ import annotations

import numpy as np
import pytest
from vcmm_twins.ballbar import recorded as ball_bar

import vcmm
from vcmm.files.own.library import companions, example, folder


def test_the_files_of_the_example_are_what_the_case_makes():
    for name, made in ball_bar.texts().items():
        assert (folder() / "ballbar" / name).read_text(encoding="utf-8") == made
    assert set(companions("ballbar")) == {"ballbar/circles.csv", "ballbar/machine.toml"}


def test_a_quarter_by_hand():
    """At 90 deg, running to -X after +X ended at 0 deg: Y upwards: -24 urad x 150 mm lies across the bar, Y stops 3.5 um short."""
    place, sense, length = ball_bar.readings()
    at = int(np.argmin(np.abs(place[:, 0]) + np.abs(place[:, 1] - 150.0)))
    assert sense[at].tolist() == [-1.0, 1.0]
    assert length[at] == pytest.approx(-3.5e-3, abs=1e-3)


@pytest.mark.thorough
def test_play_and_squareness_are_named():
    recording, machine = vcmm.load_recording(example("ballbar"))
    found = vcmm.diagnose(recording, machine)
    sizes = {(a.effect, *a.where.values()): a for a in found.found}
    assert set(sizes) == {("backlash", "Y"), ("backlash", "X"), ("squareness", "C0Y")}
    for key, name, true in (
        (("backlash", "Y"), "gap", 7.0),
        (("backlash", "X"), "gap", 3.0),
        (("squareness", "C0Y"), "angle", 24.0),
    ):
        low, high = sizes[key].parameters[name].interval95
        assert low <= true <= high
