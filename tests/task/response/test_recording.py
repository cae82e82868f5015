"""Recording: shapes, words and numbers are checked; groups by label; parts of a recording for hold-out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.laws import StudentT
from vcmm.core.run import Run
from vcmm.task.response.recording import RECORDING_KINDS, Recording

X = np.array([1.0, 0.0, 0.0])


def recording(kind: str = "probe", n: int = 4, **changes) -> Recording:
    """n observations along x, one per row, poses a a b b."""
    labels = {"pose": np.array(["a", "a", "b", "b"][:n]), "stylus": np.array(["s"] * n)}
    run = Run({a: np.arange(float(n)) for a in "XYZ"}, np.zeros((n, 3)), {}, labels)
    given = {
        "value": np.arange(n) * 1e-3,
        "measuring": True,
        "row": np.arange(n),
        "direction": np.tile(X, (n, 1)),
        "other": np.full(n, -1),
    }
    return Recording("r", kind, run, **(given | changes))


def test_the_sense_gives_the_sign_of_the_tip_motion():
    assert recording().sign == -1.0
    assert recording(measuring=False).sign == 1.0
    assert recording().m == 4


def test_groups_follow_the_rows_of_the_observations():
    twice = recording(
        row=np.array([3, 0, 3]), value=np.zeros(3), direction=np.tile(X, (3, 1)), other=np.full(3, -1)
    )
    assert twice.groups("pose") == (("a", "b"), pytest.approx([1, 0, 1]))


@pytest.mark.parametrize("label", ["", "run", "clamp"])
def test_all_rows_are_one_group_without_a_label(label):
    names, codes = recording().groups(label)
    assert names == ("",)
    assert codes.tolist() == [0, 0, 0, 0]


def test_take_keeps_the_run_and_the_rest():
    whole = recording(u=np.array([1.0, 2.0, 3.0, 4.0]), nuisance={"rigid": "pose"}, noise=StudentT(1e-3, 6))
    part = whole.take(np.array([False, True, False, True]))
    assert part.row.tolist() == [1, 3]
    assert part.value.tolist() == [1e-3, 3e-3]
    assert part.u is not None
    assert part.u.tolist() == [2.0, 4.0]
    assert part.run is whole.run
    assert part.noise is whole.noise
    assert part.nuisance == {"rigid": "pose"}
    assert part.groups("pose")[1].tolist() == [0, 1]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"direction": np.zeros((4, 3))}, "directions of length 1"),
        ({"direction": np.tile(2 * X, (4, 1))}, "directions of length 1"),
        ({"value": np.array([0.0, np.nan, 0.0, 0.0])}, "must be finite"),
        ({"value": np.zeros((4, 1))}, "row has shape"),
        ({"row": np.array([0, 1, 2, 4])}, "beyond the 4 rows"),
        ({"row": np.array([0, 1])}, "row has shape"),
        ({"other": np.array([0, 1, 2, 3])}, "only a length has a second end"),
        ({"u": np.array([1.0, 0.0, 1.0, 1.0])}, "above zero"),
        ({"nuisance": {"rigit": "pose"}}, 'Did you mean "rigid"'),
    ],
)
def test_what_is_refused(changes, words):
    with pytest.raises(UsageError, match=words):
        recording(**changes)


def test_a_sense_that_is_no_direction_is_refused_with_its_row():
    good = recording()
    with pytest.raises(UsageError, match="sense_X is 10 in row 3"):
        replace(good, run=good.run.with_columns({"sense_X": np.array([1.0, -1.0, 10.0, 0.0])}))


def test_a_mistyped_kind_is_answered_with_the_closest():
    with pytest.raises(UsageError, match=r'Did you mean "displacement".*Allowed: probe, displacement'):
        recording("displacment")
    assert len(RECORDING_KINDS) == 5
