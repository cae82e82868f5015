"""Contact map: how the cut surface answers to small errors of the tool, without cutting again.

A displacement e of the tool at the moment of contact moves the cut surface along the nominal normal n by

    ds = (N . e) / (N . n)        N = normal of the tool at the contact, out of the tool

since the tool's boundary moves by N . e along N and meets the ray under the angle between N and n. A small turn theta of
the tool (rad, about its tip) displaces the contact by theta x r, r from the tip to the contact. A tool larger by dr cuts
deeper by dr / (N . n). With several contacts close to each other the lowest wins: the deviation is the minimum over the K
candidates, which is what changes place when a cusp between two passes moves. First order in e and in the gradient of the
error; the rest is about e^2 / 2R (0.04 um at 20 um and R 5 mm), and `audit` measures it. Source of the projection:
the envelope condition N . v = 0, e.g. Altintas, Manufacturing Automation, 2nd ed. (2012), ch. 2 for milled surfaces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.cutting.displaced import CHORD, Field, displaced
from vcmm.cutting.envelope import CUT, CutSurface, surface_left, tips
from vcmm.cutting.sweeps import Sweep
from vcmm.errors import UsageError
from vcmm.laws import Array

GRAZING = 1e-3  # |N . n| below which a contact is so oblique that first order means little


@dataclass(frozen=True, eq=False)
class ContactMap:
    """Candidates of P points, K each; void candidates have s = inf and gain 0. `cut` tells which points have a surface."""

    s: Array  # (P, K) mm
    gain: Array  # (P, K, 3) N / (N . n)
    arm: Array  # (P, K, 3) mm, from the tip to the contact
    across: Array  # (P, K) share of N square to the tool axis, over N . n
    row: Array  # (P, K), -1 = void
    t: Array  # (P, K)
    tip: Array  # (P, K, 3) position of the tip at the contact, nan = void
    cut: Array  # (P,) bool
    grazing: Array  # (P,) bool, any candidate that meets the ray at less than GRAZING

    def apply(
        self,
        displacement: Array,
        tilt: Array | None = None,
        radius: Array | float = 0.0,
        growth: Array | float = 0.0,
    ) -> Array:
        """Deviation (T, P) mm for displacements (T, P, K, 3) mm at the contacts; nan where the point was not cut.

        tilt (T, P, K, 3) rad about the tip; radius (mm, shape (T, P, K) or less): the cutting edges run that much
        further out square to the axis (runout); growth (mm): the edge grows along its own normal (wear is negative).
        """
        e = np.asarray(displacement, float)
        if e.ndim != 4 or e.shape[1:] != self.gain.shape:
            raise UsageError(
                f"ContactMap.apply: displacement must have the shape (T, {self.gain.shape}), not {e.shape}"
            )
        void = self.row < 0
        if not np.isfinite(e[:, ~void]).all():
            raise UsageError("ContactMap.apply: the displacement is not finite at some contact")
        ds = np.einsum("tpki,pki->tpk", np.where(void[..., None], 0.0, e), self.gain)
        if tilt is not None:
            # gain . (theta x r) = theta . (r x gain)
            turned = np.cross(self.arm, self.gain)
            ds += np.einsum("tpki,pki->tpk", np.where(void[..., None], 0.0, tilt), turned)
        ds = ds + np.asarray(radius, float) * self.across + np.asarray(growth, float) * self._per_growth()
        lowest = np.min(self.s + ds, axis=-1)
        return np.where(self.cut, lowest, np.nan)

    def _per_growth(self) -> Array:
        """1 / (N . n) (P, K): gain is N / (N . n) and N a unit vector, N . n < 0."""
        return -np.linalg.norm(self.gain, axis=-1)


def contact_map(surface: CutSurface, sweep: Sweep) -> ContactMap:
    """The map of a cut surface. `sweep` is the one it was cut with."""
    void = surface.row < 0
    slant = np.einsum("pki,pi->pk", surface.normal, surface.normals)
    axis = sweep.axis[np.where(void, 0, surface.row)]
    radial = np.linalg.norm(np.cross(surface.normal, axis), axis=-1)
    tip = tips(surface, sweep)
    contact = surface.points[:, None] + surface.contact_s[..., None] * surface.normals[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        gain, across = surface.normal / slant[..., None], radial / slant
    return ContactMap(
        np.where(void, np.inf, surface.contact_s),
        np.where(void[..., None], 0.0, gain),
        np.where(void[..., None], 0.0, contact - tip),
        np.where(void, 0.0, across),
        surface.row,
        surface.t,
        tip,
        surface.status == CUT,
        np.any(~void & (np.abs(slant) < GRAZING), axis=1),
    )


@dataclass(frozen=True, eq=False)
class Audit:
    """Contact map against cutting again with the displaced tool."""

    largest: float  # mm
    rms: float  # mm
    single: float  # mm, largest difference had only the one contact of the nominal pass been kept
    amplitude: float  # mm, largest displacement
    compared: int  # points cut both times


def audit(
    surface: CutSurface,
    sweep: Sweep,
    field: Field,
    tolerance: float = CHORD,
    depth: float = 0.5,
    height: float = 2.0,
) -> Audit:
    """Largest and rms difference between the map and an exact new query with the tool displaced by `field`."""
    contacts = contact_map(surface, sweep)
    known = contacts.row >= 0
    e = np.zeros_like(contacts.gain)
    e[known] = field(contacts.tip[known], contacts.row[known], contacts.t[known])
    quick = contacts.apply(e[None])[0]
    one = contacts.s[:, 0] + np.einsum("pi,pi->p", e[:, 0], contacts.gain[:, 0])
    again = surface_left(surface.points, surface.normals, displaced(sweep, field, tolerance), depth, height)
    both = contacts.cut & (again.status == CUT)
    if not both.any():
        raise UsageError("audit: no point was cut both by the nominal and by the displaced tool")
    off = (quick - again.s)[both]
    return Audit(
        float(np.abs(off).max()),
        float(np.sqrt(np.mean(off**2))),
        float(np.abs(one - again.s)[both].max()),
        float(np.linalg.norm(e[known], axis=1).max()),
        int(both.sum()),
    )
