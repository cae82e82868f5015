"""Figures of a calibrated machine, computed from the file that was written, read back."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def field_figures(path: Path) -> list[dict[str, Any]]:
    """Largest and mean tip error and body diagonals over the measured volume, with standard uncertainty, um."""
    from vcmm.calibrating.acceptance import volume_figures
    from vcmm.files.machine import load_machine

    return [f.document() for f in volume_figures(load_machine(path))]
