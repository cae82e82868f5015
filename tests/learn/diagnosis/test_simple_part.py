"""A scaled plate out of square is no bundle of curves, and a curve says what is most of it."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.learn.diagnosis.job import diagnose
from vcmm.task.response.recording import Recording

AXES = {a: Axis(a, (-400.0, 400.0)) for a in "XYZ"}
DRILL = Machine("drill", "machine-tool", parse_structure("w X' Y' b Z t"), AXES)


def plate(bend: float) -> Recording:
    """Holes on a grid of 600 x 480 mm: scales -35e-6 and -20e-6, 60 urad out of square, a bend of y over x, noise 2 um."""
    x, y = (v.ravel() for v in np.meshgrid(np.linspace(-300, 300, 13), np.linspace(-240, 240, 11)))
    n = len(x)
    run = Run({"X": x, "Y": y, "Z": np.zeros(n)}, np.zeros((n, 3)))
    dx, dy = -35e-6 * x - 60e-6 * y, -20e-6 * y + bend * (x / 300) ** 2
    value = np.stack([dx, dy], axis=1).ravel() + 2e-3 * np.random.default_rng(4).standard_normal(2 * n)
    direction, none = np.tile(np.eye(3)[:2], (n, 1)), np.full(2 * n, -1, dtype=np.intp)
    rows = np.repeat(np.arange(n), 2)
    return Recording("p", "path", run, value, False, rows, direction, none, None, {"rigid": ""}, Normal(2e-3))


@pytest.mark.parametrize("bend", [0.0, 6e-3])
@pytest.mark.thorough
def test_scales_and_squareness_are_read_off(bend):
    found = diagnose(plate(bend), DRILL, seed=1)
    answer = {(a.effect, *a.where.values()): a for a in found.answer if not a.alias_of}
    said = {a.remark.split(" % of it is ")[1] for a in found.answer if " % of it is " in a.remark}
    for name, parameter, size in (
        ("scale_factor X", "k", -35.0),
        ("scale_factor Y", "k", -20.0),
        ("squareness C0Y", "angle", 60.0),
    ):
        if tuple(name.split()) in answer:
            value = answer[tuple(name.split())].parameters[parameter].value
        else:  # a curve in its place says what it is
            value = float(next(s for s in said if s.startswith(name)).split(", ")[1].split()[0])
        assert value == pytest.approx(size, abs=4.0)
    if not bend:
        assert set(answer) == {("scale_factor", "X"), ("scale_factor", "Y"), ("squareness", "C0Y")}
        assert found.verdict == "explained"
