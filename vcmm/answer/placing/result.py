"""Results of a placement as frozen values, and the body of its JSON document."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.answer.evaluation.result import UncertaintyResult
from vcmm.answer.placing.certificate import Certificate
from vcmm.answer.placing.confirmation import Confirmation
from vcmm.answer.placing.hindrances import Hindrance
from vcmm.answer.placing.near_best import Map, Region
from vcmm.answer.placing.objective import Uncertain
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import Array
from vcmm.core.views import draw

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class At:
    """A pose (6: mm and rad), the value of the objective there, u and U of the characteristics (C,), mm or rad."""

    pose: Array
    value: float
    u: Array
    expanded: Array


@dataclass(frozen=True, eq=False)
class PlacementResult(Readable):
    """The outcome. present: None where the present pose cannot be used; `problems` say why.

    before, after: the full evaluation at the present and the best pose (budgets, decisions). median and worst are those
    of the scan, sampled evenly over the fixture.
    """

    objective: Uncertain
    label: str  # the discrete choices of the best pose
    best: At
    present: At | None
    problems: tuple[Hindrance, ...]
    median: At
    worst: At
    minima: tuple[tuple[float, Array], ...]
    evaluations: int
    feasible_share: float
    certificate: Certificate
    map: Map
    region: Region
    confirmation: Confirmation | None
    before: UncertaintyResult | None
    after: UncertaintyResult
    seed: int
    warnings: tuple[str, ...]
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        shift = ", ".join(f"{v:.1f}" for v in self.best.pose[:3])
        gain = "" if self.gain is None else f", {self.gain:.1%} below the present pose"
        return f"<Placed: shift ({shift}) mm, objective {self.best.value:.4g}{gain}>"

    def plot(self, ax: Any = None) -> Axes:
        """Plot the objective over the two degrees of freedom that matter most, the others at the best pose."""
        drawn: Axes = draw(self, ax)
        return drawn

    @property
    def gain(self) -> float | None:
        """Share of the present value that the best pose saves."""
        if self.present is None or not self.present.value:
            return None
        return (self.present.value - self.best.value) / self.present.value


def place_json(placed: PlacementResult) -> dict[str, Any]:
    """Return the body of the JSON document."""
    objective, certificate, flat = placed.objective, placed.certificate, placed.region
    sure = placed.confirmation
    return {
        "pose": pose_json(placed.best.pose),
        "choice": placed.label,
        "objective": {
            "kind": dict(objective.goal.mixture), "unit": objective.unit, "weights": dict(objective.goal.weights),
            "costs": dict(objective.goal.costs), "value": placed.best.value, "characteristics": _spread(placed, placed.best),
        },
        "present": None if placed.present is None else at_json(placed, placed.present) | {"gain": placed.gain},
        "problems": [{"name": p.name, "constraint": p.constraint, "point": p.point, f"amount_{p.unit}": p.amount} for p in placed.problems],
        "median": at_json(placed, placed.median),
        "worst": at_json(placed, placed.worst),
        "certificate": {
            "method": certificate.method, "text": certificate.text, "scanned": certificate.scan_count, "better": certificate.better,
            "earlier": certificate.earlier, "hidden": certificate.hidden_gain if certificate.hidden_gain < 1.0 else None, "floor": certificate.floor, "spacing": certificate.spacing,
        },
        "search": {
            "evaluations": placed.evaluations, "feasible_share": placed.feasible_share,
            "minima": [{"value": v, "pose": pose_json(p)} for v, p in placed.minima],
        },
        "confirmation": None if sure is None else {
            "seed": sure.seed, "trials": sure.trials, "present": sure.present, "best": sure.best, "gain": sure.gain,
            "u_gain": sure.u_gain, "confirmed": sure.is_confirmed,
        },
        "flat": {
            "within": flat.within, "share": flat.share, "box": {freedom_key(n): list(r) for n, r in flat.box.items()}, "checked": flat.pose_count,
            "convenient": None if flat.convenient is None else {"pose": pose_json(flat.convenient), "value": flat.convenient_value},
        },
        "why": why_json(placed),
        "map": map_json(placed.map),
    }  # fmt: skip


def freedom_key(freedom: str) -> str:
    """Return the key of a degree of freedom with its unit."""
    return f"{freedom}_rad" if freedom.startswith("turn") else f"{freedom}_mm"


def pose_json(six: Array) -> dict[str, Any]:
    """Return a pose; shift after turns about the fixed x, then y, then z."""
    return {
        "shift_mm": [float(v) for v in six[:3]],
        "turn_rad": [float(v) for v in six[3:]],
        "turn_deg": [float(v) for v in np.degrees(six[3:])],
    }


def at_json(placed: PlacementResult, at: At) -> dict[str, Any]:
    return {"pose": pose_json(at.pose), "value": at.value, "characteristics": _spread(placed, at)}


def _spread(placed: PlacementResult, at: At) -> list[dict[str, Any]]:
    """Return u and U of the characteristics that count: by the full evaluation where there is one, beside the values of the search."""
    from vcmm.part.gps.characteristics import unit

    whole = placed.after if at is placed.best else placed.before if at is placed.present else None
    full = {} if whole is None else {c.name: c for c in whole.characteristics}
    out = []
    for i, c in enumerate(placed.objective.characteristics):
        if not placed.objective.weights[c.name]:
            continue
        word, figures = unit(c), (float(at.u[i]), float(at.expanded[i]))
        u, expanded = (full[c.name].u, full[c.name].expanded) if c.name in full else figures
        out.append({
            "name": c.name, f"u_{word}": u, f"U_{word}": expanded, "evaluation": "full" if c.name in full else "search",
            f"u_search_{word}": figures[0], f"U_search_{word}": figures[1],
        })  # fmt: skip
    return out


def why_json(placed: PlacementResult) -> list[dict[str, Any]]:
    """Return contributions of the influences at the present and the best pose, by the full evaluation."""
    out = []
    for k, after in enumerate(placed.after.characteristics):
        before = placed.before.characteristics[k] if placed.before else None
        old = {b.input: b.u for b in before.budget} if before else {}
        unit = after.unit
        budget = [
            {"input": b.input, f"u_present_{unit}": old.get(b.input), f"u_best_{unit}": b.u}
            for b in after.budget
        ]
        row = {
            "name": after.name,
            f"U_present_{unit}": before.expanded if before else None,
            f"U_best_{unit}": after.expanded,
        }
        out.append(row | {"budget": budget})
    return out


def map_json(chart: Map) -> dict[str, Any]:
    """Return the map; null where the fixture or a constraint does not allow a pose."""
    values = [[float(v) if np.isfinite(v) else None for v in row] for row in chart.values]
    names = [freedom_key(n) for n in chart.names]
    axes = {n: [float(v) for v in a] for n, a in zip(names, (chart.x, chart.y))}
    return {"over": names, **axes, "objective": values}
