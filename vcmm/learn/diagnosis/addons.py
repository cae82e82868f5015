"""Add-ons: the rows of a recording measured again with one thing changed, as they would be.

A second stylus length, another speed, the approach from the other side, the artefact turned, a temperature step, a longer log. Only
rows, columns and labels are made; nothing is measured.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from vcmm.core.run import Array, Run, Series
from vcmm.learn.diagnosis.problem import Problem
from vcmm.task.response.logs import RememberingRun
from vcmm.task.response.recording import Recording

ROWS = 80  # of the recording repeated in an add-on, and quantiles of the evidence that it adds
PER_TOUCH = 10.0  # s
STANDS = 0.05  # component of the normal below which an axis has stopped before the touch
ALONG = 15.0  # minutes to set an instrument up along an axis
STRETCH = 2.0  # times the length of the log by which it is continued

Change = Callable[[Run], Run | None]


@dataclass(frozen=True)
class AddOn:
    """An add-on. do: instruction for the operator; minutes: beyond the touches themselves; change: the rows as they would be."""

    do: str
    minutes: float
    change: Change


def instruction(addon: AddOn, problem: Problem) -> str:
    """Return what to do, in the words of the kind of recording: only a probe touches."""
    return addon.do if problem.recording.kind == "probe" else addon.do.replace("some touches", "some rows")


def minutes_of(addon: AddOn, problem: Problem) -> float:
    """Return the minutes of the set-up, and of the rows at the pace of the recording; a longer log takes its own time once more, twice."""
    time = problem.run.columns.get("time_s")
    steps = np.diff(np.unique(time)) if time is not None else np.zeros(0)
    if addon.change is _longer_log and time is not None:
        seconds = STRETCH * float(np.ptp(time))
        return float(f"{seconds / 60:.2g}") if seconds < 6000 else float(round(seconds / 60))
    pace = float(np.median(steps)) if len(steps) and problem.recording.kind != "probe" else PER_TOUCH
    return float(round(addon.minutes + min(ROWS, problem.m) * pace / 60))


def extend_recording(problem: Problem, addon: AddOn) -> tuple[Recording, Array] | None:
    """Return the recording with the rows of the add-on behind it, and u of all observations; None where it cannot be done."""
    recording = problem.recording
    if (recording.other >= 0).any():
        return None
    chosen = np.unique(np.linspace(0, recording.m - 1, min(ROWS, recording.m)).astype(np.intp))
    rows = recording.row[chosen]
    run = problem.recording.run
    touches = recording.kind == "probe" and addon.change is _other_side
    change = _other_side_of_touches if touches else addon.change
    new = change(run.take(rows))
    if new is None:
        return None
    both = join_runs(run, new)
    added = np.arange(run.n, run.n + len(rows))
    out = replace(
        recording,
        run=both,
        value=np.concatenate([recording.value, np.zeros(len(rows))]),
        row=np.concatenate([recording.row, added]),
        direction=np.concatenate([recording.direction, new_direction(new, recording.direction[chosen])]),
        other=np.concatenate([recording.other, np.full(len(rows), -1)]),
        u=None if recording.u is None else np.concatenate([recording.u, recording.u[chosen]]),
    )
    return out, np.concatenate([problem.u, problem.u[chosen]])


def new_direction(new: Run, old: Array) -> Array:
    """Return the normals of the added rows where they were turned, else as they were."""
    return new.normal if "turned" in new.labels and "nx" in new.columns else old


def join_runs(a: Run, b: Run) -> Run:
    """Return the rows of a, then those of b."""
    series = {**a.series, **b.series}
    return RememberingRun(
        {k: np.concatenate([v, b.position[k]]) for k, v in a.position.items()},
        np.concatenate([a.offset, b.offset]),
        {k: np.concatenate([v, b.columns[k]]) for k, v in a.columns.items() if k in b.columns},
        {k: np.concatenate([v, b.labels[k]]) for k, v in a.labels.items() if k in b.labels},
        series,
    )


def _other_speed(run: Run) -> Run | None:
    names = [c for c in run.columns if c.startswith("speed_")]
    return run.with_columns({c: 2.5 * run.columns[c] for c in names}) if names else None


def _other_side(run: Run) -> Run | None:
    names = [c for c in run.columns if c.startswith("sense_")]
    return run.with_columns({c: -run.columns[c] for c in names}) if names else None


def _other_side_of_touches(run: Run) -> Run | None:
    """Return the run with touches from the other side. None where all do."""
    turned = _other_side(run)
    if turned is None or "nx" not in run.columns:
        return None
    stays = {f"sense_{a}": np.abs(run.normal[:, i]) > STANDS for i, a in enumerate("XYZ")}
    kept = {
        c: np.where(still, run.columns[c], turned.columns[c])
        for c, still in stays.items()
        if c in run.columns
    }
    return turned.with_columns(kept) if any(np.any(v != run.columns[c]) for c, v in kept.items()) else None


def _longer_way(run: Run) -> Run | None:
    names = [c for c in run.columns if c.startswith("since_reversal_")]
    return run.with_columns({c: 0.1 * run.columns[c] for c in names}) if names else None


def _longer_stylus(run: Run) -> Run | None:
    if "stylus_length_mm" not in run.columns or "stylus" not in run.labels:
        return None
    out = run.with_columns({"stylus_length_mm": 2.0 * run.columns["stylus_length_mm"]})
    labels = {**run.labels, "stylus": np.array([f"{s} long" for s in run.labels["stylus"]])}
    return replace(out, labels=labels)


def _turn_artefact(run: Run) -> Run | None:
    """Return the run with the artefact turned by 90 degrees about the vertical, about its own middle: a new pose."""
    if not {"X", "Y", "Z"} <= set(run.position) or "pose" not in run.labels or "nx" not in run.columns:
        return None
    tip = np.stack([run.position[a] + run.offset[:, i] for i, a in enumerate("XYZ")], axis=1)
    middle = tip.mean(axis=0)
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    moved = (tip - middle) @ turn.T + middle - run.offset
    columns = {**_rotate_vector(run, turn, "n{}"), **_rotate_vector(run, turn, "part_{}_mm")}
    for name in ("speed_{}_mm_s", "accel_{}_mm_s2", "sense_{}"):  # the approach turns with the artefact
        columns.update(_rotate_vector(run, turn, name, "XYZ"))
    if "probe_angle_rad" in run.columns:
        columns["probe_angle_rad"] = run.columns["probe_angle_rad"] + np.pi / 2
    labels = {
        **run.labels,
        "pose": np.array([f"{p} turned" for p in run.labels["pose"]]),
        "turned": np.full(run.n, "yes"),
    }
    return replace(
        run.with_columns(columns),
        position={**run.position, **{a: moved[:, i] for i, a in enumerate("XYZ")}},
        labels=labels,
    )


def _rotate_vector(run: Run, turn: Array, name: str, letters: str = "xyz") -> dict[str, Array]:
    """Return three columns of a vector, turned; nothing where one of them is missing."""
    names = [name.format(c) for c in letters]
    if not set(names) <= set(run.columns):
        return {}
    return dict(zip(names, (run.vector(*names) @ turn.T).T))


def _warmer(run: Run) -> Run | None:
    """Return the run with two kelvin more for everything, steady long enough to soak: later, and with the logs continued."""
    names = [c for c in run.columns if c.startswith("temp_")]
    if not names or "time_s" not in run.columns:
        return None
    out = _later(run, 4 * 3600.0)
    assert out is not None
    warm = {c: run.columns[c] + 2.0 for c in names}
    logs = {k: _continue_log(s, float(out.columns["time_s"].max()), 2.0) for k, s in run.series.items()}
    return replace(out.with_columns(warm), series=logs)


def _longer_log(run: Run) -> Run | None:
    return _later(run, 0.0, STRETCH)


def _later(run: Run, pause: float, stretch: float = 1.0) -> Run | None:
    if "time_s" not in run.columns:
        return None
    time = run.columns["time_s"]
    later = time.max() + pause + stretch * (time - time.min())
    logs = {k: _continue_log(s, float(later.max()), 0.0) for k, s in run.series.items()}
    return replace(run.with_columns({"time_s": later}), series=logs)


def _continue_log(log: Series, until: float, rise: float) -> Series:
    last, value = float(log.time[-1]), float(log.value[-1])
    if until <= last:
        return log
    return Series(
        np.append(log.time, [last + 1.0, until + 1.0]), np.append(log.value, [value + rise, value + rise])
    )


def along_axes(problem: Problem) -> tuple[AddOn, ...]:
    """Return runs of an instrument along one axis alone, where the recording moves several axes at once."""
    moving = [a for a, q in problem.run.position.items() if a in "XYZ" and np.ptp(q) > 0]
    if problem.recording.kind != "displacement" or len(moving) < 2:
        return ()
    return tuple(AddOn(f"run along {a} only", ALONG, partial(_along, a)) for a in moving)


def _along(axis: str, run: Run) -> Run | None:
    """Return the same rows with one axis alone moving, the instrument along it and set up anew."""
    still = {a: np.full(run.n, float(np.mean(q))) for a, q in run.position.items() if a != axis}
    columns = {f"n{c}": np.full(run.n, float(c.upper() == axis)) for c in "xyz"}
    columns |= {f"sense_{a}": np.zeros(run.n) for a in still if f"sense_{a}" in run.columns}
    columns_kept = {c: v for c, v in run.columns.items() if not c.startswith("counted_")}
    labels = {k: np.array([f"{v} {axis}" for v in run.labels[k]]) for k in run.labels if k == "setup"}
    labels = {**run.labels, **labels, "turned": np.full(run.n, "yes")}
    return replace(
        run, position={**run.position, **still}, columns={**columns_kept, **columns}, labels=labels
    )


ADDONS = (
    AddOn("repeat some touches at 2.5 times the approach speed", 5.0, _other_speed),
    AddOn("repeat some touches after moving up from the other side (reverse the preload)", 5.0, _other_side),
    AddOn("repeat some touches right after a reversal, at a tenth of the distance", 5.0, _longer_way),
    AddOn("repeat some touches with a stylus of twice the length", 15.0, _longer_stylus),
    AddOn("turn the artefact by 90 degrees and repeat some touches", 20.0, _turn_artefact),
    AddOn("repeat some touches two kelvin warmer, after soaking", 240.0, _warmer),
    AddOn("continue the log for twice the time", 0.0, _longer_log),
)
