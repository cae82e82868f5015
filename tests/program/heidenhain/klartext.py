"""Short Klartext programs and what they mean."""

from __future__ import annotations

import numpy as np

from tests.conftest import data_file
from vcmm.program.heidenhain.reader import read
from vcmm.program.setup import Setup, Tool

SETUP = Setup(
    offsets={"G54": (0.0, 0.0, 0.0), "G55": (100.0, 50.0, -10.0)},
    tools={5: Tool(5, diameter=10.0), 2: Tool(2, length=80.0, diameter=6.0, name="MILL_6")},
)


def moves(text, setup=SETUP, unit="MM"):
    return read(f"BEGIN PGM T {unit}\n{text}\nEND PGM T {unit}\n", "part.h", setup).moves


def ends(text, **more):
    return np.array([m.end for m in moves(text, **more)])


def check(text, *points, **more):
    got = ends(text, **more)
    assert got.shape == (len(points), 3), got
    assert np.allclose(got, points, atol=1e-9), got


def sample(name):
    return data_file(f"data/nc/gpl_test_only/heidenhain_{name}.h").read_bytes().decode()
