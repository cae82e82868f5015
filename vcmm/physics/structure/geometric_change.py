"""Geometric change: a component error is no longer what its table says, smoothly, because the calibration is stale."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legvander

from vcmm.core.axes import axis_of, is_component, is_rotary
from vcmm.core.declaration import UM, URAD, About, ForDiagnosis, Site, Typical, Words
from vcmm.core.effect import COLUMN, Effect, at, param, positions
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import FULL_TURN
from vcmm.core.run import Array, Run


def _geometric_change_make_at(
    cls: type[GeometricChange], place: Mapping[str, Any], site: Site
) -> GeometricChange:
    axis = axis_of(place["component"])
    q = site.run.q(axis)
    if is_rotary(axis) and float(np.ptp(q)) > FULL_TURN:
        raise UsageError("after a full turn an axis is where it was: its geometry repeats, see rotary_cyclic")
    return cls(place["component"], np.array([q.min(), q.max()]))


def _geometric_change_file_note(effect: GeometricChange) -> str:
    nodes, turn = np.asarray(effect.nodes, dtype=float), is_rotary(effect.link)
    low, high = (np.degrees(nodes) if turn else nodes)[[0, -1]]
    return f"recorded from {low:.1f} to {high:.1f} {'deg' if turn else 'mm'}; beyond these ends the value of the end is kept"


@dataclass(frozen=True, eq=False)
class GeometricChange(Effect):
    """c0 P0(s) + c1 P1(s) + c2 P2(s) ..., Legendre polynomials, s from -1 to +1 between the ends of the table.

    Added to the axis's own motion, as the table is: for an axis that carries the workpiece the table's own motion.
    Beyond the ends the value at the end is kept: a polynomial that was fitted between them says nothing about the rest and
    would grow with its highest power there, while a guide goes on smoothly. Over the travel the mean square is the sum of c_k^2 / (2 k + 1); `rms` is its root.
    """

    name = "geometric_change"
    diagnosis = ForDiagnosis(
        special_case_of=("map_interpolation",),
        shared_physics="geometry",
        holds_table_edits=True,
        is_free_curve=True,
        file_note=_geometric_change_file_note,
        make_at=_geometric_change_make_at,
    )
    per = "component"
    own = True
    about = About(
        cites="Schwenke et al., CIRP Annals 57 (2008) 660: component errors change with time, wear and foundation",
        words=Words(
            seen="{where} is no longer what the table says ({rms})",
            causes="wear, a collision, foundation, transport or a stale calibration",
            confirm="measure {where} again and replace its table",
        ),
    )
    component: str = at("EXX", "component error, for example EXX, EYX, EBX")
    nodes: Any = positions((0.0, 1.0))
    coefficients: Any = param(
        lambda: np.zeros(4),
        "mm or rad",
        "change per Legendre polynomial, from P0 on",
        shape="(powers,)",
        typical=Typical(1 * UM, "a fraction of the component itself: 1 um, 3 urad", 3 * URAD),
        lengths=(4, 8),
    )

    def __post_init__(self) -> None:
        c = self.component
        if not is_component(c):
            raise UsageError(f'component = "{c}" is not a component error; write for example "EXX" or "EBX"')
        nodes = np.asarray(self.nodes, dtype=float)
        if len(nodes) < 2 or not nodes[-1] > nodes[0]:
            raise UsageError(f"{self.id}: nodes must hold the two ends of the travel, the lower one first")

    @property
    def link(self) -> str:
        return axis_of(self.component)

    @property
    def rms(self) -> float:
        """Root mean square over the travel, mm or rad."""
        c = np.asarray(self.coefficients, dtype=float)
        return float(np.sqrt((c**2 / (2 * np.arange(len(c)) + 1)).sum()))

    def error_motion(self, run: Run) -> Array:
        nodes = np.asarray(self.nodes, dtype=float)
        q = np.minimum(np.maximum(run.q(self.link), nodes[0]), nodes[-1])
        s = (2 * q - nodes[0] - nodes[-1]) / (nodes[-1] - nodes[0])
        out = np.zeros((run.n, 6))
        c = np.asarray(self.coefficients, dtype=float)
        out[:, COLUMN[self.component[1]]] = legvander(s, len(c) - 1) @ c
        return out
