"""Pointing lists: actual directions of a tool on two rotary axes against the readings of its axes.

TPOINT lists (format "tpoint", equatorial mounts): free lines of head, the last of them latitude (d m s), date (y m d),
temperature (degC), pressure (hPa) ..., then rows of 14 numbers: right ascension (h m s) and declination (d m s) of the star,
those that the mount read, sidereal time (h m). The air lifts a star by 1.02' cot(h + 10.3 / (h + 5.11)) P / 1010 283 / (273 + T)
(Saemundsson, Sky and Telescope 72 (1986) 70). The list does not state its equinox: `equinox = "J2000"` precesses to its date
(Lieske et al., Astronomy and Astrophysics 58 (1977) 1).

Offsets of an altitude-azimuth head (format "altaz"): a table with az_deg, alt_deg as read and d_az_arcsec, d_alt_arcsec (or
_urad, _deg), true - read; azimuth from north through east.

Both give the readings of the two axes, first axis = -hour angle or -azimuth about z, second = -declination or -altitude, the tool
along x of the last frame, and the direction seen. z is the pole or the zenith, x the meridian on the equator or north.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import DataError, UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.core.text import lines_of, read_text
from vcmm.core.units import UNITS
from vcmm.files.columns import conditions_of, file_columns, known_column
from vcmm.files.sheets import Layout, SheetColumn, numbers_of, read_csv
from vcmm.task.response.pointing import POINTING_COLUMNS, pointing_observations, with_down
from vcmm.task.response.recording import Recording

NOMINAL_TOOL_MM = 1000.0  # mm: the tool has a direction and no length
AZIMUTH, ALTITUDE = (
    SheetColumn(name, units=("deg",), advice=", what the axis read") for name in ("az", "alt")
)
OFFSETS = tuple(
    SheetColumn(f"d_{name}", units=("arcsec", "urad", "deg"), advice=", true - read")
    for name in ("az", "alt")
)
EQUINOXES = ("date", "J2000")
ROW, HEAD = 14, 8  # numbers of a star; of the line of conditions


@dataclass(frozen=True, eq=False)
class Pointings:
    """n sightings. first, second (n,) rad: readings of the axes; directions (n, 3) unit; down (3,); columns and labels of the rows."""

    first: Array
    second: Array
    directions: Array
    down: Array
    columns: dict[str, Array]
    labels: dict[str, np.ndarray]
    lines: Array


def recording_of_pointings(pointings: Pointings, machine: Machine, measuring: bool) -> Recording:
    """Return sightings as a recording of angles. Raises UsageError where the machine has not two rotary axes on its tool side."""
    axes = [a for a in machine.chain.tool if is_rotary(a)]
    if len(axes) != 2:
        raise UsageError(
            f'a pointing list needs a machine of two rotary axes, structure = "w b C B t"; {machine.chain.structure} has '
            f"{len(axes)} on the side of its tool"
        )
    n = len(pointings.first)
    position = {a: np.zeros(n) for a in machine.chain.letters} | {
        axes[0]: pointings.first,
        axes[1]: pointings.second,
    }
    columns = {
        **pointings.columns,
        **{name: pointings.directions[:, i] for i, name in enumerate(POINTING_COLUMNS)},
    }
    run = with_down(
        Run(position, np.tile([NOMINAL_TOOL_MM, 0.0, 0.0], (n, 1)), columns, pointings.labels),
        machine,
        pointings.down,
    )
    value, direction = pointing_observations(run, machine, -1.0 if measuring else 1.0)
    return Recording(
        "",
        "angle",
        run,
        value=value,
        measuring=measuring,
        row=np.repeat(np.arange(n), 2),
        direction=direction,
        other=np.full(2 * n, -1, dtype=np.intp),
        lines=pointings.lines.astype(np.intp),
    )


def direction_of(longitude: Array, latitude: Array) -> Array:
    """Return the direction (n, 3) of hour angle and declination, or azimuth and altitude (rad): y is to the west."""
    across = np.cos(latitude)
    return np.stack([across * np.cos(longitude), -across * np.sin(longitude), np.sin(latitude)], axis=1)


def read_tpoint(path: str | Path, equinox: str = "date") -> Pointings:
    """Read a TPOINT list of an equatorial mount. Raises DataError with the line of what it cannot read."""
    path = Path(path)
    if equinox not in EQUINOXES:
        raise UsageError(f'equinox = "{equinox}"; allowed are {", ".join(EQUINOXES)}')
    lines = lines_of(read_text(path))
    rows = {
        row.line: row_numbers for row in Layout().rows(lines) if len(row_numbers := _numbers(row.text)) == ROW
    }
    if not rows:
        raise DataError(
            f"{path}:1: there is no row of {ROW} numbers: RA h m s, Dec d m s, both as read, sidereal time h m"
        )
    begin = min(rows)
    head = lines[: begin - 1]
    for i, line in enumerate(head, 1):
        if line.strip().upper() == ":ALTAZ":
            raise DataError(f'{path}:{i}: the mount is altitude-azimuth; give a table with format = "altaz"')
    stated = next((i for i in range(begin - 1, 0, -1) if len(_numbers(lines[i - 1])) >= HEAD), None)
    if stated is None:
        raise DataError(
            f"{path}:{begin}: no line above names latitude d m s, date y m d, temperature and pressure"
        )
    wrong = [
        i
        for i, line in enumerate(lines, 1)
        if i not in rows
        and ((i > begin and line.strip() not in ("", "END")) or (i > stated and len(line.split()) == ROW))
    ]
    if wrong:
        raise DataError([f"{path}:{i}: expected {ROW} numbers: {lines[i - 1].strip()[:60]}" for i in wrong])
    numbers = np.array(list(rows.values()))
    signs = np.array([_signs(lines[i - 1]) for i in rows])
    return _stars(numbers, signs, _numbers(lines[stated - 1]), head, equinox, np.array(list(rows)))


def _stars(
    numbers: Array, signs: Array, conditions: list[float], head: list[str], equinox: str, lines: Array
) -> Pointings:
    degrees = [signs[:, i] * _base60(numbers[:, 3 * i : 3 * i + 3]) for i in range(4)]
    ra, dec, read_ra, read_dec = (
        np.radians(d * (15.0 if i % 2 == 0 else 1.0)) for i, d in enumerate(degrees)
    )
    sidereal = np.radians(15.0 * (numbers[:, 12] + numbers[:, 13] / 60.0))
    if equinox == "J2000":
        ra, dec = precess(ra, dec, conditions[3] + (conditions[4] - 0.5) / 12.0)
    sign = (
        -1.0
        if next(line for line in reversed(head) if len(_numbers(line)) >= HEAD).lstrip().startswith("-")
        else 1.0
    )
    latitude = float(np.radians(sign * _base60(np.abs(np.array([conditions[:3]])))[0]))
    star = refract(direction_of(sidereal - ra, dec), latitude, conditions[6], conditions[7])
    first = np.mod(np.pi - sidereal + read_ra, 2 * np.pi) - np.pi
    down = np.array([-np.cos(latitude), 0.0, -np.sin(latitude)])
    return Pointings(first, -read_dec, directions=star, down=down, columns={}, labels={}, lines=lines)


def _numbers(line: str) -> list[float]:
    """Return the numbers of a line of nothing but finite numbers, else none."""
    try:
        return numbers_of(line.split(), "")
    except DataError:
        return []


def _signs(line: str) -> list[float]:
    """Return the signs of the four angles of a row: -00 12 30 is negative."""
    words = line.split()
    return [-1.0 if words[i].startswith("-") else 1.0 for i in (0, 3, 6, 9)]


def _base60(parts: Array) -> Array:
    """Convert d m s (n, 3) without sign to d."""
    whole = np.abs(parts)
    return np.asarray(whole[:, 0] + whole[:, 1] / 60.0 + whole[:, 2] / 3600.0)


def precess(ra: Array, dec: Array, year: float) -> tuple[Array, Array]:
    """Convert places of J2000 (rad) to the mean equinox of a year."""
    t = (year - 2000.0) / 100.0
    arcs = (
        2306.2181 * t + 0.30188 * t**2 + 0.017998 * t**3,
        2306.2181 * t + 1.09468 * t**2 + 0.018203 * t**3,
        2004.3109 * t - 0.42665 * t**2 - 0.041833 * t**3,
    )
    first, second, tilt = (a * UNITS["arcsec"][0] for a in arcs)
    a = ra + first
    x = np.cos(tilt) * np.cos(dec) * np.cos(a) - np.sin(tilt) * np.sin(dec)
    y = np.cos(dec) * np.sin(a)
    z = np.sin(tilt) * np.cos(dec) * np.cos(a) + np.cos(tilt) * np.sin(dec)
    return np.arctan2(y, x) + second, np.arcsin(z)


def refract(apparent: Array, latitude: float, celsius: float, hectopascal: float) -> Array:
    """Raise directions (n, 3) by the refraction of the air; latitude rad. Raises DataError for stars below the horizon."""
    zenith = np.array([np.cos(latitude), 0.0, np.sin(latitude)])
    sine = apparent @ zenith
    height = np.degrees(np.arcsin(np.clip(sine, -1.0, 1.0)))
    low = np.flatnonzero(height < 0)
    if len(low):
        raise DataError(
            f"star {int(low[0]) + 1} of the list is {-height[low[0]]:.1f} deg below the horizon: check latitude and sidereal time"
        )
    lift = np.radians(1.02 / 60.0 / np.tan(np.radians(height + 10.3 / (height + 5.11))))
    lift = lift * hectopascal / 1010.0 * 283.0 / (273.0 + celsius)
    across = (zenith - sine[:, None] * apparent) / np.sqrt(1.0 - sine**2)[:, None]
    return np.asarray(np.cos(lift)[:, None] * apparent + np.sin(lift)[:, None] * across)


def read_altaz(path: str | Path) -> Pointings:
    """Read a table of az_deg, alt_deg and their offsets. Raises DataError with column, line and fix."""
    sheet = read_csv(Path(path))
    problems = sheet.missing((AZIMUTH, ALTITUDE, *OFFSETS))
    used = [name for column in (AZIMUTH, ALTITUDE, *OFFSETS) for name in column.headings]
    allowed = file_columns()
    columns, labels = conditions_of(
        sheet, used, lambda name: known_column(name, allowed), lambda name: " of a pointing list", problems
    )
    if problems:
        raise DataError(problems)
    read = [sheet.quantities(c) for c in (AZIMUTH, ALTITUDE)]
    true = [q + sheet.quantities(c) for q, c in zip(read, OFFSETS)]
    first = np.mod(np.pi - read[0], 2 * np.pi) - np.pi
    return Pointings(
        first,
        -read[1],
        directions=direction_of(*true),
        down=np.array([0.0, 0.0, -1.0]),
        columns=columns,
        labels=labels,
        lines=np.array(sheet.lines),
    )
