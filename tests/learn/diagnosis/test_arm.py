"""A six-axis arm measured by a tracker: a joint that stands 0.3 mrad off and a link that is too long are named."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.run import Run
from vcmm.files.learned.improved_machine import improved_machine
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.physics.structure.squareness import RotaryLocation

CENTRES = {
    "C1": (0, 0, 0), "B2": (150, 0, 450), "B3": (150, 0, 1050), "A4": (150, 0, 1170), "B5": (790, 0, 1170),
    "A6": (875, 0, 1170),
}  # fmt: skip
TOOL = (900.0, 40.0, 1190.0)


def machine_text() -> str:
    head = 'vcmm = "machine/1"\nkind = "machine-tool"\nstructure = "w b C1 B2 B3 A4 B5 A6 t"\n'
    axes = "".join(
        f'[axes.{a}]\ntravel = ["-170 deg", "170 deg"]\ncentre = [{", ".join(f"{chr(34)}{v} mm{chr(34)}" for v in c)}]\n'
        for a, c in CENTRES.items()
    )
    return head + axes + '[repeatability]\nu = "20 um"\n'


def recorded(folder, faults: tuple[RotaryLocation, ...], n: int = 36):
    """n poses, the reflector's place by a tracker whose own place is free."""
    (folder / "machine.toml").write_text(machine_text())
    machine = load_machine(folder / "machine.toml")
    rng = np.random.default_rng(5)
    q = {a: rng.uniform(-1.2, 1.2, n) for a in CENTRES}
    run = Run(q, np.tile(TOOL, (n, 1)))
    error = machine.with_effect(*faults).tip_error(run, exact=True) + rng.normal(0, 0.02, (n, 3))
    names = [*(f"{a}_deg" for a in q), *(f"offset_{c}_mm" for c in "xyz"), "dx_um", "dy_um", "dz_um"]
    table = np.column_stack([*(np.degrees(v) for v in q.values()), run.offset, error * 1e3])
    rows = [",".join(f"{v:.6f}" for v in row) for row in table]
    (folder / "data.csv").write_text("\n".join([",".join(names), *rows]) + "\n")
    (folder / "recording.toml").write_text(
        'vcmm = "recording/1"\ndata = "data.csv"\nmachine = "machine.toml"\nkind = "path"\nhistory = "none"\n'
        '[nuisance]\nrigid = ""\n'
    )
    return load_recording(folder / "recording.toml")


@pytest.mark.thorough
def test_the_faults_are_named_with_their_sizes_and_written(tmp_path):
    faults = (RotaryLocation("B0B3", tilt=300e-6), RotaryLocation("X0A4", offset=0.25))
    recording, machine = recorded(tmp_path, faults)
    found = diagnose_recording(recording, machine, seed=1, nulls=200)
    # a shift along the axis of A4 is one of B5, which it carries: such aliases stand beside the names, said to be that
    named = [a for a in found.answer if not a.alias_of]
    sizes = {a.where["component"]: next(iter(a.parameters.values())) for a in named}
    assert ("rotary_location[X0A4]", "X0B5") in {(a.alias_of, a.where["component"]) for a in found.answer}
    assert {a.effect for a in found.answer} == {"rotary_location"}
    assert sorted(sizes) == ["B0B3", "X0A4"]
    assert abs(sizes["B0B3"].value - 300.0) < 4 * sizes["B0B3"].u
    assert abs(sizes["X0A4"].value - 250.0) < 4 * sizes["X0A4"].u
    new = tmp_path / "new.toml"
    new.write_text(improved_machine(tmp_path / "machine.toml", new, machine, found.answer, "recording.toml"))
    assert {e.where for e in load_machine(new).effects} >= {"B0B3", "X0A4"}
