"""Readings of a probe against an artefact of straight lines: straightedge, square; capacitance and optical probes.

straightedge       d across the travel, from a line that lies anywhere (zero, slope)   own errors: form at its places, gain of the probe
square             d across both travels, the square lying anywhere (alignment)        own errors: angle, gain of the probe
capacitance probe  d towards a face that lies anywhere (zero, slope)                   own errors: gain, drift with time_s
optical probe      the same                                                            own errors: gain, drift with time_s
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.instruments.instrument import GAIN, Instrument, OwnError, of_features, since_start
from vcmm.task.instruments.laser import line
from vcmm.task.instruments.laying import join_layouts
from vcmm.task.response.recording import Recording

ARMS = ("first", "second")


def arm_angle(recording: Recording, run: Run) -> Array:
    """Return the reading of the second arm (label feature) when it is turned by 1 rad against the first, in their plane, (m, 1).

    Right-hand about first x second. Raises UsageError without the labels "first" and "second".
    """
    labels = run.labels.get("feature")
    if labels is None or not set(ARMS) <= set(labels.tolist()):
        raise UsageError(
            'a square needs the label column feature with "first" and "second" (arm) in its rows'
        )
    mine = [np.flatnonzero(labels[recording.row] == arm) for arm in ARMS]
    first, second = (run.tip[recording.row[rows]] for rows in mine)
    normal = np.cross(_way(first), _way(second))
    normal = normal / np.linalg.norm(normal)
    out = np.zeros((recording.m, 1))
    moved = np.cross(normal, second - second.mean(axis=0))
    out[mine[1], 0] = (moved * recording.direction[mine[1]]).sum(axis=1)
    return out


def _way(tips: Array) -> Array:
    """Return the unit vector (3,) from the first of the places (n, 3) to the furthest from it."""
    away = tips - tips[0]
    way = away[np.linalg.norm(away, axis=1).argmax()]
    return np.asarray(way / np.linalg.norm(way))


FORM = OwnError(
    "form", "um", of_features, "u of the calibrated form at one place (label feature)", is_permanent=False
)
ANGLE = OwnError("angle", "urad", arm_angle, "u of the calibrated angle between its arms")
DRIFT = OwnError("drift", "um/h", since_start, "u of its drift", is_permanent=False)
STRAIGHTEDGE = Instrument(
    "straightedge", "displacement", (FORM, GAIN), ("zero", "slope"), "ISO 230-1:2012, 8.2.2"
)
SQUARE = Instrument("square", "displacement", (ANGLE, GAIN), ("alignment",), "ISO 230-1:2012, 10.3.2")
CAPACITANCE = Instrument(
    "capacitance probe",
    "displacement",
    (GAIN, DRIFT),
    ("zero", "slope"),
    "ISO 230-3:2020, 5; ISO 230-7:2015, annex D",
)
OPTICAL = Instrument("optical probe", "displacement", (GAIN, DRIFT), ("zero", "slope"), "ISO 230-1:2012, 5.2")


def edge(
    machine: Machine,
    axis: str,
    targets: Array,
    at: Mapping[str, float],
    offset: Array,
    component: str,
    u: float,
) -> Recording:
    """Lay out a straightedge along an axis, read across it in component "X", "Y" or "Z", there and back; label feature: the place on it."""
    if component == axis or component not in "XYZ":
        raise UsageError(
            f"a straightedge along {axis} is read across it: component = one of X Y Z other than {axis}"
        )
    group = line(machine, axis, targets, at, offset, component=component, u=u)
    places = np.array([f"{q:.6g}" for q in group.run.q(axis)])
    return replace(group, run=replace(group.run, labels={**group.run.labels, "feature": places}))


def square(
    machine: Machine,
    axes: tuple[str, str],
    targets: tuple[Array, Array],
    at: Mapping[str, float],
    offset: Array,
    u: float,
) -> Recording:
    """Lay out a square along two axes, each arm read in the direction of the other axis; at: positions of the axes while they do not move."""
    arms = []
    for i, (axis, other) in enumerate((axes, axes[::-1])):
        group = line(machine, axis, targets[i], at, offset, component=other, u=u)
        labels = {"feature": np.array([ARMS[i]] * group.run.n)}
        arms.append(replace(group, run=replace(group.run, labels=labels)))
    return replace(join_layouts(f"square {''.join(axes)}", arms), nuisance={"alignment": ""})
