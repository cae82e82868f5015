"""The `rs274` binary of LinuxCNC (Debian: linuxcnc-uspace), run on a program, and its canonical moves as steps.

VCMM_RS274 names the binary where it is not on the path: the package unpacked beside linuxcnc's libboost-python1.74.0 with
`dpkg-deb -x` will do, LD_LIBRARY_PATH pointing into it. Numbers come with four decimals in the unit of the program.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

from tests.program.oracle import Step, steps

_CALL = re.compile(r"(?:N\d+)?([A-Z]+(?:_[A-Z0-9]+)*)\(([^)]*)\)")
_PLANE = {"CANON_PLANE_XY": 1, "CANON_PLANE_YZ": 2, "CANON_PLANE_XZ": 3}
_TABLE = "T1 P1 Z0 D0.393700787\nT2 P2 Z0.492125984 D0.236220472\n"  # inches, whatever the program says


def binary() -> str:
    """The interpreter; the test is skipped where it is not installed."""
    found = os.environ.get("VCMM_RS274") or shutil.which("rs274")
    if not found:
        pytest.skip(
            "LinuxCNC's rs274 is not here: apt-get install linuxcnc-uspace, or name it with VCMM_RS274"
        )
    return found


def said_of(program: Path, folder: Path, tools: str = _TABLE, seconds: float = 30.0) -> tuple[int, str]:
    """Exit code of the interpreter (124: it does not end) and what it prints for a program."""
    table = folder / "tool.tbl"
    table.write_text(tools, encoding="utf-8")
    try:
        said = subprocess.run(
            [binary(), "-g", "-t", str(table), str(program)], capture_output=True, timeout=seconds,
            env={**os.environ, "HOME": str(folder)}, check=False,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return 124, ""
    return said.returncode, said.stdout.decode("latin-1")


def path_of(text: str, folder: Path) -> list[Step]:
    """The path of a program, mm."""
    program = folder / "p.ngc"
    program.write_text(text, encoding="utf-8")
    code, said = said_of(program, folder)
    assert code == 0, said[-300:]
    return path_said(said)


def path_said(said: str) -> list[Step]:
    """The path in what the interpreter has printed, mm."""
    events: list[list[Any]] = []
    unit, offset = 1.0, [0.0] * 9
    for line in said.splitlines():
        call = _CALL.search(line)
        if call is None:
            continue
        name, words = call[1], re.split(r"[,\s]+", call[2].strip())
        if name == "USE_LENGTH_UNITS":
            unit = 25.4 if "INCH" in words[0] else 1.0
        elif name == "SELECT_PLANE":
            events.append(["plane", 0, _PLANE[words[0]]])
        elif name == "SET_XY_ROTATION":
            events.append(["rot", 0, float(words[0])])
        elif name == "DWELL":
            events.append(["dwell", 0, float(words[0])])
        elif name in _LENGTHS:
            values = [float(w) * unit for w in words]
            events.append([_LENGTHS[name], 0, values])
        elif name == "SET_G5X_OFFSET":
            offset = [float(w) * unit for w in words[1:]] + [0.0] * 3
            events.append(["g5x", 0, [int(words[0]), *offset]])
        elif name == "ARC_FEED":
            a, b, c, d, turns, end = words[:6]
            ends = [float(w) * unit for w in (a, b, c, d)]
            events.append(["A", 0, [*ends, int(turns), float(end) * unit]])
    return steps(events)


_LENGTHS = {
    "STRAIGHT_TRAVERSE": "T", "STRAIGHT_FEED": "F", "SET_G92_OFFSET": "g92", "USE_TOOL_LENGTH_OFFSET": "tlo",
}  # fmt: skip
