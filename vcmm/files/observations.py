"""The CSV of a recording: columns of positions, observations and conditions to a Recording.

Units stand in the names (um to mm, deg and urad to rad). Values that follow from the rows are filled in: the second end of
a length as a run row of its own, the lateral share of the normal, the measured length.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.axes import is_rotary, unit_vector
from vcmm.core.errors import DataError, ModelLimit
from vcmm.core.kinematics import CHUNK, Motion, nominal_tip, tip_motion
from vcmm.core.machine import Machine
from vcmm.core.reach import linear_positions
from vcmm.core.run import Array, Run
from vcmm.files.columns import axes_of, axis_column, positions_of
from vcmm.files.gaps import fill_gaps, note_gaps
from vcmm.files.large_tables import read_table
from vcmm.files.sheets import Sheet
from vcmm.task.response.pointing import POINTING_COLUMNS, pointing_observations
from vcmm.task.response.recording import Ints, Recording

VECTOR = ("dx_um", "dy_um", "dz_um")
OBSERVED_COLUMNS = ("d_um", "d_urad", *VECTOR)
NORMAL = ("nx", "ny", "nz")
FROM = ("from_x_mm", "from_y_mm", "from_z_mm")
UNIT_TOLERANCE = 0.01  # a normal written with two decimals is still one


@dataclass(frozen=True)
class Sense:
    """Statements of the recording file about the data: kind, indicated - true or not, whether lengths end at a station."""

    kind: str
    measuring: bool
    fixed_end: bool = False


def read_observations(path: Path, machine: Machine | None, sense: Sense, name: str = "") -> Recording | None:
    """Read the table of a recording (CSV, Parquet); None where the machine is not known, after the file itself was checked.

    Raises DataError with every problem: column, line and fix.
    """
    sheet, gaps = fill_gaps(read_table(path))
    letters = tuple(axes_of(sheet.header))
    problems = _header_problems(sheet, sense)
    run = None
    try:
        run = positions_of(sheet, letters if machine is None else machine.chain.letters)
    except DataError as error:
        problems = [*error.problems, *problems]
    if run is not None:
        run = _with_unit_normals(run, sheet, problems)
        _check_other_axes(sheet, run, problems)
        _check_uncertainties(sheet, run, problems)
    if problems:
        raise DataError(problems)
    if run is None or machine is None:
        return None
    return note_gaps(_recording(run, machine, sense, name, sheet), gaps)


def _header_problems(sheet: Sheet, sense: Sense) -> list[str]:
    at, have = sheet.head, set(sheet.header)
    due = "d_urad" if sense.kind == "angle" else "d_um"
    headings = [c for c in OBSERVED_COLUMNS if c in have]
    out = []
    pointed = set(POINTING_COLUMNS) <= have
    if pointed and sense.kind != "angle":
        out.append(f'{at}: pointed_x ... is a direction; write kind = "angle" or remove these columns')
    for columns in (NORMAL, FROM, POINTING_COLUMNS):
        lacking = [c for c in columns if c not in have]
        if 0 < len(lacking) < 3:
            out.append(f"{at}: {' '.join(columns)} go together; {' '.join(lacking)} is missing")
    if sense.kind != "length" and have & set(FROM):
        out.append(
            f'{at}: from_x_mm ... is the second end of a length; write kind = "length" or remove these columns'
        )
    if sense.kind == "angle" and "u_um" in have:
        out.append(f"{at}: u_um is a length; the uncertainty of an angle is u_d_urad")
    if pointed and headings:
        out.append(f"{at}: {' '.join(headings)} and pointed_x ... are both observations; keep one of them")
    elif pointed:
        return out
    if not headings:
        or_vector = " (or pointed_x pointed_y pointed_z)" if sense.kind == "angle" else ""
        or_vector = or_vector if sense.kind in ("angle", "length") else " (or dx_um dy_um dz_um)"
        out.append(f"{at}: there is no observation; add the column {due}{or_vector}")
    wrong = [c for c in headings if (c == "d_urad") != (sense.kind == "angle")]
    wrong += [c for c in headings if c in VECTOR and sense.kind == "length"]
    if wrong:
        out.append(f'{at}: {" ".join(wrong)} does not go with kind = "{sense.kind}", which takes {due}')
    elif len(headings) > 1 and due in headings:
        out.append(
            f"{at}: {due} and {' '.join(c for c in headings if c != due)} are both there; keep one of them"
        )
    elif due in headings and not have & set(NORMAL) and not (sense.kind == "length" and have & set(FROM)):
        ends = ", or the second end from_x_mm from_y_mm from_z_mm" if sense.kind == "length" else ""
        out.append(f"{at}: {due} needs its direction nx ny nz{ends}")
    return out


def _with_unit_normals(run: Run, sheet: Sheet, problems: list[str]) -> Run:
    if not all(c in run.columns for c in NORMAL):
        return run
    normal = run.normal
    size = np.linalg.norm(normal, axis=1)
    for i in np.flatnonzero(np.abs(size - 1.0) > UNIT_TOLERANCE):
        problems.append(f"{sheet.at(int(i))}: nx ny nz has the length {size[i]:.4g}; give a unit vector")
    unit = normal / np.where(size > 0, size, 1.0)[:, None]
    return run.with_columns({c: unit[:, i] for i, c in enumerate(NORMAL)})


def _check_other_axes(sheet: Sheet, run: Run, problems: list[str]) -> None:
    """Check that positions of axes that the machine lacks are zero, since they would be dropped."""
    for letter in axes_of(sheet.header):
        column = axis_column(letter)
        if letter not in run.position:
            moved = np.flatnonzero(sheet.numbers(column))
            if len(moved):
                problems.append(
                    f"{sheet.at(int(moved[0]))}: {column} is not zero, but the machine has no axis {letter}; "
                    "name the right machine or remove the column"
                )


def _check_uncertainties(sheet: Sheet, run: Run, problems: list[str]) -> None:
    for column in ("u_um", *(f"u_{c}" for c in OBSERVED_COLUMNS)):
        for i in np.flatnonzero(run.columns.get(column, np.ones(1)) <= 0):
            problems.append(
                f"{sheet.at(int(i))}: {column} must be above zero; leave the column out if it is not known"
            )


def _recording(run: Run, machine: Machine, sense: Sense, name: str, sheet: Sheet) -> Recording:
    if POINTING_COLUMNS[0] in run.columns:
        value, row, direction, u = _pointing_rows(run, machine, sense, sheet)
    else:
        value, row, direction, u = _observations(run, sense.kind)
    other = np.full(len(value), -1, dtype=np.intp)
    run = with_lateral_share(_without_observations(run), machine, sense.kind)
    if sense.kind == "length" and FROM[0] in run.columns:
        run, direction, ends = _second_ends(run, machine, sense, sheet)
        other = ends if ends is not None else other
    lines = np.asarray(sheet.lines, dtype=np.intp)
    return Recording(
        name,
        sense.kind,
        run,
        value=value,
        measuring=sense.measuring,
        row=row,
        direction=direction,
        other=other,
        u=u,
        lines=lines,
    )


def _pointing_rows(
    run: Run, machine: Machine, sense: Sense, sheet: Sheet
) -> tuple[Array, Ints, Array, Array | None]:
    """Return two small rotations per pointed direction (see vcmm.task.response.pointing)."""
    size = np.linalg.norm(run.vector(*POINTING_COLUMNS), axis=1)
    wrong = np.flatnonzero(np.abs(size - 1.0) > UNIT_TOLERANCE)
    if len(wrong):
        at = sheet.at(int(wrong[0]))
        raise DataError(f"{at}: pointed_x ... has the length {size[wrong[0]]:.4g}; give a unit vector")
    value, direction = pointing_observations(run, machine, -1.0 if sense.measuring else 1.0)
    u = run.columns.get("u_d_urad")
    return value, np.repeat(np.arange(run.n), 2), direction, None if u is None else np.repeat(u * 1e-6, 2)


def _observations(run: Run, kind: str) -> tuple[Array, Ints, Array, Array | None]:
    """Return value (m,), row (m,), direction (m, 3), u (m,) or None, in mm or rad."""
    columns = run.columns
    if "d_um" in columns or "d_urad" in columns:
        name, scale = ("d_urad", 1e-6) if kind == "angle" else ("d_um", 1e-3)
        direction = run.normal if all(c in columns for c in NORMAL) else np.tile([1.0, 0.0, 0.0], (run.n, 1))
        u = columns.get(f"u_{name}", None if kind == "angle" else columns.get("u_um"))
        return columns[name] * scale, np.arange(run.n), direction, None if u is None else u * scale
    names = [c for c in VECTOR if c in columns]
    value = run.vector(*names).ravel() * 1e-3
    direction = np.tile(np.eye(3)[[VECTOR.index(c) for c in names]], (run.n, 1))
    spread = [columns.get(f"u_{c}", columns.get("u_um")) for c in names]
    u = None if any(s is None for s in spread) else np.stack(spread, axis=1).ravel() * 1e-3  # type: ignore[arg-type]
    return value, np.repeat(np.arange(run.n), len(names)), direction, u


def _without_observations(run: Run) -> Run:
    gone = {"u_um", *OBSERVED_COLUMNS, *(f"u_{c}" for c in OBSERVED_COLUMNS)}
    kept = {name: values for name, values in run.columns.items() if name not in gone}
    return Run(run.position, run.offset, kept, run.labels, run.series)


def with_lateral_share(run: Run, machine: Machine, kind: str) -> Run:
    """Add probe_lateral, the share of the normal across the stylus: sqrt(1 - (n . stylus)^2); the stylus lies along offset.

    Without an offset the stylus is along Z of the last tool-side frame. Where every stylus is stated and lies along z,
    probe_angle_rad follows from the normals too, where it is not given: atan2(n_y, n_x).
    """
    cut = kind == "path" and "cut_length_mm" in run.columns  # a tool made it, no stylus
    if cut or "probe_lateral" in run.columns or not all(c in run.columns for c in NORMAL):
        return run
    lateral, stands = np.empty(run.n), True
    for i in range(0, run.n, CHUNK):
        rows = slice(i, i + CHUNK)
        lateral[rows], upright = _lateral_share(run.take(rows), machine)
        stands &= upright
    columns = {"probe_lateral": lateral}
    fixed = not any(machine.axes[a].rotary for a in machine.chain.tool if a in machine.axes)
    if "probe_angle_rad" not in run.columns and kind == "probe" and fixed and stands:
        columns["probe_angle_rad"] = np.arctan2(run.columns["ny"], run.columns["nx"])
    return run.with_columns(columns)


def _lateral_share(run: Run, machine: Machine) -> tuple[Array, bool]:
    """Return probe_lateral (n,), and whether every stylus is stated and lies along z."""
    long = np.linalg.norm(run.offset, axis=1) > 0
    along = np.where(long[:, None], run.offset, [0.0, 0.0, -1.0])
    chain, axes = machine.chain, machine.axes
    ends = (nominal_tip(chain, axes, Run(run.position, o)) for o in (along, np.zeros_like(along)))
    stylus = next(ends) - next(ends)
    share = (run.normal * stylus).sum(axis=1) / np.linalg.norm(stylus, axis=1)
    upright = np.abs(stylus[:, 2]) >= (1.0 - 1e-6) * np.linalg.norm(stylus, axis=1)
    return np.sqrt(np.maximum(0.0, 1.0 - share**2)), bool(long.all() and upright.all())


def _tip(run: Run, machine: Machine) -> Array:
    if "tip_x_mm" in run.columns:
        return run.tip
    return nominal_tip(machine.chain, machine.axes, run)


def _second_ends(run: Run, machine: Machine, sense: Sense, sheet: Sheet) -> tuple[Run, Array, Ints | None]:
    """Return the run with the second ends as further rows, the directions (n, 3) of the lengths, and the rows of the ends.

    from_x_mm ... is the place of the tip at the second end, workpiece axes; at a fixed station it has no row.
    """
    start = run.vector(*FROM)
    way = _tip(run, machine) - start
    length = np.linalg.norm(way, axis=1)
    short = np.flatnonzero(length < 1e-6)
    if len(short):
        raise DataError(
            f"{sheet.at(int(short[0]))}: both ends of the length are one place; check from_x_mm ..."
        )
    run = run.with_columns({"length_mm": length})
    direction = way / length[:, None]
    if sense.fixed_end:
        return run, direction, None
    try:
        position = linear_positions(machine, run, start)
    except ModelLimit as error:
        raise DataError(f"{sheet.head}: from_x_mm ...: {error}") from None
    twice = np.tile(np.arange(run.n), 2)
    both = run.take(twice)
    position = {a: np.concatenate([q, position[a]]) for a, q in run.position.items()}
    columns = dict(both.columns)
    if "tip_x_mm" in columns:
        columns |= {f"tip_{c}_mm": np.concatenate([run.tip[:, i], start[:, i]]) for i, c in enumerate("xyz")}
    return Run(position, both.offset, columns, both.labels, run.series), direction, run.n + np.arange(run.n)


def axis_direction(machine: Machine, run: Run, axis: str) -> Array:
    """Return the unit direction (n, 3) in which the tip goes, seen from the workpiece, when a linear axis is commanded forward; for a rotary
    axis the axis about which the tool turns.
    """
    if is_rotary(axis):
        turn = np.tile(np.concatenate([np.zeros(3), unit_vector(axis)]), (run.n, 1))
        return tip_motion(machine.chain, machine.axes, run, [Motion(axis, "motion", turn)])[:, 3:]
    chain, axes = machine.chain, machine.axes
    there = Run({**run.position, axis: run.q(axis) + 1.0}, run.offset)
    return nominal_tip(chain, axes, there) - nominal_tip(chain, axes, Run(run.position, run.offset))
