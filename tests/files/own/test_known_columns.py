"""What is known to be uncertain in a recording, written and read back."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.files.own.known_columns import known_text, read_known
from vcmm.learn.diagnosis.comparison import remove_nuisance
from vcmm.task.response.recording import Recording


def recording(known=()) -> Recording:
    run = Run({"X": np.array([0.0, 10.0, 20.0])}, np.zeros((3, 3)), {"time_s": np.arange(3.0)})
    return Recording(
        "part", "path", run, np.zeros(3), False, np.arange(3), np.tile([1.0, 0, 0], (3, 1)), np.full(3, -1),
        noise=Normal(1e-3), known=known,
    )  # fmt: skip


def test_written_and_read_it_is_the_same(tmp_path):
    radius, scatter = np.array([[2e-3], [2e-3], [0.0]]), np.array([[5e-4, 0.0], [3e-4, 4e-4], [0.0, 5e-4]])
    given = recording((("tool_radius[1].dr", radius), ("scatter.value", scatter)))
    file = tmp_path / "known.csv"
    file.write_text(known_text(given))
    assert file.read_text().splitlines()[:2] == [
        "tool_radius[1].dr_um,scatter.value#1_um,scatter.value#2_um",
        "2.0,0.5,0.0",
    ]
    found = dict(read_known(file, given))
    assert found["tool_radius[1].dr"] == pytest.approx(radius)
    assert found["scatter.value"] == pytest.approx(scatter)


def test_another_number_of_rows_or_no_unit_is_told(tmp_path):
    file = tmp_path / "known.csv"
    file.write_text("tool_radius[1].dr_um\n1\n2\n")
    with pytest.raises(DataError, match=r"known.csv: 2 rows, but the recording has 3 observations"):
        read_known(file, recording())
    file.write_text("tool_radius[1].dr\n1\n2\n3\n")
    with pytest.raises(
        DataError, match=r'known.csv:1: column "tool_radius\[1\].dr" states no unit; its name ends in _um'
    ):
        read_known(file, recording())


def test_known_columns_go_with_their_rows():
    taken = recording((("a", np.array([[1.0], [2.0], [3.0]])),)).take(np.array([2, 0]))
    assert taken.known[0][1].tolist() == [[3.0], [1.0]]


def test_what_rows_share_is_weighed_by_its_covariance():
    """u = 1, K = (sqrt 3, 0): covariance diag(4, 1), its inverse root diag(1/2, 1): departures (2, 1) count as (1, 1)."""
    rest, rank = remove_nuisance(
        np.array([2.0, 1.0]), np.zeros((2, 0)), np.ones(2), np.array([[np.sqrt(3.0)], [0.0]])
    )
    assert rest == pytest.approx([1.0, 1.0])
    assert rank == 0
