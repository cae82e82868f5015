"""[[inputs]] of quantities that are known together: their names and their covariance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from vcmm.core.effect import Effect, parameter_fields, unit_of
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.units import channel_unit, parse_unit
from vcmm.files.columns import REDRAW, check_channel
from vcmm.files.own.effects import KeyProblems, noting
from vcmm.files.own.inputs import degrees_of_freedom, input_parameter, is_number, redraw_of
from vcmm.files.problems import TableProblems

CORRELATED_KEYS = ("names", "covariance", "nu", "redraw", "evidence")


def build_joint_input(
    table: dict[str, Any], effects: Sequence[Effect], complete: bool = True
) -> Input | None:
    """An [[inputs]] table with names = ["backlash[X].gap", "channel.temp_part_C"] and their covariance.

    covariance[i][j] is in the unit of i times that of j, those of the parameters' own tables. Raises TableProblems.
    """
    found: KeyProblems = []
    for key in table:
        if key not in CORRELATED_KEYS:
            text = f'unknown key "{key}" of correlated inputs.{choose_from(key, CORRELATED_KEYS)}'
            found.append((key, text))
    names = table["names"]
    if not (isinstance(names, list) and len(names) > 1 and all(isinstance(n, str) for n in names)):
        text = (
            'names = ["backlash[X].gap", "backlash[Y].gap"]: two or more quantities that are known together'
        )
        raise TableProblems([*found, ("names", text)])
    if len(set(names)) < len(names):
        found.append(("names", "a quantity stands there twice; name each once"))
    redraw = redraw_of(table)
    if redraw not in REDRAW:
        found.append(("redraw", f'redraw = "{redraw}" is no label.{choose_from(redraw, REDRAW)}'))
    members: list[tuple[Input, str]] = []
    for name in names:
        with noting(found, "names"):
            one = _member(name, effects, redraw, complete)
            if one is not None:
                members.append(one)
    law = None
    with noting(found, "covariance"):
        law = _covariance(table, [unit for _, unit in members]) if len(members) == len(names) else None
    nu = np.inf
    with noting(found, "nu"):
        nu = degrees_of_freedom(table)
    if found:
        raise TableProblems(found)
    if law is None:
        return None
    inputs = tuple(one for one, _ in members)
    whole = " & ".join(one.id for one in inputs)
    return Input("", "", whole, law, redraw, str(table.get("evidence", "")), members=inputs, nu=nu)


def _member(name: str, effects: Sequence[Effect], redraw: str, complete: bool) -> tuple[Input, str] | None:
    """A quantity by its name `effect[where].parameter` or `channel.column`, and its unit; its law is that of the covariance."""
    target, _, word = name.rpartition(".")
    where = target[target.find("[") + 1 : -1] if target.endswith("]") else ""
    effect = target.split("[")[0]
    if effect == "channel":
        check_channel(word)
        return Input("channel", "", word, Normal(1.0), redraw), channel_unit(word)
    hit = next((e for e in effects if (e.name, e.where) == (effect, where)), None)
    if hit is None:
        if not complete:
            return None
        known = [f"{e.id}.{f.name}" for e in effects for f in parameter_fields(e)]
        raise UsageError(f'"{name}" is no quantity of the machine or part.{choose_from(name, known)}')
    spec = input_parameter(type(hit), {"parameter": word}, str(getattr(hit, "component", "")))
    if np.size(getattr(hit, spec.name)) != 1:
        raise UsageError(f'"{name}" is a table of numbers; only single numbers are correlated by name')
    return Input(effect, where, spec.name, Normal(1.0), redraw), unit_of(hit, spec.name)


def _covariance(table: dict[str, Any], units: Sequence[str]) -> MultivariateNormal:
    rows, n = table.get("covariance"), len(units)
    square = (
        isinstance(rows, list) and len(rows) == n and all(isinstance(r, list) and len(r) == n for r in rows)
    )
    if not square or not all(is_number(v) for row in rows for v in row):  # type: ignore[union-attr]
        raise UsageError(
            f"covariance must be {n} rows of {n} plain numbers, in the units {', '.join(units)} multiplied in pairs"
        )
    factor = np.array([parse_unit(unit).factor for unit in units])
    return MultivariateNormal(np.array(rows, dtype=float) * np.outer(factor, factor))
