"""The report of the placement twin: ranking beside the paper's, the pose found, how few nodes suffice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from vcmm import Scenario, __version__, placement
from vcmm import report as r
from vcmm import tables as tb

from .page import overview
from .placement import OTHERS, NodeReduction, Optimum, Ranking
from .readings import PAPER_DISTANCE_U, PAPER_FORM_U

FIELDS = {"touch": "interpolated standard deviations", "run": "correlated field"}
CAUTION = (
    "The five places, the part, the plan and 44 of 52 nodes are drawn, because the paper does not give them: the shares say "
    "how far its published figures alone fix the ranking, not whether the authors were right. Independent draws at the "
    "nodes are not interpolated here: that shrinks the variance between the nodes, and an optimiser would run there."
)


CAPTION = (
    "Places are drawn (the paper shows photographs only), so no agreement can be claimed. Table 3 of the paper has places 5 and 3 "
    "in front; share: of machines that agree with the published maxima and means."
)


def placement_page(
    scenario: Scenario,
    rankings: Sequence[Ranking],
    optima: Sequence[Optimum],
    reductions: Sequence[NodeReduction],
    draws: int,
) -> str:
    """One self-contained HTML file."""
    blocks = [r.note(CAUTION, "warning"), r.heading("Which of the five places is best")]
    blocks.append(tb.html(ranking_table(rankings, draws)))
    blocks.append(r.heading("The pose found, probe errors included"))
    blocks.append(tb.html(optimum_table(optima)))
    for one in optima:
        blocks += [r.heading(f"Over the table: {FIELDS[one.redraw]}"), *placement.maps(one.found)]
    blocks.append(r.heading("How few reference points still give the right place"))
    blocks.append(tb.html(node_table(reductions)))
    blocks += [r.heading("Machine, nodes and the five places"), overview(scenario)]
    return r.page(
        "Gąska 2014: the place that the program finds",
        blocks,
        subtitle=scenario.machine.name,
        footer=f"vcmm {__version__}.",
    )


@dataclass(frozen=True)
class RankedPlace:
    """Shares of the machines in which a place (or a pair) is best by form, distance and both; the paper's U, um."""

    redraw: str
    name: str
    shares: tuple[float, float, float]
    paper: tuple[str, str] = ("", "")


def _share(index: int, place: RankedPlace) -> float:
    return place.shares[index]


RANKING: tuple[tb.Column[RankedPlace], ...] = (
    tb.Column("field per", lambda p: p.redraw),
    tb.Column("place", lambda p: p.name),
    *(
        tb.Column(f"by {what}", partial(_share, i), tb.percent(0))
        for i, what in enumerate(("form", "distance", "both"))
    ),
    tb.Column("paper U form um", lambda p: p.paper[0], tb.NUMBER_TEXT, page_head="paper: U form / µm"),
    tb.Column(
        "paper U distance um", lambda p: p.paper[1], tb.NUMBER_TEXT, page_head="paper: U distance / µm"
    ),
)


def ranking_table(rankings: Sequence[Ranking], draws: int) -> tb.ResultTable[RankedPlace]:
    """One line per place and redraw rule, then the share in which 3 and 5 are the best two."""
    rows = []
    for one in rankings:
        for name, shares in one.shares().items():
            paper = f"{PAPER_FORM_U[name]:.1f}", f"{PAPER_DISTANCE_U[name]:.1f}"
            rows.append(RankedPlace(one.redraw, name, shares, paper))
        rows.append(RankedPlace(one.redraw, "3 and 5 best two", one.both_best()))
    title = f"which of the five places is best, over {draws} machines"
    on_page = f"Share of {draws} machines that agree with the published maxima and means."
    return tb.ResultTable(title, RANKING, rows, CAPTION, on_page)


def best_place(one: Optimum) -> str:
    """The best of the paper's five places."""
    return min(one.places, key=lambda name: one.places[name])


UM = tb.fixed(3, scale=1e3)
OPTIMA: tuple[tb.Column[Optimum], ...] = (
    tb.Column("field", lambda o: FIELDS[o.redraw]),
    tb.Column("pose", lambda o: placement.pose_text(o.found.best.pose)),
    tb.Column("U um", lambda o: o.found.best.value, UM, page_head="U / µm"),
    tb.Column("best of the five", best_place, tb.NUMBER_TEXT),
    tb.Column("its U um", lambda o: o.places[best_place(o)], UM, page_head="its U / µm"),
    tb.Column("saved", lambda o: 1 - o.found.best.value / o.places[best_place(o)], tb.percent(1)),
    tb.Column("better on others", lambda o: o.better, tb.percent(0)),
    tb.Column("saved there", lambda o: o.saved, tb.percent(1)),
    tb.Column("certificate", lambda o: o.found.certificate.text),
)


def optimum_table(optima: Sequence[Optimum]) -> tb.ResultTable[Optimum]:
    title = "the pose found, probe errors included (mean of U of form and distance)"
    caption = (
        f"Found on the machine that is shown. better on others: share of {OTHERS} other machines on which this pose beats the best of the five; saved "
        "there: median of U saved."
    )
    return tb.ResultTable(title, OPTIMA, optima, caption, f"U: mean of form and distance. {caption}")


NODES: tuple[tb.Column[NodeReduction], ...] = (
    tb.Column("nodes", lambda x: x.nodes, tb.NUMBER_TEXT),
    tb.Column("picked", lambda x: x.picked),
    tb.Column("loss, median", lambda x: x.median, tb.percent(1)),
    tb.Column("loss, 95 %", lambda x: x.worst, tb.percent(1)),
    tb.Column("within 2 % of the right place", lambda x: x.right, tb.percent(0)),
)


def node_table(reductions: Sequence[NodeReduction]) -> tb.ResultTable[NodeReduction]:
    title = "how few reference points still give the right place (distance, interpolated standard deviations)"
    caption = (
        "Loss: U of the distance at the place chosen with fewer nodes against the best place, judged with all 52. optimised: one subset for all "
        "machines, found on others than those counted."
    )
    return tb.ResultTable(title, NODES, reductions, page_caption=caption)
