"""CSV files of positions and recordings: header names with units to canonical columns of a Run."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vcmm.core.axes import LETTERS, ROTARY, in_order, is_axis, is_rotary
from vcmm.core.errors import DataError, UsageError, did_you_mean
from vcmm.core.run import OFFSET_LABEL, Array, Run
from vcmm.core.text import LARGEST, brief, is_usual, lines_of, read_text, to_number, unescape_cell
from vcmm.core.units import ABSOLUTE_ZERO
from vcmm.files.problems import misspelt
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
BLANK = ("", "nan", "na", "n/a")
POINT = "; decimals take a point"
FEW = 5  # cells that are named one by one
DEAD = 0.5  # share of cells without a number from which it is the column that is wrong, and not the rows
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


@dataclass(frozen=True)
class Sheet:
    """A CSV file: header, rows of cells, and the line of the header and of every row."""

    path: Path
    header: list[str]
    rows: list[list[str]]
    header_line: int
    lines: list[int]

    def at(self, row: int) -> str:
        """'front.csv:12', the place of a row (0 = first)."""
        return f"{self.path}:{self.lines[row]}"

    @property
    def count(self) -> int:
        """Number of rows."""
        return len(self.rows)

    def texts(self, name: str) -> np.ndarray:
        """One column (n,) as text."""
        i = self.header.index(name)
        return np.array([row[i] for row in self.rows], dtype=np.str_)

    def blanks(self, name: str) -> np.ndarray:
        """(n,) bool: cells of one column that hold nothing."""
        i = self.header.index(name)
        return np.array([is_blank(row[i]) for row in self.rows], dtype=bool)

    def take(self, rows: np.ndarray) -> Sheet:
        """The same with some of the rows, by number."""
        return replace(self, rows=[self.rows[k] for k in rows], lines=[self.lines[k] for k in rows])

    def without(self, name: str) -> Sheet:
        """The same without one column."""
        i = self.header.index(name)
        rows = [row[:i] + row[i + 1 :] for row in self.rows]
        return replace(self, header=[n for n in self.header if n != name], rows=rows)

    def with_numbers(self, name: str, rows: np.ndarray, new: Array) -> Sheet:
        """The same with other numbers (n,) in some of the rows (n,) of one column."""
        i = self.header.index(name)
        cells = [
            [*row[:i], repr(float(new[k])), *row[i + 1 :]] if rows[k] else row
            for k, row in enumerate(self.rows)
        ]
        return replace(self, rows=cells)

    def numbers(self, name: str) -> Array:
        """One column (n,). Raises DataError naming every cell that is no finite number."""
        i = self.header.index(name)
        out, problems = np.zeros(len(self.rows)), []
        for j, row in enumerate(self.rows):
            try:
                out[j] = to_number(row[i])
            except ValueError:
                problems.append(
                    f'{self.at(j)}: "{brief(row[i])}" in column {name} is not a number{instead(row[i], name)}'
                )
                continue
            if not is_usual(out[j]):
                what = f"beyond {LARGEST:g}" if np.isfinite(out[j]) else "not finite"
                problems.append(
                    f'{self.at(j)}: "{brief(row[i])}" in column {name} is {what}; remove or repair the row'
                )
            elif out[j] < ABSOLUTE_ZERO and is_temperature(name):
                problems.append(
                    f"{self.at(j)}: {row[i]} degC in column {name} is below absolute zero; repair the row"
                )
        if len(problems) > max(DEAD * len(self.rows), FEW):
            problems = [self._many(name, problems)]
        if problems:
            raise DataError(problems)
        return out

    def _many(self, name: str, problems: list[str]) -> str:
        """One sentence of a column of which many cells are wrong; a decimal comma is told."""
        share = f"{len(problems)} of {len(self.rows)} rows"
        if problems[0].endswith(POINT):
            return f"{problems[0]} ({share} of this column are so)"
        return (
            f"{self.path}:{self.header_line}: {name} is no finite number in {share}: repair the column, or remove it "
            "(what depends on it is then not testable), not the rows"
        )


def is_blank(cell: str) -> bool:
    """Whether a cell holds nothing: empty, or one of the words that programs write for it."""
    return cell.strip().lower() in BLANK


def is_temperature(name: str) -> bool:
    """Whether a column holds temperatures, no difference of them."""
    return name.startswith(("temp_", "reading_")) and name.endswith("_C") and "gradient" not in name


def instead(cell: str, name: str) -> str:
    """What to write, where that can be told."""
    if name.startswith("sense_"):
        return "; write 1 where the axis last moved up, -1 where it moved down, 0 where that is not known"
    return POINT if re.fullmatch(r"[-+]?\d+,\d+", cell) else ""


def read_csv(path: str | Path) -> Sheet:
    """Header and rows of a CSV file (comma, semicolon or tab). Raises DataError with the line of a ragged row."""
    path = Path(path)
    lines = [(i, line) for i, line in enumerate(lines_of(read_text(path)), 1)]
    lines = [(i, line) for i, line in lines if line.strip() and not line.lstrip().startswith("#")]
    if not lines:
        raise DataError(
            f"{path}:1: the file is empty; its first line names the columns, for example X_mm,Y_mm,Z_mm"
        )
    header, delimiter, header_line = header_of(path, lines[0])
    table, numbers = cells_of(path, lines, delimiter)
    problems = row_problems(path, header, table[1:], numbers[1:])
    if len(table) == 1:
        problems.append(f"{path}:{header_line}: there are no rows below the header; add one row per point")
    if problems:
        raise DataError(problems)
    return Sheet(path, header, table[1:], header_line, numbers[1:])


def header_of(path: Path, first: tuple[int, str]) -> tuple[list[str], str, int]:
    """Names of the columns, what separates them, and their line. Raises DataError for a name that stands twice."""
    delimiter = max(",;\t", key=first[1].count)
    (header,), (line,) = cells_of(path, [first], delimiter)
    repeated = {name for name in header if header.count(name) > 1}
    if repeated:
        raise DataError(f'{path}:{line}: the column "{name}" is named twice; keep one' for name in repeated)
    return header, delimiter, line


def row_problems(path: Path, header: list[str], rows: list[list[str]], lines: list[int]) -> list[str]:
    """Rows of another length than the header."""
    ragged = [(line, len(row)) for line, row in zip(lines, rows) if len(row) != len(header)]
    told = [f"{path}:{line}: {cells} cells where the header names {len(header)}" for line, cells in ragged]
    if 1 < len(rows) == len(ragged) and min(cells for _, cells in ragged) > len(header):
        return [f"{told[0]}, and so in all {len(rows)} rows{POINT}, and commas only separate the columns"]
    return told


def cells_of(path: Path, lines: list[tuple[int, str]], delimiter: str) -> tuple[list[list[str]], list[int]]:
    """Rows of cells and the line on which each begins. Raises DataError where a quotation mark is not closed."""
    reader = csv.reader([text + "\n" for _, text in lines], delimiter=delimiter, strict=True)
    table: list[list[str]] = []
    numbers: list[int] = []
    while True:
        line = lines[min(reader.line_num, len(lines) - 1)][0]
        try:
            table.append([unescape_cell(cell.strip()) for cell in next(reader)])
        except StopIteration:
            return table, numbers
        except csv.Error as error:
            why = str(error)
            if "field larger" in why:
                raise DataError(
                    f"{path}:{line}: a cell of more than {csv.field_size_limit():,} characters; shorten it"
                ) from None
            raise DataError(
                f'{path}:{line}: the quotation marks of this row do not match ({why}); write each " in a text twice'
            ) from None
        numbers.append(line)


def read_positions(path: str | Path, axes: tuple[str, ...]) -> Run:
    """Positions (X_mm ... C_deg) and tip offsets (offset_x_mm ...) to a Run; every axis must have its column.

    All columns of a recording are read. Raises DataError with every problem: column, line and fix.
    """
    return positions_of(read_csv(path), axes)


def positions_of(sheet: Sheet, axes: tuple[str, ...]) -> Run:
    """The same of a table that was read."""
    problems = []
    for axis in axes:
        if axis_column(axis) not in sheet.header:
            hint = misspelt(axis_column(axis), [n for n in sheet.header if n not in file_columns()])
            problems.append(
                f"{sheet.path}:{sheet.header_line}: the column {axis_column(axis)} is missing.{hint} The machine has the axes {' '.join(axes)}"
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


def _wrong_senses(sheet: Sheet, numbers: dict[str, Array]) -> list[str]:
    """Every cell of a sense that is no direction, with its line."""
    return [
        f"{sheet.at(int(i))}: {name} = {values[i]:g}; the direction in which the axis last moved is -1 or 1, and 0 where it is "
        "not known"
        for name, values in numbers.items()
        if name.startswith("sense_")
        for i in np.flatnonzero(~np.isin(values, (-1.0, 0.0, 1.0)))
    ]


def axis_column(axis: str) -> str:
    """X -> X_mm, C -> C_deg, A1 -> A1_deg."""
    return f"{axis}_deg" if is_rotary(axis) else f"{axis}_mm"


def axes_of(header: Iterable[str]) -> list[str]:
    """The axes whose positions stand in a header, in order."""
    words = {name.rpartition("_")[0] for name in header}
    return in_order(a for a in words if is_axis(a) and axis_column(a) in header)


def _without_number(name: str) -> str:
    """sense_A1 -> sense_A, C2_deg -> C_deg: the column of the axis without a number; head_A1_deg stays as it is."""
    return re.sub(r"(?<!head_)(?<![A-Za-z])([ABC])[1-9]\d?(?=_|$)", r"\1", name)


def canonical_columns(numbers: dict[str, Array]) -> dict[str, Array]:
    """Angles to rad: probe_angle_deg -> probe_angle_rad; everything else is canonical already."""
    out = {}
    for name, values in numbers.items():
        out[f"{name[:-4]}_rad" if name.endswith("_deg") else name] = (
            values * DEG if name.endswith("_deg") else values
        )
    return out


def file_columns() -> list[str]:
    """Every numeric column that a file may have, spelled out; effects add those they ask for."""
    names = [axis_column(a) for a in LETTERS] + list(_SINGLE)
    names += [text.format(a) for text in _BY_AXIS for a in LETTERS]
    names += [text.format(a) for text in _BY_ROTARY for a in ROTARY]
    names += [text.format(c) for text in _BY_DIRECTION for c in "xyz"]
    names += [f"reading_{n.removeprefix('temp_')}" for n in _SINGLE if n.startswith("temp_")]
    asked = [
        column
        for effect in ALL
        for column in effect.needs
        if "{" not in column and not column.endswith("_rad")
    ]
    return list(dict.fromkeys([*names, *asked]))


def run_columns() -> list[str]:
    """The same columns as a Run names them (angles in rad), without the axis positions."""
    names = [n for n in file_columns() if n not in {axis_column(a) for a in LETTERS}]
    return [f"{n[:-4]}_rad" if n.endswith("_deg") else n for n in names]


def known_column(name: str, known: list[str]) -> bool:
    """Whether a column may stand in a file: by its name, any temp_<name>_C, or u_<column> of a known column."""
    if name in known or _without_number(name) in known or re.fullmatch(r"temp_\w+_C", name):
        return True
    return name.startswith("u_") and known_column(name[2:], known)


def check_channel(name: str) -> None:
    """Raises UsageError with the closest name when no run can have such a column."""
    known = run_columns()
    if not known_column(name, known):
        raise UsageError(
            f'channel = "{name}" is no column of a run.{did_you_mean(name, known)} Write for example channel = "temp_part_C"'
        )


def _split_columns(sheet: Sheet, problems: list[str]) -> tuple[dict[str, Array], dict[str, np.ndarray]]:
    numbers: dict[str, Array] = {}
    labels: dict[str, np.ndarray] = {}
    known = file_columns()
    for name in sheet.header:
        if name in LABELS:
            labels[name] = sheet.texts(name)
        elif not known_column(name, known):
            hint = did_you_mean(name, [*known, *LABELS])
            problems.append(
                f'{sheet.path}:{sheet.header_line}: unknown column "{name}".{hint} Names state their unit, as in '
                "X_mm, C_deg, offset_z_mm, temp_part_C, speed_X_mm_s"
            )
        else:
            try:
                numbers[name] = sheet.numbers(name)
            except DataError as error:
                problems.extend(error.problems)
    return numbers, labels
