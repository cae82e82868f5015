"""A program in pieces with what is off along it, before and after it is rewritten."""

from __future__ import annotations

import numpy as np
import pytest

from tests.compensation.mill import SETUP, scale
from vcmm.compensation.job import compensate
from vcmm.compensation.path_deviations import follow_path
from vcmm.compensation.proof import walk
from vcmm.program.interpret import interpret

PROGRAM = "%\nO1\nG21 G90 G54\nG0 X0 Y0\nG1 X8. F500\nG0 Y20.\nM30\n%\n"


def test_pieces_hang_together_and_rapids_have_no_error():
    # G1 over 8 mm: knots every 2 mm, five of them; the errors 0 1 2 3 4 make pieces of 1 2 3 4
    moves = interpret(PROGRAM, "fanuc", SETUP).moves
    w = walk(moves)
    path = follow_path(moves, w.move, w.tip, np.arange(len(w.move), dtype=float))
    cut = np.isfinite(path.error)
    assert path.error[cut].tolist() == [1.0, 2.0, 3.0, 4.0]
    assert len(path.points) == len(path.error) + 1
    assert np.diff(path.points[:, 0])[cut].tolist() == [2.0] * 4
    assert set(path.line[cut].tolist()) == {5}
    assert path.points[-1] == pytest.approx(moves[-1].end)


def test_both_paths_say_what_the_table_says(tmp_path):
    # +100 um/m: at X = 8 mm 0.8 um too far, after it the last decimal at most
    file = tmp_path / "p.nc"
    file.write_text(PROGRAM)
    found = compensate(file, SETUP, scale(100.0), dialect="fanuc", follow=True, tolerance=1e-4, decimals=4)
    before, after = found.paths
    assert np.nanmax(before.error) == pytest.approx(found.before.largest)
    assert found.before.largest == pytest.approx(0.8e-3)
    assert np.nanmax(after.error) == pytest.approx(found.after.largest)
    assert set(after.line[np.isfinite(after.error)].tolist()) == {
        5
    }  # of the file, not of the text with the mark
    assert compensate(file, SETUP, scale(100.0), dialect="fanuc").paths is None
