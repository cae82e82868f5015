"""vcmm/physics/catalogue/plate_bow.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics.ask import ask
from vcmm.core.run import Run
from vcmm.physics.catalogue.plate_bow import PlateBow


def one_row(position=(0.0, 0.0, 0.0), **columns: float) -> Run:
    named = {k: np.array([v]) for k, v in columns.items()}
    return Run({a: np.array([q]) for a, q in zip("XYZ", position)}, np.zeros((1, 3)), named)


def test_a_plate_that_was_held_convex():
    # 200 um/m^3 = 2e-10 / mm^2; r^2 = 300^2 + 400^2 = 250 000 mm^2: 5e-5 x (300, 400) = (15, 20) um
    run = one_row(part_x_mm=300.0, part_y_mm=400.0, part_z_mm=8.0)
    assert PlateBow(c=2e-10).error_motion(run)[0, :3] == pytest.approx([15e-3, 20e-3, 0.0], abs=1e-12)
    # R = 5281 mm: 1 / (6 R^2) = 5.976e-9 / mm^2; arc above a radius of 325 mm: R arcsin(325 / R) - 325 = 0.2054 mm
    c = 1 / (6 * 5281.0**2)
    edge = PlateBow(c=c).error_motion(one_row(part_x_mm=325.0, part_y_mm=0.0, part_z_mm=0.0))[0, 0]
    assert edge == pytest.approx(5281.0 * np.arcsin(325.0 / 5281.0) - 325.0, rel=2e-3)
    flat = Run(
        {},
        np.zeros((3, 3)),
        {
            "part_x_mm": np.array([0.0, 300, 0]),
            "part_y_mm": np.array([0.0, 0, 200]),
            "part_z_mm": np.zeros(3),
        },
    )
    assert [ask(PlateBow(n), "shows_in", flat) for n in "xyz"] == [False, False, True]
