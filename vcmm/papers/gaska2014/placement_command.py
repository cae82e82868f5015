"""vcmm place gaska2014: the placement that the authors of the paper asked for, beside their ranking."""

from __future__ import annotations

from pathlib import Path
from typing import Any

CAPTION = (
    "Places are drawn (the paper shows photographs only), so no agreement can be claimed. Table 3 of the paper has places 5 and 3 "
    "in front; share: of machines that agree with the published maxima and means."
)


def show_placement(folder: Path | None, draws: int, options: dict[str, Any], json: bool) -> int:
    """Ranking, optimum and node reduction: tables, JSON, report. options: seed, evaluations, scanned, trials of `optimum`."""
    from vcmm.console.common import document, print_json, progress, say, write_files
    from vcmm.files.scenario import load_scenario
    from vcmm.library import path
    from vcmm.papers.gaska2014 import placement as twin

    source = path("gaska2014")
    scenario = load_scenario(source)
    with progress() as report:
        rankings = twin.ranking(scenario, draws, report)
        reductions = twin.reduction(scenario, min(draws, 100), seed=options.get("seed", 1), progress=report)
        optima = [twin.optimum(scenario, redraw, report, **options) for redraw in ("touch", "run")]
    seed = options.get("seed", scenario.settings.seed)
    content = document("vcmm.place/1", body(rankings, optima, reductions, draws), seed=seed, files=[source])
    if folder:
        import json as _json

        from vcmm.papers.gaska2014.placement_page import placement_page

        texts = {
            "place.json": _json.dumps(content, indent=1, allow_nan=False),
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
    from vcmm.placing.result import place_json, pose_json

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
            }
            for o in optima
        ],
        "nodes": [
            {"nodes": r.nodes, "loss_median": r.median, "loss_95": r.worst, "right_place": r.right}
            for r in reductions
        ],
    }
    return place_json(run.found) | {"twin": twin}


def _show(rankings: Any, optima: Any, reductions: Any, draws: int) -> None:
    from vcmm.console.common import show_table
    from vcmm.papers.gaska2014.placement_page import node_rows, optimum_rows, ranking_rows

    show_table(
        f"which of the five places is best, over {draws} machines",
        ["field per", "place", "by form", "by distance", "by both", "paper U form um", "paper U distance um"],
        ranking_rows(rankings), left=(0, 1), caption=CAPTION,
    )  # fmt: skip
    show_table(
        "the pose found, probe errors included (mean of U of form and distance)",
        ["field", "pose", "U um", "best of the five", "its U um", "saved", "certificate"],
        optimum_rows(optima), left=(0, 1, 6),
    )  # fmt: skip
    show_table(
        "how few reference points still give the right place (distance, interpolated standard deviations)",
        ["nodes", "loss, median", "loss, 95 %", "within 2 % of the right place"], node_rows(reductions),
    )  # fmt: skip
