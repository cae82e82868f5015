"""Short Sinumerik programs and what they mean."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.conftest import data_file
from vcmm.program.setup import Setup, Tool
from vcmm.program.sinumerik.reader import read

SETUP = Setup(
    offsets={"G54": (0.0, 0.0, 0.0), "G55": (100.0, 50.0, -10.0)},
    tools={1: Tool(1, diameter=10.0), 2: Tool(2, length=80.0, diameter=6.0, name="MILL_6")},
)


def moves(text, setup=SETUP):
    return read(text, "part.mpf", setup).moves


def ends(text, setup=SETUP):
    return np.array([m.end for m in moves(text, setup)])


def check(text, *points, setup=SETUP):
    got = ends(text, setup)
    assert got.shape == (len(points), 3), got
    assert np.allclose(got, points, atol=1e-9), got


def sample(name):
    return data_file(f"data/nc/mit/sinumerik_{name}.mpf").read_bytes().decode()


SURVEY = replace(SETUP, strict=False)


def told(text):
    """What a survey assumes: what it is -> line, value taken."""
    return {a.what: (a.line, a.value) for a in read(text, "part.mpf", SURVEY).assumed}
