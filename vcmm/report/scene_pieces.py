"""From items to flat pieces: convex polygons and straight edges, each with its style, ready to be ordered and drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.report import svg
from vcmm.report.colormap import NO_VALUE, Bands
from vcmm.report.meshes import box_mesh
from vcmm.report.palette import rgb_of
from vcmm.report.scene_items import (
    Array,
    Item,
    Lines,
    SceneBox,
    SceneMesh,
    array,
    face_values,
    line_segments,
    mesh_arrays,
)
from vcmm.report.scene_mesh import (
    CREASE,
    Ints,
    banded,
    edge_faces,
    joined,
    normals,
    quad,
    split,
    volume,
    weld,
)

SHADE = 0.32  # how much darker than its colour a face turned away from the light is


@dataclass(frozen=True)
class ScenePiece:
    """A polygon (style: r, g, b, opacity, hidden when seen from behind, shade) or an edge (style: SVG attributes).

    `faces`: for a polygon the number of the face it is (a part of); for an edge the faces it borders (it is hidden
    when all of these are), empty for a free line. `unit`: what is kept together when space is divided: a mesh with its
    edges, or one side of a box; -1 for other edges. `facing`: outward normal of the side of a box.
    """

    item: int
    unit: int
    points: Array
    style: tuple[float, ...] | str
    faces: tuple[int, ...] = ()
    facing: tuple[float, ...] = (0.0, 0.0, 0.0)

    @property
    def is_face(self) -> bool:
        """A polygon, not an edge."""
        return not isinstance(self.style, str)


def pieces_of(items: Sequence[Item], scale: Bands | None) -> list[ScenePiece]:
    """Polygons and edges of all boxes, meshes and lines; `scale` colours the meshes that carry values."""
    out: list[ScenePiece] = []
    for number, item in enumerate(items):
        first = max((p.faces[0] + 1 for p in out if p.is_face), default=0)
        if isinstance(item, SceneBox):
            out += _box(number, item, first)
        elif isinstance(item, SceneMesh):
            out += _mesh(number, item, first, scale)
        elif isinstance(item, Lines):
            how = svg.paint(stroke=item.colour, width=item.width, dash="5 4" if item.dashed else "")
            out += [ScenePiece(number, -1, segment, how) for segment in line_segments(item)]
    return out


def _box(number: int, box: SceneBox, first: int) -> list[ScenePiece]:
    lo, hi = array(box.lo, (3,), "A box corner"), array(box.hi, (3,), "A box corner")
    vertices, triangles = box_mesh(lo, hi)
    quads = np.concatenate([triangles[:6], triangles[6:, 2:]], axis=1)
    solid = box.opacity > 0
    style = (*rgb_of(box.colour), box.opacity, float(box.opacity >= 1), SHADE)
    shown = enumerate(quads) if solid else ()
    facing = [(0, 0, -1), (0, 0, 1), (0, -1, 0), (0, 1, 0), (-1, 0, 0), (1, 0, 0)]  # order of box_mesh
    out = [ScenePiece(number, first + i, vertices[q], style, (first + i,), facing[i]) for i, q in shown]
    how = _edge_style(box.colour, box.opacity)
    for a in range(8):
        for b in [a | bit for bit in (1, 2, 4) if not a & bit] if box.wire else []:
            near = tuple(first + i for i, q in enumerate(quads) if a in q and b in q) if solid else ()
            out.append(ScenePiece(number, -1, vertices[[a, b]], how, near))
    return out


def _edge_style(colour: str, opacity: float) -> str:
    """Edges of opaque solids are a darker tone of the solid; of glass and wire frames the colour itself."""
    if opacity < 0.6:
        return svg.paint(stroke=colour, width=0.9)
    dark = "#" + "".join(f"{round(0.55 * c):02x}" for c in rgb_of(colour))
    return svg.paint(stroke=dark, width=0.8)


def _mesh(number: int, mesh: SceneMesh, first: int, scale: Bands | None) -> list[ScenePiece]:
    vertices, faces = mesh_arrays(mesh)
    if not len(faces):
        return []
    faces = weld(vertices)[faces]
    edge, pair = edge_faces(faces)
    closed = bool((pair >= 0).all())
    if closed and volume(vertices, faces) < 0:
        faces = faces[:, ::-1]
    cull = mesh.cull if mesh.cull is not None else closed and mesh.opacity >= 1
    shade = SHADE if mesh.values is None else SHADE / 2  # a colour that means a value must stay recognisable
    parts = _polygons(mesh, vertices, faces, edge, pair, scale)
    owner = {f: k for k, (group, _) in enumerate(parts) for f in group}
    out = [
        ScenePiece(
            number,
            first + owner[0],
            points,
            (*rgb_of(colour), mesh.opacity, float(cull), shade),
            (first + k,),
        )
        for k, (_, shapes) in enumerate(parts if mesh.opacity > 0 else [])
        for points, colour in shapes
    ]
    how = _edge_style(mesh.colour, mesh.opacity)
    for k in _sharp(vertices, faces, pair) if mesh.edges else []:
        near = tuple(first + owner[int(f)] for f in pair[k] if f >= 0) if mesh.opacity > 0 else ()
        out.append(ScenePiece(number, first + owner[0] if near else -1, vertices[edge[k]], how, near))
    return out


def _sharp(vertices: Array, faces: Ints, pair: Ints) -> Ints:
    """Edges at a rim or between faces that turn by more than the crease angle."""
    n = normals(vertices, faces)
    turn = np.einsum("ij,ij->i", n[pair[:, 0]], n[pair[:, 1]])
    return np.flatnonzero((pair[:, 1] < 0) | (turn < CREASE))


Part = tuple[list[int], list[tuple[Array, str]]]


def _polygons(
    mesh: SceneMesh, vertices: Array, faces: Ints, edge: Ints, pair: Ints, scale: Bands | None
) -> list[Part]:
    """Groups of triangles with the coloured polygons that show them."""
    values = face_values(mesh)
    if values is None or scale is None:
        common = {tuple(sorted(map(int, p))): e for p, e in zip(pair, edge)}
        groups = joined(vertices, faces, edge, pair)
        shapes = (
            faces[g[0]] if len(g) == 1 else quad(faces[g[0]], faces[g[1]], common[tuple(sorted(g))])
            for g in groups
        )
        return [(g, [(vertices[s], mesh.colour)]) for g, s in zip(groups, shapes)]
    corner = np.asarray(mesh.values, dtype=np.float64)
    colours = (*scale.colours, NO_VALUE)  # index -1: no value
    if len(corner) == len(faces) and len(corner) != len(vertices):
        return [
            ([i], [(vertices[f], colours[k])]) for i, (f, k) in enumerate(zip(faces, scale.index(values)))
        ]
    return [
        ([i], [(p, colours[k]) for p, k in banded(vertices[f], corner[f], scale)])
        for i, f in enumerate(faces)
    ]


def cut(piece: ScenePiece, axis: int, at: float) -> tuple[ScenePiece | None, ScenePiece | None]:
    """The parts below and above the plane coordinate[axis] = at."""
    sides = split(piece.points, piece.points[:, axis] - at, closed=piece.is_face)
    least = 3 if piece.is_face else 2
    low, high = (replace(piece, points=p) if len(p) >= least else None for p in sides)
    return low, high


def shortened(piece: ScenePiece, limit: float) -> list[ScenePiece]:
    """The piece cut in halves until no part is longer than `limit` along an axis."""
    low, high = piece.points.min(axis=0), piece.points.max(axis=0)
    axis = int(np.argmax(high - low))
    if high[axis] - low[axis] <= limit:
        return [piece]
    halves = cut(piece, axis, float(low[axis] + high[axis]) / 2)
    return [part for half in halves if half is not None for part in shortened(half, limit)]
