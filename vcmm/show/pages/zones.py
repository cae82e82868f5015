"""Pictures of the tolerance zones of measured parts: flatness, roundness and position, as the points that were taken in lie in them."""

from __future__ import annotations

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel
from vcmm.core.pose import Pose
from vcmm.part.alignment import align
from vcmm.part.characteristic import Characteristic
from vcmm.part.gps.reference_circles import least_squares_circle, minimum_zone_circles
from vcmm.part.gps.zone_points import FlatPoints, PlacedAxis, RoundPoints, zone_points
from vcmm.show import charts as draw


def zone_picture(model: LinearModel, c: Characteristic) -> list[str]:
    """The zone of one characteristic with what was measured; nothing for other types, and where no points were taken in."""
    task = model.task
    if not task.form.any():
        return []
    features, scheme = task.part.features, task.plan.alignment
    pose = None if scheme is None else align(scheme, features, model.base, Pose.identity())
    places = {name: task.touches.points[rows] for name, rows in task.touches.rows.items()}
    shown = zone_points(c, features, model.base, places, pose)
    zone = None if c.zone is None else 1e3 * c.zone
    if isinstance(shown, FlatPoints):
        title = f"{c.name}: points as indicated, in the zone"
        return [draw.on_page(draw.flatness_zone, shown.along, 1e3 * shown.residual, zone, title=title)]
    if isinstance(shown, PlacedAxis):
        title = f"{c.name}: as indicated, in the zone"
        return [draw.on_page(draw.position_zone, 1e3 * shown.off, zone, 1e3 * shown.paid, title=title)]
    return [] if shown is None else [_round(c, shown)]


def _round(c: Characteristic, shown: RoundPoints) -> str:
    order = np.argsort(shown.angle, kind="stable")
    angle, raw = shown.angle[order], 1e3 * shown.residual[order]
    lines = [draw.PolarTrace("unfiltered", angle, raw, "c1" if shown.filtered is None else "c6", thin=True)]
    kept = raw
    if shown.filtered is not None:
        kept = 1e3 * shown.filtered[order]
        lines.append(draw.PolarTrace("filtered", angle, kept, "c1"))
    circles = []
    for name, found, zone in (
        ("LSC", least_squares_circle, False), ("MZC", minimum_zone_circles, True),
    ):  # fmt: skip
        (radius, x, y), width = found(angle, kept)
        circles.append(draw.ReferenceCircle(name, float(radius), float(x), float(y), width, zone=zone))
    return draw.on_page(draw.traces, lines, title=f"{c.name}: profile as indicated", circles=circles)
