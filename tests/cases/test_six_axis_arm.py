"""The arm that `vcmm new six_axis_arm` copies: its files, and that they find what was concealed in it."""

from __future__ import annotations

import numpy as np
import pytest
from vcmm_twins.six_axis_arm import recorded

from vcmm.files.own.library import companions, example, folder
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording_data import load_poses
from vcmm.learn.calibration.arm import fit_arm
from vcmm.learn.calibration.pose_tests import put_to_poses


def _numbers(text: str) -> np.ndarray:
    return np.array([[float(v) for v in row.split(",")] for row in text.splitlines()[1:]])


def test_the_files_of_the_example_are_what_the_case_makes():
    made = recorded.texts()
    for name, text in made.items():
        stored = (folder() / "six_axis_arm" / name).read_text(encoding="utf-8")
        assert stored.splitlines()[0] == text.splitlines()[0]
        assert _numbers(stored) == pytest.approx(_numbers(text), abs=2e-6)
    tables = {f"six_axis_arm/{n}.toml" for n in ("machine", "others")}
    assert set(companions("six_axis_arm")) == tables | {f"six_axis_arm/{n}" for n in made}


@pytest.mark.thorough
def test_it_finds_what_was_concealed():
    machine = load_machine(folder() / "six_axis_arm" / "machine.toml")
    fit = fit_arm([load_poses(example("six_axis_arm"), machine)], machine)
    # concealed: shoulder 0.40 mrad x sin of its angle and 0.25 mrad x cos of both, elbow 0.30 mrad x cos of both
    due = {
        "elastic_joint[B2,B2]": (0.0, 4e-4),
        "elastic_joint[B2,B2 B3]": (2.5e-4, 0.0),
        "elastic_joint[B3,B2 B3]": (3e-4, 0.0),
    }
    found = {t.name: fit.values(t) for t in fit.terms if t.size == 2}
    assert found.keys() == due.keys()
    for name, (value, u) in found.items():
        assert np.abs(value - due[name]).max() < 4 * u.max(), name
    others = load_poses(folder() / "six_axis_arm" / "others.toml", machine)
    test = put_to_poses(others, machine, fit.machine, fit.placements[0])
    assert test.before > 0.5
    assert test.in_place is not None
    assert test.in_place < 0.024  # 20 um of noise, and what 40 poses leave open
