"""Prepare recordings with sensors for a thermal model, and the terms that they can show."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.readings import free_nuisance
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.physics.structure.spindle_growth import SpindleGrowth
from vcmm.physics.structure.thermal import ThermalDrift
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import Observer
from vcmm.task.response.recording import Recording

SHORTEST = 1.0  # s
BLOCKS = 8  # of time, per recording
VARIES = 0.5  # K: a sensor that changes less tells nothing
ABOUT, FAR = 5, 8.0  # readings; beyond so many standard deviations none lies by chance
LEAST_DIRECTION = 0.3  # share of a direction in a reading


@dataclass(frozen=True)
class Term:
    """A term: make(amount, tau) is the effect; name of its amount; lag: whether tau counts. where: direction and sensor, or axis."""

    where: tuple[str, ...]
    make: Callable[[float, float], Effect]
    amount: str
    lag: bool
    sensor: str


@dataclass(frozen=True, eq=False)
class WarmReadings:
    """One prepared recording: value (m,) less the baseline, nuisance (m, p), block of time (m,), weight (m,) 0 or 1."""

    recording: Recording
    observer: Observer
    value: Array
    nuisance: Array
    block: Array
    weight: Array

    def column(self, term: Term, tau: float) -> Array:
        """Return the readings per unit of the amount (m,)."""
        effect = term.make(1.0, tau)
        return self.observer.through(effect, effect.error_motion(self.observer.run)[:, :, None])[:, 0]


def warm_readings(recording: Recording, machine: Machine) -> WarmReadings:
    """Raises UsageError for a recording without a clock that goes forward."""
    recording, _ = free_nuisance(recording, machine)
    observer = Observer(recording, machine)
    time = observer.run.columns.get("time_s")
    if time is None or (np.diff(time) < 0).any():
        raise UsageError(
            f"{recording.name}: a thermal model needs the column time_s, in the order of the rows, for temperatures act late"
        )
    at = time[recording.row]
    nuisance, _ = nuisance_columns(recording, machine)
    span = max(float(np.ptp(at)), 1e-9)
    block = np.minimum((BLOCKS * (at - at[0]) / span).astype(int), BLOCKS - 1)
    value = recording.value - observer.baseline()
    weight = np.where(standing_out(value), 0.0, 1.0)
    return WarmReadings(
        recording=recording, observer=observer, value=value, nuisance=nuisance, block=block, weight=weight
    )


def standing_out(value: Array) -> npt.NDArray[np.bool_]:
    """Return single readings (m,) far from the median of five about them; a run of five and more is no mistake."""
    if len(value) < ABOUT:
        return np.zeros(len(value), dtype=bool)
    padded = np.pad(value, ABOUT // 2, mode="edge")
    away = np.abs(value - np.median(np.lib.stride_tricks.sliding_window_view(padded, ABOUT), axis=1))
    usual = 1.4826 * float(np.median(away[away > 0])) if (away > 0).any() else 0.0
    return np.asarray(away > FAR * usual) & (away > 0)


def sensors_of(parts: Sequence[WarmReadings]) -> tuple[dict[str, tuple[float, float]], dict[str, str]]:
    """Return sensor -> lowest and highest temperature of those in all recordings that vary; the others with the reason."""
    names = [{c for c in p.observer.run.columns if c.startswith("temp_") and c.endswith("_C")} for p in parts]
    used, unused = {}, {}
    for name in sorted(set.union(*names)):
        sensor = name.removeprefix("temp_").removesuffix("_C")
        if any(name not in names_read for names_read in names):
            unused[sensor] = "not in all recordings"
            continue
        values = np.concatenate([p.observer.run.column(name) for p in parts])
        if np.ptp(values) < VARIES:
            unused[sensor] = f"varies by {np.ptp(values):.2g} K only"
        else:
            used[sensor] = (float(values.min()), float(values.max()))
    return used, unused


def candidates(parts: Sequence[WarmReadings], sensors: Sequence[str]) -> list[Term]:
    """Return every term that these readings can show."""
    out = []
    lengths = [p for p in parts if p.recording.kind != "angle"]
    for k, direction in enumerate("xyz"):
        if any((np.abs(p.recording.direction[:, k]) > LEAST_DIRECTION).any() for p in lengths):
            out += [_drift(direction, s) for s in sensors]
    for axis in "XYZ":
        moves = [np.ptp(p.observer.run.q(axis)) > 1.0 for p in parts if axis in p.observer.run.position]
        if any(moves) and f"scale_{axis.lower()}" in sensors:
            out.append(_scale(axis))
    if all("spindle_on_s" in p.observer.run.columns for p in parts):
        out.append(_spindle())
    return out


def _drift(direction: str, sensor: str) -> Term:
    def make(amount: float, tau: float) -> Effect:
        return ThermalDrift(direction, sensor, amount, tau)

    return Term((direction, sensor), make, "k", True, sensor)


def _scale(axis: str) -> Term:
    def make(amount: float, tau: float) -> Effect:
        return ScaleExpansion(axis, amount)

    return Term((axis,), make, "alpha", False, f"scale_{axis.lower()}")


def _spindle() -> Term:
    def make(amount: float, tau: float) -> Effect:
        return SpindleGrowth("Z", amount, max(tau, SHORTEST))

    return Term(("Z",), make, "amplitude", True, "")
