"""The cut surface over all features, for pictures and extremes."""

from __future__ import annotations

import numpy as np

from vcmm.cutting.envelope import UNCUT
from vcmm.machining.machine_at_cut import tool_side
from vcmm.machining.maps import Net, net
from vcmm.machining.preparation import Shop, look
from vcmm.machining.result import Patch
from vcmm.machining.turned_faces import turned_net
from vcmm.part.part import Feature

MOST_ACROSS, MOST_FACES = 41, 28_000  # points across one feature, triangles of all features in one picture


def surface_map(shop: Shop) -> tuple[Patch, ...]:
    """All features of the part that have an extent, as densely as a picture of all of them can show."""
    features = shop.scenario.part.features.values()
    across = int(min(MOST_ACROSS, np.sqrt(MOST_FACES / 2 / max(len(features), 1))))
    return tuple(patch(shop, n) for f in features if (n := _net(shop, f, across)) is not None)


def _net(shop: Shop, feature: Feature, across: int) -> Net | None:
    if shop.turning is None:
        return net(feature, across)
    return turned_net(feature, across, shop.pose, shop.turning)


def patch(shop: Shop, over: Net) -> Patch:
    """The surface over one net at the estimates of all errors, and without errors."""
    surface = look(shop, over.points, over.normals)
    height, nominal = np.full(len(over.points), np.nan), np.full(len(over.points), np.nan)
    there = np.flatnonzero(surface.status != UNCUT)
    if len(there):
        some = look(shop, over.points[there], over.normals[there])
        names = np.array([f"{over.feature} {i}" for i in range(len(there))])
        tool, contacts = tool_side(shop, some, names, np.full(len(there), over.feature))
        height[there], nominal[there] = contacts.surface(tool.errors()), contacts.surface(tool.known)
    return Patch(over, height, nominal)
