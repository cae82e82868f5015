"""A virtual cut as tables: the finished part, main uncertainty contributors, shares within a batch, the surface point by point."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from vcmm.answer.evaluation.result import CharacteristicResult, budget_interaction
from vcmm.shop.machining.result import CutResult, SurfaceExtremes, expected_deviation
from vcmm.shop.machining.significance import LEAST_P
from vcmm.show.tables.quantities import (
    DEVIATION,
    LENGTH,
    SHARE,
    SIZE,
    SPAN,
    fixed,
    in_file,
    percent_text,
    whole_percent,
)
from vcmm.show.tables.table import (
    NUMBER_TEXT,
    Column,
    ResultTable,
    Writing,
    csv_text,
    entry,
    listing,
    records,
)
from vcmm.show.tables.uncertainty import (
    BUDGET,
    DECISION,
    BudgetRow,
    budget_rows,
    characteristic_json,
    decision_text,
    from_nominal,
    more_than_rounding,
    p_conform,
)

if TYPE_CHECKING:
    from vcmm.core.run import Array
    from vcmm.shop.machining.measured_part import BesidePrediction, MeasuredCut
    from vcmm.shop.machining.mismatch import MismatchEntry

PART: tuple[Column[CharacteristicResult], ...] = (
    Column("characteristic", lambda c: c.name),
    Column("nominal", lambda c: c.nominal, LENGTH),
    Column("deviation", expected_deviation, DEVIATION),
    Column("known errors", lambda c: c.bias, DEVIATION),
    Column("U", lambda c: c.expanded, SIZE),
    Column("interval", lambda c: from_nominal(c.interval, c), SPAN),
    Column("tolerance", lambda c: from_nominal(c.tolerance, c), SPAN, on="page"),
    Column("decision", decision_text, DECISION),
    Column("p conform", p_conform, SHARE, page_head="probability of conformity"),
)


def finished_part(result: CutResult) -> ResultTable[CharacteristicResult]:
    """Return the expected value of each characteristic, and its conformity; beside it the reading of the own machine."""
    p = result.characteristics[0].p
    caption = (
        f"Deviation to expect, of it by the known errors of the machine, and coverage interval for p = {p:.0%}; lengths "
        "in mm and µm, angles in deg and µrad."
    )
    title = f"the finished part: expected deviation from nominal and its coverage interval for p = {p:.0%}"
    columns = list(PART)
    if result.own_reading is not None:
        columns.insert(3, Column("own reading", partial(_own_reading, result), DEVIATION))
    return ResultTable(title, columns, result.characteristics, page_caption=caption)


def _own_reading(result: CutResult, c: CharacteristicResult) -> float:
    """Return the deviation from nominal that the machine that cut the part reads on it."""
    assert result.own_reading is not None
    return expected_deviation(next(r for r in result.own_reading.characteristics if r.name == c.name))


def _own_readings(result: CutResult) -> list[dict[str, Any]]:
    """Return, per characteristic, the reading of the own machine, from nominal; nothing where another measures."""
    if result.own_reading is None:
        return [{} for _ in result.characteristics]
    return [
        {f"own_reading_{c.unit}": expected_deviation(c), f"own_reading_U_{c.unit}": c.expanded}
        for c in result.own_reading.characteristics
    ]


@dataclass(frozen=True, eq=False)
class OwnedShares:
    """A characteristic with its share of u² by owner, and what repeats and scatters in a batch (mm, rad)."""

    of: CharacteristicResult
    shares: dict[str, float]
    repeats: float
    scatters: float

    @property
    def unit(self) -> str:
        return self.of.unit


def shares_by_owner(result: CutResult) -> list[OwnedShares]:
    return [
        OwnedShares(c, dict(result.shares[c.name]), result.repeats[c.name], result.scatters[c.name])
        for c in result.characteristics
    ]


GROUP_WORDS = {"machine": "machine tool", "setup": "set-up"}  # as pages name them
OWNER = Writing(lambda value, unit: percent_text(value), lambda value, unit: whole_percent(value))
_NAME: Column[OwnedShares] = Column("characteristic", lambda o: o.of.name)
REPEATS: Column[OwnedShares] = Column("u, repeats in every part", lambda o: o.repeats, SIZE, key="u_repeats_{unit}", page_head="u repeats")  # fmt: skip
SCATTERS: Column[OwnedShares] = Column("u, scatters from part to part", lambda o: o.scatters, SIZE, key="u_scatters_{unit}", page_head="u scatters")  # fmt: skip
CUTTING_COLUMNS: tuple[Column[OwnedShares], ...] = (  # what cutting adds to the characteristics of JSON
    Column(None, lambda o: expected_deviation(o.of), key="deviation_{unit}"),
    Column(None, lambda o: o.shares, key="groups"),
    REPEATS,
    SCATTERS,
)


def _share(name: str, row: OwnedShares) -> float:
    return row.shares[name]


def owners(result: CutResult) -> ResultTable[OwnedShares]:
    """Return the owners of the uncertainty; on the page also the share within a batch."""
    rows = shares_by_owner(result)
    u: Column[OwnedShares] = Column("u", lambda o: o.of.u, SIZE, on="page")
    shares: list[Column[OwnedShares]] = [
        Column(name, partial(_share, name), OWNER, page_head=GROUP_WORDS.get(name)) for name in rows[0].shares
    ]
    if any(budget_interaction(row.of) for row in rows):
        shares.append(Column("interaction", lambda o: budget_interaction(o.of), OWNER))
    batch = [Column(c.head, c.cell, c.writing, page_head=c.page_head, on="page") for c in (REPEATS, SCATTERS)]
    caption = (
        "Shares of u² by owner, each input alone with the others held still; interaction: of inputs of any owner, "
        "100 % less the others, where the output is not linear (negative: they cover each other). What repeats is common to all parts cut with this set-up; what scatters differs from part to "
        "part."
    )
    return ResultTable("share of u² by owner", [_NAME, u, *shares, *batch], rows, page_caption=caption)


def largest_contributions(result: CutResult, most: int = 4) -> ResultTable[BudgetRow]:
    columns = [c for c in BUDGET if c.head != "law"]
    rows = [row for c in result.characteristics for row in budget_rows(c)[:most] if more_than_rounding(row)]
    return ResultTable("largest contributions", columns, rows)


def batch(result: CutResult) -> ResultTable[OwnedShares]:
    return ResultTable("in a batch", [_NAME, REPEATS, SCATTERS], shares_by_owner(result))


def surface(result: CutResult) -> ResultTable[Any]:
    """Return the statements of the nets over all features about the surface, for the page."""
    s = result.surface
    minutes, seconds = divmod(result.seconds, 60)
    rows = [
        ["largest departure", s.reason if s.max_um is None else f"{s.max_um:.2f} µm"],
        ["rms departure", "–" if s.rms_um is None else f"{s.rms_um:.2f} µm"],
        ["points looked at, on nets over all features", f"{s.points:,}"],
        *([["features without a net, not in it", ", ".join(s.without)]] if s.without and s.points else []),
        ["left uncut", f"{s.uncut:,}"],
        [f"gouged by the program itself, deeper than {s.deep_um:g} µm", f"{s.gouges:,}"],
        ["contacts against displaced tools", f"{result.recut.largest * 1e3:.3f} µm" if result.recut else "–"],
        ["cycle time", f"{minutes:.0f} min {seconds:.1f} s"],
    ]
    return listing("", ["", ""], rows)


def threads(result: CutResult) -> ResultTable[Any]:
    """Return the pitch and diameter of every thread, U for k = 2."""
    rows = [
        [
            f"{t.line}", f"{t.lead_mm:.4g} mm", f"{t.length_mm:.4g} mm", f"{t.pitch_um:+.2f} ± {t.pitch_U_um:.2f} µm",
            f"{t.diameter_um:+.2f} ± {t.diameter_U_um:.2f} µm", f"{t.gauge_um:.2f} µm",
        ]
        for t in result.threads
    ]  # fmt: skip
    heads = ["thread, line", "lead", "length", "pitch, cumulative", "diameter", "a gauge feels"]
    return listing("threads: deviation and expanded uncertainty (k = 2)", heads, rows)


def grooves(result: CutResult) -> ResultTable[Any]:
    """Return the width, place and floor of every groove, U for k = 2."""
    rows = [
        [
            " and ".join(f"{n}" for n in dict.fromkeys(g.lines)), f"{g.width_mm:.4g} mm", f"{g.middle_mm:.5g} mm",
            f"{g.width_um:+.2f} ± {g.width_U_um:.2f} µm", f"{g.middle_um:+.2f} ± {g.middle_U_um:.2f} µm",
            f"{g.diameter_um:+.2f} ± {g.diameter_U_um:.2f} µm",
        ]
        for g in result.grooves
    ]  # fmt: skip
    heads = ["groove, lines", "width", "middle, Z", "width", "middle", "diameter of the floor"]
    return listing("grooves: deviation and expanded uncertainty (k = 2)", heads, rows)


def cut_json(result: CutResult) -> dict[str, Any]:
    """Return the body of the JSON document: the characteristics of `uncertainty`, and what belongs to cutting."""
    s = result.surface
    added = records(CUTTING_COLUMNS, shares_by_owner(result))
    return {
        "trials": result.uncertainty.trials,
        "characteristics": [
            characteristic_json(c) | more | reading for c, more, reading in zip(result.characteristics, added, _own_readings(result))
        ],
        "surface": {
            "max_um": s.max_um, "rms_um": s.rms_um, "points": s.points, "uncut": s.uncut, "gouges": s.gouges,
            "gouge_depth_um": s.deep_um, "reason": s.reason or None, "without": list(s.without),
            "recut": None if result.recut is None else {"points": result.recut.points, "largest_um": result.recut.largest * 1e3},
        },
        "time_s": result.seconds,
        "grooves": [asdict(g) for g in result.grooves],
        "threads": [asdict(t) | {"gauge_um": t.gauge_um} for t in result.threads],
        "stock": None if result.blank is None else {
            "removed_mm3": result.blank.removed_volume,
            "kept_as": result.blank.kept_as,
            "collisions": [{"line": line, "depth_mm": depth} for line, depth in result.blank.collisions],
            "shanks": [{"line": line, "tool": tool, "depth_mm": depth} for line, tool, depth in result.blank.shanks],
        },
    }  # fmt: skip


@dataclass(frozen=True, eq=False)
class SurfacePoint:
    """A point of a map: place and normal (6,) mm, drawing frame; departures in mm, NaN where nothing was cut."""

    feature: str
    place: Array
    deviation: float
    program_alone: float


def _surface_points(result: CutResult) -> Iterator[SurfacePoint]:
    for patch in result.patches:
        net = patch.net
        for point, normal, height, nominal in zip(net.points, net.normals, patch.height, patch.nominal):
            yield SurfacePoint(net.feature, (*point, *normal), float(height), float(nominal))  # type: ignore[arg-type]


def _coordinate(index: int, point: SurfacePoint) -> float:
    return float(point.place[index])


SURFACE: tuple[Column[SurfacePoint], ...] = (
    Column(None, lambda p: p.feature, csv="feature"),
    *(
        Column(None, partial(_coordinate, i), csv=name, file=in_file(6))
        for i, name in enumerate(("x_mm", "y_mm", "z_mm", "nx", "ny", "nz"))
    ),
    Column(None, lambda p: p.deviation, csv="deviation_um", file=in_file(4, 1e3)),
    Column(None, lambda p: p.program_alone, csv="program_alone_um", file=in_file(4, 1e3)),
)


def surface_csv(result: CutResult) -> str:
    """Return every point of the maps: drawing frame, mm; departure in um, empty where nothing was cut."""
    return csv_text(ResultTable("", SURFACE, list(_surface_points(result))))


def surface_text(s: SurfaceExtremes) -> str:
    """Return one line for the terminal."""
    if s.max_um is None:
        return f"surface: no figure; {s.reason}"
    without = f"; not in it, since they have no net: {', '.join(s.without)}" if s.without else ""
    return (
        f"surface: largest departure {s.max_um:.2f} µm, rms {s.rms_um:.2f} µm over {s.points} points of the nets on all "
        f"features; {s.uncut} uncut, {s.gouges} gouged by the program itself (deeper than {s.deep_um:g} µm){without}"
    )


PREDICTION_COLUMNS: tuple[Column[BesidePrediction], ...] = (
    Column("characteristic", lambda r: r.name, key="name"),
    Column("nominal", lambda r: r.nominal, LENGTH),
    Column("measured", lambda r: r.measured - r.nominal, DEVIATION),
    Column("predicted", lambda r: r.prediction - r.nominal, DEVIATION),
    Column("u of the difference", lambda r: r.u, SIZE, key="u_difference_{unit}"),
    Column("E_n", lambda r: r.e_n, fixed(2), key="E_n"),
    entry("measured_{unit}", lambda r: r.measured),
    entry("predicted_{unit}", lambda r: r.prediction),
)
MISMATCH: tuple[Column[MismatchEntry], ...] = (
    Column("feature", lambda m: m.feature, key="feature"),
    Column("line", lambda m: m.line, NUMBER_TEXT, key="line"),
    Column("goes with", lambda m: m.covariate, key="covariate"),
    Column("p", lambda m: f"{m.p:.1g}" if m.p > 0 else f"< {LEAST_P:.0g}", NUMBER_TEXT),
    entry("p", lambda m: m.p),
    entry("rms_um", lambda m: m.rms * 1e3),
    Column("what", lambda m: m.text, key="text"),
)


def prediction_table(cut: MeasuredCut) -> ResultTable[BesidePrediction]:
    return ResultTable("measured against predicted, from nominal", PREDICTION_COLUMNS, list(cut.comparisons))


def mismatch(cut: MeasuredCut) -> ResultTable[MismatchEntry]:
    return ResultTable("where the part departs from its prediction", MISMATCH, cut.mismatch)


def measured_json(cut: MeasuredCut) -> dict[str, Any]:
    """Return keys of the document: measured, mismatch, scatter_um."""
    return {
        "measured": records(PREDICTION_COLUMNS, list(cut.comparisons)),
        "mismatch": records(MISMATCH, list(cut.mismatch)),
        "scatter_um": cut.scatter * 1e3,
    }
