"""Standard strategies at a given number of touches: what a good operator, a textbook or a standard would do."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array
from vcmm.measuring.strategies import (
    Around,
    Birdcage,
    Even,
    Grid,
    Helix,
    Iso10360,
    Latitudes,
    Levels,
    Pattern,
    Polar,
    Ring,
    Spiral,
    Spread,
    plan_points,
)
from vcmm.part.part import Feature


def standard_points(feature: Feature, most: int, margin: float) -> Iterator[tuple[str, Array]]:
    """(name, points (n, 3)) of standard strategies with at most `most` touches, `margin` mm inside the edges."""
    for name, pattern in _patterns(feature, most, margin):
        try:
            points = plan_points(feature, pattern)[0]
        except UsageError:  # too few points for the fit, or the margin leaves nothing
            continue
        if len(points) <= most:
            yield f"{name} {len(points)}", points


def _patterns(f: Feature, most: int, margin: float) -> Iterator[tuple[str, Pattern]]:
    if f.kind == "plane":
        yield from (
            ("grid", Grid((a, b), margin)) for a in range(2, most) for b in range(2, most) if a * b <= most
        )
        yield from (("hammersley", Spread(n, margin)) for n in range(3, most + 1))
        yield from (("polar", Polar(r, n, margin)) for r in (1, 2, 3) for n in range(3, most) if r * n < most)
    elif f.kind == "line":
        yield from (("even", Even(n, margin)) for n in range(2, most + 1))
    elif f.kind == "circle":
        yield from (("even", Around(n)) for n in range(3, most + 1))
    elif f.kind == "sphere":
        yield "iso10360", Iso10360()
        yield from (("spiral", Spiral(n)) for n in range(4, most + 1))
        yield from (("levels", Latitudes((0.0, 0.7, 1.3), n)) for n in range(3, most // 3 + 1))
    elif f.kind in ("cylinder", "cone"):
        yield from _round(f, most, margin)
    elif f.kind == "torus":
        yield from (("grid", Ring((a, b))) for a in range(3, most) for b in range(3, most) if a * b <= most)


def _round(f: Feature, most: int, margin: float) -> Iterator[tuple[str, Pattern]]:
    low, high = margin, f.extent[0] - margin
    for levels in (2, 3, 4):
        at = tuple(float(z) for z in np.linspace(low, high, levels))
        yield from (("levels", Levels(at, n)) for n in range(3, most // levels + 1))
        yield from (("staggered", Levels(at, n, stagger=True)) for n in range(3, most // levels + 1))
    yield from (("helix", Helix(n, 2.0, margin)) for n in range(6, most + 1, 2))
    yield from (
        ("birdcage", Birdcage(2, n, lines, 3, margin))
        for n in range(4, most, 2)
        for lines in (2, 4)
        if 2 * n + 3 * lines <= most
    )
