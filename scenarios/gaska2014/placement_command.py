"""vcmm place gaska2014: the placement that the authors of the paper asked for, beside their ranking."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from vcmm import Scenario
from vcmm import placement as placing
from vcmm import tables as tb

from . import placement_page as page
from .placement import NodeReduction, Optimum, Ranking, optimum, ranking, reduction


@dataclass(frozen=True, eq=False)
class PlacementStudy:
    """The answers to the three questions of `placement`, over `draws` machines."""

    scenario: Scenario
    draws: int
    rankings: Sequence[Ranking]
    optima: Sequence[Optimum]
    reductions: Sequence[NodeReduction]

    def tables(self) -> list[tb.ResultTable[Any]]:
        """Ranking, optimum and node reduction."""
        return [
            page.ranking_table(self.rankings, self.draws),
            page.optimum_table(self.optima),
            page.node_table(self.reductions),
        ]

    def html(self) -> str:
        """The report as HTML."""
        return page.placement_page(self.scenario, self.rankings, self.optima, self.reductions, self.draws)

    def body(self) -> dict[str, Any]:
        """The document: that of the placement on the correlated field, and what the twin adds."""
        run = next(o for o in self.optima if o.redraw == "run")
        twin = {
            "draws": self.draws,
            "ranking": [_ranking_body(r) for r in self.rankings],
            "optimum": [_optimum_body(o) for o in self.optima],
            "nodes": [_nodes_body(r) for r in self.reductions],
        }
        return placing.place_json(run.found) | {"twin": twin}


def study(
    scenario: Scenario, draws: int, options: dict[str, Any], report: Callable[[str, float], None]
) -> PlacementStudy:
    """Rank the places, find the best pose and reduce the nodes. options: seed, evaluations, scanned, trials of `optimum`."""
    rankings = ranking(scenario, draws, report)
    reductions = reduction(scenario, min(draws, 100), seed=options.get("seed", 1), progress=report)
    optima = [optimum(scenario, redraw, report, **options) for redraw in ("touch", "run")]
    return PlacementStudy(scenario, draws, rankings, optima, reductions)


def _ranking_body(r: Ranking) -> dict[str, Any]:
    names = ("form", "distance", "both")
    return {
        "redraw": r.redraw,
        "best": {name: dict(zip(names, shares)) for name, shares in r.shares().items()},
        "3_and_5_best": dict(zip(names, r.both_best())),
    }


def _optimum_body(o: Optimum) -> dict[str, Any]:
    return {
        "redraw": o.redraw,
        "pose": placing.pose_json(o.found.best.pose),
        "value": o.found.best.value,
        "places": o.places,
        "better_on_others": o.better,
        "saved_on_others": o.saved,
    }


def _nodes_body(r: NodeReduction) -> dict[str, Any]:
    return {
        "nodes": r.nodes,
        "picked": r.picked,
        "loss_median": r.median,
        "loss_95": r.worst,
        "right_place": r.right,
    }
