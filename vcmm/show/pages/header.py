"""The facts at the head of a report: part, drawing, machine with serial number, date, operator, order, software, files and hashes."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from vcmm import __version__
from vcmm.show.report import blocks as r
from vcmm.show.report.table import Raw

NAMES = {
    "part_serial": "part, serial number", "drawing": "drawing", "date": "date", "by": "operator", "order": "order", "laboratory": "laboratory",
    "machine_certificate": "certificate of the machine", "probe": "probe and styli",
}  # fmt: skip
EXPECTED = ("drawing", "date", "by", "order")  # said to be open where the record does not hold them
OF_MACHINES = ("date", "by")  # the same of reports on a machine, without a part


def facts(
    part: str = "",
    machine: str = "",
    record: Mapping[str, str] | None = None,
    seed: int | None = None,
    more: Iterable[tuple[str, str]] = (),
    expected_names: Sequence[str] = EXPECTED,
) -> list[tuple[str, str]]:
    """Return the names and values. record: the table [record] of a scenario, machine or recording; None where the job has no such table. expected_names:
    names shown as open where the record does not hold them.
    """
    stated = record or {}
    serial = f", serial number {stated['machine_serial']}" if stated.get("machine_serial") else ""
    out = [("part", part)] if part else []
    out += [(NAMES[key], stated[key]) for key in NAMES if stated.get(key) and key != "date"]
    out += [("machine", machine + serial)] if machine else []
    out += [("date", stated["date"])] if stated.get("date") else []
    out += list(more)
    out.append(("software", f"vcmm {__version__}" + ("" if seed is None else f", seed {seed}")))
    if record is not None:
        missing = [NAMES[key] for key in expected_names if not stated.get(key)]
        missing += [] if serial else ["serial number of the machine"]
        if missing:
            out.append(
                (
                    "not stated",
                    f"{', '.join(missing)} (table [record] of the scenario, the machine or the recording)",
                )
            )
    return out


def hashes(files: Sequence[Path]) -> list[list[object]]:
    """Return the file and the SHA-256 of its bytes."""
    return [[str(f), Raw(f"<code>{hashlib.sha256(f.read_bytes()).hexdigest()}</code>")] for f in files]


def files_block(files: Sequence[Path]) -> list[str]:
    """Return the files read, so that the report can be made again; nothing where no file is named."""
    there = [f for f in dict.fromkeys(files) if f.is_file()]
    if not there:
        return []
    return [r.heading("Files read (SHA-256)"), r.table(["file", "hash"], hashes(there))]
