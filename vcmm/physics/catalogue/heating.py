"""Heat that the machine makes itself: spindle growth, expansion of a ball screw with use."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Opposite, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run


def _screw_heating_file_note(effect: ScrewHeating) -> str:
    return "acts with the distance travelled since the start of a job (travel_..._mm); a job without it is refused"


@dataclass(frozen=True, eq=False)
class ScrewHeating(Effect):
    """(k q_a + shift) (1 - exp(-travel / distance)) e_a: a screw expands as it warms with the distance travelled.

    shift = -k q_f where the screw is held at q_f and not at zero. A distance far beyond the travel made gives an
    expansion in proportion to it.
    """

    name = "screw_heating"
    per = "axis"
    needs = ("travel_{axis}_mm",)
    about = About(
        cites="ISO 230-3:2020: thermal distortion caused by moving linear axes",
        words=Words(
            seen="{where} stretches with the distance travelled ({k})",
            causes="the ball screw warms with use",
            confirm="move to and fro for half an hour and measure again",
            opposite=Opposite("k", "{where} shrinks with the distance travelled ({k})"),
        ),
    )
    diagnosis = ForDiagnosis(
        file_note=_screw_heating_file_note,
    )
    axis: str = at("X", "linear axis driven by a screw without a scale")
    k: float = param(
        0.0,
        "um/m",
        "strain of the warm screw",
        typical=Typical(50e-6, "usual: 50-100 um/m for a screw without a scale"),
    )
    shift: float = param(
        0.0,
        "um",
        "shift of the axis zero when warm",
        typical=Typical(20 * UM, "50 um/m with the fixed bearing 0.4 m from the zero"),
    )
    distance: float = param(
        1e5, "mm", "travel after which 63 % is reached", scan=(3e3, 1e4, 3e4, 1e5, 3e5, 1e6)
    )

    def __post_init__(self) -> None:
        if not self.distance > 0:
            raise UsageError(f'{self.id}: distance must be positive; write for example distance = "100 m"')

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        warm = -np.expm1(-run.column(f"travel_{self.axis}_mm") / self.distance)
        return motion(run, **{self.axis: (self.k * run.q(self.axis) + self.shift) * warm})
