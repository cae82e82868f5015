"""Read [surroundings] of a scenario with [surroundings.head]: obstacles of the stylus, and the room it needs."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

import numpy as np
from pydantic import Field

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.pose import Pose
from vcmm.core.units import quantity
from vcmm.files.problems import Problems
from vcmm.files.schema import Angle, Deviation, Direction, Distance, Point, Size, Table, Turn
from vcmm.part.part import Part
from vcmm.task.measuring.obstacles import Clamp, Head, Surroundings
from vcmm.task.measuring.plan import Plan


class HeadTable(Table):
    diameter: Size = 60.0
    length: Size = 100.0
    extension: Size = 20.0
    quill: Point = (80.0, 80.0, 400.0)
    up: Direction = (0.0, 0.0, 1.0)


class ClampTable(Table):
    centre: Point
    size: Point
    turn: Turn = (0.0, 0.0, 0.0)
    on: Literal["table", "part"] = "table"


class SurroundingsTable(Table):
    head: HeadTable = Field(default_factory=HeadTable)
    clamps: dict[str, ClampTable] = Field(
        default_factory=dict, examples=['{ left = { centre = "0 0 30 mm", size = "20 20 10 mm" } }']
    )
    table: Deviation | None = None
    safe: Distance = 2.0
    shaft_gap: Distance = 0.05
    shafts: dict[str, str] = Field(default_factory=dict, examples=['{ down = "3 mm" }'])
    steepest: Angle = math.radians(120.0)
    wall: Size = 5.0
    forms: dict[str, str] = Field(default_factory=dict, examples=['{ bore = "0.5 um" }'])


def surroundings_of(
    model: SurroundingsTable, part: Part, plan: Plan, problems: Problems
) -> Surroundings | None:
    """Return the Surroundings of a scenario; problems are added to `problems`."""
    before, at = len(problems.found), "surroundings"
    clamps = []
    for name, t in model.clamps.items():
        if min(t.size) <= 0:
            problems.add((at, "clamps", name, "size"), f"the size of {name} must be three positive lengths")
        clamps.append(Clamp(name, t.size, Pose.from_turns(np.array(t.centre), np.array(t.turn)), t.on))
    if min(model.head.quill) <= 0:
        problems.add((at, "head", "quill"), "quill must be three positive lengths: two sides and its length")
    shafts = _lengths("shafts", model.shafts, plan.styli, problems)
    forms = _lengths("forms", model.forms, part.features, problems)
    if len(problems.found) > before:
        return None
    h = model.head
    head = Head(h.diameter, h.length, h.extension, h.quill, h.up, shafts)
    return problems.attempt(
        (at,),
        lambda: Surroundings(
            head=head, clamps=tuple(clamps), table=model.table, safe=model.safe, shaft=model.shaft_gap, steepest=model.steepest, wall=model.wall,
            forms=forms,
        ),
    )  # fmt: skip


def _lengths(
    key: str, table: Mapping[str, str], names: Mapping[str, object], problems: Problems
) -> dict[str, float]:
    """Parse { bore = "0.5 um" } with names that exist."""
    out: dict[str, float] = {}
    for name, text in table.items():
        here = ("surroundings", key, name)
        if name not in names:
            problems.add(here, f'{key} names "{name}", which is unknown.{choose_from(name, names)}')
            continue
        try:
            out[name] = quantity(text, "length", name, "0.5 um")
        except UsageError as error:
            problems.add(here, str(error))
            continue
        if out[name] < 0.0:
            problems.add(here, f"{name} = {text} must not be negative")
    return out
