"""[part] tables: features, characteristics, expansion, mesh."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from vcmm.effects.expansion import PartExpansion
from vcmm.errors import UsageError, choose_from
from vcmm.files.schema import Angle, Direction, Expansion, Length, Lengths, Point, Problems, Table, read_model
from vcmm.files.toml import Document, Location
from vcmm.form import Lobes
from vcmm.inputs import Input
from vcmm.laws import Normal
from vcmm.part import Characteristic, Feature, Part, load_mesh
from vcmm.units import quantity


class FormTable(Table):
    lobes: int
    amplitude: Length
    phase: Angle = 0.0


class FeatureTable(Table):
    type: Literal["point", "line", "plane", "circle", "sphere", "cylinder", "cone", "torus", "mesh"]


class PointTable(FeatureTable):
    point: Point
    normal: Direction


class LineTable(FeatureTable):
    point: Point
    direction: Direction
    length: Length
    normal: Direction | None = None


class PlaneTable(FeatureTable):
    point: Point
    normal: Direction
    size: Lengths
    u: Direction | None = None


class _Round(FeatureTable):
    point: Point
    diameter: Length
    inside: bool = False
    form: FormTable | None = None


class SphereTable(_Round):
    pass


class CircleTable(_Round):
    axis: Direction
    u: Direction | None = None


class CylinderTable(CircleTable):
    length: Length


class ConeTable(CylinderTable):
    angle: Angle


class TorusTable(FeatureTable):
    point: Point
    axis: Direction
    diameter: Length
    tube: Length
    inside: bool = False


class MeshTable(FeatureTable):
    pass


TABLES: dict[str, type[FeatureTable]] = {
    "point": PointTable, "line": LineTable, "plane": PlaneTable, "circle": CircleTable, "sphere": SphereTable,
    "cylinder": CylinderTable, "cone": ConeTable, "torus": TorusTable, "mesh": MeshTable,
}  # fmt: skip


class CharacteristicTable(Table):
    name: str
    type: str
    of: str | list[str] = []
    between: list[str] = []
    datums: list[str] = []
    criterion: str = "GG"
    limits: list[str] | None = None
    zone: str | None = None


class PartFile(Table):
    """part/1"""

    name: str = ""
    expansion: Expansion = 0.0
    u_expansion: Expansion = 0.0
    mesh: str | None = None
    features: dict[str, dict[str, Any]] = {}
    characteristics: list[CharacteristicTable] = []


@dataclass(frozen=True, eq=False)
class PartData:
    """A part, the forms of its features, and what is known of its expansion."""

    part: Part
    forms: dict[str, Lobes]
    u_expansion: float

    def effects(self, compensated: bool) -> list[PartExpansion]:
        alpha = self.part.expansion
        return [PartExpansion(alpha, alpha if compensated else 0.0)] if alpha or self.u_expansion else []

    def inputs(self) -> list[Input]:
        if not self.u_expansion:
            return []
        return [
            Input("part_expansion", "", "alpha", Normal(self.u_expansion), "machine", "expansion of the part")
        ]


def part_from(document: Document, data: dict[str, Any], at: Location, problems: Problems) -> PartData | None:
    """A [part] table to PartData; what is wrong is added to `problems`."""
    model = problems.attempt(at, lambda: read_model(PartFile, data, document, at))
    if model is None:
        return None
    features: dict[str, Feature] = {}
    forms: dict[str, Lobes] = {}
    for name, table in model.features.items():
        here = (*at, "features", name)
        built = problems.attempt(here, lambda n=name, t=table, h=here: _feature(n, t, document, h))
        if built is not None:
            features[name] = built[0]
            forms |= {name: built[1]} if built[1] is not None else {}
    characteristics = []
    for i, item in enumerate(model.characteristics):
        c = problems.attempt((*at, "characteristics", i), lambda item=item: _characteristic(item))
        characteristics += [c] if c is not None else []
    if len(features) < len(model.features) or len(characteristics) < len(model.characteristics):
        return None  # unknown names would only repeat what is already reported
    mesh = (
        problems.attempt((*at, "mesh"), lambda: load_mesh(_beside(document, model.mesh)))
        if model.mesh
        else None
    )
    part = problems.attempt(at, lambda: Part(features, tuple(characteristics), model.expansion, mesh))
    return PartData(part, forms, model.u_expansion) if part is not None else None


def _beside(document: Document, name: str) -> Path:
    return document.path.parent / name


def _feature(
    name: str, data: dict[str, Any], document: Document, at: Location
) -> tuple[Feature, Lobes | None]:
    kind = data.get("type")
    if kind not in TABLES:
        word = "has no type" if kind is None else f'has the unknown type "{kind}"'
        raise UsageError(f'feature "{name}" {word}.{choose_from(str(kind), TABLES)}')
    t: Any = read_model(TABLES[kind], data, document, at)
    form = getattr(t, "form", None)
    lobes = Lobes(form.lobes, form.amplitude, form.phase) if form else None
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
        name, kind, point, axis, np.array(sizes), inside, extent, None if u is None else np.array(u)
    ), lobes


def _numbers(kind: str, t: Any) -> tuple[list[float], tuple[float, ...]]:
    """(sizes, extent): radii and half angles from the diameters and full angles of a drawing."""
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


def _characteristic(t: CharacteristicTable) -> Characteristic:
    dimension = "angle" if t.type == "angle" else "length"
    limits = None
    if t.limits is not None:
        if len(t.limits) != 2:
            raise UsageError(
                f'"{t.name}": limits take two values from nominal, for example limits = ["0 mm", "0.021 mm"]'
            )
        limits = (quantity(t.limits[0], dimension, "limits"), quantity(t.limits[1], dimension, "limits"))
    zone = None if t.zone is None else quantity(t.zone, "length", "zone")
    of = (t.of,) if isinstance(t.of, str) else tuple(t.of)
    return Characteristic(t.name, t.type, of, tuple(t.between), tuple(t.datums), t.criterion, limits, zone)
