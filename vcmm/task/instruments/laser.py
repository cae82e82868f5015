"""Laser interferometer: linear (position), straightness and angle (pitch, yaw; with a level or 6-D head also roll).

linear        d along the beam, from where the counter was set to zero         own error: scale (wavelength of the air)
straightness  d across the beam, from a line that lies anywhere                own error: gain of the Wollaston prism
angle         turn about a direction across the beam, from any zero            own error: gain
6-D           all of them along one line at once, with roll; six recordings    own errors: scale, straightness, angle
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.task.instruments.instrument import GAIN, SCALE, Instrument, OwnError, across_reading, angle_reading
from vcmm.task.instruments.laying import layout, rows
from vcmm.task.response.recording import Recording

LASER_LINEAR = Instrument(
    "laser linear", "displacement", (SCALE,), ("zero",), "Steinmetz, Precision Engineering 12 (1990) 12"
)
LASER_STRAIGHTNESS = Instrument(
    "laser straightness", "displacement", (GAIN,), ("zero", "slope"), "ISO 230-1:2012, 8.2.3.2"
)
SIX_STRAIGHTNESS = OwnError("straightness", "%", across_reading, "u of the gain of its straightness channels")
SIX_ANGLE = OwnError("angle", "%", angle_reading, "u of the gain of its angle channels")
SIX_D = Instrument(
    "6-D laser",
    "displacement",
    (SCALE, SIX_STRAIGHTNESS, SIX_ANGLE),
    ("zero", "slope"),
    "Echerfaoui et al., J. Manuf. Mater. Process. 1 (2017) 8",
    other_kinds=("angle",),
)
LASER_ANGLE = Instrument("laser angle", "angle", (GAIN,), ("zero",), "ISO 230-1:2012, 8.4.2")


def line(
    machine: Machine,
    axis: str,
    targets: Array,
    at: Mapping[str, float],
    offset: Array,
    component: str,
    u: float,
    runs: int = 1,
    reflector: Array | None = None,
) -> Recording:
    """Lay out readings along one axis, there and back: component "X", "Y", "Z" (translation) or "A", "B", "C" (turn).

    targets (t,) mm; at: the other axes, mm; offset (3,) mm: reflector in the frame of the last tool-side axis; u mm or rad.
    reflector (3,) mm, workpiece axes: it is fixed to the table instead, and the interferometer moves with the tool.
    """
    there = np.concatenate([np.asarray(targets, dtype=float), np.asarray(targets, dtype=float)[::-1]])
    q = np.tile(there, runs)
    position = {a: q if a == axis else np.full(len(q), at[a]) for a in machine.chain.letters}
    if reflector is not None:
        offset = reflector - nominal_tip(machine.chain, machine.axes, rows(position, np.zeros(3)))
    direction = np.eye(3)["XYZABC".index(component) % 3]
    kind = "angle" if component in "ABC" else "displacement"
    across = kind == "displacement" and component != axis
    nuisance = {"zero": "", "slope": ""} if across else {"zero": ""}
    return layout(f"E{component}{axis}", kind, rows(position, offset), direction, nuisance, u)


def six_d(
    machine: Machine,
    axis: str,
    targets: Array,
    at: Mapping[str, float],
    offset: Array | None,
    u: Mapping[str, float],
) -> list[Recording]:
    """Lay out all six errors of an axis along one line; u: {"linear": mm, "straightness": mm, "angle": rad}.

    offset None: the line through `measured_at` of the axis, where its errors are stated (the Abbe line).
    """
    if offset is None:
        offset = offset_to_line(machine, axis, at)
    out = []
    for component in "XYZABC":
        what = "angle" if component in "ABC" else "linear" if component == axis else "straightness"
        out.append(line(machine, axis, targets, at, offset, component=component, u=u[what]))
    return out


def offset_to_line(machine: Machine, axis: str, at: Mapping[str, float]) -> Array:
    """Return the offset of a reflector (3,) mm in the frame of the last tool-side axis that puts it at `measured_at` of the axis when
    this is at zero.

    Raises UsageError where the machine does not state it.
    """
    where = machine.axes[axis].measured_at
    if where is None:
        raise UsageError(
            f'the machine states no measured_at for {axis}; add it, or say where the reflector is with offset = "0 0 -100 mm"'
        )
    position = {a: np.array([0.0 if a == axis else at[a]]) for a in machine.chain.letters}
    return np.array(where) - nominal_tip(machine.chain, machine.axes, rows(position, np.zeros(3)))[0]


def diagonal(
    machine: Machine,
    ends: tuple[Sequence[float], Sequence[float]],
    n: int,
    u: float,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
    runs: int = 2,
) -> Recording:
    """Lay out a laser line from one place of the axes X Y Z to another, there and back (ISO 230-6), with the senses of the axes."""
    start, end = (np.asarray(e, dtype=float) for e in ends)
    there = np.linspace(0.0, 1.0, n)
    share = np.tile(np.concatenate([there, there[::-1]]), runs)
    points = start + share[:, None] * (end - start)
    position = {
        a: points[:, "XYZ".index(a)] if a in "XYZ" else np.zeros(len(share)) for a in machine.chain.letters
    }
    way = np.tile(np.repeat([1.0, -1.0], n), runs)
    run = rows(position, np.asarray(offset, dtype=float))
    run = run.with_columns(
        {f"sense_{a}": way * np.sign(end[i] - start[i]) for i, a in enumerate("XYZ") if a in position}
    )
    direction = (end - start) / np.linalg.norm(end - start)
    return layout("diagonal", "displacement", run, direction, {"zero": ""}, u)
