"""A 3-D picture of machine, part, points and uncertainty that a reader can turn, point at, clip and print.

The picture is a figure of plotly in the page, drawn when it is scrolled into view; a poster (PNG) stands for it in print,
without script and without WebGL. The library itself, unpacked by `scene.js`, is put into a page once by `page`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from vcmm.core.errors import DataError, ModelLimit
from vcmm.show.report.colormap import Bands, bands, legend
from vcmm.show.report.scene_items import Arrows, Ellipsoids, Item, SceneMesh, face_values, mesh_arrays
from vcmm.show.report.scene_poster import poster
from vcmm.show.report.scene_traces import reach, traces_of
from vcmm.show.report.text import escape, number

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
    """The picture of `items` seen from `view` = (azimuth from +x towards +y, elevation), degrees.

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
    """The figure (data, layout) for plotly, and the colours of its meshes. Errors as of `scene`."""
    _check_size(items)
    scale = _bands(items)
    low, high = reach(items)
    size = float((high - low).max()) or 1.0
    return {"data": traces_of(items, scale, size), "layout": _layout(view, axes, (low, high))}, scale


def eye(view: tuple[float, float]) -> dict[str, float]:
    """Where the camera stands for an azimuth from +x towards +y and an elevation in degrees."""
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
    """One colour scale for all meshes that carry values."""
    meshes = [i for i in items if isinstance(i, SceneMesh) and i.values is not None]
    if not meshes:
        return None
    values = [v.ravel() for v in map(face_values, meshes) if v is not None]
    return bands(np.concatenate(values), symmetric=any(m.symmetric for m in meshes))


def _unit(items: Sequence[Item]) -> str:
    return next((i.unit for i in items if isinstance(i, SceneMesh) and i.values is not None), "")


def _missing(items: Sequence[Item]) -> bool:
    found = (face_values(i) for i in items if isinstance(i, SceneMesh))
    return any(v is not None and bool(np.isnan(v).any()) for v in found)


def magnification(items: Sequence[Item]) -> str:
    """The sentence on how much arrows and ellipsoids are magnified ("" if there are none)."""
    said = []
    for kind, what in ((Arrows, "Arrows"), (Ellipsoids, "Ellipsoids (semi-axes: standard uncertainty)")):
        scales = sorted({float(i.scale) for i in items if isinstance(i, kind)})
        if scales and scales != [1.0]:
            said.append(f"{what} magnified {' and '.join(f'{_thousands(s)} ×' for s in scales)}.")
    return " ".join(said)


def _thousands(value: float) -> str:
    return f"{value:,.0f}".replace(",", "\u202f") if value >= 100 else number(value, 2)
