"""Contacts: which cut made each inspection point, and how an error of the tool there moves the surface.

    ds = (N . e) / (N . n)      N: normal of the cutter where it touches the surface, n: outward normal of the part,
                                e: actual - commanded of that point of the tool while it passes

K candidates are kept for each point: under another error another cut may be the deepest. Sign: material left is plus.
Altintas, Manufacturing Automation (2012), ch. 4 (surface location error); Soori et al., CAD 45 (2013) 1306.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.run import Array

Ints = npt.NDArray[np.intp]


@dataclass(frozen=True, eq=False)
class Contacts:
    """P points, K candidates each; workpiece axes, mm.

    height (P, K): surface above nominal along n if this candidate cut alone; cutter (P, K, 3): unit normal N;
    normal (P, 3): n; row (P, K): row of the run in which this candidate is cut, -1 where there is none.
    """

    height: Array
    cutter: Array
    normal: Array
    row: Ints

    def __post_init__(self) -> None:
        if (self.row[:, 0] < 0).any():
            raise ValueError("every point needs a cut; leave uncut points out")

    @property
    def gain(self) -> Array:
        """(P, K, 3): change of the height per error of the tool."""
        along = np.einsum("pki,pi->pk", self.cutter, self.normal)
        safe = np.where(self.row >= 0, along, 1.0)
        return self.cutter / safe[:, :, None]

    def heights(self, moved: Array) -> Array:
        """(..., P, K) under errors (..., rows, 3) of the tool; inf where there is no candidate."""
        found = np.einsum("...pki,pki->...pk", moved[..., np.maximum(self.row, 0), :], self.gain)
        return np.where(self.row >= 0, self.height + found, np.inf)

    def surface(self, moved: Array) -> Array:
        """(..., P): the lowest of the candidates, which is what remains."""
        return np.asarray(self.heights(moved).min(axis=-1))

    def deepest(self, moved: Array) -> tuple[Ints, Array]:
        """Row (P,) and gain (P, 3) of the candidate that makes each point under errors (rows, 3)."""
        k = self.heights(moved).argmin(axis=-1)
        points = np.arange(len(k))
        return self.row[points, k], self.gain[points, k]
