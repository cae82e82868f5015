"""Check files of measured points and values: those that go together, and their contents."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from vcmm.core.blocks import Progress
from vcmm.core.errors import DataError, UsageError, choose_from

if TYPE_CHECKING:
    from vcmm.answer.inference.given_points import GivenPoints
    from vcmm.answer.inference.job import EvaluatedPart
    from vcmm.task.measuring.scenario import Scenario
    from vcmm.task.measuring.settings import Settings


def check_inputs(
    points: str | Path | None, values: str | Path | None, frame: str = "part", tip_centres: bool = False
) -> None:
    """Raise UsageError where not exactly one of points and values is given, for an unknown frame, or for words about points beside values."""
    from vcmm.answer.inference.points import FRAMES

    if (points is None) == (values is None):
        raise UsageError("give what was measured: --points points.csv or --values values.csv, one of the two")
    if frame not in FRAMES:
        raise UsageError(f'frame = "{frame}".{choose_from(frame, FRAMES)}')
    if points is None and (frame != "part" or tip_centres):
        raise UsageError("--frame and --tip-centres are about points; values have neither")


def evaluate_listed(
    scenario: Scenario, values: str | Path, settings: Settings, progress: Progress | None
) -> tuple[EvaluatedPart, ...]:
    """Evaluate the values of a file of ours or of an export, with notes on information that the export lacks."""
    from vcmm.answer.inference.job import evaluate_values
    from vcmm.files.foreign.cmm_exports import exported_values
    from vcmm.files.own.measured_data import read_measured_values
    from vcmm.part.gps import characteristics as gps

    nominals = {c.name: gps.nominal(c, scenario.part.features) for c in scenario.part.characteristics}
    exported = exported_values(values, list(nominals), nominals)
    listed, note = exported or (read_measured_values(values), "")
    parts = evaluate_values(scenario, listed, settings=settings, progress=progress)
    return tuple(replace(p, warnings=(*p.warnings, note)) for p in parts) if note else parts


def given_points(
    scenario: Scenario, path: str | Path, tip_centres: bool
) -> tuple[tuple[GivenPoints, ...], bool, tuple[str, ...]]:
    """Return points of a CSV or QIF file or of a bare list, whether they are centres of the tip, and notes on missing information.

    UsageError and DataError where a QIF file says otherwise than the call or the plan: it states its own tip.
    """
    from vcmm.files.foreign.point_lists import read_point_list
    from vcmm.files.foreign.qif import is_qif
    from vcmm.files.own.measured_data import read_measured_points

    if not is_qif(path):
        listed = read_point_list(path)
        return (
            (read_measured_points(path), tip_centres, ())
            if listed is None
            else ((listed.points,), tip_centres, listed.notes)
        )
    from vcmm.files.foreign.qif_points import TIP, read_qif_points

    qif_points = read_qif_points(path)
    if qif_points.tip_radius is None:
        if tip_centres:
            raise UsageError(
                f"{path} says that its points are compensated for the tip; leave --tip-centres out"
            )
        return qif_points.parts, False, qif_points.notes
    other = [n for n, s in scenario.plan.styli.items() if abs(s.tip_radius - qif_points.tip_radius) > TIP]
    if other:
        raise DataError(
            f"{path}: its points are centres of a tip of radius {qif_points.tip_radius:.9g} mm, and the stylus "
            f'"{other[0]}" of the plan has {scenario.plan.styli[other[0]].tip_radius:.9g} mm; write '
            f'tip_diameter = "{2 * qif_points.tip_radius:.12g} mm"'
        )
    return qif_points.parts, True, qif_points.notes
