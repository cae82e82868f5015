"""What is wrong with recordings before they are fitted together: each check says what, where, and what to do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.calibrating.evidence import Reduced, with_others
from vcmm.calibrating.identified import broad_factor
from vcmm.calibrating.model import ErrorModel
from vcmm.calibrating.readings import Readings
from vcmm.calibrating.recorded_lines import check_senses
from vcmm.calibrating.solve import Before, Whitened, columns_of, conditioned_factor, project
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.response.recording import Recording

FACTORS = {  # a recording times this would agree with the others: what usually was done
    -1.0: "its sign is the other way round: check the direction nx ny nz and indicated - true against actual - commanded",
    4.848137: "its values look like arcsec taken for urad (1 arcsec = 4.848 urad)",
    0.2062648: "its values look like urad that were taken for arcsec and converted (1 arcsec = 4.848 urad)",
}
SURE = (
    15.0  # nats that the other recordings must win for another sign or unit, beyond what it wins without them
)
FITS = 2.0  # chi-squared per reading that it may leave then
ROUGH = 0.15  # correlation length in parts of the travel: the others' prediction must not be too sure between their readings
LARGE, STEEP = 1.0, 1e-3  # mm, rad: no machine errs so much; a unit does


def check_recordings(recordings: Sequence[Recording]) -> None:
    """Raises UsageError for what cannot be right: names given twice, readings of another unit, exchanged direction labels."""
    names = [r.name for r in recordings]
    for name in names:
        if names.count(name) > 1:
            raise UsageError(f'two recordings have the name "{name}"; give each its own name = "..."')
    for recording in recordings:
        _check_size(recording)
        _check_labels(recording)


def _check_size(recording: Recording) -> None:
    """Readings that vary by more than any machine errs have another unit."""
    spread = float(np.ptp(recording.value)) if recording.m else 0.0
    if recording.kind == "angle" and spread > STEEP:
        raise UsageError(
            f"{recording.name}: angles vary by {spread * 1e3:.3g} mrad; d_urad is in urad (1 arcsec = 4.848 urad, "
            "1 mm/m = 1000 urad): check the unit"
        )
    if (
        recording.kind in ("displacement", "probe", "path")
        and spread > LARGE
        and not recording.nuisance.get("slope")
    ):
        raise UsageError(
            f"{recording.name}: readings vary by {spread:.3g} mm, more than a machine errs; d_um is in um, and holds deviations, "
            "not positions"
        )


def _check_labels(recording: Recording) -> None:
    """Directions of positioning runs against the order of their rows."""
    moving = [a for a, q in recording.run.position.items() if float(np.ptp(q)) > 1e-6]
    if (
        recording.kind == "displacement"
        and len(moving) == 1
        and f"sense_{moving[0]}" in recording.run.columns
    ):
        axis = moving[0]
        q, sense = recording.run.q(axis)[recording.row], recording.run.column(f"sense_{axis}")[recording.row]
        check_senses(recording, axis, q, sense)


def check_agreement(parts: Sequence[Readings], model: ErrorModel) -> None:
    """Raises UsageError where one recording contradicts all others and would agree with them in another unit or sign.

    Each recording is predicted from the others (nothing known before, stated noise). Only what several recordings see can be told.
    """
    columns, _ = columns_of(parts, Before.nothing(model))
    white = [project(p, c, 1 / p.u**2) for p, c in zip(parts, columns)]
    a, b = np.sum([w.gram for w in white], axis=0), np.sum([w.x.T @ w.y for w in white], axis=0)
    factor = with_others(broad_factor(model, ROUGH), len(b))
    for part, one in zip(parts, white):
        if len(parts) < 2 or not part.stated:
            continue
        mean, known = conditioned_factor(Reduced(a - one.gram, b - one.x.T @ one.y, model), factor)
        nothing = np.zeros(len(mean))
        gains, misfits = {}, {}
        for times in (1.0, *FACTORS):
            told, misfits[times] = _log_likelihood(one, mean, known, times)
            gains[times] = told - _log_likelihood(one, nothing, factor, times)[0]
        times = max(FACTORS, key=lambda t: gains[t])
        if gains[times] - gains[1.0] > SURE and misfits[times] < FITS * part.m:
            raise UsageError(
                f"{part.recording.name} contradicts the other recordings, and would agree with them times {times:g}; "
                f"{FACTORS[times]}"
            )


def _log_likelihood(one: Whitened, mean: Array, factor: Array, times: float) -> tuple[float, float]:
    """(ln likelihood, chi-squared) of whitened readings that should have been `times` theirs; mean, factor @ factor.T: of theta.

    Their covariance is times^2 1 + (x factor)(x factor)'; its inverse and determinant by Woodbury, so that no matrix is as large as the
    readings are many.
    """
    away = times * one.y - one.x @ mean
    seen = factor.T @ (one.x.T @ away)
    inner = factor.T @ one.gram @ factor
    inner[np.diag_indices_from(inner)] += times**2
    m, r = len(away), len(inner)
    misfit = float(away @ away - seen @ np.linalg.solve(inner, seen)) / times**2
    log_det = float(np.linalg.slogdet(inner)[1]) + (m - r) * float(np.log(times**2))
    return -misfit / 2 - log_det / 2 + m * float(np.log(abs(times))), misfit
