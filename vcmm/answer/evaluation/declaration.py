"""Declare which influences an evaluation covers, as ISO/TS 15530-4 requires of software: every family of effects, and influences that are no effect.

"uncertain"    an Input moves it: it is in the budget
"known"        the machine file or the scenario states it, and it is taken as exact
"not covered"  it is not stated: U does not include it

Families are the files of vcmm/physics, one family each; their first line describes them. A file of structure/ that holds a part of a
family of catalogue/ names it as FAMILY.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

from vcmm.answer.evaluation.part_forms import FORM
from vcmm.core.inputs import Input
from vcmm.physics import ALL
from vcmm.task.measuring.task import Task

UNCERTAIN, KNOWN, NOT_COVERED = "uncertain", "known", "not covered"
OF_CUTTING = ("tool", "setup")  # who answers for effects that no measuring machine has


@dataclass(frozen=True)
class DeclaredInfluence:
    """One influence: description, coverage, and its Inputs."""

    influence: str
    what: str
    status: str
    inputs: tuple[str, ...] = ()


def declared_influences(task: Task) -> tuple[DeclaredInfluence, ...]:
    """Return all influences of a measuring task, those of the machine first."""
    single = [m for quantity in task.inputs for m in (quantity.members or (quantity,))]
    return (*_of_effects(task, single), *_unmodelled_influences(task))


def _of_effects(task: Task, single: Sequence[Input]) -> list[DeclaredInfluence]:
    files: dict[str, list[type]] = {}
    for kind in ALL:
        if kind.about.belongs_to not in OF_CUTTING and not kind.about.needs_cut:
            files.setdefault(_family(kind), []).append(kind)
    of_machine = {e.name for e in task.machine.effects}
    out = []
    for family, kinds in files.items():
        names = {str(k.name) for k in kinds}  # type: ignore[attr-defined]
        moved = tuple(dict.fromkeys(i.id for i in single if i.effect in names))
        status = UNCERTAIN if moved else KNOWN if of_machine & names else NOT_COVERED
        sentence = (sys.modules[kinds[0].__module__].__doc__ or "").split("\n", 1)[0]
        out.append(DeclaredInfluence(family, sentence, status, moved))
    return out


def _family(kind: type) -> str:
    module = sys.modules[kind.__module__]
    stem = kind.__module__.rpartition(".")[2].replace("_", " ")
    return str(getattr(module, "FAMILY", stem))


def _unmodelled_influences(task: Task) -> list[DeclaredInfluence]:
    """Return the influences that no effect represents."""
    warm = tuple(dict.fromkeys(i.id for i in task.inputs if i.is_channel))
    forms = tuple(i.id for i in task.inputs if i.effect == FORM)
    aligned = task.plan.alignment is not None
    free = [n for n in task.touches.rows if n not in task.forms]
    return [
        DeclaredInfluence("temperatures", "Temperatures of part, scales and room, true minus reading.", UNCERTAIN if warm else KNOWN, warm),
        DeclaredInfluence("alignment", "The part is found by its own measured features.", UNCERTAIN if aligned else KNOWN),
        DeclaredInfluence("sampling", "Number and places of the points of every feature, as the plan has them.", KNOWN),
        DeclaredInfluence(
            "form of the part", f"What the surfaces do between and beside the points{'; not stated of ' + ', '.join(free) if free else ''}.",
            UNCERTAIN if forms else KNOWN if not free else NOT_COVERED, forms,
        ),
        DeclaredInfluence("fit", "Association of the elements: certified sets of data to 1e-9 mm.", KNOWN),
        DeclaredInfluence("scanning", "Dynamics and filters of a scanning probe.", NOT_COVERED),
        DeclaredInfluence("handling", "Dirt, burrs, operator, damage, change of the machine after its calibration.", NOT_COVERED),
    ]  # fmt: skip
