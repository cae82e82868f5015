"""A machine's volume for a window: slices through the map of its tip errors, or its hull bent by them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.show.pages.field import magnification_of
from vcmm.show.report.blocks import Lines, SceneBox, SceneMesh
from vcmm.task.response.volumetric import field, linear_axes

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.core.run import Array

NODES = 31  # per axis: 29,791 positions
UNIT = "tip error / µm"


def volume_slices(machine: Machine) -> list[SceneMesh | SceneBox]:
    """Return the size of the tip error on three planes through the middle of the travels, and their box."""
    places, errors = _grid(machine)
    middle = NODES // 2
    sheets = [(np.take(places, middle, axis=i), np.take(errors, middle, axis=i)) for i in range(3)]
    vertices, faces, values = _join_sheets([(p, np.linalg.norm(e, axis=-1)) for p, e in sheets])
    mesh = SceneMesh(vertices, faces, values=1e3 * values, unit=UNIT, edges=False, name="slices")
    return [SceneBox(places[0, 0, 0], places[-1, -1, -1], "#7a8793", 0.0, name="travels"), mesh]


def volume_hull(machine: Machine) -> list[SceneMesh | Lines | SceneBox]:
    """Return the six sides of the travels, bent by the tip errors, magnified as the name of the item says."""
    places, errors = _grid(machine)
    factor = magnification_of(places.reshape(-1, 3), errors.reshape(-1, 3))
    bent = places + factor * errors
    size = np.linalg.norm(errors, axis=-1)
    sides = [(np.take(bent, end, axis=i), np.take(size, end, axis=i)) for i in range(3) for end in (0, -1)]
    vertices, faces, values = _join_sheets(sides)
    name = f"bent, {factor:,.0f} ×"
    mesh = SceneMesh(vertices, faces, values=1e3 * values, unit=UNIT, edges=False, name=name)
    return [SceneBox(places[0, 0, 0], places[-1, -1, -1], "#7a8793", 0.0, name="nominal"), mesh]


def _grid(machine: Machine) -> tuple[Array, Array]:
    """Return positions and tip errors (NODES, NODES, NODES, 3), mm. UsageError: no three linear axes, errors
    known in a part of the travels only, or none at all."""
    axes = linear_axes(machine)
    error_map = field(machine, nodes=NODES)
    if len(axes) < 3 or error_map.run.n != NODES**3:
        raise UsageError(
            f"{machine.name}: slices and hull need three linear axes and errors known over all of their travels; "
            "vcmm view without --look shows what is known"
        )
    places = np.stack([error_map.run.position[a] for a in "XYZ"], axis=1)
    if not error_map.tip_error.any():
        raise UsageError(
            f"{machine.name}: no error of it is known, so that there is nothing to see; vcmm calibrate finds them"
        )
    order = np.lexsort(places.T[::-1])  # Z fastest, whatever the order of the grid
    shape = (NODES, NODES, NODES, 3)
    return places[order].reshape(shape), error_map.tip_error[order].reshape(shape)


def _join_sheets(sheets: list[tuple[Array, Array]]) -> tuple[Array, Array, Array]:
    """Join sheets: return vertices (v, 3), triangles (f, 3), values (f,) of sheets of places (n, m, 3), values (n, m); both triangles of
    a square have its mean."""
    vertices, faces, values, first = [], [], [], 0
    for places, value in sheets:
        n, m = value.shape
        number = first + np.arange(n * m).reshape(n, m)
        a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
        faces += [np.stack([x.ravel() for x in three], axis=1) for three in ((a, b, c), (a, c, d))]
        vertices.append(places.reshape(-1, 3))
        mean = (value[:-1, :-1] + value[1:, :-1] + value[1:, 1:] + value[:-1, 1:]) / 4
        values += [mean.ravel(), mean.ravel()]
        first += n * m
    return np.concatenate(vertices), np.concatenate(faces), np.concatenate(values)
