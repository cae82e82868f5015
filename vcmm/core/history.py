"""Compute the history of an axis before each row: sense, travel since reversal, speed, state of play.

Backlash, hysteresis, reversal spikes and servo lag depend on how a place was reached. Effects are row-wise, so that
memory is turned into columns once, here:

    sense_X                direction in which the axis last moved, -1 or 1; 0 where it is not known
    since_reversal_X_mm    distance travelled since the last reversal (the start of the path counts as one)
    turned_X               1 once the axis has turned within the rows, 0 before; where it lacks the start counts as a reversal
    travel_X_mm            distance travelled since the start, to and fro
    speed_X_mm_s           signed
    accel_X_mm_s2          signed
    time_since_accel_s     since the linear axes last accelerated (the start counts as such)
    play_X_5um_mm          how far the axis leads a follower with 5 um of play, within -5 um and 5 um
    play_X                 how much of the play of the machine is taken up (`taken_up`), of paths of machines that have play

Rotary axes have the same columns in rad: since_reversal_C_rad, speed_C_rad_s, accel_C_rad_s2.

`path_history` takes the dense path, retract and approach included. `row_history` has only the rows of a recording,
in the order in which they were made, and claims only what follows from them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run

Bools = npt.NDArray[np.bool_]
Ints = npt.NDArray[np.intp]
RESTING = 0.05  # share of the largest acceleration of a path below which it is none
LEAST_COMPILED_ROWS = 20_000  # rows from which the walk along an axis is compiled
NO_REVERSAL = 1e-7  # mm or rad: an axis that moves back by less has not reversed (rounding of positions)


@dataclass(frozen=True, eq=False)
class Width:
    """half (n,): half of the play along a path; band (n,): way back below which an axis has not turned; mm or rad."""

    half: Array
    band: Array


def play_name(axis: str) -> str:
    """Name of the column that says how much of the play of an axis is taken up."""
    return f"play_{axis}"


def taken_up(q: Array, half: Array) -> Array:
    """Return the state of play, play_X (n,), along positions q (n,) with half the play h (n,), mm or rad: (q - follower) / h, which is 1
    or -1 where the play is taken up.

        follower_i = min(max(follower_i-1, q_i - h), q_i + h)

    The slide hangs behind its command by q - follower: an axis that turns back by less than its play moves no slide, so small
    corrections of a path turn nothing round. The slide starts in the middle. Source: as `play`.
    """
    out = np.zeros(len(q))
    follower = float(q[0]) if len(q) else 0.0
    for i, (x, h) in enumerate(zip(q.tolist(), half.tolist())):
        follower = min(max(follower, x - h), x + h)
        out[i] = (x - follower) / h if h > 0.0 else out[max(i - 1, 0)]
    return out


def taken_up_between(before: Array, q_before: Array, q: Array, half: Array) -> Array:
    """Return play_X (k,) at positions q (k,) on the straight way from rows at q_before (k,), where it was `before` (k,)."""
    wide = np.where(half > 0.0, half, 1.0)
    return np.where(half > 0.0, np.clip(before + (q - q_before) / wide, -1.0, 1.0), before)


def sense_and_since(q: Array, still: float | Array = NO_REVERSAL) -> tuple[Array, Array]:
    """Return the sense (n,) and the distance since the last reversal (n,) along positions q (n,), mm or rad.

    A reversal is noticed once the axis has come back from its furthest point by more than `still` (one, or n of them), and counts
    from that furthest point. The first reversal is the start; before the axis first moves its sense is 0.
    """
    if len(q) >= LEAST_COMPILED_ROWS:
        from vcmm.core import _history_kernels as kernels

        band = np.ascontiguousarray(np.broadcast_to(np.asarray(still, dtype=float), len(q)))
        pair = kernels.sense_and_since(np.ascontiguousarray(q, dtype=float), band, NO_REVERSAL)
        return np.asarray(pair[0]), np.asarray(pair[1])
    sense, since = np.zeros(len(q)), np.zeros(len(q))
    direction, turned = 0, float(q[0]) if len(q) else 0.0
    furthest = turned
    for i, (x, least) in enumerate(zip(q.tolist(), np.broadcast_to(still, len(q)).tolist())):
        ahead = (x - furthest) * direction if direction else abs(x - furthest)
        if ahead > 0 and direction:
            furthest = x
        elif (direction and ahead < -least) or (not direction and ahead > NO_REVERSAL):
            direction, turned, furthest = (1 if x > furthest else -1), furthest, x
        sense[i], since[i] = direction, abs(furthest - turned)
    return sense, since


def axis_unit(axis: str) -> str:
    """Return the unit of an axis in column names: mm, or rad for a rotary axis."""
    return "mm" if axis in "XYZ" else "rad"


def travel(q: Array) -> Array:
    """Return the distance travelled since the first position, to and fro (n,), in the unit of q (n,)."""
    return np.concatenate([np.zeros(min(len(q), 1)), np.cumsum(np.abs(np.diff(q)))])


def play(q: Array, radius: float) -> Array:
    """Apply the play operator (Krasnosel'skii & Pokrovskii, Systems with Hysteresis, 1989): return q - follower (n,), within +-radius.

    The follower rests until the axis has left it behind by `radius`. It starts in the middle of its play.
    """
    if not radius > 0:
        raise UsageError(f"a play of {radius:g} mm must be positive; write for example 0.005")
    out = np.zeros(len(q))
    follower = float(q[0]) if len(q) else 0.0
    for i, x in enumerate(q.tolist()):
        follower = min(max(follower, x - radius), x + radius)
        out[i] = x - follower
    return out


def speed_and_acceleration(q: Array, time: Array) -> tuple[Array, Array]:
    """Return the signed speed and acceleration (n,) of positions q (n,) at times (n,) s, by differences of neighbours.

    Central differences, of second order for a smooth path. Raises UsageError where two times are equal.
    """
    back = np.flatnonzero(np.diff(time) <= 0)
    if len(back):
        i = int(back[0]) + 1
        raise UsageError(f"time_s is {time[i]:g} in row {i + 1}, after {time[i - 1]:g}; it must increase")
    if len(q) < 2:
        return np.zeros(len(q)), np.zeros(len(q))
    step = np.diff(time)
    slope = np.diff(q) / step
    bend = 2 * np.diff(slope) / (step[1:] + step[:-1])
    inner = np.concatenate([bend[:1], bend, bend[-1:]]) if len(bend) else np.zeros(len(q))
    return np.gradient(q, time), inner


def time_since_acceleration(acceleration: Array, time: Array) -> Array:
    """Return the time (n,) s since |acceleration| (n,) was last above RESTING of its maximum; the start counts as such."""
    size = np.abs(acceleration)
    active = size > RESTING * size.max(initial=0.0)
    active[:1] = True
    last = np.maximum.accumulate(np.where(active, np.arange(len(time)), 0))
    return time - time[last]


def path_history(
    position: Mapping[str, Array],
    time: Array | None = None,
    radii: Sequence[float] = (),
    widths: Mapping[str, Width] | None = None,
) -> dict[str, Array]:
    """Return the columns of a dense path: position of each axis (n,) mm or rad, time (n,) s.

    radii: plays in mm or rad for which the play state is kept. Speed and acceleration need `time`.
    widths: the play of the axes that have it (vcmm.core.play.widths).
    """
    out: dict[str, Array] = {}
    for axis, q in position.items():
        unit = axis_unit(axis)
        width = (widths or {}).get(axis)
        band = NO_REVERSAL if width is None else width.band
        out[f"sense_{axis}"], out[f"since_reversal_{axis}_{unit}"] = sense_and_since(q, band)
        if width is not None and width.half.any():
            out[play_name(axis)] = taken_up(q, width.half)
        out[f"travel_{axis}_{unit}"] = travel(q)
        if time is not None:
            speed, acceleration = speed_and_acceleration(q, time)
            out[f"speed_{axis}_{unit}_s"], out[f"accel_{axis}_{unit}_s2"] = speed, acceleration
        for radius in radii:
            out[play_column(axis, radius)] = play(q, radius)
    linear = [out[f"accel_{a}_mm_s2"] for a in position if a in "XYZ" and time is not None]
    if linear and time is not None:
        out["time_since_accel_s"] = time_since_acceleration(np.linalg.norm(linear, axis=0), time)
    return out


def play_column(axis: str, radius: float) -> str:
    """Name of a play state: play_X_5um_mm, play_C_20urad_rad."""
    return f"play_{axis}_{radius * 1e3:g}um_mm" if axis in "XYZ" else f"play_{axis}_{radius * 1e6:g}urad_rad"


def row_history(
    run: Run, axes: Sequence[str], starts: Bools | None = None, positioned: bool = False
) -> dict[str, Array]:
    """Return sense and since_reversal computed from the rows of a run alone, for the axes that lack them.

    starts (n,): rows before which something unseen may have happened (another run, another set-up); each begins anew.
    positioned: the rows are targets approached one by one (ISO 230-2), not a dense path. Then the first target of a
    stretch was approached in the direction in which the stretch goes on, and a target that is repeated at a turning
    point was left, overrun and approached from beyond. Of three or more repeats there, those in between stay unknown.
    """
    fresh = np.zeros(run.n, dtype=bool) if starts is None else starts.copy()
    fresh[:1] = True
    out: dict[str, Array] = {}
    for axis in axes:
        q, unit = run.q(axis), axis_unit(axis)
        sense_name, since_name = f"sense_{axis}", f"since_reversal_{axis}_{unit}"
        sense = run.columns.get(sense_name)
        if sense is None:
            sense = _sense_of_rows(q, fresh, positioned)
        columns = {sense_name: sense, since_name: since_reversal(q, sense, fresh)}
        out |= {name: values for name, values in columns.items() if name not in run.columns}
    return out


def _sense_of_rows(q: Array, fresh: Bools, positioned: bool) -> Array:
    """Return the sense (n,) of every stretch on its own; positioned: its first rows take the sense of its first move."""
    sense = np.zeros(len(q))
    first = np.flatnonzero((fresh | turning_repeats(q)) if positioned else fresh)
    for begin, end in zip(first, [*first[1:], len(q)]):
        sense[begin:end] = sense_and_since(q[begin:end])[0]
        moves = np.flatnonzero(sense[begin:end])
        if positioned and len(moves):
            sense[begin : begin + moves[0]] = sense[begin + moves[0]]
    return sense


def since_reversal(q: Array, sense: Array, fresh: Bools) -> Array:
    """Return the distance (n,) since the sense of an axis last changed sign; rows marked `fresh` begin anew.

    The first row is one of them. An axis that comes back turned at the row before. One that arrives against its way from there (or without any)
    turned beyond the target at an unknown place, and counts from the target.
    """
    rows = np.arange(len(q))
    before = np.concatenate([q[:1], q[:-1]])
    last_known = np.maximum.accumulate(
        np.where(fresh | (sense != 0), rows, 0)
    )  # where the sense was last known
    last = np.concatenate([np.zeros(min(len(q), 1)), sense[last_known][:-1]])
    beyond = fresh | ((q - before) * sense < 0)
    turned = np.where(beyond, q, before)
    event = np.maximum.accumulate(np.where(beyond | (sense * last < 0), rows, 0))
    return np.abs(q - turned[event])


def rows_after_turning(sense: Array, time: Array) -> Array:
    """Return turned_X (n,): 1 from the first row on, by the clock (n,), at which the known sense of an axis has changed; else 0."""
    order = np.argsort(time, kind="stable")
    moving = order[sense[order] != 0]
    changes = np.flatnonzero(np.diff(sense[moving]) != 0)
    return (time >= time[moving[changes[0] + 1]]).astype(float) if len(changes) else np.zeros(len(sense))


def turning_repeats(q: Array) -> Bools:
    """Return the rows (n,) at which a target is repeated at a turning point of the targets; see `row_history`.

    Of k repeats the second to the last are marked, so that only the last goes on in the new direction.
    """
    out = np.zeros(len(q), dtype=bool)
    begin, at = 0, q.tolist()
    for end in range(1, len(q) + 1):
        if end < len(q) and abs(at[end] - at[begin]) <= NO_REVERSAL:
            continue
        before = at[begin] - at[begin - 1] if begin else 0.0
        after = at[end] - at[begin] if end < len(q) else 0.0
        if before * after < 0:
            out[begin + 1 : end] = True
        begin = end
    return out
