"""Interpolations compared on readings that were held out: every third position of each line, never its ends, and of lengths (tracker,
step gauge) a third of the places, sampled.

    prediction    G theta + N nu, nu (zero, slope) by weighted least squares on the readings of the same line that were kept
    variance      A C A' + N (N' W N)^-1 N' + noise^2,   A = G_held - N_held N_kept^+ G_kept,   C the covariance of theta

theta and nu are jointly normal, so this is the law of the readings held out given those kept.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.blocks import Progress
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.interpolation import INTERPOLATIONS, SAME_POSITION_MM, moving
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.net import folds
from vcmm.learn.calibration.readings import Readings, readings
from vcmm.learn.calibration.result import Calibration, rms
from vcmm.learn.calibration.verification import INSIDE
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.response.recording import Recording

Mask = npt.NDArray[np.bool_]
LEAST_POSITIONS = 6  # positions of a line of which some are held out


@dataclass(frozen=True)
class PredictedPositions:
    """One interpolation on n readings held out: rms error in um (lengths) and urad (angles), None where there are none.

    inside: share within the 95 % band of the prediction (noise of the reading included); nats: mean log density per reading in
    units of its noise; seconds of the fit.
    """

    name: str
    n: int
    rms_um: float | None
    rms_urad: float | None
    inside: float
    nats: float
    seconds: float


def held_rows(recording: Recording) -> Mask:
    """Return which readings are held out (m,): those at every third position of a line, of lengths those at a third of the places. None of
    other recordings.
    """
    none = np.zeros(recording.m, dtype=bool)
    axes = moving(recording)
    if recording.kind == "length":
        where = np.stack([recording.run.q(a)[recording.row] for a in axes], axis=1)
        places, number = np.unique(np.round(where / SAME_POSITION_MM), axis=0, return_inverse=True)
        mixed = np.random.default_rng(0).permutation(len(places))  # in order, whole planes of a grid would go
        return np.isin(number.ravel(), mixed[: len(places) // 3]) if len(places) >= LEAST_POSITIONS else none
    if recording.kind not in ("displacement", "angle") or len(axes) != 1:
        return none
    q = np.round(recording.run.q(axes[0])[recording.row] / SAME_POSITION_MM)
    places, number = np.unique(q, return_inverse=True)
    if len(places) < LEAST_POSITIONS:
        return none
    return np.isin(number, folds(len(places))[1])


def compare_interpolations(
    recordings: Sequence[Recording],
    machine: Machine,
    certificates: Mapping[str, InstrumentCertificate] | None = None,
    only: Sequence[str] = (),
    progress: Progress = lambda text, share: None,
    names: Sequence[str] = INTERPOLATIONS,
) -> list[PredictedPositions]:
    """Fit every interpolation without the readings held out, and return its predictions of them.

    Raises UsageError where no recording is a line of 6 positions or more, or lengths to as many places, and what `calibrate` raises.
    """
    masks = [held_rows(r) for r in recordings]
    if not any(h.any() for h in masks):
        raise UsageError(
            f"no recording is a line of {LEAST_POSITIONS} positions or more along one axis, or lengths to as many places; nothing can be held out to "
            "compare interpolations"
        )
    kept = [r.take(~h) for r, h in zip(recordings, masks)]
    out = []
    for k, name in enumerate(names):
        progress(name, k / len(names))
        start = time.perf_counter()
        calibration = calibrate(kept, machine, certificates, only, interpolation=name)
        seconds = time.perf_counter() - start
        whole = [
            readings(r, machine, calibration.posterior.model, (certificates or {}).get(r.name))
            for r in recordings
        ]
        out.append(
            _score(
                name,
                [predict_rows(calibration, k, p, h) for k, (p, h) in enumerate(zip(whole, masks)) if h.any()],
                seconds,
            )
        )
    return out


@dataclass(frozen=True, eq=False)
class _HeldOutPrediction:
    """Prediction of one recording: error, u of the prediction, noise (held,), mm or rad."""

    angle: bool
    error: Array
    u: Array
    noise: Array


def predict_rows(calibration: Calibration, number: int, part: Readings, held_out: Mask) -> _HeldOutPrediction:
    """Predict the held-out readings of recording `number`, as the docstring of this module says. part: all of its readings."""
    post = calibration.posterior
    noise = post.noise[number].u * part.u
    weight = 1 / noise[~held_out]
    inverse = np.linalg.pinv(part.nuisance[~held_out] * weight[:, None], rcond=1e-9) * weight
    through = part.nuisance[held_out] @ inverse
    error = part.value - part.errors @ post.theta
    moved = part.errors[held_out] - through @ part.errors[~held_out]
    u2 = np.einsum("ij,jk,ik->i", moved, post.covariance, moved)
    u2 += ((through * noise[~held_out]) ** 2).sum(axis=1)
    return _HeldOutPrediction(
        part.recording.kind == "angle",
        error[held_out] - through @ error[~held_out],
        np.sqrt(u2 + noise[held_out] ** 2),
        noise[held_out],
    )


def _score(name: str, predictions: Sequence[_HeldOutPrediction], seconds: float) -> PredictedPositions:
    error, u, noise = (np.concatenate([getattr(f, k) for f in predictions]) for k in ("error", "u", "noise"))
    angle = np.concatenate([np.full(len(f.error), f.angle) for f in predictions])
    density = -((error / u) ** 2) / 2 - np.log(u / noise * np.sqrt(2 * np.pi))
    return PredictedPositions(
        name=name,
        n=len(error),
        rms_um=rms(error[~angle]) * 1e3 if (~angle).any() else None,
        rms_urad=rms(error[angle]) * 1e6 if angle.any() else None,
        inside=float((np.abs(error) < INSIDE * u).mean()),
        nats=float(density.mean()),
        seconds=seconds,
    )
