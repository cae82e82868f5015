"""Every public program that LinuxCNC's own interpreter reads to its end: the whole path, and the centres of its arcs."""

from __future__ import annotations

import math
import os
from pathlib import Path

import pytest

from tests.program.oracle import Step, ours
from tests.program.rs274 import binary, path_said, said_of
from vcmm.face.cli.nc_folder import programs_in
from vcmm.program.interpret import read_program
from vcmm.program.setup import Setup, Tool

NUMBERS = range(1, 100)
TABLE = "".join(f"T{n} P{n} Z0 D0\n" for n in NUMBERS)
SETUP = Setup(tools={n: Tool(n, 0.0, 0.0) for n in NUMBERS})
OTHERS = ("heidenhain", "sinumerik")  # no language of its
PRINTED = 0.006  # mm: four decimals, of an inch at worst, at both ends of an arc
AT_LEAST = 50  # programs of this folder that it read in November 2026: 56


def folder() -> Path:
    found = Path(os.environ.get("VCMM_DATA", "")) / "data" / "nc_public"
    if not found.is_dir():
        pytest.skip("the public programs are not there: set VCMM_DATA")
    return found


def same(a: Step, b: Step) -> bool:
    """Kind, sense, turns, end and centre of two steps; the interpreter prints a thread as a line."""
    kinds = {"thread": "line"}
    alike = kinds.get(a[0], a[0]) == kinds.get(b[0], b[0]) and a[3:5] == b[3:5] and abs(a[5] - b[5]) < 1e-9
    centres = a[2] is None or b[2] is None or math.dist(a[2], b[2]) < PRINTED
    return alike and centres and math.dist(a[1], b[1]) < PRINTED


def is_nothing(steps: list[Step], index: int) -> bool:
    """A dwell of no time, or a straight step that is shorter than what is printed."""
    kind, end, *_, seconds = steps[index]
    before = steps[index - 1][1] if index else (0.0, 0.0, 0.0)
    return seconds == 0.0 if kind == "dwell" else kind != "arc" and math.dist(end, before) < PRINTED / 2.0


def first_difference(a: list[Step], b: list[Step]) -> str:
    """The first step that differs, "" where the paths are the same; steps of no length may be missing on either side."""
    i = k = 0
    while i < len(a) or k < len(b):
        if i < len(a) and k < len(b) and same(a[i], b[k]):
            i, k = i + 1, k + 1
        elif i < len(a) and is_nothing(a, i):
            i += 1
        elif k < len(b) and is_nothing(b, k):
            k += 1
        else:
            return f"{a[i : i + 1]} against {b[k : k + 1]}"
    return ""


def test_a_difference_is_seen():
    line: Step = ("line", (1.0, 0.0, 0.0), None, None, 1, 0.0)
    arc: Step = ("arc", (2.0, 0.0, 0.0), (1.5, 0.0), True, 1, 0.0)
    assert not first_difference([line, arc], [line, arc])
    assert first_difference([line, arc], [line, (*arc[:2], (1.5, 0.01), *arc[3:])])
    assert first_difference([line], [line, arc])
    assert not first_difference([line, ("dwell", line[1], None, None, 1, 0.0)], [line])


@pytest.mark.thorough
def test_public_programs_have_the_path_of_the_interpreter(tmp_path: Path):
    binary()
    root, compared, wrong = folder(), 0, []
    for program in programs_in(root):
        if program.relative_to(root).parts[0] in OTHERS:
            continue
        code, said = said_of(program, tmp_path, TABLE, 20.0)
        expected = path_said(said) if code == 0 else []
        if not expected:
            continue
        compared += 1
        found = read_program(program, "linuxcnc", SETUP)
        if text := first_difference(ours(found.moves), expected):
            wrong.append(f"{program.relative_to(root)}: {text}")
    assert not wrong
    assert compared >= AT_LEAST
