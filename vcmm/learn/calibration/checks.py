"""Check recordings before they are fitted together: each message says what, where, and what to do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from vcmm.answer.evaluation.gaussian import condition
from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.learn.calibration.evidence import NormalEquations, append_identity
from vcmm.learn.calibration.identifiability import broad_factor
from vcmm.learn.calibration.model import ErrorModel
from vcmm.learn.calibration.readings import ALONG, Readings
from vcmm.learn.calibration.recorded_lines import check_senses
from vcmm.learn.calibration.solve import Before, WhitenedReadings, columns_of, conditioned_factor, project
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.response.recording import Recording

LIKELY_FACTORS = {  # a recording times this would agree with the others: what usually was done
    -1.0: "its sign is the other way round: check the direction nx ny nz and indicated - true against actual - commanded",
}
ARCSEC = {  # of angles alone
    4.848137: "its values look like arcsec taken for urad (1 arcsec = 4.848 urad)",
    0.2062648: "its values look like urad that were taken for arcsec and converted (1 arcsec = 4.848 urad)",
}
SURE = (
    15.0  # nats that the other recordings must win for another sign or unit, beyond what it wins without them
)
FITS = 2.0  # chi-squared per reading that it may leave then
MISFIT_CHANCE = 1e-3  # chance of a misfit as large, by the stated noise
ROUGH = 0.15  # correlation length in parts of the travel: the others' prediction must not be too sure between their readings
PART = 0.9  # of the travel that other recordings of the axis have
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


def check_instruments(certificates: Mapping[str, InstrumentCertificate]) -> None:
    """Raises UsageError where one instrument, by its serial, has two certificates. certificates: recording name -> its instrument."""
    by_serial: dict[tuple[str, str], tuple[str, InstrumentCertificate]] = {}
    for name, certificate in certificates.items():
        if not certificate.serial:
            continue
        before, first = by_serial.setdefault(
            (certificate.instrument.name, certificate.serial), (name, certificate)
        )
        if dict(first.u) != dict(certificate.u):
            raise UsageError(
                f'{before} and {name} were read with one "{certificate.instrument.name}", serial = "{certificate.serial}", but state different u of its own '
                "errors; state the same in both, or give two instruments two serials"
            )


def _check_size(recording: Recording) -> None:
    """Refuse readings that vary by more than any machine errs: they have another unit."""
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
    """Check directions of positioning runs against the order of their rows."""
    moving = [a for a, q in recording.run.position.items() if float(np.ptp(q)) > 1e-6]
    if (
        recording.kind == "displacement"
        and len(moving) == 1
        and f"sense_{moving[0]}" in recording.run.columns
    ):
        axis = moving[0]
        q, sense = recording.run.q(axis)[recording.row], recording.run.column(f"sense_{axis}")[recording.row]
        check_senses(recording, axis, q, sense)


def remarks_on(recordings: Sequence[Recording]) -> list[str]:
    """Return remarks on what is not wrong but will affect the result: lines of one axis that end earlier than others, and readings on the fly."""
    lines: dict[str, list[tuple[str, float, float]]] = {}
    for recording in recordings:
        moving = [a for a, q in recording.run.position.items() if float(np.ptp(q)) > 1e-6]
        if len(moving) == 1:
            q = recording.run.q(moving[0])
            lines.setdefault(moving[0], []).append((recording.name, float(q.min()), float(q.max())))
    return [*_short_lines(lines), *(text for r in recordings for text in _on_the_fly(r))]


def _short_lines(lines: dict[str, list[tuple[str, float, float]]]) -> list[str]:
    out = []
    for axis, spans in lines.items():
        low, high = min(f[1] for f in spans), max(f[2] for f in spans)
        unit, scale = ("deg", 180 / np.pi) if is_rotary(axis) else ("mm", 1.0)
        for name, start, end in spans:
            if end - start < PART * (high - low):
                out.append(
                    f"{name} reads {axis} from {start * scale:.6g} to {end * scale:.6g} {unit}, other recordings from {low * scale:.6g} to "
                    f"{high * scale:.6g}: its errors are not known beyond; measure them over the whole of it, or leave out the readings beyond"
                )
    return out


def _on_the_fly(recording: Recording) -> list[str]:
    """Return remarks on readings in motion from both sides: clocks that disagree by t read like a lost motion of 2 v t."""
    out = []
    for axis in "XYZ":
        speed = recording.run.columns.get(f"speed_{axis}_mm_s")
        sense = recording.run.columns.get(f"sense_{axis}")
        if recording.kind != "displacement" or speed is None or sense is None:
            continue
        along = np.abs(recording.direction[:, "XYZ".index(axis)]) > ALONG
        way = sense[recording.row] * along
        fast = np.abs(speed[recording.row])
        if (way > 0).any() and (way < 0).any() and float(np.median(fast[along])) > 0:
            gap = abs(float(recording.value[way > 0].mean() - recording.value[way < 0].mean()))
            v = float(np.median(fast[along]))
            out.append(
                f"{recording.name} was read while {axis} moved at {v:.3g} mm/s: the senses differ by {gap * 1e3:.3g} um on average, which a lost "
                f"motion makes, or clocks of machine and instrument that disagree by {gap / (2 * v) * 1e3:.3g} ms; read at two speeds, or at rest"
            )
    return out


def check_agreement(parts: Sequence[Readings], model: ErrorModel) -> None:
    """Raises UsageError where one recording contradicts all others and would agree with them in another unit or sign.

    Each recording is predicted from the others (nothing known before, stated noise). Only errors that several recordings see can be compared, and
    only a prediction that the stated noise does not explain (chi-squared) is a contradiction.
    """
    from scipy.special import chdtrc

    columns, _ = columns_of(parts, Before.nothing(model))
    white = [project(p, c, 1 / p.u**2) for p, c in zip(parts, columns)]
    a, b = np.sum([w.gram for w in white], axis=0), np.sum([w.back_project(w.y) for w in white], axis=0)
    factor = append_identity(broad_factor(model, ROUGH), len(b))
    for part, whitened in zip(parts, white):
        if len(parts) < 2 or not part.stated:
            continue
        mean, mean_factor = conditioned_factor(
            NormalEquations(a - whitened.gram, b - whitened.back_project(whitened.y), model), factor
        )
        nothing = np.zeros(len(mean))
        gains, misfits = {}, {}
        factors = LIKELY_FACTORS | ARCSEC if part.recording.kind == "angle" else LIKELY_FACTORS
        for times in (1.0, *factors):
            evidence, misfits[times] = log_likelihood(whitened, mean, mean_factor, times)
            gains[times] = evidence - log_likelihood(whitened, nothing, factor, times)[0]
        if chdtrc(part.m - whitened.rank, misfits[1.0]) > MISFIT_CHANCE:
            continue
        times = max(factors, key=lambda t: gains[t])
        if gains[times] - gains[1.0] > SURE and misfits[times] < FITS * part.m:
            raise UsageError(
                f"{part.recording.name} contradicts the other recordings, and would agree with them times {times:g}; "
                f"{factors[times]}"
            )


def log_likelihood(
    whitened: WhitenedReadings, mean: Array, factor: Array, times: float
) -> tuple[float, float]:
    """Return (ln likelihood, chi-squared) of whitened readings that should be `times` theirs; mean, factor @ factor.T: of theta.

    Their covariance is times^2 1 + (x factor)(x factor)'.
    """
    away = times * whitened.y - whitened.predict(mean)
    conditioned = condition(whitened.gram, whitened.back_project(away), factor / times)
    misfit = float(away @ away - conditioned.gain) / times**2
    return (
        -misfit / 2 - conditioned.log_det / 2,
        misfit,
    )  # times^m of the covariance and of the readings cancel
