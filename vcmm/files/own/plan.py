"""Read [plan] tables: styli, steps with strategies or point files, touch, alignment."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields
from dataclasses import Field as DataField
from typing import Any

import numpy as np
from pydantic import Field

from vcmm.core.errors import DataError, UsageError, choose_from
from vcmm.core.run import Array
from vcmm.core.units import quantity, shorten, vector
from vcmm.files.own.features import read_points, row_of
from vcmm.files.own.knowledge import names_in
from vcmm.files.problems import Key, Problems, TableProblems, bad_name, misspelt
from vcmm.files.schema import Direction, Distance, Point, Size, Speed, Spread, Table, checked_model, is_number
from vcmm.files.toml import Document, Location
from vcmm.part.alignment import Alignment
from vcmm.part.part import Feature, Part
from vcmm.task.measuring.explicit import on_surface
from vcmm.task.measuring.plan import Plan, Step, Stylus, Touch
from vcmm.task.measuring.qualification import Qualification
from vcmm.task.measuring.strategies import choose, plan_points

POINTS = {  # per kind of feature what a step may say; numbers are those of a feature of 20 mm and more
    "point": '{ strategy = "nominal" }', "points": '{ strategy = "nominal" }', "line": '{ strategy = "even", n = 5 }',
    "plane": '{ strategy = "grid", n = [3, 3], margin = "5 mm" }', "circle": '{ strategy = "even", n = 12 }',
    "sphere": '{ strategy = "iso10360" }', "cylinder": '{ strategy = "levels", at = ["5 mm", "15 mm"], n = 12 }',
    "cone": '{ strategy = "levels", at = ["5 mm", "15 mm"], n = 12 }', "torus": '{ strategy = "grid", n = [8, 8] }', "mesh": '"points.csv"',
}  # fmt: skip


class QualificationTable(Table):
    sphere_diameter: Size = 25.0
    u_diameter: Spread = 0.0
    form: Spread = 0.0


class StylusTable(Table):
    offset: Point
    tip_diameter: Size
    length: Size | None = None
    event: str = ""
    qualification: QualificationTable | None = None


class TouchTable(Table):
    speed: Speed = 5.0
    approach: Distance = 3.0
    clearance: Distance = 20.0
    positioning: Speed = 100.0


class StepTable(Table):
    feature: str = Field(examples=['"top"'])
    stylus: str = Field(examples=['"down"'])
    points: str | dict[str, Any] | None = Field(
        default=None, examples=['{ strategy = "grid", n = [3, 3], margin = "5 mm" }']
    )
    approach: Direction | None = None


class AlignmentTable(Table):
    plane: str = Field(examples=['"top"'])
    line: str | list[str] = Field(default_factory=list, examples=['"front"'])
    origin: str | list[str] = Field(default_factory=list, examples=['"bore"'])

    def scheme(self) -> Alignment:
        line = self.line if isinstance(self.line, str) else tuple(self.line)
        return Alignment(
            self.plane, line, self.origin if isinstance(self.origin, str) else tuple(self.origin)
        )

    def names(self) -> list[tuple[str, str]]:
        """Return (role, feature) of every feature named."""
        out = []
        for role in ("plane", "line", "origin"):
            value = getattr(self, role)
            out += [(role, name) for name in ([value] if isinstance(value, str) else value)]
        return out


class PlanFile(Table):
    """plan/1"""

    alignment: AlignmentTable | None = None
    touch: TouchTable = Field(default_factory=TouchTable)
    styli: dict[str, StylusTable] = Field(
        default_factory=dict, examples=['{ down = { offset = "0 0 -120 mm", tip_diameter = "4 mm" } }']
    )
    steps: list[StepTable] = Field(default_factory=list)


def plan_from(
    document: Document, data: dict[str, Any], at: Location, part: Part | None, problems: Problems
) -> tuple[Plan, dict[str, Qualification]] | None:
    """Convert a [plan] table to a Plan and the qualifications of its styli; problems are added to `problems`.

    Without a part (because it is wrong itself) only what does not depend on it is checked.
    """
    before = len(problems.found)
    model = checked_model(PlanFile, data, problems, at)
    if model is None or part is None:
        return None
    steps = []
    if not part.features and model.steps:
        problems.add(
            (*at, "steps"), "the plan measures features, but the part has none; add them in [part.features]"
        )
        return None
    if not model.styli and len(problems.found) == before and model.steps:
        problems.add(
            at, 'the plan has no styli; add styli.down = { offset = "0 0 -120 mm", tip_diameter = "4 mm" }'
        )
    for name in model.styli:
        if bad := bad_name(name):
            problems.add((*at, "styli", name), f"the name of a stylus, {shorten(name)}, {bad}")
    styli_names = names_in(data, "styli") or None
    for i, table in enumerate(model.steps):
        here = (*at, "steps", i)
        step = problems.attempt(here, lambda t=table: _step(document, t, part, styli_names))  # type: ignore[misc]
        steps += [step] if step is not None else []
    if len(problems.found) == before:
        _check_plan(model, list(dict.fromkeys(t.feature for t in model.steps)), part, problems, at)
    if len(problems.found) > before:
        return None
    styli = {n: _stylus(n, t) for n, t in model.styli.items()}
    touch = Touch(model.touch.speed, model.touch.approach, model.touch.clearance, model.touch.positioning)
    scheme = model.alignment.scheme() if model.alignment else None
    plan = problems.attempt((*at, "steps"), lambda: Plan(tuple(steps), styli, touch, scheme))
    patterns = {
        n: Qualification(t.qualification.sphere_diameter, t.qualification.u_diameter, t.qualification.form)
        for n, t in model.styli.items()
        if t.qualification is not None
    }
    return (plan, patterns) if plan is not None else None


def _check_plan(model: PlanFile, measured: list[str], part: Part, problems: Problems, at: Location) -> None:
    """Check that every feature that a characteristic or the alignment needs is measured, each in one step."""
    if not measured:
        return  # the empty plan is reported once
    for role, name in model.alignment.names() if model.alignment else ():
        if name not in measured:
            problems.add(
                (*at, "alignment", role),
                f'the alignment names "{name}", which the plan does not measure.{choose_from(name, measured)}',
            )
    for c in part.characteristics:
        for name in c.features:
            if name not in measured:
                problems.add(
                    (*at, "steps"),
                    f'the characteristic "{c.name}" needs the feature "{name}", which no step of the plan measures; '
                    "add a [[plan.steps]] for it",
                )


def _stylus(name: str, t: StylusTable) -> Stylus:
    offset = np.array(t.offset)
    length = float(np.linalg.norm(offset)) if t.length is None else t.length
    return Stylus(name, offset, t.tip_diameter / 2, length, t.event)


def _step(document: Document, t: StepTable, part: Part, styli: list[str] | None) -> Step:
    problems: list[tuple[Key, str]] = []
    if t.feature not in part.features:
        problems.append(("feature", f'unknown feature "{t.feature}".{choose_from(t.feature, part.features)}'))
    if styli is not None and t.stylus not in styli:
        problems.append(("stylus", f'unknown stylus "{t.stylus}".{choose_from(t.stylus, styli)}'))
    if problems:
        raise TableProblems(problems)
    feature = part.features[t.feature]
    try:
        if t.points is None and feature.kind != "point":
            raise TableProblems(
                [
                    (
                        "",
                        f'the key "points" is missing; write for example points = {POINTS[feature.kind]}, or name a file of the points',
                    )
                ]
            )
        if isinstance(t.points, str):
            points, normals = _from_file(document, t.points, feature, part)
        else:
            points, normals = plan_points(feature, _pattern(feature, t.points or {"strategy": "nominal"}))
    except TableProblems:
        raise
    except DataError as error:
        raise TableProblems([("points", text) for text in error.problems]) from None
    except UsageError as error:
        raise TableProblems([("points", str(error))]) from None
    approach = None
    if t.approach is not None:
        direction = np.array(t.approach) / np.linalg.norm(t.approach)
        approach = np.tile(direction, (len(points), 1))
    return Step(t.feature, t.stylus, points, normals, approach)


def _pattern(feature: Feature, table: Mapping[str, Any]) -> Any:
    """Convert points = { strategy = "levels", at = ["5 mm"], n = 8 } to the pattern's dataclass; units by its metadata."""
    if "strategy" not in table:
        raise UsageError(
            f"points has no strategy.{misspelt('strategy', table)} Write for example points = {POINTS[feature.kind]}"
        )
    kind = choose(feature.kind, str(table["strategy"]))
    keys = {f.name: f for f in fields(kind)}
    values: dict[str, Any] = {}
    problems: list[tuple[Key, str]] = []
    for key, value in table.items():
        if key == "strategy":
            continue
        if key not in keys:
            text = (
                f'unknown key "{key}" of strategy {table["strategy"]}.{choose_from(key, ["strategy", *keys])}'
            )
            problems.append((("points", key), text))
            continue
        try:
            values[key] = _pattern_value(keys[key], key, value)
        except UsageError as error:
            problems.append((("points", key), str(error)))
    if problems:
        raise TableProblems(problems)
    missing = [n for n, f in keys.items() if n not in values and f.default is MISSING]
    if missing:
        raise UsageError(
            f"strategy {table['strategy']} of a {feature.kind} lacks {' and '.join(missing)}; "
            f"its keys are {', '.join(keys)}"
        )
    return kind(**values)


def _pattern_value(spec: DataField[Any], key: str, value: Any) -> Any:
    """Return a value of a strategy: with a unit, a count, a list of counts, a direction, or true and false."""
    dimension, kind = spec.metadata.get("dimension"), str(spec.type)
    if dimension is not None:
        example = "5 mm" if dimension == "length" else "30 deg"
        if "tuple" in kind:
            return vector(value, dimension, key, example)
        return quantity(value, dimension, key, example)
    if kind.startswith("tuple[int"):
        return _counts(key, value, kind.count("int"))
    if kind.startswith("tuple[float"):
        if not isinstance(value, list) or len(value) != 3 or not all(is_number(v) for v in value):
            raise UsageError(
                f"{key} = {shorten(value)} must be three plain numbers; write for example {key} = [0, 0, 1]"
            )
        return tuple(float(v) for v in value)
    if kind == "bool":
        if not isinstance(value, bool):
            raise UsageError(f"{key} = {shorten(value)} must be true or false")
        return value
    if kind == "float":
        if not is_number(value):
            raise UsageError(
                f"{key} = {shorten(value)} must be a plain number; write for example {key} = 2.5"
            )
        return float(value)
    return _counts(key, [value], 1)[0]


def _counts(key: str, value: Any, how_many: int) -> tuple[int, ...]:
    whole = isinstance(value, list) and all(isinstance(v, int) and not isinstance(v, bool) for v in value)
    if not whole or len(value) != how_many or min(value) < 1:
        example = f"{key} = 8" if how_many == 1 else f"{key} = [{', '.join(['3'] * how_many)}]"
        given = value[0] if how_many == 1 and isinstance(value, list) and len(value) == 1 else value
        due = "a whole number" if how_many == 1 else f"{how_many} whole numbers"
        raise UsageError(f"{key} = {shorten(given)} must be {due}, 1 or more; write for example {example}")
    return tuple(value)


def _from_file(document: Document, name: str, feature: Feature, part: Part) -> tuple[Array, Array]:
    """Read a CSV with x_mm y_mm z_mm and optionally nx ny nz, drawing frame."""
    sheet, points, normals = read_points(document.path.parent / name)
    try:
        return on_surface(feature, points, normals, mesh=part.mesh)
    except UsageError as error:
        raise DataError(f"{row_of(sheet, str(error))}: {error}") from None
