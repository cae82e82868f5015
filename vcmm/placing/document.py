"""The JSON document of a placement."""

from __future__ import annotations

from typing import Any


def place_json(found: Any) -> dict[str, Any]:
    """The body of the JSON document."""
    objective, certificate, flat = found.objective, found.certificate, found.region
    sure = found.confirmation
    return {
        "pose": pose_json(found.best.pose),
        "choice": found.label,
        "objective": {
            "kind": dict(objective.goal.mixture), "unit": objective.unit, "weights": dict(objective.goal.weights),
            "costs": dict(objective.goal.costs), "value": found.best.value, "characteristics": _spread(found, found.best),
        },
        "present": None if found.present is None else at_json(found, found.present) | {"gain": found.gain},
        "problems": [{"name": p.name, "constraint": p.constraint, "point": p.point, f"amount_{getattr(p, 'unit', 'mm')}": p.amount} for p in found.problems],
        "median": at_json(found, found.median),
        "worst": at_json(found, found.worst),
        "certificate": {
            "method": certificate.method, "text": certificate.text, "scanned": certificate.scanned, "better": certificate.better,
            "earlier": certificate.earlier, "hidden": certificate.hidden, "floor": certificate.floor, "spacing": certificate.spacing,
        },
        "search": {
            "evaluations": found.evaluations, "feasible_share": found.feasible_share,
            "minima": [{"value": v, "pose": pose_json(p)} for v, p in found.minima],
        },
        "confirmation": None if sure is None else {
            "seed": sure.seed, "trials": sure.trials, "present": sure.present, "best": sure.best, "gain": sure.gain,
            "u_gain": sure.u_gain, "confirmed": sure.confirmed,
        },
        "flat": {
            "within": flat.within, "share": flat.share, "box": {named(n): list(r) for n, r in flat.box.items()}, "checked": flat.checked,
            "convenient": None if flat.convenient is None else {"pose": pose_json(flat.convenient), "value": flat.convenient_value},
        },
        "why": why_json(found),
        "map": map_json(found.map),
    }  # fmt: skip


def named(freedom: str) -> str:
    """Key of a degree of freedom with its unit."""
    return f"{freedom}_rad" if freedom.startswith("turn") else f"{freedom}_mm"


def pose_json(six: Any) -> dict[str, Any]:
    """A pose; shift after turns about the fixed x, then y, then z."""
    import numpy as np

    return {
        "shift_mm": [float(v) for v in six[:3]],
        "turn_rad": [float(v) for v in six[3:]],
        "turn_deg": [float(v) for v in np.degrees(six[3:])],
    }


def at_json(found: Any, at: Any) -> dict[str, Any]:
    return {"pose": pose_json(at.pose), "value": at.value, "characteristics": _spread(found, at)}


def _spread(found: Any, at: Any) -> list[dict[str, Any]]:
    """u and U of the characteristics that count, as the search saw them."""
    from vcmm.gps.characteristics import unit

    out = []
    for i, c in enumerate(found.objective.characteristics):
        if found.objective.weights[c.name]:
            out.append(
                {"name": c.name, f"u_{unit(c)}": float(at.u[i]), f"U_{unit(c)}": float(at.expanded[i])}
            )
    return out


def why_json(found: Any) -> list[dict[str, Any]]:
    """Contributions of the influences at the present and the best pose, by the full evaluation."""
    out = []
    for k, after in enumerate(found.after.characteristics):
        before = found.before.characteristics[k] if found.before else None
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


def map_json(chart: Any) -> dict[str, Any]:
    """The map; null where the fixture or a constraint does not allow a pose."""
    import numpy as np

    values = [[float(v) if np.isfinite(v) else None for v in row] for row in chart.values]
    names = [named(n) for n in chart.names]
    axes = {n: [float(v) for v in a] for n, a in zip(names, (chart.x, chart.y))}
    return {"over": names, **axes, "objective": values}
