"""Poses of a tracker against the joint angles of an arm (recordings of kind "pose"): columns of one file or two to PoseReadings.

Usual columns: C1_deg A2_deg ... (or _rad), x_mm y_mm z_mm (or _m), and where orientations were read qw qx qy qz, rot_x_deg rot_y_deg
rot_z_deg (a rotation vector, or _rad) or r11 r12 ... r33. [poses] names the columns of files that are written otherwise.
"""

from __future__ import annotations

from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from vcmm.core.errors import DataError, UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.core.units import quantity
from vcmm.files.schema import Point, Table
from vcmm.files.sheets import Sheet, read_csv
from vcmm.task.response.poses import PoseReadings, check_arm

_UNITS = {"deg": np.pi / 180.0, "rad": 1.0, "mm": 1.0, "m": 1000.0}
_POSITION = tuple("xyz")
_ROTATION = ("rot_x", "rot_y", "rot_z")
_QUATERNION = ("qw", "qx", "qy", "qz")
_MATRIX = tuple(f"r{i}{j}" for i in "123" for j in "123")
Word = Literal[
    "",
    "quaternion wxyz",
    "quaternion xyzw",
    "rotation vector",
    "matrix",
    "euler xyz",
    "euler zyx",
    "euler zyz",
]
_COUNT = {"quaternion wxyz": 4, "quaternion xyzw": 4, "matrix": 9}  # numbers of an orientation; else 3
TURNED = 0.01  # a quaternion or matrix written with two decimals is still one


class PosesTable(Table):
    """Form of the poses, where it is not the usual one: names of columns, or their numbers from "1" in a file without a heading.

    measured: a second file that holds what the tracker read, in the same order of rows. angle, length: units of columns that do not say
    theirs. orientation_as: euler xyz turns about the fixed axes x, y, z in that order (zyx: about its own axes is the same as xyz about
    fixed ones). offset: where the target sits on the tool, in the axes of the last joint; found from the poses where it is left out.
    ignore: columns that say nothing of the arm; another one that nothing uses is refused.
    """

    measured: str = Field(default="", examples=['"tracker.csv"'])
    joints: list[str] = Field(default_factory=list, examples=['["q1", "q2", "q3", "q4", "q5", "q6"]'])
    position: list[str] = Field(default_factory=list, examples=['["x", "y", "z"]'])
    orientation: list[str] = Field(default_factory=list, examples=['["rx", "ry", "rz"]'])
    orientation_as: Word = Field(default="", examples=['"euler xyz"'])
    angle: Literal["deg", "rad"] = "deg"
    length: Literal["mm", "m"] = "mm"
    offset: Point = (0.0, 0.0, 0.0)
    u_orientation: str = Field(default="", examples=['"50 urad"'])
    ignore: list[str] = Field(default_factory=list, examples=['["time_s", "temperature"]'])


def read_poses(
    table: PosesTable, path: Path, machine: Machine, name: str, u_position: float = 0.0
) -> PoseReadings:
    """Read poses. Raises DataError with every problem: file, column, line; UsageError for a machine that is no arm."""
    check_arm(machine, str(path))
    commanded = read_csv(path, numbered=True)
    measured = read_csv(path.parent / table.measured, numbered=True) if table.measured else commanded
    if measured.count != commanded.count:
        raise DataError(
            f"{measured.path} has {measured.count} rows and {commanded.path} {commanded.count}; they hold the same poses in the same order"
        )
    positions, letters = _positions(table, measured), _joints(table, commanded, machine)
    oriented = _orientation_columns(table, measured)
    _refuse_idle(table, commanded, measured, [*letters, *positions, *(oriented[0] if oriented else ())])
    position = _numbers(measured, positions, table.length, ("mm", "m"))
    joints = _numbers(commanded, letters, table.angle, ("deg", "rad"))
    run = Run(
        {a: joints[:, i] for i, a in enumerate(machine.chain.letters)},
        np.tile(table.offset, (commanded.count, 1)),
    )
    u_turn = (
        quantity(table.u_orientation, "angle", "u_orientation", "50 urad") if table.u_orientation else 0.0
    )
    lines = np.asarray(commanded.lines, dtype=np.intp)
    return PoseReadings(
        name, run, position, _orientations(table, measured, oriented), (u_position, u_turn), lines
    )


def _joints(table: PosesTable, sheet: Sheet, machine: Machine) -> list[str]:
    letters = machine.chain.letters
    if table.joints:
        if len(table.joints) != len(letters):
            raise UsageError(
                f"joints names {len(table.joints)} columns, and the arm has {len(letters)} joints: {' '.join(letters)}; write one for each, in that order"
            )
        return _present(sheet, table.joints, "joints")
    names = [
        next((f"{a}_{u}" for u in ("deg", "rad") if f"{a}_{u}" in sheet.header), f"{a}_deg") for a in letters
    ]
    return _present(sheet, names, "joints")


def _positions(table: PosesTable, sheet: Sheet) -> list[str]:
    if table.position:
        if len(table.position) != 3:
            raise UsageError(f"position names {len(table.position)} columns; expected three: x, y, z")
        return _present(sheet, table.position, "position")
    names = [
        next((f"{c}_{u}" for u in ("mm", "m") if f"{c}_{u}" in sheet.header), f"{c}_mm") for c in _POSITION
    ]
    return _present(sheet, names, "position")


def _present(sheet: Sheet, names: list[str], key: str) -> list[str]:
    """Return the names. Raises DataError for a name that is no column."""
    lacking = [n for n in names if n not in sheet.header]
    if lacking:
        raise DataError(
            f"{sheet.head}: there is no column {' '.join(lacking)}.{choose_from(lacking[0], sheet.header)} Name the columns with [poses] {key} = [...]"
        )
    return names


def _numbers(sheet: Sheet, names: list[str], unit: str, allowed: tuple[str, ...]) -> Array:
    """Return numbers (n, k) in mm or rad: a column's own unit where its name ends in one, else `unit`."""
    numbers = [n.rpartition("_")[2] for n in names]
    return sheet.stack(names) * np.array([_UNITS[u if u in allowed else unit] for u in numbers])


def _refuse_idle(table: PosesTable, joints: Sheet, tracker: Sheet, used: list[str]) -> None:
    """Raise DataError for columns that are neither used nor ignored by name: they may be orientations under other names."""
    for sheet in (joints, tracker) if tracker is not joints else (joints,):
        idle = [n for n in sheet.header if n not in used and n not in table.ignore]
        if idle:
            shown = ", ".join(f'"{n}"' for n in idle)
            raise DataError(
                f"{sheet.head}: nothing uses the column{'s' if len(idle) > 1 else ''} {' '.join(idle)}; name orientations with [poses] orientation = [...] and "
                f"orientation_as, or write ignore = [{shown}]"
            )
    gone = [n for n in table.ignore if n not in joints.header and n not in tracker.header]
    if gone:
        raise DataError(
            f"{joints.head}: [poses] ignore names {' '.join(gone)}, which is no column; take it out"
        )


def _orientation_columns(table: PosesTable, sheet: Sheet) -> tuple[list[str], Word] | None:
    """Return the columns of orientations and their notation; None where there are none."""
    names, word = table.orientation, table.orientation_as
    if not names:
        if word:
            raise UsageError(
                f'orientation_as = "{word}" says how to read columns that orientation = [...] names; name them'
            )
        return _usual_orientation(sheet)
    if not word:
        raise UsageError(
            f"orientation names columns, and orientation_as does not say what they are: {', '.join(w for w in Word.__args__ if w)}"  # type: ignore[attr-defined]
        )
    due = _COUNT.get(word, 3)
    if len(names) != due:
        raise UsageError(f'orientation names {len(names)} columns where "{word}" has {due}')
    return _present(sheet, names, "orientation"), word


def _orientations(table: PosesTable, sheet: Sheet, oriented: tuple[list[str], Word] | None) -> Array | None:
    """Return matrices (n, 3, 3) of the columns; None where there are none."""
    if oriented is None:
        return None
    names, word = oriented
    if _COUNT.get(word, 3) == 3:
        return _from_angles(_numbers(sheet, names, table.angle, ("deg", "rad")), word)
    return _from_units(sheet.stack(names), word, sheet)


def _usual_orientation(sheet: Sheet) -> tuple[list[str], Word] | None:
    have = set(sheet.header)
    vectors = [[f"{n}_{u}" for n in _ROTATION] for u in ("deg", "rad")]
    kinds: list[tuple[list[str], Word]] = [(list(_QUATERNION), "quaternion wxyz"), (list(_MATRIX), "matrix")]
    kinds += [(v, "rotation vector") for v in vectors]
    for names, word in kinds:
        if set(names) <= have:
            return names, word
    for names, word in kinds:
        if not have.isdisjoint(
            names
        ):  # some of them: a mistyped name must not drop the orientations in silence
            lacking = [n for n in names if n not in have]
            raise DataError(
                f"{sheet.head}: orientations as {word} are the columns {' '.join(names)}, and there is no column {' '.join(lacking)}."
                f"{choose_from(lacking[0], sheet.header)} Complete them, take the others out, or name them with [poses] orientation = [...]"
            )
    return None


def _from_angles(values: Array, word: str) -> Array:
    from scipy.spatial.transform import Rotation

    if word == "rotation vector":
        return np.asarray(Rotation.from_rotvec(values).as_matrix())
    if word == "euler zyx":  # about its own axes z, y, x
        return np.asarray(Rotation.from_euler("ZYX", values).as_matrix())
    if word == "euler zyz":
        return np.asarray(Rotation.from_euler("ZYZ", values).as_matrix())
    return np.asarray(Rotation.from_euler("xyz", values).as_matrix())


def _from_units(values: Array, word: str, sheet: Sheet) -> Array:
    """Return matrices (n, 3, 3) of quaternions or matrices. Raises DataError for a row that is none."""
    from scipy.spatial.transform import Rotation

    if word == "matrix":
        matrices = values.reshape(-1, 3, 3)
        off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
        off = np.where(np.linalg.det(matrices) > 0, off, 2.0)
        what = "no rotation: its rows are not of length 1 and square to one another, or it mirrors"
    else:
        off = np.abs(np.linalg.norm(values, axis=1) - 1.0)
        what = "no unit quaternion"
    wrong = np.flatnonzero(off > TURNED)
    if len(wrong):
        raise DataError(
            f"{sheet.at(int(wrong[0]))}: the orientation is {what} ({len(wrong)} of {len(values)} rows are so)"
        )
    if word == "matrix":
        left, _, right = np.linalg.svd(matrices)
        return np.asarray(left @ right)
    ordered = np.roll(values, -1, axis=1) if word == "quaternion wxyz" else values
    return np.asarray(Rotation.from_quat(ordered).as_matrix())
