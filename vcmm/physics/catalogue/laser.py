"""Errors of a laser interferometer: cosine error, air, dead path. All are readings, indicated - true.

A recording of lengths states where the beam begins, from_x_mm from_y_mm from_z_mm (the station of a tracker or tracer):
lengths count from there, and the path is as long as the length. Without it they count from the origin of the workpiece axes,
where the counter is taken to be zero; another zero is a constant along the beam, which a recording's nuisance `zero` takes up
while the strain does not change. Where it does, as with the weather, the zero matters: with zero = 1 lengths count from the
first row of every set-up, columns counted_x_mm, counted_y_mm, counted_z_mm, which a recording of displacements fills in.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import About, ChoosesColumns, ForDiagnosis, Typical, Words
from vcmm.core.effect import Effect, along, at, motion, param
from vcmm.core.run import T0_DEG_C, Array, Run

P0_HPA, H0_PCT = 1013.25, 50.0
# change of the index of air per K, per hPa, per % relative humidity
K_T = -0.93e-6
K_P = 0.27e-6
K_H = -0.01e-6


def index_change(run: Run) -> Array:
    """Return the refractive index of air less that at 20 degC, 1013.25 hPa and 50 % (n,); without humidity_pct at 50 %.

    First order about that state of the formula of Birch & Downs, Metrologia 30 (1993) 155, at 633 nm.
    """
    humidity = run.columns.get("humidity_pct", H0_PCT)
    change = K_T * (run.column("temp_air_C") - T0_DEG_C) + K_P * (run.column("pressure_hPa") - P0_HPA)
    return change + K_H * (humidity - H0_PCT)


COUNTED = ("counted_x_mm", "counted_y_mm", "counted_z_mm")
STATION = ("from_x_mm", "from_y_mm", "from_z_mm")


def way(run: Run, counted: bool = False) -> Array:
    """Return the beam (n, 3) mm, workpiece axes: from its station, from the first row of the set-up (counted), or from the origin."""
    if all(c in run.columns for c in STATION):
        return run.tip - run.vector(*STATION)
    return run.vector(*COUNTED) if counted else run.tip


@dataclass(frozen=True, eq=False)
class _Laser(Effect):
    per = "instrument"

    @property
    def link(self) -> str:
        return "reading"

    def _stretch(self, run: Run, strain: float | Array, counted: bool = False) -> Array:
        used = strain * run.label_mask("instrument", getattr(self, "instrument", ""))
        x, y, z = way(run, counted).T
        return motion(run, X=used * x, Y=used * y, Z=used * z)


def _cosine_error_report(effect: CosineError, values: Array) -> tuple[str, Array, str]:
    """Report the cosine error as an angle: the amplitude multiplies its square."""
    return "theta", effect.theta * np.sqrt(np.maximum(values, 0.0)), "mrad"


@dataclass(frozen=True, eq=False)
class CosineError(_Laser):
    """+1/2 theta^2 L, times `share`: the beam is not parallel to the travel.

    theta acts by its square, so it is held fixed and `share` is the linear amplitude: the angle found is
    theta times the root of share.
    """

    name = "cosine_error"
    diagnosis = ForDiagnosis(
        # theta^2
        is_never_negative=True,
        report=_cosine_error_report,
    )
    about = About(
        cites="Steinmetz, Precision Engineering 12 (1990) 12: sub-micron position measurement with laser interferometry",
        words=Words(
            seen="the instrument is misaligned ({theta})",
            causes="beam not parallel to the travel",
            confirm="align the beam again over the whole travel",
        ),
    )
    theta: float = param(0.0, "mrad", "angle between beam and travel", scan=(1e-3,))
    share: float = param(
        1.0, "%", "multiplies theta^2", show="1", typical=Typical(1.0, "theta = 1 mrad is 0.5 um/m")
    )
    instrument: str = at("", "instrument name; empty = all")

    def error_motion(self, run: Run) -> Array:
        return self._stretch(run, self.share * 0.5 * self.theta**2)


@dataclass(frozen=True, eq=False)
class AirIndex(_Laser, ChoosesColumns):
    """scale L (-0.93 ppm/K (T_air - 20 degC) + 0.27 ppm/hPa (P - 1013.25 hPa) - 0.01 ppm/% (H - 50 %)).

    scale = 1: the instrument does not correct for the air at all; 0: it does so rightly. Without a column
    humidity_pct the humidity is taken as 50 %.
    """

    name = "air_index"
    needs = ("temp_air_C", "pressure_hPa")
    about = About(
        cites="Birch & Downs, Metrologia 30 (1993) 155: updated Edlen equation",
        words=Words(
            seen="the wavelength follows the air ({scale} times the full correction)",
            causes="air temperature, pressure or humidity not compensated",
            confirm="log the air and switch the compensation on",
            signed=("scale",),
        ),
    )
    scale: float = param(
        0.0,
        "%",
        "share of the change that is not corrected",
        show="1",
        typical=Typical(
            1.0,
            "no correction at all: 1-10 ppm, which is 1; corrected twice -1, with the wrong sign 2",
            bounds=(-1.0, 2.0),
        ),
    )
    instrument: str = at("", "instrument name; empty = all")
    zero: int = at(
        0, "lengths from 0 = the origin, 1 = the first row of every set-up", quiet=True, forms=(0, 1)
    )

    def required_columns(self) -> tuple[str, ...]:
        return (*self.needs, *COUNTED) if self.zero else self.needs

    def error_motion(self, run: Run) -> Array:
        return self._stretch(run, self.scale * index_change(run), bool(self.zero))


@dataclass(frozen=True, eq=False)
class DeadPath(_Laser):
    """length x index change along the beam: the path between the interferometer and the zero of the count changes too.

    The beam goes along n, or from its station to the tip. A longer optical path is indicated as a longer displacement; only
    what changes after the zero is seen.
    """

    name = "dead_path"
    needs = ("temp_air_C", "pressure_hPa")
    about = About(
        cites="Steinmetz, Precision Engineering 12 (1990) 12: dead path error",
        words=Words(
            seen="the dead path of the laser is not compensated ({length})",
            causes="optics set up far from the first point",
            confirm="move the optics close to the first point",
            signed=("length",),
        ),
    )
    length: float = param(
        0.0,
        "mm",
        "dead path that the instrument does not know of",
        typical=Typical(100.0, "optics set up 50-500 mm from the first point"),
    )
    instrument: str = at("", "instrument name; empty = all")

    def error_motion(self, run: Run) -> Array:
        used = run.label_mask("instrument", self.instrument)
        return along(run, self._beam(run), self.length * index_change(run) * used)

    @staticmethod
    def _beam(run: Run) -> Array:
        """Return the unit vectors (n, 3) along the beam; zero at the station itself."""
        if not all(c in run.columns for c in STATION):
            return run.normal
        whole = way(run)
        length = np.linalg.norm(whole, axis=1)[:, None]
        return np.asarray(whole / np.where(length > 0, length, 1.0))
