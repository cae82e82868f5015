"""Reversal that changes along the travel as no straight line does: a worn middle, stiff ends, a belt and its pulleys."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander

from vcmm.core.declaration import PLAY, UM, About, ForDiagnosis, Prior, Site, Typical
from vcmm.core.effect import Effect, at, motion, param, positions
from vcmm.core.errors import UsageError
from vcmm.core.play import share_taken_up
from vcmm.core.run import Array, Run


def _lost_motion_curve_make_at(
    cls: type[LostMotionCurve], place: Mapping[str, Any], site: Site
) -> LostMotionCurve:
    """Return the curve over the recorded travel, if rows lie at four places at least; otherwise a straight line explains as much."""
    q = site.run.q(place["axis"])
    if len(np.unique(np.round(q, 6))) < 4:
        raise UsageError("a curve over the travel needs four places")
    return cls(**place, nodes=np.array([q.min(), q.max()]))


@dataclass(frozen=True, eq=False)
class LostMotionCurve(Effect):
    """-1/2 (g0 + g1 q_a + c2 P2(s) + c3 P3(s) ...) d_a e_a, Legendre polynomials, s from -1 to +1 between the nodes.

    The second shape of lost_motion, and reported as such: the gap at a place may have either sign there (at the places
    of a negative gap the axis runs ahead after a reversal).
    """

    name = "lost_motion_curve"
    diagnosis = ForDiagnosis(
        family="lost_motion",
        # a shape that is rarer than the other shape of its family
        prior=Prior(share=0.1),
        shared_physics="play",
        make_at=_lost_motion_curve_make_at,
    )
    per = "axis"
    about = About(
        cites="ISO 230-2:2014, 2.16 and figure 1: reversal error at each position, which the standard tabulates",
        along_axis=True,
    )
    needs = ("sense_{axis}",)
    axis: str = at("X", "linear or rotary axis")
    nodes: Any = positions((0.0, 1.0))
    g0: float = param(
        0.0, "um", "lost motion at zero, of the straight part", typical=Typical(1 * UM, "as backlash", PLAY)
    )
    g1: float = param(
        0.0,
        "um/m",
        "lost motion per travelled length, of the straight part",
        typical=Typical(4e-6, "as lost_motion", most=2e-3),
    )
    curve: Any = param(
        lambda: np.zeros(1),
        "mm",
        "lost motion per Legendre polynomial, from P2 on",
        shape="(powers,)",
        typical=Typical(1 * UM, "as backlash: what wear makes of it along the travel", PLAY),
        lengths=(1, 3),
    )

    def __post_init__(self) -> None:
        nodes = np.asarray(self.nodes, dtype=float)
        if len(nodes) < 2 or not nodes[-1] > nodes[0]:
            raise UsageError(f"{self.id}: nodes must hold the two ends of the travel, the lower one first")

    @property
    def link(self) -> str:
        return self.axis

    def gap(self, q: Array) -> Array:
        """Return the lost motion (n,) mm at positions q."""
        nodes, c = np.asarray(self.nodes, dtype=float), np.asarray(self.curve, dtype=float)
        s = (2 * q - nodes[0] - nodes[-1]) / (nodes[-1] - nodes[0])
        return np.asarray(self.g0 + self.g1 * q + legvander(s, len(c) + 1)[:, 2:] @ c)

    def error_motion(self, run: Run) -> Array:
        gap = self.gap(run.q(self.axis))
        return motion(run, **{self.axis: -0.5 * gap * share_taken_up(run, self.axis)})
