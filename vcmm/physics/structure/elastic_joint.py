"""Elastic joint: a joint of an arm yields under the weight that it carries."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.axes import is_axis, is_rotary
from vcmm.core.declaration import URAD, About, ForDiagnosis, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


def signed_axes(words: str) -> tuple[tuple[float, str], ...]:
    """Parse the signed axes of a text: "A2 -A3" -> ((1, "A2"), (-1, "A3")). Raises UsageError for a word that is no rotary axis."""
    out = []
    for word in words.split():
        name = word.lstrip("+-")
        if not (is_axis(name) and is_rotary(name)):
            raise UsageError(
                f'angles = "{words}": "{word}" is no rotary axis; write the joints whose angles add up to the inclination of the link, such as '
                '"A2 A3", or "A2 -A3" where they turn about opposite directions'
            )
        out.append((-1.0 if word.startswith("-") else 1.0, name))
    return tuple(out)


@dataclass(frozen=True, eq=False)
class ElasticJoint(Effect):
    """The joint turns by c cos(p) + s sin(p), p the sum of the signed joint angles `angles`.

    A link of weight M g whose centre of mass lies at the distance r from a horizontal joint, in the direction p + p0, loads the joint
    with M g r cos(p + p0). Torque over stiffness K turns it by (M g r / K) (cos p0 cos p - sin p0 sin p). So c and s are compliance times
    the torque of the level and of the upright link; poses alone do not tell K from M r. Exact where all joints named turn about the same
    horizontal direction. Joint A2 of a six-axis arm carries its own link (`angles` = "A2") and the forearm ("A2 A3").
    """

    name = "elastic_joint"
    per = "axis"
    about = About(
        cites="Khalil & Dombre, Modeling, Identification and Control of Robots (2002), 9.6: flexibility of joints, angle = compliance x torque "
        "of gravity",
        words=Words(
            seen="joint {axis} yields under weight by {amplitude} as {angles} turn",
            causes="weight of links and payload on gear and bearing",
            confirm="the same poses with another payload: the deflection grows with it",
        ),
        aliases={"amplitude": "coefficients"},
    )
    diagnosis = ForDiagnosis(is_named=False, size_name="amplitude")
    axis: str = at("C", "joint that yields, a rotary axis that turns about a horizontal direction")
    angles: str = at("C", 'joints whose angles add up to the inclination of the weight, such as "A2 A3"')
    coefficients: Any = param(
        lambda: np.zeros(2), "urad", "at the cosine and at the sine of the summed angles; `amplitude` in files", shape="(2,)",
        typical=Typical(200 * URAD, "arms: 1e-6 rad/(N m) at 100 to 1000 N m", most=20e-3), lengths=(2,),
    )  # fmt: skip

    def __post_init__(self) -> None:
        if not (is_axis(self.axis) and is_rotary(self.axis)):
            raise UsageError(f'axis = "{self.axis}" is no rotary axis; write for example "A2"')
        if not signed_axes(self.angles):
            raise UsageError(f'{self.name}: angles is empty; write for example "A2 A3"')
        if np.size(self.coefficients) != 2:
            raise UsageError(
                f'{self.id}: {np.size(self.coefficients)} numbers; a deflection has two, at the cosine and at the sine, such as "120 -40 urad"'
            )

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        inclination = np.sum([sign * run.q(name) for sign, name in signed_axes(self.angles)], axis=0)
        cosine, sine = np.asarray(self.coefficients, dtype=float)
        out = motion(run)
        out[:, 3 + "ABC".index(self.axis[0])] = cosine * np.cos(inclination) + sine * np.sin(inclination)
        return out
