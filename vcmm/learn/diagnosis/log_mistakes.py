"""Mistakes of the log: two columns or labels exchanged, a sign, a unit, directions the other way round, without a free parameter; a clock
of the logs that is late or drifts, with one.

The machine file predicts the recording from what was logged. With a correct log it would predict something else:

    departure = prediction from the corrected columns - prediction from the columns as logged

Such a hypothesis is tested as a mistake of the table is (see mistakes): its number is 1, it pays its prior, and it must beat the explanation of
the catalogue. Columns on which no prediction depends are not tested.

Mistakes of the log with one number: a clock of the logs that is late or early, or runs too fast or too slowly.

    clock_offset    T(t) was logged at t + s              clock_drift    T(t) was logged at t + s (t - t1) / (t2 - t1)

t1 and t2 are the first and the last row, s seconds, positive where the log is late. Trial values lie evenly within half of the duration to either
side; the best one is searched between its neighbours, and each pays its share of the trials. Only logs with a clock of their own are tested.

Two labels that are exchanged everywhere group the same rows; they are reported only where the machine holds an effect for one of them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run, Series
from vcmm.learn.diagnosis.constants import MOST_SHAPES
from vcmm.learn.diagnosis.scans import MOST_STEPS
from vcmm.learn.diagnosis.units_and_signs import unit_forms
from vcmm.task.response.logs import sensor_of
from vcmm.task.response.observe import Observer
from vcmm.task.response.recording import Recording

OFFSET, DRIFT = "clock_offset", "clock_drift"


@dataclass(frozen=True)
class ClockMistake:
    """A clock mistake: the kind, and the run with a log that is s seconds late."""

    what: str
    corrected: Callable[[float], Run]
    values: tuple[float, ...]

    def text(self, seconds: float) -> str:
        late = "late" if seconds > 0 else "early"
        at_end = " at the last row" if self.what == DRIFT else ""
        return f"the clock of the logs, {abs(seconds):.4g} s {late}{at_end}"


def clock_mistakes(run: Run) -> Iterator[ClockMistake]:
    """Yield offset and drift of all logs together, where there are logs with a clock of their own."""
    if "time_s" not in run.columns:
        return
    time = run.column("time_s")
    logs = {n: log for n, log in run.series.items() if not _is_of_rows(log, time)}
    span = float(np.ptp(time))
    if not logs or span <= 0:
        return
    trials = np.linspace(-0.5, 0.5, MOST_STEPS + 1) * span
    values = tuple(float(v) for v in trials[trials != 0.0])
    yield ClockMistake(OFFSET, lambda s: _with_clock(run, logs, lambda t: t - s), values)
    yield ClockMistake(
        DRIFT, lambda s: _with_clock(run, logs, lambda t: t - s * (t - time.min()) / span), values
    )


def _is_of_rows(log: Series, time: Array) -> bool:
    return bool(np.isin(log.time, time).all()) and len(log.time) >= len(np.unique(time))


def _with_clock(run: Run, logs: dict[str, Series], true_time: Callable[[Array], Array]) -> Run:
    """Return the run with logs at their true times, and with the columns that were read from them."""
    series = {n: Series(true_time(log.time), log.value) for n, log in logs.items()}
    time = run.column("time_s")
    columns = {}
    for name, values in run.columns.items():
        log = logs.get(sensor_of(name))
        if log is not None and np.array_equal(values, np.interp(time, log.time, log.value)):
            columns[name] = np.interp(time, series[sensor_of(name)].time, log.value)
    return replace(run.with_columns(columns), series={**run.series, **series})


MISTAKE = "map_mistake"  # the name of an answer: a wrong number in a stored table
LOG = "log_mistake"  # the name of an answer
LABELS_EXCHANGED = "labels_exchanged"
EXCHANGED, SIGN, UNIT, DIRECTIONS = "columns_exchanged", "sign", "unit", "directions_exchanged"
WORDS = {
    EXCHANGED: "each stands in the place of the other",
    SIGN: "the sign is the opposite one",
    DIRECTIONS: "+ and - are exchanged",
}
Name = tuple[str, str]  # of what a run holds: one of TABLES or PLACES, and the name in it
ZEROED = (("columns", "time_s"), ("labels", "setup"))  # by which the zero of a counter is known
TABLES, PLACES = ("columns", "labels", "series"), "position"
COLUMN_PREFIXES = (
    "temp_",
    "speed_",
    "accel_",
    "sense_",
)  # beginnings of columns that are taken for one another
OFFSETS = ("offset_x_mm", "offset_y_mm", "offset_z_mm")
RunCorrection = Callable[[Run], Run]


@dataclass(frozen=True, eq=False)
class Clock:
    """The hypotheses about it: value: seconds; step: between trials; at: seconds -> (words, departure (m,)), or None."""

    value: float
    step: float
    at: Callable[[float], tuple[str, Array] | None]


@dataclass(frozen=True, eq=False)
class Mistake:
    """One hypothesis that something was written down wrongly: component (EYX, C0Y, or "all"; of a log the columns or labels that are meant),
    what, departure (m,) of the observation, mm or rad, score in nats.
    """

    component: str
    what: str
    departure: Array
    score: float = 0.0
    prior: float = 0.0  # ln; each kind of mistake of a component weighs the same, however many forms it has
    rivals: tuple[str, ...] = ()  # other mistakes within 3 nats, in words
    effect: str = MISTAKE  # or the effect of a wrong Abbe arm, whose component is the axis
    factor: float = (
        1.0  # what the recording holds of the table: -1, 0, 2 or a unit factor; of the Abbe error -1 or 1
    )
    source: str = ""  # the component whose table it holds instead
    both: bool = False  # and the other way round
    lead: float = np.inf  # nats over the best explanation without a mistake
    free: tuple[str, ...] = ()  # names of the terms that explain it instead
    clock: Clock | None = None  # of a mistake of the log with one number
    words: str = ""  # what about the columns is wrong


def log_hypotheses(recording: Recording, machine: Machine) -> Iterator[Mistake]:
    """Yield all mistakes of the log that change what the machine file predicts."""
    observer = Observer(recording, machine)
    before = observer.baseline()
    if not np.any(before):
        return
    read = names_read(observer)

    def change(run: Run) -> Array | None:
        if not changed_names(recording.run, run) & read:
            return None
        try:
            after = Observer(replace(recording, run=run), machine).baseline()
        except (ModelLimit, UsageError):
            return None  # positions outside the travels, temperatures that cannot be
        return after - before if np.isfinite(after).all() and np.any(after != before) else None

    for what, tried in _kinds(recording.run):
        changed = [(columns, words, change(corrected(recording.run))) for columns, corrected, words in tried]
        departures = [(columns, words, d) for columns, words, d in changed if d is not None]
        for columns, words, departure in departures:
            share = -float(np.log(len(departures)))
            yield replace(_of_log(columns, what, departure, share), words=words or WORDS.get(what, ""))
    yield from _of_labels(recording.run, change)
    for clock in clock_mistakes(recording.run):
        yield from _of_clock(clock, change)


def _of_log(columns: str, what: str, departure: Array, prior: float) -> Mistake:
    return Mistake(columns, what, departure, prior=prior, effect=LOG)


def _of_labels(run: Run, change: Callable[[Run], Array | None]) -> Iterator[Mistake]:
    departures = [(text, d) for text, other in exchanged_labels(run) if (d := change(other)) is not None]
    for text, departure in departures:
        yield _of_log(text, LABELS_EXCHANGED, departure, -float(np.log(len(departures))))


def _of_clock(clock: ClockMistake, change: Callable[[Run], Array | None]) -> Iterator[Mistake]:
    """Yield every trial value; the best one is refined between its neighbours."""

    def at(seconds: float) -> tuple[str, Array] | None:
        departure = change(clock.corrected(seconds))
        return None if departure is None else (clock.text(seconds), departure)

    step = float(np.diff(sorted(clock.values)).min())
    share = -float(np.log(len(clock.values)))
    for seconds in clock.values:
        departure = at(seconds)
        if departure is not None:
            yield replace(
                _of_log(departure[0], clock.what, departure[1], share), clock=Clock(seconds, step, at)
            )


class _TableOfReads(dict[str, Any]):
    """A table of a run that notes which of its names are read."""

    def __init__(self, table: Mapping[str, Any], kind: str, names_read: set[Name]) -> None:
        super().__init__(table)
        self.kind, self.names_read = kind, names_read

    def __getitem__(self, name: str) -> Any:
        self.names_read.add((self.kind, name))
        return super().__getitem__(name)

    def get(self, name: str, default: Any = None) -> Any:
        self.names_read.add((self.kind, name))
        return super().get(name, default)

    def __contains__(self, name: object) -> bool:
        self.names_read.add((self.kind, str(name)))
        return super().__contains__(name)

    def __iter__(self) -> Iterator[str]:
        names = list(super().__iter__())
        self.names_read.update((self.kind, name) for name in names)
        return iter(names)

    def keys(self) -> Any:
        iter(self)
        return super().keys()

    def values(self) -> Any:
        iter(self)
        return super().values()

    def items(self) -> Any:
        iter(self)
        return super().items()


def names_read(observer: Observer) -> set[Name]:
    """Return the names on which the prediction of a recording depends: places, and of columns, labels and logs those that the machine's
    effects read."""
    names: set[Name] = {(PLACES, ""), *ZEROED}
    run = copy(observer.run)
    for kind in TABLES:
        object.__setattr__(run, kind, _TableOfReads(getattr(run, kind), kind, names))
    for effect in observer.usable.effects:
        effect.error_motion(run)
    return names


def changed_names(before: Run, after: Run) -> set[Name]:
    """Return where two runs with the same rows differ; a column whose rows are its log changes that too."""
    out = {
        (kind, name)
        for kind in TABLES
        for old, new in [(getattr(before, kind), getattr(after, kind))]
        for name in old.keys() | new.keys()
        if not _is_same(old.get(name), new.get(name))
    }
    out |= {("series", sensor_of(name)) for kind, name in out if kind == "columns"}
    places = [(q, after.position[a]) for a, q in before.position.items()]
    if not all(_is_same(was, new) for was, new in [*places, (before.offset, after.offset)]):
        out.add((PLACES, ""))
    return out


def _is_same(first: Any, second: Any) -> bool:
    if first is second:
        return True
    if isinstance(first, Series) and isinstance(second, Series):
        return np.array_equal(first.time, second.time) and np.array_equal(first.value, second.value)
    return first is not None and second is not None and np.array_equal(first, second)


def _kinds(run: Run) -> Iterator[tuple[str, list[tuple[str, RunCorrection, str]]]]:
    """Yield a kind, and for each of its forms the columns, the corrected run, and words that the kind does not have."""
    for what, forms in _forms(run):
        yield what, [(columns, corrected, "") for columns, corrected in forms]
    yield UNIT, list(_units(sorted(n for n, v in run.columns.items() if np.ptp(v) > 0)))


def _forms(run: Run) -> Iterator[tuple[str, list[tuple[str, RunCorrection]]]]:
    names = sorted(n for n, v in run.columns.items() if np.ptp(v) > 0)
    axes = sorted(a for a, q in run.position.items() if np.ptp(q) > 0)
    alike = [[n for n in names if n.startswith(start) and _ending(n) == end] for start, end in _groups(names)]
    exchanged = [
        (f"{a} and {b}", _columns(a, b)) for group in alike for a, b in itertools.combinations(group, 2)
    ]
    linear = [a for a in axes if a in "XYZUVW"]
    exchanged += [(f"{a} and {b}", _axes(a, b)) for a, b in itertools.combinations(linear, 2)]
    exchanged += [
        (f"{OFFSETS[a]} and {OFFSETS[b]}", _offsets(_exchanging(a, b)))
        for a, b in itertools.combinations(range(len(OFFSETS)), 2)
        if not np.array_equal(run.offset[:, a], run.offset[:, b])
    ]
    yield EXCHANGED, exchanged
    yield (
        SIGN,
        [
            *((a, _mirror(a)) for a in axes),
            *((name, _offsets(_mirroring(a))) for a, name in enumerate(OFFSETS) if run.offset[:, a].any()),
            *((n, _all_times([n])) for n in names if n.startswith(("speed_", "accel_"))),
        ],
    )
    senses = [n for n in names if n.startswith("sense_")]
    yield (
        DIRECTIONS,
        [(n, _all_times([n])) for n in senses]
        + ([(" and ".join(senses), _all_times(senses))] if len(senses) > 1 else []),
    )


def _units(names: Sequence[str]) -> Iterator[tuple[str, RunCorrection, str]]:
    """Yield one column in another unit, all columns of one unit, and all of a kind: m/min in place of mm/s concerns every linear axis, a speed
    per minute perhaps the rotary axes too."""
    for start, forms in unit_forms().items():
        alike = tuple(n for n in names if n.startswith(start))
        of_unit = (tuple(n for n in alike if _ending(n) == end) for end in dict.fromkeys(map(_ending, alike)))
        groups = dict.fromkeys(g for g in (*((n,) for n in alike), *of_unit, alike) if g)
        for (factor, zero, words), group in itertools.product(forms, groups):
            yield " and ".join(group), _all_times(group, factor, zero), words


def _groups(names: Sequence[str]) -> list[tuple[str, str]]:
    groups = [(start, _ending(n)) for start in COLUMN_PREFIXES for n in names if n.startswith(start)]
    return list(dict.fromkeys(groups))


def _ending(name: str) -> str:
    """Return the unit of a column without its place: temp_air_C, temp_scale_x_C -> C, speed_X_mm_s -> mm_s, sense_X -> ''."""
    parts = name.split("_")
    return parts[-1] if parts[0] == "temp" else "_".join(parts[2:])


def _columns(a: str, b: str) -> RunCorrection:
    def corrected(run: Run) -> Run:
        first, second = sensor_of(a), sensor_of(b)
        series = dict(run.series)
        for to, source in ((first, second), (second, first)):
            series.pop(to, None)
            if source in run.series:
                series[to] = run.series[source]
        return replace(run.with_columns({a: run.columns[b], b: run.columns[a]}), series=series)

    return corrected


def _axes(a: str, b: str) -> RunCorrection:
    return lambda run: replace(run, position={**run.position, a: run.position[b], b: run.position[a]})


def _mirror(axis: str) -> RunCorrection:
    return lambda run: replace(run, position={**run.position, axis: -run.position[axis]})


def _mirroring(a: int) -> Callable[[Array], Array]:
    return lambda offset: offset * np.where(np.arange(len(OFFSETS)) == a, -1.0, 1.0)


def _exchanging(a: int, b: int) -> Callable[[Array], Array]:
    order = [b if i == a else a if i == b else i for i in range(len(OFFSETS))]
    return lambda offset: offset[:, order]


def _offsets(change: Callable[[Array], Array]) -> RunCorrection:
    return lambda run: replace(run, offset=change(run.offset))


def _all_times(names: Sequence[str], factor: float = -1.0, zero: float = 0.0) -> RunCorrection:
    def corrected(run: Run) -> Run:
        series = dict(run.series)
        for sensor in {sensor_of(name) for name in names} & series.keys():
            log = series[sensor]
            series[sensor] = Series(log.time, factor * (log.value - zero))
        columns = {n: factor * (run.columns[n] - zero) for n in names}
        return replace(run.with_columns(columns), series=series)

    return corrected


def exchanged_labels(run: Run) -> Iterator[tuple[str, Run]]:
    """Yield the pairs of values of one label, each taken for the other."""
    for label, values in run.labels.items():
        kinds = [str(v) for v in np.unique(values)]
        if not 1 < len(kinds) <= MOST_SHAPES:
            continue
        for a, b in itertools.combinations(kinds, 2):
            other = np.where(values == a, b, np.where(values == b, a, values)).astype(values.dtype)
            yield f"{a} and {b} of {label}", replace(run, labels={**run.labels, label: other})
