"""scan/1: a spiral or raster scan of a face, as the probe on the machine read it.

vcmm = "scan/1"
name = "mirror 7"
kind = "spiral"            # "spiral": X_mm, C_deg, the spindle turns the part; "raster": X_mm, Y_mm
data = "scan.csv"          # and d_um, + where the face is higher (along +Z) than programmed; run, where there are several scans
radius = "250 mm"          # of a sphere that was programmed, + convex; left out: a plane, a cone, any other
level = "plane"            # raster: what is taken off each scan, its "plane" or its mean ("offset")
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from vcmm.core.errors import DataError, UsageError
from vcmm.core.units import quantity
from vcmm.files.columns import read_positions
from vcmm.files.problems import Problems
from vcmm.files.schema import Table, checked_model
from vcmm.files.toml import check_version, read_toml
from vcmm.task.instruments.face_scan import FaceScan

UM = 1e-3  # mm


class FaceScanFile(Table):
    """scan/1"""

    vcmm: str
    name: str = Field(default="", examples=['"mirror 7"'])
    kind: Literal["spiral", "raster"]
    data: str = Field(examples=['"scan.csv"'])
    radius: str = Field(default="", examples=['"250 mm"'])
    level: Literal["plane", "offset"] = "plane"


def load_face_scan(path: str | Path) -> FaceScan:
    """Read a scan and its rows. Raises DataError with every problem: file, line, what is allowed."""
    document = read_toml(path)
    check_version(document, "scan")
    problems = Problems(document)
    model = checked_model(FaceScanFile, document.data, problems)
    radius = (
        0.0 if model is None or not model.radius else problems.attempt(("radius",), lambda: _radius(model))
    )
    if model is not None and model.kind == "spiral" and "level" in model.model_fields_set:
        problems.add(
            ("level",),
            'level belongs to kind = "raster"; the tilt of a turned face is always taken off; remove it',
        )
    problems.raise_if_any()
    assert model is not None
    assert radius is not None
    return _read(model, document.path.parent / model.data, radius, model.name or document.path.stem)


def _radius(model: FaceScanFile) -> float:
    if model.kind != "spiral":
        raise UsageError('radius belongs to kind = "spiral"; remove it')
    return quantity(model.radius, "length", "radius", "250 mm")


def _read(model: FaceScanFile, data: Path, radius: float, name: str) -> FaceScan:
    spiral = model.kind == "spiral"
    run = read_positions(data, ("X", "C") if spiral else ("X", "Y"))
    if "d_um" not in run.columns:
        raise DataError(
            f"{data}:1: the column d_um is missing; it holds what the probe read above the programmed face"
        )
    idle = sorted((set(run.columns) - {"d_um"}) | (set(run.labels) - {"run"}))
    if idle:
        raise DataError(f"{data}:1: nothing uses the column {idle[0]} of a scan of a face; remove it")
    return FaceScan(
        name=name,
        spiral=spiral,
        x=run.q("X"),
        across=run.q("C" if spiral else "Y"),
        reading=run.columns["d_um"] * UM,
        run=run.labels.get("run", np.full(run.n, "", dtype=np.str_)),
        level=model.level,
        radius=radius,
    )
