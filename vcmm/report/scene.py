"""A 3-D picture of machine, part, points and uncertainty, as SVG that a reader can turn by dragging.

The SVG is complete without script (print, mail preview); `scene.js`, which `page` adds once, redraws it.
"""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from vcmm.core.errors import DataError, ModelLimit
from vcmm.report import svg
from vcmm.report.axes import Array
from vcmm.report.colormap import NO_VALUE, Bands, bands, colour_legend, legend_width
from vcmm.report.scene_items import (
    Arrows,
    Ellipsoids,
    Item,
    Label,
    Lines,
    Points,
    SceneBox,
    SceneMesh,
    array,
    face_values,
    mesh_arrays,
)
from vcmm.report.scene_order import order
from vcmm.report.scene_paint import LABEL, LIGHT, Display, Encoder, basis, draw, place_labels, project
from vcmm.report.scene_pieces import pieces_of
from vcmm.report.text import escape, number, text_width

HINT = "Drag or use the arrow keys to turn the picture, double-click to reset it."
MOST_FACES = 30_000  # an SVG of more polygons opens slowly (about 3 MB)


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

    Orthographic, fitted to the items. `axes`: triad and scale bar. The caption tells the magnification of arrows and
    ellipsoids. DataError: bad shapes or numbers that are not finite. ModelLimit: more than 30 000 mesh faces.
    """
    _check_size(items)
    scale = _bands(items)
    display = encode(items, scale, width, height, view, axes)
    left = width - display["side"] + 12
    colours = colour_legend(scale, _unit(items), left, 34, 0.72 * height) if scale else ""
    keys, used = svg.legend(_legend(items), 0, height + 8, width)
    body = draw(display, view) + colours + keys
    data = json.dumps(display, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")
    script = f'<script type="application/json" data-scene>{data}</script>'
    words = " ".join(w for w in (caption, magnification(items)) if w)
    whole = svg.document(width, height + (used + 8 if used else 0), body, title)
    return svg.figure(whole, title, words, '<p class="hint">' + HINT + "</p>" + script)


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


def encode(
    items: Sequence[Item], scale: Bands | None, width: float, height: float, view: Sequence[float], axes: bool
) -> Display:
    """The display list.

    w, h: size. side: room for a colour legend. fit: centre and half size of the picture. view. grain: mm per unit of
    v, the vertices. n: unit normals. s: styles, (r, g, b, opacity, hidden from behind, shade) or SVG attributes. f: polygons
    (style, original face, normal, vertices). e: edges (style, 2 vertices, original faces beside). t: tree (see
    `Encoder.tree`). q: ellipses (style, vertex, covariance rows). a: arrows (style, 2 vertices). p: points (style,
    vertex, radius). l: labels (vertex, dx, dy, text). bar: longest scale bar, 0 for no axes. light, label: constants.
    """
    pieces = pieces_of(items, scale)
    corners = np.vstack([p.points for p in pieces] + [_reach(i) for i in items])
    low, high = corners.min(axis=0), corners.max(axis=0)
    size = float((high - low).max()) or 1.0
    out = Encoder(_origin(corners, view), size)
    side = legend_width(scale, _unit(items)) + 24 if scale else 0.0
    half = ((width - side) / 2, (height - (26 if axes else 0)) / 2)
    tree = out.tree(order(pieces, size))
    for item in items:
        for point in _reach(item):
            out.vertex(point)
    overlays, labels = _overlays(items, out)
    display = {
        "w": width, "h": height, "side": round(side, 1), "bar": 0.2 * width if axes else 0, "view": list(view),
        "fit": [*half, half[0] - 18, half[1] - 18], "grain": out.grain, "light": LIGHT, "label": LABEL,
        "v": list(out.vertices), "n": list(out.normals), "s": list(out.styles), "f": out.faces, "e": out.edges,
        "t": tree, **overlays,
    }  # fmt: skip
    return display | {"l": place_labels(display, project(display, view)[0], labels)}


def _origin(corners: Array, view: Sequence[float]) -> Array:
    """The point to turn about: the centre of the box around everything, moved so that the first view is centred."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    frame = basis(*view)
    seen = (corners - (low + high) / 2) @ frame.T
    shift = (seen.min(axis=0) + seen.max(axis=0)) / 2
    return (low + high) / 2 + shift[:2] @ frame[:2]


def _unit(items: Sequence[Item]) -> str:
    return next((i.unit for i in items if isinstance(i, SceneMesh) and i.values is not None), "")


def _reach(item: Item) -> Array:
    """Points (n, 3) that the picture must contain besides the pieces."""
    if isinstance(item, Points):
        return array(item.xyz, (None, 3), "Points")
    if isinstance(item, Label):
        return array(item.xyz, (3,), "A label position")[None]
    if isinstance(item, Arrows):
        return np.vstack(_arrow_ends(item))
    if isinstance(item, Ellipsoids):
        centres, covariances = _ellipsoid_arrays(item)
        half = item.scale * np.sqrt(np.einsum("nii->ni", covariances).clip(0))
        return np.vstack([centres - half, centres + half])
    return np.zeros((0, 3))


def _arrow_ends(item: Arrows) -> tuple[Array, Array]:
    origin, vector = (
        array(item.origin, (None, 3), "Arrow origins"),
        array(item.vector, (None, 3), "Arrow vectors"),
    )
    return origin, origin + item.scale * vector


def _ellipsoid_arrays(item: Ellipsoids) -> tuple[Array, Array]:
    centres = array(item.centres, (None, 3), "Ellipsoid centres")
    covariances = array(item.covariances, (None, 3, 3), "Ellipsoid covariances")
    if len(centres) != len(covariances):
        raise DataError(
            f"{len(centres)} ellipsoid centres but {len(covariances)} covariances: give one each."
        )
    least = np.linalg.eigvalsh(covariances)[:, 0] if len(covariances) else np.zeros(1)
    if (least < -1e-9 * np.abs(covariances).max(initial=0.0)).any():
        raise DataError("An ellipsoid covariance has a negative eigenvalue: it is not a covariance.")
    return centres, covariances


def _overlays(items: Sequence[Item], out: Encoder) -> tuple[Display, list[tuple[int, str, float]]]:
    """Ellipses, arrows and points; labels as (vertex, escaped text, width)."""
    found: dict[str, list[list[object]]] = {"q": [], "a": [], "p": []}
    labels: list[tuple[int, str, float]] = []
    for item in items:
        if isinstance(item, Points):
            style = out.style(svg.paint(item.colour, "surface", 0.8))
            xyz = array(item.xyz, (None, 3), "Points")
            found["p"] += [[style, out.vertex(p), item.size] for p in xyz]
            labels += [_label(out.vertex(p), words) for p, words in zip(xyz, item.labels or ())]
        elif isinstance(item, Arrows):
            style = out.style(svg.paint(item.colour, item.colour, 1.2))
            found["a"] += [[style, out.vertex(a), out.vertex(b)] for a, b in zip(*_arrow_ends(item))]
        elif isinstance(item, Ellipsoids):
            style = out.style(_ellipse_style(item))
            factor = (item.scale / out.grain) ** 2
            found["q"] += [
                [style, out.vertex(p), *_rows(c * factor)] for p, c in zip(*_ellipsoid_arrays(item))
            ]
        elif isinstance(item, Label):
            labels.append(_label(out.vertex(array(item.xyz, (3,), "A label position")), item.text))
    return found, labels


def _label(vertex: int, words: str) -> tuple[int, str, float]:
    return vertex, escape(words), text_width(words, 12)


def _ellipse_style(item: Ellipsoids) -> str:
    return svg.paint(item.colour, item.colour, 0.9) + ' fill-opacity=".25"'


def _rows(covariance: Array) -> list[list[float]]:
    """The rows with 7 digits."""
    return [[float(f"{v:.7g}") for v in row] for row in covariance]


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


def _legend(items: Sequence[Item]) -> list[tuple[str, str]]:
    out = []
    for item in items:
        if isinstance(item, Label) or not item.name:
            continue
        if isinstance(item, Points):
            swatch = svg.circle(8, 5, min(item.size, 5), svg.paint(item.colour))
        elif isinstance(item, Lines):
            how = svg.paint(stroke=item.colour, width=item.width, dash="5 4" if item.dashed else "")
            swatch = svg.line(0, 5, 16, 5, how)
        elif isinstance(item, Arrows):
            swatch = svg.path("M0 5H9M16 5L9 2V8Z", svg.paint(item.colour, item.colour, 1.2))
        elif isinstance(item, Ellipsoids):
            swatch = f'<ellipse cx="8" cy="5" rx="8" ry="5" {_ellipse_style(item)}/>'
        else:
            swatch = _solid_swatch(item)
        out.append((swatch, item.name))
    missing = [
        v
        for v in (face_values(i) for i in items if isinstance(i, SceneMesh))
        if v is not None and np.isnan(v).any()
    ]
    return out + ([(svg.rect(0, 0, 16, 10, svg.paint(NO_VALUE)), "not evaluated")] if missing else [])


def _solid_swatch(item: SceneBox | SceneMesh) -> str:
    how = svg.paint(item.colour if item.opacity > 0 else "", item.colour, 1.0)
    return svg.rect(0.5, 0.5, 15, 9, how + f' fill-opacity="{svg.px(item.opacity)}"')
