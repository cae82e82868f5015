"""Mean cutting forces of a move from its engagement.

Milling, linear edge force model (Budak, Altintas, Armarego, J. Manuf. Sci. Eng. 118 (1996) 216): each piece db of a cutting
edge carries dF_j = (K_jc h + K_je) db, j = tangential, radial, axial, h = c sin(phi). Averaged over a turn:

    Fx = N a / 2 pi  [ c/4 (Ktc cos 2phi - Krc (2phi - sin 2phi)) - Kte sin phi + Kre cos phi ]
    Fy = N a / 2 pi  [ c/4 (Ktc (2phi - sin 2phi) + Krc cos 2phi) - Kte cos phi - Kre sin phi ]
    Fz = N a / 2 pi  [ -Kac c cos phi + Kae phi ]        each from phi_start to phi_exit (Altintas, Manufacturing
                                                        Automation, 2nd ed. (2012), eq. 2.28)

x = feed of the tool, z = tool axis towards the spindle, y to the left of the feed; phi from +y, clockwise seen from the
spindle (M3): 0 left, pi/2 ahead, pi right. These are forces of the part on the tool. Climb milling has the material on the
right: phi from pi - acos(1 - ae/R) to pi. Turning: Kienzle, Fc = b kc1.1 h^(1 - mc). Milling of a material known by Kienzle's
numbers only goes by the tangent of that law at the mean chip of the engagement (`at_chip`).
"""

from __future__ import annotations

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.laws import Array
from vcmm.program.setup import Kienzle, LinearEdge

RADIAL = 0.3  # radial over tangential force of a milling edge
LEAST_CHIP = 1e-4  # mm, below which no tangent is taken: edges rub


def mean_chip(start: Array, exit_: Array, chip: Array) -> Array:
    """Return the mean thickness (mm) of the chips c sin(phi) from start to exit: c (cos start - cos exit) / (exit - start); 0 without a cut."""
    way = np.asarray(exit_, float) - np.asarray(start, float)
    full = np.cos(start) - np.cos(exit_)
    return np.asarray(chip * np.divide(full, way, out=np.zeros_like(way), where=way > 1e-9))


def at_chip(of: Kienzle, thickness: Array, radial: float = RADIAL) -> LinearEdge:
    """Return the linear edge model that has force and slope of Kienzle's law at chips of this thickness h (m,) mm.

    kc1.1 h^(1 - mc) ~ K_c h + K_e with K_c = (1 - mc) kc1.1 h^-mc, K_e = mc kc1.1 h^(1 - mc). The radial force is `radial` of
    the tangential one (0.3: Tlusty & MacNeil, Ann. CIRP 24 (1975) 21), the axial one is left out: the helix is not known.
    """
    h = np.maximum(np.asarray(thickness, float), LEAST_CHIP)
    cut, edge = (1.0 - of.mc) * of.kc11 * h**-of.mc, of.mc * of.kc11 * h ** (1.0 - of.mc)
    none = np.zeros_like(h)
    return LinearEdge(
        tangential=cut,
        radial=radial * cut,
        axial=none,
        edge_tangential=edge,
        edge_radial=radial * edge,
        edge_axial=none,
        source=of.source,
    )


def turning_force(width: Array, thickness: Array, of: Kienzle) -> Array:
    """Return the main cutting force (N) for chips of width b and thickness h (mm): b kc1.1 h^(1 - mc). Nothing without a chip."""
    b, h = np.asarray(width, float), np.asarray(thickness, float)
    return b * of.kc11 * np.maximum(h, 0.0) ** (1.0 - of.mc)


def immersion(radial: Array, radius: Array, climb: bool = True) -> tuple[Array, Array]:
    """Return the angles (rad) at which an edge enters and leaves, for a radial depth ae (mm) of a mill of the given radius."""
    ae, r = np.asarray(radial, float), np.asarray(radius, float)
    if np.any((ae < 0.0) | (ae > 2 * r)):
        raise UsageError("immersion: the radial depth must lie between 0 and the diameter of the tool")
    angle = np.arccos(1.0 - ae / r)
    return (np.pi - angle, np.full_like(angle, np.pi)) if climb else (np.zeros_like(angle), angle)


def milling_force(
    start: Array, exit_: Array, axial: Array, chip: Array, teeth: Array, of: LinearEdge
) -> Array:
    """Return the mean force (..., 3) N on the tool along feed, left of it, and tool axis.

    start, exit_: rad; axial: depth ap in mm; chip: feed per tooth in mm; teeth: number of cutting edges.
    """
    c = np.asarray(chip, float)
    begin, end = (edge_integral(np.asarray(phi, float), c, of) for phi in (start, exit_))
    per_turn = np.asarray(teeth, float) * np.asarray(axial, float) / (2.0 * np.pi)
    return np.asarray(per_turn)[..., None] * (end - begin)


def edge_integral(phi: Array, chip: Array, of: LinearEdge) -> Array:
    """Return the integral (..., 3) N rad/mm over phi of the force on a unit of edge (`edge_force`), up to a constant: the brackets above."""
    double, sine, cosine = np.cos(2 * phi), np.sin(phi), np.cos(phi)
    swept = 2 * phi - np.sin(2 * phi)
    fx = (
        chip / 4 * (of.tangential * double - of.radial * swept)
        - of.edge_tangential * sine
        + of.edge_radial * cosine
    )
    fy = (
        chip / 4 * (of.tangential * swept + of.radial * double)
        - of.edge_tangential * cosine
        - of.edge_radial * sine
    )
    fz = -of.axial * chip * cosine + of.edge_axial * phi
    return np.stack(np.broadcast_arrays(fx, fy, fz), axis=-1)


def edge_force(phi: Array, chip: Array, of: LinearEdge) -> Array:
    """Return the force (..., 3) N/mm of the part on a unit of an edge at phi: along feed, left of it, tool axis (Altintas, eq. 2.25)."""
    sine, cosine = np.sin(phi), np.cos(phi)
    tangential = of.tangential * chip * sine + of.edge_tangential
    radial = of.radial * chip * sine + of.edge_radial
    axial = of.axial * chip * sine + of.edge_axial
    fx, fy = -tangential * cosine - radial * sine, tangential * sine - radial * cosine
    return np.stack(np.broadcast_arrays(fx, fy, axial), axis=-1)


def milling_power(
    start: Array, exit_: Array, axial: Array, chip: Array, teeth: Array, speed: Array, of: LinearEdge
) -> Array:
    """Return the mean cutting power (...,) W: tangential forces of all edges times the cutting speed (m/s); the rest as in `milling_force`.

    N a / 2 pi  [ -Ktc c cos phi + Kte phi ] v     from phi_start to phi_exit (Altintas, Manufacturing Automation, 2nd ed. (2012), 2.8)
    """
    c, a, b = np.asarray(chip, float), np.asarray(start, float), np.asarray(exit_, float)
    tangential = of.tangential * c * (np.cos(a) - np.cos(b)) + of.edge_tangential * (b - a)
    per_turn = np.asarray(teeth, float) * np.asarray(axial, float) / (2.0 * np.pi)
    return np.asarray(per_turn * tangential * speed)


def to_workpiece(force: Array, feed: Array, axis: Array) -> Array:
    """Return the forces (m, 3) along feed, left, axis turned into the axes of the part: columns force_x_N, force_y_N, force_z_N.

    feed (m, 3) is the direction of the move; a plunge has none across the axis, its forces across it are dropped as they
    turn with the edges and cancel over a turn.
    """
    across = feed - np.einsum("mi,mi->m", feed, axis)[:, None] * axis
    length = np.linalg.norm(across, axis=1)
    x = across / np.where(length > 1e-12, length, 1.0)[:, None]
    y = np.cross(axis, x)
    return force[:, 0:1] * x + force[:, 1:2] * y + force[:, 2:3] * axis
