"""Signs that contradict one another: speeds against normals, senses against speeds, speeds against the motion itself."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.task.response.recording import Recording

MOST = 0.9  # share of the rows from which a sign is called reversed
ENOUGH = 20  # rows that can tell


def sign_warnings(recording: Recording) -> list[str]:
    """One sentence per contradiction."""
    return [*_approach(recording), *_senses(recording), *_speeds(recording)]


def _approach(recording: Recording) -> list[str]:
    """A touch moves against the outward normal: v . n is negative."""
    run = recording.run
    names = [f"speed_{a}_mm_s" for a in "XYZ"]
    if recording.kind != "probe" or not set(names) <= set(run.columns):
        return []
    v = run.vector(*names)[recording.row]
    along, size = (v * recording.direction).sum(axis=1), np.linalg.norm(v, axis=1)
    use = (np.abs(along) > 0.5 * size) & (size > 0) & ~_is_scan(recording)
    away = use & (along > 0)
    if use.sum() < ENOUGH or not away.any():
        return []
    if away.sum() > MOST * use.sum():
        return [
            f"in {int(away.sum())} of {int(use.sum())} touches the tip moves away from the surface (speed . normal > 0):"
            " either nx ny nz point into the material or the speeds have the wrong sign; a trigger delay and a tip"
            " radius would come out with the wrong sign"
        ]
    if away.sum() < 0.2 * use.sum():
        return [
            f"{recording.places(away)}: the tip moves away from the surface (speed . normal > 0), against the other rows"
        ]
    return []


def _is_scan(recording: Recording) -> npt.NDArray[np.bool_]:
    mode = recording.run.labels.get("mode")
    return np.zeros(recording.m, dtype=bool) if mode is None else (mode == "scan")[recording.row]


def _senses(recording: Recording) -> list[str]:
    """The sense of an axis is the sign of its speed."""
    out = []
    for axis in recording.run.position:
        sense, speed = _column(recording, f"sense_{axis}"), _speed(recording, axis)
        if sense is None or speed is None:
            continue
        use = (sense != 0) & (np.abs(speed) > 1e-9)
        against = use & (np.sign(speed) != np.sign(sense))
        if use.sum() >= ENOUGH and against.sum() > MOST * use.sum():
            out.append(
                f"sense_{axis} and speed_{axis} have opposite signs in {int(against.sum())} of {int(use.sum())} rows; one"
                " of them is reversed, and backlash and lag would come out with opposite signs"
            )
    return out


def _speeds(recording: Recording) -> list[str]:
    """Along a trace the speed is the change of the position with time."""
    time, out = _column(recording, "time_s"), []
    if time is None or recording.kind not in ("path", "angle"):
        return []
    for axis in recording.run.position:
        speed, q = _speed(recording, axis), recording.run.position[axis][recording.row]
        step = np.diff(time)
        use = step > 0
        if speed is None or use.sum() < ENOUGH or np.ptp(q) == 0:
            continue
        moved = np.diff(q)[use] / step[use]
        stated = ((speed[1:] + speed[:-1]) / 2)[use]
        if np.std(moved) > 0 and np.std(stated) > 0 and np.corrcoef(moved, stated)[0, 1] < -0.5:
            out.append(f"speed_{axis} has the opposite sign of the motion along {axis} between the rows")
    return out


def _column(recording: Recording, name: str) -> Array | None:
    values = recording.run.columns.get(name)
    return None if values is None else values[recording.row]


def _speed(recording: Recording, axis: str) -> Array | None:
    unit = "mm" if axis in "XYZ" else "rad"
    return _column(recording, f"speed_{axis}_{unit}_s")
