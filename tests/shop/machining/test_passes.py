"""Scatter of a cut: one departure per pass, correlated along it, whatever is inspected."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.program.interpret import read_program
from vcmm.shop.cutting.sweeps import lines
from vcmm.shop.cutting.tools import flat
from vcmm.shop.machining.job import cut
from vcmm.shop.machining.passes import LENGTH, pass_weights

FACE = (
    """\
%
O1
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-60. Y-30. S3000 M3
G43 H1 Z5.
"""
    + "".join(f"G0 X-60. Y{y}.\nZ-10.\nG1 X60. F600\nG0 Z5.\n" for y in range(-30, 31, 10))
    + "M30\n%\n"
)
SCENARIO = """\
vcmm = "scenario/1"
machine = "mill.toml"
[cut]
program = "part.nc"
setup = "setup.toml"
[part.features]
face = { type = "plane", point = "0 0 -10 mm", normal = [0, 0, 1], size = "80 60 mm" }
[[part.characteristics]]
name = "flat"
type = "flatness"
of = "face"
zone = "0.02 mm"
[plan]
[[plan.steps]]
feature = "face"
points = { strategy = "grid", n = [%d, %d], margin = "2 mm" }
[job]
trials = 4000
"""


@pytest.mark.thorough
def test_flatness_does_not_grow_with_the_points_that_are_looked_at(tmp_path):
    """Drawn per point it would: 1 um scatter, range of n normals 2.97 (9), 4.5 (49) and 5.6 (225) um."""
    found = []
    for n in (7, 13, 21):
        path = shop.write(tmp_path, '[repeatability]\nu = "1 um"\n', SCENARIO % (n, n), FACE)
        result = cut(vcmm.load_cut(path))
        (one,) = result.characteristics
        found.append(one.mean * 1e3)
        assert one.budget[0].redraw == "pass"
        assert result.scatters["flat"] == pytest.approx(one.u, rel=1e-6)
    assert found[2] < found[0] * 1.15
    # independently: 7 passes of 120 mm at y = -30 .. 30, each a process of 20 mm correlation, on a fine grid
    rng, x = np.random.default_rng(1), np.linspace(-38, 38, 21)
    kernel = np.exp(-((x[:, None] - x[None]) ** 2) / (2 * LENGTH**2)) + 1e-9 * np.eye(21)
    y = np.linspace(-28, 28, 21)
    nearest = np.abs(y[:, None] - np.arange(-30, 31, 10)[None]).argmin(axis=1)
    design = np.stack([np.ones(441), np.repeat(y, 21), np.tile(x, 21)], axis=1)
    ranges = []
    for _ in range(400):
        passes = rng.standard_normal((7, 21)) @ np.linalg.cholesky(kernel).T
        height = passes[nearest].ravel()
        rest = height - design @ np.linalg.lstsq(design, height, rcond=None)[0]
        ranges.append(np.ptp(rest))
    assert found[2] == pytest.approx(np.mean(ranges), rel=0.15)


def test_exact_trials_have_the_same_passes(tmp_path):
    path = shop.write(tmp_path, '[repeatability]\nu = "1 um"\n', SCENARIO % (7, 7), FACE)
    result = cut(vcmm.load_cut(path))
    assert result.characteristics[0].linear_error < 1e-5


def test_weights_by_hand(tmp_path):
    """One pass along a line of 100 mm, a rapid, another: correlation exp(-d^2 / (2 20^2)) along, none across."""
    text = "%\nO1\nG21 G90 G17 G40 G49 G80 G94\nT1 M6\nG54 G0 X0 Y0\nG43 H1 Z5.\nG1 X100. F100\nG0 Y20.\nG1 X0.\nM30\n%\n"
    path = shop.write(tmp_path, program=text)
    scenario = vcmm.load_cut(path)
    program = read_program(scenario.program, scenario.dialect, scenario.setup)
    number = [i for i, move in enumerate(program.moves) if move.kind == "line"]
    rapid = [i for i, move in enumerate(program.moves) if move.kind == "rapid"][-1]
    start = np.array([[0.0, 0, 0], [100, 0, 0], [100, 20, 0]])
    sweep = lines(start, np.array([[100.0, 0, 0], [100, 20, 0], [0, 20, 0]]), (flat(10.0),))
    sweep = type(sweep)(**{**vars(sweep), "move": np.array([number[0], rapid, number[1]])})
    weights = pass_weights(program, sweep, np.array([0, 0, 0, 2]), np.array([0.0, 0.2, 1.0, 0.0]))
    got = weights @ weights.T
    assert np.diag(got) == pytest.approx(np.ones(4))
    assert got[0, 1] == pytest.approx(np.exp(-0.5), abs=0.01)  # 20 mm apart
    assert got[0, 2] == pytest.approx(np.exp(-12.5), abs=1e-3)
    assert got[2, 3] == 0.0  # the same X, another pass
