"""A room that is not at one temperature: it changes while a plan is measured, and from place to place.

What a room is built for is stated as K/h, K/d and K/m (VDI/VDE 2627 Part 1). Part and scales follow the air here without delay and in
full: both lag behind a real one, so that these are upper bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import HOUR, About, ForDiagnosis, Typical
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run

STEEL, UNNAMED = (8e-6, 11.5e-6, 23e-6), ForDiagnosis(is_named=False)
RATE = Typical(0.3 / HOUR, "measuring rooms 0.2-1 K/h, workshops 1-3 K/h")


@dataclass(frozen=True, eq=False)
class RoomDrift(Effect):
    """+alpha rate t p: the part has grown since its temperature was read, at time_s = 0. p from the part's origin.

    A steel part of 400 mm in a room that warms by 1 K/h is 2.3 um longer after half an hour.
    """

    name = "room_drift"
    per = "part"
    needs = ("time_s",)
    about = About(
        cites="JCGM 100:2008, H.1 (expansion); VDI/VDE 2627 Part 1 (changes of a room in K/h and K/d)",
        belongs_to="part",
    )
    diagnosis = UNNAMED
    rate: float = param(0.0, "K/h", "change of the part's temperature since it was read", typical=RATE)
    alpha: float = param(
        11.5e-6, "um/(m K)", "expansion coefficient of the part; steel when left out", scan=STEEL
    )

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        x, y, z = (self.alpha * self.rate * run.column("time_s")[:, None] * run.part_point).T
        return motion(run, X=x, Y=y, Z=z)


@dataclass(frozen=True, eq=False)
class RoomDriftOfScale(Effect):
    """alpha rate t q_a e_a: a scale without correction that has grown since time_s = 0 makes the machine travel too far."""

    name = "room_drift_of_scale"
    per = "axis"
    needs = ("time_s",)
    about = About(
        cites="JCGM 100:2008, H.1 (expansion); VDI/VDE 2627 Part 1 (changes of a room in K/h and K/d)",
    )
    diagnosis = UNNAMED
    axis: str = at("X", "linear axis")
    rate: float = param(0.0, "K/h", "change of the temperature of the scale", typical=RATE)
    alpha: float = param(
        8e-6, "um/(m K)", "expansion coefficient of the scale; glass when left out", scan=STEEL
    )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        return motion(run, **{self.axis: self.alpha * self.rate * run.column("time_s") * run.q(self.axis)})


@dataclass(frozen=True, eq=False)
class RoomGradient(Effect):
    """+alpha g (s p - e p^2 / 2), s = e p: a part that is warmer by g s along e, from its origin at p = 0.

    A temperature that is linear in place strains a free body without stress: strains alpha g s alike in all directions, no shear; the
    displacement is their integral, e = x: u = alpha g ((x^2 - y^2 - z^2) / 2, x y, x z). Long parts bow: a beam along x in a gradient
    along z sags by alpha g x^2 / 2.
    """

    name = "room_gradient"
    per = "direction"
    about = About(
        cites="Boley & Weiner, Theory of Thermal Stresses (1960), 3.3 (linear temperature fields); VDI/VDE 2627 Part 1 (K/m)",
        belongs_to="part",
    )
    diagnosis = UNNAMED
    direction: str = at("z", "x, y or z of the workpiece axes: where it gets warmer")
    g: float = param(
        0.0,
        "K/m",
        "change of the part's temperature over its length",
        typical=Typical(0.3 / 1000.0, "measuring rooms 0.2-0.5 K/m, workshops 1-2 K/m"),
    )
    alpha: float = param(
        11.5e-6, "um/(m K)", "expansion coefficient of the part; steel when left out", scan=STEEL
    )

    def __post_init__(self) -> None:
        if self.direction not in ("x", "y", "z"):
            raise UsageError(f'room_gradient: direction = "{self.direction}" must be "x", "y" or "z"')

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        p, along = run.part_point, "xyz".index(self.direction)
        moved = p[:, along, None] * p
        moved[:, along] -= (p**2).sum(axis=1) / 2.0
        x, y, z = (self.alpha * self.g * np.asarray(moved)).T
        return motion(run, X=x, Y=y, Z=z)
