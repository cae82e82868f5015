"""Block M: seconds of one whole diagnosis (1000 rows, null recordings and report included), and whether it repeats.

A fresh process as a user starts it, twice with the same seed. Wall time depends on who else uses the machine; processor time
(all threads) does not, so both are given. The two printed documents and the two reports have to be equal to the last byte.
"""

from __future__ import annotations

import resource
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from benchmarks.exam.asking import LIMIT, START


def _once(recording: Path, seed: int, report: Path) -> tuple[str, str, float, float]:
    words = ["diagnose", str(recording), "--seed", str(seed), "--json", "--report", str(report)]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run([sys.executable, "-c", START, *words], capture_output=True, text=True, timeout=LIMIT, check=False)  # fmt: skip
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"exit {done.returncode}: {done.stderr.strip()[-600:]}")
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return done.stdout, report.read_text(encoding="utf-8"), wall, used


def cost(recording: Path, seed: int) -> dict[str, Any]:
    """wall and processor seconds of two runs, and whether document and report came out the same."""
    first, second = (_once(recording, seed, recording.parent / f"report{i}.html") for i in (1, 2))
    return {
        "wall_s": [first[2], second[2]], "processor_s": [first[3], second[3]],
        "same_document": first[0] == second[0], "same_report": first[1] == second[1],
    }  # fmt: skip
