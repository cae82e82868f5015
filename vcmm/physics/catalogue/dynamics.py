"""Dynamics: the structure pitches while an axis accelerates, and rings after it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.declaration import UM, URAD, About, ChoosesColumns, ForDiagnosis, Typical, Words
from vcmm.core.effect import Effect, at, declared_columns, motion, param
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Array, Run

Complex = npt.NDArray[np.complex128]
METRE = 1e3  # mm

PITCH = {"X": ("B", 1.0), "Y": ("A", -1.0), "Z": ("B", 1.0)}  # e_z x e_a; for Z about Y
YAW = {"X": "C", "Y": "C", "Z": "A"}


@dataclass(frozen=True, eq=False)
class DynamicPitch(Effect):
    """Rotation in proportion to acceleration: pitch k a_a about e_z x e_a, and yaw a_a; the arm makes it a displacement.

    Pitch: X turns about +Y, Y about -X, so the tip moves by k a_a z e_a, z its height over the reference point of the
    axis: a tip hanging below lags behind. Z turns about +Y. Yaw is about Z (for axis Z about X).
    """

    name = "dynamic_pitch"
    per = "axis"
    needs = ("accel_{axis}_mm_s2",)
    about = About(
        cites="Weekers & Schellekens, CIRP Annals 44 (1995) 469: dynamic errors of CMMs for fast probing",
        words=Words(
            seen="acceleration tilts {where} ({k})",
            causes="the slide is driven off its centre of mass",
            confirm="the same path with half the acceleration",
        ),
    )
    axis: str = at("X", "linear axis")
    k: float = param(
        0.0,
        "urad/(m/s^2)",
        "pitch per acceleration",
        typical=Typical(
            5 * URAD / 1e3, "CMM 0.1-1 um at 0.1 m/s^2, machine tool 5-20 um at 10 m/s^2, arm 0.5 m"
        ),
    )
    yaw: float = param(
        0.0, "urad/(m/s^2)", "yaw per acceleration", typical=Typical(5 * URAD / 1e3, "as pitch")
    )

    def __post_init__(self) -> None:
        if self.axis not in PITCH:
            raise UsageError(f'dynamic_pitch: axis = "{self.axis}" must be "X", "Y" or "Z"')

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        acceleration = run.column(f"accel_{self.axis}_mm_s2")
        letter, sign = PITCH[self.axis]
        return motion(run, **{letter: sign * self.k * acceleration, YAW[self.axis]: self.yaw * acceleration})


def _structural_vibration_shows_in(effect: StructuralVibration, run: Run) -> bool:
    """Return whether some row comes after an acceleration has ended; on a circle none does, and a ringing at time zero is a step."""
    after = run.columns.get("time_since_accel_s")
    return bool(effect.follows) or after is None or bool(np.any(after > 0))


@dataclass(frozen=True, eq=False)
class StructuralVibration(Effect, ChoosesColumns):
    """d_a exp(-damping w t) (sine sin(w t) + cosine cos(w t)) e_a, w = 2 pi frequency, t since the acceleration ended.

    The ringing turns over with the direction d_a from which the axis came to rest. With follows = 1 it is that of one
    mode to the whole acceleration of the axis, from a log accel_<axis>_mm_s2 over time: every change of it starts a
    ringing of its own, the amplitude is that after a change of 1 m/s^2, and all of them add (Duhamel's sum).
    """

    name = "structural_vibration"
    per = "axis"
    needs = ("time_since_accel_s", "sense_{axis}")
    about = About(
        cites="free vibration of a damped oscillator; Weekers & Schellekens, CIRP Annals 44 (1995) 469",
        words=Words(
            seen="{where} rings after accelerating ({amplitude}, {frequency})",
            causes="a resonance of the structure",
            confirm="wait before touching; vary the waiting time",
        ),
        aliases={"amplitude": "sine"},
    )
    diagnosis = ForDiagnosis(
        shows_in=_structural_vibration_shows_in,
    )
    axis: str = at("X", "linear axis")
    sine: float = param(
        0.0, "um", "sine part; `amplitude` in files", typical=Typical(0.5 * UM, "usual: 0.1-2 um at 10-60 Hz")
    )
    cosine: float = param(0.0, "um", "cosine part", typical=Typical(0.5 * UM, "usual: 0.1-2 um at 10-60 Hz"))
    frequency: float = param(20.0, "Hz", "frequency", scan=(8.0, 12.0, 16.0, 20.0, 27.0, 35.0, 45.0, 60.0))
    damping: float = param(0.05, "%", "damping ratio", show="1", scan=(0.02, 0.05, 0.1))
    follows: int = at(
        0, "1 = rings after every change of the acceleration, 0 = after one stop", quiet=True, forms=(0, 1)
    )

    def __post_init__(self) -> None:
        if not self.frequency > 0 or self.damping < 0:
            raise UsageError(f"{self.id}: the frequency must be positive, the damping zero or positive")

    @property
    def link(self) -> str:
        return self.axis

    def required_columns(self) -> tuple[str, ...]:
        return ("time_s", self._log) if self.follows else declared_columns(self)

    @property
    def _log(self) -> str:
        return f"accel_{self.axis}_mm_s2"

    def error_motion(self, run: Run) -> Array:
        if self.follows:
            state = self._state(run)
            return motion(run, **{self.axis: self.sine * state.imag + self.cosine * state.real})
        phase = 2 * np.pi * self.frequency * run.column("time_since_accel_s")
        ringing = self.sine * np.sin(phase) + self.cosine * np.cos(phase)
        fading = np.exp(-self.damping * phase) * run.column(f"sense_{self.axis}")
        return motion(run, **{self.axis: ringing * fading})

    def _state(self, run: Run) -> Complex:
        """sum over changes D_k of the acceleration, in m/s^2, of D_k exp((i - damping) w (t - t_k)) at every row (n,)."""
        log = run.series.get(self._log)
        if log is None:
            raise ModelLimit(f"{self.id} with follows = 1 needs a log of {self._log} over time_s; add it")
        rate = (1j - self.damping) * 2 * np.pi * self.frequency
        change = np.diff(log.value, prepend=0.0) / METRE
        fading = np.exp(rate * np.diff(log.time, prepend=log.time[0]))
        state = np.empty(len(change), dtype=complex)
        now = 0j
        for i, (step, less) in enumerate(zip(change.tolist(), fading.tolist())):
            state[i] = now = now * less + step
        time = run.column("time_s")
        last = np.searchsorted(log.time, time, side="right") - 1
        late = time - log.time[np.maximum(last, 0)]
        return np.where(last >= 0, state[np.maximum(last, 0)] * np.exp(rate * np.maximum(late, 0.0)), 0j)
