"""Values as other measuring software exports them: tables of CALYPSO (..._chr.txt) and text reports of PC-DMIS.

CALYPSO   tab-separated; heading planid partnb id type idsymbol actual nominal uppertol lowertol ... unit; perhaps a last line END.
          `id` is the characteristic, `actual` its value, `partnb` the part.
PC-DMIS   blocks  DIM LOC1= LOCATION OF CIRCLE CIR1 UNITS=MM  with a heading  AX NOMINAL +TOL -TOL MEAS DEV OUTTOL  and a row per axis.
          The characteristic is LOC1, or LOC1.D where the block has several rows.

Such files hold everything that was measured. What the scenario does not ask for is left out and said.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path

from vcmm.core.errors import DataError, did_you_mean
from vcmm.core.text import lines_of, read_text, to_number
from vcmm.core.units import UNITS
from vcmm.inference.given import GivenValue

UNIT_WORDS = {
    "mm": "mm",
    "inch": "in",
    "in": "in",
    "um": "um",
    "µm": "um",
    "deg": "deg",
    "°": "deg",
    "rad": "rad",
}
CALYPSO = ("id", "actual", "nominal", "idsymbol")
BLOCK = re.compile(r"DIM\s+(\S+?)\s*=\s*(.+?)\s+UNITS\s*=\s*(\w+)", re.IGNORECASE)
SHOWN = 8  # names in a message
Reader = Callable[[Path, Sequence[str], Collection[str]], Iterator["GivenValue | str"]]


def exported_values(
    path: str | Path, wanted: Collection[str]
) -> tuple[tuple[tuple[GivenValue, ...], ...], str] | None:
    """(values per part, what was left out in words) of an export; None where the file is no such export.

    DataError, with the line: a cell that is no number, an unknown unit, a value given twice, none of the wanted ones there.
    """
    lines = list(lines_of(read_text(Path(path))))
    kind = _kind(lines)
    if kind is None:
        return None
    found = list(kind(Path(path), lines, wanted))
    rows = [v for v in found if isinstance(v, GivenValue)]
    others = list(dict.fromkeys(v for v in found if isinstance(v, str)))
    if not rows:
        hint = did_you_mean(others[0], list(wanted)) if others else ""
        raise DataError(
            f"{path}: it holds none of the characteristics of the part ({', '.join(wanted)}); it has {_some(others)}.{hint} Name "
            "the characteristics as the export does"
        )
    _check_once(rows)
    parts = tuple(tuple(v for v in rows if v.part == p) for p in dict.fromkeys(v.part for v in rows))
    said = (
        f"{path}: {len(others)} characteristics are not asked for and left out: {_some(others)}"
        if others
        else ""
    )
    return parts, said


def _some(names: Sequence[str]) -> str:
    more = len(names) - SHOWN
    return ", ".join(names[:SHOWN]) + (f" and {more} more" if more > 0 else "")


def _kind(lines: Sequence[str]) -> Reader | None:
    """The reader of a file, by its heading."""
    head = next((line for line in lines if line.strip()), "")
    if set(CALYPSO) <= {c.strip() for c in head.split("\t")}:
        return _calypso
    return _pcdmis if any(BLOCK.match(line.strip()) for line in lines) else None


def _check_once(rows: Sequence[GivenValue]) -> None:
    seen: dict[tuple[str, str], str] = {}
    for v in rows:
        first = seen.setdefault((v.part, v.name), v.where)
        if first != v.where:
            of = f' of part "{v.part}"' if v.part else ""
            raise DataError(f'{v.where}: "{v.name}"{of} stands in {first} already; keep one')


def _number(text: str, where: str, column: str) -> float:
    try:
        return to_number(text.strip())
    except ValueError:
        raise DataError(f'{where}: "{text.strip()}" in column {column} is not a number') from None


def _unit(word: str, where: str) -> tuple[float, bool]:
    """(factor to mm or rad, whether it is an angle)."""
    name = UNIT_WORDS.get(word.strip().lower())
    if name is None:
        raise DataError(
            f'{where}: the unit "{word.strip()}" is not known; allowed are {", ".join(UNIT_WORDS)}'
        )
    return UNITS[name][0], name in ("deg", "rad")


def _calypso(path: Path, lines: Sequence[str], wanted: Collection[str]) -> Iterator[GivenValue | str]:
    header: list[str] = []
    for n, line in enumerate(lines, 1):
        cells = [c.strip() for c in line.split("\t")]
        if not line.strip() or cells[0] == "END":
            continue
        if not header:
            header = cells
            continue
        where, row = f"{path}:{n}", dict(zip(header, cells))
        if not row.get("id"):
            raise DataError(f"{where}: the row has no id; it was cut off, export the table again")
        if row["id"] not in wanted:
            yield row["id"]
            continue
        factor, angle = _unit(row.get("unit", ""), where)
        value = _number(row.get("actual", ""), where, "actual")
        yield GivenValue(
            row.get("partnb", ""), row["id"], value * factor, angle=angle, deviation=False, where=where
        )


def _pcdmis(path: Path, lines: Sequence[str], wanted: Collection[str]) -> Iterator[GivenValue | str]:
    for name, unit, rows in _blocks(path, lines):
        for where, axis, value in rows:
            full = f"{name}.{axis}"
            asked = name if len(rows) == 1 and name in wanted else full
            if asked not in wanted:
                yield full if len(rows) > 1 else name
                continue
            factor, angle = _unit("deg" if axis.upper() == "A" else unit, where)
            yield GivenValue("", asked, value * factor, angle=angle, deviation=False, where=where)


def _blocks(path: Path, lines: Sequence[str]) -> Iterator[tuple[str, str, list[tuple[str, str, float]]]]:
    """(name, unit, rows of (where, axis, measured value)) of every DIM block."""
    header: list[str] = []
    name, unit = "", ""
    rows: list[tuple[str, str, float]] = []
    for n, line in enumerate(lines, 1):
        text, where = line.strip(), f"{path}:{n}"
        begins = BLOCK.match(text)
        if begins or text.upper().startswith("END OF DIMENSION"):
            if name:
                yield name, unit, rows
            name, unit, header, rows = (begins[1], begins[3], [], []) if begins else ("", "", [], [])
        elif name and text.upper().startswith("AX"):
            header = text.upper().split()
        elif name and text and header:
            cells = text.split()
            if len(cells) < len(header):
                raise DataError(
                    f"{where}: {len(cells)} cells where the heading names {len(header)}; export the report again"
                )
            if "MEAS" not in header:
                raise DataError(f"{where}: the heading of {name} has no column MEAS; add it to the report")
            rows.append((where, cells[0], _number(cells[header.index("MEAS")], where, "MEAS")))
    if name:
        yield name, unit, rows
