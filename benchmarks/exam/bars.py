"""The figures that have a published bar, from the rows of result files: hits of n, one-sided bound, bar."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.exam.results import Row, grouped
from benchmarks.exam.score import STALE, bound

Test = Callable[[Row], Any]
RIGHT = {10.0: 0.985, 7.0: 0.95, 5.0: 0.70, 15.0: 0.99}
SET = {10.0: 1.2, 7.0: 1.6, 5.0: 5.0, 15.0: 1.1}


@dataclass(frozen=True)
class Figure:
    """A rate with the bar it has to meet; high: the rate has to be at least the bar."""

    block: str
    what: str
    hits: int
    n: int
    bar: float | None
    high: bool = True

    @property
    def rate(self) -> float:
        return self.hits / self.n if self.n else float("nan")

    @property
    def bound(self) -> float:
        return bound(self.hits, self.n, self.high)

    @property
    def met(self) -> bool | None:
        if self.bar is None or not self.n:
            return None
        return self.rate >= self.bar if self.high else self.rate <= self.bar


def counted(
    block: str, what: str, rows: Sequence[Row], test: str | Test, bar: float | None = None, high: bool = True
) -> Figure:
    """Rows in which `test` (a key or a function) gives None are not counted."""
    ask: Test = (lambda r: r.get(test)) if isinstance(test, str) else test
    known = [bool(v) for v in map(ask, rows) if v is not None]
    return Figure(block, what, sum(known), len(known), bar, high)


def valid(rows: Sequence[Row]) -> list[Row]:
    return [r for r in rows if not r.get("error")]


def visible(rows: Sequence[Row]) -> list[Row]:
    return [r for r in valid(rows) if not r.get("invisible")]


MISSED: Row = dict.fromkeys(("right", "in_set", "exact", "all_in_sets", "flagged"), False)


def with_failed(rows: Sequence[Row]) -> list[Row]:
    """Visible cases, and those in which the command failed: they count as missed."""
    return visible(rows) + [MISSED for r in rows if r.get("error")]


def _a(name: str, delta: float, rows: list[Row]) -> list[Figure]:
    seen = visible(rows)
    return [
        counted(name, "right name first", with_failed(rows), "right", RIGHT.get(delta)),
        counted(name, "truth in the set", with_failed(rows), "in_set", 0.98),
        counted(name, "right place, of those with one", seen, "place_right"),
        counted(name, "named wrongly with 0.95 or more", seen, "wrong_confident", None, False),
    ]


def _b(name: str, rows: list[Row]) -> list[Figure]:
    worlds = sorted({str(r["world"]) for r in rows}, key=lambda w: (w != "t6", w))
    out = [
        counted(
            name,
            f"false alarms, {w}",
            [r for r in valid(rows) if r["world"] == w],
            "anything",
            0.02 if w == "t6" else 0.03,
            False,
        )
        for w in worlds
    ]
    return [*out, counted(name, "false alarms, all worlds", valid(rows), "anything", 0.03, False)]


def _d(name: str, rows: list[Row]) -> list[Figure]:
    return [
        counted(name, "exact pair", with_failed(rows), "exact", 0.92),
        counted(name, "both in the sets", with_failed(rows), "all_in_sets", 0.97),
        counted(name, "an extra name", visible(rows), lambda r: r["extra"] > 0, 0.05, False),
    ]


def covariate_right(row: Row) -> bool | None:
    """E, where physics without a name was proposed: does one of its covariates belong to the truth? (X for X_mm and so on)"""
    if not row.get("unknown") or not row.get("covariates"):
        return None

    def base(word: str) -> str:
        return word.removesuffix("_mm").removesuffix("_s").removesuffix("_mm_s").split("_")[0].lower()

    return bool({base(w) for w in row["covariates"]} & {base(w) for w in row["unknown"]["covariates"]})


def _f(name: str, rows: list[Row]) -> list[Figure]:
    seen, hidden = visible(rows), [r for r in valid(rows) if r.get("invisible")]
    return [
        counted(name, "truth in the set, of those visible", with_failed(rows), "in_set", 0.98),
        counted(name, "right name first, of those visible", seen, "right"),
        counted(name, "exact alias kept in the set", seen, "alias_kept", 1.0),
        counted(name, "invisible effects declared", hidden, "declared_invisible", 1.0),
        counted(name, "named wrongly with 0.95 or more", seen, "wrong_confident", None, False),
    ]


def of_block(block: str, delta: float, rows: list[Row]) -> list[Figure]:
    name, ok = f"{block}, delta {delta:g}", visible(rows)
    if block == "A":
        return _a(name, delta, rows)
    if block == "B":
        return _b("B", rows)
    if block == "C":
        return [
            counted("C", "named stale, where visible", ok, "right", 0.95),
            counted(
                "C", "named stale, whatever the strength", ok, lambda r: bool({*r["answered"][:1]} & STALE)
            ),
            counted("C", "other physics named", ok, "other_named", 0.03, False),
        ]
    if block == "D":
        return _d(name, rows)
    if block == "E":
        return [
            counted(name, "flagged", with_failed(rows), "flagged", 0.90),
            counted(name, "silently wrong", ok, "silently_wrong", 0.04, False),
            counted(name, "covariate right, where proposed", ok, covariate_right, 0.85),
        ]
    if block == "F":
        return _f(name, rows)
    if block == "G":
        return [
            counted(name, "named wrongly with 0.95 or more", ok, "wrong_confident", 0.02, False),
            counted(name, "right name first", ok, "right"),
        ]
    return (
        [counted(name, "component and mistake exact", with_failed(rows), "right", 0.97)]
        if block == "H"
        else []
    )


def across(rows: Sequence[Row]) -> list[Figure]:
    """Figures over several blocks."""
    named = [r for r in visible(rows) if r["block"] in "ABDFGH" and (r["block"] == "B" or r.get("right"))]
    found = [
        i for r in visible(rows) if r["block"] in "ADFG" for i in r.get("intervals", []) if "inside" in i
    ]
    return [
        counted("A B D F G H", "`unknown` filled beside a right name or nothing", named,
                lambda r: r.get("unknown") is not None, 0.03, False),
        counted("A D F G", "parameters inside their 95 % interval", found, "inside"),
    ]  # fmt: skip


def figures(rows: Sequence[Row]) -> list[Figure]:
    out = []
    for (block, delta), mine in grouped(rows).items():
        out += of_block(block, delta, mine)
    return out + across(rows)


def set_sizes(rows: Sequence[Row]) -> list[tuple[str, int, float, float | None]]:
    """(block, sets, mean size, bar) of the first answers."""
    out = []
    for (block, delta), mine in grouped(rows).items():
        sizes = [r["set_size"] for r in visible(mine) if r.get("set_size")]
        if sizes and block in "ADFG":
            bar = SET.get(delta) if block == "A" else 3.0 if block == "F" else None
            out.append((f"{block}, delta {delta:g}", len(sizes), float(np.mean(sizes)), bar))
    return out


def relative_errors(rows: Sequence[Row]) -> list[float]:
    """|estimate / truth - 1| times the delta reached, of effects with one parameter; 0.67 is the median of a perfect fit."""
    out = []
    for r in visible(rows):
        if r["block"] == "A" and r.get("right") and len(r.get("intervals", [])) == 1:
            ratio = r["intervals"][0].get("ratio")
            out += [abs(abs(ratio) - 1) * r["concealed"][0]["delta"]] if ratio is not None else []
    return out


def folds_left(rows: Sequence[Row], at_least: float) -> list[Mapping[str, Any]]:
    """Folds of A (right name) and D (exact pair), delta 10 or more, in which, and outside of which, the truth is that strong."""
    good = [
        r
        for r in visible(rows)
        if r["delta_asked"] >= 10
        and ((r["block"] == "A" and r["right"]) or (r["block"] == "D" and r["exact"]))
    ]
    return [
        {**f, "case": f"{r['block']} {r['seed']} {r['case']}", "effect": r["concealed"][0]["effect"]}
        for r in good
        for f in r.get("folds", [])
        if min(f["strength"], f["known"]) >= at_least
    ]
