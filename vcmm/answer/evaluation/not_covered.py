"""What a claim does not cover: defects that no touch met."""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import choose_criteria
from vcmm.part.part import Characteristic
from vcmm.task.measuring.task import Task

SAME = 1e-3  # mm: touches nearer than that are repeats of one
NARROW = "defects narrower than the spacing of the points ({where}) that no point touches"


def between_touches(task: Task, c: Characteristic) -> tuple[str, ...]:
    """Of extreme values, and of elements by contact: the families of forms hold no scratch between two points."""
    if not gps.is_one_sided(c) and choose_criteria(c).gauss:
        return ()
    rows, places = task.touches.rows, []
    for name in c.of:
        apart = spacing(task.touches.points[rows[name]]) if name in rows else 0.0
        if apart:
            places.append(f"{apart:.2g} mm on {name}")
    return (NARROW.format(where=", ".join(places)),) if places else ()


def spacing(points: Array) -> float:
    """From a point (n, 3) to the nearest other one, of the point that is farthest from all others, mm; 0 of a single point."""
    from scipy.spatial import cKDTree

    places = np.unique(np.round(points / SAME), axis=0) * SAME
    if len(places) < 2:
        return 0.0
    return float(np.asarray(cKDTree(places).query(places, k=2)[0])[:, 1].max())
