"""Recordings joined: rows, labels, clocks and nuisance of each stay its own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.core.run import Run, Series
from vcmm.task.response.folds import fold_masks
from vcmm.task.response.joining import SETTLING_TIME, join_recordings
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import calibration_columns, known_here
from vcmm.task.response.recording import Recording


def recording(name: str, n: int = 3, kind: str = "probe", nuisance=None, **columns) -> Recording:
    run = Run({a: np.arange(float(n)) for a in "XYZ"}, np.zeros((n, 3)), {k: np.asarray(v) for k, v in columns.items()},
              {"pose": np.array(["a", "a", "b"][:n]), "stylus": np.full(n, "s")})  # fmt: skip
    along = np.tile([1.0, 0.0, 0.0], (n, 1))
    value = np.arange(n) * 1e-3
    return Recording(
        name, kind, run, value, True, np.arange(n), along, np.full(n, -1), None, nuisance or {}, Normal(1e-3)
    )


def test_rows_follow_one_another_and_know_whose_they_are():
    both = join_recordings([recording("A"), recording("B", 2)], make.machine())
    assert both.recording.row.tolist() == [0, 1, 2, 3, 4]
    assert both.part.tolist() == [0, 0, 0, 1, 1]
    assert both.recording.value.tolist() == [0.0, 1e-3, 2e-3, 0.0, 1e-3]
    assert both.recording.run.labels["recording"].tolist() == ["A", "A", "A", "B", "B"]
    assert both.recording.run.labels["pose"].tolist() == ["A a", "A a", "A b", "B a", "B a"]
    assert both.recording.run.labels["stylus"].tolist() == ["s"] * 5  # the same thing
    assert both.recording.noise == Normal(1e-3)
    folds = dict(fold_masks(both.recording.run, both.recording.row))
    assert folds["recording B"].tolist() == [False, False, False, True, True]


def test_nuisance_has_a_copy_per_recording_and_none_where_it_has_none():
    first = recording("A", nuisance={"zero": "", "offset": "pose"})
    both = join_recordings([first, recording("B", nuisance={"zero": ""})], make.machine()).recording
    columns, names = nuisance_columns(both, make.machine())
    known = dict(zip(names, columns.T.tolist()))
    assert known["zero[zero of recording=A]"] == [1, 1, 1, 0, 0, 0]
    assert known["zero[zero of recording=B]"] == [0, 0, 0, 1, 1, 1]
    assert known["offset[offset of recording=A b].shift_x"] == [0, 0, 1, 0, 0, 0]
    assert len(names) == 4


def test_noise_that_differs_becomes_an_uncertainty_of_every_row():
    loud = replace(recording("B", 2), noise=Normal(3e-3))
    both = join_recordings([recording("A", 2), loud], make.machine()).recording
    assert both.noise is None
    assert both.u == pytest.approx([1e-3, 1e-3, 3e-3, 3e-3])


def test_columns_that_one_of_them_lacks_are_left_out_and_named():
    both = join_recordings([recording("A", temp_air_C=[20.0, 21, 22]), recording("B")], make.machine())
    assert "temp_air_C" not in both.recording.run.columns
    assert both.left_out == {"temp_air_C": ("B",)}


def test_a_second_clock_begins_after_the_first_one_has_settled():
    time = np.array([0.0, 60.0, 120.0])
    one = recording("A", time_s=time, temp_air_C=[20.0, 21.0, 22.0])
    two = recording("B", time_s=time, temp_air_C=[25.0, 25.0, 25.0])
    logs = [{"air": Series(time, r.run.columns["temp_air_C"])} for r in (one, two)]
    pair = [replace(r, run=replace(r.run, series=s)) for r, s in zip((one, two), logs)]
    both = join_recordings(pair, make.machine()).recording.run
    assert both.column("time_s")[3:] == pytest.approx(time + 120.0 + SETTLING_TIME)
    # behind a lag of an hour the second one stands at 25 degC from its first row on, as it does alone
    assert both.lag("air", 3600.0)[3:] == pytest.approx([25.0] * 3, abs=1e-9)
    later = replace(two, run=replace(two.run.with_columns({"time_s": time + 130.0}), series={}))
    on_one_clock = join_recordings(
        [replace(one, run=replace(one.run, series={})), later], make.machine()
    ).recording
    assert on_one_clock.run.column("time_s")[3] == 130.0


def test_what_cannot_be_joined():
    with pytest.raises(UsageError, match="several kinds"):
        join_recordings([recording("A"), recording("B", kind="path")], make.machine())
    with pytest.raises(UsageError, match='two recordings are called "A"'):
        join_recordings([recording("A"), recording("A")], make.machine())


def test_what_is_known_of_the_machine_is_common_and_of_a_recording_its_own():
    """The scale of X is one number of the machine, so one column over all rows; each radius was set for its own part."""
    scale = Input("scale_factor", "X", "k", Normal(1e-6))
    machine = replace(make.machine(), inputs=(scale,))
    given = [
        replace(
            recording(name, 2),
            known=((scale.id, np.full((2, 1), k)), ("tool_radius[1].dr", np.full((2, 1), 2e-3))),
        )
        for name, k in (("A", 1e-4), ("B", 3e-4))
    ]
    known = dict(join_recordings(given, machine).recording.known)
    assert known[scale.id].ravel().tolist() == [1e-4, 1e-4, 3e-4, 3e-4]
    assert known["A: tool_radius[1].dr"].ravel().tolist() == [2e-3, 2e-3, 0.0, 0.0]
    assert known["B: tool_radius[1].dr"].ravel().tolist() == [0.0, 0.0, 2e-3, 2e-3]
    both = join_recordings(given, machine).recording
    assert known_here(both, machine).shape == (4, 2)  # what is no number of the machine
    stated = [name for name, _ in calibration_columns(both, machine)]
    assert stated.count(scale.id) == 1  # in place of what the Input itself would do
