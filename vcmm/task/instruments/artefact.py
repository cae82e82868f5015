"""Artefacts: ball and hole plates, ball bars as length standards, step gauges, measured by touching.

ball plate         x y z of every ball, the plate lying anywhere     nuisance rigid; own errors: scale, balls
hole plate         the two directions of the plate of every hole     nuisance rigid; own errors: scale, balls
step gauge         places of faces along one line, the gauge lying anywhere (zero, and its direction by the rows)
ball bar artefact  length between two balls, both touched            own errors: length (the same in every place), scale
sphere             touches along the normal, the sphere anywhere     nuisance rigid; own error: diameter
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.task.instruments.instrument import (
    SCALE,
    Instrument,
    OwnError,
    constant,
    half_along_normal,
    of_features,
)
from vcmm.task.instruments.laying import layout, rows
from vcmm.task.response.recording import Recording

BALLS = OwnError(
    "balls", "um", of_features, "u of the calibrated place of one ball, each direction", is_permanent=False
)
BALL_PLATE = Instrument(
    "ball plate", "probe", (SCALE, BALLS), ("rigid",), "ISO 10360-2:2009, annex B; VDI/VDE 2617-5"
)
STEP_GAUGE = Instrument(
    "step gauge", "displacement", (SCALE,), ("zero",), "ISO 10360-2:2009, annex B", ("length",)
)


HOLE_PLATE = Instrument(
    "hole plate", "probe", (SCALE, BALLS), ("rigid",), "VDI/VDE 2617-5; ISO 10360-2:2009, annex B"
)
BAR_LENGTH = OwnError("length", "um", constant, "u of the calibrated length between its balls")
BAR = Instrument(
    "ball bar artefact",
    "length",
    (BAR_LENGTH, SCALE),
    (),
    "ASME B89.4.10360.2-2008, annex; ISO 10360-2:2009, annex B",
)
DIAMETER = OwnError("diameter", "um", half_along_normal, "u of its calibrated diameter")
SPHERE = Instrument("sphere", "probe", (DIAMETER,), ("rigid",), "ISO 10360-5:2020, 6.2")


def plate(
    machine: Machine,
    centres: Array,
    pose: str,
    offset: Sequence[float],
    u: float,
    features: Sequence[str] | None = None,
    axes: str = "XYZ",
) -> Recording:
    """Lay out x, y and z of balls at centres (n, 3) mm, workpiece axes; pose: label of this placement; u mm per coordinate.

    axes: the directions that are read, "XY" of a hole plate that lies flat.
    """
    tips = np.asarray(centres, dtype=float) - np.asarray(offset, dtype=float)
    position = {
        a: tips[:, "XYZ".index(a)] if a in "XYZ" else np.zeros(len(tips)) for a in machine.chain.letters
    }
    names = features or [f"ball {i + 1}" for i in range(len(tips))]
    run = rows(position, np.asarray(offset), {"pose": [pose] * len(tips), "feature": names})
    recording = layout(f"plate {pose}", "probe", run, np.eye(3)[0], {"rigid": "pose"}, u)
    plain = {k: v for k, v in recording.run.columns.items() if k not in ("nx", "ny", "nz")}
    n, directions = run.n, np.eye(3)[["XYZ".index(a) for a in sorted(axes)]]
    m = n * len(directions)
    return replace(
        recording,
        run=replace(recording.run, columns=plain),
        value=np.zeros(m),
        row=np.repeat(np.arange(n), len(directions)),
        direction=np.tile(directions, (n, 1)),
        other=np.full(m, -1, dtype=np.intp),
    )


def bar(
    machine: Machine,
    places: Sequence[tuple[Sequence[float], Sequence[float]]],
    u: float,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
) -> Recording:
    """Lay out the lengths of a ball bar in several places: (first ball, second ball), each (3,) mm, workpiece axes; u mm of one length."""
    ends = np.array([[p[1] for p in places], [p[0] for p in places]], dtype=float)
    n = len(places)
    tips = ends.reshape(2 * n, 3) - np.asarray(offset, dtype=float)
    position = {a: tips[:, "XYZ".index(a)] if a in "XYZ" else np.zeros(2 * n) for a in machine.chain.letters}
    run = rows(position, np.asarray(offset, dtype=float))
    run = run.with_columns({f"from_{c}_mm": np.tile(ends[1][:, i], 2) for i, c in enumerate("xyz")})
    way = ends[0] - ends[1]
    length = np.linalg.norm(way, axis=1)
    run = run.with_columns({"length_mm": np.tile(length, 2)})
    recording = layout("ball bar", "length", run, np.eye(3)[0], {}, u)
    return replace(
        recording,
        value=np.zeros(n),
        row=np.arange(n),
        direction=way / length[:, None],
        other=n + np.arange(n),
    )


def sphere(
    machine: Machine,
    centre: Sequence[float],
    diameter: float,
    normals: Array,
    u: float,
    offset: Sequence[float] = (0.0, 0.0, 0.0),
) -> Recording:
    """Lay out touches of a sphere along normals (n, 3), unit; u mm per touch."""
    tips = np.asarray(centre, dtype=float) + diameter / 2 * normals - np.asarray(offset, dtype=float)
    position = {
        a: tips[:, "XYZ".index(a)] if a in "XYZ" else np.zeros(len(tips)) for a in machine.chain.letters
    }
    return layout(
        "sphere", "probe", rows(position, np.asarray(offset, dtype=float)), normals, {"rigid": ""}, u
    )


def grid_of_balls(
    corner: Sequence[float], along: Sequence[float], across: Sequence[float], n: tuple[int, int] = (5, 5)
) -> Array:
    """Return the balls of a plate (n0 n1, 3) mm, from a corner along two edges (their lengths are the size of the plate)."""
    a, b = np.meshgrid(np.linspace(0, 1, n[0]), np.linspace(0, 1, n[1]), indexing="ij")
    edge = [np.asarray(v, dtype=float) for v in (along, across)]
    return np.asarray(corner, dtype=float) + a.ravel()[:, None] * edge[0] + b.ravel()[:, None] * edge[1]
