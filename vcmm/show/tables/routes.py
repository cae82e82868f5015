"""Routes to one result as tables: the result of each, its distance from the truth where that is known, and E_n between them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from vcmm.show.tables.quantities import DEVIATION, LENGTH, SIZE, fixed
from vcmm.show.tables.table import WORDS, Column, ResultTable, entry, records

if TYPE_CHECKING:
    from vcmm.answer.routes.estimate import Contribution, RouteAgreement, RouteEstimate
    from vcmm.answer.routes.job import RoutedCharacteristic, RoutesResult


@dataclass(frozen=True)
class RouteRow:
    """One route of one characteristic."""

    of: RoutedCharacteristic
    route: RouteEstimate

    @property
    def unit(self) -> str:
        return self.of.unit


@dataclass(frozen=True)
class AgreementRow:
    """Two routes of one characteristic."""

    of: RoutedCharacteristic
    pair: RouteAgreement

    @property
    def unit(self) -> str:
        return self.of.unit


@dataclass(frozen=True)
class ContributionRow:
    """One contribution to one route."""

    row: RouteRow
    contribution: Contribution

    @property
    def unit(self) -> str:
        return self.row.unit


def _dof(dof: float) -> float | None:
    return None if dof == float("inf") else dof


CONTRIBUTIONS: tuple[Column[ContributionRow], ...] = (
    Column("characteristic", lambda r: r.row.of.name, csv="characteristic"),
    Column("route", lambda r: r.row.route.route, WORDS, csv="route"),
    Column("contribution", lambda r: r.contribution.name, WORDS, key="name", csv="contribution"),
    Column("u", lambda r: r.contribution.u, SIZE, key="u_{unit}", csv="u_{unit}", page_head="u / {small}"),
    Column("nu", lambda r: _dof(r.contribution.dof), fixed(0), key="dof", csv="dof"),
)

ROUTES: tuple[Column[RouteRow], ...] = (
    Column("characteristic", lambda r: r.of.name, csv="characteristic"),
    Column("route", lambda r: r.route.route, WORDS, key="route", csv="route"),
    Column("value", lambda r: r.route.value, LENGTH, key="value_{unit}", csv="value_{unit}", page_head="value / {large}"),
    Column("u", lambda r: r.route.u, SIZE, key="u_{unit}", csv="u_{unit}", page_head="u / {small}"),
    Column("k", lambda r: r.route.k, fixed(2), key="k", csv="k"),
    Column("U", lambda r: r.route.expanded, SIZE, key="U_{unit}", csv="U_{unit}", page_head="U / {small}"),
    entry("dof", lambda r: _dof(r.route.dof)),
    Column("(value - truth) / U", lambda r: r.of.error(r.route), fixed(2, signed=True), key="error_over_U", csv="error_over_U"),
    entry("contributions", lambda r: records(CONTRIBUTIONS, [ContributionRow(r, c) for c in r.route.contributions])),
    entry("remarks", lambda r: list(r.route.remarks)),
)  # fmt: skip

AGREEMENTS: tuple[Column[AgreementRow], ...] = (
    Column("characteristic", lambda r: r.of.name, csv="characteristic"),
    Column("routes", lambda r: f"{r.pair.first} - {r.pair.second}", WORDS),
    entry("between", lambda r: [r.pair.first, r.pair.second]),
    Column("difference", lambda r: r.pair.difference, DEVIATION, key="difference_{unit}", csv="difference_{unit}", page_head="difference / {small}"),
    Column("U of the difference", lambda r: r.pair.expanded, SIZE, key="U_difference_{unit}", csv="U_difference_{unit}", page_head="its U / {small}"),
    entry("covariance_{unit}2", lambda r: r.pair.covariance),
    Column("shared", lambda r: ", ".join(r.pair.common_inputs) or "nothing", WORDS),
    entry("shared", lambda r: list(r.pair.common_inputs)),
    Column("E_n", lambda r: r.pair.en, fixed(2, signed=True), key="E_n", csv="E_n"),
    Column("", lambda r: "agree" if r.pair.agrees else "do not agree", WORDS),
)  # fmt: skip

CHARACTERISTICS: tuple[Column[RoutedCharacteristic], ...] = (
    entry("name", lambda c: c.name),
    entry("reading_{unit}", lambda c: c.reading),
    entry("reading_given", lambda c: c.is_handed_in),
    entry("true_{unit}", lambda c: c.truth),
    entry("routes", lambda c: records(ROUTES, _route_rows([c]))),
    entry("agreements", lambda c: records(AGREEMENTS, _pair_rows([c]))),
)


def _route_rows(compared: Iterable[RoutedCharacteristic]) -> list[RouteRow]:
    return [RouteRow(c, r) for c in compared for r in c.routes]


def _pair_rows(compared: Iterable[RoutedCharacteristic]) -> list[AgreementRow]:
    return [AgreementRow(c, a) for c in compared for a in c.agreements]


def routes_table(compared: RoutesResult) -> ResultTable[RouteRow]:
    where = ", measured on a drawn machine and parts that no route knows" if compared.simulated else ""
    shown = ROUTES if compared.simulated else tuple(c for c in ROUTES if c.head != "(value - truth) / U")
    return ResultTable(f"the true value by every route{where}", shown, _route_rows(compared.characteristics))


def agreements_table(compared: RoutesResult) -> ResultTable[AgreementRow]:
    caption = (
        "E_n = difference / U of the difference; what both routes share is not in it. |E_n| <= 1: they agree."
    )
    return ResultTable("do the routes agree?", AGREEMENTS, _pair_rows(compared.characteristics), caption)


def contributions_table(compared: RoutesResult) -> ResultTable[ContributionRow]:
    rows = [
        ContributionRow(r, c) for r in _route_rows(compared.characteristics) for c in r.route.contributions
    ]
    return ResultTable("contributions", CONTRIBUTIONS, rows)


def routes_json(compared: RoutesResult) -> dict[str, Any]:
    """Return the body of the JSON document."""
    return {
        "simulated": compared.simulated, "agree": compared.agree,
        "characteristics": records(CHARACTERISTICS, compared.characteristics),
    }  # fmt: skip
