"""Cutting power over the time of a program: of the force model, or from a log of the control.

A log takes the place of the model in two ways: the spindle warms by it, and the forces of the model are scaled by measured over
modelled power at each moment. The model then gives the direction of the force, the log its size (P = F_t v: at one speed and
engagement all components of the force go with the power).
"""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array, Series
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.machining.blank import Blank
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.states import seconds_at

GAP, LEAST_READINGS = 10.0, 10  # times the median interval; readings from which there is a rate: chosen


def power_log(job: PreparedCut) -> Series | None:
    """Return the cutting power over the time of the program, W; as logged, else of the model; None where neither is known.

    Of the n-th part in a row it begins with the first: each is cut as the first, without a pause.
    """
    log = job.scenario.load_log or modelled_power(job)
    if log is None or job.scenario.batch_part == 1:
        return log
    log = of_one_part(log, job.seconds)
    begin = np.repeat(np.arange(job.scenario.batch_part) * job.seconds, len(log.time))
    time = begin + np.tile(log.time, job.scenario.batch_part)
    return Series(time, np.tile(log.value, job.scenario.batch_part))


def of_one_part(log: Series, seconds: float) -> Series:
    """Return a log from 0 to `seconds`: what was logged before the start and behind the end belongs to no part, and the next one begins
    with its own first value (a step, not a ramp from the last one)."""
    inside = (log.time > 0.0) & (log.time < seconds)
    first, last = np.interp([0.0, seconds], log.time, log.value)
    return Series(np.r_[0.0, log.time[inside], seconds], np.r_[first, log.value[inside], last])


def gap_of(log: Series) -> tuple[float, float] | None:
    """Return (from, to) s of the longest stretch without a reading, where it is GAP times as long as readings are apart; else None."""
    apart = np.diff(log.time)
    if len(apart) < LEAST_READINGS or apart.max() <= GAP * np.median(apart):
        return None
    k = int(np.argmax(apart))
    return float(log.time[k]), float(log.time[k + 1])


def modelled_power(job: PreparedCut) -> Series | None:
    """Return the cutting power of the force model, W: constant along each stretch of the path, zero between two cuts."""
    blank = job.blank
    if not isinstance(blank, Blank) or blank.power is None or blank.pieces is None:
        return None
    row = np.repeat(np.arange(len(blank.pieces.count)), blank.pieces.count)
    inside = np.arange(len(row)) - blank.pieces.first[row]
    cuts = np.flatnonzero(blank.power > 0.0)
    if not len(cuts):
        return Series(np.array([0.0, job.seconds]), np.zeros(2))
    count = blank.pieces.count[row[cuts]]
    move = job.sweep.move[row[cuts]]
    begin, end = (seconds_at(job.path.timing, move, (inside[cuts] + k) / count) for k in (0, 1))
    time = np.stack([begin, begin, end, end], axis=1).ravel()
    value = np.stack([0.0 * begin, blank.power[cuts], blank.power[cuts], 0.0 * begin], axis=1).ravel()
    time = np.maximum.accumulate(np.r_[0.0, time, job.seconds])  # stretches meet to rounding
    return Series(time, np.r_[0.0, value, 0.0])


def measured_share(job: PreparedCut, time: Array, row: Ints, share: Array) -> Array:
    """Return the measured over modelled power (k,) at times (k,) of shares of rows; 1 where nothing was logged or the model sees no cut."""
    log, blank = job.scenario.load_log, job.blank
    if log is None or not isinstance(blank, Blank) or blank.power is None or blank.pieces is None:
        return np.ones(len(time))
    stretch, _ = blank.pieces.at(row, share)
    model = blank.power[stretch]
    measured = np.maximum(np.interp(time, log.time, log.value), 0.0)
    return np.divide(measured, model, out=np.ones(len(time)), where=model > 0.0)
