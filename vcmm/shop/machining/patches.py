"""The cut surface over all features, for pictures and extremes."""

from __future__ import annotations

import numpy as np

from vcmm.shop.cutting.envelope import UNCUT
from vcmm.shop.machining.contact_path import surface_at, tool_side
from vcmm.shop.machining.maps import Net
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.result import Patch

MOST_ACROSS, MOST_FACES = 41, 28_000  # points across one feature, triangles of all features in one picture


def surface_map(job: PreparedCut) -> tuple[Patch, ...]:
    """Return all features of the part that have an extent, with a density that a picture of all of them can show."""
    features = job.scenario.part.features.values()
    across = int(min(MOST_ACROSS, np.sqrt(MOST_FACES / 2 / max(len(features), 1))))
    return tuple(patch(job, n) for f in features if (n := job.process.net(job, f, across)) is not None)


def patch(job: PreparedCut, over: Net) -> Patch:
    """Return the surface over one net at the estimates of all errors, and without errors."""
    surface = surface_at(job, over.points, over.normals)
    height, nominal = np.full(len(over.points), np.nan), np.full(len(over.points), np.nan)
    there = np.flatnonzero(surface.status != UNCUT)
    if len(there):
        some = surface_at(job, over.points[there], over.normals[there])
        names = np.array([f"{over.feature} {i}" for i in range(len(there))])
        tool, contacts = tool_side(job, some, names, np.full(len(there), over.feature))
        height[there], nominal[there] = contacts.surface(tool.errors()), contacts.surface(tool.known_error)
    return Patch(over, height, nominal)
