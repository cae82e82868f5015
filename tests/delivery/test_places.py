"""Where nothing can be kept, and where two write at once: the same document, no traceback."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from vcmm.files.own.library import example

pytestmark = pytest.mark.thorough
VCMM = [sys.executable, "-c", "from vcmm.face.cli import main; main()"]
MANY = (
    "--trials",
    "1200000",
    "--engine",
    "montecarlo",
)  # five blocks, and kernels are worth their compilation


def started(folder: Path, *words: str, **places: str) -> subprocess.Popen[str]:
    kept = {k: v for k, v in os.environ.items() if k not in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME")}
    return subprocess.Popen(
        [*VCMM, "uncertainty", str(example("ring_gauge")), *words],
        cwd=folder, env=kept | places, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip


def test_a_home_that_cannot_be_written(tmp_path: Path) -> None:
    """/dev/null is no folder, for root neither: no kernels and no blocks are kept, and nobody is told of it."""
    nowhere = {"HOME": "/dev/null", "PYTHONPYCACHEPREFIX": "/dev/null"}
    runs = [
        started(tmp_path, *MANY, "--json"),
        started(tmp_path, *MANY, "--json", "--workers", "2", **nowhere),
    ]
    (whole, _), (bare, said) = (r.communicate() for r in runs)
    assert [r.returncode for r in runs] == [0, 0], said
    assert bare == whole
    assert not [line for line in said.splitlines() if "dev/null" in line or "Traceback" in line]


def test_two_at_once_on_one_kernel_cache_and_one_output(tmp_path: Path) -> None:
    both = [
        started(tmp_path, *MANY, "--out", "made", NUMBA_CACHE_DIR=str(tmp_path / "kernels")) for _ in range(2)
    ]
    ends = [one.communicate() for one in both]
    assert [one.returncode for one in both] == [0, 0], ends
    assert sorted(p.name for p in (tmp_path / "made").iterdir()) == [
        "budget.csv",
        "report.html",
        "uncertainty.json",
    ]
    assert json.loads((tmp_path / "made" / "uncertainty.json").read_text())["trials"] == 1_200_000
