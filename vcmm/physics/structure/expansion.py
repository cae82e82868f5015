"""Thermal expansion of scales and part, and the error that remains after compensation.

The control corrects with its own coefficient and its sensor's reading; the physics follows the true ones:
    left over = (alpha (T - 20) - corrected (T_read - 20)) L
so that with alpha = corrected the uncertainties u(alpha) dT L and alpha u(dT) L both remain (JCGM 100, H.1).
"""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.core.declaration import About, ChoosesColumns, Trade, Typical, Words
from vcmm.core.effect import Effect, at, motion, param
from vcmm.core.run import T0_DEG_C, Array, Run


def _left_over(run: Run, name: str, alpha: float, corrected: float) -> Array:
    """Return the strain (n,): alpha (T - 20) - corrected (reading - 20); the reading is the temperature itself when not logged."""
    true = run.column(f"temp_{name}_C") - T0_DEG_C
    reading = run.columns.get(f"reading_{name}_C")
    read = true if reading is None else reading - T0_DEG_C
    return alpha * true - corrected * read


@dataclass(frozen=True, eq=False)
class ScaleExpansion(Effect, ChoosesColumns):
    """alpha (T_scale,a - 20 degC) q_a e_a: a long scale makes the machine travel too far."""

    name = "scale_expansion"
    about = About(
        cites="JCGM 100:2008, H.1; ISO 1 (20 degC); ISO/TR 16015",
        trade=Trade(
            "expansion coefficient of the scales {where}",
            "measure nearer to 20 °C, or calibrate the expansion of the scales",
        ),
        words=Words(
            seen="the scale of {where} follows the temperature ({alpha})",
            causes="expansion coefficient or scale temperature not compensated",
            confirm="the same length at temperatures 2 K apart",
            signed=("alpha",),
        ),
    )
    per = "axis"
    needs = ("temp_scale_{axis}_C",)
    axis: str = at("X", "linear axis")
    alpha: float = param(
        0.0,
        "um/(m K)",
        "expansion coefficient of the scale",
        typical=Typical(
            8e-6, "steel 11.5, glass 8, Zerodur 0 um/(m K)", bounds=(-35e-6, 35e-6)
        ),  # zinc 30; negative where the control corrects too much
    )
    corrected: float = param(
        0.0, "um/(m K)", "coefficient used by the control's own correction, 0 = none", chosen=True
    )

    @property
    def link(self) -> str:
        return self.axis

    def required_columns(self) -> tuple[str, ...]:
        return (f"temp_scale_{self.axis.lower()}_C",)

    def error_motion(self, run: Run) -> Array:
        strain = _left_over(run, f"scale_{self.axis.lower()}", self.alpha, self.corrected)
        return motion(run, **{self.axis: strain * run.q(self.axis)})


@dataclass(frozen=True, eq=False)
class PartExpansion(Effect):
    """+alpha (T_part - 20 degC) p: a warm part is larger, so it is indicated larger. p from the part's origin."""

    name = "part_expansion"
    about = About(
        cites="JCGM 100:2008, H.1; ISO 1 (20 degC)",
        trade=Trade(
            "expansion coefficient of the part", "measure nearer to 20 °C, or a better known coefficient"
        ),
        words=Words(
            seen="the part is larger when warmer ({alpha})",
            causes="wrong expansion coefficient or part temperature",
            confirm="measure the part again after soaking",
            signed=("alpha",),
        ),
        belongs_to="part",
        on_cut_part="turned",
    )
    per = "part"
    needs = ("temp_part_C",)
    alpha: float = param(
        0.0,
        "um/(m K)",
        "expansion coefficient of the part",
        typical=Typical(
            8e-6,
            "steel 11.5, aluminium 23, plastics to 100; known to 10 % after correction",
            bounds=(-1e-4, 1e-4),
        ),
    )
    corrected: float = param(
        0.0, "um/(m K)", "coefficient used by the software's own correction, 0 = none", chosen=True
    )

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        x, y, z = run.part_point.T
        strain = _left_over(run, "part", self.alpha, self.corrected)
        return motion(run, X=strain * x, Y=strain * y, Z=strain * z)
