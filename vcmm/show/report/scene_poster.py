"""The still picture of a scene, drawn by matplotlib: for print, for readers without script, and until the live one is there."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from typing import Any

import numpy as np

from vcmm.show.report.colormap import NO_VALUE, Bands
from vcmm.show.report.meshes import box_mesh
from vcmm.show.report.palette import hex_of
from vcmm.show.report.scene_items import (
    Array,
    Arrows,
    Ellipsoids,
    Item,
    Label,
    Lines,
    Points,
    SceneBox,
    SceneMesh,
    face_values,
    line_segments,
    mesh_arrays,
)
from vcmm.show.report.scene_mesh import normals
from vcmm.show.report.scene_traces import arrow_ends, ellipsoid_arrays, reach

DPI = 110
COLOURS = 128
LIGHT = np.array([0.35, -0.55, 0.76])  # from where the still picture is lit, unit length within 1 %


def poster(
    items: Sequence[Item], scale: Bands | None, size: tuple[int, int], view: tuple[float, float]
) -> str:
    """PNG in base64 of a scene seen from `view`, at `size` pixels of the page."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(size[0] / 100, size[1] / 100), dpi=DPI)
    FigureCanvasAgg(figure)
    axes: Any = figure.add_axes((0, 0, 1, 1), projection="3d", proj_type="ortho", computed_zorder=False)
    axes.set_axis_off()
    axes.view_init(elev=view[1], azim=view[0])
    faces, colours = _faces(items, scale)
    if len(faces):
        from mpl_toolkits.mplot3d.art3d import Poly3DCollection

        axes.add_collection3d(Poly3DCollection(faces, facecolors=colours, edgecolors="none", zorder=1))
    for item in items:
        _draw_item(axes, item)
    low, high = reach(items)
    middle, half = (low + high) / 2, 0.5 * (float((high - low).max()) or 1.0)
    for set_limits, m, d in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, (high - low) / 2):
        set_limits(m - max(d, 0.02 * half), m + max(d, 0.02 * half))
    axes.set_box_aspect(np.maximum(high - low, 0.04 * half), zoom=1.25)
    out = io.BytesIO()
    figure.savefig(out, format="png", transparent=True)
    return base64.b64encode(_with_fewer_colours(out)).decode("ascii")


def _with_fewer_colours(picture: io.BytesIO) -> bytes:
    """The PNG with a palette of COLOURS: a third of its size."""
    from PIL import Image

    out = io.BytesIO()
    with Image.open(picture) as full:
        full.quantize(COLOURS, method=Image.Quantize.FASTOCTREE).save(out, format="png", optimize=True)
    return out.getvalue()


def _faces(items: Sequence[Item], scale: Bands | None) -> tuple[Array, Array]:
    """Triangles (n, 3, 3) of all solids with their shaded colours (n, 4), so that the nearest hides what is behind."""
    triangles, colours = [np.zeros((0, 3, 3))], [np.zeros((0, 4))]
    for item in items:
        if isinstance(item, SceneBox) and item.opacity > 0:
            vertices, faces = box_mesh(item.lo, item.hi)
            own = np.tile(_rgb(item.colour), (len(faces), 1))
        elif isinstance(item, SceneMesh):
            vertices, faces = mesh_arrays(item)
            own = _own_colours(item, len(faces), scale)
        else:
            continue
        shade = 0.72 + 0.28 * np.abs(normals(vertices, faces) @ LIGHT)
        if isinstance(item, SceneMesh) and item.values is not None and scale is not None:
            shade = np.ones(len(faces))  # its colours are numbers
        triangles.append(vertices[faces])
        colours.append(np.column_stack([own * shade[:, None], np.full(len(faces), item.opacity)]))
    return np.concatenate(triangles), np.concatenate(colours).clip(0.0, 1.0)


def _own_colours(item: SceneMesh, count: int, scale: Bands | None) -> Array:
    values = face_values(item)
    if values is None or scale is None:
        return np.tile(_rgb(item.colour), (count, 1))
    palette = np.array([_rgb(c) for c in (*scale.colours, NO_VALUE)])
    return palette[scale.index(values)]


def _draw_item(axes: Any, item: Item) -> None:
    """Lines, dots, arrows, outlines of ellipsoids and words, in front of the solids."""
    from mpl_toolkits.mplot3d.art3d import Line3DCollection

    if isinstance(item, SceneBox) and item.wire:
        corners, _ = box_mesh(item.lo, item.hi)
        ends = [(a, a | bit) for a in range(8) for bit in (1, 2, 4) if not a & bit]
        axes.add_collection3d(Line3DCollection([corners[list(e)] for e in ends], colors=[hex_of(item.colour)], linewidths=0.6, zorder=2))  # fmt: skip
    elif isinstance(item, Lines):
        axes.add_collection3d(Line3DCollection(line_segments(item), colors=[hex_of(item.colour)], linewidths=0.7 * item.width, zorder=3))  # fmt: skip
    elif isinstance(item, Points):
        xyz = np.asarray(item.xyz, float)
        axes.scatter(
            *xyz.T, s=2.0 * item.size**2, c=[hex_of(item.colour)], depthshade=False, linewidths=0, zorder=5
        )
        for place, words in zip(xyz, item.labels or ()):
            axes.text(*place, words.replace("$", r"\$"), fontsize=7, zorder=6)
    elif isinstance(item, Arrows):
        shafts = np.stack(arrow_ends(item), axis=1)
        axes.add_collection3d(
            Line3DCollection(shafts, colors=[hex_of(item.colour)], linewidths=1.0, zorder=4)
        )
        axes.scatter(*shafts[:, 1].T, s=5, c=[hex_of(item.colour)], depthshade=False, linewidths=0, zorder=4)
    elif isinstance(item, Ellipsoids):
        axes.add_collection3d(Line3DCollection(_outlines(item), colors=[hex_of(item.colour)], linewidths=0.7, zorder=4))  # fmt: skip
    elif isinstance(item, Label):
        axes.text(*np.asarray(item.xyz, float), item.text.replace("$", r"\$"), fontsize=8, zorder=6)


def _outlines(item: Ellipsoids) -> Array:
    """Three principal ellipses of every ellipsoid as polylines (3 n, 25, 3)."""
    centres, covariances = ellipsoid_arrays(item)
    value, vector = np.linalg.eigh(covariances)
    root = item.scale * vector * np.sqrt(value.clip(0))[:, None, :]
    angle = np.linspace(0.0, 2.0 * np.pi, 25)
    rings = []
    for i, j in ((0, 1), (1, 2), (2, 0)):
        ring = (
            np.cos(angle)[None, :, None] * root[:, None, :, i]
            + np.sin(angle)[None, :, None] * root[:, None, :, j]
        )
        rings.append(centres[:, None, :] + ring)
    return np.concatenate(rings)


def _rgb(colour: str) -> Array:
    text = hex_of(colour)
    return np.array([int(text[k : k + 2], 16) for k in (1, 3, 5)]) / 255.0
