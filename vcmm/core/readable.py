"""Readings of a result in Python: as a document, as rows, as a page, in a notebook.

Rooms that compute do not know tables and pages. The room that runs a job for a person (`vcmm.face`) gives the result a `Reading`: how its
document, its rows and its page are made. The result offers them as methods.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.core.errors import Environment, UsageError, choose_from

FRAMES = ("pandas", "polars")


@dataclass(frozen=True, eq=False)
class Reading:
    """document: what `--json` prints; rows: one flat record per row of the main table; brief: HTML for a notebook; page: the report as
    HTML, None where the job has none; write: puts a page into a file.
    """

    document: Callable[[Any], dict[str, Any]]
    rows: Callable[[Any], Sequence[Mapping[str, Any]]]
    brief: Callable[[Any], str]
    page: Callable[[Any], str] | None = None
    write: Callable[[Path, str], Any] = lambda path, html: path.write_text(html, encoding="utf-8")


class Readable:
    """A result that can be read in several ways once it has a `reading`."""

    reading: Reading | None

    def to_dict(self) -> dict[str, Any]:
        """Return the document that the command line prints with `--json`: plain lists, texts and numbers.

        Returns
        -------
        dict
            Keys `schema`, `version`, `seed`, `inputs`, `warnings`, and those of the job (docs/cli.md).
        """
        return self._reading().document(self)

    def to_dataframe(self, library: str | None = None) -> Any:
        """Return the rows of the main table as a data frame; headings carry the unit, as the keys of the document do.

        Parameters
        ----------
        library
            "pandas" or "polars"; by default the first of the two that is installed.

        Returns
        -------
        pandas.DataFrame or polars.DataFrame
            An interval takes two columns, its ends named `_low` and `_high`.

        Raises
        ------
        UsageError
            Another library.
        Environment
            It is not installed.
        """
        return frame_of(self._reading().rows(self), library)

    def report(self, path: str | Path) -> Path:
        """Write the report of the job as one HTML file, which works without a network.

        Parameters
        ----------
        path
            File to write; an existing one is replaced.

        Returns
        -------
        pathlib.Path
            The file.

        Raises
        ------
        UsageError
            The job has no report.
        """
        reading = self._reading()
        if reading.page is None:
            raise UsageError(
                f"{type(self).__name__} has no report; to_dict() and to_dataframe() hold all of it"
            )
        target = Path(path)
        reading.write(target, reading.page(self))
        return target

    def _repr_html_(self) -> str | None:
        """Return the HTML of a notebook; None (a notebook then shows the repr) for a result that was made inside the program."""
        return None if self.reading is None else self.reading.brief(self)

    def _reading(self) -> Reading:
        if self.reading is None:
            raise UsageError(
                f"this {type(self).__name__} was made by a step inside a job; only what the functions of `import vcmm` return knows "
                "its document and its report"
            )
        return self.reading


class ReadableRows(tuple[Any, ...], Readable):
    """Several rows of one job: a tuple that can be read as a document and as a data frame."""

    reading: Reading | None = None

    @classmethod
    def of(cls, rows: Sequence[Any], reading: Reading) -> ReadableRows:
        """Return the rows with their reading."""
        out = cls(rows)
        out.reading = reading
        return out

    def __getitem__(self, key: Any) -> Any:
        """Return a row by number, as a tuple does, or by name. KeyError: no row has this name."""
        if not isinstance(key, str):
            return super().__getitem__(key)
        names = [str(getattr(row, "name", "") or getattr(row, "file", "")) for row in self]
        if key not in names:
            raise KeyError(f'no row "{key}".{choose_from(key, dict.fromkeys(names))}')
        return super().__getitem__(names.index(key))


def frame_of(rows: Sequence[Mapping[str, Any]], library: str | None = None) -> Any:
    """Return flat records as a data frame of pandas or polars. UsageError: another library; Environment: none is installed."""
    if library is not None and library not in FRAMES:
        raise UsageError(f'library = "{library}".{choose_from(library, FRAMES)}')
    wanted = FRAMES if library is None else (library,)
    there = next((name for name in wanted if importlib.util.find_spec(name)), None)
    if there is None:
        raise Environment(
            f"{' or '.join(wanted)} is not installed: pip install {wanted[0]}, or read to_dict(), which needs neither"
        )
    records = [flatten_record(row) for row in rows]
    heads = list(dict.fromkeys(key for record in records for key in record))
    columns = {head: [record.get(head) for record in records] for head in heads}
    return importlib.import_module(there).DataFrame(columns)


def flatten_record(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a record without inner tables: a pair of numbers becomes its two ends, the keys of an inner record follow a dot."""
    out: dict[str, Any] = {}
    for key, value in row.items():
        if isinstance(value, Mapping):
            out |= {f"{key}.{inner}": v for inner, v in flatten_record(value).items()}
        elif isinstance(value, list | tuple):
            if len(value) == 2 and not any(isinstance(v, str | Mapping | list | tuple) for v in value):
                out |= {f"{key}_low": value[0], f"{key}_high": value[1]}
            elif len(value) == 3 and all(isinstance(v, float) for v in value):
                out |= {f"{key}_{axis}": v for axis, v in zip("xyz", value)}
        else:
            out[key] = value
    return out
