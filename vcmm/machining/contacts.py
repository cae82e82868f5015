"""Contacts: which cut made each inspection point, and how an error of the tool there moves the surface.

    ds = (N . e) / (N . n)      to first order; N: normal of the cutter where it touches the surface, n: outward normal of the part,
                                e: actual - commanded of that point of the tool while it passes

K candidates are kept for each point: under another error another cut may be the deepest. Sign: material left is plus.
Altintas, Manufacturing Automation (2012), ch. 4 (surface location error); Soori et al., CAD 45 (2013) 1306.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.cutting.standing import entry
from vcmm.cutting.tools import Tool
from vcmm.run import Array

Ints = npt.NDArray[np.intp]
ASTRAY = 0.05  # mm: a ray that meets the moved tool further off has met another side of it


@dataclass(frozen=True, eq=False)
class Solids:
    """The tools of the candidates: which (P, K) of `tools`, and arm (P, K, 3) mm from their tip to the point."""

    tools: tuple[Tool, ...]
    which: Ints
    arm: Array

    def entry(self, shift: Array, normal: Array) -> Array:
        """Where the rays from the points along normal (P, 3) enter the tools moved by shift (..., P, K, 3), (..., P, K)."""
        out = np.full(shift.shape[:-1], np.inf)
        rays = np.broadcast_to(normal[:, None, :], shift.shape)
        for number, tool in enumerate(self.tools):
            mine = np.broadcast_to(self.which == number, out.shape)
            if mine.any():
                out[mine] = entry(tool, (self.arm - shift)[mine], rays[mine])
        return out


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
    solids: Solids | None = None

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
        """(..., P, K) under errors (..., rows, 3) of the tool; inf where there is no candidate.

        With the solids of the tools the ray meets the moved tool itself, so that a hole drilled beside its place keeps its
        size; where it misses the moved tool, and without solids, the surface moves by the gain.
        """
        shift = moved[..., np.maximum(self.row, 0), :]
        linear = self.height + np.einsum("...pki,pki->...pk", shift, self.gain)
        if self.solids is not None:
            exact = self.solids.entry(shift, self.normal)
            both = np.isfinite(exact) & np.isfinite(linear)
            near = both & (np.abs(np.where(both, exact, 0.0) - np.where(both, linear, 0.0)) < ASTRAY)
            first = np.arange(self.row.shape[1]) == 0
            linear = np.where(near, exact, np.where(first, linear, np.inf))
        return np.where(self.row >= 0, linear, np.inf)

    def surface(self, moved: Array) -> Array:
        """(..., P): the lowest of the candidates, which is what remains."""
        return np.asarray(self.heights(moved).min(axis=-1))

    def deepest(self, moved: Array) -> tuple[Ints, Array]:
        """Row (P,) and gain (P, 3) of the candidate that makes each point under errors (rows, 3)."""
        k = self.heights(moved).argmin(axis=-1)
        points = np.arange(len(k))
        return self.row[points, k], self.gain[points, k]
