"""A calibrated arm as tables: its links by the numbers of the trade, joints that yield or run out, residuals of poses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vcmm.learn.calibration.arm import ArmFit, machine_with
from vcmm.learn.calibration.arm_geometry import LinkNumber, link_numbers
from vcmm.learn.calibration.pose_tests import PoseTest
from vcmm.physics.structure.squareness import RotaryLocation
from vcmm.show.report.answers import AnswerLine, K, signed_value
from vcmm.show.tables.quantities import fixed
from vcmm.show.tables.table import Column, ResultTable

if TYPE_CHECKING:
    from vcmm.core.run import Array

STEP = 1e-6  # mm, rad: of derivatives of link numbers
UNITS = {True: ("deg", 180 / np.pi, "mrad", 1e3), False: ("mm", 1.0, "mm", 1.0)}


@dataclass(frozen=True)
class LinkRow:
    """One number of a link: nominal and found in mm or deg, change and u in mm or mrad."""

    joint: str
    following: str
    quantity: str
    nominal: float
    estimate: float
    unit: str
    change: float
    u: float
    unit_of_change: str


@dataclass(frozen=True)
class ArmNumber:
    """One number of the machine file: mm, mrad."""

    effect: str
    where: str
    number: str
    value: float
    u: float
    unit: str


def _urad(turn: float | None) -> float | None:
    return None if turn is None else turn * 1e6


LINKS: tuple[Column[LinkRow], ...] = (
    Column("joint", lambda row: row.joint, key="joint"),
    Column("next", lambda row: row.following, key="next"),
    Column("number", lambda row: row.quantity, key="quantity"),
    Column("nominal", lambda row: row.nominal, fixed(4), key="nominal"),
    Column("found", lambda row: row.estimate, fixed(4), key="found"),
    Column("unit", lambda row: row.unit, key="unit"),
    Column("change", lambda row: row.change, fixed(4), key="change"),
    Column("u", lambda row: row.u, fixed(4), key="u"),
    Column("in", lambda row: row.unit_of_change, key="unit_of_change"),
)
TERMS: tuple[Column[ArmNumber], ...] = (
    Column("effect", lambda row: row.effect, key="effect"),
    Column("where", lambda row: row.where, key="where"),
    Column("number", lambda row: row.number, key="parameter"),
    Column("value", lambda row: row.value, fixed(4), key="value"),
    Column("u", lambda row: row.u, fixed(4), key="u"),
    Column("unit", lambda row: row.unit, key="unit"),
)
POSE_TESTS: tuple[Column[PoseTest], ...] = (
    Column("test", lambda row: row.name, key="name"),
    Column("poses", lambda row: row.n, fixed(0), key="poses"),
    Column("before", lambda row: row.before * 1e3, fixed(1, "um"), key="rms_before_um"),
    Column("after", lambda row: row.after * 1e3, fixed(1, "um"), key="rms_after_um"),
    Column(
        "tracker held",
        lambda row: None if row.in_place is None else row.in_place * 1e3,
        fixed(1, "um"),
        key="rms_held_um",
    ),
    Column("turn before", lambda row: _urad(row.before_turn), fixed(0, "urad"), key="turn_before_urad"),
    Column("turn after", lambda row: _urad(row.after_turn), fixed(0, "urad"), key="turn_after_urad"),
)


def link_rows(fit: ArmFit) -> list[LinkRow]:
    """Return every number of every link, nominal and found; u from the covariance of the fit, by central differences."""
    ideal, fitted = link_numbers(fit.nominal, fit.nominal), link_numbers(fit.machine, fit.nominal)
    slopes = []
    for k in range(len(fit.theta)):
        step = np.zeros(len(fit.theta))
        step[k] = STEP
        up, down = (
            link_numbers(machine_with(fit.nominal, fit.terms, fit.theta + s), fit.nominal)
            for s in (step, -step)
        )
        slopes.append([_change(a, b) / (2 * STEP) for a, b in zip(up, down)])
    slope: Array = np.array(slopes).T
    u = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", slope, fit.covariance, slope), 0.0))
    return [_link_row(a, b, float(s)) for a, b, s in zip(ideal, fitted, u)]


def _change(first: LinkNumber, second: LinkNumber) -> float:
    """Return first - second, for angles by the shorter way."""
    difference = first.value - second.value
    return float(np.angle(np.exp(1j * difference))) if first.is_angle else difference


def _link_row(ideal: LinkNumber, fitted: LinkNumber, u: float) -> LinkRow:
    unit, scale, small, fine = UNITS[ideal.is_angle]
    change = _change(fitted, ideal)
    return LinkRow(
        joint=ideal.joint,
        following=ideal.following,
        quantity=ideal.quantity,
        nominal=ideal.value * scale,
        estimate=(ideal.value + change) * scale,
        unit=unit,
        change=change * fine,
        u=u * fine,
        unit_of_change=small,
    )


def term_rows(fit: ArmFit) -> list[ArmNumber]:
    """Return the numbers of the machine file."""
    rows = []
    for term in fit.terms:
        values, u = fit.values(term)
        shift = isinstance(term.effect, RotaryLocation) and term.parameter == "offset"
        unit, scale = ("mm", 1.0) if shift else ("mrad", 1e3)
        words = [term.parameter] if term.size == 1 else ["cosine", "sine"]
        rows += [
            ArmNumber(term.effect.name, term.effect.where, w, float(v) * scale, float(s) * scale, unit)
            for w, v, s in zip(words, values, u)
        ]
    return rows


def further_rows(fit: ArmFit) -> list[ArmNumber]:
    """Return the numbers beside the geometry."""
    return [r for r in term_rows(fit) if r.effect != RotaryLocation.name]


def links_table(rows: Sequence[LinkRow]) -> ResultTable[LinkRow]:
    """Return the links."""
    return ResultTable(
        "Links from joint to joint (Denavit-Hartenberg; Hayati where axes are parallel)", LINKS, rows
    )


def further_table(rows: Sequence[ArmNumber]) -> ResultTable[ArmNumber]:
    """Return the joints that yield under weight, and once-per-turn errors."""
    return ResultTable("Joints that yield under weight or err once per turn", TERMS, rows)


def pose_tests(rows: Sequence[PoseTest]) -> ResultTable[PoseTest]:
    """Return the residuals of other poses under the written file, per coordinate."""
    return ResultTable("Other poses, rms of a coordinate", POSE_TESTS, rows)


def arm_answers(fit: ArmFit, before: float, tests: Sequence[PoseTest]) -> list[AnswerLine]:
    """Return the residuals of the poses, and of each of them predicted from the others; then of the tests."""
    position, turn = fit.rms
    n = sum(r.n for r in fit.recordings)
    turned = f", {turn * 1e6:.0f} µrad" if turn else ""
    lines = [
        AnswerLine(
            fit.nominal.name,
            f"{before * 1e3:.1f} → {position * 1e3:.1f} µm{turned}",
            coverage=f"rms of a coordinate, {n} poses",
            verdict=f"each predicted from the others: {fit.press * 1e3:.1f} µm",
            because=_further_words(fit),
            labels=("", "beside the geometry:", ""),
            numbers={
                "rms_before_um": before * 1e3,
                "rms_after_um": position * 1e3,
                "rms_left_out_um": fit.press * 1e3,
            },
        )
    ]
    for test in tests:
        comparison = (
            ""
            if test.in_place is None
            else f"; tracker and target as in the calibration: {test.in_place * 1e3:.1f} µm"
        )
        lines.append(
            AnswerLine(
                test.name,
                f"{test.before * 1e3:.1f} → {test.after * 1e3:.1f} µm",
                coverage=f"{test.n} other poses",
                verdict=comparison.removeprefix("; "),
            )
        )
    return lines


def _further_words(fit: ArmFit) -> str:
    """Return the elastic and cyclic terms, with their largest amplitude."""
    words = []
    for term in fit.terms:
        if term.size == 2:
            values, u = fit.values(term)
            size = float(np.hypot(*values))
            words.append(f"{term.name} {signed_value(size * 1e3, K * float(u.max()) * 1e3, 'mrad')}")
    return "; ".join(words) or "nothing that pays"
