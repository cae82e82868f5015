"""Counts and second routes as Python calls: audit, independent routes, value of a certificate."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from vcmm.core.blocks import Progress, Sharing
from vcmm.core.readable import ReadableRows
from vcmm.face import readings
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import Settings

if TYPE_CHECKING:
    from vcmm.answer.routes.job import RoutesResult
    from vcmm.files.learned.certificate_comparison import CertificateWorth


def audit(
    scenario: Scenario | str | Path,
    *,
    parts: int = 2000,
    settings: Settings | None = None,
    progress: Progress | None = None,
    sharing: Sharing | None = None,
    key: str = "",
) -> ReadableRows:
    """Count how often the intervals of a task hold the true value, on parts and machines drawn from what is known.

    Parameters
    ----------
    scenario
        A scenario, or the path of its file.
    parts
        Parts to draw and measure for every kind of part.
    settings
        Instead of those of the scenario.
    progress
        Called with what is done and its share, 0 to 1.
    sharing
        Who counts; the result does not depend on it.
    key
        Of the job by all that it reads, where finished blocks are kept (`vcmm.core.blocks.key_of`).

    Returns
    -------
    tuple of AuditResult
        One row for each characteristic and kind of part; also `to_dict` and `to_dataframe`.

    Raises
    ------
    DataError, UsageError, ModelLimit
        As `uncertainty`.
    """
    from vcmm.answer.inference.audit import audit as count
    from vcmm.face.api import load_measuring

    loaded = load_measuring(scenario)
    chosen = settings or loaded.settings
    rows = count(loaded, parts=parts, settings=chosen, progress=progress, sharing=sharing, key=key)
    return ReadableRows.of(rows, readings.audit_reading(chosen.seed))


def routes(
    scenario: Scenario | str | Path,
    *,
    calibrated: str | Path | None = None,
    repeats: str | Path | None = None,
    positions: str | Path | None = None,
    standards: str | Path | None = None,
    values: str | Path | None = None,
    seed: int | None = None,
    trials: int | None = None,
    progress: Progress | None = None,
) -> RoutesResult:
    """Evaluate the same task by independent routes: virtual CMM, calibrated part (ISO 15530-3), several positions; and E_n between them.

    Without measured data all of it is measured on a machine and parts that are drawn and hidden from the routes.

    Parameters
    ----------
    scenario
        A scenario, or the path of its file.
    calibrated
        Certificate of a calibrated part: characteristic, value_mm, U_um, k.
    repeats
        What was measured of it, again and again: characteristic, value_mm (temp_part_C).
    positions
        The part itself in several positions: position, characteristic, value_mm.
    standards
        Standards beside `positions`: standard, calibrated_mm, U_um, k, reading_mm.
    values
        The part itself, measured once: characteristic, value_mm.
    seed
        Seed of the streams and of the drawn machine (default: the scenario's).
    trials
        Monte Carlo trials (default: the scenario's).
    progress
        Called with what is done and its share, 0 to 1.

    Returns
    -------
    RoutesResult
        `agree`, and for each characteristic its routes and their agreement.

    Raises
    ------
    DataError, UsageError
        A file is wrong; there is no second route.
    """
    from vcmm.answer.routes.job import routes as by_routes
    from vcmm.face.api import load_measuring
    from vcmm.files.own.routes import read_route_data

    given = {
        "calibrated": calibrated, "repeats": repeats, "positions": positions, "standards": standards, "values": values,
    }  # fmt: skip
    files = {name: None if file is None else Path(file) for name, file in given.items()}
    read = [file for file in files.values() if file is not None]
    loaded = load_measuring(scenario)
    data = read_route_data(loaded, **files) if read else None
    settings = loaded.settings.with_changes(seed=seed, trials=trials)
    routes_result = by_routes(loaded, data, settings=settings, progress=progress)
    own_files = [scenario] if isinstance(scenario, str | Path) else []
    return replace(routes_result, reading=readings.routes_reading(loaded, [*own_files, *read]))


def certificate(
    scenario: str | Path,
    *,
    trials: int | None = 20_000,
    seed: int | None = None,
    progress: Progress | None = None,
) -> CertificateWorth:
    """Find the value of the certificate of a machine for a part: U under three priors and with every further fact, coverage counted.

    Parameters
    ----------
    scenario
        Path of a scenario whose machine states a [certificate] and no errors of its own.
    trials
        Monte Carlo trials of each evaluation.
    seed
        Seed of the random streams (default: the scenario's).
    progress
        Called with what is done and its share, 0 to 1.

    Returns
    -------
    CertificateWorth
        `by_prior`, `by_fact` (U), `covered` (machines at the limit), `figures` of the test.

    Raises
    ------
    DataError, UsageError
        A file is wrong; the machine states no certificate.
    """
    from vcmm.files.learned.certificate_comparison import certificate_worth

    worth = certificate_worth(Path(scenario), trials=trials, seed=seed, progress=progress)
    return replace(worth, reading=readings.certificate_reading(scenario))
