"""Items of a scene as traces of plotly: plain lists and numbers, nothing of plotly is imported.

Colours are roles ("role:accent", which the script of the page resolves for light and dark) or #rrggbb.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from vcmm.core.errors import DataError
from vcmm.show.report.colormap import NO_VALUE, Bands
from vcmm.show.report.meshes import box_mesh, creases, sphere_mesh
from vcmm.show.report.palette import LIGHT, hex_of, rgb_of
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
    array,
    face_values,
    line_segments,
    mesh_arrays,
)

Trace = dict[str, Any]
DIGITS = 7  # significant digits of a coordinate: 0.1 um at a metre, far below a pixel
HEAD = 0.02  # length of an arrow head, of the size of the scene
FINE, COARSE, MANY = 12, 6, 150  # meridians of an ellipsoid, and of how many on they are drawn coarsely
FLAT = {
    "ambient": 1.0,
    "diffuse": 0.0,
    "specular": 0.0,
    "roughness": 1.0,
    "fresnel": 0.0,
}  # the colour itself, as on its bar
SOFT = {"ambient": 0.62, "diffuse": 0.5, "specular": 0.08, "roughness": 0.8, "fresnel": 0.05}


def traces_of(items: Sequence[Item], scale: Bands | None, size: float) -> list[Trace]:
    """Return the traces of all items in their order. scale: colours of meshes that carry values. size: mm, of the whole scene."""
    out: list[Trace] = []
    for item in items:
        if isinstance(item, SceneBox):
            out += _box(item)
        elif isinstance(item, SceneMesh):
            out += _mesh(item, scale)
        elif isinstance(item, Lines):
            out.append(_lines(line_segments(item), item.colour, item.width, item.name, item.dashed))
        elif isinstance(item, Points):
            out.append(_points(item))
        elif isinstance(item, Arrows):
            out += _arrows(item, size)
        elif isinstance(item, Ellipsoids):
            out += _ellipsoids(item)
        elif isinstance(item, Label):
            out.append(_label(item))
    return out


def reach(items: Sequence[Item]) -> tuple[Array, Array]:
    """Return the corners of the box around everything, mm."""
    spots = np.vstack([_spots(i) for i in items])
    return spots.min(axis=0), spots.max(axis=0)


def _spots(item: Item) -> Array:
    if isinstance(item, SceneBox):
        return np.stack([array(item.lo, (3,), "A box corner"), array(item.hi, (3,), "A box corner")])
    if isinstance(item, SceneMesh):
        return mesh_arrays(item)[0]
    if isinstance(item, Lines):
        return line_segments(item).reshape(-1, 3)
    if isinstance(item, Points):
        return array(item.xyz, (None, 3), "Points")
    if isinstance(item, Arrows):
        return np.vstack(arrow_ends(item))
    if isinstance(item, Ellipsoids):
        centres, covariances = ellipsoid_arrays(item)
        half = item.scale * np.sqrt(np.einsum("nii->ni", covariances).clip(0))
        return np.vstack([centres - half, centres + half])
    return array(item.xyz, (3,), "A label position")[None]


def arrow_ends(item: Arrows) -> tuple[Array, Array]:
    """Return origins and tips (n, 3) of the magnified arrows."""
    origin = array(item.origin, (None, 3), "Arrow origins")
    return origin, origin + item.scale * array(item.vector, (None, 3), "Arrow vectors")


def ellipsoid_arrays(item: Ellipsoids) -> tuple[Array, Array]:
    """Return the centres (n, 3) and covariances (n, 3, 3). DataError: other numbers of them, no covariance."""
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


def _box(item: SceneBox) -> list[Trace]:
    lo, hi = array(item.lo, (3,), "A box corner"), array(item.hi, (3,), "A box corner")
    vertices, faces = box_mesh(lo, hi)
    out = [_solid(vertices, faces, item.colour, item.opacity, item.name)] if item.opacity > 0 else []
    ends = [(a, a | bit) for a in range(8) for bit in (1, 2, 4) if not a & bit]
    if item.wire:
        segments = np.array([[vertices[a], vertices[b]] for a, b in ends])
        out.append(_lines(segments, _edge_colour(item), 1.5, "" if out else item.name))
    return out


def _mesh(item: SceneMesh, scale: Bands | None) -> list[Trace]:
    vertices, faces = mesh_arrays(item)
    if not len(faces):
        return []
    solid = _solid(vertices, faces, item.colour, item.opacity, item.name)
    values = face_values(item)
    if values is not None and scale is not None:
        band = scale.index(values)
        colours = [NO_VALUE if b < 0 else scale.colours[b] for b in band]
        at_corners = _corner_values(item, values, len(vertices), faces)
        texts = ["not evaluated" if not np.isfinite(v) else f"{v:.4g} {item.unit}" for v in at_corners]
        solid |= {
            "lighting": FLAT,
            "opacity": 1.0,
            "facecolor": colours,
            "hovertext": texts,
            "hoverinfo": "text",
        }
    out = [solid]
    if item.edges:
        segments = creases(vertices, faces)
        if len(segments):
            out.append(_lines(segments, _edge_colour(item), 1.5, ""))
    return out


def _corner_values(item: SceneMesh, values: Array, count: int, faces: Any) -> Array:
    """Return the value at every vertex: as given, or the mean of its faces."""
    given = np.asarray(item.values, float)
    if given.shape == (count,):
        return given
    total, number = np.zeros(count), np.zeros(count)
    np.add.at(total, faces.ravel(), np.repeat(values, 3))
    np.add.at(number, faces.ravel(), 1.0)
    return np.divide(total, number, out=np.full(count, np.nan), where=number > 0)


def _solid(vertices: Array, faces: Any, colour: str, opacity: float, name: str) -> Trace:
    x, y, z = _xyz(vertices)
    i, j, k = (faces[:, n].tolist() for n in range(3))
    return {
        "type": "mesh3d", "x": x, "y": y, "z": z, "i": i, "j": j, "k": k, "color": _role(colour), "opacity": opacity,
        "flatshading": True, "lighting": SOFT, "hoverinfo": "skip", **_legend_entry(name),
    }  # fmt: skip


def _edge_colour(item: SceneBox | SceneMesh) -> str:
    """Return the edges of opaque solids are a darker tone of the solid; of glass and wire frames the colour itself."""
    if item.opacity < 0.6:
        return item.colour
    return "#" + "".join(f"{round(0.55 * c):02x}" for c in rgb_of(item.colour))


def _lines(segments: Array, colour: str, width: float, name: str, dashed: bool = False) -> Trace:
    gaps = np.full((len(segments), 3, 3), np.nan)
    gaps[:, :2] = segments
    x, y, z = _xyz(gaps.reshape(-1, 3))
    line = {"color": _role(colour), "width": 1.6 * width, "dash": "dash" if dashed else "solid"}
    return {"type": "scatter3d", "mode": "lines", "x": x, "y": y, "z": z, "line": line, "hoverinfo": "skip", **_legend_entry(name)}  # fmt: skip


def _points(item: Points) -> Trace:
    xyz = array(item.xyz, (None, 3), "Points")
    x, y, z = _xyz(xyz)
    texts = _hover_texts(item.hover or item.labels, len(xyz), "points")
    marker = {"size": 1.7 * item.size, "color": _role(item.colour), "line": {"width": 0}}
    out = {
        "type": "scatter3d",
        "mode": "markers",
        "x": x,
        "y": y,
        "z": z,
        "marker": marker,
        **_legend_entry(item.name),
    }
    if item.labels:
        out |= {
            "mode": "markers+text",
            "text": [_plain(t) for t in item.labels],
            "textposition": "top center",
        }
    return out | ({"hovertext": texts, "hoverinfo": "text"} if texts else {"hoverinfo": "skip"})


def _arrows(item: Arrows, size: float) -> list[Trace]:
    a, b = arrow_ends(item)
    long = np.linalg.norm(b - a, axis=1)
    drawn = long > 0
    shaft = _lines(np.stack([a, b], axis=1), item.colour, 1.4, item.name)
    if not drawn.any():
        return [shaft]
    way = (b - a)[drawn] / long[drawn, None]
    u, v, w = _xyz(way)
    x, y, z = _xyz(b[drawn])
    hovers = _hover_texts(item.hover, len(a), "arrows")
    texts = [t for t, keep in zip(hovers, drawn) if keep] if hovers else _lengths(item, a[drawn], long[drawn])
    head = {
        "type": "cone", "x": x, "y": y, "z": z, "u": u, "v": v, "w": w, "anchor": "tip", "sizemode": "absolute",
        "sizeref": HEAD * size, "showscale": False, "colorscale": [[0, _role(item.colour)], [1, _role(item.colour)]],
        "hovertext": texts, "hoverinfo": "text", "showlegend": False,
    }  # fmt: skip
    return [shaft, head]


def _lengths(item: Arrows, at: Array, drawn: Array) -> list[str]:
    """Return the text of an arrow: its true length, and its place."""
    return [
        f"{1e3 * d / item.scale:.3g} µm at {p[0]:.4g}, {p[1]:.4g}, {p[2]:.4g} mm" for p, d in zip(at, drawn)
    ]


def _ellipsoids(item: Ellipsoids) -> list[Trace]:
    """Return all ellipsoids as one mesh, and their centres.

    The mesh is one ball; `meta` has the centres and, row by row, the roots of the covariances that make ellipsoids of it in
    `scene.js`: a tenth of the numbers. A text of `hovertext` belongs to a whole ellipsoid.
    """
    centres, covariances = ellipsoid_arrays(item)
    ball, faces = sphere_mesh(np.zeros(3), 1.0, n=FINE if len(centres) <= MANY else COARSE)
    value, vector = np.linalg.eigh(covariances)
    roots = item.scale * vector * np.sqrt(value.clip(0))[:, None, :]
    texts = _hover_texts(item.hover, len(centres), "ellipsoids") or [_axes(v) for v in np.sqrt(value.clip(0))]
    solid = _solid(ball, faces, item.colour, 0.45, item.name)
    meta = {
        "centres": _short(centres),
        "roots": _short(roots.reshape(-1, 9)),
    }
    solid |= {"flatshading": False, "hovertext": texts, "hoverinfo": "text", "meta": meta}
    return [solid, _points(Points(centres, item.colour, 2.0))]


def _axes(semi: Array) -> str:
    return "semi-axes " + ", ".join(f"{1e3 * v:.3g}" for v in sorted(semi, reverse=True)) + " µm (k = 1)"


def _label(item: Label) -> Trace:
    x, y, z = _xyz(array(item.xyz, (3,), "A label position")[None])
    return {
        "type": "scatter3d", "mode": "text", "x": x, "y": y, "z": z, "text": [_plain(item.text)],
        "textfont": {"color": "role:ink", "size": 12}, "hoverinfo": "skip", "showlegend": False,
    }  # fmt: skip


def _hover_texts(texts: Sequence[str] | None, count: int, what: str) -> list[str]:
    """Return the hover texts, one each; newlines break lines."""
    if texts is None:
        return []
    if len(texts) != count:
        raise DataError(f"{len(texts)} texts for {count} {what}: give one each.")
    return [_plain(t) for t in texts]


def _plain(text: str) -> str:
    """Return a text as plotly shows it: it knows a few tags, which a name from a file must not become."""
    escaped = text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
    return escaped.replace("\n", "<br>")


def _legend_entry(name: str) -> Trace:
    return {"name": _plain(name), "showlegend": True} if name else {"showlegend": False}


def _role(colour: str) -> str:
    hex_of(colour)  # refuses what is neither
    return f"role:{colour}" if colour in LIGHT else colour


def _xyz(points: Array) -> list[list[float | None]]:
    """Return columns with few digits; NaN is None, a gap."""
    return [[None if v != v else float(f"{v:.{DIGITS}g}") for v in points[:, k].tolist()] for k in range(3)]


def _short(rows: Array) -> list[list[float]]:
    return [[float(f"{v:.{DIGITS}g}") for v in row] for row in rows.tolist()]
