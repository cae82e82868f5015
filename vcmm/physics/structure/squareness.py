"""Squareness of linear axes and location of rotary axes (ISO 230-1 position-independent errors)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import axis_of, is_location
from vcmm.core.declaration import UM, URAD, About, ForDiagnosis, Trade, Typical, Words
from vcmm.core.effect import COLUMN, Effect, at, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run

PAIRS = ("C0Y", "B0Z", "A0Z")


@dataclass(frozen=True, eq=False)
class Squareness(Effect):
    """The travel direction of the second-named axis is turned about A, B or C; the stylus does not turn.

    A tool-side Y with C0Y = +c shifts the tip by (-c y, 0, 0); Z with B0Z = +b by (b z, 0, 0), with A0Z = +a by
    (0, -a z, 0); the same formulas hold for an axis that carries the workpiece.
    """

    name = "squareness"
    about = About(
        cites="ISO 230-1:2012, 3.6 and annex A",
        trade=Trade(
            "squareness {where}",
            "measure squareness {where} and correct it, or place the part where it shows less (vcmm place)",
        ),
        words=Words(
            seen="{where} is out of square by {angle}",
            causes="a collision, or the machine was moved or levelled anew, or a guide was adjusted",
            confirm="a square or two diagonals, the artefact turned by 90 degrees",
            signed=("angle",),
        ),
        table_parameter="angle",
        is_calibrated=True,
    )
    diagnosis = ForDiagnosis(
        special_case_of=("geometric_change", "map_interpolation"),
        shared_physics="geometry",
        is_uniform=True,
    )
    per = "pair"
    place = "travel"
    pair: str = at("C0Y", "C0Y, B0Z or A0Z (also B0X, A0Y ... where another axis is primary)")
    angle: float = param(
        0.0,
        "urad",
        "angle between the axes, right-hand about the first letter",
        typical=Typical(
            10 * URAD, "usual: stale squareness 1-50 urad; frames set by eye 1-3 mrad", most=5e-3
        ),
    )

    def __post_init__(self) -> None:
        p = self.pair
        if (
            len(p) != 3
            or p[0] not in "ABC"
            or p[1] != "0"
            or p[2] not in "XYZ"
            or "XYZ"["ABC".index(p[0])] == p[2]
        ):
            raise UsageError(f'pair = "{p}" is not a squareness error; allowed are {", ".join(PAIRS)}')

    @property
    def link(self) -> str:
        return self.pair[2]

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, COLUMN[self.pair[0]]] = self.angle
        return out


@dataclass(frozen=True, eq=False)
class RotaryLocation(Effect):
    """The centre line of a rotary axis is shifted (X0C, Y0C) or tilted (A0C, B0C) in the frame that carries it.

    A tilting head with X0B = +d shifts the tip by +d, a table with X0C = +d by -d, already at zero angle.
    """

    name = "rotary_location"
    about = About(
        cites="ISO 230-1:2012, 3.7; ISO 230-7",
        trade=Trade(
            "location of the rotary axis, {where}",
            "touch a sphere on the table at four angles and correct {where}",
        ),
        words=Words(
            seen="the centre line of {where} is not where it should be ({offset}{tilt})",
            causes="a collision, or the table was set anew",
            confirm="touch a sphere on the table at four angles",
        ),
        is_calibrated=True,
    )
    per = "component"
    place = "location"
    own = True
    diagnosis = ForDiagnosis(
        special_case_of=("geometric_change",),
        is_uniform=True,
    )
    component: str = at("X0C", "location error, for example X0C, A0C, Y0A, C0A")
    offset: float = param(
        0.0,
        "um",
        "shift of the centre line (X0, Y0, Z0 errors)",
        only="XYZ",
        typical=Typical(10 * UM, "five-axis machines: 5-50 um; links of an arm to 2 mm", most=2.0),
    )
    tilt: float = param(
        0.0,
        "urad",
        "tilt of the centre line (A0, B0, C0 errors)",
        only="ABC",
        typical=Typical(
            20 * URAD, "five-axis machines: 10-100 urad; mounts set up in the field to 1 deg", most=20e-3
        ),
    )

    def __post_init__(self) -> None:
        c = self.component
        if not is_location(c):
            raise UsageError(
                f'component = "{c}" is not a location error of a rotary axis; write for example "X0C" or "A0C"'
            )

    @property
    def link(self) -> str:
        return axis_of(self.component)

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, COLUMN[self.component[0]]] = self.offset if self.component[0] in "XYZ" else self.tilt
        return out
