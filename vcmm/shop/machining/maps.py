"""Maps: nets of points on the nominal surfaces, at which the cut surface is evaluated for pictures and extremes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.part.part import Feature, normal, surface_point

MARGIN = 0.01  # of the size: the very edge belongs to the neighbour


@dataclass(frozen=True, eq=False)
class Net:
    """points, normals (ny nx, 3) in the drawing frame, row by row; first (nx,), second (ny,): surface coordinates."""

    feature: str
    points: Array
    normals: Array
    first: Array
    second: Array
    labels: tuple[str, str]

    @property
    def faces(self) -> npt.NDArray[np.int64]:
        """Triangles (f, 3) over the points."""
        nx, ny = len(self.first), len(self.second)
        corner = (np.arange(ny - 1)[:, None] * nx + np.arange(nx - 1)).ravel()
        lower = np.stack([corner, corner + 1, corner + nx + 1], axis=1)
        upper = np.stack([corner, corner + nx + 1, corner + nx], axis=1)
        return np.concatenate([lower, upper]).astype(np.int64)


def net(feature: Feature, across: int = 41) -> Net | None:
    """Return about across x across points over the extent of a feature; None for points, lines and meshes."""
    full = np.linspace(0.0, 2 * np.pi, 2 * across - 1)
    labels = ("angle / deg", "along the axis / mm")
    if feature.kind == "plane":
        first, second = (np.linspace(-0.5 + MARGIN, 0.5 - MARGIN, across) * size for size in feature.extent)
        labels = ("along u / mm", "along v / mm")
    elif feature.kind in ("cylinder", "cone"):
        first, second = full, np.linspace(MARGIN, 1.0 - MARGIN, max(9, across // 2)) * feature.extent[0]
    elif feature.kind == "sphere":
        first, second, labels = (
            full,
            np.linspace(0.02, 0.98, across) * np.pi / 2,
            ("longitude / deg", "latitude / deg"),
        )
    elif feature.kind == "torus":
        first, second, labels = (
            full,
            np.linspace(0.0, np.pi, across),
            ("ring angle / deg", "tube angle / deg"),
        )
    else:
        return None
    points = surface_point(feature, first[None, :], second[:, None]).reshape(-1, 3)
    return Net(feature.name, points, normal(feature, points), first, second, labels)
