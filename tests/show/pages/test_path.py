"""The path of a cut, coloured by what the machine does wrong along it."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import vcmm
from vcmm.compensation.field import field_of, known_errors_of
from vcmm.compensation.proof import errors_on, walk
from vcmm.program.interpret import read_for
from vcmm.shop.motion.tool_centre import orient_moves
from vcmm.show.pages.path import _of_cut

SCENARIOS = Path(__file__).parents[3] / "scenarios"
HEAD, STEP = 8, 24  # blocks before the first cut of the cone; of the blocks behind it one in so many


@pytest.mark.thorough
def test_a_led_tip_errs_in_the_picture_as_where_compensation_asks(tmp_path):
    """One from motions of the axes, one from the tip over the workpiece, where the control turns its zero with the part.

    Taken off along the axes of the machine, the zero left 4.5 um of 19.4, where the surface stands 18.3 um off (surface.csv).
    """
    shutil.copytree(SCENARIOS / "cone_frustum", tmp_path / "cone_frustum")
    shutil.copy(SCENARIOS / "cone_frustum.toml", tmp_path)
    program = tmp_path / "cone_frustum" / "part.nc"
    lines = program.read_text().splitlines()
    program.write_text("\n".join([*lines[:HEAD], *lines[HEAD:-12:STEP], "M30", "%"]))
    scenario = vcmm.load_cut(tmp_path / "cone_frustum.toml")

    path = _of_cut(scenario)
    shown = dict(zip(np.asarray(path.line).tolist(), path.error.tolist()))  # the last piece of every block

    read = read_for("cut", program.read_text(), scenario.dialect, scenario.setup, name="part.nc")
    moves, _ = orient_moves(read.moves, scenario.machine)
    known = known_errors_of(scenario.machine).whole()
    w = walk(moves)
    e = errors_on(field_of(known, scenario.setup, moves, set_here=True, constants=scenario.constants), w)
    asked = {
        moves[i].source.line: size for i, size in zip(w.move.tolist(), np.linalg.norm(e, axis=1).tolist())
    }

    lines_of_cut = [n for n in asked if n > HEAD]
    assert len(lines_of_cut) > 10
    assert max(shown[n] for n in lines_of_cut) == pytest.approx(19.4e-3, abs=0.1e-3)
    assert [shown[n] for n in lines_of_cut] == pytest.approx([asked[n] for n in lines_of_cut], abs=5e-5)
