"""A face that was scanned on the machine, as tables and as a document."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.text import csv_of
from vcmm.show.tables.table import ResultTable, listing

if TYPE_CHECKING:
    from vcmm.learn.calibration.face_map import FaceFigure, FaceMap

SIZES = {"mm": (1e3, "µm", "um"), "rad": (1e6, "µrad", "urad")}


def figures(face: FaceMap) -> ResultTable[Any]:
    """Return every figure with its standard uncertainty."""
    rows = [(f.name, _text(f.value, f.unit), _text(f.u, f.unit)) for f in face.figures]
    return listing(f"face {face.scan.name}", ("figure", "value", "u"), rows)


def _text(value: float, unit: str) -> str:
    scale, word, _ = SIZES[unit]
    return f"{value * scale:.3g} {word}"


def profile_csv(face: FaceMap) -> str:
    """Return the profile of a turned face: radius, height, u, and the odd part of the slide's error."""
    assert face.r is not None
    assert face.profile is not None
    heads, columns = ["r_mm", "height_um", "u_um"], [face.r, face.profile * 1e3, face.u_profile * 1e3]
    if face.odd is not None and face.u_odd is not None:
        heads += ["odd_um", "u_odd_um"]
        columns += [face.odd * 1e3, face.u_odd * 1e3]
    return csv_of([heads, *([f"{v:.6g}" for v in row] for row in np.column_stack(columns))])


def map_csv(face: FaceMap) -> str:
    """Return the cells of the map that hold readings."""
    rows = [
        [f"{face.x[j]:.6g}", f"{face.y[i]:.6g}", f"{face.height[i, j] * 1e3:.6g}", f"{face.u[i, j] * 1e3:.6g}"]
        for i, j in zip(*np.nonzero(np.isfinite(face.height)))
    ]  # fmt: skip
    return csv_of([["x_mm", "y_mm", "height_um", "u_um"], *rows])


def face_json(face: FaceMap) -> dict[str, Any]:
    """Return the body of vcmm.face/1."""
    body: dict[str, Any] = {
        "name": face.scan.name,
        "kind": "spiral" if face.scan.spiral else "raster",
        "machine": face.machine or None,
        "readings": len(face.scan.x),
        "noise_um": face.noise * 1e3,
        "memory": face.memory,
        "figures": [_figure(f) for f in face.figures],
        "map": {"x_mm": face.x.tolist(), "y_mm": face.y.tolist(), "height_um": _cells(face.height), "u_um": _cells(face.u)},
    }  # fmt: skip
    if face.r is not None and face.profile is not None:
        body["profile"] = {"r_mm": face.r.tolist(), "height_um": (face.profile * 1e3).tolist(), "u_um": (face.u_profile * 1e3).tolist()}  # fmt: skip
    if face.odd is not None and face.u_odd is not None:
        body["odd_part"] = {"height_um": (face.odd * 1e3).tolist(), "u_um": (face.u_odd * 1e3).tolist()}
    return body


def _figure(f: FaceFigure) -> dict[str, Any]:
    scale, _, key = SIZES[f.unit]
    return {"name": f.name, "value": f.value * scale, "u": f.u * scale, "unit": key}


def _cells(values: Any) -> list[list[float | None]]:
    """Return rows along y; null where no reading lies."""
    return [[float(v) * 1e3 if np.isfinite(v) else None for v in row] for row in values]
