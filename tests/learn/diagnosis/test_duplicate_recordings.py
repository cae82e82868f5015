"""A recording given twice is refused with both names; repeats on a coarse display are no copies."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from tests.learn.diagnosis.test_kinds import laser
from vcmm.core.errors import UsageError
from vcmm.face.cli import run
from vcmm.learn.diagnosis.several import refuse_copies

UM = 1e-3


def recording(name: str, seed: int, step: float = 0.0):
    """110 readings with 0.6 um of scatter, shown in steps."""
    one = laser(lambda q, s: -1.0 * UM * s, seed=seed)
    value = np.round(one.value / step) * step if step else one.value
    return replace(one, name=name, value=value)


def test_a_copy_in_another_order_or_in_part_is_refused_with_both_names():
    one, machine = recording("monday", 1), make.machine()
    order = np.random.default_rng(3).permutation(one.run.n)[:60]
    part = replace(one.take(order), name="copy")
    with pytest.raises(UsageError, match="all 60 readings of copy stand in monday too"):
        refuse_copies([part, recording("friday", 2), one], machine)
    refuse_copies([one, recording("friday", 2)], machine)


def test_equal_readings_of_a_coarse_display_are_no_copies():
    """Step 10 um, scatter 0.6 um: every reading is 0, and repeats so by chance: 10 / (2 sqrt(pi) 0.6) = 4.7 > 1.
    Step 0.5 um: 110 readings agree with probability (0.5 / 2.13)^110 = 1e-69."""
    machine = make.machine()
    refuse_copies([recording("monday", 1, 10 * UM), recording("friday", 2, 10 * UM)], machine)
    with pytest.raises(UsageError, match="no second witness"):
        refuse_copies([recording("monday", 1, 0.5 * UM), recording("friday", 1, 0.5 * UM)], machine)


def test_the_command_refuses_a_copied_table(tmp_path, capsys):
    axes = "".join(f'[axes.{a}]\ntravel = ["-1 m", "1 m"]\n' for a in "XYZ")
    (tmp_path / "machine.toml").write_text(f'vcmm = "machine/1"\nstructure = "w b Y X Z t"\n{axes}')
    rows = "".join(f"{10 * i},0,0,1,0,0,{0.137 * i**1.5 % 1.1:.3f}\n" for i in range(40))
    for name in ("a", "b"):
        (tmp_path / f"{name}.csv").write_text("X_mm,Y_mm,Z_mm,nx,ny,nz,d_um\n" + rows)
        (tmp_path / f"{name}.toml").write_text(
            f'vcmm = "recording/1"\nname = "{name}"\ndata = "{name}.csv"\nmachine = "machine.toml"\nkind = "displacement"\n'
            '[noise]\nu = "0.3 um"\n'
        )
    assert run(["diagnose", str(tmp_path / "a.toml"), str(tmp_path / "b.toml")]) == 2
    said = capsys.readouterr().err
    assert "all 40 readings of a stand in b too" in " ".join(said.split())
