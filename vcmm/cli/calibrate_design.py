"""vcmm calibrate --design: what planned set-ups identify, and which to take."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def design_command(path: Path, json: bool) -> int:
    """What the set-ups of a plan identify together, the best of them within the budget, the cheapest complete ones."""
    from vcmm.calibrating.design import Setup, best_within, cheapest_complete, plan_of, proposal
    from vcmm.console.documents import document, print_json, sources
    from vcmm.files.design import load_design

    made, machine, budget = load_design(path)
    plan = plan_of([Setup(*one) for one in made], machine)
    everything = proposal(plan, range(len(plan.names)))
    best = None if budget is None else proposal(plan, best_within(plan, budget))
    complete = cheapest_complete(plan)
    cheapest = None if complete is None else proposal(plan, complete)
    body = {
        "setups": len(plan.names),
        "all": _document(everything),
        "budget_minutes": budget,
        "best_within_budget": None if best is None else _document(best),
        "cheapest_complete": None if cheapest is None else _document(cheapest),
    }
    content = document("vcmm.design/1", body, seed=0, files=sources(path))
    if json:
        print_json(content)
    else:
        _show(everything, best, cheapest)
    return int(bool(everything.identified.combinations))


def _document(p: Any) -> dict[str, Any]:
    return {
        "setups": list(p.names),
        "minutes": p.minutes,
        "volume_um": p.volume_um,
        "identified": list(p.identified.names),
        "not_identified": [{"combination": list(c.names), "text": c.text} for c in p.identified.combinations],
        "condition": p.identified.condition,
    }


def _show(everything: Any, best: Any, cheapest: Any) -> None:
    from vcmm.console.terminal import show_table

    rows = []
    for title, one in (
        ("all", everything),
        ("best within the budget", best),
        ("cheapest that is complete", cheapest),
    ):
        if one is not None:
            count = f"{len(one.identified.names)} errors"
            rows.append(
                [title, f"{one.minutes:g} min", f"{one.volume_um:.2f} um", count, ", ".join(one.names)]
            )
    show_table(
        "set-ups",
        ["choice", "time", "u of the tip over the volume", "identified", "set-ups"],
        rows,
        left=(0, 4),
    )
    for c in everything.identified.combinations:
        print(f"not identified, even by all: {c.text}")
