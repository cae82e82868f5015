"""The frame of a touch probe: that of the last tool-side axis, turned with the spindle (right-hand about +Z of that frame)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Motion, tip_motion
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.response.recording import Recording

IN_PROBE = ("probe_nx", "probe_ny", "probe_nz")  # columns: outward normal in the frame of the probe
SPINDLE = "spindle_angle_rad"


def tool_directions(machine: Machine, run: Run) -> Array:
    """Return X, Y and Z of the last tool-side frame in workpiece axes, as rows (n, 3, 3)."""
    ways = [
        tip_motion(machine.chain, machine.axes, run, [Motion("tool", "motion", np.tile(axis, (run.n, 1)))])[
            :, :3
        ]
        for axis in np.eye(6)[:3]
    ]
    return np.stack(ways, axis=1)


def head_axes(machine: Machine) -> tuple[str, ...]:
    """Return the rotary axes that carry the tool: a head turns by them."""
    return tuple(a for a in machine.chain.tool if is_rotary(a))


def machine_directions(machine: Machine, run: Run) -> Array:
    """Return X, Y and Z of the machine in workpiece axes, as rows (n, 3, 3); turns of a head do not count."""
    still = {a: np.zeros(run.n) for a in head_axes(machine)}
    return tool_directions(machine, replace(run, position={**run.position, **still}))


def with_probe_frame(run: Run, machine: Machine) -> Run:
    """Return the run with the outward normals in the frame of the probe; unchanged where it has no normals."""
    if not all(f"n{c}" in run.columns for c in "xyz") or IN_PROBE[0] in run.columns:
        return run
    n = np.einsum("nij,nj->ni", tool_directions(machine, run), run.normal)
    turn = run.columns.get(SPINDLE, np.zeros(run.n))
    x = np.cos(turn) * n[:, 0] + np.sin(turn) * n[:, 1]
    y = -np.sin(turn) * n[:, 0] + np.cos(turn) * n[:, 1]
    return run.with_columns(dict(zip(IN_PROBE, (x, y, n[:, 2]))))


def normals_in_probe(recording: Recording, run: Run) -> Array:
    """Return the outward normals in the frame of the probe, as (m, 3). Raises UsageError where the run was not made ready for a probe."""
    if not all(name in run.columns for name in IN_PROBE):
        raise UsageError(
            f'{recording.name}: the own errors of a "touch probe" need the outward normals nx ny nz of its touches'
        )
    return run.vector(*IN_PROBE)[recording.row]
