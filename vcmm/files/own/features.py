"""Read [part.features] tables: nominal surfaces and elements, their stated forms, and their points in CSV files."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from vcmm.core.errors import DataError, UsageError, choose_from
from vcmm.core.run import Array
from vcmm.files.problems import TableProblems, misspelt
from vcmm.files.schema import Angle, Deviation, Direction, Point, Size, Table, TwoSizes, read_model
from vcmm.files.sheets import Sheet, SheetColumn, read_csv
from vcmm.files.toml import Document, Location
from vcmm.part.form import Lobes
from vcmm.part.nominal import NominalPoints
from vcmm.part.part import Feature

PLACES, NORMALS = ("x_mm", "y_mm", "z_mm"), ("nx", "ny", "nz")


def read_points(path: Path, with_normals: bool = False) -> tuple[Sheet, Array, Array | None]:
    """Read points on a drawing: x_mm y_mm z_mm, with or without their normals nx ny nz. Return the sheet, points (n, 3) mm and normals (n, 3) as written, None without. with_normals: normals are required.

    DataError: columns that are missing or unknown, cells that are no numbers, normals that are no unit vectors.
    """
    sheet = read_csv(path)
    normals = with_normals or any(column in sheet.header for column in NORMALS)
    unknown = [column for column in sheet.header if column not in PLACES + NORMALS]
    needs = "x_mm,y_mm,z_mm,nx,ny,nz" if with_normals else "x_mm,y_mm,z_mm and may have nx,ny,nz"
    columns = [
        SheetColumn(
            name,
            optional=name in NORMALS and not normals,
            advice=f".{misspelt(name, unknown)} The file needs {needs}",
        )
        for name in PLACES + NORMALS
    ]
    problems = sheet.missing(columns)
    problems += sheet.unknown(PLACES + NORMALS, lambda name: f".{choose_from(name, PLACES + NORMALS)}")
    if problems:
        raise DataError(problems)
    return sheet, sheet.stack(PLACES), _unit(sheet, sheet.stack(NORMALS)) if normals else None


def _unit(sheet: Sheet, normals: Array) -> Array:
    """Return the normals (n, 3), after checking that their length is 1 within a hundredth, as in every other file."""
    size = np.linalg.norm(normals, axis=1)
    problems = [
        f"{sheet.at(int(i))}: nx ny nz has the length {size[i]:.4g}; give a unit vector"
        for i in np.flatnonzero(~(np.abs(size - 1.0) <= 0.01))
    ]
    if problems:
        raise DataError(problems)
    return normals


def row_of(sheet: Sheet, message: str) -> str:
    """Return the file and line of the point that a message names."""
    match = re.search(r"\bpoint (\d+)\b", message)
    row = int(match[1]) - 1 if match else -1
    return sheet.at(row) if 0 <= row < len(sheet.lines) else sheet.head


class FormTable(Table):
    """Half the peak to valley, and what is known of the shape: lobes on round features, their phase."""

    lobes: int | None = Field(default=None, ge=1, examples=["3"])
    amplitude: Deviation
    phase: Angle | None = None


class FeatureTable(Table):
    type: Literal["point", "line", "plane", "circle", "sphere", "cylinder", "cone", "torus", "mesh", "points"]


class PointTable(FeatureTable):
    point: Point
    normal: Direction


class LineTable(FeatureTable):
    point: Point
    direction: Direction
    length: Size
    normal: Direction | None = None


class PlaneTable(FeatureTable):
    point: Point
    normal: Direction
    size: TwoSizes
    u: Direction | None = None


class _Round(FeatureTable):
    point: Point
    diameter: Size
    inside: bool = False
    form: FormTable | None = None


class SphereTable(_Round):
    pass


class CircleTable(_Round):
    axis: Direction
    u: Direction | None = None


class CylinderTable(CircleTable):
    length: Size


class ConeTable(CylinderTable):
    angle: Angle


class TorusTable(FeatureTable):
    point: Point
    axis: Direction
    diameter: Size
    tube: Size
    inside: bool = False


class MeshTable(FeatureTable):
    pass


class PointsTable(FeatureTable):
    nominal: str = Field(examples=['"nominal.csv"'])


TABLES: dict[str, type[FeatureTable]] = {
    "point": PointTable, "line": LineTable, "plane": PlaneTable, "circle": CircleTable, "sphere": SphereTable,
    "cylinder": CylinderTable, "cone": ConeTable, "torus": TorusTable, "mesh": MeshTable,
    "points": PointsTable,
}  # fmt: skip


def read_feature(
    name: str, data: dict[str, Any], document: Document, at: Location
) -> tuple[Feature, Lobes | None]:
    """Read one table of [part.features]: the feature, and its stated form. UsageError, TableProblems: errors in it."""
    kind = data.get("type")
    if kind is None:
        raise UsageError(
            f'the feature "{name}" has no type.{misspelt("type", data)} Allowed: {", ".join(TABLES)}'
        )
    if not isinstance(kind, str) or kind not in TABLES:
        raise TableProblems(
            [("type", f'the feature "{name}" has the unknown type "{kind}".{choose_from(str(kind), TABLES)}')]
        )
    t: Any = read_model(TABLES[kind], data, document, at)
    if kind == "points":
        return _of_points(name, t.nominal, document), None
    form = getattr(t, "form", None)
    lobes = Lobes(form.lobes or 0, form.amplitude, form.phase) if form else None
    inside = getattr(t, "inside", False)
    point = np.array(getattr(t, "point", (0.0, 0.0, 0.0)))
    axis = np.array(
        next((getattr(t, k) for k in ("normal", "axis") if getattr(t, k, None) is not None), (0.0, 0.0, 0.0))
    )
    u = getattr(t, "u", None)
    sizes, extent = _numbers(kind, t)
    if kind == "line":
        axis, u = np.array(t.direction), t.normal
    return Feature(
        name=name,
        kind=kind,
        point=point,
        axis=axis,
        sizes=np.array(sizes),
        inside=inside,
        extent=extent,
        u=None if u is None else np.array(u),
    ), lobes


def _of_points(name: str, file: str, document: Document) -> Feature:
    """Return a surface of nominal points with normals, drawing frame."""
    sheet, points, normals = read_points(document.path.parent / file, with_normals=True)
    assert normals is not None
    try:
        nominal = NominalPoints(points, normals)
    except DataError as error:
        raise DataError([f"{row_of(sheet, text)}: {text}" for text in error.problems]) from None
    return Feature(name, "points", points.mean(axis=0), np.zeros(3), np.zeros(0), nominal=nominal)


def _numbers(kind: str, t: Any) -> tuple[list[float], tuple[float, ...]]:
    """Return (sizes, extent): radii and half angles from the diameters and full angles of a drawing."""
    if kind == "plane":
        return [], tuple(t.size)
    if kind == "line":
        return [], (t.length,)
    if kind in ("circle", "sphere"):
        return [t.diameter / 2], ()
    if kind == "cylinder":
        return [t.diameter / 2], (t.length,)
    if kind == "cone":
        return [t.diameter / 2, t.angle / 2], (t.length,)
    if kind == "torus":
        return [t.diameter / 2, t.tube / 2], ()
    return [], ()
