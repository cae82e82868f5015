"""The joint covariance of an error table: a CSV beside errors.csv, to one Input that all errors share.

    error,position,EXX@0,EXX@75,...,C0Y
    EXX,0,1.2e-7,...

One row and one column per number of the error table: component and position (mm; rad for A B C), or a squareness or
location error without position. Values in mm^2, rad^2 and mm rad. Positions are the nodes of the table.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vcmm.core.effect import Effect, own_nodes
from vcmm.core.errors import DataError
from vcmm.core.inputs import EVERY, Input, JointCovariance
from vcmm.core.laws import Normal
from vcmm.core.run import Array
from vcmm.core.text import brief, csv_of, to_number
from vcmm.files.sheets import Sheet, read_csv
from vcmm.physics.structure.component import CalibrationModes, ComponentSpline, ComponentTable

HEAD = ("error", "position")
ASYMMETRY = 1e-6


def read_joint_covariance(path: str | Path) -> JointCovariance:
    """Read a file. Raises DataError: names that do not fit the columns, cells that are no numbers, no covariance."""
    sheet = read_csv(path)
    if tuple(sheet.header[:2]) != HEAD or len(sheet.header) - 2 != len(sheet.rows):
        raise DataError(
            f"{sheet.head}: a joint covariance has the columns error, position and one per row; "
            f"there are {len(sheet.rows)} rows and {len(sheet.header) - 2} such columns"
        )
    errors = tuple(sheet.words("error"))
    position = np.array([_position(sheet, i, cell) for i, cell in enumerate(sheet.words("position"))])
    due = [label(e, q) for e, q in zip(errors, position)]
    for i, (name, want) in enumerate(zip(sheet.header[2:], due)):
        if name != want:
            raise DataError(
                f"{sheet.at(i)}: row {i + 1} is {brief(want)}, but column {i + 1} is {brief(name)}; keep one order"
            )
    matrix = sheet.stack(sheet.header[2:])
    _check_covariance(sheet, matrix)
    return JointCovariance(errors, position, (matrix + matrix.T) / 2)


def _position(sheet: Sheet, row: int, cell: str) -> float:
    try:
        return to_number(cell) if cell else np.nan
    except ValueError:
        raise DataError(
            f'{sheet.at(row)}: the position "{brief(cell)}" is not a number; leave it empty for C0Y'
        ) from None


def _check_covariance(sheet: Sheet, matrix: Array) -> None:
    below = np.flatnonzero(np.diag(matrix) < 0)
    if len(below):
        raise DataError(f"{sheet.at(int(below[0]))}: the variance in row {below[0] + 1} is below zero")
    u = np.sqrt(np.diag(matrix))
    scale = np.outer(u, u)
    wrong = np.argwhere(np.abs(matrix - matrix.T) > ASYMMETRY * scale + 1e-300)
    if len(wrong):
        i, j = wrong[0]
        raise DataError(
            f"{sheet.at(int(i))}: not symmetric: row {i + 1}, column {j + 1} differs from its mirror image"
        )
    safe = np.where(u > 0, u, 1.0)
    low = float(np.linalg.eigvalsh(matrix / np.outer(safe, safe)).min())
    if low < -1e-5 * len(matrix):
        raise DataError(
            f"{sheet.head}: no covariance: its correlation matrix has the eigenvalue {low:.3g}; "
            "a covariance has none below zero"
        )


def label(error: str, position: float) -> str:
    """Return the label of a number: EXX@75 or C0Y."""
    return error if np.isnan(position) else f"{error}@{position:.10g}"


def covariance_text(joint: JointCovariance) -> str:
    """Return the file that `read_joint_covariance` reads."""
    names = [label(e, q) for e, q in zip(joint.errors, joint.position)]
    rows: list[list[object]] = [[*HEAD, *names]]
    for error, q, row in zip(joint.errors, joint.position, joint.matrix):
        rows.append([error, "" if np.isnan(q) else f"{q:.10g}", *(f"{v:.8g}" for v in row)])
    return csv_of(rows)


def joint_knowledge(
    joint: JointCovariance, effects: Sequence[Effect], evidence: str
) -> tuple[list[Effect], list[Input]]:
    """Return CalibrationModes per error, and the Input that they share.

    effects: those of the error table. Raises DataError for an error or nodes that the table does not have.
    """
    factor, names = joint.factor, np.array(joint.errors)
    by_name = {e.where: e for e in effects}
    out: list[Effect] = []
    for name in dict.fromkeys(joint.errors):
        rows = np.flatnonzero(names == name)
        _check_nodes(name, joint.position[rows], by_name)
        cubic = isinstance(by_name[name], ComponentSpline)
        nodes = np.zeros(0) if np.isnan(joint.position[rows[0]]) else joint.position[rows]
        out.append(CalibrationModes(name, nodes, factor[rows], "cubic" if cubic else "linear"))
    if not factor.shape[1]:
        return [], []
    return out, [Input(CalibrationModes.name, EVERY, "modes", Normal(1.0), "machine", evidence)]


def _check_nodes(name: str, position: Array, by_name: dict[str, Effect]) -> None:
    if name not in by_name:
        raise DataError(f"covariance: {name} is not in the error table, which has {', '.join(by_name)}")
    effect = by_name[name]
    nodes = own_nodes(effect)
    if nodes is None and isinstance(effect, ComponentTable):
        raise DataError(
            f"covariance: {name} is tabulated over several axes; state an uncertainty for it instead"
        )
    nodes = np.zeros(0) if nodes is None else nodes
    given = position[~np.isnan(position)]
    if len(given) != len(nodes) or not np.allclose(given, nodes, rtol=0, atol=1e-6):
        raise DataError(
            f"covariance: the positions of {name} are not those of the error table; write one row per node"
        )
