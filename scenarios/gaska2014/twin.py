"""Twin of Gaska et al. 2014: a compressor body at five places of a Leitz PMM 12106.

Int. J. Adv. Manuf. Technol. 73 (2014) 497-507. Typed in from the paper: the nodes (Table 1), eight rows of standard deviations (Table 2),
the results (Table 3). Everything else the paper leaves unpublished is drawn.

    1  LaserTracer, five stations, 14 approaches of 52 nodes: what d is, and what of it the instrument makes    tracer.found_by
    2  the model of sections 4 and 5, read sixteen ways, over many machines, beside Table 3                      readings.matrix
       the same with fewer and more touches                                                                      other_plans
    3  one machine from the middle of them: form and distance at five places                                     places
    4  maps of the simulated reproduction error (Fig. 7)                                                         maps.field_map
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import product
from typing import Any

import numpy as np

from vcmm import Array, Scenario, calibration, instruments, measuring
from vcmm import tables as tb
from vcmm.core.residual_weights import CURVES

from .nodes import SHOWN, draw_deviations
from .readings import (
    PAPER_DISTANCE_U,
    PAPER_FORM_U,
    REDRAWS,
    SHOWN_READING,
    TRIALS,
    Reading,
    ReadingResult,
    matrix,
    rank,
    with_touches,
)
from .tracer import READINGS as LENGTHS
from .tracer import Approached, bare, found_by, read, untold

RECIPE = "by the recipe of the paper the spread of a form says nothing of the true one"
HYSTERESIS = (0.0, 0.5, 1.0)  # share of the variance of the approaches
CLOSE_RUNS = 4  # machines followed by the LaserTracer for each
PLANS = (
    (2, 8),
    (3, 12),
    (4, 20),
)  # touches along a side of each face, and on each of three levels of the bore
PLANNED = tuple(Reading(curve, "linear", "deviation", redraw) for curve in CURVES for redraw in REDRAWS)
PLAN_MACHINES = 60
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Row:
    """One place: form and distance on the machine that is shown, and the central 95 % of U over the machines (mm)."""

    place: str
    form: measuring.CharacteristicResult
    distance: measuring.CharacteristicResult
    form_range: tuple[float, float]
    distance_range: tuple[float, float]
    result: measuring.UncertaintyResult


@dataclass(frozen=True)
class Followed:
    """The title procedure for one share of hysteresis and one reading of eq. 1, over several machines.

    residual: rms of eq. 2, um.   found, single: rms of d as found and of one approach as derived, over the true one.
    instrument: smallest, median, largest share of the instrument in d, um.   small: instrument's share of the variance of the d below
    0.3 um.   rejected: share of chi-squared tests below 0.05.   quiet: probability that ten nodes reject nothing, as in the paper.
    """

    hysteresis: float
    lengths: str
    residual: float
    found: float
    single: float
    instrument: tuple[float, float, float]
    small: float
    rejected: float
    quiet: float


@dataclass(frozen=True, eq=False)
class OtherPlan:
    """One reading with another number of touches on each face and in the bore."""

    face: int
    bore: int
    result: ReadingResult


@dataclass(frozen=True, eq=False)
class GaskaTwin:
    """rows: five places of the machine that is shown. matrix: every reading. ranks: of that machine's mean U, from 1, form and distance.

    shares: of the machines in which each place is best, by form and by distance.
    """

    draws: int
    rows: tuple[Row, ...]
    matrix: tuple[ReadingResult, ...]
    followed: tuple[Followed, ...]
    plans: tuple[OtherPlan, ...]
    ranks: tuple[int, int]
    shares: dict[str, tuple[float, float]]


def machines(draws: int) -> Array:
    """(draws, 52, 3) um."""
    return np.array([draw_deviations(seed) for seed in range(1, draws + 1)])


def run(
    scenario: Scenario,
    draws: int = 200,
    trials: int | None = None,
    progress: Progress = lambda text, share: None,
) -> GaskaTwin:
    """All of it. draws: machines consistent with the published figures."""
    drawn = machines(draws)
    progress("LaserTracer", 0.0)
    followed = tuple(follow(drawn[:CLOSE_RUNS], *one) for one in product(HYSTERESIS, LENGTHS))
    also = np.concatenate(
        [drawn, draw_deviations(SHOWN)[None]]
    )  # whatever the number of draws, the machine that is shown comes last
    every = matrix(scenario, also, progress=lambda text, share: progress(text, 0.1 + 0.4 * share))
    whole = next(f for f in every if f.reading == SHOWN_READING)
    ranks = rank(whole.form, draws), rank(whole.distance, draws)
    found = [f.first(draws) for f in every]
    shown = whole.first(draws)
    rows = places(scenario, shown, trials, lambda text, share: progress(text, 0.5 + 0.5 * share))
    shares = {
        name: (
            float((shown.form.argmin(axis=1) == k).mean()),
            float((shown.distance.argmin(axis=1) == k).mean()),
        )
        for k, name in enumerate(scenario.places)
    }
    return GaskaTwin(
        draws=draws, rows=tuple(rows), matrix=tuple(found), followed=followed, plans=other_plans(scenario, drawn),
        ranks=ranks, shares=shares,
    )  # fmt: skip


def follow(drawn: Array, hysteresis: float, lengths: str) -> Followed:
    """The LaserTracer on machines with d (M, 52, 3) um."""
    found = [found_by(Approached(d * 1e-3, hysteresis, lengths), k) for k, d in enumerate(drawn)]
    true = (drawn * 1e-3) ** 2

    def ratio(name: str) -> float:
        return float(np.sqrt(np.mean([getattr(f, name) ** 2 for f in found]) / true.mean()))

    own = np.array([f.instrument for f in found])
    d = np.array([f.d for f in found])
    low, middle, high = (float(v) * 1e3 for v in np.quantile(own, [0, 0.5, 1]))
    few = d < 0.3e-3
    return Followed(
        hysteresis=hysteresis,
        lengths=lengths,
        residual=float(np.sqrt(np.mean([f.u**2 for f in found]))) * 1e3,
        found=ratio("d"),
        single=ratio("single"),
        instrument=(low, middle, high),
        small=float((own[few] ** 2).sum() / (d[few] ** 2).sum()),
        rejected=float(np.mean([f.rejection_share() for f in found])),
        quiet=float(np.mean([untold(f) for f in found])),
    )


def other_plans(scenario: Scenario, drawn: Array) -> tuple[OtherPlan, ...]:
    """What the tests say with fewer and more touches: the paper gives no plan."""
    out = []
    for face, level in PLANS:
        found = matrix(with_touches(scenario, face, level), drawn[:PLAN_MACHINES], PLANNED, TRIALS // 2)
        out += [OtherPlan(face**2, 3 * level, one) for one in found]
    return tuple(out)


def places(scenario: Scenario, over: ReadingResult, trials: int | None, progress: Progress) -> list[Row]:
    """Form by the paper's recipe and distance at every place, with the range of U over the machines."""
    settings = replace(scenario.settings, trials=trials or scenario.settings.trials, certify=50)
    rows = []
    for k, (name, pose) in enumerate(scenario.places.items()):
        progress(f"place {name}", k / len(scenario.places))
        result = measuring.evaluate(scenario.at(pose).task(), settings, read=False)
        form, distance = (
            next(c for c in result.characteristics if c.type == t) for t in ("cylindricity", "distance")
        )
        rows.append(
            Row(
                name,
                by_recipe(form, settings.rule),
                distance,
                span_of(over.form[:, k]),
                span_of(over.distance[:, k]),
                result,
            )
        )
    return rows


def span_of(u: Array) -> tuple[float, float]:
    """The central 95 %."""
    low, high = np.quantile(u, [0.025, 0.975])
    return float(low), float(high)


def by_recipe(form: measuring.CharacteristicResult, rule: str) -> measuring.CharacteristicResult:
    """As the paper takes it: U is half of where 95 % of the indicated values lie, whatever they say of the true one."""
    assert form.summary is not None
    low, high = form.summary.interval(form.p, form.interval_kind)
    u = form.summary.u
    return replace(
        form, value=form.indicated, interval=(low, high), half_width=None, u=u, k=(high - low) / 2 / u, coverage_shown=False,
        why_not_shown=RECIPE, decision=measuring.no_decision(rule, RECIPE), true_value=None,
    )  # fmt: skip


def in_detail(row: Row, rule: str) -> measuring.UncertaintyResult:
    """The result of a place with what its form says of the true one, which parts are drawn for."""
    found = [
        c if c.true_value or not c.extreme else measuring.at_indication(c, c.indicated, rule)
        for c in row.result.characteristics
    ]
    return replace(row.result, characteristics=tuple(found))


def tracer_files() -> dict[str, str]:
    """File name -> text: the lengths of the LaserTracer on the machine that is shown, half of whose scatter is hysteresis, for
    `vcmm calibrate tracer.toml --machine cmm.toml --nodes`.
    """
    seen = read(Approached(draw_deviations(SHOWN) * 1e-3), np.random.default_rng(SHOWN))
    return {
        **instruments.recording_texts(seen, "tracer", "cmm.toml"),
        "cmm.toml": calibration.bare_text(bare()),
    }


def order(values: Sequence[float]) -> str:
    """Places from the smallest U, such as "5 3 1 2 4"."""
    return " ".join(str(k + 1) for k in np.argsort(values, kind="stable"))


def figures(result: GaskaTwin) -> dict[str, Any]:
    """Body of the JSON document."""
    return {
        "draws": result.draws,
        "machine": {"draw": SHOWN, "rank_form": result.ranks[0], "rank_distance": result.ranks[1], "reading": SHOWN_READING.words},
        "rows": [
            {
                "place": row.place, "redraw": SHOWN_READING.redraw,
                "form": tb.characteristic_json(row.form), "form_U_range_mm": list(row.form_range),
                "paper_form_U_mm": PAPER_FORM_U[row.place] * 1e-3, "form_best_share": result.shares[row.place][0],
                "distance": tb.characteristic_json(row.distance), "distance_U_range_mm": list(row.distance_range),
                "paper_distance_U_mm": PAPER_DISTANCE_U[row.place] * 1e-3, "distance_best_share": result.shares[row.place][1],
            }
            for row in result.rows
        ],
        "readings": [_reading_json(one) for one in result.matrix],
        "plans": [{"touches_face": p.face, "touches_bore": p.bore, **_reading_json(p.result)} for p in result.plans],
        "tracer": [asdict(one) for one in result.followed],
    }  # fmt: skip


def _reading_json(one: ReadingResult) -> dict[str, Any]:
    hits, ratio, spread = one.hits(), one.ratio(), one.spread
    return {
        **asdict(one.reading),
        "form_U_mm": np.median(one.form, axis=0).tolist(), "distance_U_mm": np.median(one.distance, axis=0).tolist(),
        "form_U_ranges_mm": [list(span_of(u)) for u in one.form.T], "distance_U_ranges_mm": [list(span_of(u)) for u in one.distance.T],
        "hits_form": hits[0], "hits_distance": hits[1], "hits_p": one.hits_p, "ratio": ratio[0], "ratio_above_1_share": ratio[1],
        "spread_p_form": spread[0], "spread_p_distance": spread[1], "contradicted_by": list(one.against()),
    }  # fmt: skip
