"""The best single shift of a work offset, by hand."""

from __future__ import annotations

import pytest

from tests.compensation.mill import SETUP, scale
from tests.compensation.test_contours import HEAD
from vcmm.compensation.offsets import best_offsets


def test_half_of_what_a_scale_errs_by_is_shifted_away(tmp_path) -> None:
    """100 um/m from X 0 to 100: 0 to 10 um, 5 um in the mean, so -5 um of shift leaves 5 um at both ends."""
    path = tmp_path / "part.nc"
    path.write_text(f"{HEAD}G0 X0\nG1 X100. F500\nM30\n%\n")
    found = best_offsets(path, SETUP, scale(100.0))
    assert found.shifts["G54"] == pytest.approx([-5e-3, 0.0, 0.0], abs=1e-6)
    assert found.before.largest == pytest.approx(10e-3, abs=1e-6)
    assert found.offset_only.largest == pytest.approx(5e-3, abs=1e-6)
    assert found.before.line == 6
