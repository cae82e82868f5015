"""Recording files: recording/1 TOML and its data to a Recording and the Machine it was made on.

`format` says how the data are written: "table" (columns of a recording, the default), "points" (nominal and measured
points of a CMM), "iso230" (positioning runs), "rtl" (laser), "scope" (trace of a controller), "tpoint" and "altaz" (pointing
lists), "klipper" (thermal logs), "touches" (a log of touches). All give the same thing; what follows (logs, history of the axes, nuisance, noise) does not know which it was.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.axes import LETTERS
from vcmm.core.errors import DataError, ModelLimit, UsageError, did_you_mean
from vcmm.core.history import (
    axis_unit,
    path_history,
    row_history,
    rows_after_turning,
    time_since_acceleration,
    travel,
)
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run, Series
from vcmm.core.text import is_file, read_text
from vcmm.files.columns import LABELS, run_columns
from vcmm.files.gaps import note_gaps, reaching
from vcmm.files.observations import OBSERVED_COLUMNS
from vcmm.files.own.known_columns import read_known
from vcmm.files.own.logs import add_logs, read_logs, with_readings
from vcmm.files.own.machine import machine_from
from vcmm.files.own.recording_data import read_data
from vcmm.files.own.recording_tables import (
    RecordingFile,
    check_words,
    noise_law,
)
from vcmm.files.problems import Problems
from vcmm.files.schema import checked_model
from vcmm.files.toml import Document, check_version, read_toml
from vcmm.task.response.indexing import settle_index
from vcmm.task.response.logs import with_logs
from vcmm.task.response.nuisance import named_nuisance
from vcmm.task.response.pointing import with_down
from vcmm.task.response.recording import ALL_ROWS, Recording

BREAKS = ("setup", "pose", "run")  # labels: between their values the axes moved unseen

QUARTER = 0.25  # of the rows

PLACEMENTS = ("rigid", "alignment")  # nuisances of which a recording usually has several


def load_recording(
    path: str | Path, machine: Machine | None = None, gaps: bool = False
) -> tuple[Recording, Machine]:
    """Read a recording (recording/1).

    Parameters
    ----------
    path
        The file.
    machine
        Used instead of the machine that the file names, which is then not read.
    gaps
        Blank cells of a sensor and logs that end early are allowed; `notes` of the recording say what was set aside.

    Returns
    -------
    tuple of Recording and Machine
        The observations, and the machine they were made on.

    Raises
    ------
    DataError
        Every problem of the file and of the files it names, each with its line.
    """
    document = read_toml(path)
    check_version(document, "recording")
    problems = Problems(document)
    checked = _check_document(document, machine, problems, gaps)
    problems.raise_if_any()
    assert checked is not None
    return checked


def _check_document(
    document: Document, machine: Machine | None, problems: Problems, gaps: bool
) -> tuple[Recording, Machine] | None:
    model = checked_model(RecordingFile, document.data, problems)
    if model is not None and model.reversal is not None:
        problems.add(
            ("reversal",),
            "a reversal separates machine and artefact by itself: give this file alone to vcmm calibrate or vcmm test --iso 230-7, and "
            "the machine file that calibrate writes to this command",
        )
        return None
    machine = machine or _machine(document, problems)
    if model is None:
        return None
    check_words(model, problems)
    noise = None
    if model.noise is not None:
        noise = problems.attempt(("noise",), partial(noise_law, model.noise, model.kind == "angle"))
    folder = document.path.parent
    logs = problems.attempt(("series",), lambda: read_logs([folder / s.data for s in model.series]))
    recording = problems.attempt(("data",), lambda: read_data(model, folder / model.data, machine, problems))
    if recording is None or machine is None or logs is None or problems.found:
        return None
    name, data = model.name or document.path.stem, folder / model.data
    record = ({"date": model.date} if model.date else {}) | model.record.entries
    recording = replace(
        recording, name=name, nuisance=model.nuisance or recording.nuisance, noise=noise, record=record
    )
    known_table = model.known
    steps: list[tuple[str, Callable[[Recording], Recording]]] = [
        ("data", partial(_on_machine, machine=machine, data=data)),
        (
            "known",
            lambda r: (
                r if known_table is None else replace(r, known=read_known(folder / known_table.data, r))
            ),
        ),
        ("series", partial(_with_logs, logs=logs)),
        ("data", partial(_complete, gaps=gaps)),
        ("history", partial(_with_past, memory=model.memory, has_order=gaps)),
        ("nuisance", _with_labels),
        ("nuisance", partial(settle_index, machine=machine)),
        ("down", partial(_with_down, machine=machine, down=model.down)),
        ("data", partial(_with_part, machine=machine)),
        ("nuisance", partial(_with_nuisance, machine=machine)),
    ]
    for key, step in steps:
        following = problems.attempt((key,), partial(step, recording))
        if following is None:
            return None
        recording = following
    return replace(recording, missing=missing_columns(recording.run, machine)), machine


def _with_logs(recording: Recording, logs: dict[str, Series]) -> Recording:
    """Return the recording with its logs; rows beyond the end of one are named."""
    logs, gaps = reaching(recording.run, logs)
    whole = replace(recording, run=with_readings(with_logs(add_logs(recording.run, logs))))
    return note_gaps(whole, gaps)


def _complete(recording: Recording, gaps: bool) -> Recording:
    """Return the recording unchanged. Raises UsageError where rows or columns were set aside without a note."""
    if recording.notes and not gaps:
        raise UsageError(
            f"{'; '.join(recording.notes)}: complete the readings of the sensor, or remove the rows or the column (vcmm diagnose "
            "and vcmm compare take the recording as it is)"
        )
    return recording


def recording_file(path: str | Path) -> Path:
    """Return the recording file of some data: the file itself, or the one beside a table that names it. Raises DataError for none."""
    path = Path(path)
    if path.suffix.lower() == ".toml":
        return path
    beside = [p for p in sorted(path.parent.glob("*.toml")) if _names_data(p, path.name)]
    if len(beside) == 1:
        return beside[0]
    lines = (
        f"{' and '.join(p.name for p in beside)} name it; give one of them"
        if beside
        else "no file beside it names it"
    )
    raise DataError(
        f'{path}: these are the data of a recording, and {lines}. A recording file says what they are: vcmm = "recording/1", '
        f'data = "{path.name}", machine = "machine.toml", kind = "probe"'
    )


def _names_data(path: Path, name: str) -> bool:
    try:
        data = read_toml(path).data
    except DataError:
        return False
    return str(data.get("vcmm", "")).startswith("recording/") and data.get("data") == name


def machine_of(path: str | Path) -> tuple[Path | None, str]:
    """Return the machine file that a recording names (None where it holds the machine itself), and its text."""
    document = read_toml(path)
    value = document.data.get("machine")
    if not isinstance(value, str):
        return None, repr(value)
    file = document.path.parent / value
    return file, read_text(file) if is_file(file) else value


def _machine(document: Document, problems: Problems) -> Machine | None:
    """Return the machine that the file names or holds; None where there is none, which is noted."""
    value = document.data.get("machine")
    if isinstance(value, dict):
        return problems.attempt(("machine",), lambda: machine_from(document, value, ("machine",)))
    if isinstance(value, str):
        return problems.attempt(("machine",), lambda: _machine_file(document.path.parent / value))
    if value is None:
        problems.add(
            (), 'the key "machine" is missing; write machine = "machine.toml", or name one with --machine'
        )
    return None


def _machine_file(path: Path) -> Machine:
    other = read_toml(path)
    check_version(other, "machine")
    return machine_from(other, other.data, ())


def _on_machine(recording: Recording, machine: Machine, data: Path) -> Recording:
    """Return the recording unchanged, after checking that all rows are within the travels. Raises DataError, with the line of the data
    where it is known."""
    try:
        machine.check_travels(recording.run)
    except ModelLimit as error:
        if error.row is None or recording.lines is None:
            raise DataError(f"{data}: {error}") from None
        lines, end = recording.lines, ""
        if error.row >= len(lines):
            end = '; this is the second end, from_x_mm ...: for a fixed station write [nuisance] station = ""'
        raise DataError(f"{data}:{lines[error.row % len(lines)]}: {_without_row(error)}{end}") from None
    return recording


def _without_row(error: ModelLimit) -> str:
    """Return the complaint without its number of the row of the run, where the line of a file is given instead."""
    return str(error) if error.row is None else str(error).removeprefix(f"row {error.row + 1}: ")


def _with_nuisance(recording: Recording, machine: Machine) -> Recording:
    """Return the recording unchanged, after checking that its nuisance is possible."""
    for _ in named_nuisance(recording, machine):
        pass
    return recording


def _with_labels(recording: Recording) -> Recording:
    """Return the recording unchanged, after checking the label columns of placements. Raises UsageError for one that is missing.

    A recording without the column `stylus` or `instrument` has one of them, which a diagnosis tells; without `pose`
    several placements would become one without a word.
    """
    labels = sorted(recording.run.labels)
    for word in PLACEMENTS:
        label = recording.nuisance.get(word, "")
        if label not in ALL_ROWS and label not in labels:
            near = did_you_mean(label, labels)
            rest = (
                f" The label columns are {', '.join(labels)}."
                if labels
                else " The data have no label column."
            )
            raise UsageError(
                f'{word} = "{label}": the data have no column "{label}".{near}{rest} Add the column, or write '
                f'{word} = "" for one placement in all rows'
            )
    return recording


def _with_past(recording: Recording, memory: str, has_order: bool) -> Recording:
    """Return the recording with the history of its axes. A table that was sorted otherwise than by its clock, or not at all, is followed in the
    order of time where that is known (`has_order`); else `_with_history` raises an error with advice.
    """
    run = recording.run
    two = int((recording.other >= 0).sum())
    if not has_order or memory == "none" or two or not _is_shuffled(run):
        return replace(recording, run=_with_history(recording, memory))
    rows = np.argsort(run.column("time_s"), kind="stable")
    back = np.argsort(rows)
    moved = replace(recording, run=run.take(rows), row=back[recording.row])
    past = _with_history(moved, memory).take(back)
    note = "the rows do not stand in the order of their clock: senses, travels and distances since a reversal are those of the order of time"
    return replace(recording, run=past, notes=(*recording.notes, note))


def _is_shuffled(run: Run) -> bool:
    """Does a clock that gives every row a time of its own go back in more than a quarter of the rows? In a random order it does so in
    half of them; a clock that began anew goes back once per run.
    """
    if "time_s" not in run.columns or run.n < 2:
        return False
    time = run.column("time_s")
    return len(np.unique(time)) == run.n and float(np.mean(np.diff(time) < 0)) > QUARTER


def _with_history(recording: Recording, memory: str) -> Run:
    """Return the run with travel, sense and since_reversal (of a dense path also speed and acceleration) where the file lacks them.

    memory "travel": only the distance travelled, row by row in order; "rows": rows follow one another without detours
    or reversals in between. The second end of a length has the history of its first end.
    """
    run = recording.run
    if memory == "none" or run.n < 2:
        return _with_reversal_distance(run)
    two = recording.other >= 0
    rows = run.take(np.arange(run.n - two.sum())) if two.any() else run
    axes = list(rows.position)
    _check_order(rows)
    columns: dict[str, Array] = {f"travel_{a}_{axis_unit(a)}": travel(rows.q(a)) for a in axes}
    if memory in ("rows", "path"):
        columns |= row_history(rows, axes, _starts(rows), recording.kind == "displacement")
    if memory == "path":
        columns |= path_history(rows.position, rows.column("time_s"))
    accelerated = [c for c in rows.columns if re.fullmatch(r"accel_[XYZ]_mm_s2", c)]
    if memory in ("rows", "path") and accelerated and "time_s" in rows.columns and recording.kind == "path":
        size = np.linalg.norm(np.stack([rows.columns[c] for c in accelerated], axis=1), axis=1)
        columns["time_since_accel_s"] = time_since_acceleration(size, rows.column("time_s"))
    new = {name: values for name, values in columns.items() if name not in run.columns}
    if two.any():
        source = np.concatenate([np.arange(rows.n), recording.row[two]])
        new = {name: values[source] for name, values in new.items()}
    return _with_reversal_distance(run.with_columns(new))


def _with_reversal_distance(run: Run) -> Run:
    """Return the run with turned_X where sense, distance since the last reversal and clock of the rows are known."""
    positions = [
        a
        for a in run.position
        if {f"sense_{a}", f"since_reversal_{a}_{axis_unit(a)}", "time_s"} <= set(run.columns)
    ]
    return run.with_columns(
        {f"turned_{a}": rows_after_turning(run.column(f"sense_{a}"), run.column("time_s")) for a in positions}
    )


def _with_part(recording: Recording, machine: Machine) -> Recording:
    """Return the recording with part_x_mm ... where the file lacks them: the tip from the middle of its placement's points.

    The place where the part is held is unknown; a free placement absorbs the effect of another origin while the part is warm.
    """
    run = recording.run
    if recording.kind not in ("probe", "path") or "part_x_mm" in run.columns:
        return recording
    label = next((recording.nuisance[w] for w in ("rigid", "alignment") if w in recording.nuisance), "pose")
    values = run.labels.get(label, np.zeros(run.n, dtype=np.str_))
    tip = machine.prepare(run).tip
    for value in np.unique(values):
        rows = values == value
        tip[rows] -= tip[rows].mean(axis=0)
    return replace(recording, run=run.with_columns({f"part_{c}_mm": tip[:, i] for i, c in enumerate("xyz")}))


def _with_down(recording: Recording, machine: Machine, down: list[float] | None) -> Recording:
    """Return the recording with gravity in the frame of the tool, where the file states which way is down."""
    if down is None:
        return recording
    return replace(recording, run=with_down(recording.run, machine, np.array(down)))


def _starts(run: Run) -> Any:
    """Return the rows (n,) at which a label shows that something else begins."""
    out = np.zeros(run.n, dtype=bool)
    for label in BREAKS:
        if label in run.labels:
            out[1:] |= run.labels[label][1:] != run.labels[label][:-1]
    return out


def _check_order(run: Run) -> None:
    if "time_s" not in run.columns:
        return
    back = np.flatnonzero((np.diff(run.column("time_s")) < 0) & ~_starts(run)[1:])
    if len(back):
        raise UsageError(
            f"time_s goes back at row {int(back[0]) + 2}; rows stand in the order in which they were made. Sort them, or "
            'write history = "none"'
        )


def missing_columns(run: Run, machine: Machine) -> tuple[str, ...]:
    """Return the columns and labels that a recording may have and this one lacks, as a run names them."""
    absent_axes = [a for a in LETTERS if a not in machine.chain.letters]
    pattern = re.compile(
        r"u_|reading_|(part|tip|from|offset)_[xyz]_mm|probe_lateral|" + "|".join(OBSERVED_COLUMNS)
    )
    of_axis = re.compile(rf"(sense|since_reversal|speed|accel|raw|travel)_[{''.join(absent_axes)}](_|$)")
    columns = [
        c for c in run_columns() if c not in run.columns and not pattern.match(c) and not of_axis.match(c)
    ]
    return (*columns, *(label for label in LABELS if label not in run.labels))


__all__ = ["RecordingFile", "load_recording", "machine_of", "missing_columns", "recording_file"]
