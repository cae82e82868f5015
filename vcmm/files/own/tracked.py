"""[tracked] of a machine file: its numbers were followed in time, and are known together as they were at a date.

    [tracked]
    at = "2026-12-01"                       # the date for which the file is valid
    last_check = "2026-11-20"               # the last recording that it knows
    covariance = "machine_state.csv"        # what the recordings leave
    since = "machine_since.csv"             # what may have changed from the last check until then

Both files are joint covariances (see vcmm.files.own.joint_covariance) whose rows are parameters of effects: their name as of Inputs and
the number of the element, "component_table[EXX].values" and 3, "backlash[X].gap" without one. Each becomes one Input of all of them; the second is
the line "time since calibration" of every budget.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.errors import DataError, UsageError, choose_from
from vcmm.core.inputs import SINCE, STATE, Input
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.run import Array
from vcmm.files.own.joint_covariance import read_joint_covariance
from vcmm.files.own.machine_tables import Tracked


def tracked_inputs(table: Tracked, folder: Path, effects: Sequence[Effect]) -> list[Input]:
    """Return the Inputs of [tracked]. Raises DataError and UsageError for files and names that do not fit the effects."""
    label = f"followed until {table.last_check}"
    out = [_joint_input(folder / table.covariance, effects, "", label)]
    if table.since is not None:
        later = f"from the last check, {table.last_check}, until {table.at}"
        out.append(_joint_input(folder / table.since, effects, SINCE, later))
    return out


def _joint_input(path: Path, effects: Sequence[Effect], cause: str, label: str) -> Input:
    joint = read_joint_covariance(path)
    members, widths, at = [], [], 0
    for name, rows in groupby(joint.errors):
        count = len(list(rows))
        member = _member(path, name, joint.position[at : at + count], effects)
        members.append(Input(member.name, member.where, name.rpartition(".")[2], Normal(1.0), cause=cause))
        widths.append(count)
        at += count
    law = MultivariateNormal(
        joint.factor @ joint.factor.T
    )  # what the digits of the file leave below zero is rounding
    return Input(
        "", "", STATE, law, "machine", label, members=tuple(members), cause=cause, widths=tuple(widths)
    )


def _member(path: Path, name: str, element: Array, effects: Sequence[Effect]) -> Effect:
    """Return the effect of a row. Raises UsageError where there is none, and DataError where its elements are others."""
    place, _, parameter = name.rpartition(".")
    hit = next((e for e in effects if e.id == place), None)
    if hit is None or not hasattr(hit, parameter):
        names = [f"{e.id}.{e.about.table_parameter}" if e.about.table_parameter else e.id for e in effects]
        raise UsageError(
            f'{path}: "{name}" is no parameter of an effect of the machine.{choose_from(name, names)}'
        )
    size = int(np.size(getattr(hit, parameter)))
    due = np.full(1, np.nan) if np.ndim(getattr(hit, parameter)) == 0 else np.arange(float(size))
    if len(element) != len(due) or not np.array_equal(element, due, equal_nan=True):
        raise DataError(
            f"{path}: {name} has {size} numbers, but the file has {len(element)} rows of it or another order"
        )
    return hit
