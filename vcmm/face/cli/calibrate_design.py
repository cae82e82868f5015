"""vcmm calibrate --design: what planned set-ups identify, and which to take."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def design_command(path: Path, json: bool) -> int:
    """What the set-ups of a plan identify together, the best of them within the budget, the cheapest complete ones."""
    from vcmm.face.cli.calibrate_poses import poses_command
    from vcmm.files.own.design import load_design
    from vcmm.learn.calibration.design import PlannedSetup, best_within, cheapest_complete, plan_of, proposal
    from vcmm.learn.calibration.pose_design import is_pose_design
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.terminal import show_answers, show_table
    from vcmm.show.tables.answers_runs import design_answers
    from vcmm.show.tables.calibration import setups

    made, machine, budget = load_design(path)
    setups_made = [PlannedSetup(*one) for one in made]
    if is_pose_design(setups_made):
        return poses_command(path, setups_made, machine, budget, json)
    with about(path, "setups"):
        plan = plan_of(setups_made, machine)
    everything = proposal(plan, range(len(plan.names)))
    best = None if budget is None else proposal(plan, best_within(plan, budget))
    complete = cheapest_complete(plan)
    cheapest = None if complete is None else proposal(plan, complete)
    body = {
        "setups": len(plan.names),
        "all": _only(everything),
        "budget_minutes": budget,
        "best_within_budget": None if best is None else _only(best),
        "cheapest_complete": None if cheapest is None else _only(cheapest),
    }
    content = document("vcmm.design/1", body, seed=0, files=sources(path))
    if json:
        print_json(content)
    else:
        chosen = (
            ("all", everything),
            ("best within the budget", best),
            ("cheapest that is complete", cheapest),
        )
        show_answers(design_answers(everything, best, cheapest))
        show_table(setups([(what, one) for what, one in chosen if one is not None]))
        for c in everything.identified.combinations:
            print(f"not identified, even by all: {c.text}")
    return int(bool(everything.identified.combinations))


def _only(proposal: Any) -> dict[str, Any]:
    """The record of one proposal."""
    from vcmm.show.tables.calibration import PROPOSALS
    from vcmm.show.tables.table import records

    (record,) = records(PROPOSALS, [proposal])
    return record
