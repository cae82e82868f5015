"""The report of the placement twin: ranking beside the paper's, the pose found, how few nodes suffice."""

from __future__ import annotations

from collections.abc import Sequence

from vcmm import __version__
from vcmm import report as r
from vcmm.measuring.scenario import Scenario
from vcmm.pages.place import maps
from vcmm.papers.gaska2014.page import overview
from vcmm.papers.gaska2014.placement import Optimum, Ranking, Reduction
from vcmm.papers.gaska2014.twin import PAPER_DISTANCE_U, PAPER_FORM_U
from vcmm.placing.tables import pose_text

FIELDS = {"touch": "interpolated standard deviations", "run": "correlated field"}
CAUTION = (
    "The five places, the part, the plan and 44 of 52 nodes are drawn, because the paper does not give them: the shares say "
    "how far its published figures alone fix the ranking, not whether the authors were right. Independent draws at the "
    "nodes are not interpolated here: that shrinks the variance between the nodes, and an optimiser would run there."
)


def placement_page(
    scenario: Scenario,
    rankings: Sequence[Ranking],
    optima: Sequence[Optimum],
    reductions: Sequence[Reduction],
    draws: int,
) -> str:
    """One self-contained HTML file."""
    blocks = [r.note(CAUTION, "warning"), r.heading("Which of the five places is best")]
    columns = [
        "field per",
        "place",
        "by form",
        "by distance",
        "by both",
        "paper: U form / µm",
        "paper: U distance / µm",
    ]
    caption = f"Share of {draws} machines that agree with the published maxima and means."
    blocks.append(r.table(columns, ranking_rows(rankings), numeric=(2, 3, 4, 5, 6), caption=caption))
    blocks.append(r.heading("The pose found, probe errors included"))
    columns = ["field", "pose", "U / µm", "best of the five", "its U / µm", "saved", "certificate"]
    blocks.append(
        r.table(columns, optimum_rows(optima), numeric=(2, 4, 5), caption="U: mean of form and distance.")
    )
    for one in optima:
        blocks += [r.heading(f"Over the table: {FIELDS[one.redraw]}"), *maps(one.found)]
    blocks.append(r.heading("How few reference points still give the right place"))
    columns = ["nodes", "loss, median", "loss, 95 %", "within 2 % of the right place"]
    caption = "Loss: U of the distance at the place chosen with fewer nodes against the best place, judged with all 52."
    blocks.append(r.table(columns, node_rows(reductions), numeric=(0, 1, 2, 3), caption=caption))
    blocks += [r.heading("Machine, nodes and the five places"), overview(scenario)]
    return r.page(
        "Gąska 2014: the place that the program finds",
        blocks,
        subtitle=scenario.machine.name,
        footer=f"vcmm {__version__}.",
    )


def ranking_rows(rankings: Sequence[Ranking]) -> list[list[str]]:
    """One line per place and redraw rule, then the share in which 3 and 5 are the best two."""
    rows = []
    for one in rankings:
        for name, shares in one.shares().items():
            paper = [f"{PAPER_FORM_U[name]:.1f}", f"{PAPER_DISTANCE_U[name]:.1f}"]
            rows.append([one.redraw, name, *(f"{s:.0%}" for s in shares), *paper])
        rows.append([one.redraw, "3 and 5 best two", *(f"{s:.0%}" for s in one.both_best()), "", ""])
    return rows


def optimum_rows(optima: Sequence[Optimum]) -> list[list[str]]:
    rows = []
    for one in optima:
        best = min(one.places, key=lambda n: one.places[n])
        value, other = one.found.best.value, one.places[best]
        rows.append(
            [
                FIELDS[one.redraw], pose_text(one.found.best.pose), f"{value * 1e3:.3f}", best, f"{other * 1e3:.3f}",
                f"{1 - value / other:.1%}", one.found.certificate.text,
            ]
        )  # fmt: skip
    return rows


def node_rows(reductions: Sequence[Reduction]) -> list[list[str]]:
    return [[str(x.nodes), f"{x.median:.1%}", f"{x.worst:.1%}", f"{x.right:.0%}"] for x in reductions]
