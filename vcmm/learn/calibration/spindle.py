"""Error motion values of a turning axis (ISO 230-7:2015), fixed sensitive direction: from a reversal, or from a machine file.

    total           range of all readings                     synchronous            range of their mean over the turns
    asynchronous    largest range over the turns at one angle
    fundamental     range of once per turn (axial, tilt; radial it is the centring of the artefact, and left out everywhere)
    residual synchronous    range of the mean without once per turn

From a reversal the artefact is taken out first. What the test cannot tell (see `ReversalResult.combinations`) is in no value.

Limits as people write them: "A = 8 um", "E0 = 1.9 um + L/300".
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.core.units import quantity
from vcmm.learn.calibration.acceptance import Figure, Limit, tip_errors
from vcmm.learn.calibration.reversal import CIRCLE, ReversalResult
from vcmm.task.certification.certificate import length_limit
from vcmm.task.instruments.reversal import NORMAL, SeparationResult
from vcmm.task.instruments.reversal_turns import Complex, TurnGroup

TRIALS = 1000
TURNS, PER_TURN = 10, 72
REACH = 100.0  # mm between the two heights where a tilt is read
ANGLE = " (urad)"  # at the end of the name of a figure in urad
ZERO_ERROR = 1e-13  # mm, rad
COORDINATE_NAMES = {
    "X": "radial X",
    "Y": "radial Y",
    "Z": "axial Z",
    "A": "tilt A",
    "B": "tilt B",
    "C": "angle C",
}


def recorded_spindle(
    result: ReversalResult, limits: Mapping[str, Limit] | None = None, seed: int = 0, trials: int = TRIALS
) -> list[Figure]:
    """Return the values of every error motion of one separated test, um or urad; u from the scatter of the turns.

    The asynchronous and total values are extremes of the turns that were recorded and have no u. Raises UsageError for a test
    along a line.
    """
    if result.turning is None:
        raise UsageError(
            f'{result.file.name} is a test of kind "{result.file.kind}"; ISO 230-7 takes one of a turning axis'
        )
    rng, out = np.random.default_rng(seed), []
    drawn = result.turning.draw(rng, trials)
    for i, name in enumerate(result.errors):
        values = _values(result.turning, name, _first_setup(result, name))
        moved = {
            "synchronous": _ranges(drawn[:, i]),
            "fundamental": 2.0 * np.abs(drawn[:, i, 0]),
            "residual synchronous": _ranges(drawn[:, i] * (np.arange(drawn.shape[2]) > 0)),
        }
        for value, number in values.items():
            spread = None if value not in moved else float(moved[value].std())
            out.append(
                figure(f"{value} {COORDINATE_NAMES[name[1]]}", number, spread, name[1] in "ABC", limits or {})
            )
    return out


def figure(name: str, value: float, u: float | None, angle: bool, limits: Mapping[str, Limit]) -> Figure:
    """Return a figure in um or urad, with its limit (mm or rad) and the chance that the value is within it: 0 or 1 without u."""
    scale = 1e6 if angle else 1e3
    stated = [key for key in limits if is_of(key, name) and angle == any(word in key for word in TURNING)]
    limit = limits[max(stated, key=len)](0.0) if stated else None
    sure = None
    if limit is not None:
        sure = float(value <= limit) if not u else _below((limit - value) / u)
    return Figure(
        f"{name}{ANGLE if angle else ''}", value * scale, None if u is None else u * scale,
        None if limit is None else limit * scale, sure,
    )  # fmt: skip


def is_of(key: str, name: str) -> bool:
    """Return whether the name of a limit, whole or its beginning ("synchronous"), is that of a figure."""
    return name == key or name.startswith(f"{key} ")


def _below(z: float) -> float:
    from math import erf

    return 0.5 * (1.0 + erf(z / np.sqrt(2.0)))


def _ranges(coefficients: Complex) -> Array:
    """Return (trials,) ranges of curves with these orders (trials, K)."""
    waves = np.exp(1j * np.outer(np.arange(1, coefficients.shape[1] + 1), CIRCLE))
    return np.asarray(np.ptp(np.real(coefficients @ waves), axis=1))


def _values(separation: SeparationResult, name: str, apart: Array) -> dict[str, float]:
    """Return values in mm or rad; apart (turns, angles): differences of the turns from their mean."""
    orders = separation.value.shape[1]
    is_known = separation.is_identified[separation.names.index(name)]
    curve = separation.curve(name, CIRCLE)
    out = {
        "total": float(np.ptp(curve + apart)),
        "synchronous": float(np.ptp(curve)),
        "asynchronous": float(np.ptp(apart, axis=0).max()),
    }
    if is_known[0]:
        out["fundamental"] = 2.0 * float(abs(separation.value[separation.names.index(name), 0]))
        out["residual synchronous"] = float(np.ptp(separation.curve(name, CIRCLE, range(2, orders + 1))))
    return out


def _first_setup(result: ReversalResult, name: str) -> Array:
    """Return readings of the first set-up less their mean, (turns, angles); for a tilt the outer probe less the inner one, over the arm."""
    file, test = result.file, result.file.test
    assert test is not None
    first = [
        g
        for g in file.groups
        if g.setup == (NORMAL if test.test in ("face", "donaldson") else file.groups[0].setup)
    ]
    if test.test != "face":
        return _from_mean(first[0])
    arms = test.arms or {}
    inner = next(g for g in first if test.on_axis(g.probe))
    if name != test.tilt:
        return _from_mean(inner)
    outer = max(first, key=lambda g: abs(arms[g.probe]))
    n = min(len(outer.plot), len(inner.plot))
    return (_from_mean(outer)[:n] - _from_mean(inner)[:n]) / arms[outer.probe]


def _from_mean(group: TurnGroup) -> Array:
    return group.plot - group.plot.mean(axis=0)


def predicted_spindle(
    machine: Machine, limits: Mapping[str, Limit] | None = None, seed: int = 0, trials: int = TRIALS
) -> list[Figure]:
    """Return values that a test with a perfect artefact would give of every C axis of the machine file, on sampled machines.

    Read at two heights on the axis; ten turns, scatter per reading. Motions of which the machine file knows no error are left out.
    Raises UsageError without a C axis.
    """
    turning = [a for a in machine.chain.letters if a[0] == "C"]
    if not turning:
        raise UsageError(
            f'ISO 230-7 needs a turning axis C; structure = "{machine.chain.structure}" has none'
        )
    out, rng = [], np.random.default_rng(seed)
    for axis in turning:
        for name, drawn in _motions(machine, axis, rng, trials).items():
            label = COORDINATE_NAMES[name] if len(turning) == 1 else f"{COORDINATE_NAMES[name]} of {axis}"
            if float(np.abs(drawn).max()) < ZERO_ERROR:
                continue  # the machine file knows no such error
            for value, values in _drawn_values(drawn, name in "XY").items():
                out.append(_predicted_figure(f"{value} {label}", values, name in "AB", limits or {}))
    return out


def _predicted_figure(name: str, drawn: Array, angle: bool, limits: Mapping[str, Limit]) -> Figure:
    row = figure(name, float(drawn.mean()), float(drawn.std()), angle, limits)
    if row.limit_um is None:
        return row
    share = float((drawn * (1e6 if angle else 1e3) <= row.limit_um).mean())
    return Figure(row.name, row.value_um, row.u_um, row.limit_um, share)


def _motions(machine: Machine, axis: str, rng: np.random.Generator, trials: int) -> dict[str, Array]:
    """Return error motion -> (trials, TURNS, PER_TURN) mm or rad in fixed directions, the turning part's own."""
    from vcmm.task.instruments.reversal_simulation import fixed_places, own_motion

    angle = np.tile(np.arange(PER_TURN) * 2 * np.pi / PER_TURN, TURNS)
    places = ((0.0, 0.0, 0.0), (0.0, 0.0, REACH))
    runs = [fixed_places(machine, axis, angle, place, _middle(machine, axis)) for place in places]
    run = Run(
        {a: np.concatenate([r.q(a) for r in runs]) for a in machine.chain.letters},
        np.concatenate([r.offset for r in runs]),
        {f"n{c}": np.full(2 * len(angle), float(c == "z")) for c in "xyz"},
    )
    drawn = tip_errors(machine, run, rng, trials)
    on, above = (
        own_motion(machine, axis, angle, part) for part in (drawn[:, : len(angle)], drawn[:, len(angle) :])
    )
    shape = (trials, TURNS, PER_TURN)
    lean = (above - on) / REACH
    motions = {"X": on[..., 0], "Y": on[..., 1], "Z": on[..., 2], "A": -lean[..., 1], "B": lean[..., 0]}
    return {name: values.reshape(shape) for name, values in motions.items()}


def _middle(machine: Machine, axis: str) -> dict[str, float]:
    return {
        a: (x.travel[0] + x.travel[1]) / 2 if a in "XYZ" else 0.0
        for a, x in machine.axes.items()
        if a != axis
    }


def _drawn_values(drawn: Array, radial: bool) -> dict[str, Array]:
    """Return the values (trials,) of motions (trials, turns, angles)."""
    wave = np.exp(-1j * np.arange(drawn.shape[2]) * 2 * np.pi / drawn.shape[2])
    mean = drawn.mean(axis=1)
    once = 2.0 * (mean @ wave) / drawn.shape[2]
    rest = mean - np.real(once[:, None] * wave.conj())
    apart = drawn - mean[:, None]
    kept = rest if radial else mean
    out = {
        "total": np.ptp((kept[:, None] + apart).reshape(len(drawn), -1), axis=1),
        "synchronous": np.ptp(kept, axis=1),
        "asynchronous": np.ptp(apart, axis=1).max(axis=1),
    }
    return (
        out
        if radial
        else out | {"fundamental": 2.0 * np.abs(once), "residual synchronous": np.ptp(rest, axis=1)}
    )


TURNING = ("tilt", "angle")  # figures that are angles


def limits_of(texts: Sequence[str], angles: bool = False) -> Mapping[str, Limit]:
    """Name -> limit in mm by length in mm; angles: limits of tilts may be stated, in rad.

    Raises UsageError for a text that is not understood, a length for a tilt and an angle for another figure.
    """
    out: dict[str, Limit] = {}
    for text in texts:
        name, mark, value = text.partition("=")
        if not mark or not name.strip():
            raise UsageError(f'--limit "{text}" is not understood; write for example --limit "A = 8 um"')
        figure = re.sub("_MP[EL]$", "", name.strip())  # as a machine file states it
        if angles and any(word in figure for word in TURNING):
            size = quantity(value.strip(), "angle", name.strip(), "0.5 urad")
            if not size > 0:
                raise UsageError(f"{text}: a limit is positive; write for example {name.strip()} = 0.5 urad")
            out[figure] = partial(_always, size)
        else:
            out[figure] = length_limit(value.strip(), name.strip())
    return out


def _always(size: float, length: float) -> float:
    return size
