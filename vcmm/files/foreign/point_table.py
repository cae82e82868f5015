"""Point tables of a CMM: nominal and measured points (`feature, x, y, z, i, j, k` and measured x, y, z), in mm.

    nominal    x y z, normal i j k       measured   mx my mz, or dx dy dz as measured - nominal

Spellings such as nom_x, meas_x, x_meas, actual_x, X [mm] are accepted. Points are in the frame of the part, corrected
for the tip radius; `[pose]` of the recording says where the part lay, `[stylus]` with what it was measured. A point
with a normal is known along it only (the tip slides along the surface); a point without one, such as the centre of a
hole, in all directions that the table has.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError, did_you_mean
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array, Run
from vcmm.core.text import lines_of, read_text
from vcmm.files.columns import LABELS, conditions_of, file_columns
from vcmm.files.observations import with_lateral_share
from vcmm.files.sheets import Layout, Sheet, read_csv
from vcmm.task.measuring.plan import axis_positions
from vcmm.task.response.recording import Recording

MEASURED_NAMES = ("m", "meas", "measured", "act", "actual", "ist")
NOMINAL = ("", "n", "nom", "nominal", "soll")
DEVIATION = ("d", "dev", "err", "error")
OF_FEATURE = ("d", "dia", "diam", "diameter", "r", "radius", "round", "roundness", "form", "cylindricity")
ROUNDING = 2.1e-3  # mm: three numbers, each rounded to 1 um, and one printed step
NORMAL = {"i": 0, "j": 1, "k": 2, "nx": 0, "ny": 1, "nz": 2}
NAMES = Layout(r"\s{2,}|\t")  # of a printed list
_NAME = re.compile(r"(?P<before>[a-z]*?)_?(?P<axis>[xyz])_?(?P<after>[a-z]*)")


def canonical(name: str) -> str:
    """Return the canonical name: 'Meas X [mm]' -> 'mx', 'nom_y' -> 'y', 'x_dev' -> 'dx', 'I' -> 'i'; '' for any other name."""
    plain = re.sub(r"[\[(]\s*mm\s*[\])]|_mm$", "", name.strip().lower()).strip().replace(" ", "_")
    if plain in NORMAL:
        return "ijk"[NORMAL[plain]]
    match = _NAME.fullmatch(plain)
    if not match or (match["before"] and match["after"]):
        return ""
    word = match["before"] or match["after"]
    for prefix, words in (("m", MEASURED_NAMES), ("", NOMINAL), ("d", DEVIATION)):
        if word in words:
            return prefix + match["axis"]
    return ""


def of_feature(name: str) -> bool:
    """Return whether a column describes the feature itself and not its place: 'Meas D', 'Nom D', 'Round', 'form'."""
    words = re.split(r"[\s_]+", re.sub(r"[\[(].*[\])]", "", name.strip().lower()))
    prefixes = {*MEASURED_NAMES, *NOMINAL, *DEVIATION} - {"d"}
    rest = [w for w in words if w and w not in prefixes]
    return len(rest) == 1 and rest[0] in OF_FEATURE


def read_list(path: Path) -> Sheet:
    """Read a table, or a printed list: lines of head, names two blanks apart, numbers in columns.

    Raises DataError with the line of a ragged row.
    """
    lines = lines_of(read_text(path))
    names = (row for row in NAMES.rows(lines) if sum(bool(canonical(c)) for c in NAMES.cells(row.text)) >= 2)
    head = next(names, None)
    if head is None or any(d in lines[head.line - 1] for d in ",;\t"):
        return read_csv(path)
    header, rows = NAMES.cells(head.text), list(Layout().rows(lines[head.line :], head.line + 1))
    problems = [
        f"{path}:{row.line}: {len(row.cells)} cells where line {head.line} names {len(header)}"
        for row in rows
        if len(row.cells) != len(header)
    ]
    if not rows:
        problems.append(f"{path}:{head.line}: there are no rows below the names; add one row per point")
    if problems:
        raise DataError(problems)
    return Sheet(path, header, [row.cells for row in rows], head.line, [row.line for row in rows])


def _drop_same(sheet: Sheet, table: dict[str, Array], problems: list[str]) -> None:
    """Drop the deviation where both measured value and deviation are there and agree to rounding."""
    for c in "xyz":
        if not {c, f"m{c}", f"d{c}"} <= set(table):
            continue
        stated = table.pop(f"d{c}")
        apart = np.abs(table[f"m{c}"] - table[c] - stated)
        wrong = np.flatnonzero(apart > ROUNDING)
        if len(wrong):
            i = int(wrong[0])
            problems.append(
                f"{sheet.at(i)}: deviation {c} = {stated[i]:g}, but measured - nominal is {table[f'm{c}'][i] - table[c][i]:.4g}; "
                f"correct one of them or remove the column ({len(wrong)} rows)"
            )


def read_points(
    path: str | Path,
    machine: Machine,
    pose: Pose,
    offset: Array,
    tip_radius: float,
    kind: str = "probe",
    measuring: bool = True,
) -> Recording:
    """Read a point table. pose: machine_from_part; offset (3,) mm of the tip; tip_radius mm; rotary axes at zero.

    measuring: the part is known to be as nominal and the CMM is examined (indicated - true); False: the CMM is
    believed and the machine that made the part is examined (actual - commanded).
    Raises DataError with every problem: column, line and fix.
    """
    sheet = read_list(Path(path))
    problems: list[str] = []
    table, columns, labels = _columns(sheet, problems)
    _drop_same(sheet, table, problems)
    _check_complete(sheet, table, problems)
    if problems:
        raise DataError(problems)
    n = len(sheet.rows)
    nominal = np.stack([table.get(c, np.zeros(n)) for c in "xyz"], axis=1)
    normal = _unit_normals(sheet, table)
    coordinates = [i for i, c in enumerate("xyz") if f"m{c}" in table or f"d{c}" in table]
    error = np.zeros((n, 3))
    for i in coordinates:
        c = "xyz"[i]
        error[:, i] = table[f"d{c}"] if f"d{c}" in table else table[f"m{c}"] - nominal[:, i]
    run = _run(machine, pose, nominal, normal, offset, tip_radius)
    run = with_lateral_share(Run(run.position, run.offset, {**run.columns, **columns}, labels), machine, kind)
    if normal is not None:
        value, row, direction = (error * normal).sum(axis=1), np.arange(n), pose.turn(normal)
    else:
        value, row = error[:, coordinates].ravel(), np.repeat(np.arange(n), len(coordinates))
        direction = np.tile(pose.turn(np.eye(3)[coordinates]), (n, 1))
    return Recording(
        "",
        kind,
        run,
        value=value,
        measuring=measuring,
        row=row,
        direction=direction,
        other=np.full(len(value), -1, dtype=np.intp),
        lines=np.array(sheet.lines, dtype=np.intp),
    )


def _columns(
    sheet: Sheet, problems: list[str]
) -> tuple[dict[str, Array], dict[str, Array], dict[str, np.ndarray]]:
    """Return coordinates by canonical name, conditions, labels."""
    table: dict[str, Array] = {}
    allowed = [c for c in file_columns() if c == "time_s" or c.startswith("temp_")]
    for name in [n for n in sheet.header if n.lower() not in LABELS and canonical(n)]:
        short = canonical(name)
        if short in table:
            problems.append(
                f'{sheet.head}: "{name}" means {short}, which is there already; keep one of the two'
            )
        try:
            table[short] = sheet.numbers(name)
        except DataError as error:
            problems.extend(error.problems)
    used = [n for n in sheet.header if n.lower() not in LABELS and (canonical(n) or of_feature(n))]
    headings = [n.lower() if n.lower() in LABELS else n for n in sheet.header]
    columns, labels = conditions_of(
        replace(sheet, header=headings),
        used,
        allowed.__contains__,
        lambda name: (
            f" of a point table.{did_you_mean(name, ['feature', 'mx', 'my', 'mz', *allowed, *LABELS])}"
            " Columns: feature x y z i j k mx my mz"
        ),
        problems,
    )
    return table, columns, labels


def _check_complete(sheet: Sheet, table: dict[str, Array], problems: list[str]) -> None:
    at = sheet.head
    have_normal = [c for c in "ijk" if c in table]
    coordinates = [c for c in "xyz" if f"m{c}" in table or f"d{c}" in table]
    for c in "xyz":
        if c in coordinates and c not in table:
            problems.append(f"{at}: {c} is measured, but its nominal column {c} is missing")
    if not coordinates:
        problems.append(
            f"{at}: there are no measured columns; add mx my mz (or dx dy dz, measured - nominal)"
        )
    if have_normal and len(have_normal) < 3:
        problems.append(f"{at}: the normal i j k is complete or absent; found {' '.join(have_normal)}")
    if have_normal and 0 < len(coordinates) < 3:
        problems.append(f"{at}: along a normal all of x y z must be measured; found {' '.join(coordinates)}")


def _unit_normals(sheet: Sheet, table: dict[str, Array]) -> Array | None:
    if "i" not in table:
        return None
    normal = np.stack([table[c] for c in "ijk"], axis=1)
    size = np.linalg.norm(normal, axis=1)
    bad = np.flatnonzero(np.abs(size - 1.0) > 0.01)
    if len(bad):
        raise DataError(
            [f"{sheet.at(int(i))}: i j k has the length {size[i]:.4g}; give a unit vector" for i in bad]
        )
    return np.asarray(normal / size[:, None])


def _run(
    machine: Machine, pose: Pose, nominal: Array, normal: Array | None, offset: Array, tip_radius: float
) -> Run:
    """Return the positions of the axes at each point: the tip centre one radius off the surface."""
    in_machine = pose.apply(nominal)
    turned = np.zeros_like(nominal) if normal is None else pose.turn(normal)
    offsets = np.tile(np.asarray(offset, dtype=float), (len(nominal), 1))
    position = axis_positions(machine.chain, machine.axes, in_machine + tip_radius * turned, offsets)
    columns = {f"part_{c}_mm": (in_machine - pose.shift)[:, i] for i, c in enumerate("xyz")}
    if normal is not None:
        columns |= {f"n{c}": turned[:, i] for i, c in enumerate("xyz")}
    return Run(position, offsets, columns)
