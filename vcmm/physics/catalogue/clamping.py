"""Clamping: the part is bent by the way it is held."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.legendre import legval

from vcmm.core.declaration import UM, About, ForDiagnosis, Prior, Site, Trade, Typical, Words
from vcmm.core.effect import Effect, along, at, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run

DEGREES = ((2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3))
ACROSS = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}


def _clamping_make_at(cls: type[Clamping], place: Mapping[str, Any], site: Site) -> Clamping:
    return cls(**place, length=max(float(np.abs(site.run.part_point).max()), 1.0))


@dataclass(frozen=True, eq=False)
class Clamping(Effect):
    """Sum of c_j P_a(s) P_b(t) in one direction: a bent surface over the other two coordinates s, t of the part.

    Legendre polynomials, (a, b) = (2 0) (1 1) (0 2) and, with 7 coefficients, (3 0) (2 1) (1 2) (0 3); s and t are -1
    and +1 at `length` from the part's origin. Shift and tilt are the part's pose, not clamping. Each clamping has its
    own numbers: an Input with redraw = "clamp". A surface that bulges towards +direction is indicated there.
    """

    name = "clamping"
    about = About(
        cites="Timoshenko & Woinowsky-Krieger, Theory of Plates and Shells (1959): bending of a plate",
        trade=Trade("clamping of the part", "clamp with less force, nearer to the supports"),
        words=Words(
            seen="the part is bent by its clamping ({rms})",
            causes="clamps or supports force it",
            confirm="measure the part free and clamped",
        ),
        belongs_to="part",
        on_cut_part="turned",
    )
    per = "direction, clamp"
    diagnosis = ForDiagnosis(
        prior=Prior(rare_without="clamp"),
        make_at=_clamping_make_at,
    )
    direction: str = at("z", "x, y or z: where the part is bent")
    coefficients: Any = param(
        lambda: np.zeros(3),
        "um",
        "3 of second order, or 7 with third order",
        shape="(powers,)",
        typical=Typical(5 * UM, "usual: 1-20 um on parts that yield"),
        lengths=(3, 7),
    )
    length: float = 100.0

    def __post_init__(self) -> None:
        if self.direction not in ACROSS:
            raise UsageError(f'clamping: direction = "{self.direction}" must be "x", "y" or "z"')
        if len(self.coefficients) not in (3, 7) or not self.length > 0:
            raise UsageError(
                f"{self.id}: give 3 or 7 coefficients and a positive length (half the part's size)"
            )

    @property
    def link(self) -> str:
        return "reading"

    @property
    def rms(self) -> float:
        """Root mean square over the square of side 2 length, mm."""
        size = [1 / ((2 * a + 1) * (2 * b + 1)) for a, b in DEGREES[: len(self.coefficients)]]
        return float(np.sqrt(np.asarray(self.coefficients, dtype=float) ** 2 @ size))

    def error_motion(self, run: Run) -> Array:
        s, t = (run.part_point[:, i] / self.length for i in ACROSS[self.direction])
        unit = np.eye(4)
        terms = [legval(s, unit[a]) * legval(t, unit[b]) for a, b in DEGREES[: len(self.coefficients)]]
        bulge = np.stack(terms, axis=1) @ np.asarray(self.coefficients, dtype=float)
        return along(run, np.eye(3)["xyz".index(self.direction)], bulge)
