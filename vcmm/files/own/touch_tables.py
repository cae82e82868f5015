"""Read [touch] of a recording file, the touched features, the probe and the zero; and convert the log of the control to a Recording."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.reach import linear_positions
from vcmm.core.run import Array, Run
from vcmm.files.foreign.touch_log import TouchLog, read_touch_log
from vcmm.files.problems import TableProblems
from vcmm.files.schema import Distance, Point, Table
from vcmm.task.instruments.probe_frame import SPINDLE, head_axes
from vcmm.task.instruments.touched_surfaces import PLANE, TouchedSurface, recording_of_touches
from vcmm.task.response.recording import Recording

ORIGIN = (0.0, 0.0, 0.0)


class TouchedTable(Table):
    """A feature on the table: workpiece axes, its place while every rotary axis is at zero; to a millimetre is enough.

    part: faces of one block name the same; what lies between them is then as stated (a calibrated length), and the block lies anywhere.
    """

    type: Literal["sphere", "plane", "ring"] = "sphere"
    point: Point = Field(examples=['"150 0 80 mm"'])
    diameter: Distance = 0.0
    normal: list[float] | None = Field(default=None, min_length=3, max_length=3, examples=["[0, 0, 1]"])
    axis: list[float] | None = Field(default=None, min_length=3, max_length=3, examples=["[0, 0, 1]"])
    part: str = Field(default="", examples=['"block"'])


class TouchesTable(Table):
    """Probe and place (format touches). log: X Y Z are of the surface (the control has taken the ball off along I J K), or of the middle of the ball.

    zero: where the work offset of the program lies for the tip, in the axes of the machine, rotary axes at zero. head: where a head turns, what X Y Z are: of
    the axes, as if it stood at zero (no tool centre point control), or of the tip where it is, in the axes of the machine (G43.4, TRAORI, M128).
    """

    features: dict[str, TouchedTable]
    tip_diameter: Distance = Field(examples=['"6 mm"'])
    offset: Point = ORIGIN
    zero: Point = ORIGIN
    log: Literal["surface", "centre"] = "surface"
    head: Literal["axes", "tip"] | None = None


def surfaces_of(table: TouchesTable) -> dict[str, TouchedSurface]:
    """Return the features by name. Raises TableProblems with the key."""
    out = {}
    for name, surface in table.features.items():
        key = ("features", name)
        if surface.type == "plane" and (
            surface.normal is None or surface.axis is not None or surface.diameter
        ):
            raise TableProblems([(key, "a plane takes point and normal, no axis and no diameter")])
        if surface.type != "plane" and (not surface.diameter or surface.normal is not None):
            raise TableProblems([(key, f"a {surface.type} takes point and diameter, no normal")])
        if surface.type == "sphere" and surface.axis is not None:
            raise TableProblems([(key, "a sphere has no axis")])
        way = np.array(surface.normal or surface.axis or [0.0, 0.0, 1.0], dtype=float)
        if not np.linalg.norm(way) > 0:
            raise TableProblems([(key, "normal or axis is 0 0 0; it is a direction")])
        unit = way / np.linalg.norm(way)
        place, axis = (tuple(float(v) for v in w) for w in (surface.point, unit))
        out[name] = TouchedSurface(surface.type, place, axis, surface.diameter / 2, surface.part)  # type: ignore[arg-type]
    return out


def read_touches(table: TouchesTable, path: Path, machine: Machine) -> Recording:
    """Read the log as touches along their normals. Raises DataError and UsageError with lines, TableProblems with the key."""
    surfaces = surfaces_of(table)
    touch_log = read_touch_log(path)
    _check_head(table, machine)
    absent = [a for a in "ABC" if a in touch_log.letters and a not in machine.chain.letters]
    if absent:
        raise UsageError(
            f"the log turns {' '.join(absent)}, which the machine {machine.chain.structure} does not have"
        )
    try:
        return recording_of_touches(
            machine, _run(table, touch_log, machine), surfaces, table.tip_diameter / 2, touch_log.lines
        )
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from None


def _run(table: TouchesTable, touch_log: TouchLog, machine: Machine) -> Run:
    """Return positions of the axes: the middle of the ball, less its offset, plus the zero."""
    place = np.stack([touch_log.values[c] for c in "XYZ"], axis=1)
    if table.log == "surface":
        way = _ways(touch_log)
        place = place - way * table.tip_diameter / 2
    offset = np.array(table.offset)
    tip = place + np.array(table.zero)
    n = len(tip)
    turned = {
        a: np.radians(touch_log.values.get(a[0], np.zeros(n))) for a in machine.chain.letters if is_rotary(a)
    }
    linear = _linear_axes(machine, turned, offset, tip, leads=table.head == "tip")
    position = {a: turned[a] if a in turned else linear[a] for a in machine.chain.letters}
    columns = {"time_s": touch_log.values["T"]} if "T" in touch_log.letters else {}
    if "S" in touch_log.letters and np.any(touch_log.values["S"]):
        columns[SPINDLE] = np.radians(touch_log.values["S"])
    return Run(position, np.tile(offset, (n, 1)), columns, {"feature": touch_log.features})


def _check_head(table: TouchesTable, machine: Machine) -> None:
    """Raise UsageError where a head turns and the meaning of X Y Z is not stated, or where it is stated and no head turns."""
    turning = " ".join(head_axes(machine))
    if turning and table.head is None:
        raise UsageError(
            f'the head turns by {turning}, so X Y Z of the log may be those of the axes, as if it stood at zero, or those of the tip: add head = "axes" to [touch] '
            'where no tool centre point control was on while it touched (programs of vcmm calibrate program), head = "tip" where it was (G43.4, TRAORI, M128)'
        )
    if table.head is not None and not turning:
        raise UsageError(
            f'head = "{table.head}": the machine {machine.chain.structure} has no axis that turns a head; leave it out'
        )


def _linear_axes(
    machine: Machine, turned: dict[str, Array], offset: Array, tip: Array, *, leads: bool
) -> dict[str, Array]:
    """Return positions of X Y Z whose tip (n, 3), in the axes of the machine, is that of the log; leads: with the head as it is turned,
    else with every axis at zero."""
    n, head = len(tip), head_axes(machine)
    position = {a: np.zeros(n) for a in machine.chain.letters}
    position |= {a: q for a, q in turned.items() if leads and a in head}
    return linear_positions(machine, Run(position, np.tile(offset, (n, 1))), tip)


def _ways(touch_log: TouchLog) -> Array:
    """Return the unit way of the probe (n, 3). Raises UsageError where a line leaves it out."""
    way = np.stack([touch_log.values[c] for c in "IJK"], axis=1)
    size = np.linalg.norm(way, axis=1)
    if (size == 0).any():
        line = int(touch_log.lines[int(np.flatnonzero(size == 0)[0])])
        raise UsageError(
            f'line {line}: the way of the probe I J K is missing, along which the control took the ball off; add it, or write log = "centre"'
        )
    return way / size[:, None]


__all__ = ["PLANE", "TouchedTable", "TouchesTable", "read_touches", "surfaces_of"]
