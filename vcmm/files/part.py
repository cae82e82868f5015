"""[part] tables: features, characteristics, expansion, mesh."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.core.units import quantity, shown
from vcmm.effects import made_for
from vcmm.files.knowledge import names_in
from vcmm.files.problems import Problems, TableProblems, bad_name, misspelt
from vcmm.files.schema import (
    Angle,
    Deviation,
    Direction,
    Expansion,
    ExpansionSpread,
    Limits,
    Mass,
    Point,
    Size,
    Table,
    TwoSizes,
    checked_model,
    read_model,
    whole,
)
from vcmm.files.toml import Document, Location
from vcmm.gps import characteristics as gps
from vcmm.part.form import Lobes
from vcmm.part.part import TYPES, Characteristic, Feature, Part, load_mesh


class FormTable(Table):
    lobes: int = Field(ge=1, examples=["3"])
    amplitude: Deviation
    phase: Angle = 0.0


class FeatureTable(Table):
    type: Literal["point", "line", "plane", "circle", "sphere", "cylinder", "cone", "torus", "mesh"]


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


TABLES: dict[str, type[FeatureTable]] = {
    "point": PointTable, "line": LineTable, "plane": PlaneTable, "circle": CircleTable, "sphere": SphereTable,
    "cylinder": CylinderTable, "cone": ConeTable, "torus": TorusTable, "mesh": MeshTable,
}  # fmt: skip


class CharacteristicTable(Table):
    name: str = Field(examples=['"bore diameter"'])
    type: str = Field(examples=['"size"'])
    of: str | list[str] = Field(default_factory=list, examples=['"bore"'])
    between: list[str] = Field(default_factory=list, examples=['["front", "bore"]'])
    datums: list[str] = Field(default_factory=list, examples=['["top"]'])
    criterion: str = Field(default="GG", examples=['"GX"'])
    datum_criterion: str = Field(default="G", examples=['"X"'])
    limits: Limits | None = None
    zone: str | None = Field(default=None, examples=['"0.01 mm"'])


class PartFile(Table):
    """part/1"""

    name: str = ""
    expansion: Expansion = 0.0
    u_expansion: ExpansionSpread = 0.0
    mass: Mass = 0.0
    mesh: str | None = Field(default=None, examples=['"part.stl"'])
    features: dict[str, dict[str, Any]] = Field(
        default_factory=dict,
        examples=['{ top = { type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], size = "80 80 mm" } }'],
    )
    characteristics: list[CharacteristicTable] = Field(default_factory=list)


@dataclass(frozen=True, eq=False)
class PartData:
    """A part, the forms of its features, and what is known of its expansion."""

    part: Part
    forms: dict[str, Lobes]
    u_expansion: float

    def effects(self, compensated: bool) -> list[Effect]:
        alpha = self.part.expansion
        if not alpha and not self.u_expansion:
            return []
        return [self._kind(alpha, alpha if compensated else 0.0)]

    @property
    def _kind(self) -> Any:
        return made_for("part temperature", "[part] expansion")

    def inputs(self) -> list[Input]:
        if not self.u_expansion:
            return []
        return [
            Input(self._kind.name, "", "alpha", Normal(self.u_expansion), "machine", "expansion of the part")
        ]


def part_from(document: Document, data: dict[str, Any], at: Location, problems: Problems) -> PartData | None:
    """A [part] table to PartData; what is wrong is added to `problems`."""
    before = len(problems.found)
    model = checked_model(PartFile, data, problems, at)
    tables = model.features if model else {}
    features: dict[str, Feature] = {}
    forms: dict[str, Lobes] = {}
    for name, table in tables.items():
        here = (*at, "features", name)
        if bad := bad_name(name):
            problems.add(here, f"the name of a feature, {shown(name)}, {bad}")
        built = problems.attempt(here, lambda n=name, t=table, h=here: _feature(n, t, document, h))  # type: ignore[misc]
        if built is not None:
            features[name] = built[0]
            forms |= {name: built[1]} if built[1] is not None else {}
    characteristics: list[Characteristic] = []
    for i, item in enumerate(model.characteristics if model else ()):
        if not whole(item, data["characteristics"][i]):
            continue
        here = (*at, "characteristics", i)
        c = problems.attempt(here, lambda item=item: _characteristic(item))  # type: ignore[misc]
        if c is not None:
            _check_names(c, names_in(data, "features") or None, characteristics, problems, here)
            characteristics.append(c)
    if model is not None and model.characteristics and not model.features and len(problems.found) == before:
        problems.add(at, "the part has characteristics and no features; add them in [part.features]")
    if model is None or len(problems.found) > before:
        return None
    mesh = None
    if model.mesh:
        mesh = problems.attempt((*at, "mesh"), lambda: load_mesh(_beside(document, str(model.mesh))))
    part = problems.attempt(
        at, lambda: Part(features, tuple(characteristics), model.expansion, mesh, model.mass)
    )
    if part is None:
        return None
    for i, c in enumerate(characteristics):
        problems.attempt((*at, "characteristics", i), lambda c=c: _check_limits(c, features))  # type: ignore[misc]
    return PartData(part, forms, model.u_expansion)


def _check_limits(c: Characteristic, features: dict[str, Feature]) -> None:
    """The limits about the nominal value are two different numbers."""
    nominal = gps.nominal(c, features)
    if c.limits is not None and not nominal + c.limits[0] < nominal + c.limits[1]:
        text = f"the limits of {nominal:g} are one number to 16 digits; enlarge the tolerance"
        raise TableProblems([("limits", text)])


def _check_names(
    c: Characteristic,
    features: list[str] | None,
    before: list[Characteristic],
    problems: Problems,
    at: Location,
) -> None:
    """A characteristic names features that exist, and has a name of its own."""
    if bad := bad_name(c.name):
        problems.add((*at, "name"), f"name = {shown(c.name)} {bad}")
    for role in ("of", "between", "datums"):
        for name in getattr(c, role):
            if features is not None and name not in features:
                problems.add(
                    (*at, role),
                    f'the characteristic "{c.name}" names the unknown feature "{name}".{choose_from(name, features)}',
                )
    if any(other.name == c.name for other in before):
        problems.add((*at, "name"), f'two characteristics are named "{c.name}"; rename one')


def _beside(document: Document, name: str) -> Path:
    return document.path.parent / name


def _feature(
    name: str, data: dict[str, Any], document: Document, at: Location
) -> tuple[Feature, Lobes | None]:
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
        name=name,
        kind=kind,
        point=point,
        axis=axis,
        sizes=np.array(sizes),
        inside=inside,
        extent=extent,
        u=None if u is None else np.array(u),
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
    found: list[tuple[str, str]] = []
    if t.type not in TYPES:
        found.append(("type", f'unknown characteristic type "{t.type}".{choose_from(t.type, TYPES)}'))
    angle, limits, zone = t.type == "angle", None, None
    dimension, example = ("angle", "0.1 deg") if angle else ("length", "0.021 mm")
    try:
        if t.limits is not None:
            low, high = (quantity(v, dimension, "limits", example) for v in t.limits)
            limits = (low, high)
            if not low < high:
                raise UsageError(
                    f"limits = {shown(t.limits)}: the lower limit is not below the upper one; exchange them"
                )
    except UsageError as error:
        found.append(("limits", str(error)))
    try:
        zone = None if t.zone is None else quantity(t.zone, "length", "zone", "0.01 mm")
    except UsageError as error:
        found.append(("zone", str(error)))
    if found:
        raise TableProblems(found)
    of = (t.of,) if isinstance(t.of, str) else tuple(t.of)
    return Characteristic(
        name=t.name,
        type=t.type,
        of=of,
        between=tuple(t.between),
        datums=tuple(t.datums),
        criterion=t.criterion,
        limits=limits,
        zone=zone,
        datum_criterion=t.datum_criterion,
    )
