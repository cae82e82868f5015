"""Names of axes: X Y Z, the rotary axes A B C about them, and any further rotary axis by a number: A1, C2 ... C10.

The letter says in which direction the axis moves (or about which it turns) while all axes stand at zero; the number says
nothing. Component errors and locations carry the name at their end: EXA1, ECC2, X0B3.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import lru_cache

import numpy as np
import numpy.typing as npt

LINEAR, ROTARY = "XYZ", "ABC"
LETTERS = LINEAR + ROTARY  # of directions: translations, then rotations; the names of axes without a number
NAME = r"[XYZ]|[ABC](?:[1-9]\d?)?"
_UNITS = np.eye(3)
_UNITS.setflags(write=False)
AXIS_NAMES = "X Y Z, A B C, and rotary axes with a number such as A1 or C2"


def is_axis(name: str) -> bool:
    """Return whether this is the name of an axis: X, C, A1."""
    return re.fullmatch(NAME, name) is not None


@lru_cache(maxsize=256)
def is_rotary(name: str) -> bool:
    """Return whether this is the name of a rotary axis: C, A1."""
    return is_axis(name) and name[0] in ROTARY


def unit_vector(name: str) -> npt.NDArray[np.float64]:
    """Return the unit vector (3,) along which a linear axis moves or about which a rotary axis turns, all axes at zero; read-only."""
    return np.asarray(_UNITS[LETTERS.index(name[0]) % 3])


def in_order(names: Iterable[str]) -> list[str]:
    """Return the names sorted: X Y Z, then the rotary axes by letter and number."""
    return sorted(names, key=lambda a: (LETTERS.index(a[0]), int(a[1:] or 0)))


def axis_of(component: str) -> str:
    """Return the axis of a component error (EXA1 -> A1), of a location or of a squareness (X0C -> C), or "" for another name."""
    match = re.fullmatch(rf"(?:E[{LETTERS}]|[{LETTERS}]0)({NAME})", component)
    return match[1] if match else ""


def whole_turn(name: str, positions: npt.NDArray[np.float64]) -> bool:
    """Return whether positions (n,) rad of a rotary axis, increasing, go round exactly once."""
    return is_rotary(name) and abs(float(positions[-1] - positions[0]) - 2 * np.pi) < 1e-6


def is_component(name: str) -> bool:
    """Return whether this names a component error: EXX, EBX, EXA1."""
    return name[:1] == "E" and axis_of(name) != ""


def is_location(name: str) -> bool:
    """Return whether this names a location error of a rotary axis: X0C, A0C, C0C2."""
    return name[:1] != "E" and is_rotary(axis_of(name))
