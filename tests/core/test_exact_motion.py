"""Exact motion of the tip: rotations beyond first order, by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.run import Run
from vcmm.physics.structure.component import ComponentPolynomial


def turned(**angles: float):
    return [ComponentPolynomial(component=c, coefficients=np.array([v])) for c, v in angles.items()]


def at(x: float, offset=(0.0, 0.0, -100.0)) -> Run:
    zero = np.zeros(1)
    return Run({"X": np.array([x]), "Y": zero, "Z": zero}, np.array([offset]))


def test_a_large_turn_keeps_its_angle():
    """ECX = 0.1 rad at the end of a chain without other errors: the tool turns by 0.1 rad about Z, and a tip 100 mm away along
    x goes to 100 (cos 0.1 - 1, sin 0.1) = (-0.499583, 9.983342) mm.
    """
    m = machine(*turned(ECX=0.1))
    got = m.tip_motion(at(200.0, (100.0, 0.0, 0.0)), exact=True)[0]
    assert got[3:] == pytest.approx([0.0, 0.0, 0.1])
    assert got[:3] == pytest.approx([-0.4995834722, 9.9833416647, 0.0])


def test_small_turns_agree_with_first_order():
    m = machine(*turned(EAX=3e-6, EBY=-2e-6, ECZ=5e-6))
    run = Run(
        {"X": np.array([200.0]), "Y": np.array([-50.0]), "Z": np.array([10.0])},
        np.array([[1.0, 2.0, -100.0]]),
    )
    np.testing.assert_allclose(m.tip_motion(run, exact=True), m.tip_motion(run), atol=2e-9)
    np.testing.assert_allclose(m.tip_motion(run, exact=True)[:, :3], m.tip_error(run, exact=True))
