"""Instruments for rotary axes: R-test, ball bar held in one direction, indexed angle.

R-test          x y z of a ball that the machine holds at one place of the workpiece while the axis turns; the linear axes follow.
                Nest on the table, ball in the spindle, read in workpiece axes; its place is free (rigid). Own error: gain
ball bar        the same, read in one direction only, from a cup at any place (centre, and radius unless calibrated)
rotary indexer  turn about the axis against a polygon with autocollimator, or an encoder; from any zero. Own errors: gain, faces
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.axes import unit_vector
from vcmm.core.kinematics import Motion, tip_motion
from vcmm.core.machine import Machine
from vcmm.core.reach import linear_positions
from vcmm.core.run import Array, Run
from vcmm.task.instruments.instrument import GAIN, Instrument, OwnError, of_features
from vcmm.task.instruments.laying import layout, rows
from vcmm.task.instruments.tracker import at_station
from vcmm.task.response.recording import Recording

FACES = OwnError(
    "faces",
    "urad",
    of_features,
    "u of the calibrated angle of one face or division (label feature)",
    is_permanent=False,
)
R_TEST = Instrument(
    "R-test", "displacement", (GAIN,), ("rigid",), "ISO 10791-6:2014, BK4; Weikert, CIRP Annals 53 (2004) 429"
)
INDEXER = Instrument("rotary indexer", "angle", (GAIN, FACES), ("zero",), "ISO 230-1:2012, 8.4.3")


def hold_tip(
    machine: Machine, axis: str, angles: Array, ball: Sequence[float], offset: Sequence[float]
) -> Run:
    """Return rows in which the tip (offset (3,) mm from the last tool-side axis) stays at ball (3,), workpiece axes, while axis goes
    through angles (n,) rad.

    Raises ModelLimit where the linear axes cannot follow.
    """
    n = len(angles)
    position = {a: np.asarray(angles) if a == axis else np.zeros(n) for a in machine.chain.letters}
    run = rows(position, np.asarray(offset, dtype=float))
    place = np.tile(np.asarray(ball, dtype=float), (n, 1))
    return replace(run, position=linear_positions(machine, run, place))


def r_test(
    machine: Machine,
    axis: str,
    angles: Array,
    ball: Sequence[float],
    u: float,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
) -> Recording:
    """Lay out x, y and z of a ball held at one place of the workpiece; u mm per coordinate."""
    run = hold_tip(machine, axis, angles, ball, offset)
    recording = layout(f"R-test {axis}", "displacement", run, np.eye(3)[0], {"rigid": ""}, u)
    plain = {k: v for k, v in recording.run.columns.items() if k not in ("nx", "ny", "nz")}
    n = run.n
    return replace(
        recording,
        run=replace(recording.run, columns=plain),
        value=np.zeros(3 * n),
        row=np.repeat(np.arange(n), 3),
        direction=np.tile(np.eye(3), (n, 1)),
        other=np.full(3 * n, -1, dtype=np.intp),
    )


def held_bar(
    machine: Machine,
    axis: str,
    angles: Array,
    ball: Sequence[float],
    cup: Sequence[float],
    u: float,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
) -> Recording:
    """Lay out a ball bar (ISO 10791-6) from a cup (3,) to the held ball (3,), workpiece axes: axial, radial or tangential by the place of the cup."""
    run = hold_tip(machine, axis, angles, ball, offset)
    recording = layout(f"ball bar about {axis}", "length", run, np.eye(3)[0], {"centre": "", "radius": ""}, u)
    return at_station(recording, machine, np.tile(np.asarray(cup, dtype=float), (run.n, 1)))


def index_axis(machine: Machine, axis: str, angles: Array, u: float) -> Recording:
    """Turn of a rotary axis about itself at angles (n,) rad, the other axes at zero; u rad. Label feature: the face."""
    n = len(angles)
    position = {a: np.asarray(angles) if a == axis else np.zeros(n) for a in machine.chain.letters}
    faces = [f"{np.degrees(a) % 360:.6g}" for a in angles]
    run = rows(position, np.zeros(3), {"feature": faces})
    turn = np.tile(np.concatenate([np.zeros(3), unit_vector(axis)]), (n, 1))
    about = tip_motion(machine.chain, machine.axes, run, [Motion(axis, "motion", turn)])[:, 3:]
    return layout(f"angle {axis}", "angle", run, about, {"zero": ""}, u)
