"""Check that a recording is fit to be diagnosed: copies, dead or saturated sensors, impossible numbers, gaps, signs, belonging.

Rows that are no observations (copies of another row, a sensor at its stop) are left out, with a remark and
their lines; a recording that is unusable as a whole is refused. `doubtful` lowers what may be claimed.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.diagnosis.units_and_signs import sign_remarks, unit_remarks
from vcmm.task.response.observe import noise_u
from vcmm.task.response.recording import ALL_ROWS, SOURCE_LABEL, Ints, Recording

Mask = npt.NDArray[np.bool_]
FEWEST = 10  # fewest observations for a statement about a sensor
LARGEST_SHARE = 0.3  # of the observations that may be left out; more is no recording
CHANCE = 1e-4  # of a run of equal readings, or of readings at the stop, in a healthy sensor
SPREAD = 0.3  # K that another sensor must vary before a constant one is called dead
SENSORS = ("temp_", "pressure_", "humidity_")  # columns of sensors, which may be dead
READINGS = 10  # different readings of that other sensor: a coarse display that does not change proves nothing
GAP = 20.0  # times the usual distance in time
GAP_SHARE = 0.05  # of the whole time
FAHRENHEIT = (59.0, 95.0)  # 15 to 35 degC
NEAR_FAHRENHEIT = 8.0  # K between a sensor, taken for degF, and the others

# ending or beginning of a column -> least, largest, what is usual
LIMITS: tuple[tuple[Callable[[str], bool], float, float, str], ...] = (
    (lambda c: c.startswith("temp_gradient"), -50.0, 50.0, "a difference of temperatures is a few K"),
    (lambda c: c.startswith("temp_"), -40.0, 150.0, "temperatures are in degC"),
    (lambda c: c == "pressure_hPa", 500.0, 1100.0, "1013 hPa at sea level; 1 mmHg = 1.333 hPa"),
    (lambda c: c == "humidity_pct", 0.0, 100.0, "relative humidity in percent"),
    (lambda c: c.startswith(("since_reversal_", "travel_")), 0.0, np.inf, "a distance is not negative"),
    (lambda c: c in ("stylus_length_mm", "tip_radius_mm", "tool_radius_mm", "tool_length_mm", "cut_length_mm"),
     0.0, np.inf, "a length is not negative"),
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class SanityCheck:
    """The recording without the rows that are no observations; remarks; whether the claim must be lowered."""

    recording: Recording
    warnings: tuple[str, ...]
    doubtful: bool = False


def check_recording(recording: Recording, machine: Machine) -> SanityCheck:
    """Look at the numbers before any physics. Raises ModelLimit where there is nothing to diagnose."""
    _refuse_dead_sensor(recording)
    recording, warnings = without_dead_columns(recording)
    _refuse_impossible_log(recording)
    copied = partial(copied_rows, u=usual_u(recording, machine))
    out = np.zeros(recording.m, dtype=bool)
    for find in (copied, stuck_rows, saturated_rows, impossible_rows):
        mask, text = find(recording)
        fresh = mask & ~out
        if fresh.any():
            warnings.append(f"{recording.places(fresh)} left out: {text}")
            out |= mask
    if out.mean() > LARGEST_SHARE and not _only_copies(recording, copied, out):
        raise ModelLimit(
            f"{int(out.sum())} of {recording.m} observations cannot be used. " + ". ".join(warnings)
        )
    doubtful = bool(out.mean() > 0.1) and not _only_copies(recording, copied, out)
    kept = recording.take(~out) if out.any() else recording
    warnings += [
        *missing_label_remarks(kept),
        *constant_sensor_remarks(kept),
        *gap_remarks(kept),
        *sign_remarks(kept),
        *unit_remarks(kept, machine),
    ]
    return SanityCheck(kept, tuple(warnings), doubtful)


def _only_copies(recording: Recording, copied: Callable[[Recording], tuple[Mask, str]], out: Mask) -> bool:
    return bool((out == copied(recording)[0]).all())


def usual_u(recording: Recording, machine: Machine) -> float:
    """Return the stated noise of one observation, mm; 0 where none is known (which is refused later, by name)."""
    try:
        return float(np.median(noise_u(recording, machine)))
    except ModelLimit:
        return 0.0


def _refuse_dead_sensor(recording: Recording) -> None:
    if recording.m >= FEWEST and np.ptp(recording.value) == 0.0:
        raise ModelLimit(
            f"recording {recording.name}: all {recording.m} observations are {recording.value[0] * 1e3:g} um"
            " (or mrad): a dead sensor, or the wrong column"
        )


def copied_rows(recording: Recording, u: float = 0.0) -> tuple[Mask, str]:
    """Return observations that repeat an earlier one in every number: copied rows, which would count as further evidence.

    Without time stamps repeats of one place may agree to the last digit of a coarse display: two of them do so with
    probability q / (2 sqrt(pi) s), q its step, s the scatter of repeats (u, mm, where none differ). Where a place was reached in
    several ways s holds their differences too; pairs that differ by one step then tell how many are equal by chance: half of them,
    where the scatter is some steps wide. Copies are more than either.
    """
    none = np.zeros(recording.m, dtype=bool)
    rows = np.column_stack([recording.direction, *_of_rows(recording)])
    table = np.column_stack([recording.value, rows])
    _, first = np.unique(table, axis=0, return_index=True)
    copy = ~none
    copy[first] = False
    timed = _has_own_times(recording, ~copy)
    if not copy.any():
        return none, ""
    if not timed and (_may_be_chance(recording.value, rows, u) or not _in_a_row(copy)):
        return none, ""
    return copy, "copies of other rows, with the same reading to the last digit" + (
        "" if timed else " (if they are repeats, add time_s)"
    )


def _in_a_row(copy: Mask) -> bool:
    """Return whether some rows that repeat others follow one another. Copying copies stretches; single ones are repeats of a place."""
    return bool((copy[2:] & copy[1:-1] & copy[:-2]).any())


def _has_own_times(recording: Recording, kept: Mask) -> bool:
    """Return whether every row that is kept has a time of its own."""
    time = recording.run.columns.get("time_s")
    rows = np.unique(recording.row[kept])
    return time is not None and len(np.unique(time[rows])) == len(rows)


def _may_be_chance(value: Array, rows: Array, u: float) -> bool:
    """Return whether the equal readings of rows that agree in all else may be those of a coarse display."""
    from scipy.special import pdtrc

    _, place, count = np.unique(rows, axis=0, return_inverse=True, return_counts=True)
    place = np.ravel(place)
    same = np.unique(np.column_stack([place, value]), axis=0, return_counts=True)[1]
    pairs, equal = (int(np.sum(n * (n - 1) // 2)) for n in (count, same))
    if not equal or not np.ptp(value):
        return True
    mean = np.bincount(place, value) / count
    free = len(value) - len(count)
    scatter = float(np.sqrt(np.sum((value - mean[place]) ** 2) / free)) or u
    step = display_step(value)
    chance = min(step / (2.0 * np.sqrt(np.pi) * scatter), 1.0) if scatter > 0 else 1.0
    near = _within(value, place, step + 0.5 * step) - equal
    expected = max(pairs * chance, near / 2.0)
    return bool(pdtrc(equal - 1, expected) > CHANCE)


def _within(value: Array, place: Ints, reach: float) -> int:
    """Return the number of pairs of one place whose values differ by no more than reach."""
    total = 0
    order = np.lexsort((value, place))
    v, p = value[order], place[order]
    for piece in np.split(v, np.flatnonzero(np.diff(p)) + 1):
        above = np.searchsorted(piece, piece + reach, side="right")
        total += int(np.sum(above - np.arange(len(piece)) - 1))
    return total


def display_step(value: Array) -> float:
    """Return the largest decimal step of which all values (m,) are multiples, mm or rad; 0 for none above 1e-9."""
    steps = (m * 10.0**k for k in range(0, -10, -1) for m in (1.0, 0.5, 0.2))
    return next((s for s in steps if np.abs(value / s - np.round(value / s)).max() < 1e-3), 0.0)


def _of_rows(recording: Recording) -> list[Array]:
    run = recording.run
    columns = [*run.position.values(), *run.offset.T]
    columns += [v for name, v in run.columns.items() if name == "time_s" or name.startswith("temp_")]
    columns += [np.unique(v, return_inverse=True)[1].astype(float) for v in run.labels.values()]
    second = np.where(recording.other >= 0, recording.other, recording.row)
    columns_of_rows = [c[recording.row] for c in columns]
    return columns_of_rows + [run.position[a][second] for a in run.position]


def series_of(row: Ints) -> list[Ints]:
    """Return the observations of one series each, in order: d, or dx, dy and dz apart; row (m,): the run row of each observation."""
    order = np.argsort(row, kind="stable")
    first = np.r_[True, np.diff(row[order]) > 0]
    starts = np.maximum.accumulate(np.where(first, np.arange(len(row)), 0))
    place = np.arange(len(row)) - starts
    return [order[place == k].astype(np.intp) for k in range(int(place.max(initial=0)) + 1)]


def stuck_rows(recording: Recording) -> tuple[Mask, str]:
    """Return runs of one and the same reading, longer than the coarseness of the readings explains."""
    out = np.zeros(recording.m, dtype=bool)
    for series in series_of(recording.row):
        value = recording.value[series]
        if len(value) < FEWEST:
            continue
        starts = np.flatnonzero(np.r_[True, np.diff(value) != 0])
        length = np.diff(np.r_[starts, len(value)])
        longest = int(length.max())
        others = len(value) - longest
        equal = (others - (len(length) - 1) + 1.0) / (others + 2.0)  # share of equal neighbours elsewhere
        if longest >= 5 and len(value) * equal ** (longest - 1) < CHANCE:
            for k in np.flatnonzero(len(value) * equal ** (length - 1.0) < CHANCE):
                out[series[starts[k] : starts[k] + length[k]]] = True
    return out, "the reading does not change, although rows differ: the sensor was stuck"


def saturated_rows(recording: Recording) -> tuple[Mask, str]:
    """Return readings that pile up at their largest or smallest value: the end of the measuring range."""
    out = np.zeros(recording.m, dtype=bool)
    for series in series_of(recording.row):
        value = recording.value[series]
        kinds, count = np.unique(value, return_counts=True)
        if len(value) < FEWEST or len(kinds) < FEWEST:
            continue
        usual = float(np.quantile(count, 0.9))
        for end, near in ((0, count[1:4]), (-1, count[-4:-1])):
            if count[end] >= max(5.0, 3.0 * float(near.max()), 3.0 * usual):
                out[series[value == kinds[end]]] = True
    return out, "the reading is at the end of its range: the sensor is saturated"


def impossible_rows(recording: Recording) -> tuple[Mask, str]:
    """Return rows with a condition that no workshop has; a column that is so everywhere is refused."""
    out, names = np.zeros(recording.m, dtype=bool), []
    for name, values in recording.run.columns.items():
        for fits, low, high, usual in LIMITS:
            if not fits(name):
                continue
            wrong = ((values < low) | (values > high))[recording.row]
            if wrong.mean() > LARGEST_SHARE:
                raise ModelLimit(
                    f"{name} is {values[recording.row][wrong][0]:g} in {recording.places(wrong)}; {usual}"
                )
            if wrong.any():
                names.append(f"{name} = {values[recording.row][wrong][0]:g} ({usual})")
                out |= wrong
            break
    return out, "impossible " + ", ".join(names)


def without_dead_columns(recording: Recording) -> tuple[Recording, list[str]]:
    """Return the recording without columns that hold one impossible number nearly everywhere, and the words for it.

    To leave out the rows would leave nothing; what needs the column is not testable.
    """
    run, out = recording.run, []
    for name, values in run.columns.items():
        limits = next(((low, high, usual) for fits, low, high, usual in LIMITS if fits(name)), None)
        if limits is None or not name.startswith(SENSORS):
            continue
        values_read = values[recording.row]
        wrong = values_read[(values_read < limits[0]) | (values_read > limits[1])]
        if len(wrong) > LARGEST_SHARE * len(values_read) and np.ptp(wrong) == 0.0:
            out.append(
                (
                    name,
                    f"{name} = {wrong[0]:g} in {len(wrong)} of {len(values_read)} observations ({limits[2]})",
                )
            )
    if not out:
        return recording, []
    gone = {name for name, _ in out}
    columns = {name: v for name, v in run.columns.items() if name not in gone}
    logs = {n: s for n, s in run.series.items() if f"temp_{n}_C" not in gone and n not in gone}
    remarks = [
        f"{text}: a dead sensor; the column is left out, and what depends on it is not testable"
        for _, text in out
    ]
    return replace(recording, run=replace(run, columns=columns, series=logs)), remarks


def _refuse_impossible_log(recording: Recording) -> None:
    for name, log in ((n, s) for n, s in recording.run.series.items() if not n.startswith("accel_")):
        gradient = name == "gradient"
        wrong = np.flatnonzero(np.abs(log.value - (0.0 if gradient else 55.0)) > (50.0 if gradient else 95.0))
        if name not in ("pressure_hPa", "humidity_pct", "spindle_rpm", "spindle_load_W", "load_kg") and len(
            wrong
        ):
            at = int(wrong[0])
            raise ModelLimit(
                f"the log of {name} is {log.value[at]:g} degC at time_s = {log.time[at]:g} ({len(wrong)} such values):"
                " a fault of the sensor; remove these rows of the log"
            )


def constant_sensor_remarks(recording: Recording) -> list[str]:
    """Return temperatures that are constant while another one changes, and those that look like degF."""
    out, run = [], recording.run
    names = _thermometers(recording)
    spread = {c: float(np.ptp(run.columns[c][recording.row])) for c in names}
    moving = sorted((c for c in names if _moves(run.columns[c][recording.row])), key=lambda c: -spread[c])
    still = dead_sensors(recording)
    if still:
        out.append(
            f"{', '.join(still)} never changes while {moving[0]} varies by {spread[moving[0]]:.1f} K: a dead sensor, or a"
            " number typed once; what depends on it cannot be shown"
        )
    out += _fahrenheit({c: float(np.median(run.columns[c][recording.row])) for c in names})
    same = [n for n in ("pressure_hPa", "humidity_pct", "load_kg", "spindle_rpm") if n in run.columns]
    constant = [n for n in same if np.ptp(run.columns[n][recording.row]) == 0]
    if constant:
        out.append(f"{', '.join(constant)} is the same in all rows; what depends on it cannot be shown")
    return out


def dead_sensors(recording: Recording) -> tuple[str, ...]:
    """Return thermometers that show one number all the time while another one changes."""
    logs = {c: recording.run.columns[c][recording.row] for c in _thermometers(recording)}
    if not any(_moves(v) for v in logs.values()):
        return ()
    return tuple(c for c, v in logs.items() if np.ptp(v) == 0.0)


def _thermometers(recording: Recording) -> list[str]:
    names = (c for c in recording.run.columns if c.startswith("temp_") and c.endswith("_C"))
    return [c for c in names if c != "temp_gradient_C"]


def missing_label_remarks(recording: Recording) -> list[str]:
    """Return nuisances per value of a label column that the recording does not have."""
    wanted = recording.nuisance.items()
    out = [(w, b) for w, b in wanted if b not in (*ALL_ROWS, *recording.run.labels)]
    return [f'{w} = "{b}": there is no column {b}, so one {w} is fitted to all rows' for w, b in out]


def _moves(values: Array) -> bool:
    return float(np.ptp(values)) > SPREAD and len(np.unique(values)) >= READINGS


def _fahrenheit(middle: dict[str, float]) -> list[str]:
    """Return sensors whose median would be the temperature of a workshop in degF: all of them, or some among others in degC."""
    hot = [c for c, t in middle.items() if FAHRENHEIT[0] < t < FAHRENHEIT[1]]
    if not hot:
        return []
    first, names = middle[hot[0]], ", ".join(hot)
    if len(hot) == len(middle):
        return [f"{names}: about {first:.0f}, which in a workshop is degF; expected degC"]
    usual = float(np.median([t for c, t in middle.items() if c not in hot]))
    alike = [c for c in hot if abs((middle[c] - 32.0) / 1.8 - usual) < NEAR_FAHRENHEIT]
    if not alike:
        return []
    first = middle[alike[0]]
    return [
        f"{', '.join(alike)}: about {first:.0f} where the others are at about {usual:.0f} degC; {first:.0f} degF are "
        f"{(first - 32.0) / 1.8:.1f} degC, so this sensor looks like degF; expected degC (a motor or spindle may be that hot)"
    ]


def duration_text(seconds: float) -> str:
    """Return a time in the unit in which it has one to four digits before the point: 12 min, 40 s, 0.3 s."""
    if seconds >= 5400.0:
        return f"{seconds / 3600.0:.3g} h"
    return f"{seconds / 60.0:.3g} min" if seconds >= 300.0 else f"{seconds:.3g} s"


def gap_remarks(recording: Recording) -> list[str]:
    """Return times without rows, far longer than usual."""
    if "time_s" not in recording.run.columns or recording.m < 2 * FEWEST:
        return []
    time = recording.run.columns["time_s"][recording.row]
    order = np.argsort(time, kind="stable")
    step = np.diff(time[order])
    usual = float(np.quantile(step[step > 0], 0.9)) if (step > 0).any() else 0.0
    of = recording.run.labels.get(SOURCE_LABEL, np.zeros(recording.run.n, dtype=np.str_))[recording.row][
        order
    ]
    within = of[1:] == of[:-1]
    whole = float(step[within].sum())  # the time between several recordings is unknown
    long = np.flatnonzero((step > GAP * usual) & (step > GAP_SHARE * whole) & within)
    if usual <= 0 or not len(long):
        return []
    remarks = []
    for i in long[:3]:
        where = recording.places(order[[i, i + 1]])
        remarks.append(f"{duration_text(float(step[i]))} between {where}")
    more = f" and {len(long) - 3} more" if len(long) > 3 else ""
    return [
        f"no rows for {'; '.join(remarks)}{more}: what happened there is unknown, and a drift across it may be a step"
    ]


def without_gaps(before: Ints, time: Array | None) -> Ints:
    """Return predecessors (m,) of the observations, none across a gap in time: neighbours there are no neighbours."""
    if time is None:
        return before
    inner = before >= 0
    step = np.where(inner, time - time[np.maximum(before, 0)], 0.0)
    positive = step[inner & (step > 0)]
    if len(positive) < FEWEST:
        return before
    return np.where(inner & (step > GAP * np.quantile(positive, 0.9)), -1, before)
