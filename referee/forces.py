"""The force of the chips on a mill: what of the blank stands before it, and the mean over a turn.

A tooth at the angle whose outward direction is e cuts a chip h = f e.d thick, d the way of the feed. On the tool act a cutting force against the way of
the tooth, t = (e_y, -e_x) of a spindle that turns clockwise (M3), and a radial force that pushes it out of the material:

    dF = -(kc1 h^(1 - mc)) (t + RADIAL e) db        for each slice db of the depth and each place on the front half where material stands

summed over the teeth and averaged over a turn. Sources: Kienzle, VDI-Z 94 (1952) 299 (h^(1 - mc)); kc1 = 2100 N/mm^2, mc = 0.26 of 16MnCr5 and a radial
share of 0.35: Tschaetsch, Praxis der Zerspantechnik. Floors: the mill is stiff along its axis.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from referee.cutter import Cutter, Moment

Array = NDArray[np.float64]
KC1, MC, RADIAL = 2100.0, 0.26, 0.35
ANGLES, SLICE = 90, 1.0  # places on the front half; mm of depth
THIN = 5.0  # degrees of a circle between chords that are looked at: its sagitta at 10 mm is 0.01 mm
INSIDE = 0.02  # mm: so deep in the material a place must lie


@dataclass
class Blank:
    """A box with its top at Z0 and its middle at X0 Y0, mm."""

    x: float
    y: float
    z: float


def forces(cutter: Cutter, blank: Blank, teeth: dict[int, int], moments: Moment) -> Array:
    """Mean force of the part on the tool (n, 3) N in the workpiece system at each moment."""
    p = cutter.path
    sweeps = _few_chords(cutter)
    start, end, began = p.start[sweeps], p.end[sweeps], p.began[sweeps]
    radii = np.array([cutter.radius[int(t)] if t else 0.0 for t in p.tool[sweeps]])
    low = np.minimum(start[:, 2], end[:, 2])
    out = np.zeros((len(moments.time), 3))
    for i in range(len(out)):
        pace = float(np.linalg.norm(moments.velocity[i, :2]))
        if not pace:
            continue
        number = int(moments.tool[i])
        radius, d = cutter.radius[number], moments.velocity[i, :2] / pace
        turn = np.radians(-90 + 180 / ANGLES * (np.arange(ANGLES) + 0.5))
        e = np.outer(np.cos(turn), d) + np.outer(np.sin(turn), (-d[1], d[0]))
        places = moments.q[i, :2] + (radius - INSIDE) * e
        stands = (np.abs(places[:, 0]) < blank.x / 2) & (np.abs(places[:, 1]) < blank.y / 2)
        before = began < moments.time[i] - 0.05 * radius / pace  # the last stretch is the one that cuts
        before &= p.block[sweeps] != moments.block[i]
        away = _distance(places[stands], start[before, :2], end[before, :2]) < radii[before]
        b = np.zeros(ANGLES)
        for z in np.arange(moments.q[i, 2] + SLICE / 2, 0.0, SLICE):
            b[stands] += SLICE * ~(away & (low[before] < z)).any(axis=1)
        chip = moments.feed[i] / moments.speed[i] / teeth[number] * np.cos(turn)
        t = np.column_stack([e[:, 1], -e[:, 0]])
        each = -(KC1 * b * np.maximum(chip, 0.0) ** (1 - MC))[:, None] * (t + RADIAL * e)
        out[i, :2] = teeth[number] / (2 * np.pi) * each.sum(axis=0) * np.pi / ANGLES
    return out


def _few_chords(cutter: Cutter) -> NDArray[np.intp]:
    """Rows of the path that cut, of circles every chord at which it has turned by `THIN`."""
    p = cutter.path
    every = round(THIN / 0.1)
    count = np.bincount(p.block, minlength=int(p.block.max()) + 1)
    nth = np.arange(len(p.block)) - np.searchsorted(p.block, p.block)
    long = count[p.block] > every
    return np.flatnonzero((p.feed > 0) & (~long | (nth % every == 0)))


def _distance(points: Array, start: Array, end: Array) -> Array:
    """Distance (n, m) of points from stretches, in the plane."""
    step = end - start
    share = np.einsum("nmk,mk->nm", points[:, None] - start, step) / np.maximum((step**2).sum(axis=1), 1e-12)
    at = start + np.clip(share, 0, 1)[..., None] * step
    return np.asarray(np.linalg.norm(points[:, None] - at, axis=2))
