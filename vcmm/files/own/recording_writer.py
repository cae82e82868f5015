"""Write a recording as recording/1: TOML, the CSV of its observations, one CSV per log."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.laws import Law, Normal, StudentT
from vcmm.core.run import Run, Series
from vcmm.core.text import csv_of, quote
from vcmm.core.whole_files import write_files
from vcmm.files.columns import axis_column, file_columns, known_column
from vcmm.files.observations import FROM, NORMAL, VECTOR
from vcmm.files.own.known_columns import known_text
from vcmm.files.own.logs import LOG_COLUMNS
from vcmm.task.response.logs import row_logs
from vcmm.task.response.recording import Ints, Recording

DEG = np.pi / 180.0
DERIVED_COLUMN = re.compile(
    r"length_mm|travel_.*|(since_reversal|speed|accel)_[ABC]\d*_rad.*|play_.*|turned_.*|pointed_[xyz]"
)  # made again on reading
SEPARATE_COLUMN = re.compile(
    r"length_mm|(since_reversal|speed|accel)_[ABC]\d*_rad.*|play_.*|turned_.*|pointed_[xyz]"
)  # the same, but for travel


def save_recording(
    recording: Recording, path: str | Path, machine: str = "machine.toml", *, apart: bool = False
) -> None:
    """Write PATH (TOML) and its CSV files beside it; machine: the file name that the TOML states.

    Columns that follow from others (measured length, travel, play) are left out. apart: rows that do not follow one another, as of a
    part that was cut: then travel is written and nothing is made of their order. Reading gives the same recording to
    rounding. Raises UsageError for a law or a column that the format cannot hold, Environment if it cannot be written.
    """
    path = Path(path)
    texts = recording_texts(recording, path.stem, machine, apart=apart)
    write_files(path.parent, texts)


def recording_texts(
    recording: Recording, stem: str, machine: str = "machine.toml", *, apart: bool = False
) -> dict[str, str]:
    """Return file name -> text of all files of a recording; see `save_recording`."""
    run = recording.run
    own_logs = row_logs(run)
    logs = {name: log for name, log in run.series.items() if not _same(log, own_logs.get(name))}
    column = {s: s if s in LOG_COLUMNS else f"temp_{s}_C" for s in logs}
    names = {sensor: f"{stem}_{sensor}.csv" for sensor in logs}
    texts = {f"{stem}.toml": _toml(recording, stem, machine, list(names.values()), apart)}
    texts[f"{stem}.csv"] = _csv(_columns(recording, SEPARATE_COLUMN if apart else DERIVED_COLUMN))
    if recording.known:
        texts[f"{stem}-known.csv"] = known_text(recording)
    for sensor, log in logs.items():
        texts[names[sensor]] = _csv({"time_s": log.time, column[sensor]: log.value})
    return texts


def _same(series: Series, other: Series | None) -> bool:
    return (
        other is not None
        and np.array_equal(series.time, other.time)
        and np.array_equal(series.value, other.value)
    )


def _toml(recording: Recording, stem: str, machine: str, logs: list[str], apart: bool) -> str:
    lines = ['vcmm = "recording/1"', f"name = {quote(recording.name)}", f'data = "{stem}.csv"']
    lines += [f"machine = {quote(machine)}", f'kind = "{recording.kind}"']
    lines.append(f'observed = "{"indicated - true" if recording.measuring else "actual - commanded"}"')
    if apart:
        lines.append('history = "none"')
    if recording.nuisance:
        lines += ["[nuisance]", *(f'{word} = "{label}"' for word, label in recording.nuisance.items())]
    if recording.noise is not None:
        lines += ["[noise]", *_noise(recording.noise, "rad" if recording.kind == "angle" else "mm")]
    if recording.known:
        lines += ["[known]", f'data = "{stem}-known.csv"']
    for name in logs:
        lines += ["[[series]]", f"data = {quote(name)}"]
    return "\n".join(lines) + "\n"


def _noise(law: Law, unit: str) -> list[str]:
    if isinstance(law, Normal):
        return ['law = "normal"', f'u = "{law.u!r} {unit}"']
    if isinstance(law, StudentT):
        return ['law = "t"', f'scale = "{law.scale!r} {unit}"', f"dof = {law.dof!r}"]
    raise UsageError(f"noise of the law {law.name} has no place in a recording file; use normal or t")


def _columns(recording: Recording, without: re.Pattern[str]) -> dict[str, Any]:
    """Return every column of the CSV, one row per line."""
    run, angle = recording.run, recording.kind == "angle"
    vector = _components(recording)
    rows = np.arange(run.n) if vector else recording.row
    out = _conditions(run, rows, without)
    if not vector and _across_normals(recording):
        raise UsageError("observations across the normals of their rows have no place in a recording file")
    if not vector:
        out |= {c: recording.direction[:, i] for i, c in enumerate(NORMAL)}
    if (recording.other >= 0).any() and FROM[0] not in run.columns:
        out |= {c: run.tip[recording.other, i] for i, c in enumerate(FROM)}
    scale = 1e6 if angle else 1e3
    names = vector or (("d_urad",) if angle else ("d_um",))
    table = (recording.value * scale).reshape(-1, len(names))
    out |= {name: table[:, i] for i, name in enumerate(names)}
    if recording.u is not None:
        spread = (recording.u * scale).reshape(-1, len(names))
        out |= {f"u_{name}": spread[:, i] for i, name in enumerate(names)}
    return out


def _across_normals(recording: Recording) -> bool:
    if recording.kind == "length" or not all(c in recording.run.columns for c in NORMAL):
        return False
    gap = recording.run.normal[recording.row] - recording.direction
    return bool(np.abs(gap).max(initial=0.0) > 1e-9)


def _components(recording: Recording) -> tuple[str, ...]:
    """Return dx_um dy_um dz_um (or some of them) where every run row has the same of them, in this order; else nothing."""
    n = recording.run.n
    along_normals = recording.m == n and all(c in recording.run.columns for c in NORMAL)
    if recording.kind in ("length", "angle") or recording.m % n or along_normals:
        return ()
    axis = recording.direction.argmax(axis=1).reshape(n, -1)
    exact = np.abs(recording.direction - np.eye(3)[axis.ravel()]).max(initial=0.0) < 1e-12
    regular = (axis == axis[0]).all() and (np.diff(axis[0]) > 0).all()
    in_rows = np.array_equal(recording.row, np.repeat(np.arange(n), axis.shape[1]))
    return tuple(VECTOR[i] for i in axis[0]) if exact and regular and in_rows else ()


def _conditions(run: Run, rows: Ints, without: re.Pattern[str]) -> dict[str, Any]:
    """Return the positions, offsets, columns and labels of the rows, in file units."""
    out: dict[str, Any] = {
        axis_column(a): q[rows] / (DEG if is_rotary(a) else 1.0) for a, q in run.position.items()
    }
    if run.offset.any():
        out |= {f"offset_{c}_mm": run.offset[rows, i] for i, c in enumerate("xyz")}
    columns = file_columns()
    for name, values in run.columns.items():
        if without.fullmatch(name) or name in NORMAL:
            continue
        written = f"{name[:-4]}_deg" if name.endswith("_rad") else name
        if not known_column(written, columns):
            raise UsageError(f"the column {name} has no place in a recording file; remove it")
        out[written] = values[rows] / (DEG if name.endswith("_rad") else 1.0)
    if all(c in run.columns for c in NORMAL):
        out |= {c: run.columns[c][rows] for c in NORMAL}
    return out | {name: values[rows] for name, values in run.labels.items()}


def _csv(columns: Mapping[str, Any]) -> str:
    return csv_of([list(columns), *zip(*(values.tolist() for values in columns.values()))])
