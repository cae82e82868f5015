"""Items of a 3-D scene. Coordinates are mm in one frame; colours are roles of the palette or #rrggbb.

`name` puts the item into the legend below the picture.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import DataError

Array = npt.NDArray[np.float64]


@dataclass(frozen=True)
class SceneBox:
    """Axis-aligned box; opacity 0 leaves the wire frame (a machine volume)."""

    lo: npt.ArrayLike
    hi: npt.ArrayLike
    colour: str = "#b8c0ca"
    opacity: float = 1.0
    wire: bool = True
    name: str = ""


@dataclass(frozen=True)
class SceneMesh:
    """Triangles (f, 3) over vertices (v, 3). `values` (f,) or (v,) colour it in discrete bands of `unit`.

    Both sides of every face are drawn; `cull` has no effect and stands for programs that give it. `edges` draws rims and creases sharper
    than 30 degrees.
    """

    vertices: npt.ArrayLike
    faces: npt.ArrayLike
    colour: str = "#9fb4cc"
    opacity: float = 1.0
    values: npt.ArrayLike | None = None
    unit: str = ""
    symmetric: bool = False
    edges: bool = True
    cull: bool | None = None
    name: str = ""


@dataclass(frozen=True)
class Lines:
    """A polyline (n, 3) or separate segments (n, 2, 3); width in pixels."""

    points: npt.ArrayLike
    colour: str = "muted"
    width: float = 1.2
    dashed: bool = False
    name: str = ""


@dataclass(frozen=True)
class Points:
    """Dots (n, 3) of radius `size` pixels, with an optional label each; hover: what each says when pointed at."""

    xyz: npt.ArrayLike
    colour: str = "accent"
    size: float = 3.0
    labels: Sequence[str] | None = None
    hover: Sequence[str] | None = None
    name: str = ""


@dataclass(frozen=True)
class Arrows:
    """Vectors (n, 3) at origins (n, 3), mm, drawn `scale` times too long; hover: text of each (default: its length)."""

    origin: npt.ArrayLike
    vector: npt.ArrayLike
    scale: float = 1.0
    colour: str = "c2"
    hover: Sequence[str] | None = None
    name: str = ""


@dataclass(frozen=True)
class Ellipsoids:
    """Covariances (n, 3, 3), mm^2, at centres (n, 3): semi-axes `scale` x standard uncertainty; hover as above."""

    centres: npt.ArrayLike
    covariances: npt.ArrayLike
    scale: float = 1.0
    colour: str = "c4"
    hover: Sequence[str] | None = None
    name: str = ""


@dataclass(frozen=True)
class Label:
    """Text at a point (3,)."""

    xyz: npt.ArrayLike
    text: str


Item = SceneBox | SceneMesh | Lines | Points | Arrows | Ellipsoids | Label


def array(values: npt.ArrayLike, shape: tuple[int | None, ...], what: str) -> Array:
    """Return a float64 array of `shape` (None: any length). DataError: another shape, or numbers that are not finite."""
    out = np.asarray(values, dtype=np.float64)
    fits = out.ndim == len(shape) and all(want in (None, got) for want, got in zip(shape, out.shape))
    if not fits:
        wanted = ", ".join("n" if s is None else str(s) for s in shape)
        raise DataError(f"{what} of a scene must have the shape ({wanted}), got {out.shape}.")
    if not np.isfinite(out).all():
        raise DataError(f"{what} of a scene hold numbers that are not finite: leave such rows out.")
    return out


def line_segments(lines: Lines) -> Array:
    """Return (n, 2, 3) from either form of `Lines.points`."""
    if np.ndim(lines.points) == 3:
        return array(lines.points, (None, 2, 3), "Segments")
    path = array(lines.points, (None, 3), "Line points")
    return np.stack([path[:-1], path[1:]], axis=1)


def mesh_arrays(mesh: SceneMesh) -> tuple[Array, npt.NDArray[np.int64]]:
    """Return (vertices, faces), checked. DataError: a face names a vertex that does not exist."""
    vertices = array(mesh.vertices, (None, 3), "SceneMesh vertices")
    faces = array(mesh.faces, (None, 3), "SceneMesh faces").astype(np.int64)
    if faces.size and not (faces.min() >= 0 and faces.max() < len(vertices)):
        raise DataError(
            f"SceneMesh faces name vertices outside 0 to {len(vertices) - 1}: check the index base (it is 0)."
        )
    return vertices, faces


def face_values(mesh: SceneMesh) -> Array | None:
    """Return the scalar per face (f,); values at vertices are averaged. NaN is allowed: "not evaluated"."""
    if mesh.values is None:
        return None
    values, (vertices, faces) = np.asarray(mesh.values, dtype=np.float64), mesh_arrays(mesh)
    if values.shape == (len(faces),):
        return values
    if values.shape == (len(vertices),):
        return np.asarray(values[faces].mean(axis=1))
    raise DataError(
        f"SceneMesh values must be one per face ({len(faces)}) or per vertex ({len(vertices)}), got {values.shape}."
    )
