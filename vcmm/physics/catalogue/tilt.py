"""Tilts and offsets in two directions: one axis that leans askew is one fault with two numbers.

The second shapes of squareness and rotary_location, and reported as such. A column that leans, a table or an azimuth axis
whose base is not level, a head mounted off its centre: what moved has no reason to move along one axis of the machine.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from vcmm.core.axes import LINEAR, ROTARY, is_rotary
from vcmm.core.declaration import UM, URAD, About, ForDiagnosis, Prior, Typical, Words
from vcmm.core.effect import COLUMN, Effect, at, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


def _two_directions_elements(effect: _TwoDirections) -> tuple[str, ...]:
    across = [i for i in range(3) if LINEAR[i] != effect.axis and ROTARY[i] != effect.axis[0]]
    return tuple(f"{effect.letters[i]}0{effect.axis}" for i in across)


@dataclass(frozen=True, eq=False)
class _TwoDirections(Effect):
    per = "axis"
    diagnosis = ForDiagnosis(
        # most are set along one axis
        prior=Prior(share=0.3),
        moves_together=True,
        elements=_two_directions_elements,
    )
    letters: ClassVar[str] = ROTARY  # of the two numbers: turns, or shifts
    axis: str = at("C", "axis")

    def __post_init__(self) -> None:
        if np.size(getattr(self, self.diagnosis.size_name)) != 2:
            raise UsageError(
                f"{self.id}: {self.diagnosis.size_name} takes two numbers, one each for {' and '.join(self.diagnosis.elements(self))}"
            )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        for name, amount in zip(
            self.diagnosis.elements(self), np.asarray(getattr(self, self.diagnosis.size_name), dtype=float)
        ):
            out[:, COLUMN[name[0]]] = amount
        return out


@dataclass(frozen=True, eq=False)
class AxisLean(_TwoDirections):
    """The direction of travel of Z leans about A and B (A0Z, B0Z), each as in squareness."""

    name = "axis_lean"
    diagnosis = ForDiagnosis(
        family="squareness",
        prior=Prior(share=0.3),
        size_name="angle",
        moves_together=True,
        elements=_two_directions_elements,
    )
    place = "travel"
    about = About(
        cites="ISO 230-1:2012, 3.6: two squareness errors of one axis",
        words=Words(
            seen="{where} leans by {angle}, askew to both other axes",
            causes="the column or ram was moved or levelled anew",
            confirm="a square in both planes, turned by 180 degrees",
        ),
    )
    axis: str = at("Z", "Z, the axis that is carried by the other two")
    angle: Any = param(
        lambda: np.zeros(2), "urad", "A0Z and B0Z", shape="(2,)",
        typical=Typical(10 * URAD, "as squareness", most=5e-3),
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.axis != "Z":
            raise UsageError(
                f'axis_lean: axis = "{self.axis}"; only Z has two squareness errors, A0Z and B0Z'
            )


@dataclass(frozen=True, eq=False)
class CentreLineTilt(_TwoDirections):
    """The centre line of a rotary axis is tilted in two directions (A0C and B0C), in the frame that carries it."""

    name = "rotary_tilt"
    diagnosis = ForDiagnosis(
        family="rotary_location",
        prior=Prior(share=0.3),
        size_name="tilt",
        moves_together=True,
        elements=_two_directions_elements,
    )
    place = "location"
    own = True
    about = About(
        cites="ISO 230-1:2012, 3.7: two tilts of one centre line; AN and AW of a mount that is not level",
        words=Words(
            seen="the centre line of {where} is tilted by {tilt}",
            causes="the base was set anew, is not level or was hit",
            confirm="a level on the axis, turned through a full turn",
        ),
    )
    tilt: Any = param(
        lambda: np.zeros(2), "urad", "the two tilts, in the order of the alphabet", shape="(2,)",
        typical=Typical(20 * URAD, "as rotary_location", most=20e-3),
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_rotary(self)


@dataclass(frozen=True, eq=False)
class CentreLineOffset(_TwoDirections):
    """The centre line of a rotary axis is shifted in two directions (X0C and Y0C), in the frame that carries it."""

    name = "rotary_offset"
    diagnosis = ForDiagnosis(
        family="rotary_location",
        prior=Prior(share=0.3),
        size_name="offset",
        moves_together=True,
        elements=_two_directions_elements,
    )
    place = "location"
    own = True
    letters: ClassVar[str] = LINEAR
    about = About(
        cites="ISO 230-1:2012, 3.7: two offsets of one centre line",
        words=Words(
            seen="the centre line of {where} is shifted by {offset}",
            causes="the table was set anew or hit",
            confirm="touch a sphere on the table at four angles",
        ),
    )
    offset: Any = param(
        lambda: np.zeros(2), "um", "the two offsets, in the order of the alphabet", shape="(2,)",
        typical=Typical(10 * UM, "as rotary_location", most=2.0),
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        _check_rotary(self)


def _check_rotary(effect: Effect) -> None:
    axis = str(getattr(effect, "axis", ""))
    if not is_rotary(axis):
        raise UsageError(f'{effect.name}: axis = "{axis}" is no rotary axis; write axis = "C"')
