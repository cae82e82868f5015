"""Read [part] tables: features, characteristics, expansion, mesh."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import Field

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.core.units import quantity, shorten
from vcmm.files.own.drawing import (
    GeneralTolerances,
    compared_with_itself,
    general_from,
    general_of,
    note_contradictions,
    reciprocal,
    size_limits,
    stated_filter,
    stated_limits,
)
from vcmm.files.own.features import read_feature
from vcmm.files.own.knowledge import names_in
from vcmm.files.problems import Problems, TableProblems, bad_name
from vcmm.files.schema import (
    Angle,
    Deviation,
    Expansion,
    ExpansionSpread,
    Limits,
    Mass,
    Table,
    checked_model,
    is_complete,
)
from vcmm.files.toml import Document, Location
from vcmm.part.form import Lobes
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import TYPES, Characteristic, Feature, Part, load_mesh, members
from vcmm.physics.structure.expansion import PartExpansion


class CharacteristicTable(Table):
    name: str = Field(examples=['"bore diameter"'])
    type: str = Field(examples=['"size"'])
    of: str | list[str] = Field(default_factory=list, examples=['"bore"'])
    between: list[str] = Field(default_factory=list, examples=['["front", "bore"]'])
    datums: list[str | list[str]] = Field(default_factory=list, examples=['["top"]'])
    criterion: str = Field(default="GG", examples=['"GX"'])
    datum_criterion: str = Field(default="G", examples=['"X"'])
    limits: Limits | str | None = Field(default=None, examples=['["0 mm", "0.021 mm"]', '"H7"'])
    zone: str | None = Field(default=None, examples=['"0.01 mm"'])
    material: str = Field(default="", examples=['"M"'])
    reciprocity: bool = False
    projected: str | None = Field(default=None, examples=['"20 mm"'])
    zones: str = Field(default="CZ", examples=['"CZ"'])
    filter: str = Field(default="", examples=['"gaussian"'])
    upr: float | None = Field(default=None, gt=0, allow_inf_nan=False, examples=["50"])
    cutoff: str | None = Field(default=None, examples=['"0.8 mm"'])


class GeneralTable(Table):
    standard: str = Field(default="ISO 22081", examples=['"ISO 22081"'])
    size: Deviation | None = None
    angle: Angle | None = None
    profile: Deviation | None = None


class PartFile(Table):
    """part/1"""

    name: str = ""
    expansion: Expansion = 0.0
    u_expansion: ExpansionSpread = 0.0
    mass: Mass = 0.0
    mesh: str | None = Field(default=None, examples=['"part.stl"'])
    general_tolerances: str | GeneralTable | None = Field(default=None, examples=['"ISO 2768-mK"'])
    features: dict[str, dict[str, Any]] = Field(
        default_factory=dict,
        examples=['{ top = { type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], size = "80 80 mm" } }'],
    )
    characteristics: list[CharacteristicTable] = Field(default_factory=list)


@dataclass(frozen=True, eq=False)
class PartData:
    """A part, the forms of its features, and the uncertainty of its expansion."""

    part: Part
    forms: dict[str, Lobes]
    u_expansion: float

    def effects(self, compensated: bool) -> list[Effect]:
        alpha = self.part.expansion
        if not alpha and not self.u_expansion:
            return []
        return [PartExpansion(alpha, alpha if compensated else 0.0)]

    def inputs(self) -> list[Input]:
        if not self.u_expansion:
            return []
        return [
            Input(
                PartExpansion.name, "", "alpha", Normal(self.u_expansion), "machine", "expansion of the part"
            )
        ]


def part_from(document: Document, data: dict[str, Any], at: Location, problems: Problems) -> PartData | None:
    """Convert a [part] table to PartData; problems are added to `problems`."""
    before = len(problems.found)
    model = checked_model(PartFile, data, problems, at)
    tables = model.features if model else {}
    features: dict[str, Feature] = {}
    forms: dict[str, Lobes] = {}
    for name, table in tables.items():
        here = (*at, "features", name)
        if bad := bad_name(name):
            problems.add(here, f"the name of a feature, {shorten(name)}, {bad}")
        built = problems.attempt(here, lambda n=name, t=table, h=here: read_feature(n, t, document, h))  # type: ignore[misc]
        if built is not None:
            features[name] = built[0]
            forms |= {name: built[1]} if built[1] is not None else {}
    characteristics: list[Characteristic] = []
    general = problems.attempt(
        (*at, "general_tolerances"), lambda: general_from(model and model.general_tolerances)
    )
    drawing = _Drawing(features, model.characteristics if model else [], general or GeneralTolerances())
    for i, item in enumerate(model.characteristics if model else ()):
        if not is_complete(item, data["characteristics"][i]):
            continue
        here = (*at, "characteristics", i)
        c = problems.attempt(here, lambda item=item: _characteristic(item, drawing))  # type: ignore[misc]
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
        problems.attempt((*at, "characteristics", i), lambda c=c: _checked_limits(c, features))  # type: ignore[misc]
    note_contradictions(characteristics, features, problems, at)
    return PartData(part, forms, model.u_expansion)


ABSOLUTE_LIMIT_SHARE = 0.5  # of the nominal value: limits that both lie within this of it are absolute ones
ONE_LIMIT_SHARE, LEAST_SIZE_MM = 0.05, 1.0  # the same for one limit alone, of sizes from 1 mm on


def _checked_limits(c: Characteristic, features: dict[str, Feature]) -> None:
    """Raise UsageError for a characteristic that cannot be evaluated, and for limits that hold the nominal value itself."""
    nominal = gps.nominal(c, features)
    if c.limits is not None and not nominal + c.limits[0] < nominal + c.limits[1]:
        text = f"the limits of {nominal:g} are one number to 16 digits; enlarge the tolerance"
        raise TableProblems([("limits", text)])
    if c.limits is None or nominal <= 0:
        return
    off = [abs(end - nominal) / nominal for end in c.limits]
    if max(off) >= ABSOLUTE_LIMIT_SHARE and not (
        gps.unit(c) == "mm" and nominal >= LEAST_SIZE_MM and min(off) < ONE_LIMIT_SHARE
    ):
        return
    scale, unit = (1.0, "mm") if gps.unit(c) == "mm" else (180.0 / math.pi, "deg")
    ends = [end - nominal if share < ABSOLUTE_LIMIT_SHARE else end for end, share in zip(c.limits, off)]
    right = ", ".join(f'"{end * scale:.6g} {unit}"' for end in ends)
    remark = f'"{c.name}": limits count from the nominal value ({nominal * scale:.6g} {unit}); '
    enough = f"{c.limits[0] * scale:.6g} and {c.limits[1] * scale:.6g} {unit} hold it already; write limits = [{right}]"
    raise TableProblems([("limits", remark + enough)])


def _check_names(
    c: Characteristic,
    features: list[str] | None,
    before: list[Characteristic],
    problems: Problems,
    at: Location,
) -> None:
    """Check that a characteristic names features that exist, and has a name of its own."""
    if bad := bad_name(c.name):
        problems.add((*at, "name"), f"name = {shorten(c.name)} {bad}")
    for role in ("of", "between", "datums"):
        for name in (m for n in getattr(c, role) for m in members(c, n)):
            if features is not None and name not in features:
                problems.add(
                    (*at, role),
                    f'the characteristic "{c.name}" names the unknown feature "{name}".{choose_from(name, features)}',
                )
    if any(other.name == c.name for other in before):
        problems.add((*at, "name"), f'two characteristics are named "{c.name}"; rename one')


def _beside(document: Document, name: str) -> Path:
    return document.path.parent / name


@dataclass(frozen=True, eq=False)
class _Drawing:
    """Data to which characteristics refer: features, the tables of all of them, general tolerances."""

    features: dict[str, Feature]
    tables: list[CharacteristicTable]
    general: GeneralTolerances

    def own_limits(self, t: CharacteristicTable) -> tuple[float, float] | None:
        """Return stated limits, else general ones."""
        limits = stated_limits(t, self.features)
        if limits is None and t.zone is None:
            limits = general_of(t, self.features, self.general)[0]
        return limits

    def limits(self, t: CharacteristicTable) -> tuple[float, float] | None:
        """Return the limits with the addition of reciprocity."""
        limits = self.own_limits(t)
        return reciprocal(t, self.tables, self.features, limits) if limits and t.type == "size" else limits


def _characteristic(t: CharacteristicTable, drawing: _Drawing) -> Characteristic:
    problems: list[tuple[str, str]] = []
    if t.type not in TYPES:
        problems.append(("type", f'unknown characteristic type "{t.type}".{choose_from(t.type, TYPES)}'))
    if t.reciprocity and not t.material:
        problems.append(("reciprocity", 'reciprocity goes with material = "M" or "L"'))

    def read(key: str, make: Any) -> Any:
        try:
            return make()
        except UsageError as error:
            problems.append((key, str(error)))
            return None

    limits = read("limits", lambda: drawing.limits(t)) if not problems else None
    zone = read("zone", lambda: None if t.zone is None else quantity(t.zone, "length", "zone", "0.01 mm"))
    if t.limits is None and t.zone is None and not problems:
        zone = read("zone", lambda: general_of(t, drawing.features, drawing.general)[1])
    along = read("projected", lambda: t.projected and quantity(t.projected, "length", "projected", "20 mm"))
    sizes = read("material", lambda: size_limits(t, drawing.tables, drawing.features, drawing.own_limits))
    kept = read("filter", lambda: stated_filter(t))
    problems += compared_with_itself(t)
    if problems:
        raise TableProblems(problems)
    return Characteristic(
        name=t.name, type=t.type, of=(t.of,) if isinstance(t.of, str) else tuple(t.of), between=tuple(t.between),
        datums=tuple(d if isinstance(d, str) else tuple(d) for d in t.datums),  # type: ignore[misc]
        criterion=t.criterion, limits=limits, zone=zone, datum_criterion=t.datum_criterion,
        projected=along or None, zones=t.zones, material=t.material, size_limits=sizes,
        filter=kept,
    )  # fmt: skip
