"""vcmm place gaska2014: the placement that the authors of the paper asked for, beside their ranking."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def show_placement(folder: Path | None, draws: int, options: dict[str, Any], json: bool) -> int:
    """Ranking, optimum and node reduction: tables, JSON, report. options: seed, evaluations, scanned, trials of `optimum`."""
    from vcmm.files.own.library import example
    from vcmm.files.own.scenario import load_scenario
    from . import placement as twin
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import progress, say

    source = example("gaska2014")
    scenario = load_scenario(source)
    with progress() as report:
        rankings = twin.ranking(scenario, draws, report)
        reductions = twin.reduction(scenario, min(draws, 100), seed=options.get("seed", 1), progress=report)
        optima = [twin.optimum(scenario, redraw, report, **options) for redraw in ("touch", "run")]
    seed = options.get("seed", scenario.settings.seed)
    content = document("vcmm.place/1", body(rankings, optima, reductions, draws), seed=seed, files=[source])
    if folder:
        from .placement_page import placement_page

        texts = {
            "place.json": json_text(content),
            "report.html": placement_page(scenario, rankings, optima, reductions, draws),
        }
        write_files(folder, texts)
        say(f"wrote {folder}/report.html, place.json")
    if json:
        print_json(content)
    else:
        _show(rankings, optima, reductions, draws)
    return 0


def body(rankings: Any, optima: Any, reductions: Any, draws: int) -> dict[str, Any]:
    """The document: that of the placement on the correlated field, and what the twin adds."""
    from vcmm.answer.placing.result import place_json, pose_json

    run = next(o for o in optima if o.redraw == "run")
    twin = {
        "draws": draws,
        "ranking": [
            {
                "redraw": r.redraw,
                "best": {
                    name: dict(zip(("form", "distance", "both"), shares))
                    for name, shares in r.shares().items()
                },
                "3_and_5_best": dict(zip(("form", "distance", "both"), r.both_best())),
            }
            for r in rankings
        ],
        "optimum": [
            {
                "redraw": o.redraw,
                "pose": pose_json(o.found.best.pose),
                "value": o.found.best.value,
                "places": o.places,
                "better_on_others": o.better,
                "saved_on_others": o.saved,
            }
            for o in optima
        ],
        "nodes": [
            {
                "nodes": r.nodes,
                "picked": r.picked,
                "loss_median": r.median,
                "loss_95": r.worst,
                "right_place": r.right,
            }
            for r in reductions
        ],
    }
    return place_json(run.found) | {"twin": twin}


def _show(rankings: Any, optima: Any, reductions: Any, draws: int) -> None:
    from .placement_page import node_table, optimum_table, ranking_table
    from vcmm.show.console.terminal import show_table

    show_table(ranking_table(rankings, draws))
    show_table(optimum_table(optima))
    show_table(node_table(reductions))
