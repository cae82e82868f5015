"""Probe and stylus: lobing, tip radius and offset, bending, trigger delay. All are readings, indicated - true.

The stylus column of a run says which stylus was used; an effect with stylus = "" acts on every row.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from vcmm.core.declaration import (
    UM,
    About,
    ForDiagnosis,
    Opposite,
    SeenByQualification,
    Trade,
    Typical,
    Words,
)
from vcmm.core.effect import Effect, along, at, param
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class _Probe(Effect):
    per = "stylus"
    stylus: str = at("", "stylus name; empty = all")

    @property
    def link(self) -> str:
        return "reading"


@dataclass(frozen=True, eq=False)
class PreTravel(_Probe, SeenByQualification):
    """A reading along n that qualification sees too: what looks like an offset or a radius there is taken off.

    `spheres` (stylus -> its `run` on the reference sphere and S (4, n), `matrix`, which makes offset and radius of the readings
    there) is filled in for qualified styli; the reading of a touch is then
    reading n - (d1, d2, d3) - d4 n with d = S · (readings on the sphere). Linear, so departures are qualified alike.
    """

    spheres: Any = field(default_factory=dict, kw_only=True, metadata={"internal": True})

    def after_qualification(self, spheres: Mapping[str, Any]) -> PreTravel:
        mine = {name: s for name, s in spheres.items() if self.stylus in ("", name)}
        return replace(self, spheres=mine)

    @abstractmethod
    def reading(self, run: Run) -> Array:
        """Return the reading (n,) mm along n, for every row as if it were made with this stylus."""

    def error_motion(self, run: Run) -> Array:
        out = along(run, run.normal, self.reading(run) * run.label_mask("stylus", self.stylus))
        for name, sphere in self.spheres.items():
            d = sphere.matrix @ self.reading(sphere.run)
            out[:, :3] -= run.label_mask("stylus", name)[:, None] * (d[:3] + d[3] * run.normal)
        return out


@dataclass(frozen=True, eq=False)
class ProbeLobing(PreTravel):
    """Pre-travel of a touch probe: (cosine cos(k theta) + sine sin(k theta)) times the lateral share of n, along n.

    theta = probe_angle about the stylus axis, k = lobes (three seats of a kinematic probe).
    """

    name = "probe_lobing"
    about = About(
        cites="Estler et al., Precision Engineering 19 (1996) 85: three-lobed pre-travel of kinematic touch probes",
        trade=Trade(
            "pre-travel of the probe {where}",
            "qualify the probe with 25 touches, or measure both sides in one probe direction",
        ),
        words=Words(
            seen="the probe errs with the direction of touch ({amplitude})",
            causes="the three seats of a touch trigger probe",
            confirm="25 touches around a sphere; then another probe orientation",
        ),
        aliases={"amplitude": "cosine"},
    )
    diagnosis = ForDiagnosis(
        shared_physics="lobes",
    )
    needs = ("probe_angle_rad", "probe_lateral", "nx", "ny", "nz")
    cosine: float = param(
        0.0,
        "um",
        "cosine part; `amplitude` in files",
        typical=Typical(0.5 * UM, "+-0.3-1 um with 10-20 mm styli, to 5 um with long ones"),
    )
    sine: float = param(
        0.0,
        "um",
        "sine part",
        typical=Typical(0.5 * UM, "+-0.3-1 um with 10-20 mm styli, to 5 um with long ones"),
    )
    lobes: int = at(
        3,
        "lobes per turn",
        quiet=True,
        tries=(3, 2, 4),
        waves_over="probe_angle_rad",
        waves_by="probe_lateral",
    )

    def reading(self, run: Run) -> Array:
        angle = self.lobes * run.column("probe_angle_rad")
        wave = self.cosine * np.cos(angle) + self.sine * np.sin(angle)
        return np.asarray(wave * run.column("probe_lateral"))


@dataclass(frozen=True, eq=False)
class StylusBending(PreTravel):
    """-c (length / 50 mm)^3 times the lateral share of the force, along n: a bent stylus indicates too little material.

    A cantilever bends with length^3 and only under lateral force (Euler-Bernoulli); the lateral share of n enters
    twice: once for the lateral force, once for the projection of the bend on n.
    """

    name = "stylus_bending"
    about = About(
        cites="Euler-Bernoulli cantilever: w = F L^3 / (3 E I)",
        trade=Trade("bending of stylus {where}", "a shorter or stiffer stylus"),
        words=Words(
            seen="the stylus bends sideways ({c})",
            causes="a long or thin stylus, or a high force",
            confirm="repeat with half the stylus length or half the force",
        ),
    )
    needs = ("probe_lateral", "stylus_length_mm", "nx", "ny", "nz")
    c: float = param(
        0.0,
        "um",
        "bending of a 50 mm stylus under full lateral force",
        typical=Typical(
            1 * UM, "0.1 N on 50 mm of carbide, d 3 mm: 0.1 x 50^3 / (3 x 6e5 x 4.0) mm = 1.7 um"
        ),
    )

    def reading(self, run: Run) -> Array:
        slender = (run.column("stylus_length_mm") / 50.0) ** 3
        return np.asarray(-self.c * slender * run.column("probe_lateral") ** 2)


@dataclass(frozen=True, eq=False)
class TriggerDelay(PreTravel):
    """(v · n) delay along n: the position is latched late; approaching, v · n < 0, so the material seems smaller."""

    name = "trigger_delay"
    about = About(
        cites="kinematics: distance = speed x delay",
        trade=Trade("delay of the trigger {where}", "touch more slowly, at the speed of the qualification"),
        words=Words(
            seen="the probe answers late ({delay})",
            causes="probe electronics; qualified at another speed",
            confirm="touch a ring and a plug at three speeds",
            opposite=Opposite("delay", "the probe answers earlier than its correction says ({delay})"),
        ),
    )
    needs = ("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s", "nx", "ny", "nz")
    delay: float = param(
        0.0,
        "ms",
        "time from contact to latching, less what qualification removed",
        typical=Typical(2e-4, "1 ms at 5 mm/s is 5 um, mostly removed by qualification"),
    )

    def reading(self, run: Run) -> Array:
        speed = run.vector("speed_X_mm_s", "speed_Y_mm_s", "speed_Z_mm_s")
        return np.asarray((speed * run.normal).sum(axis=1) * self.delay)
