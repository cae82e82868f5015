"""Set-ups with a touch probe in a plan (design/1): spheres on the table, touched from five sides at a grid of rotary positions."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from typing import Any

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.units import quantity
from vcmm.task.instruments.touch_probe import touches
from vcmm.task.response.recording import Recording

SIDES = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1]], dtype=float)  # outward normals


def touch_setup(table: Any, machine: Machine, u: float) -> tuple[Recording, ...]:
    """Return the touches of one set-up of a plan. Raises UsageError for keys that are missing or wrong."""
    for key in ("spheres", "radius"):
        if getattr(table, key) in ("", None, []):
            raise UsageError(f'the set-up "{table.name}" with "touch probe" needs {key}')
    radius = quantity(table.radius, "length", "radius", "12.5 mm")
    if radius <= 0:
        raise UsageError(
            f'the set-up "{table.name}": radius = "{table.radius}" is that of the spheres, above zero'
        )
    spindle = [quantity(text, "angle", "spindle", "180 deg") for text in table.spindle] or [0.0]
    spheres = [list(s) for s in table.spheres]
    made = touches(
        machine,
        spheres,
        radius + table.tip_diameter / 2,
        poses_of(table, machine),
        directions=SIDES,
        u=u,
        offset=table.tip,
        spindle=spindle,
    )
    return (made,)


def poses_of(table: Any, machine: Machine) -> list[dict[str, float]]:
    """Return rotary positions (rad) by axis: every one of the first axis with every one of the next. Raises UsageError."""
    turning = [a for a in machine.chain.letters if is_rotary(a)]
    for letter in table.rotary:
        if letter not in turning:
            raise UsageError(f'the set-up "{table.name}" turns "{letter}".{choose_from(letter, turning)}')
    grid: Mapping[str, list[float]] = {
        a: [quantity(text, "angle", a, "30 deg") for text in texts] for a, texts in table.rotary.items()
    }
    empty = [a for a, angles in grid.items() if not angles]
    if empty:
        raise UsageError(
            f'the set-up "{table.name}" states no position of {empty[0]}; write {empty[0]} = ["0 deg", "90 deg"]'
        )
    return [dict(zip(grid, angles)) for angles in product(*grid.values())]
