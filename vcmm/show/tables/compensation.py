"""A rewritten program as tables: departures before and after, the shift of the work offsets, corrected points, the proof by a cut."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from vcmm.compensation.result import CompensatedProgram, Departure, OrientationProof
from vcmm.core.run import Array
from vcmm.show.tables.quantities import fixed, in_file
from vcmm.show.tables.table import NUMBER_TEXT, Column, ResultTable, csv_text, entry, records

if TYPE_CHECKING:
    from vcmm.compensation.points import CorrectedPoints
    from vcmm.shop.machining.proof import CutProof, InspectedCut

NamedDeparture = tuple[str, Departure]
Shift = tuple[str, Array]

DEPARTURES: tuple[Column[NamedDeparture], ...] = (
    Column("", lambda n: n[0]),
    Column("largest", lambda n: n[1].largest, fixed(2, "um", 1e3)),
    Column("rms", lambda n: n[1].rms, fixed(2, "um", 1e3)),
    entry("max_um", lambda n: n[1].largest * 1e3),
    entry("rms_um", lambda n: n[1].rms * 1e3),
    Column("at line", lambda n: n[1].line, NUMBER_TEXT, key="line"),
)

POINTINGS: tuple[Column[NamedDeparture], ...] = (
    Column("", lambda n: n[0]),
    Column("largest", lambda n: n[1].largest, fixed(1, "urad", 1e6)),
    Column("rms", lambda n: n[1].rms, fixed(1, "urad", 1e6)),
    entry("max_urad", lambda n: n[1].largest * 1e6),
    entry("rms_urad", lambda n: n[1].rms * 1e6),
    Column("at line", lambda n: n[1].line, NUMBER_TEXT, key="line"),
)


def _along(axis: int, shift: Shift) -> float:
    return float(shift[1][axis])


SHIFTS: tuple[Column[Shift], ...] = (
    Column("offset", lambda s: s[0]),
    *(Column(c, partial(_along, i), fixed(1, "um", 1e3, signed=True)) for i, c in enumerate("XYZ")),
)


class RewritingSummary(Protocol):
    """Summary of every rewriting."""

    @property
    def name(self) -> str: ...
    @property
    def machine(self) -> str: ...
    @property
    def shifts(self) -> Mapping[str, Array]: ...


def departures(result: RewritingSummary, rows: list[NamedDeparture]) -> ResultTable[NamedDeparture]:
    title = f"{result.name} on {result.machine}: departure of the cut path from the programmed one"
    return ResultTable(title, DEPARTURES, rows)


def pointings(proof: OrientationProof) -> ResultTable[NamedDeparture]:
    rows = [("as programmed", proof.before), ("compensated program", proof.after)]
    return ResultTable(
        "angle between the tool and where it is programmed to point, over the cuts", POINTINGS, rows
    )


def pointing_json(departure: Departure) -> dict[str, Any]:
    """Return the same of one program."""
    return records(POINTINGS, [("", departure)])[0]


def shifts(result: RewritingSummary) -> ResultTable[Shift]:
    return ResultTable("best shift of the work offsets alone", SHIFTS, list(result.shifts.items()))


def before_and_after(result: CompensatedProgram) -> list[NamedDeparture]:
    """Return the program as it is, with shifted offsets, and rewritten; then with what rewriting does not correct."""
    rows = [
        ("as programmed", result.before),
        ("work offsets shifted", result.offset_only),
        ("compensated program", result.after),
    ]
    if result.whole is not None:
        rows.append(("as programmed, with reversal and lag", result.whole[0]))
        rows.append(("compensated, with reversal and lag", result.whole[1]))
    return rows


def departure_json(departure: Departure) -> dict[str, Any]:
    return records(DEPARTURES, [("", departure)])[0]


def shifts_json(result: RewritingSummary) -> dict[str, list[float]]:
    return {name: [float(v) for v in shift] for name, shift in result.shifts.items()}


def _component(what: str, axis: int, corrected_points: CorrectedPoints, row: int) -> float:
    return float(getattr(corrected_points, what)[row, axis])


def points_csv(corrected: CorrectedPoints) -> str:
    """Return corrected and indicated points, mm, and the subtracted errors, um."""
    columns: list[Column[int]] = []
    for what, heading, file in (
        ("corrected", "corrected_{}_mm", in_file(6)),
        ("indicated", "indicated_{}_mm", in_file(6)),
        ("error", "e{}_um", in_file(4, 1e3)),
    ):
        columns += [
            Column(None, partial(_component, what, i, corrected), csv=heading.format(c), file=file)
            for i, c in enumerate("xyz")
        ]
    return csv_text(ResultTable("", columns, range(len(corrected.error))))


def proof_json(proof: CutProof) -> dict[str, Any]:
    """Return the key `proof`, and `reason` where it is null."""
    if proof.after is None:
        return {"proof": None, "reason": proof.reason}
    body = {"by": "cut", **_figures(proof.after), "met": proof.is_met, "allowed_um": proof.limit * 1e3}
    return {"proof": body | {"before": None if proof.before is None else _figures(proof.before)}}


def _figures(cut: InspectedCut) -> dict[str, Any]:
    features = {
        str(name): {"lowest_um": float(off.min()) * 1e3, "highest_um": float(off.max()) * 1e3}
        for name in dict.fromkeys(cut.feature.tolist())
        if len(off := cut.off[cut.feature == name])
    }
    return {
        "largest_um": cut.largest * 1e3, "mean_um": cut.mean * 1e3, "points": len(cut.off), "uncut": cut.uncut,
        "worst_feature": cut.worst, "features": features,
    }  # fmt: skip


def proof_text(proof: CutProof) -> str:
    """Return the answer in two lines."""
    if proof.after is None:
        return f"proof by a cut: nothing was inspected; {proof.reason}"
    after, before = proof.after, proof.before
    was = (
        ""
        if before is None
        else f"; before {before.largest * 1e3:.2f} µm ({before.worst}), {before.mean * 1e3:.2f} µm"
    )
    return (
        f"proof by a cut: {'met' if proof.is_met else 'NOT met'}: the new program, cut and inspected at {len(after.off)} points, departs by {after.largest * 1e3:.2f} µm at most "
        f"({after.worst}), {after.mean * 1e3:.2f} µm in the mean{was}; allowed are {proof.limit * 1e3:.2f} µm"
        + (f"; {after.uncut} points are left uncut" if after.uncut else "")
    )
