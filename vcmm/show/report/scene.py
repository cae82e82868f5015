"""A 3-D picture of machine, part, points and uncertainty that a reader can turn, point at, clip and print.

The picture is a figure of plotly in the page, drawn when it is scrolled into view; a poster (PNG) replaces it in print,
without script and without WebGL. The library itself, unpacked by `scene.js`, is put into a page once by `page`.

The still picture of a scene, drawn by matplotlib: for print, for readers without script, and until the live one is there.
"""

from __future__ import annotations

import base64
import io
import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vcmm.core.errors import DataError, ModelLimit
from vcmm.show.report.colormap import NO_VALUE, Bands, bands, legend
from vcmm.show.report.meshes import box_mesh, normals
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
from vcmm.show.report.scene_traces import arrow_ends, ellipsoid_arrays, reach, traces_of
from vcmm.show.report.text import escape, number

DPI = 110
COLOURS = 128
LIGHT = np.array([0.35, -0.55, 0.76])  # from where the still picture is lit, unit length within 1 %


def poster(
    items: Sequence[Item], scale: Bands | None, size: tuple[int, int], view: tuple[float, float]
) -> str:
    """Return PNG in base64 of a scene seen from `view`, at `size` pixels of the page."""
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
    """Return the PNG with a palette of COLOURS: a third of its size."""
    from PIL import Image

    out = io.BytesIO()
    with Image.open(picture) as full:
        full.quantize(COLOURS, method=Image.Quantize.FASTOCTREE).save(out, format="png", optimize=True)
    return out.getvalue()


def _faces(items: Sequence[Item], scale: Bands | None) -> tuple[Array, Array]:
    """Return the triangles (n, 3, 3) of all solids with their shaded colours (n, 4), so that the nearest hides what is behind."""
    triangles, colours = [np.zeros((0, 3, 3))], [np.zeros((0, 4))]
    for item in items:
        if isinstance(item, SceneBox) and item.opacity > 0:
            vertices, faces = box_mesh(item.lo, item.hi)
            face_colours = np.tile(_rgb(item.colour), (len(faces), 1))
        elif isinstance(item, SceneMesh):
            vertices, faces = mesh_arrays(item)
            face_colours = _own_colours(item, len(faces), scale)
        else:
            continue
        shade = 0.72 + 0.28 * np.abs(normals(vertices, faces) @ LIGHT)
        if isinstance(item, SceneMesh) and item.values is not None and scale is not None:
            shade = np.ones(len(faces))  # its colours are numbers
        triangles.append(vertices[faces])
        colours.append(np.column_stack([face_colours * shade[:, None], np.full(len(faces), item.opacity)]))
    return np.concatenate(triangles), np.concatenate(colours).clip(0.0, 1.0)


def _own_colours(item: SceneMesh, count: int, scale: Bands | None) -> Array:
    values = face_values(item)
    if values is None or scale is None:
        return np.tile(_rgb(item.colour), (count, 1))
    palette = np.array([_rgb(c) for c in (*scale.colours, NO_VALUE)])
    return palette[scale.index(values)]


def _draw_item(axes: Any, item: Item) -> None:
    """Draw lines, dots, arrows, outlines of ellipsoids and words, in front of the solids."""
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
    """Return three principal ellipses of every ellipsoid as polylines (3 n, 25, 3)."""
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


HINT = "Drag or use the arrow keys to turn the picture, the wheel to come nearer, Home to reset it; point at anything to read it."
MOST_FACES = 30_000  # a page of more triangles opens slowly (about 3 MB)
PAD = 0.04  # of the longest edge: what the axes go beyond the items
TICKS = 7  # of the longest edge
CAMERA = 1.6  # distance of the eye in sizes of the scene: what leaves room for the labels


def scene(
    items: Sequence[Item],
    *,
    title: str,
    width: int = 760,
    height: int = 520,
    view: tuple[float, float] = (-60.0, 22.0),
    axes: bool = True,
    caption: str = "",
) -> str:
    """Return the picture of `items` seen from `view` = (azimuth from +x towards +y, elevation), degrees.

    Orthographic, fitted to the items. `axes`: axes with mm. The caption tells the magnification of arrows and
    ellipsoids. DataError: bad shapes or numbers that are not finite. ModelLimit: more than 30 000 mesh faces.
    """
    figure, scale = figure_of(items, view, axes)
    still = poster(items, scale, (width, height), view)
    colours = "" if scale is None else legend(scale, _unit(items), 0.72 * height, _missing(items))
    data = json.dumps(figure, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    words = " ".join(w for w in (caption, magnification(items)) if w)
    picture = (
        f'<div class="scene" tabindex="0" role="group" aria-label="{escape(title)}" style="height:{height}px">'
        f'<img class="poster" alt="{escape(title)}" src="data:image/png;base64,{still}"><div class="live"></div></div>'
    )
    script = f'<script type="application/json" data-scene>{data}</script>'
    below = '<div class="clip" hidden></div><p class="hint">' + HINT + "</p>" + script
    head = f"<figcaption>{escape(title)}{_small(words)}</figcaption>"
    return f'<figure class="figure">{head}<div class="picture row">{picture}{colours}</div>{below}</figure>'


def figure_of(
    items: Sequence[Item], view: tuple[float, float] = (-60.0, 22.0), axes: bool = True
) -> tuple[dict[str, Any], Bands | None]:
    """Return the figure (data, layout) for plotly, and the colours of its meshes. Errors as of `scene`."""
    _check_size(items)
    scale = _bands(items)
    low, high = reach(items)
    size = float((high - low).max()) or 1.0
    return {"data": traces_of(items, scale, size), "layout": _layout(view, axes, (low, high))}, scale


def eye(view: tuple[float, float]) -> dict[str, float]:
    """Return the place of the camera for an azimuth from +x towards +y and an elevation in degrees."""
    a, e = math.radians(view[0]), math.radians(view[1])
    return {
        "x": CAMERA * math.cos(e) * math.cos(a), "y": CAMERA * math.cos(e) * math.sin(a), "z": CAMERA * math.sin(e),
    }  # fmt: skip


def _layout(view: tuple[float, float], axes: bool, box: tuple[Any, Any]) -> dict[str, Any]:
    size = float((box[1] - box[0]).max()) or 1.0
    edges = (box[1] - box[0]) / size + 2 * PAD
    whole = edges * math.sqrt(3.0) / float(np.linalg.norm(edges))  # as long from corner to corner as a cube

    def axis(letter: str, k: int) -> dict[str, Any]:
        pad, share = PAD * size, float(box[1][k] - box[0][k]) / size
        shown = {"title": {"text": f"{letter} / mm"}, "color": "role:muted", "gridcolor": "role:grid"}
        return {
            "visible": axes, "showbackground": False, "showspikes": False, "range": [float(box[0][k] - pad), float(box[1][k] + pad)],
            "zeroline": False, "nticks": max(2, round(TICKS * share)), "tickfont": {"size": 11}, **shown,
        }  # fmt: skip

    scene = {
        "aspectmode": "manual", "aspectratio": dict(zip("xyz", whole.tolist())), "xaxis": axis("X", 0), "yaxis": axis("Y", 1), "zaxis": axis("Z", 2), "dragmode": "orbit",
        "camera": {"eye": eye(view), "up": {"x": 0, "y": 0, "z": 1}, "projection": {"type": "orthographic"}},
    }  # fmt: skip
    return {
        "scene": scene, "margin": {"l": 0, "r": 0, "t": 0, "b": 0}, "paper_bgcolor": "rgba(0,0,0,0)", "autosize": True,
        "font": {"color": "role:ink", "size": 12}, "showlegend": True,
        "legend": {"orientation": "h", "x": 0, "y": 0, "yanchor": "top", "bgcolor": "rgba(0,0,0,0)"},
        "modebar": {"bgcolor": "rgba(0,0,0,0)", "color": "role:muted", "activecolor": "role:accent"},
        "hoverlabel": {"bgcolor": "role:surface", "bordercolor": "role:rule", "font": {"color": "role:ink"}},
    }  # fmt: skip


def _small(words: str) -> str:
    return f'<span class="caption">{escape(words)}</span>' if words else ""


def _check_size(items: Sequence[Item]) -> None:
    if not items:
        raise DataError("A scene needs at least one item.")
    faces = sum(len(mesh_arrays(i)[1]) for i in items if isinstance(i, SceneMesh))
    if faces > MOST_FACES:
        raise ModelLimit(
            f"The scene holds {faces} mesh faces, at most {MOST_FACES} can be drawn: decimate the mesh."
        )


def _bands(items: Sequence[Item]) -> Bands | None:
    """Return one colour scale for all meshes that carry values."""
    meshes = [i for i in items if isinstance(i, SceneMesh) and i.values is not None]
    if not meshes:
        return None
    values = [v.ravel() for v in map(face_values, meshes) if v is not None]
    return bands(np.concatenate(values), symmetric=any(m.symmetric for m in meshes))


def _unit(items: Sequence[Item]) -> str:
    return next((i.unit for i in items if isinstance(i, SceneMesh) and i.values is not None), "")


def _missing(items: Sequence[Item]) -> bool:
    values = (face_values(i) for i in items if isinstance(i, SceneMesh))
    return any(v is not None and bool(np.isnan(v).any()) for v in values)


def magnification(items: Sequence[Item]) -> str:
    """Return the sentence on how much arrows and ellipsoids are magnified ("" if there are none)."""
    texts = []
    for kind, what in ((Arrows, "Arrows"), (Ellipsoids, "Ellipsoids (semi-axes: standard uncertainty)")):
        scales = sorted({float(i.scale) for i in items if isinstance(i, kind)})
        if scales and scales != [1.0]:
            texts.append(f"{what} magnified {' and '.join(f'{_thousands(s)} ×' for s in scales)}.")
    return " ".join(texts)


def _thousands(value: float) -> str:
    return f"{value:,.0f}".replace(",", "\u202f") if value >= 100 else number(value, 2)
