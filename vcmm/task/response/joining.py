"""Join several recordings of one machine: the machine is common to all, set-ups and logs belong to each recording.

nuisance   one copy per recording (and per value of its own label)
labels     pose, setup, run, event, clamp and repeat are those of a recording; stylus, tool, part ... are things, and the
           same word is the same thing in all of them
columns    those that all recordings have; the others are left out, and named
clock      recordings whose times follow one another share a clock; others are set one after another, so far apart that a
           log has settled in between
noise      the common statement, or the standard uncertainty of every observation
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run, Series
from vcmm.physics.structure.scatter import Scatter
from vcmm.task.response.nuisance import NO_COPY
from vcmm.task.response.observe import noise_u
from vcmm.task.response.recording import SOURCE_LABEL, Ints, Recording

OWN_LABELS = ("pose", "setup", "run", "event", "clamp", "repeat")
# s: after a day the slowest structure that is looked for (a lag of 6 h) has settled to 1 %
SETTLING_TIME = 1e5


@dataclass(frozen=True, eq=False)
class JoinedRecordings:
    """recording: all of them as one; part (m,): number of the recording of each observation; left_out: column -> recordings
    that lack it.
    """

    recording: Recording
    part: Ints
    left_out: dict[str, tuple[str, ...]]


def join_recordings(recordings: Sequence[Recording], machine: Machine) -> JoinedRecordings:
    """Return recordings of one machine as one. Raises UsageError where they differ in kind or sense, or share a name."""
    _check(recordings)
    shifted = [_on_common_clock(r, by) for r, by in zip(recordings, _shifts(recordings))]
    runs = [_label_own(r) for r in shifted]
    run, left_out = _one_run(runs, [r.name for r in recordings])
    first = np.cumsum([0, *(r.run.n for r in recordings)])[:-1]
    law = recordings[0].noise
    stated = all(r.noise == law and r.u is None for r in recordings)
    u = None if stated else np.concatenate([noise_u(r, machine) for r in recordings])
    words = dict.fromkeys(w for r in recordings for w in r.nuisance)
    joined = Recording(
        " + ".join(r.name for r in recordings),
        recordings[0].kind,
        run,
        value=np.concatenate([r.value for r in recordings]),
        notes=tuple(f"{r.name}: {note}" for r in recordings for note in r.notes),
        measuring=recordings[0].measuring,
        row=np.concatenate([r.row + k for r, k in zip(recordings, first)]),
        direction=np.concatenate([r.direction for r in recordings]),
        other=np.concatenate([np.where(r.other >= 0, r.other + k, -1) for r, k in zip(recordings, first)]),
        u=u,
        nuisance={w: _copy_label(w) for w in words},
        noise=law if stated else None,
        missing=tuple(dict.fromkeys([*left_out, *(c for r in recordings for c in r.missing)])),
        index={f"{r.name}: {k}": v for r in recordings for k, v in r.index.items()},
        known=_join_knowledge(recordings, machine),
        chosen_from=_chosen_from(recordings),
        record=joined_record([r.record for r in recordings]),
    )
    part = np.repeat(np.arange(len(recordings)), [r.m for r in recordings])
    return JoinedRecordings(joined, part, left_out)


def joined_record(records: Iterable[Mapping[str, str]]) -> dict[str, str]:
    """Join several records into one: entries that differ are listed side by side, dates as the first and the last."""
    values: dict[str, list[str]] = {}
    for record in records:
        for key, text in record.items():
            values.setdefault(key, []).append(text)
    different = {key: list(dict.fromkeys(texts)) for key, texts in values.items()}
    dates = sorted(different.pop("date", []))
    out = {key: "; ".join(texts) for key, texts in different.items()}
    return out | ({"date": dates[0] if len(dates) == 1 else f"{dates[0]} to {dates[-1]}"} if dates else {})


def _chosen_from(recordings: Sequence[Recording]) -> int:
    """Return the number of observations from which those of all recordings were chosen; 0 where none was thinned."""
    thinned = any(r.chosen_from for r in recordings)
    return sum(r.chosen_from or r.m for r in recordings) if thinned else 0


def _join_knowledge(recordings: Sequence[Recording], machine: Machine) -> tuple[tuple[str, Array], ...]:
    """Join the knowledge of recordings: knowledge of numbers of the machine acts on all rows together, knowledge of one recording on its own rows."""
    m = [r.m for r in recordings]
    of_machine = {i.id for i in machine.inputs if i.effect != Scatter.name}
    out: list[tuple[str, Array]] = []
    for k, recording in enumerate(recordings):
        for name, columns in recording.known:
            whole = np.zeros((sum(m), columns.shape[1]))
            whole[sum(m[:k]) : sum(m[: k + 1])] = columns
            if name not in of_machine:
                out.append((f"{recording.name}: {name}", whole))
    common = of_machine & set[str].intersection(*({name for name, _ in r.known} for r in recordings))
    for name in sorted(common):
        out.append((name, np.concatenate([dict(r.known)[name] for r in recordings])))
    return tuple(out)


def _check(recordings: Sequence[Recording]) -> None:
    for what in ("kind", "measuring"):
        values = {getattr(r, what) for r in recordings}
        if len(values) > 1:
            listed = ", ".join(
                f"{r.name}: {r.kind}, {'indicated - true' if r.measuring else 'actual - commanded'}"
                for r in recordings
            )
            raise UsageError(
                f"recordings of several kinds cannot be joined ({listed}); diagnose each kind by itself"
            )
    names = [r.name for r in recordings]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f'two recordings are called "{name}"; give them names, name = "..."')
    axes = {tuple(sorted(r.run.position)) for r in recordings}
    if len(axes) > 1:
        raise UsageError(
            f"recordings of different axes cannot be joined: {' and '.join(' '.join(a) for a in sorted(axes))}"
        )


def _shifts(recordings: Sequence[Recording]) -> list[float]:
    """Return the shift of time of each recording (s): zero while they follow one another on one clock."""
    ends = [_span(r.run) for r in recordings]
    if all(e is None for e in ends):
        return [0.0] * len(recordings)
    spans = [e or (0.0, 0.0) for e in ends]
    if all(a[1] < b[0] for a, b in pairwise(spans)):
        return [0.0] * len(recordings)
    out, begin = [], 0.0
    for low, high in spans:
        out.append(begin - low)
        begin += high - low + SETTLING_TIME
    return out


def _span(run: Run) -> tuple[float, float] | None:
    time = [run.column("time_s")] if "time_s" in run.columns else []
    time += [s.time for s in run.series.values()] if time else []
    return (min(float(t.min()) for t in time), max(float(t.max()) for t in time)) if time else None


def _on_common_clock(recording: Recording, shift: float) -> Recording:
    run = recording.run
    if shift == 0.0 or "time_s" not in run.columns:
        return recording
    columns = {**run.columns, "time_s": run.column("time_s") + shift}
    logs = {name: Series(s.time + shift, s.value) for name, s in run.series.items()}
    return replace(recording, run=replace(run, columns=columns, series=logs))


def _copy_label(word: str) -> str:
    return f"{word} of {SOURCE_LABEL}"


def _label_own(recording: Recording) -> Run:
    """Return the run with its own labels made different from those of other recordings."""
    run, name = recording.run, recording.name
    labels = dict(run.labels) | {SOURCE_LABEL: np.full(run.n, name)}
    for label in OWN_LABELS:
        if label in run.labels or label in ("setup", "run"):
            names = run.labels.get(label, np.full(run.n, ""))
            labels[label] = np.array([f"{name} {v}".strip() for v in names])
    for word, label in recording.nuisance.items():
        names = run.labels.get(label, np.full(run.n, ""))
        labels[_copy_label(word)] = np.array([f"{name} {v}".strip() for v in names])
    return replace(run, labels=labels)


def _one_run(runs: Sequence[Run], names: Sequence[str]) -> tuple[Run, dict[str, tuple[str, ...]]]:
    every = dict.fromkeys(c for r in runs for c in r.columns)
    lacking = {c: tuple(n for r, n in zip(runs, names) if c not in r.columns) for c in every}
    left_out = {c: who for c, who in lacking.items() if who}
    columns = {c: np.concatenate([r.columns[c] for r in runs]) for c in every if c not in left_out}
    labels = {
        label: np.concatenate([_words(r, label) for r in runs])
        for label in dict.fromkeys(x for r in runs for x in r.labels)
    }
    position = {a: np.concatenate([r.q(a) for r in runs]) for a in runs[0].position}
    offset = np.concatenate([r.offset for r in runs])
    return Run(position, offset, columns, labels, _one_log(runs)), left_out


def _words(run: Run, label: str) -> np.ndarray:
    """Return the label of every row; where a recording lacks it no copy of a nuisance, and for other labels one value."""
    return run.labels.get(label, np.full(run.n, NO_COPY if label.endswith(f" of {SOURCE_LABEL}") else ""))


def _one_log(runs: Sequence[Run]) -> dict[str, Series]:
    """Return the logs that all runs have, one after another; between two clocks a log jumps at once to where the next one begins."""
    shared = set(runs[0].series).intersection(*(r.series for r in runs[1:]))
    out = {}
    for name in sorted(shared):
        logs = sorted((r.series[name] for r in runs), key=lambda s: float(s.time[0]))
        time, value = [logs[0].time], [logs[0].value]
        for before, after in pairwise(logs):
            if float(after.time[0]) <= float(before.time[-1]):  # one log, given twice
                late = after.time > before.time[-1]
                after = Series(after.time[late], after.value[late])
            elif float(after.time[0]) - float(before.time[-1]) > SETTLING_TIME / 2:
                time.append(before.time[-1:] + 1.0)
                value.append(after.value[:1])
            time.append(after.time)
            value.append(after.value)
        out[name] = Series(np.concatenate(time), np.concatenate(value))
    return out
