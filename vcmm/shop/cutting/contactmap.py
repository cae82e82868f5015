"""Contacts: the cuts that make each point of the surface, and its shift by small errors of the tool, without cutting again.

    ds = (N . e) / (N . n)      to first order; N: normal of the cutter where it touches the surface, out of the tool,
                                n: outward normal of the part, e: actual - commanded of that point of the tool

since the tool's boundary moves by N . e along N and meets the ray under the angle between N and n. A tilt, wear or runout is
an e at the contact as well (theta x arm, growth times N). With several contacts close to each other the lowest wins, which
is what changes place when a cusp between two passes moves. First order in e and in the gradient of the error; the rest is
about e^2 / 2R (0.04 um at 20 um and R 5 mm), and `audit` measures it. Sign: material left is plus. Sources: the envelope
condition N . v = 0, Altintas, Manufacturing Automation, 2nd ed. (2012), ch. 2 and 4; Soori et al., CAD 45 (2013) 1306.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError
from vcmm.core.laws import Array
from vcmm.shop.cutting.displacement import CHORD, Displacement, displace
from vcmm.shop.cutting.envelope import CUT, CutSurface, surface_left, tips
from vcmm.shop.cutting.standing_tool import entry
from vcmm.shop.cutting.sweeps import Sweep
from vcmm.shop.cutting.tools import Cutter

Ints = npt.NDArray[np.intp]
ASTRAY = 0.05  # mm: a ray that meets the moved tool further off has met another side of it
GRAZING = 1e-6  # |N . n| below which the ray ends in the side of a gouge: the tool moves that end as it moves itself


class MovedCutters(Protocol):
    """Interface of the cutters of the candidates, to be met by rays again when they are moved."""

    def entry(self, shift: Array, normal: Array) -> Array:
        """Return where the rays from P points along normal (P, 3) enter the cutters moved by shift (..., P, K, 3): (..., P, K) mm."""


@dataclass(frozen=True, eq=False)
class Solids:
    """The tools of the candidates: which (P, K) of `tools`, and arm (P, K, 3) mm from their tip to the point."""

    tools: tuple[Cutter, ...]
    which: Ints
    arm: Array

    def entry(self, shift: Array, normal: Array) -> Array:
        """Return where the rays from the points along normal (P, 3) enter the tools moved by shift (..., P, K, 3), (..., P, K)."""
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
    solids: MovedCutters | None = None

    def __post_init__(self) -> None:
        if (self.row[:, 0] < 0).any():
            raise ValueError("every point needs a cut; leave uncut points out")

    @property
    def gain(self) -> Array:
        """Change of the height per error of the tool (P, K, 3)."""
        along = np.einsum("pki,pi->pk", self.cutter, self.normal)
        safe = np.where(
            (self.row >= 0) & (along != 0.0), along, np.inf
        )  # a ray along the cutter is not moved by it
        return self.cutter / safe[:, :, None]

    def heights(self, moved: Array) -> Array:
        """Return the heights (..., P, K) under errors (..., rows, 3) of the tool; inf where there is no candidate.

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
        """Return the surface (..., P): the lowest of the candidates."""
        return np.asarray(self.heights(moved).min(axis=-1))

    def deepest(self, moved: Array) -> tuple[Ints, Array]:
        """Return the row (P,) and gain (P, 3) of the candidate that makes each point under errors (rows, 3)."""
        k = self.heights(moved).argmin(axis=-1)
        points = np.arange(len(k))
        return self.row[points, k], self.gain[points, k]


def contact_map(surface: CutSurface, sweep: Sweep) -> Contacts:
    """Return the contacts of a cut surface, its candidates numbered row by row; `sweep` is the one it was cut with.

    Errors come in that order: those at tips(surface, sweep)[surface.row >= 0]. Raises UsageError where points are uncut.
    """
    is_cut = surface.row >= 0
    if not is_cut[:, 0].all():
        raise UsageError(
            f"contact_map: {np.sum(~is_cut[:, 0])} points were not cut; take(surface.status == CUT) leaves them out"
        )
    row = np.full(is_cut.shape, -1, dtype=np.intp)
    row[is_cut] = np.arange(is_cut.sum())
    height = np.where(is_cut, surface.contact_s, np.inf)
    return Contacts(height, upright(surface.normal, surface.normals, is_cut), surface.normals, row)


def upright(cutter: Array, normal: Array, is_cut: Array) -> Array:
    """Return the normals of the cutter (P, K, 3); n itself where there is no candidate, or the ray grazes the tool."""
    along = np.einsum("pki,pi->pk", cutter, normal)
    good = is_cut & (np.abs(np.where(is_cut, along, 0.0)) >= GRAZING)
    return np.where(good[:, :, None], cutter, normal[:, None, :])


@dataclass(frozen=True, eq=False)
class ContactAudit:
    """Contacts against cutting again with the displaced tool."""

    largest: float  # mm
    rms: float  # mm
    single: float  # mm, largest difference had only the one contact of the nominal pass been kept
    amplitude: float  # mm, largest displacement
    points: int  # points cut both times


def audit(
    surface: CutSurface,
    sweep: Sweep,
    field: Displacement,
    tolerance: float = CHORD,
    depth: float = 0.5,
    height: float = 2.0,
) -> ContactAudit:
    """Return the largest and rms difference between contacts and an exact new query with the tool displaced by `field`."""
    part = surface.take(np.flatnonzero(surface.status == CUT))
    is_cut = part.row >= 0
    contacts, moved = contact_map(part, sweep), np.zeros((0, 3))
    if is_cut.any():
        moved = field(tips(part, sweep)[is_cut], part.row[is_cut], part.t[is_cut])
    again = surface_left(part.points, part.normals, displace(sweep, field, tolerance), depth, height)
    both = again.status == CUT
    if not both.any():
        raise UsageError("audit: no point was cut both by the nominal and by the displaced tool")
    single = contacts.height[:, 0] + np.einsum("pi,pi->p", moved[contacts.row[:, 0]], contacts.gain[:, 0])
    off = (contacts.surface(moved) - again.s)[both]
    return ContactAudit(
        float(np.abs(off).max()),
        float(np.sqrt(np.mean(off**2))),
        float(np.abs(single - again.s)[both].max()),
        float(np.linalg.norm(moved, axis=1).max()),
        int(both.sum()),
    )
