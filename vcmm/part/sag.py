"""Estimate how far a smooth surface lies off the facets of the mesh that was made of it."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from vcmm.core.pose import Array, length
from vcmm.part.mesh import Mesh, surface_of

SHARP = np.radians(20.0)
"""Two facets that turn by more are an edge of the part. Facets of one radius R turn by t over a chord R t: sag R t^2 / 8. At 20 deg
that is 1.5 % of R, 0.15 mm of R = 10 mm, more than a profile that is worth measuring; no such mesh is a nominal shape. It is also
the angle at which trimesh (graph.smooth_shade) tells facets from smooth surfaces."""


@lru_cache(maxsize=2)
def facet_sags(mesh: Mesh) -> Array:
    """Return the largest distance (f,) mm between each facet and the smooth surface on which its corners lie, estimated from the mesh.

    A chord c of a circle of radius R has the sag c^2 / 8 R, and neighbouring chords turn by t = c / R: sag = c t / 8. The chord
    across an edge is the altitude of the triangle upon it; of two unequal ones the shorter counts, for a mesher makes facets as
    long as the curvature lets it, so the longer one lies in a flatter place. Edges of a facet add, as the curvatures in two
    directions do: exact to second order on strips of a cylinder and on a square grid, halved by diagonals, of any surface; 9 / 8
    of it on equilateral triangles of a sphere (a^2 / 6 R). Convex and concave edges count apart, the larger sum is taken.
    """
    import trimesh

    of = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    of.merge_vertices()
    pair, turn = of.face_adjacency, of.face_adjacency_angles
    ends = of.vertices[of.face_adjacency_edges]
    edge = length(ends[:, 1] - ends[:, 0])
    chord = 2.0 * of.area_faces[pair].min(axis=1) / np.where(edge > 0.0, edge, np.inf)
    sag = np.where(turn < SHARP, chord * turn / 8.0, 0.0)
    out = np.zeros((2, len(mesh.faces)))
    for way, counts in enumerate((of.face_adjacency_convex, ~of.face_adjacency_convex)):
        np.add.at(out[way], pair[counts].ravel(), np.repeat(sag[counts], 2))
    return np.asarray(out.max(axis=0))


def sag_at(mesh: Mesh, points: Array) -> Array:
    """Return the sag (n,) mm of the facets nearest to points (n, 3)."""
    nearest = surface_of(mesh).find_closest_cell(points)
    return facet_sags(mesh)[np.atleast_1d(nearest)]
