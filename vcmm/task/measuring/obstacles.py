"""Obstacles around the part: head, quill, clamps, table; and the distances to be kept.

The head hangs on the last tool-side frame: its underside is where `Stylus.offset` counts from, `up` leads away from the
tip. From the underside to the root of the shaft runs an extension. Default sizes are those of a common motorised
head of 60 mm diameter on a ram of 80 x 80 mm; give your own where room is tight.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.pose import Array, Pose

SHAFT_SHARE = 0.7  # shaft diameter by default, of the tip diameter: common for balls of 2 mm to 8 mm


@dataclass(frozen=True)
class Head:
    """Sizes in mm. The head is a cylinder along `up`, the quill a bar (two sides, length) above it.

    shafts: stylus -> diameter of its shaft; by default SHAFT_SHARE of the tip diameter.
    """

    diameter: float = 60.0
    length: float = 100.0
    extension: float = 20.0
    quill: tuple[float, float, float] = (80.0, 80.0, 400.0)
    up: tuple[float, float, float] = (0.0, 0.0, 1.0)
    shafts: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Clamp:
    """A box that must not be touched: size (3,) mm, centred at `pose` in its frame.

    on="table": workpiece axes of the machine; on="part": drawing frame, it moves with the part.
    """

    name: str
    size: tuple[float, float, float]
    pose: Pose
    on: str = "table"

    def corners(self) -> Array:
        """Return the corners of the clamp (8, 3) in its frame."""
        signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=float)
        return self.pose.apply(0.5 * signs * np.array(self.size))


@dataclass(frozen=True, eq=False)
class Surroundings:
    """Lengths in mm, angles in rad; None = not limited.

    table     height of the table in workpiece axes: nothing may be below it
    safe      distance that head, quill and the moving stylus keep; shaft: what the shaft keeps at the touch
    steepest  largest angle between shaft (tip to head) and outward normal
    wall      thickness of material behind a measured surface where nothing else says how thick it is
    forms     feature -> standard deviation of its form, for the choice of points
    """

    head: Head = field(default_factory=Head)
    clamps: tuple[Clamp, ...] = ()
    table: float | None = None
    safe: float = 2.0
    shaft: float = 0.05
    steepest: float = float(np.radians(120.0))
    wall: float = 5.0
    forms: Mapping[str, float] = field(default_factory=dict)

    def __post_init__(self) -> None:
        problems = []
        names = [c.name for c in self.clamps]
        for name in sorted({n for n in names if names.count(n) > 1}):
            problems.append(f'Two clamps are named "{name}"; rename one.')
        for c in self.clamps:
            if self.table is not None and c.on == "table" and c.corners()[:, 2].max() <= self.table:
                problems.append(
                    f'The clamp "{c.name}" lies below the table at {self.table:g} mm; correct its centre or the table.'
                )
        if problems:
            raise DataError(problems)
