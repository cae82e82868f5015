"""A face that was scanned on the machine, as tables and as a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.text import csv_of
from vcmm.show.tables.table import ResultTable, listing

if TYPE_CHECKING:
    from vcmm.learn.calibration.face_map import FaceFigure, FaceMap

SIZES = {"mm": (1e3, "µm", "um"), "rad": (1e6, "µrad", "urad")}


def figures(found: FaceMap) -> ResultTable[Any]:
    """Return every figure with its standard uncertainty."""
    rows = [(f.name, _text(f.value, f.unit), _text(f.u, f.unit)) for f in found.figures]
    return listing(f"face {found.scan.name}", ("figure", "value", "u"), rows)


def _text(value: float, unit: str) -> str:
    scale, word, _ = SIZES[unit]
    return f"{value * scale:.3g} {word}"


def profile_csv(found: FaceMap) -> str:
    """Return the profile of a turned face: radius, height, u, and the odd part of the slide's error."""
    assert found.r is not None
    assert found.profile is not None
    heads, columns = ["r_mm", "height_um", "u_um"], [found.r, found.profile * 1e3, found.u_profile * 1e3]
    if found.odd is not None and found.u_odd is not None:
        heads += ["odd_um", "u_odd_um"]
        columns += [found.odd * 1e3, found.u_odd * 1e3]
    return csv_of([heads, *([f"{v:.6g}" for v in row] for row in np.column_stack(columns))])


def map_csv(found: FaceMap) -> str:
    """Return the cells of the map that hold readings."""
    rows = [
        [f"{found.x[j]:.6g}", f"{found.y[i]:.6g}", f"{found.height[i, j] * 1e3:.6g}", f"{found.u[i, j] * 1e3:.6g}"]
        for i, j in zip(*np.nonzero(np.isfinite(found.height)))
    ]  # fmt: skip
    return csv_of([["x_mm", "y_mm", "height_um", "u_um"], *rows])


def face_json(found: FaceMap) -> dict[str, Any]:
    """Return the body of vcmm.face/1."""
    body: dict[str, Any] = {
        "name": found.scan.name,
        "kind": "spiral" if found.scan.spiral else "raster",
        "machine": found.machine or None,
        "readings": len(found.scan.x),
        "noise_um": found.noise * 1e3,
        "memory": found.memory,
        "figures": [_figure(f) for f in found.figures],
        "map": {"x_mm": found.x.tolist(), "y_mm": found.y.tolist(), "height_um": _cells(found.height), "u_um": _cells(found.u)},
    }  # fmt: skip
    if found.r is not None and found.profile is not None:
        body["profile"] = {"r_mm": found.r.tolist(), "height_um": (found.profile * 1e3).tolist(), "u_um": (found.u_profile * 1e3).tolist()}  # fmt: skip
    if found.odd is not None and found.u_odd is not None:
        body["odd_part"] = {"height_um": (found.odd * 1e3).tolist(), "u_um": (found.u_odd * 1e3).tolist()}
    return body


def _figure(f: FaceFigure) -> dict[str, Any]:
    scale, _, key = SIZES[f.unit]
    return {"name": f.name, "value": f.value * scale, "u": f.u * scale, "unit": key}


def _cells(values: Any) -> list[list[float | None]]:
    """Return rows along y; null where no reading lies."""
    return [[float(v) * 1e3 if np.isfinite(v) else None for v in row] for row in values]
