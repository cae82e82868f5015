"""Compare simulation and recording for any machine files: the residuals of each."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vcmm.learn.diagnosis.comparison import Comparison


def compare_files(
    recordings: Sequence[Path], machines: Sequence[Path], seed: int
) -> tuple[list[Comparison], list[str], list[Path]]:
    """Return (a row for each machine, that of the recordings first; omitted data in words; all files that were read)."""
    from vcmm.files.own.machine import load_machine
    from vcmm.show.console.documents import sources

    read = list(recordings)
    named = {_machine_name([path]) for path in read}
    recorded = Path(named.pop()).resolve() if len(named) == 1 else None  # named again it would stand twice
    once = {file.resolve(): file for file in machines if file.resolve() != recorded}
    others = [(file, load_machine(file)) for file in once.values()]
    every = [effect for _, machine_of_file in others for effect in machine_of_file.effects]
    rows = [_compare(read, None, None, seed, every)]
    rows += [_compare(read, file, machine_of_file, seed, every) for file, machine_of_file in others]
    inputs = [p for path in (*read, *machines) for p in sources(path)]
    return rows, _left_out(rows), list(dict.fromkeys(inputs))


def _compare(recordings: list[Path], file: Path | None, machine: Any, seed: int, every: list[Any]) -> Any:
    """Return one machine (None: the one that each recording names) against all recordings, in the rows that all machines can predict.

    every: the effects of all other machines: rows that one of them needs and a sensor did not read are left out for all.
    """
    from dataclasses import replace

    from vcmm.files.own.recording import load_recording
    from vcmm.learn.diagnosis.comparison import compare_machines
    from vcmm.learn.diagnosis.sensor_gaps import rows_for_effects
    from vcmm.show.console.complaints import about

    pairs = []
    for path in recordings:
        recording, machine_of_file = load_recording(path, machine, gaps=True)
        if recording.unread:
            own_machine = machine_of_file if machine is None else load_recording(path, gaps=True)[1]
            recording = rows_for_effects(recording, (*every, *own_machine.effects))
        pairs.append(
            (replace(recording, name=str(path)) if len(recordings) > 1 else recording, machine_of_file)
        )
    with about(recordings[0]):
        return compare_machines(str(file) if file else _machine_name(recordings), pairs, seed)


def _left_out(rows: list[Any]) -> list[str]:
    """Return, in words, the data of the recordings that were set aside, and the effects for which they have no columns."""
    aside = dict.fromkeys(note for row in rows for part in row.parts for note in part.recording.notes)
    return [*aside] + [
        f"{row.file}: {name} is not predicted, the recording lacks a column that it needs"
        for row in rows
        for name in sorted({n for part in row.parts for n in part.left_out})
    ]


def _machine_name(recordings: list[Path]) -> str:
    """Name of the machine file that the recordings name."""
    from vcmm.files.toml import read_toml

    named = [read_toml(path).data.get("machine") for path in recordings]
    beside = [str(p.parent / n) if isinstance(n, str) else str(p) for p, n in zip(recordings, named)]
    return ", ".join(dict.fromkeys(beside))
