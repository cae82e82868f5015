"""Draw a scene from one direction: the poster of a page. scene.js does the same for a turned view; change both.

The display list is plain JSON (keys in `scene.encode`). Coordinates are integers, 1/20000 of the scene's extent, about
its centre. Orthographic: the viewer stands at d = (cos el cos az, cos el sin az, sin el), right r = (-sin az, cos az, 0),
up u = d x r.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from vcmm.report import svg
from vcmm.report.scene_order import Leaf, Node
from vcmm.report.scene_pieces import ScenePiece

Array = npt.NDArray[np.float64]
Display = dict[str, Any]
GRAIN = 20000.0
LIGHT = (-0.3, 0.75, 0.59)  # direction to the light in camera coordinates (right, up, towards the viewer)
LABEL = 'font-size="12" paint-order="stroke" stroke-opacity=".85" ' + svg.paint("ink", "surface", 3.0)


def basis(azimuth: float, elevation: float) -> Array:
    """Rows r, u, d for angles in degrees."""
    a, e = math.radians(azimuth), math.radians(elevation)
    ca, sa, ce, se = math.cos(a), math.sin(a), math.cos(e), math.sin(e)
    return np.array([[-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]])


class Encoder:
    """Collects vertices, normals and styles, each stored once, while the display list is written."""

    def __init__(self, centre: Array, size: float) -> None:
        self.centre, self.grain = centre, size / GRAIN
        self.vertices: dict[tuple[float, ...], int] = {}
        self.normals: dict[tuple[float, ...], int] = {}
        self.styles: dict[object, int] = {}
        self.faces: list[list[int]] = []
        self.edges: list[list[int]] = []

    def vertex(self, point: Array) -> int:
        """Number of the vertex at `point` (mm)."""
        return _number(self.vertices, tuple(int(v) for v in np.round((point - self.centre) / self.grain)))

    def style(self, value: object) -> int:
        """Number of the style."""
        return self.styles.setdefault(value, len(self.styles))

    def tree(self, node: Node | Leaf) -> Any:
        """[axis, low, high] of a plane, {"m": mixed, "i": [piece numbers]} of a leaf (edges as -1 - number)."""
        if isinstance(node, Node):
            return [node.axis, self.tree(node.low), self.tree(node.high)]
        return {"m": int(node.mixed), "i": [self._piece(p) for p in node.pieces]}

    def _piece(self, piece: ScenePiece) -> int:
        corners = [self.vertex(p) for p in piece.points]
        if not piece.is_face:
            self.edges.append([self.style(piece.style), *corners, *piece.faces])
            return -len(self.edges)
        normal = _number(self.normals, tuple(float(round(v, 3)) + 0.0 for v in _unit_normal(piece.points)))
        self.faces.append([self.style(piece.style), piece.faces[0], normal, *corners])
        return len(self.faces) - 1


def _number(known: dict[tuple[float, ...], int], key: tuple[float, ...]) -> int:
    return known.setdefault(key, len(known))


def _unit_normal(points: Array) -> Array:
    """Newell's normal of a polygon: right also where three corners lie on a line."""
    p = points - points[0]
    n = np.cross(p, np.roll(p, -1, axis=0)).sum(axis=0)
    return np.asarray(n / (float(np.linalg.norm(n)) or 1.0))


def project(display: Display, view: Sequence[float]) -> tuple[Array, float]:
    """Pixel x, y and depth (v, 3) of the vertices; the scale in px per grain.

    The picture is as large as display["fit"] = [centre x, centre y, half width, half height] allows.
    """
    camera = np.array(display["v"], dtype=np.float64).reshape(-1, 3) @ basis(*view).T
    x0, y0, half_width, half_height = display["fit"]
    reach = np.abs(camera[:, :2]).max(axis=0, initial=1.0)
    scale = min(half_width / float(reach[0]), half_height / float(reach[1]))
    return np.stack([x0 + scale * camera[:, 0], y0 - scale * camera[:, 1], camera[:, 2]], axis=1), scale


def ellipse(covariance: npt.ArrayLike, frame: Array) -> tuple[float, float, float]:
    """Semi-axes (long, short) and angle (degrees, counter-clockwise on the screen) of a projected ellipsoid.

    Exact for an orthographic view: the outline of x^T C^-1 x = 1 is the ellipse of the projected P C P^T.
    """
    c = frame[:2] @ np.asarray(covariance, dtype=np.float64) @ frame[:2].T
    middle, half = (c[0, 0] + c[1, 1]) / 2, (c[0, 0] - c[1, 1]) / 2
    away = math.hypot(half, c[0, 1])
    return (
        math.sqrt(middle + away),
        math.sqrt(max(middle - away, 0.0)),
        math.degrees(math.atan2(c[0, 1], half)) / 2,
    )


def draw(display: Display, view: Sequence[float]) -> str:
    """SVG of everything that turns with the view: surfaces, edges, overlays, triad, scale bar."""
    frame = basis(*view)
    pixels, scale = project(display, view)
    faces = _faces(display, pixels, frame)
    solid = "".join(_leaf(display, leaf, pixels, faces) for leaf in leaves(display["t"], frame[2]))
    over = _overlays(display, pixels, frame, scale)
    stage = f'<g class="stage" stroke-linejoin="round" stroke-linecap="round">{solid}{over}</g>'
    return stage + (_scale_bar(display, scale) + _triad(display, frame) if display["bar"] else "")


def leaves(tree: Any, towards: Array) -> list[dict[str, Any]]:
    """Leaves from the farthest to the nearest side of every plane."""
    if isinstance(tree, dict):
        return [tree]
    axis, low, high = tree
    first, second = (low, high) if towards[axis] > 0 else (high, low)
    return leaves(first, towards) + leaves(second, towards)


Row = tuple[float, str]


def _in_depth(rows: list[Row]) -> str:
    return "".join(row[1] for row in sorted(rows, key=lambda row: row[0]))


def _faces(display: Display, pixels: Array, frame: Array) -> dict[int, tuple[float, str, int]]:
    """(depth, SVG, original face) of each polygon that shows."""
    out = {}
    normals = np.array(display["n"], dtype=np.float64).reshape(-1, 3) @ frame.T
    for i, (style, origin, normal, *corners) in enumerate(display["f"]):
        *rgb, opacity, cull, shade = display["s"][style]
        n = normals[normal]
        if cull and n[2] <= 0:
            continue
        tone = 1 - shade + shade * max(0.0, float(n @ LIGHT) * float(np.sign(n[2])))
        colour = "#" + "".join(f"{min(int(c * tone + 0.5), 255):02x}" for c in rgb)
        p = pixels[corners]
        shape = _polygon(svg.points(p[:, :2], close=True, decimals=1), colour, opacity)
        out[i] = (float(p[:, 2].mean()), shape, origin)
    return out


def _polygon(data: str, colour: str, opacity: float) -> str:
    """A stroke hides the seam between opaque neighbours; glass must not be blended at its borders."""
    if opacity < 1:
        return f'<path d="{data}" fill="{colour}" fill-opacity="{svg.px(opacity)}" shape-rendering="crispEdges"/>'
    return f'<path d="{data}" fill="{colour}" stroke="{colour}" stroke-width=".9"/>'


def _leaf(
    display: Display, leaf: dict[str, Any], pixels: Array, faces: dict[int, tuple[float, str, int]]
) -> str:
    """Pieces of one leaf, farthest first; an edge right after the faces that it borders, if one of them shows."""
    here = [faces[i] for i in leaf["i"] if i in faces]
    near = {origin: depth for depth, _, origin in here}
    rows: list[Row] = [(depth, shape) for depth, shape, _ in here]
    for style, a, b, *borders in (display["e"][-1 - i] for i in leaf["i"] if i < 0):
        beside = [near[g] for g in borders if g in near]
        if beside or not borders:
            free = leaf["m"] or not borders
            depth = 60 + (float(pixels[[a, b], 2].mean()) if free else max(beside))
            line = svg.points(pixels[[a, b], :2], decimals=1)
            rows.append((depth, f'<path d="{line}" {display["s"][style]}/>'))
    return _in_depth(rows)


def _overlays(display: Display, pixels: Array, frame: Array, scale: float) -> str:
    """Ellipses, arrows and points by depth, then labels."""
    rows: list[Row] = []
    for style, centre, *covariance in display["q"]:
        a, b, turn = ellipse(covariance, frame)
        x, y, depth = pixels[centre]
        shape = f'rx="{svg.px(a * scale)}" ry="{svg.px(b * scale)}"'
        move = f'transform="translate({svg.px(x)} {svg.px(y)}) rotate({svg.px(-turn)})"'
        rows.append((depth, f"<ellipse {shape} {move} {display['s'][style]}/>"))
    for style, start, end in display["a"]:
        rows.append((pixels[end, 2], _arrow(pixels[start], pixels[end], display["s"][style])))
    for style, centre, radius in display["p"]:
        x, y, depth = pixels[centre]
        rows.append((depth, svg.circle(x, y, radius, display["s"][style])))
    words = (
        f'<text x="{svg.px(pixels[at, 0] + dx)}" y="{svg.px(pixels[at, 1] + dy)}" {LABEL}>{text}</text>'
        for at, dx, dy, text in display["l"]
    )
    return _in_depth(rows) + "".join(words)


def _arrow(start: Array, end: Array, how: str) -> str:
    """Shaft and a head of 7 px, smaller on arrows below 14 px."""
    dx, dy = float(end[0] - start[0]), float(end[1] - start[1])
    factor, turn = min(1.0, math.hypot(dx, dy) / 14), math.degrees(math.atan2(dy, dx))
    move = f"translate({svg.px(end[0])} {svg.px(end[1])}) rotate({svg.px(turn)}) scale({svg.px(factor)})"
    shaft = f'<path d="{svg.points([(start[0], start[1]), (end[0], end[1])])}" {how}/>'
    return shaft + f'<path d="M0 0L-7 2.6V-2.6Z" transform="{move}" {how}/>'


def place_labels(
    display: Display, pixels: Array, labels: Sequence[tuple[int, str, float]]
) -> list[list[Any]]:
    """[vertex, dx, dy, text] of labels (vertex, text, width): right, left, above or below, the first free spot."""
    taken: list[tuple[float, float, float]] = []
    out: list[list[Any]] = []
    for at, words, wide in labels:
        x, y = float(pixels[at, 0]), float(pixels[at, 1])
        most = display["w"] - wide - 2
        middle = min(max(x - wide / 2, 2.0), most)
        spots = [(x + 8, y + 4), (x - 8 - wide, y + 4), (middle, y - 11), (middle, y + 19)]
        spots = [p for p in spots if 2 <= p[0] <= most] or spots
        free = [
            p for p in spots if all(p[0] > r or p[0] + wide < q or abs(p[1] - b) > 14 for q, r, b in taken)
        ]
        left, base = (free or spots)[0]
        taken.append((left, left + wide, base))
        out.append([at, round(left - x, 1), round(base - y, 1), words])
    return out


def _triad(display: Display, frame: Array) -> str:
    """Directions of the axes, bottom left."""
    out = []
    for i, role in enumerate(("bad", "good", "accent")):
        x, y = 24 * float(frame[0, i]), -24 * float(frame[1, i])
        stroke = svg.path(f"M0 0L{svg.px(x)} {svg.px(y)}", svg.paint(stroke=role, width=1.8))
        name = svg.text(0, 0, "XYZ"[i], role=role, anchor="middle", size=11, bold=True)
        name = name.replace(
            "<text ", f'<text transform="translate({svg.px(1.4 * x)} {svg.px(1.4 * y + 4)})" '
        )
        out.append(f"<g>{stroke}{name}</g>")
    return f'<g class="triad" transform="translate(38 {display["h"] - 38})">{"".join(out)}</g>'


def _scale_bar(display: Display, scale: float) -> str:
    """The longest bar of 1, 2 or 5 times a power of ten mm that fits into display["bar"] pixels, bottom right."""
    per_mm = scale / display["grain"]
    most = display["bar"] / per_mm
    power = 10.0 ** math.floor(math.log10(most))
    length = max(m * power for m in (1, 2, 5) if m * power <= most * 1.000001)
    bar = svg.path(f"M0 -4v8m0 -4H{svg.px(-length * per_mm)}m0 -4v8", svg.paint(stroke="muted", width=1.2))
    words = svg.text(0, -9, f"{length:g} mm", "muted", "end", 11.5)
    move = f"translate({svg.px(display['w'] - 16 - display['side'])} {display['h'] - 14})"
    return f'<g class="bar" transform="{move}">{bar}{words}</g>'
