"""The error field: grid, diagonals, and what a map cannot show."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests import build
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis
from vcmm.face.cli import run as run_command
from vcmm.files.own.library import example
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.response.volumetric import diagonals, field, grid, missing_columns, with_defaults


def test_a_grid_over_the_travels():
    run = grid(build.machine(), 3)
    assert run.n == 27
    assert sorted(set(run.position["Y"].tolist())) == [-1000.0, 0.0, 1000.0]
    with pytest.raises(UsageError, match="at least 2"):
        grid(build.machine(), 1)


def test_an_arm_has_no_volume_of_x_y_z(tmp_path, capsys):
    """A grid over X, Y, Z needs one of them: an arm is refused with the way out, and is mapped at named positions."""
    arm = example("six_axis_arm").parent / "six_axis_arm" / "machine.toml"
    assert run_command(["field", str(arm)]) == 2
    assert "rotary axes alone (C1, B2, B3, A4, B5, A6)" in capsys.readouterr().err
    at = tmp_path / "positions.csv"
    at.write_text("C1_deg,B2_deg,B3_deg,A4_deg,B5_deg,A6_deg\n10,20,30,40,50,60\n")
    assert run_command(["field", str(arm), "--at", str(at)]) == 0
    assert "1 points" in capsys.readouterr().out


def test_sizes_of_tip_errors():
    # 10 um/m in X and 20 um/m in Y at the corners (1 m, 1 m): sqrt(10^2 + 20^2) um
    out = field(build.machine(ScaleFactor("X", 10e-6), ScaleFactor("Y", 20e-6)), nodes=2)
    assert out.size == pytest.approx(np.full(8, np.hypot(10e-3, 20e-3)))


def test_body_diagonals_of_a_scale_and_a_squareness():
    # each diagonal of the cube of 2 m goes 2 m along X: 20 um x cos = 20 / sqrt(3) um
    out = diagonals(build.machine(ScaleFactor("X", 10e-6)))
    assert [d.length_error for d in out] == pytest.approx([20e-3 / np.sqrt(3)] * 4)
    # squareness of 10 urad: 2000 mm x 10 urad across, seen with +-1/sqrt(3); the sign goes with X against Y
    out = diagonals(build.machine(Squareness("C0Y", 10e-6)))
    assert np.abs([d.length_error for d in out]) == pytest.approx([20e-3 / np.sqrt(3)] * 4)
    assert sum(d.length_error for d in out) == pytest.approx(0.0, abs=1e-12)


def test_body_diagonals_join_opposite_corners():
    """Travels of 100, 200 and 300 mm: each begins at X 0 and ends at the corner across all three."""
    axes = {a: Axis(a, (0.0, t)) for a, t in zip("XYZ", (100.0, 200.0, 300.0))}
    out = diagonals(replace(build.machine(ScaleFactor("Z", 10e-6)), axes=axes))
    assert [(d.start, d.end) for d in out] == [
        ((0, 0, 0), (100, 200, 300)), ((0, 0, 300), (100, 200, 0)), ((0, 200, 0), (100, 0, 300)), ((0, 200, 300), (100, 0, 0)),
    ]  # fmt: skip
    # 3 um along Z, seen with 300 of sqrt(100^2 + 200^2 + 300^2) = 374.166 mm: longer by 2.405 um whichever way Z goes
    assert [d.length_error for d in out] == pytest.approx([2.40535e-3] * 4, abs=1e-8)


def test_what_a_position_does_not_tell():
    machine = build.machine(Backlash("X", 1e-3), Scatter(), ScaleFactor("X", 1e-6))
    run = grid(machine, 2)
    assert missing_columns(machine, run) == (("backlash[X]", ("sense_X",)),)
    assert with_defaults(machine, run).column("sense_X").tolist() == [0.0] * 8
