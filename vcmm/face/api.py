"""The jobs as Python calls on a Scenario; the command line calls the same functions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, overload

from vcmm.answer.evaluation.checks import remarks
from vcmm.answer.evaluation.result import UncertaintyResult
from vcmm.answer.evaluation.uncertainty import evaluate as evaluate_task
from vcmm.answer.evaluation.virtual_measurement import Measurement, measure_task
from vcmm.core.blocks import Progress, Sharing
from vcmm.core.errors import UsageError
from vcmm.face.given_files import check_inputs, evaluate_listed, given_points
from vcmm.face.readings import (
    cut_reading,
    measurement_reading,
    part_reading,
    placed_cut_reading,
    placement_reading,
    uncertainty_reading,
)
from vcmm.task.measuring.scenario import Scenario

if TYPE_CHECKING:
    from vcmm.answer.inference.job import EvaluatedPart
    from vcmm.answer.placing.hindrances import Constraint
    from vcmm.answer.placing.result import PlacementResult
    from vcmm.shop.machining.placement import PlacedCut
    from vcmm.shop.machining.result import CutResult
    from vcmm.task.measuring.cut_scenario import CutScenario
    from vcmm.task.measuring.fixture import Fixture, Goal


def measure(scenario: Scenario | CutScenario | str | Path, seed: int | None = None) -> Measurement:
    """Measure the part of a scenario once, virtually; a part that is to be cut is cut first.

    Parameters
    ----------
    scenario
        A scenario, or the path of its file.
    seed
        None: every error at its estimate; a number: one draw of all that is uncertain.

    Returns
    -------
    Measurement
        `values` of the characteristics (mm, rad), measured `points` (n, 3) in the drawing frame, `errors` (n,) along the normals, mm.

    Raises
    ------
    DataError, UsageError, ModelLimit
        A file is wrong, the call is wrong, or a point is out of reach.
    """
    files = _files_of(scenario)
    loaded = _load_if_file(scenario)
    if isinstance(loaded, Scenario):
        measurement = measure_task(loaded.task(), seed)
    else:
        from vcmm.shop.machining.job import measure_cut

        measurement = measure_cut(loaded, seed)
    return replace(measurement, reading=measurement_reading(files, seed))


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
    """Evaluate the task-specific uncertainty of every characteristic: value, U, interval, decision, budget (GUM, JCGM 101, ISO 14253-1).

    Parameters
    ----------
    scenario
        A scenario, or the path of its file. Its settings count unless given here.
    seed
        Seed of the random streams.
    trials
        Monte Carlo trials.
    engine
        "auto", "montecarlo" or "exact".
    digits
        Adaptive Monte Carlo to this many significant digits of u (JCGM 101, 7.9) instead of fixed trials.
    progress
        Called with what is done and its share, 0 to 1.
    sharing
        Who counts the trials, for example `Sharing(crew_of(workers=8))`; the result does not depend on it.

    Returns
    -------
    UncertaintyResult
        `result["name"]` is one characteristic; lengths in mm, angles in rad.

    Raises
    ------
    DataError, UsageError, ModelLimit
        A file is wrong, the call is wrong, or a point is out of reach.
    """
    files = _files_of(scenario)
    loaded = load_measuring(scenario)
    settings = loaded.settings.with_changes(seed=seed, trials=trials, engine=engine, digits=digits)
    uncertainty_result = evaluate_task(loaded.task(), settings, progress, sharing=sharing)
    notes = (*remarks(loaded), *uncertainty_result.warnings)
    return replace(uncertainty_result, warnings=notes, reading=uncertainty_reading(loaded, files))


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
    """Estimate the true values from measured points or values, with decisions; see docs/evaluate.md.

    Parameters
    ----------
    scenario
        A scenario, or the path of its file.
    points
        File of measured points: CSV (feature, x_mm, y_mm, z_mm ...), a bare list, or QIF. Give points or values.
    values
        File of measured values: CSV (characteristic, value_mm ...), or an export of PC-DMIS or CALYPSO.
    frame
        Where the points are: "part", the drawing frame, or "machine".
    tip_centres
        The points are centres of the tip, not compensated for its radius.
    seed
        Seed of the random streams (default: the scenario's).
    trials
        Monte Carlo trials (default: the scenario's).
    progress
        Called with what is done and its share, 0 to 1.

    Returns
    -------
    tuple of EvaluatedPart
        One for each part of the file; `part["name"]` is one characteristic.

    Raises
    ------
    DataError, UsageError, ModelLimit
        A file is wrong, the call is wrong, or a point is out of reach.
    """
    check_inputs(points, values, frame, tip_centres)
    files = [*_files_of(scenario), *(f for f in (points, values) if f is not None)]
    scenario = load_measuring(scenario)
    settings = scenario.settings.with_changes(seed=seed, trials=trials)
    if values is not None:
        parts = evaluate_listed(scenario, values, settings, progress)
    else:
        assert points is not None
        given, tip_centres, notes = given_points(scenario, points, tip_centres)
        from vcmm.answer.inference.job import evaluate_points

        parts = evaluate_points(
            scenario,
            given,
            in_machine=frame == "machine",
            tip_centres=tip_centres,
            settings=settings,
            progress=progress,
        )
        parts = tuple(replace(p, warnings=(*p.warnings, *notes)) for p in parts)
    reading = part_reading(scenario, files)
    return tuple(replace(p, reading=reading) for p in parts)


@overload
def place(
    scenario: Scenario,
    *,
    fixture: Fixture | None = ...,
    goal: Goal | None = ...,
    constraints: Sequence[Constraint] | None = ...,
    seed: int | None = ...,
    evaluations: int = ...,
    scanned: int = ...,
    trials: int | None = ...,
    progress: Progress | None = ...,
) -> PlacementResult: ...


@overload
def place(
    scenario: CutScenario,
    *,
    seed: int | None = ...,
    evaluations: int = ...,
    scanned: int = ...,
    trials: int | None = ...,
    progress: Progress | None = ...,
) -> PlacedCut: ...


@overload
def place(
    scenario: str | Path,
    *,
    fixture: Fixture | None = ...,
    goal: Goal | None = ...,
    constraints: Sequence[Constraint] | None = ...,
    seed: int | None = ...,
    evaluations: int = ...,
    scanned: int = ...,
    trials: int | None = ...,
    progress: Progress | None = ...,
) -> PlacementResult | PlacedCut: ...


def place(
    scenario: Scenario | CutScenario | str | Path,
    *,
    fixture: Fixture | None = None,
    goal: Goal | None = None,
    constraints: Sequence[Constraint] | None = None,
    seed: int | None = None,
    evaluations: int = 5000,
    scanned: int = 4096,
    trials: int | None = None,
    progress: Progress | None = None,
) -> PlacementResult | PlacedCut:
    """Find the best pose of a part: with the smallest objective of a measuring task, or where a part that is cut comes out best.

    Parameters
    ----------
    scenario
        A scenario that measures or cuts, or the path of its file.
    fixture
        What may move (measuring only; default: that of [placement]).
    goal
        What is minimised (measuring only; default: that of [placement], else U/T of all).
    constraints
        What a pose must keep beside the travels (measuring only; default: room for stylus, head and part; () for none).
    seed
        Seed of search, scan and trials (default: the scenario's).
    evaluations
        Evaluations of the objective that the search may use.
    scanned
        Further poses for the certificate, the median and the worst pose.
    trials
        Monte Carlo trials of the full evaluation at the present and the best pose.
    progress
        Called with what is done and its share, 0 to 1.

    Returns
    -------
    PlacementResult or PlacedCut
        `best` pose, gain, certificate, map.

    Raises
    ------
    ModelLimit
        No pose can be reached.
    UsageError
        The objective does not suit the part, or an option has no meaning for a part that is cut.
    """
    files = _files_of(scenario)
    loaded = _load_if_file(scenario)
    if isinstance(loaded, Scenario):
        from vcmm.answer.placing.placement import place as place_measured

        placed = place_measured(
            loaded,
            fixture=fixture,
            goal=goal,
            constraints=constraints,
            seed=seed,
            evaluations=evaluations,
            scanned=scanned,
            trials=trials,
            progress=progress,
        )
        return replace(placed, reading=placement_reading(files))
    options = {"fixture": fixture, "goal": goal, "constraints": constraints}
    idle = [name for name, value in options.items() if value is not None]
    if idle:
        raise UsageError(
            f"{', '.join(idle)}: a part that is cut moves with its work offset, within [placement] of its file; leave it out"
        )
    from vcmm.shop.machining.placement import place_cut

    placed_cut = place_cut(
        loaded, seed=seed, evaluations=evaluations, scanned=scanned, trials=trials, progress=progress
    )
    return replace(placed_cut, reading=placed_cut_reading(loaded, files))


def cut(
    scenario: CutScenario | str | Path,
    *,
    seed: int | None = None,
    trials: int | None = None,
    engine: str | None = None,
    progress: Progress | None = None,
    sharing: Sharing | None = None,
) -> CutResult:
    """Machine a part virtually: deviations of its features with U, their main contributors, cycle time, the surface.

    Parameters
    ----------
    scenario
        A cutting scenario, or the path of its file.
    seed
        Seed of the random streams (default: the scenario's).
    trials
        Monte Carlo trials (default: the scenario's).
    engine
        "auto", "montecarlo" or "exact".
    progress
        Called with what is done and its share, 0 to 1.
    sharing
        Who counts the trials; the result does not depend on it.

    Returns
    -------
    CutResult
        `result["name"]` is one characteristic of the finished part; lengths in mm, angles in rad.

    Raises
    ------
    DataError, UsageError, ModelLimit
        The program cannot be read, the call is wrong, or the program leaves the travels.
    """
    from vcmm.shop.machining.job import cut as cut_part

    files = _files_of(scenario)
    loaded = _load_if_file(scenario)
    if isinstance(loaded, Scenario):
        raise UsageError(
            "this scenario measures and cuts nothing: use vcmm.uncertainty(scenario), or vcmm.measure(scenario)"
        )
    cut_result = cut_part(loaded, seed=seed, trials=trials, engine=engine, progress=progress, sharing=sharing)
    return replace(cut_result, reading=cut_reading(loaded, files))


def _files_of(scenario: object) -> list[str | Path]:
    """Return the file of a scenario, where its path was given."""
    return [scenario] if isinstance(scenario, str | Path) else []


def _load_if_file(scenario: Scenario | CutScenario | str | Path) -> Scenario | CutScenario:
    """Return a scenario unchanged, or that of a file. UsageError for anything else."""
    from vcmm.task.measuring.cut_scenario import CutScenario

    if isinstance(scenario, Scenario | CutScenario):
        return scenario
    if not isinstance(scenario, str | Path):
        raise UsageError(
            f"expected a scenario or the path of its file, not {type(scenario).__name__}; vcmm.load_scenario(path) reads one"
        )
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.files.own.scenario import load_scenario
    from vcmm.files.toml import read_toml

    return load_cut(scenario) if "cut" in read_toml(scenario).data else load_scenario(scenario)


def load_measuring(scenario: Scenario | str | Path) -> Scenario:
    """Return a scenario that measures, or that of a file; for one that cuts the error names its own job."""
    measuring = _load_if_file(scenario)
    if not isinstance(measuring, Scenario):
        raise UsageError(
            "this scenario cuts a part: use vcmm.cut(scenario), or vcmm.place(scenario) for its best place"
        )
    return measuring
