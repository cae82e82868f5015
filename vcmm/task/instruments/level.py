"""Electronic level: the turn about a horizontal direction against gravity, from an arbitrary zero.

A level on the table and one on the tool, read differentially, see the turn between both. Turns about the vertical do not
move it. Own error: gain.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.task.instruments.instrument import GAIN, Instrument
from vcmm.task.instruments.laser import line
from vcmm.task.response.recording import Recording

LEVEL = Instrument("level", "angle", (GAIN,), ("zero",), "ISO 230-1:2012, 8.4.2.2")


def readings(
    machine: Machine,
    axis: str,
    targets: Array,
    at: Mapping[str, float],
    about: str,
    u: float,
    vertical: str = "Z",
) -> Recording:
    """Lay out readings of a differential level along an axis; about: "X" or "Y" (horizontal). Raises UsageError for a turn about the vertical."""
    if about == vertical:
        raise UsageError(
            f"a level does not see a turn about the vertical {vertical}; use an autocollimator or a laser (laser angle)"
        )
    return line(machine, axis, targets, at, np.zeros(3), component="ABC"["XYZ".index(about)], u=u)
