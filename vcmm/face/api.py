"""The jobs as Python calls on a Scenario; the command line calls the same functions."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, overload

from vcmm.answer.evaluation.checks import remarks
from vcmm.answer.evaluation.result import UncertaintyResult
from vcmm.answer.evaluation.sampling import Progress
from vcmm.answer.evaluation.uncertainty import evaluate as evaluate_task
from vcmm.answer.evaluation.virtual_measurement import Measurement, measure_task
from vcmm.core.blocks import Sharing
from vcmm.core.errors import DataError, UsageError, choose_from
from vcmm.task.measuring.scenario import Scenario

if TYPE_CHECKING:
    from vcmm.answer.inference.given import GivenPoints
    from vcmm.answer.inference.job import EvaluatedPart
    from vcmm.answer.placing.result import PlacementResult
    from vcmm.shop.machining.placement import PlacedCut
    from vcmm.shop.machining.scenario import CutScenario


def measure(scenario: Scenario | CutScenario | str | Path, seed: int | None = None) -> Measurement:
    """One virtual measurement; a part that is to be cut is cut first. seed=None: errors at their estimates; an int: one draw from what is known."""
    scenario = _loaded(scenario)
    if isinstance(scenario, Scenario):
        return measure_task(scenario.task(), seed)
    from vcmm.shop.machining.job import measure_cut

    return measure_cut(scenario, seed)


def uncertainty(
    scenario: Scenario | str | Path,
    *,
    seed: int | None = None,
    trials: int | None = None,
    engine: str | None = None,
    digits: int | None = None,
    progress: Progress | None = None,
    sharing: Sharing | None = None,
) -> UncertaintyResult:
    """Task-specific uncertainty of every characteristic; settings of the scenario (or of its file) unless given here.

    sharing: who counts the trials, for example `Sharing(crew_of(workers=8))`; the result does not depend on it.
    """
    scenario = _measuring(scenario)
    settings = scenario.settings.asked(seed=seed, trials=trials, engine=engine, digits=digits)
    found = evaluate_task(scenario.task(), settings, progress, sharing=sharing)
    return replace(found, warnings=(*remarks(scenario), *found.warnings))


def check_inputs(
    points: str | Path | None, values: str | Path | None, frame: str = "part", tip_centres: bool = False
) -> None:
    """UsageError: not one of points and values, an unknown frame, or words about points beside values."""
    from vcmm.answer.inference.points import FRAMES

    if (points is None) == (values is None):
        raise UsageError("give what was measured: --points points.csv or --values values.csv, one of the two")
    if frame not in FRAMES:
        raise UsageError(f'frame = "{frame}".{choose_from(frame, FRAMES)}')
    if points is None and (frame != "part" or tip_centres):
        raise UsageError("--frame and --tip-centres are about points; values have neither")


def evaluate(
    scenario: Scenario | str | Path,
    *,
    points: str | Path | None = None,
    values: str | Path | None = None,
    frame: str = "part",
    tip_centres: bool = False,
    seed: int | None = None,
    trials: int | None = None,
    progress: Progress | None = None,
) -> tuple[EvaluatedPart, ...]:
    """Measured points or values (a file of either) to true values and decisions, one result per part; see docs/evaluate.md."""
    from vcmm.answer.inference.job import evaluate_points, evaluate_values
    from vcmm.files.foreign.cmm_exports import exported_values
    from vcmm.files.own.measured_data import read_measured_values

    check_inputs(points, values, frame, tip_centres)
    scenario = _measuring(scenario)
    settings = scenario.settings.asked(seed=seed, trials=trials)
    if points is None:
        assert values is not None
        found = exported_values(values, [c.name for c in scenario.part.characteristics])
        listed, said = found or (read_measured_values(values), "")
        parts = evaluate_values(scenario, listed, settings=settings, progress=progress)
        return tuple(replace(p, warnings=(*p.warnings, said)) for p in parts) if said else parts
    given, tip_centres, notes = _given_points(scenario, points, tip_centres)
    parts = evaluate_points(
        scenario,
        given,
        in_machine=frame == "machine",
        tip_centres=tip_centres,
        settings=settings,
        progress=progress,
    )
    return tuple(replace(p, warnings=(*p.warnings, *notes)) for p in parts)


def _given_points(
    scenario: Scenario, path: str | Path, tip_centres: bool
) -> tuple[tuple[GivenPoints, ...], bool, tuple[str, ...]]:
    """Points of a CSV or QIF file or of a bare list, whether they are centres of the tip, and what the file could not say.

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

    found = read_qif_points(path)
    if found.tip_radius is None:
        if tip_centres:
            raise UsageError(
                f"{path} says that its points are compensated for the tip; leave --tip-centres out"
            )
        return found.parts, False, found.notes
    other = [n for n, s in scenario.plan.styli.items() if abs(s.tip_radius - found.tip_radius) > TIP]
    if other:
        raise DataError(
            f"{path}: its points are centres of a tip of radius {found.tip_radius:.9g} mm, and the stylus "
            f'"{other[0]}" of the plan has {scenario.plan.styli[other[0]].tip_radius:.9g} mm; write '
            f'tip_diameter = "{2 * found.tip_radius:.12g} mm"'
        )
    return found.parts, True, found.notes


@overload
def place(scenario: Scenario, **options: Any) -> PlacementResult: ...


@overload
def place(scenario: CutScenario, **options: Any) -> PlacedCut: ...


@overload
def place(scenario: str | Path, **options: Any) -> PlacementResult | PlacedCut: ...


def place(scenario: Scenario | CutScenario | str | Path, **options: Any) -> PlacementResult | PlacedCut:
    """The pose that serves best: `vcmm.answer.placing.placement.place`, or for a part to be cut `vcmm.shop.machining.placement.place_cut`.

    options: those of either; both take seed, evaluations, scanned, trials and progress.
    """
    scenario = _loaded(scenario)
    if isinstance(scenario, Scenario):
        from vcmm.answer.placing.placement import place as place_measured

        return place_measured(scenario, **options)
    from vcmm.shop.machining.placement import place_cut

    return place_cut(scenario, **options)


def _loaded(scenario: Scenario | CutScenario | str | Path) -> Scenario | CutScenario:
    """A scenario as it is, or that of a file. UsageError for anything else."""
    from vcmm.shop.machining.scenario import CutScenario

    if isinstance(scenario, Scenario | CutScenario):
        return scenario
    if not isinstance(scenario, str | Path):
        raise UsageError(
            f"a scenario or the path of its file is due, not {type(scenario).__name__}; vcmm.load_scenario(path) reads one"
        )
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.files.own.scenario import load_scenario
    from vcmm.files.toml import read_toml

    return load_cut(scenario) if "cut" in read_toml(scenario).data else load_scenario(scenario)


def _measuring(scenario: Scenario | str | Path) -> Scenario:
    """A scenario that measures, or that of a file; one that cuts is pointed to its own job."""
    found = _loaded(scenario)
    if not isinstance(found, Scenario):
        raise UsageError(
            "this scenario cuts a part: use vcmm.cut(scenario), or vcmm.place(scenario) for its best place"
        )
    return found
