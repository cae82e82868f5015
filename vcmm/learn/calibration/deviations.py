"""Deviations of one recording of an acceptance test, with simulated ones for the errors of the instrument."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.acceptance import Figure, Limit
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.response.recording import Recording

TRIALS, SAME = 2000, 1e-6
Limits = Mapping[str, Limit]


@dataclass(frozen=True, eq=False)
class RecordedTest:
    """recording, the machine it was made on (kinematics), the certificate of its instrument where one is known."""

    recording: Recording
    machine: Machine
    certificate: InstrumentCertificate | None = None

    @property
    def value(self) -> Array:
        """Deviations actual - commanded (m,), mm or rad."""
        return -self.recording.value if self.recording.measuring else self.recording.value

    @property
    def scale(self) -> float:
        """Factor to um or urad."""
        return 1e6 if self.recording.kind == "angle" else 1e3

    @cached_property
    def draws(self) -> Array | None:
        """Simulated values (TRIALS, m) with errors of the instrument by its certificate; None without one."""
        if self.certificate is None:
            return None
        rng = np.random.default_rng(0)
        moved = np.zeros((TRIALS, self.recording.m))
        for _, columns in self.certificate.columns(self.recording, self.machine.prepare(self.recording.run)):
            moved += rng.standard_normal((TRIALS, columns.shape[1])) @ columns.T
        return self.value + moved

    def figures(
        self, compute: Callable[[Array], Mapping[str, Array]], where: str, limits: Limits, length: float
    ) -> list[Figure]:
        """Return the figures. compute: values (..., m) to figures (...). where: text behind their names; length mm: for limits with L."""
        drawn = None if self.draws is None else compute(self.draws)
        out = []
        for name, value in compute(self.value).items():
            limit = limit_of(limits, name, where)
            spread = None if drawn is None else drawn[name]
            allowed = None if limit is None else limit(length)
            out.append(figure_of(f"{name} {where}".strip(), float(value), spread, allowed, self.scale))
        return out


def limit_of(limits: Limits, name: str, where: str) -> Limit | None:
    """Return the limit of "E X", else that of "E"."""
    return limits.get(f"{name} {where}", limits.get(name))


def figure_of(
    name: str, value: float, drawn: Array | None, limit: float | None = None, scale: float = 1e3
) -> Figure:
    """Return a figure with its draws (trials,) mm or rad; the draws are about the value, so that only their spread counts."""
    u = None if drawn is None else float(drawn.std())
    passed = None if limit is None else float(value <= limit)
    if limit is not None and drawn is not None:
        passed = float((value + drawn - drawn.mean() <= limit).mean())
    return Figure(
        name,
        value * scale,
        None if u is None else u * scale,
        None if limit is None else limit * scale,
        passed,
    )
