"""Read [placement] of a scenario: poses that the fixture allows, and the goal of `vcmm place`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from pydantic import Field

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.units import quantity, shorten
from vcmm.files.problems import Problems
from vcmm.files.schema import Point, Table
from vcmm.files.toml import Document
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import Part
from vcmm.task.measuring.fixture import DOFS, DOWN, Fixture, Freedom, Goal, Placement

RANGE = '["100 mm", "500 mm"]'


class ProcessTable(Table):
    """Distribution of the true values of the parts to come."""

    mean: str = Field(default="0 mm", examples=['"0.002 mm"'])
    u: str = Field(examples=['"0.003 mm"'])


class PlacementTable(Table):
    x: str | list[str] | dict[str, list[str]] | None = Field(default=None, examples=[RANGE])
    y: str | list[str] | dict[str, list[str]] | None = Field(default=None, examples=[RANGE])
    z: str | list[str] | dict[str, list[str]] | None = Field(default=None, examples=[RANGE])
    turn_x: str | list[str] | dict[str, list[str]] | None = Field(
        default=None, examples=['["-10 deg", "10 deg"]']
    )
    turn_y: str | list[str] | dict[str, list[str]] | None = Field(
        default=None, examples=['["-10 deg", "10 deg"]']
    )
    turn_z: str | list[str] | dict[str, list[str]] | None = Field(
        default=None, examples=['["-180 deg", "180 deg"]']
    )
    slots: list[Point] = Field(default_factory=list, examples=['["100 50 -300 mm", "200 50 -300 mm"]'])
    faces_down: list[str] = Field(default_factory=list, examples=['["-z", "+x"]'])
    objective: str | dict[str, float] = Field(default="", examples=['"U/T"'])
    weights: dict[str, float] = Field(default_factory=dict, examples=['{ "bore diameter" = 1.0 }'])
    costs: dict[str, float] = Field(default_factory=dict, examples=["{ accept_bad = 100, reject_good = 20 }"])
    process: dict[str, ProcessTable] = Field(default_factory=dict)


def placement_from(document: Document, part: Part | None, model: Any, problems: Problems) -> Placement | None:
    """Return the placement of a scenario, or None where the file says nothing; notes every problem."""
    data = document.data.get("placement")
    if not isinstance(data, dict) or model is None or part is None:
        return None
    table: PlacementTable = model.placement
    here = ("placement",)
    for key in ("slots", "weights"):
        if key in data and not data[key]:
            problems.add((*here, key), f"{key} is empty, which allows nothing; leave it out")
    freedoms = [problems.attempt((*here, n), lambda n=n: _freedom(n, getattr(table, n))) for n in DOFS]  # type: ignore[misc]
    faces = problems.attempt((*here, "faces_down"), lambda: _faces(table.faces_down, part))
    kept = tuple(f for f in freedoms if f is not None)
    fixture = problems.attempt(here, lambda: Fixture(kept, tuple(table.slots), faces or {}))
    goal = problems.attempt(here, lambda: _goal(table, part))
    if fixture is None or goal is None:
        return None
    is_stated = bool(kept or table.slots or table.faces_down)
    return Placement(fixture if is_stated else None, goal)


def _freedom(name: str, value: Any) -> Freedom | None:
    """Parse "120 mm": fixed there; two values: a range; three or more, or { at = [...] }: a list of choices."""
    if value is None:
        return None
    if isinstance(value, dict):
        if set(value) != {"at"} or not value["at"]:
            raise UsageError(f'{name} = {{ ... }} takes one key: {name} = {{ at = ["0 deg", "90 deg"] }}')
        return Freedom(name, values=_numbers(name, value["at"]))
    if isinstance(value, str):
        return Freedom(name, values=_numbers(name, [value]))
    numbers = _numbers(name, value)
    if len(numbers) == 2:
        return Freedom(name, numbers[0], numbers[1])
    return Freedom(name, values=numbers)


def _numbers(name: str, texts: list[str]) -> tuple[float, ...]:
    if not texts:
        raise UsageError(f"{name} = [] allows nothing; leave it out to keep the present value")
    turn = name.startswith("turn")
    example = "90 deg" if turn else "100 mm"
    return tuple(quantity(t, "angle" if turn else "length", name, example) for t in texts)


def _faces(names: list[str], part: Part) -> Mapping[str, tuple[float, float, float]]:
    """Return directions of the drawing that may point down: "-z", or the outward normal of a plane by its name."""
    out: dict[str, tuple[float, float, float]] = {}
    planes = {n: f for n, f in part.features.items() if f.kind == "plane"}
    for name in names:
        if name in DOWN:
            out[name] = DOWN[name]
        elif name in planes:
            axis = np.asarray(planes[name].axis, dtype=float)
            out[name] = (float(axis[0]), float(axis[1]), float(axis[2]))
        else:
            raise UsageError(
                f"faces_down: {shorten(name)} is neither a direction nor a plane of the part.{choose_from(name, [*DOWN, *planes])}"
            )
    return out


def _goal(table: PlacementTable, part: Part) -> Goal:
    mixture = (
        {table.objective: 1.0}
        if isinstance(table.objective, str) and table.objective
        else table.objective or {}
    )
    assert isinstance(mixture, dict)
    names = [c.name for c in part.characteristics]
    for what, keys in (("weights", table.weights), ("process", table.process)):
        for name in keys:
            if name not in names:
                raise UsageError(
                    f'{what}: the part has no characteristic "{name}".{choose_from(name, names)}'
                )
    units = {c.name: gps.unit(c) for c in part.characteristics}
    process = {n: process_of(n, p, units[n]) for n, p in table.process.items()}
    return Goal(mixture, table.weights, table.costs, process)


def process_of(name: str, table: ProcessTable, unit: str) -> tuple[float, float]:
    """Return the mean from the middle of the tolerance, and standard deviation, of the process; mm or rad."""
    dimension, example = ("angle", "10 urad") if unit == "rad" else ("length", "0.003 mm")
    mean = 0.0 if table.mean == "0 mm" else quantity(table.mean, dimension, "mean", example)
    u = quantity(table.u, dimension, "u", example)
    if not u > 0:
        raise UsageError(f'process of "{name}": u = "{table.u}" must be positive')
    return mean, u
