"""General tolerances: ISO 2768-1 (f m c v) for sizes and angles, ISO 2768-2 (H K L) for geometry, ISO 22081 as the drawing states them.

general_limits("ISO 2768-mK", "size", 30.0)     ->  (-0.2, 0.2)
general_zone("ISO 2768-mK", "flatness", 80.0)   ->  0.2
"""

from __future__ import annotations

import math
import re
from bisect import bisect_left

from vcmm.core.errors import UsageError

_NAME = re.compile(r"ISO\s*2768\s*-?\s*(?P<size>[fmcv])?\s*(?P<form>[HKL])?$")
LENGTHS = (6, 30, 120, 400, 1000, 2000, 4000)  # up to and including, mm; below 0.5 mm none
SIZES: dict[str, tuple[float | None, ...]] = {
    "f": (0.05, 0.1, 0.15, 0.2, 0.3, 0.5, None),
    "m": (0.1, 0.2, 0.3, 0.5, 0.8, 1.2, 2.0),
    "c": (0.2, 0.5, 0.8, 1.2, 2.0, 3.0, 4.0),
    "v": (0.5, 1.0, 1.5, 2.5, 4.0, 6.0, 8.0),
}
TOLERANCES_TO_3_MM = {"f": 0.05, "m": 0.1, "c": 0.2, "v": None}  # 0.5 to 3 mm
LEGS = (10, 50, 120, 400)  # shorter side of the angle, mm
ANGLES: dict[str, tuple[float, ...]] = {  # arc minutes
    "f": (60, 30, 20, 10, 5), "m": (60, 30, 20, 10, 5), "c": (90, 60, 30, 15, 10), "v": (180, 120, 60, 30, 20),
}  # fmt: skip
FLAT = (10, 30, 100, 300, 1000, 3000)
ZONES: dict[str, tuple[tuple[int, ...], dict[str, tuple[float, ...]]]] = {
    "flatness": (FLAT, {"H": (0.02, 0.05, 0.1, 0.2, 0.3, 0.4), "K": (0.05, 0.1, 0.2, 0.4, 0.6, 0.8), "L": (0.1, 0.2, 0.4, 0.8, 1.2, 1.6)}),
    "perpendicularity": ((100, 300, 1000, 3000), {"H": (0.2, 0.3, 0.4, 0.5), "K": (0.4, 0.6, 0.8, 1.0), "L": (0.6, 1.0, 1.5, 2.0)}),
    "symmetry": ((100, 300, 1000, 3000), {"H": (0.5, 0.5, 0.5, 0.5), "K": (0.6, 0.6, 0.8, 1.0), "L": (0.6, 1.0, 1.5, 2.0)}),
    "circular_runout": ((10_000,), {"H": (0.1,), "K": (0.2,), "L": (0.5,)}),
}  # fmt: skip
ZONES["straightness"] = ZONES["flatness"]
ZONES["parallelism"] = ZONES["flatness"]
ZONES["roundness"] = ZONES["circular_runout"]  # the tolerance of the diameter, at most that of run-out


def classes(standard: str) -> tuple[str, str]:
    """Split the classes of a standard: ("m", "K") of "ISO 2768-mK", either may be "". UsageError for another text."""
    match = _NAME.fullmatch(standard.strip())
    if not match or not (match["size"] or match["form"]):
        raise UsageError(
            f'"{standard}" is no general tolerance; write for example "ISO 2768-mK", "ISO 2768-m" or a table for ISO 22081'
        )
    return match["size"] or "", match["form"] or ""


def general_limits(standard: str, kind: str, size: float) -> tuple[float, float] | None:
    """Return (lower, upper) from nominal of a "size", "distance" (size mm) or "angle" (size: the shorter side, mm; rad). None: no class.

    UsageError outside the ranges of the standard.
    """
    letter = classes(standard)[0]
    if not letter:
        return None
    if kind == "angle":
        width = math.radians(ANGLES[letter][bisect_left(LEGS, size)] / 60.0)
        return -width, width
    value = (
        TOLERANCES_TO_3_MM[letter]
        if 0.5 <= size <= 3.0
        else SIZES[letter][bisect_left(LENGTHS, size)]
        if 3.0 < size <= LENGTHS[-1]
        else None
    )
    if value is None:
        raise UsageError(f"{standard} has no tolerance for {size:g} mm; write the limits")
    return -value, value


def general_zone(standard: str, kind: str, size: float) -> float | None:
    """Return the zone in mm of a geometrical characteristic over a length or diameter of `size` mm; None where the standard has none."""
    letter = classes(standard)[1]
    if not letter or kind not in ZONES:
        return None
    ranges, values = ZONES[kind]
    if size > ranges[-1]:
        raise UsageError(f"{standard} has no {kind} tolerance for {size:g} mm; write the zone")
    return values[letter][bisect_left(ranges, size)]
