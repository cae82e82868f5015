"""Scale factor: an axis travels too far in proportion to its position."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class ScaleFactor(Effect):
    """k q_a e_a: with k = +5 um/m an axis at 400 mm stands 2 um too far in + direction."""

    name = "scale_factor"
    per = "axis"
    cites = "ISO 230-2; linear positioning error"
    axis: str = at("X", "linear axis")
    k: float = param(0.0, "um/m", "error per travelled length")

    @property
    def link(self) -> str:
        return self.axis

    def error_motion(self, run: Run) -> Array:
        return motion(run, **{self.axis: self.k * run.q(self.axis)})
