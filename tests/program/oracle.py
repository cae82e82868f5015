"""Answers of LinuxCNC's interpreter, turned into the same form as our moves."""

from __future__ import annotations

import json
import math
import os
from pathlib import Path
from typing import Any

import pytest

from vcmm.program.moves import Move
from vcmm.program.setup import Setup, Tool

FOLDER = Path(os.environ.get("VCMM_DATA", "")) / "data" / "nc"
PLANES = {1: ("XY", 0, 1, 2), 2: ("YZ", 1, 2, 0), 3: ("ZX", 2, 0, 1)}
SETUP = Setup(
    tools={1: Tool(1, 0.0, 10.0), 2: Tool(2, 12.5, 6.0), 3: Tool(3, 25.4, 3.0)}
    | {n: Tool(n, 0.0, 0.5) for n in range(4, 60)}
)
Step = tuple[str, tuple[float, ...], tuple[float, ...] | None, bool | None, int, float]


def folder() -> Path:
    """The reference programs; the test is skipped where they are not there."""
    if not FOLDER.is_dir():
        pytest.skip("the reference programs are not there: set VCMM_DATA")
    return FOLDER


def answer(name: str) -> dict[str, Any]:
    path = folder() / "expected_rs274" / f"{name}.json"
    if not path.is_file():
        pytest.skip(f"{path} is missing")
    return json.loads(path.read_text(encoding="utf-8"))


def program(name: str) -> Path:
    return folder() / answer(name)["source"]


class _State:
    """Offsets of the oracle: machine = Rz(turn) (p + g92) + g5x."""

    def __init__(self) -> None:
        self.g5x, self.g92, self.tlo = [0.0] * 9, [0.0] * 9, [0.0] * 9
        self.turn, self.plane = 0.0, 1

    def tip(self, p: list[float]) -> tuple[float, ...]:
        x, y, z = (p[i] + self.g92[i] for i in range(3))
        c, s = math.cos(self.turn), math.sin(self.turn)
        return (c * x - s * y + self.g5x[0], s * x + c * y + self.g5x[1], z + self.g5x[2])


def steps(events: list[Any]) -> list[Step]:
    """(kind, end, centre, clockwise, turns, seconds) of every event that moves or waits; moves of no length left out."""
    state, out, here = _State(), [], (0.0, 0.0, 0.0)
    for event in events:
        kind, value = event[0], event[-1]
        if kind == "g5x":
            state.g5x = value[1:]
        elif kind == "g92":
            state.g92 = value
        elif kind == "rot":
            state.turn = math.radians(value)
        elif kind == "plane":
            state.plane = value
        elif kind in ("T", "F"):
            end = state.tip(value)
            if math.dist(end, here) > 1e-9:
                out.append(({"T": "rapid", "F": "line"}[kind], end, None, None, 1, 0.0))
            here = end
        elif kind == "A":
            step = _arc(state, value, here)
            out.append(step)
            here = step[1]
        elif kind == "dwell":
            out.append(("dwell", here, None, None, 1, value))
        elif kind == "tlo":
            here = tuple(here[i] - (value[i] - state.tlo[i]) for i in range(3))
            state.tlo = value
    return out


def _arc(state: _State, value: list[float], here: tuple[float, ...]) -> Step:
    _, a, b, n = PLANES[state.plane]
    end, centre = [0.0] * 3, [0.0] * 3
    end[a], end[b], end[n] = value[0], value[1], value[5]
    centre[a], centre[b], centre[n] = value[2], value[3], 0.0
    tip, middle = state.tip(end), list(state.tip(centre))
    return ("arc", tip, (middle[a], middle[b]), value[4] < 0, abs(value[4]), 0.0)


def ours(moves: tuple[Move, ...]) -> list[Step]:
    """Our moves in the same form."""
    out: list[Step] = []
    for m in moves:
        if m.kind in ("rapid", "line") and math.dist(m.start, m.end) <= 1e-9:
            continue
        centre = None
        if m.centre is not None:
            _, a, b, _ = next(p for p in PLANES.values() if p[0] == m.plane)
            centre = (m.centre[a], m.centre[b])
        out.append((m.kind, m.end, centre, m.clockwise, m.turns, m.seconds))
    return out


def differences(a: list[Step], b: list[Step], tolerance: float = 0.002) -> list[str]:
    """What differs, first few; empty where the whole paths are equal within the tolerance, mm."""
    found = [] if len(a) == len(b) else [f"{len(a)} steps against {len(b)}"]
    for i, (x, y) in enumerate(zip(a, b)):
        same = (
            x[0] == y[0]
            and x[3:5] == y[3:5]
            and abs(x[5] - y[5]) < 1e-9
            and math.dist(x[1], y[1]) < tolerance
        )
        if same and x[2] is not None and y[2] is not None:
            same = math.dist(x[2], y[2]) < tolerance
        if not same:
            found.append(f"step {i}: {x} against {y}")
    return found[:6]
