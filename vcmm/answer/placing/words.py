"""A placement in words; the same in the terminal and the report."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from vcmm.answer.placing.near_best import Region
from vcmm.answer.placing.result import PlacementResult
from vcmm.core.run import Array
from vcmm.task.measuring.fixture import format_freedom

UNITS = {"mm": ("µm", 1e3), "rad": ("µrad", 1e6)}


def amount(value: float, placed: PlacementResult) -> str:
    """Return a value of the objective with its unit."""
    word, scale = UNITS.get(placed.objective.unit, ("", 1.0))
    return f"{value * scale:.4g} {word}".strip()


def pose_text(six: Array) -> str:
    shift, turn = poses(six)
    return f"shift ({shift}) mm, turn ({turn}) deg"


def poses(six: Array) -> tuple[str, str]:
    """Shift and turns as text."""
    turns = np.degrees(six[3:])
    return " ".join(_short(v, 3) for v in six[:3]), " ".join(_short(v, 3) for v in turns)


def _short(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def changes(placed: PlacementResult) -> list[tuple[str, str, list[tuple[str, float, float]], float]]:
    """Return, per characteristic that counts, name, unit, (influence, u present, u best) by size of change, u^2 at present."""
    out = []
    if placed.before is None:
        return []
    for before, after in zip(placed.before.characteristics, placed.after.characteristics):
        if not placed.objective.weights[after.name]:
            continue
        old = {b.input: b.u for b in before.budget}
        lines = [(b.input, old.get(b.input, 0.0), b.u) for b in after.budget]
        lines = [x for x in lines if max(x[1], x[2]) > 1e-4 * after.u]  # the rest is rounding
        lines.sort(key=lambda line: -abs(line[2] ** 2 - line[1] ** 2))
        out.append((after.name, after.unit, lines, before.u**2))
    return out


class HasRegion(Protocol):
    """A placement, of a part that is measured or cut."""

    @property
    def region(self) -> Region: ...


def region_text(placed: HasRegion) -> str:
    """Return the region within 2 % in words."""
    flat = placed.region
    ranges = [f"{n} {format_freedom(n, a)} to {format_freedom(n, b)}" for n, (a, b) in flat.box.items()]
    whole = f"{flat.share:.1%} of the poses of the fixture lie within {flat.within:.0%} of the value found"
    if not ranges:
        return whole
    if not flat.pose_count:
        return f"{whole}; no box around the pose found stays within it"
    return f"{whole}; all {flat.pose_count} poses tried in the box " + ", ".join(ranges) + " do"


def goal_text(goal: Any) -> str:
    """Return the objective in words."""
    kinds = " + ".join(f"{v:g} {k}" if v != 1 else str(k) for k, v in goal.mixture.items() if v)
    parts = ", ".join(f"{w:.3g} {n}" for n, w in goal.weights.items() if w)
    return f"{kinds} over {parts}"
