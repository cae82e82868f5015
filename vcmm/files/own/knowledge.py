"""[[effects]] and [[inputs]] of a machine or scenario, checked against each other and against the machine.

Joint [[inputs]] of several quantities: their names and their covariance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from vcmm.core.effect import FREE_LINKS, Effect, parameter_fields, place_fields, unit_of
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import EVERY, Input
from vcmm.core.kinematics import Chain
from vcmm.core.knowledge import duplicate_text
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.units import channel_unit, parse_unit
from vcmm.files.columns import REDRAW, check_channel
from vcmm.files.own.effects import KeyProblems, build_effect, noting
from vcmm.files.own.inputs import build_input, degrees_of_freedom, input_parameter, redraw_of
from vcmm.files.problems import Problems, TableProblems
from vcmm.files.schema import is_number
from vcmm.files.toml import Location

CORRELATED_KEYS = ("names", "covariance", "nu", "redraw", "evidence")


def build_joint_input(
    table: dict[str, Any], effects: Sequence[Effect], complete: bool = True
) -> Input | None:
    """Convert an [[inputs]] table with names = ["backlash[X].gap", "channel.temp_part_C"] and their covariance.

    covariance[i][j] is in the unit of i times that of j, those of the parameters' own tables. Raises TableProblems.
    """
    key_problems: KeyProblems = []
    for key in table:
        if key not in CORRELATED_KEYS:
            text = f'unknown key "{key}" of correlated inputs.{choose_from(key, CORRELATED_KEYS)}'
            key_problems.append((key, text))
    names = table["names"]
    if not (isinstance(names, list) and len(names) > 1 and all(isinstance(n, str) for n in names)):
        text = (
            'names = ["backlash[X].gap", "backlash[Y].gap"]: two or more quantities that are known together'
        )
        raise TableProblems([*key_problems, ("names", text)])
    if len(set(names)) < len(names):
        key_problems.append(("names", "a quantity is named twice; name each once"))
    redraw = redraw_of(table)
    if redraw not in REDRAW:
        key_problems.append(("redraw", f'redraw = "{redraw}" is no label.{choose_from(redraw, REDRAW)}'))
    members: list[tuple[Input, str]] = []
    for name in names:
        with noting(key_problems, "names"):
            member = _member(name, effects, redraw, complete)
            if member is not None:
                members.append(member)
    law = None
    with noting(key_problems, "covariance"):
        law = _covariance(table, [unit for _, unit in members]) if len(members) == len(names) else None
    nu = np.inf
    with noting(key_problems, "nu"):
        nu = degrees_of_freedom(table)
    if key_problems:
        raise TableProblems(key_problems)
    if law is None:
        return None
    inputs = tuple(member for member, _ in members)
    whole = " & ".join(member.id for member in inputs)
    return Input("", "", whole, law, redraw, str(table.get("evidence", "")), members=inputs, nu=nu)


def _member(name: str, effects: Sequence[Effect], redraw: str, complete: bool) -> tuple[Input, str] | None:
    """Return a quantity by its name `effect[where].parameter` or `channel.column`, and its unit; its law is that of the covariance."""
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
        names = [f"{e.id}.{f.name}" for e in effects for f in parameter_fields(e)]
        raise UsageError(f'"{name}" is no quantity of the machine or part.{choose_from(name, names)}')
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


DIAGNOSIS_SOURCE = "diagnosed from"  # how the evidence begins of what a diagnosis wrote


def tables_in(data: Any, key: str) -> list[dict[str, Any]]:
    """Return the tables of a list such as [[effects]]; empty where the key holds something else."""
    tables = data.get(key, []) if isinstance(data, dict) else []
    return [t for t in tables if isinstance(t, dict)] if isinstance(tables, list) else []


def names_in(data: dict[str, Any], key: str) -> list[str] | None:
    """Return the names of a table of tables such as [axes]; None where it is missing or no table, which is reported elsewhere."""
    names = data.get(key)
    return list(names) if isinstance(names, dict) else None


def further_effects(
    tables: list[dict[str, Any]], chain: Chain | None, problems: Problems, at: Location
) -> list[Effect]:
    """Return the [[effects]] of a machine or scenario, on axes that the machine has."""
    out = []
    for i, table in enumerate(tables):
        here = (*at, "effects", i)
        built = problems.attempt(here, lambda table=table: build_effect(table))  # type: ignore[misc]
        if built is None:
            continue
        if chain and built.link not in (*FREE_LINKS, *chain.letters):
            key = next((f.name for f in place_fields(built)), "effect")
            problems.add(
                (*here, key),
                f'{built.id} acts on axis {built.link}, which is not in structure = "{chain.structure}"; '
                f"the axes are {', '.join(sorted(chain.letters))}",
            )
        out.append(built)
    return out


def further_inputs(
    tables: list[dict[str, Any]],
    effects: Sequence[Effect],
    stated: Sequence[Input],
    problems: Problems,
    at: Location,
    complete: bool = True,
) -> list[Input]:
    """Return the [[inputs]] of a machine or scenario. One quantity has one input: its name is that of its random stream.

    complete: all effects could be read, so that an input without its effect is a mistake of its own.
    """
    out: list[Input] = []
    for i, table in enumerate(tables):
        here = (*at, "inputs", i)
        build = build_joint_input if "names" in table else build_input
        quantity = problems.attempt(here, lambda table=table, build=build: build(table, effects, complete))  # type: ignore[misc]
        if quantity is None:
            continue
        note_second(quantity, [*stated, *out], problems, here)
        out.append(quantity)
    return out


def note_second(quantity: Input, stated: Sequence[Input], problems: Problems, at: Location) -> None:
    """Note a quantity that has an Input already, at its place in the file."""
    twice = duplicate_text(quantity, stated)
    if twice:
        problems.add(at, twice)


def found_since(inputs: Sequence[Input], stated: Sequence[Input]) -> dict[str, str]:
    """Return id -> evidence of the Inputs whose quantity a diagnosis has found since, at that place or at all: it includes the knowledge stated
    before, so its u holds alone."""
    causes = {
        (i.effect, i.where, i.parameter): i.evidence
        for i in stated
        if i.evidence.startswith(DIAGNOSIS_SOURCE)
    }
    places = {i.id: [(i.effect, where, i.parameter) for where in (i.where, "", EVERY)] for i in inputs}
    return {name: causes[key] for name, keys in places.items() for key in keys[::-1] if key in causes}
