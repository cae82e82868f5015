"""Flexure: the structure yields under its own moving weight, under the part, or under a temperature gradient.

`origin` is where along its axis the structure is level: the zero of the axis, or the middle of the travel.

All state the tip error along one direction of the axis's frame; `direction` is "x", "y" or "z".
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.axes import LINEAR
from vcmm.core.declaration import UM, About, ForDiagnosis, Site, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run

METRE = 1000.0


@dataclass(frozen=True, eq=False)
class _Flexure(Effect):
    axis: str = at("X", "linear axis")

    @property
    def link(self) -> str:
        return self.axis


def _check_direction(effect: Effect, direction: str) -> None:
    if direction not in ("x", "y", "z"):
        raise UsageError(f'{effect.name}: direction = "{direction}" must be "x", "y" or "z"')


def _cross_axis_flexure_trials(
    effect: CrossAxisFlexure, name: str
) -> list[tuple[dict[str, Any], float]] | None:
    """Return the trials of a flexure: a structure that reaches out droops across its way; along it a power of its own position is a
    change of its scale."""
    along = name == "power" and effect.direction.upper() == effect.other
    return [({"power": 1}, 0.0)] if along else None


@dataclass(frozen=True, eq=False)
class CrossAxisFlexure(_Flexure):
    """c q_a q_b along a direction (power = 1), or c q_b^p (power = p > 1): what axis b does depends on where a stands.

    Ram droop is q_b^2 or q_b^3 in z. c always is per m^2: power p means c q_b^2 (q_b / 1 m)^(p - 2).
    """

    name = "cross_axis_flexure"
    per = "axis, other, direction"
    about = About(
        cites="Schwenke et al., CIRP Annals 57 (2008) 660: non-rigid behaviour; cantilever beam under a moving load",
        words=Words(
            seen="the structure bends with the position of the other axis ({where}, {c})",
            causes="weight of a slide or ram on its guide",
            confirm="measure one axis at three places of the other",
            signed=("c",),
        ),
    )
    diagnosis = ForDiagnosis(
        special_case_of=("geometric_change",),
        trials=_cross_axis_flexure_trials,
    )
    other: str = at("Z", "other axis: the one that reaches out")
    direction: str = at("z", "x, y or z: where it yields")
    c: float = param(
        0.0,
        "um/m^2",
        "displacement per product of positions",
        typical=Typical(20 * UM / 1e6, "usual: 1-20 um over 0.5 m x 0.5 m"),
    )
    power: int = at(
        1, "1 = product of both positions, p > 1 = power p of the other alone", quiet=True, tries=(1, 2, 3)
    )
    origin: float = 0.0
    other_origin: float = 0.0

    def __post_init__(self) -> None:
        _check_direction(self, self.direction)

    def error_motion(self, run: Run) -> Array:
        b = run.q(self.other) - self.other_origin
        shape = (
            (run.q(self.axis) - self.origin) * b
            if self.power == 1
            else b**2 * (b / METRE) ** (self.power - 2)
        )
        return motion(run, **{self.direction.upper(): self.c * shape})


@dataclass(frozen=True, eq=False)
class PartLoad(_Flexure):
    """c load q_a along the loaded direction, load in kg: a heavy part tilts or bends what carries it."""

    name = "part_load"
    per = "axis, direction"
    needs = ("load_kg",)
    about = About(
        cites="ASME B89.4.1-1997: workpiece loading effects",
        words=Words(
            seen="a load bends {where} ({c})",
            causes="weight of part or pallet",
            confirm="the same artefact with and without ballast",
        ),
    )
    direction: str = at("z", "x, y or z: where it yields")
    c: float = param(
        0.0,
        "um/(m kg)",
        "displacement per travel and mass",
        typical=Typical(0.05 * UM / 1e3, "usual: 0-5 um per 100 kg over 0.5 m"),
    )
    origin: float = 0.0

    def __post_init__(self) -> None:
        _check_direction(self, self.direction)

    def error_motion(self, run: Run) -> Array:
        amount = self.c * run.column("load_kg") * (run.q(self.axis) - self.origin)
        return motion(run, **{self.direction.upper(): amount})


def _gradient_bending_make_at(
    cls: type[GradientBending], place: Mapping[str, Any], site: Site
) -> GradientBending:
    return cls(**place, carries="workpiece" if place["axis"] in site.work else "tool")


@dataclass(frozen=True, eq=False)
class GradientBending(_Flexure):
    """k gradient q_a^2 in the bent direction, with its pitch 2 k gradient q_a about (axis x direction).

    A guide of height h with a temperature difference dT across it bends to k = alpha / (2 h). A carriage that climbs
    +direction along +axis noses up; where the axis carries the workpiece (carries = "workpiece") its own place on
    the guide is -q, so the pitch belonging to the same displacement has the other sign.
    """

    name = "gradient_bending"
    per = "axis, direction"
    needs = ("temp_gradient_C",)
    about = About(
        cites="Boley & Weiner, Theory of Thermal Stresses (1960): curvature alpha dT / h of a beam heated on one side",
        words=Words(
            seen="a temperature difference bends {where} ({k})",
            causes="top warmer than bottom: lights, sun, coolant",
            confirm="repeat with lights or air conditioning off",
        ),
    )
    diagnosis = ForDiagnosis(
        make_at=_gradient_bending_make_at,
    )
    direction: str = at("z", "x, y or z: where it bends")
    k: float = param(
        0.0,
        "um/(m^2 K)",
        "half the curvature per temperature difference",
        typical=Typical(10 * UM / 1e6, "alpha / (2 h): granite 6 um/(m K) / (2 x 0.3 m) = 10 um/(m^2 K)"),
    )
    carries: str = "tool"
    origin: float = 0.0

    def __post_init__(self) -> None:
        _check_direction(self, self.direction)
        if self.axis not in LINEAR:
            raise UsageError(
                f'{self.id}: only the guide of a linear axis bends; write axis = "X", "Y" or "Z"'
            )
        if self.direction.upper() == self.axis:
            raise UsageError(f"{self.id}: a guide bends across its axis; choose another direction")
        if self.carries not in ("tool", "workpiece"):
            raise UsageError(f'{self.id}: carries = "{self.carries}" must be "tool" or "workpiece"')

    def error_motion(self, run: Run) -> Array:
        q, bend = run.q(self.axis) - self.origin, self.k * run.column("temp_gradient_C")
        side = 1.0 if self.carries == "tool" else -1.0
        unit = np.eye(3)
        about = np.cross(unit["XYZ".index(self.axis)], unit["xyz".index(self.direction)])
        out = motion(run, **{self.direction.upper(): bend * q**2})
        out[:, 3:] = (side * 2 * bend * q)[:, None] * about
        return out
