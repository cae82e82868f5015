"""The page of a comparison of routes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vcmm import __version__
from vcmm.show.pages.header import facts
from vcmm.show.report import blocks as r
from vcmm.show.tables.answers import routes_answers
from vcmm.show.tables.routes import agreements_table, contributions_table, routes_table
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from vcmm.answer.routes.job import RoutesResult
    from vcmm.task.measuring.scenario import Scenario


def routes_page(scenario: Scenario, compared: RoutesResult) -> str:
    """Return one self-contained HTML file."""
    verdict = (
        "All routes agree." if compared.agree else "Not all routes agree: at least one |E_n| is above 1."
    )
    notes = [
        *compared.remarks,
        *(f"{c.name}, {e.route}: {t}" for c in compared.characteristics for e in c.routes for t in e.remarks),
    ]
    blocks = [r.note(verdict, "info" if compared.agree else "warning")]
    blocks += [r.heading("By every route"), html(routes_table(compared))]
    blocks += [r.heading("Agreement"), html(agreements_table(compared))]
    blocks += [r.heading("What the uncertainties are made of"), html(contributions_table(compared))]
    blocks += r.notices(notes)
    how = (
        "Everything was measured on one drawn machine; the routes do not know it."
        if compared.simulated
        else ""
    )
    footer = f"vcmm {__version__}, seed {compared.seed}. {how}"
    return r.page(
        f"Routes to one result: {scenario.name}",
        blocks,
        footer=footer,
        answers=routes_answers(compared),
        facts=facts("", scenario.machine.name, scenario.record, compared.seed),
    )
