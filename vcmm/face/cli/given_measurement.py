"""Measured data of `vcmm evaluate`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class GivenMeasurement:
    """Measured data: a file of points or of values. frame: of the points; None for the usual one, that of the part."""

    points: Path | None
    values: Path | None
    frame: str | None
    tip_centres: bool

    @property
    def file(self) -> Path:
        file = self.points or self.values
        assert file is not None  # check_inputs refuses it
        return file

    def options(self) -> dict[str, Any]:
        """Return the data by the names of the options."""
        return {
            "points": self.points, "values": self.values, "frame": self.frame, "tip_centres": self.tip_centres,
        }  # fmt: skip
