"""Touch-trigger probe in the spindle: spheres, faces of a block and rings on the table, touched at several rotary positions.

A touch reads where the surface is along its outward normal (indicated - true). The place of each feature on the table is free
(nuisance `offset` of a sphere or a ring, `rigid` of a face, by the label feature), its size and the mean pre-travel too (nuisance `radius`):
a ball that is 1 um larger and a probe that triggers 0.5 um earlier all round read the same. Own errors of the probe:

    offset    the ball is beside the axis of the spindle, and the length is wrong: (x, y, z) in the frame of the probe
    lobing    pre-travel over the direction across the stylus: cos and sin of 2 and 3 times the angle, by the lateral share
    axial     pre-travel along the stylus less that across it, with the square of the axial share
    diameter  of the calibrated sphere, block or ring, outwards; of use where `radius` is not free

The frame of the probe is that of the last tool-side axis, turned by spindle_angle (right-hand about +Z of that frame). With touches
in the four directions of the axes alone a three-lobed pre-travel cannot be told from the offset; touches between them, or a turned
spindle, separate the two.

Sources: Ibaraki, Iritani & Matsushita, Int. J. Mach. Tools Manuf. 58 (2012) 48 (location errors by on-the-machine probing);
ISO 230-10:2016, 6.2 (probing errors); Estler et al., Precision Engineering 19 (1996) 85 (pre-travel variation, three lobes).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.reach import linear_positions
from vcmm.core.run import Array, Run
from vcmm.task.instruments.artefact import DIAMETER
from vcmm.task.instruments.instrument import Instrument, OwnError
from vcmm.task.instruments.laying import layout
from vcmm.task.instruments.probe_frame import (
    SPINDLE,
    head_axes,
    machine_directions,
    normals_in_probe,
    tool_directions,
)
from vcmm.task.response.recording import Recording

ORDERS = (2, 3)  # lobes


def ball_beside_axis(recording: Recording, run: Run) -> Array:
    """Return the reading per offset of the ball (m, 3): a ball displaced by +1 in x of the probe meets a surface that faces +x one
    earlier: indicated - true = -n."""
    return -normals_in_probe(recording, run)


def lobes(recording: Recording, run: Run) -> Array:
    """Return cos 2t, sin 2t, cos 3t, sin 3t times the lateral share (m, 4); t: angle of the normal about the stylus."""
    n = normals_in_probe(recording, run)
    lateral, angle = np.hypot(n[:, 0], n[:, 1]), np.arctan2(n[:, 1], n[:, 0])
    waves = [wave(k * angle) * lateral for k in ORDERS for wave in (np.cos, np.sin)]
    return np.stack(waves, axis=1)


def axial_share(recording: Recording, run: Run) -> Array:
    """Return the square of the share of the normal along the stylus, as (m, 1)."""
    return normals_in_probe(recording, run)[:, 2:] ** 2


OFFSET = OwnError("offset", "um", ball_beside_axis, "u of where its ball stands: beside the axis, and length")
LOBING = OwnError(
    "lobing", "um", lobes, "u of its pre-travel over the direction, each of two and three lobes"
)
AXIAL = OwnError("axial", "um", axial_share, "u of pre-travel along the stylus less that across it")
TOUCH_PROBE = Instrument(
    "touch probe",
    "probe",
    (OFFSET, LOBING, AXIAL, DIAMETER),
    ("offset", "radius"),
    "ISO 230-10:2016; Ibaraki, Int. J. Mach. Tools Manuf. 58 (2012) 48",
)


def touches(
    machine: Machine,
    spheres: Sequence[Sequence[float]],
    radius: float,
    poses: Sequence[dict[str, float]],
    directions: Array,
    u: float,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
    names: Sequence[str] = (),
    spindle: Sequence[float] = (0.0,),
    tilt: float = np.radians(120.0),
) -> Recording:
    """Lay out touches of spheres (place (3,) mm, workpiece axes, rotary axes at zero) at rotary positions (rad), spindle at angles (rad).

    directions (k, 3): outward normals in the axes of the machine, along which a control touches however its head is turned. A touch whose normal is more than
    `tilt` from +Z of the table, where the stem of the sphere is, is left out, and with a head that is turned one at which the stylus would lean over the sphere. radius mm of the surface on which the middle of the ball lies; u mm per touch.
    Raises ModelLimit where nothing can be touched, or the linear axes cannot reach it.
    """
    rows: list[tuple[int, int, float, Array]] = []
    letters = machine.chain.letters
    for k, pose in enumerate(poses):
        at_pose = Run({a: np.array([pose.get(a, 0.0)]) for a in letters}, np.zeros((1, 3)))
        outward = directions @ machine_directions(machine, at_pose)[0]  # workpiece axes
        stylus = (
            tool_directions(machine, at_pose)[0][2] if head_axes(machine) else None
        )  # from the ball to the spindle
        rows += [
            (i, k, angle, n)
            for i in range(len(spheres))
            for angle in spindle
            for n in outward
            if n[2] > np.cos(tilt) - 1e-9 and (stylus is None or n @ stylus > -1e-9)
        ]
    if not rows:
        raise ModelLimit("no direction of touch is free of the stems of the spheres; add directions")
    normal = np.array([r[3] for r in rows])
    place = np.array([spheres[r[0]] for r in rows]) + radius * normal
    turned = {a: np.array([poses[r[1]].get(a, 0.0) for r in rows]) for a in letters}
    labels = {
        "feature": np.array([(names[r[0]] if names else str(r[0] + 1)) for r in rows], dtype=np.str_),
        "pose": np.array([str(r[1] + 1) for r in rows], dtype=np.str_),
    }
    run = Run(turned, np.tile(np.asarray(offset, dtype=float), (len(rows), 1)), {}, labels)
    run = replace(run, position=linear_positions(machine, run, place))
    if any(spindle):
        run = run.with_columns({SPINDLE: np.array([r[2] for r in rows])})
    return layout("touch probe", "probe", run, normal, {"offset": "feature", "radius": ""}, u)
