"""Measured data as read from files: points and values of one part, each with its place in the file."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.core.run import Array


@dataclass(frozen=True, eq=False)
class GivenPoints:
    """points, normals (n, 3) mm; where: file and line of every point; features None = in the order of the plan."""

    part: str
    points: Array
    where: tuple[str, ...]
    features: tuple[str, ...] | None = None
    styli: tuple[str, ...] | None = None
    normals: Array | None = None
    step: float = 0.0  # mm: of the last digit of the coordinates; 0 where the file does not tell it


@dataclass(frozen=True)
class GivenValue:
    """One characteristic: number in mm or rad, absolute or a deviation from nominal; angle: the column said so.

    bonus: mm of a deviation that the size of the feature pays for and that are still in `number`; None: the export does not say.
    """

    part: str
    name: str
    number: float
    angle: bool
    deviation: bool
    where: str
    bonus: float | None = 0.0
