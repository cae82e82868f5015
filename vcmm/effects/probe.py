"""Probe and stylus: lobing, tip radius and offset, bending, trigger delay. All are readings, indicated - true.

The stylus column of a run says which stylus was used; an effect with stylus = "" acts on every row.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.effect import Effect, along, at, param
from vcmm.run import Array, Run


@dataclass(frozen=True, eq=False)
class _Probe(Effect):
    per = "stylus"

    @property
    def link(self) -> str:
        return "reading"


@dataclass(frozen=True, eq=False)
class ProbeLobing(_Probe):
    """Pre-travel of a touch probe: (cosine cos(k theta) + sine sin(k theta)) times the lateral share of n, along n.

    theta = probe_angle about the stylus axis, k = lobes (three seats of a kinematic probe).
    """

    name = "probe_lobing"
    needs = ("probe_angle_rad", "probe_lateral", "nx", "ny", "nz")
    aliases = {"amplitude": "cosine"}  # noqa: RUF012 - read only
    cites = (
        "Estler et al., Precision Engineering 19 (1996) 85: three-lobed pre-travel of kinematic touch probes"
    )
    stylus: str = at("", "stylus name; empty = all")
    cosine: float = param(0.0, "um", "cosine part; `amplitude` in files")
    sine: float = param(0.0, "um", "sine part")
    lobes: int = 3

    def error_motion(self, run: Run) -> Array:
        angle = self.lobes * run.column("probe_angle_rad")
        wave = self.cosine * np.cos(angle) + self.sine * np.sin(angle)
        return along(run, run.normal, wave * run.column("probe_lateral") * run.used("stylus", self.stylus))


@dataclass(frozen=True, eq=False)
class TipRadius(_Probe):
    """+dr along n, dr = actual - qualified radius: a ball larger than believed makes shafts larger, bores smaller."""

    name = "tip_radius"
    needs = ("nx", "ny", "nz")
    cites = "ISO 10360-5: stylus tip qualification; geometry of a ball on a surface"
    stylus: str = at("", "stylus name; empty = all")
    dr: float = param(0.0, "um", "actual minus qualified tip radius")

    def error_motion(self, run: Run) -> Array:
        return along(run, run.normal, self.dr * run.used("stylus", self.stylus))


@dataclass(frozen=True, eq=False)
class TipOffset(_Probe):
    """The qualified tip offset is wrong by a vector: indicated = true + (qualified - actual offset)."""

    name = "tip_offset"
    cites = "ISO 10360-5: stylus qualification; rigid shift of all touches of one stylus"
    stylus: str = at("", "stylus name; empty = all")
    d: Any = param(lambda: np.zeros(3), "um", "qualified minus actual offset, machine axes", shape="(3,)")

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, :3] = run.used("stylus", self.stylus)[:, None] * np.asarray(self.d, dtype=float)
        return out


@dataclass(frozen=True, eq=False)
class StylusBending(_Probe):
    """-c (length / 50 mm)^3 times the lateral share of the force, along n: a bent stylus indicates too little material.

    A cantilever bends with length^3 and only under lateral force (Euler-Bernoulli); the lateral share of n enters
    twice: once for the lateral force, once for the projection of the bend on n.
    """

    name = "stylus_bending"
    needs = ("probe_lateral", "stylus_length_mm", "nx", "ny", "nz")
    cites = "Euler-Bernoulli cantilever: w = F L^3 / (3 E I)"
    stylus: str = at("", "stylus name; empty = all")
    c: float = param(0.0, "um", "bending of a 50 mm stylus under full lateral force")

    def error_motion(self, run: Run) -> Array:
        slender = (run.column("stylus_length_mm") / 50.0) ** 3
        lateral = run.column("probe_lateral") ** 2
        return along(run, run.normal, -self.c * slender * lateral * run.used("stylus", self.stylus))


@dataclass(frozen=True, eq=False)
class TriggerDelay(_Probe):
    """(v · n) delay along n: the position is latched late; approaching, v · n < 0, so the material seems smaller."""

    name = "trigger_delay"
    needs = ("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s", "nx", "ny", "nz")
    cites = "kinematics: distance = speed x delay"
    stylus: str = at("", "stylus name; empty = all")
    delay: float = param(0.0, "ms", "time from contact to latching, less what qualification removed")

    def error_motion(self, run: Run) -> Array:
        speed = run.vector("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s")
        normal = run.normal
        return along(run, normal, (speed * normal).sum(axis=1) * self.delay * run.used("stylus", self.stylus))
