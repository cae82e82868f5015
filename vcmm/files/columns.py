"""CSV files of positions and recordings: header names with units to canonical columns of a Run."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable
from pathlib import Path

import numpy as np

from vcmm.core.axes import LETTERS, ROTARY, in_order, is_axis, is_rotary
from vcmm.core.errors import DataError, UsageError, did_you_mean
from vcmm.core.run import OFFSET_LABEL, Array, Run
from vcmm.core.units import UNITS
from vcmm.files.problems import misspelt
from vcmm.files.sheets import Sheet, read_csv
from vcmm.physics import ALL

LABELS = (
    "pose",
    "part",
    "stylus",
    "tool",
    "feature",
    "setup",
    "run",
    "event",
    "instrument",
    "clamp",
    "repeat",
    "mode",
)
REDRAW = ("machine", "touch", OFFSET_LABEL, *LABELS)  # what an Input may be redrawn by
DEG = np.pi / 180.0
_BY_AXIS = (
    "sense_{}",
    "since_reversal_{}_mm",
    "speed_{}_mm_s",
    "accel_{}_mm_s2",
    "raw_{}_mm",
    "travel_{}_mm",
)
_BY_ROTARY = ("since_reversal_{}_rad", "speed_{}_rad_s", "accel_{}_rad_s2")
_BY_DIRECTION = ("offset_{}_mm", "from_{}_mm", "force_{}_N", "load_{}_mm", "part_{}_mm", "tip_{}_mm")
_SINGLE = (
    "time_s", "nx", "ny", "nz", "pressure_hPa", "humidity_pct", "load_kg", "spindle_rpm", "spindle_load_W", "spindle_angle_deg",
    "probe_angle_deg", "probe_lateral", "head_A_deg", "head_B_deg", "stylus_length_mm", "tip_radius_mm",
    "tool_radius_mm", "tool_length_mm", "cut_length_mm", "across_tool", "chip_load_mm", "feed_mm_min", "dead_path_mm",
    "temp_gradient_C", "temp_part_C", "temp_air_C", "temp_spindle_C",
    "temp_scale_x_C", "temp_scale_y_C", "temp_scale_z_C",
    "spindle_on_s", "time_since_accel_s",
    "d_um", "dx_um", "dy_um", "dz_um", "d_urad", "u_um", "pointed_x", "pointed_y", "pointed_z",
)  # fmt: skip


def read_positions(path: str | Path, axes: tuple[str, ...]) -> Run:
    """Convert positions (X_mm ... C_deg) and tip offsets (offset_x_mm ...) to a Run; every axis must have its column.

    All columns of a recording are read. Raises DataError with every problem: column, line and fix.
    """
    return positions_of(read_csv(path), axes)


def positions_of(sheet: Sheet, axes: tuple[str, ...]) -> Run:
    """Return the Run of a table that was read."""
    problems = []
    for axis in axes:
        if axis_column(axis) not in sheet.header:
            strange = [n for n in sheet.header if n not in file_columns()]
            hint = "".join(in_other_unit(n, [axis_column(axis)]) for n in strange)
            hint = hint or misspelt(axis_column(axis), strange)
            problems.append(
                f"{sheet.head}: the column {axis_column(axis)} is missing.{hint} The machine has the axes {' '.join(axes)}"
            )
    numbers, labels = _split_columns(sheet, problems)
    problems += _wrong_senses(sheet, numbers)
    if problems:
        raise DataError(problems)
    taken = {a: numbers.pop(axis_column(a)) for a in axes}
    position = {a: q * DEG if is_rotary(a) else q for a, q in taken.items()}
    offset = np.zeros((sheet.count, 3))
    for i, c in enumerate("xyz"):
        if f"offset_{c}_mm" in numbers:
            offset[:, i] = numbers.pop(f"offset_{c}_mm")
    others = {n: v for n, v in numbers.items() if n not in {axis_column(a) for a in axes_of(numbers)}}
    return Run(position, offset, canonical_columns(others), labels)


def in_other_unit(name: str, names: Iterable[str]) -> str:
    """Return ' Convert the values of C_rad ...' where a column differs from a known one in its unit alone (another name keeps the
    numbers), else ''."""
    what, _, unit = name.rpartition("_")
    for other in names:
        same, _, due = other.rpartition("_")
        if (
            what
            and same == what
            and unit in UNITS
            and due in UNITS
            and UNITS[unit][1] == UNITS[due][1]
            and unit != due
        ):
            factor = UNITS[unit][0] / UNITS[due][0]
            return (
                f" Convert the values of {name} (1 {unit} = {factor:.10g} {due}) and name the column {other}."
            )
    return ""


def _wrong_senses(sheet: Sheet, numbers: dict[str, Array]) -> list[str]:
    """Return a problem for every cell of a sense that is no direction, with its line."""
    return [
        f"{sheet.at(int(i))}: {name} = {values[i]:g}; the direction in which the axis last moved is -1 or 1, and 0 where it is "
        "not known"
        for name, values in numbers.items()
        if name.startswith("sense_")
        for i in np.flatnonzero(~np.isin(values, (-1.0, 0.0, 1.0)))
    ]


def axis_column(axis: str) -> str:
    """Return the column of an axis: X -> X_mm, C -> C_deg, A1 -> A1_deg."""
    return f"{axis}_deg" if is_rotary(axis) else f"{axis}_mm"


def axes_of(header: Iterable[str]) -> list[str]:
    """Return the axes whose positions are in a header, in order."""
    words = {name.rpartition("_")[0] for name in header}
    return in_order(a for a in words if is_axis(a) and axis_column(a) in header)


def _without_number(name: str) -> str:
    """Return the column of the axis without a number: sense_A1 -> sense_A, C2_deg -> C_deg; head_A1_deg does not change."""
    return re.sub(r"(?<!head_)(?<![A-Za-z])([ABC])[1-9]\d?(?=_|$)", r"\1", name)


def canonical_columns(numbers: dict[str, Array]) -> dict[str, Array]:
    """Convert angles to rad: probe_angle_deg -> probe_angle_rad; everything else is canonical already."""
    out = {}
    for name, values in numbers.items():
        out[f"{name[:-4]}_rad" if name.endswith("_deg") else name] = (
            values * DEG if name.endswith("_deg") else values
        )
    return out


def file_columns() -> list[str]:
    """Return every numeric column that a file may have, spelled out; effects add those they need."""
    names = [axis_column(a) for a in LETTERS] + list(_SINGLE)
    names += [text.format(a) for text in _BY_AXIS for a in LETTERS]
    names += [text.format(a) for text in _BY_ROTARY for a in ROTARY]
    names += [text.format(c) for text in _BY_DIRECTION for c in "xyz"]
    names += [f"reading_{n.removeprefix('temp_')}" for n in _SINGLE if n.startswith("temp_")]
    needed = [
        column
        for effect in ALL
        for column in effect.needs
        if "{" not in column and not column.endswith("_rad")
    ]
    return list(dict.fromkeys([*names, *needed]))


def run_columns() -> list[str]:
    """Return the same columns as a Run names them (angles in rad), without the axis positions."""
    names = [n for n in file_columns() if n not in {axis_column(a) for a in LETTERS}]
    return [f"{n[:-4]}_rad" if n.endswith("_deg") else n for n in names]


def known_column(name: str, names: list[str]) -> bool:
    """Return whether a column may be in a file: by its name, any temp_<name>_C, or u_<column> of a known column."""
    if name in names or _without_number(name) in names or re.fullmatch(r"temp_\w+_C", name):
        return True
    return name.startswith("u_") and known_column(name[2:], names)


def check_channel(name: str) -> None:
    """Raises UsageError with the closest name when no run can have such a column."""
    columns = run_columns()
    if not known_column(name, columns):
        raise UsageError(
            f'channel = "{name}" is no column of a run.{did_you_mean(name, columns)} Write for example channel = "temp_part_C"'
        )


def conditions_of(
    sheet: Sheet,
    used: Collection[str],
    is_known: Callable[[str], bool],
    unknown: Callable[[str], str],
    problems: list[str],
) -> tuple[dict[str, Array], dict[str, np.ndarray]]:
    """Return numbers and labels of every column but those that a reader takes itself (`used`).

    unknown: text of the message for a heading that is neither a label nor known, after its name.
    """
    numbers: dict[str, Array] = {}
    labels: dict[str, np.ndarray] = {}
    for name in sheet.header:
        if name in used:
            continue
        if name in LABELS:
            labels[name] = sheet.texts(name)
        elif not is_known(name):
            problems.append(f'{sheet.head}: unknown column "{name}"{unknown(name)}')
        else:
            try:
                numbers[name] = sheet.numbers(name)
            except DataError as error:
                problems.extend(error.problems)
    return numbers, labels


def _split_columns(sheet: Sheet, problems: list[str]) -> tuple[dict[str, Array], dict[str, np.ndarray]]:
    columns = file_columns()
    return conditions_of(
        sheet,
        (),
        lambda name: known_column(name, columns),
        lambda name: (
            f".{in_other_unit(name, columns) or did_you_mean(name, [*columns, *LABELS])} Names state their unit, as in X_mm, C_deg, offset_z_mm, temp_part_C, "
            "speed_X_mm_s"
        ),
        problems,
    )
