"""[plan] tables: styli, steps with strategies or point files, touch, alignment."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np
from pydantic import Field

from vcmm.alignment import Alignment
from vcmm.errors import DataError, UsageError, choose_from
from vcmm.files.columns import read_csv
from vcmm.files.schema import Direction, Length, Point, Problems, Speed, Table, read_model
from vcmm.files.toml import Document, Location
from vcmm.part import Feature, Part
from vcmm.plan import Plan, Step, Stylus, Touch
from vcmm.qualification import Qualification
from vcmm.run import Array
from vcmm.strategies import choose, on_surface, plan_points
from vcmm.units import quantity, vector


class QualificationTable(Table):
    sphere_diameter: Length = 25.0
    u_diameter: Length = 0.0
    form: Length = 0.0


class StylusTable(Table):
    offset: Point
    tip_diameter: Length
    length: Length | None = None
    event: str = ""
    qualification: QualificationTable | None = None


class TouchTable(Table):
    speed: Speed = 5.0
    approach: Length = 3.0
    clearance: Length = 20.0
    positioning: Speed = 100.0


class StepTable(Table):
    feature: str
    stylus: str
    points: str | dict[str, Any]
    approach: Direction | None = None


class AlignmentTable(Table):
    plane: str
    line: str | list[str] = []
    origin: str | list[str] = []

    def scheme(self) -> Alignment:
        line = self.line if isinstance(self.line, str) else tuple(self.line)
        return Alignment(
            self.plane, line, self.origin if isinstance(self.origin, str) else tuple(self.origin)
        )

    def names(self) -> list[str]:
        several = [[self.plane], *([x] if isinstance(x, str) else x for x in (self.line, self.origin))]
        return [name for names in several for name in names]


class PlanFile(Table):
    """plan/1"""

    alignment: AlignmentTable | None = None
    touch: TouchTable = Field(default_factory=TouchTable)
    styli: dict[str, StylusTable] = {}
    steps: list[StepTable] = []


def plan_from(
    document: Document, data: dict[str, Any], at: Location, part: Part | None, problems: Problems
) -> tuple[Plan, dict[str, Qualification]] | None:
    """A [plan] table to a Plan and the qualifications of its styli; what is wrong is added to `problems`."""
    model = problems.attempt(at, lambda: read_model(PlanFile, data, document, at))
    if model is None or part is None:
        return None
    steps = []
    for i, table in enumerate(model.steps):
        step = problems.attempt((*at, "steps", i), lambda t=table: _step(document, t, part, model.styli))
        steps += [step] if step is not None else []
    if len(steps) < len(model.steps):
        return None
    styli = {n: _stylus(n, t) for n, t in model.styli.items()}
    touch = Touch(model.touch.speed, model.touch.approach, model.touch.clearance, model.touch.positioning)
    plan = problems.attempt((*at, "steps"), lambda: _checked(tuple(steps), styli, touch, model, part))
    known = {
        n: Qualification(t.qualification.sphere_diameter, t.qualification.u_diameter, t.qualification.form)
        for n, t in model.styli.items()
        if t.qualification is not None
    }
    return (plan, known) if plan is not None else None


def _checked(
    steps: tuple[Step, ...], styli: dict[str, Stylus], touch: Touch, model: PlanFile, part: Part
) -> Plan:
    measured = {s.feature for s in steps}
    for c in part.characteristics if steps else ():
        for name in (*c.of, *c.between, *c.datums):
            if name not in measured:
                raise UsageError(
                    f'characteristic "{c.name}" needs the feature "{name}", which no step of the plan measures; add a [[plan.steps]] for it'
                )
    for name in model.alignment.names() if model.alignment else ():
        if name not in measured:
            raise UsageError(
                f'the alignment names "{name}", which the plan does not measure.{choose_from(name, sorted(measured))}'
            )
    return Plan(steps, styli, touch, model.alignment.scheme() if model.alignment else None)


def _stylus(name: str, t: StylusTable) -> Stylus:
    offset = np.array(t.offset)
    length = float(np.linalg.norm(offset)) if t.length is None else t.length
    return Stylus(name, offset, t.tip_diameter / 2, length, t.event)


def _step(document: Document, t: StepTable, part: Part, styli: dict[str, StylusTable]) -> Step:
    if t.feature not in part.features:
        raise UsageError(
            f'the step measures the unknown feature "{t.feature}".{choose_from(t.feature, part.features)}'
        )
    if t.stylus not in styli:
        raise UsageError(
            f'the step on {t.feature} uses the unknown stylus "{t.stylus}".{choose_from(t.stylus, styli)}'
        )
    feature = part.features[t.feature]
    if isinstance(t.points, str):
        points, normals = _from_file(document, t.points, feature, part)
    else:
        points, normals = plan_points(feature, _pattern(feature, t.points))
    approach = None
    if t.approach is not None:
        direction = np.array(t.approach) / np.linalg.norm(t.approach)
        approach = np.tile(direction, (len(points), 1))
    return Step(t.feature, t.stylus, points, normals, approach)


def _pattern(feature: Feature, table: dict[str, Any]) -> Any:
    """points = { strategy = "levels", at = ["5 mm"], n = 8 } to the pattern's dataclass; units by its metadata."""
    if "strategy" not in table:
        raise UsageError(
            'points needs strategy, for example points = { strategy = "grid", n = [3, 3], margin = "5 mm" }'
        )
    kind = choose(feature.kind, str(table["strategy"]))
    known = {f.name: f for f in fields(kind)}
    values = {}
    for key, value in table.items():
        if key == "strategy":
            continue
        if key not in known:
            raise UsageError(f'unknown key "{key}" of strategy {table["strategy"]}.{choose_from(key, known)}')
        dimension = known[key].metadata.get("dimension")
        if dimension is None:
            values[key] = tuple(value) if isinstance(value, list) else value
        elif isinstance(value, list) or "tuple" in str(known[key].type):
            values[key] = vector(value, dimension, key)
        else:
            values[key] = quantity(value, dimension, key)
    try:
        return kind(**values)
    except TypeError as error:
        missing = str(error).split(":")[-1].strip()
        raise UsageError(
            f"strategy {table['strategy']} of a {feature.kind} lacks {missing}; keys: {', '.join(known)}"
        ) from None


def _from_file(document: Document, name: str, feature: Feature, part: Part) -> tuple[Array, Array]:
    """CSV with x_mm y_mm z_mm and optionally nx ny nz, drawing frame."""
    path = document.path.parent / name
    header, rows = read_csv(path)
    wanted = ["x_mm", "y_mm", "z_mm"]
    for column in wanted:
        if column not in header:
            raise DataError(
                f"{path}:1: the column {column} is missing; the file needs x_mm,y_mm,z_mm and may have nx,ny,nz"
            )
    for column in header:
        if column not in (*wanted, "nx", "ny", "nz"):
            raise DataError(
                f'{path}:1: unknown column "{column}".{choose_from(column, [*wanted, "nx", "ny", "nz"])}'
            )
    points = _numbers(path, header, rows, wanted)
    normals = _numbers(path, header, rows, ["nx", "ny", "nz"]) if "nx" in header else None
    return on_surface(feature, points, normals, mesh=part.mesh)


def _numbers(path: Any, header: list[str], rows: list[list[str]], names: list[str]) -> Array:
    out = np.empty((len(rows), len(names)))
    for i, row in enumerate(rows):
        for j, name in enumerate(names):
            if name not in header:
                raise DataError(f"{path}:1: the column {name} is missing; give all of {', '.join(names)}")
            try:
                out[i, j] = float(row[header.index(name)])
            except ValueError:
                raise DataError(
                    f'{path}:{i + 2}: "{row[header.index(name)]}" in column {name} is not a number'
                ) from None
    return out
