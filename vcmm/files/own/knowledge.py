"""[[effects]] and [[inputs]] of a machine or scenario, checked against each other and against the machine."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from vcmm.core.effect import FREE_LINKS, Effect, place_fields
from vcmm.core.inputs import EVERY, Input
from vcmm.core.kinematics import Chain
from vcmm.core.knowledge import duplicate_text
from vcmm.files.own.correlated_inputs import build_joint_input
from vcmm.files.own.effects import build_effect
from vcmm.files.own.inputs import build_input
from vcmm.files.problems import Problems
from vcmm.files.toml import Location

DIAGNOSIS_SOURCE = "diagnosed from"  # how the evidence begins of what a diagnosis wrote


def tables_in(data: Any, key: str) -> list[dict[str, Any]]:
    """The tables of a list such as [[effects]]; empty where the key holds something else."""
    found = data.get(key, []) if isinstance(data, dict) else []
    return [t for t in found if isinstance(t, dict)] if isinstance(found, list) else []


def names_in(data: dict[str, Any], key: str) -> list[str] | None:
    """The names of a table of tables such as [axes]; None where it is missing or no table, which is reported elsewhere."""
    found = data.get(key)
    return list(found) if isinstance(found, dict) else None


def further_effects(
    tables: list[dict[str, Any]], chain: Chain | None, problems: Problems, at: Location
) -> list[Effect]:
    """The [[effects]] of a machine or scenario, on axes that the machine has."""
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
    known: Sequence[Input],
    problems: Problems,
    at: Location,
    complete: bool = True,
) -> list[Input]:
    """The [[inputs]] of a machine or scenario. One quantity has one input: its name is that of its random stream.

    complete: all effects could be read, so that an input without its effect is a mistake of its own.
    """
    out: list[Input] = []
    for i, table in enumerate(tables):
        here = (*at, "inputs", i)
        build = build_joint_input if "names" in table else build_input
        found = problems.attempt(here, lambda table=table, build=build: build(table, effects, complete))  # type: ignore[misc]
        if found is None:
            continue
        note_second(found, [*known, *out], problems, here)
        out.append(found)
    return out


def note_second(one: Input, known: Sequence[Input], problems: Problems, at: Location) -> None:
    """Note a quantity that has an Input already, at its place in the file."""
    twice = duplicate_text(one, known)
    if twice:
        problems.add(at, twice)


def found_since(inputs: Sequence[Input], known: Sequence[Input]) -> dict[str, str]:
    """Id -> evidence of the Inputs whose quantity a diagnosis has found since, at that place or at all: it took what was stated as known
    before, so its u holds alone."""
    found = {
        (i.effect, i.where, i.parameter): i.evidence for i in known if i.evidence.startswith(DIAGNOSIS_SOURCE)
    }
    asked = {i.id: [(i.effect, where, i.parameter) for where in (i.where, "", EVERY)] for i in inputs}
    return {name: found[key] for name, keys in asked.items() for key in keys[::-1] if key in found}
