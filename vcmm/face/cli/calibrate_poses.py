"""vcmm calibrate design of a touch probe: which rotary positions, and what they are expected to tell."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def poses_command(path: Path, setups: Any, machine: Any, budget: float | None, json: bool) -> int:
    """The rotary positions to touch at, with the standard uncertainty expected of every error; 1 where even all leave one open."""
    from vcmm.learn.calibration.pose_design import best_poses, pose_plan
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources

    with about(path, "setups"):
        plan = pose_plan(setups, machine)
        chosen = best_poses(plan, budget)
    everything = list(range(len(plan.candidates)))
    body = {
        "setups": len(setups),
        "all": _record(plan, everything),
        "budget_minutes": budget,
        "best_within_budget": None if budget is None else _record(plan, chosen),
        "cheapest_complete": _record(plan, chosen) if budget is None else None,
        "poses": [_pose(plan.candidates[i]) for i in in_order_of_angles(plan, chosen)],
        "expected": _expected_uncertainties(plan, chosen, everything),
        "correlated": [{"errors": [a, b], "correlation": r} for a, b, r in plan.correlated(chosen)],
    }
    if json:
        print_json(document("vcmm.design/1", body, seed=0, files=sources(path)))
    else:
        _show(plan, chosen, everything, body)
    return int(bool(plan.identified(everything).combinations))


def in_order_of_angles(plan: Any, chosen: list[int]) -> list[int]:
    """The poses by their angles, the first rotary axis of the chain first, so that it moves least."""
    return sorted(chosen, key=lambda i: (plan.candidates[i].setup, tuple(plan.candidates[i].angles.values())))


def _record(plan: Any, chosen: list[int]) -> dict[str, Any]:
    found = plan.identified(chosen)
    return {
        "setups": list(dict.fromkeys(plan.candidates[i].setup for i in chosen)),
        "poses": len(chosen),
        "touches": sum(plan.candidates[i].touches for i in chosen),
        "minutes": plan.minutes(chosen),
        "volume_um": plan.volume(chosen) * 1e3,
        "identified": list(found.names),
        "not_identified": found.document(),
        "condition": found.condition,
    }


def _pose(candidate: Any) -> dict[str, Any]:
    from math import degrees

    angles = {f"{a}_deg": round(degrees(q), 6) for a, q in candidate.angles.items()}
    return {"setup": candidate.setup, **angles, "touches": candidate.touches, "minutes": candidate.minutes}


def _expected_uncertainties(plan: Any, chosen: list[int], everything: list[int]) -> list[dict[str, Any]]:
    """Per error its u by the chosen poses, and by all."""
    from vcmm.learn.calibration.pose_design import unit_of

    here, best = plan.expected(chosen), plan.expected(everything)
    return [
        {"error": n, "unit": unit_of(n)[0], "u": u * unit_of(n)[1], "u_all_poses": best[n] * unit_of(n)[1]}
        for n, u in here.items()
    ]


def _show(plan: Any, chosen: list[int], everything: list[int], body: dict[str, Any]) -> None:
    from vcmm.show.console.terminal import show_table
    from vcmm.show.tables.table import listing

    rows = [
        (
            what,
            str(len(some)),
            str(sum(plan.candidates[i].touches for i in some)),
            f"{plan.minutes(some):.3g}",
            f"{plan.volume(some) * 1e3:.3g}",
        )
        for what, some in (("chosen", chosen), ("all of the plan", everything))
    ]
    show_table(listing("poses", ("", "poses", "touches", "minutes", "left over the volume / um"), rows))
    angles = [k for k in body["poses"][0] if k.endswith("_deg")]
    steps = [(str(k + 1), *(f"{one[a]:g}" for a in angles)) for k, one in enumerate(body["poses"])]
    show_table(
        listing(
            "rotary positions, in this order", ("", *(a.replace("_deg", " / deg") for a in angles)), steps
        )
    )
    said = [
        (e["error"], f"{e['u']:.2g} {e['unit']}", f"{e['u_all_poses']:.2g} {e['unit']}")
        for e in body["expected"]
    ]
    show_table(listing("u expected", ("error", "chosen", "all of the plan"), said))
    for c in plan.identified(everything).combinations:
        print(f"not identified, even by all: {c.text}")
    for one in body["correlated"]:
        print(f"{' and '.join(one['errors'])} depend on one another: correlation {one['correlation']:.2f}")
