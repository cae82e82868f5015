"""Defects that a claim does not cover: those that no touch met, and the surface beyond its outermost touches."""

from __future__ import annotations

import numpy as np

from vcmm.answer.evaluation.form_family import coordinates
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import choose_criteria
from vcmm.part.part import Characteristic, Feature
from vcmm.task.measuring.task import Task

ENDED = ("line", "plane", "cylinder", "cone")  # features that end where touches may not reach
SAME_PLACE_MM = 1e-3  # mm: touches nearer than that are repeats of one
# of the range of a cubic, beyond the outermost touches: less moves no end by more than draws do
UNSEEN = 0.03
BEYOND_SAID = "forms that rise most beyond the outermost points"
BEYOND = BEYOND_SAID + " ({where})"
NARROW = "defects narrower than the spacing of the points ({where}) that no point touches"
# claims that held the true value, of all claims for parts with a scratch: counted from outside (docs/referee.md, family scratch)
SCRATCHED = {
    "roundness": (67, 106),
    "straightness": (278, 384),
    "flatness": (81, 114),
    "parallelism": (89, 106),
}
DENTED = ", with dents 1.5 to 8 mm wide between points 14 mm apart 199 of 226"  # flatness by 25 points, family dent
COUNTED = ": of {kind} with a scratch 1 mm wide an outside count held {held} of {claimed}"


def between_touches(task: Task, c: Characteristic) -> tuple[str, ...]:
    """Return the remarks on extreme values, and on elements by contact: the families of forms hold no scratch between two points."""
    if not gps.is_one_sided(c) and choose_criteria(c).gauss:
        return ()
    rows, places, ends = task.touches.rows, [], []
    for name in c.of:
        apart = spacing(task.touches.points[rows[name]]) if name in rows else 0.0
        if apart:
            places.append(f"{apart:.2g} mm on {name}")
        left, shown = (
            beyond_touches(task.part.features[name], task.touches.points[rows[name]])
            if name in rows
            else (0.0, 1.0)
        )
        if 1.0 - shown > UNSEEN:
            ends.append(f"{left:.2g} mm from the end of {name}: a cubic shows {shown:.0%} of itself")
    covering, claimed = SCRATCHED.get(c.type, (0, 0))
    counted = COUNTED.format(kind=c.type, held=covering, claimed=claimed) if claimed else ""
    counted += DENTED if c.type == "flatness" else ""
    out = [NARROW.format(where=", ".join(places)) + counted] if places else []
    return (*out, *([BEYOND.format(where=", ".join(ends))] if ends else []))


def beyond_touches(feature: Feature, points: Array) -> tuple[float, float]:
    """Return, for touches (n, 3), mm from the outermost to the end of the feature, and the share of its range that a cubic along it shows them.

    u^3 - 3 u / 5 (Legendre, u from -1 to 1) has its range at the ends, 0.8. At touches up to u = m, the residual of a line through the same
    cubic is that of a length m times as long, m^3 of it.

    >>> 0.9**3  # a line of 80 mm, touched from 4 mm to 76 mm
    0.7290000000000001
    """
    if feature.kind not in ENDED or not len(points):
        return 0.0, 1.0
    first, along = coordinates(feature, points)
    spans = [(along, feature.extent[-1])]
    spans += [(first, feature.extent[0])] if feature.kind == "plane" else []
    ends = [(min(float(u.max()), -float(u.min())), size) for u, size in spans]
    m, size = min((max(m, 0.0), size) for m, size in ends)
    return (1.0 - m) * size / 2.0, m**3


def spacing(points: Array) -> float:
    """Return the distance from a point (n, 3) to the nearest other one, of the point that is farthest from all others, mm; 0 of a single point."""
    from scipy.spatial import cKDTree

    places = np.unique(np.round(points / SAME_PLACE_MM), axis=0) * SAME_PLACE_MM
    if len(places) < 2:
        return 0.0
    return float(np.asarray(cKDTree(places).query(places, k=2)[0])[:, 1].max())
