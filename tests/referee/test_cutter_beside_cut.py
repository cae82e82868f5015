"""The referee's cutter and `vcmm cut`, which share nothing, where nothing is concealed."""

import csv
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from referee.cutter import Cutter, read_program
from referee.loops import RADIUS, known

VCMM = Path(sys.executable).parent / "vcmm"


@pytest.mark.thorough
def test_both_cut_the_same_block(tmp_path: Path) -> None:
    """Walls and floors within 3 nm, bores within 0.1 um: there controls lag otherwise than to first order."""
    for words in (["new", "measured_block"], ["cut", "measured_block.toml", "--out", "cut", "--json"]):
        done = subprocess.run([str(VCMM), *words], cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode in (0, 1), done.stderr
    assert json.loads(done.stdout)["surface"]
    with (tmp_path / "cut/surface.csv").open() as file:
        rows = list(csv.DictReader(file))[::57]
    assert len(rows) > 200
    points = np.array([[float(r[f"{a}_mm"]) for a in "xyz"] for r in rows])
    normals = np.array([[float(r[f"n{a}"]) for a in "xyz"] for r in rows])
    cutter = Cutter(read_program((tmp_path / "measured_block/part.nc").read_text()), RADIUS)
    apart = cutter.cut(points, normals, [known])[0] * 1e3 - np.array([float(r["deviation_um"]) for r in rows])
    bore = np.array([r["feature"].startswith("bore") for r in rows])
    assert bore.any()
    assert np.abs(apart[~bore]).max() < 0.003
    assert np.abs(apart[bore]).max() < 0.1
