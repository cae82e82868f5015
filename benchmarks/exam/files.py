"""Writes a case as its users would have it: recording.toml, touches.csv, log.csv, machine.toml, errors.csv."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from benchmarks.exam import machines
from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array


def write(
    folder: Path, design: Design, machine: machines.Machine, values: Array, u: Array | None = None
) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    machines.write(machine, folder)
    columns: dict[str, list[str]] = {}
    for letter, q in design.q.items():
        rotary = letter in "ABC"
        columns[f"{letter}_{'deg' if rotary else 'mm'}"] = _text(np.degrees(q) if rotary else q, 9)
    for i, c in enumerate("xyz"):
        columns[f"offset_{c}_mm"] = _text(design.offset[:, i], 9)
    if design.normal is not None:
        for i, c in enumerate("xyz"):
            columns[f"n{c}"] = _text(design.normal[:, i], 12)
    for name, column in design.columns.items():
        columns[name] = _text(column, 0 if name.startswith("sense") else 9)
    for name, label in design.labels.items():
        columns[name] = list(label)
    um = values * 1e3
    if design.normal is not None:
        columns["d_um"] = _text(um, 6)
    else:
        for i, c in enumerate("xyz"):
            columns[f"d{c}_um"] = _text(um.reshape(-1, 3)[:, i], 6)
    _csv(folder / "touches.csv", columns)
    lines = [
        'vcmm = "recording/1"',
        'data = "touches.csv"',
        'machine = "machine.toml"',
        f'kind = "{design.kind}"',
    ]
    lines += [f'observed = "{design.observed}"', "[nuisance]"]
    lines += [f'{word} = "{label}"' for word, label in design.nuisance.items()]
    if design.series:
        _csv(folder / "log.csv", {k: _text(v, 6) for k, v in design.series.items()})
        lines += ["[[series]]", 'data = "log.csv"']
    (folder / "recording.toml").write_text("\n".join(lines) + "\n")
    return folder / "recording.toml"


def _text(values: Array, digits: int) -> list[str]:
    return [f"{v:.{digits}f}" for v in np.asarray(values, dtype=float)]


def _csv(path: Path, columns: dict[str, list[str]]) -> None:
    rows = [",".join(columns)] + [",".join(row) for row in zip(*columns.values())]
    path.write_text("\n".join(rows) + "\n")
