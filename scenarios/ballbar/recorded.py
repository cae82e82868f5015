"""A ball bar on a machining centre with worn screws: two circles of 150 mm, what `vcmm new ballbar` copies.

Made without the effects of the catalogue, from three sentences: the table stands out of square, both screws have play, and the bar
reads with noise. Signs: error = actual - commanded of the tip; the bar reads the part along itself, outwards.
"""

from __future__ import annotations

import numpy as np

from vcmm import Array

RADIUS, POINTS, CENTRE = 150.0, 180, (300.0, 250.0, -200.0)  # mm, readings a circle, where the cup stands
SQUARE = 24e-6  # rad: the angle between X and Y is larger than a right one by this
PLAY = {"X": 3e-3, "Y": 7e-3}  # mm: way lost at a reversal
U, SEED = 0.3e-3, 4  # mm
RUN_IN = 30.0  # degrees before and behind a circle, as a ball bar is driven: the play is taken up when readings begin


def readings() -> tuple[Array, Array, Array]:
    """In order, counterclockwise, then clockwise: places (n, 2) mm, senses of motion (n, 2), lengths minus 150 mm (n,) mm."""
    step = 360.0 / POINTS
    forth = np.radians(np.arange(-RUN_IN, 360.0 + RUN_IN + step / 2, step))
    angle = np.concatenate([forth, forth[::-1]])
    place = RADIUS * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    way = np.sign(np.diff(place, axis=0, prepend=place[:1] - [[0.0, 1.0]]))
    error = np.stack([-SQUARE * place[:, 1], np.zeros(len(place))], axis=1)
    sense = np.stack([_carried(way[:, 0]), _carried(way[:, 1])], axis=1)
    error -= 0.5 * sense * np.array([PLAY["X"], PLAY["Y"]])
    outwards = place / RADIUS
    noise = U * np.random.default_rng(SEED).standard_normal(len(place))
    return place, sense, (error * outwards).sum(axis=1) + noise


def _carried(way: Array) -> Array:
    """A drive that rests keeps the sense of its last motion."""
    out = way.copy()
    for i in range(1, len(out)):
        out[i] = out[i] or out[i - 1]
    return out


def texts() -> dict[str, str]:
    """Name -> text of the files beside scenarios/ballbar.toml."""
    x, y, z = CENTRE
    rows = [
        f"{x + a:.4f},{y + b:.4f},{z:g},{x:g},{y:g},{z:g},{p:.0f},{q:.0f},{1e3 * d:.3f}"
        for (a, b), (p, q), d in zip(*readings())
    ]
    head = "X_mm,Y_mm,Z_mm,from_x_mm,from_y_mm,from_z_mm,sense_X,sense_Y,d_um"
    return {"circles.csv": "\n".join([head, *rows]) + "\n"}
