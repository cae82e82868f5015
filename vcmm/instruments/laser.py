"""Laser interferometer: linear (position), straightness and angle (pitch, yaw; with a level or 6-D head also roll).

linear        d along the beam, from where the counter was set to zero         own error: scale (wavelength of the air)
straightness  d across the beam, from a line that lies anywhere                own error: gain of the Wollaston prism
angle         turn about a direction across the beam, from any zero            own error: gain
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.instruments.instrument import GAIN, SCALE, Instrument
from vcmm.instruments.laying import layout, rows
from vcmm.response.recording import Recording

LASER_LINEAR = Instrument(
    "laser linear", "displacement", (SCALE,), ("zero",), "Steinmetz, Precision Engineering 12 (1990) 12"
)
LASER_STRAIGHTNESS = Instrument(
    "laser straightness", "displacement", (GAIN,), ("zero", "slope"), "ISO 230-1:2012, 8.2.3.2"
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
) -> Recording:
    """Readings along one axis, there and back: component "X", "Y", "Z" (translation) or "A", "B", "C" (turn).

    targets (t,) mm; at: the other axes, mm; offset (3,) mm: reflector in the frame of the last tool-side axis; u mm or rad.
    """
    there = np.concatenate([np.asarray(targets, dtype=float), np.asarray(targets, dtype=float)[::-1]])
    q = np.tile(there, runs)
    position = {a: q if a == axis else np.full(len(q), at[a]) for a in machine.chain.letters}
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
    offset: Array,
    u: Mapping[str, float],
) -> list[Recording]:
    """All six errors of an axis along one line; u: {"linear": mm, "straightness": mm, "angle": rad}."""
    out = []
    for component in "XYZABC":
        what = "angle" if component in "ABC" else "linear" if component == axis else "straightness"
        out.append(line(machine, axis, targets, at, offset, component=component, u=u[what]))
    return out
