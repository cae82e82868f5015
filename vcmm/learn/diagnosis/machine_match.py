"""Check that machine and recording belong together. Residuals of millimetres have causes that are no physics: units, axes,
alignment, another machine. The recording is fitted by an affine map of the position, and the map is put into words.

    value = s n . (A p + t)      s = -1 for indicated - true, +1 for actual - commanded;   p tip, workpiece axes
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import LEAST_FRACTION
from vcmm.learn.diagnosis.null_recordings import robust_scale
from vcmm.learn.diagnosis.problem import Problem

Mask = npt.NDArray[np.bool_]
FAR_LENGTH, FAR_ANGLE = (
    1.0,
    0.3,
)  # mm, rad: residuals (robust rms) from which nothing is a small error any more
TIMES = 100.0  # times the stated noise
WILD = 100.0  # times the scatter of the others, and the stated noise
FEW = 0.05  # share of the rows up to which they are single rows
REWEIGHTING_ROUNDS = 15
ENERGY_SHARE = 0.97  # share of the energy
UNITS = {
    25.4: "inches for mm",
    1e3: "metres for mm, or readings in um for mm",
    1e-3: "um for mm, or readings in metres for mm",
    1 / 25.4: "mm for inches, or readings in inches for mm",
}
NOISE = 30.0  # times (or parts of) the stated noise at which units are suspected
LINK_CORRELATION = 0.98  # correlation of recording and prediction


@dataclass(frozen=True)
class Suspicion:
    """A possible explanation, in words; share: of the energy of the recording that it explains."""

    text: str
    share: float


def check_belonging(problem: Problem, white: Whitener) -> None:
    """Raises ModelLimit, with what would fit, for residuals of millimetres."""
    rest = white.apply(problem.residual) / white.weight
    far = FAR_ANGLE if problem.recording.kind == "angle" else FAR_LENGTH
    usual = float(robust_scale(rest))
    if usual > far and usual > TIMES * float(np.median(problem.u)):
        reasons = suspicions(problem)
        shown = (
            ". What fits: " + "; ".join(s.text for s in reasons)
            if reasons
            else ". Neither another unit nor other axes nor an alignment explains it"
        )
        raise ModelLimit(
            f"machine and recording do not belong together: the residual is {_size(usual, problem)}, "
            f"{usual / float(np.median(problem.u)):.0f} times the stated noise{shown}. Check units, axes, [nuisance] and the"
            " machine file"
        )


def wild_rows(problem: Problem) -> tuple[Mask, str]:
    """Return single rows so far off that they are no observation of the same thing, and the words for it.

    The nuisance is fitted by least absolute values (reweighted least squares): one typing error of 10 mm would pull a
    least-squares placement along, and with it every other row.
    """
    rest = _robust_rest(problem)
    usual = float(robust_scale(rest))
    out = np.abs(rest) > WILD * np.maximum(usual, problem.u)
    if not out.any() or out.mean() > FEW:
        return np.zeros(problem.m, dtype=bool), ""
    worst, where = float(np.abs(rest).max()), problem.recording.places(out)
    return out, (
        f"{where} left out: the residual is up to {_size(worst, problem)} where the others have {_size(usual, problem)};"
        " a typing error, a crash or another feature"
    )


def _robust_rest(problem: Problem) -> Array:
    """Return the residuals (m,) after a fit of the nuisance by least absolute values."""
    length = np.linalg.norm(problem.nuisance, axis=0)
    columns = problem.nuisance[:, length > 0] / length[length > 0]
    rest = problem.residual - np.median(problem.residual)
    if not columns.shape[1]:
        return rest
    weight = np.ones(problem.m)
    for _ in range(REWEIGHTING_ROUNDS):
        root = np.sqrt(weight)
        fit = np.linalg.lstsq(columns * root[:, None], problem.residual * root, rcond=1e-10)[0]
        rest = problem.residual - columns @ fit
        weight = 1.0 / np.maximum(np.abs(rest), problem.u)
    return rest


def _size(value: float, problem: Problem) -> str:
    return f"{value * 1e3:.3g} mrad" if problem.recording.kind == "angle" else f"{value:.3g} mm"


def suspicions(problem: Problem) -> list[Suspicion]:
    """Return explanations that are no physics, best first."""
    out = [*_of_prediction(problem), *_of_alignment(problem), *_of_axes(problem)]
    return sorted(out, key=lambda s: -s.share)[:2]


def _share(value: Array, columns: Array) -> tuple[float, Array]:
    """Return the share of the energy of value (m,) in the span of columns (m, k), and the coefficients."""
    fit = np.asarray(np.linalg.lstsq(columns, value, rcond=1e-10)[0])
    rest = value - columns @ fit
    return 1.0 - float(rest @ rest) / max(float(value @ value), LEAST_FRACTION), fit


def _of_prediction(problem: Problem) -> list[Suspicion]:
    """Return suspicions of recording = factor x prediction: a unit of the observation, or the sign."""
    value = problem.recording.value - problem.recording.value.mean()
    predicted = problem.observer.baseline()
    predicted = predicted - predicted.mean()
    size = float(np.linalg.norm(value) * np.linalg.norm(predicted))
    if size <= 0 or abs(float(value @ predicted)) < LINK_CORRELATION * size:
        return []
    factor = float(value @ predicted) / float(predicted @ predicted)
    share = (float(value @ predicted) / size) ** 2
    return [Suspicion(f"the observations are {factor:.4g} times the prediction: their unit or sign", share)]


def _of_alignment(problem: Problem) -> list[Suspicion]:
    """Return suspicions of a rigid motion of everything, where the recording has no such nuisance."""
    if problem.recording.kind == "angle" or {"rigid", "alignment"} & set(problem.recording.nuisance):
        return []
    n, p = problem.recording.direction, _tip(problem)
    columns = np.concatenate([n, np.cross(p - p.mean(axis=0), n)], axis=1)
    share, fit = _share(problem.residual, columns)
    if share < ENERGY_SHARE:
        return []
    turn = float(np.linalg.norm(fit[3:]))
    text = f"an alignment (shift {np.linalg.norm(fit[:3]):.3g} mm, turn {np.degrees(turn):.2g} deg): add rigid to [nuisance]"
    return [Suspicion(text, share)]


def _tip(problem: Problem) -> Array:
    return np.asarray(problem.run.tip[problem.recording.row])


def _of_axes(problem: Problem) -> list[Suspicion]:
    """Return suspicions of an affine map of the positions that is a unit, a reversed or an exchanged axis."""
    if problem.recording.kind == "angle":
        return []
    n, p = problem.recording.direction, _tip(problem)
    across = p - p.mean(axis=0)
    columns = np.concatenate([np.einsum("mi,mj->mij", n, across).reshape(len(n), 9), n], axis=1)
    share, fit = _share(problem.residual, columns)
    if share < ENERGY_SHARE:
        return []
    axes = np.eye(3) + problem.recording.sign * fit[:9].reshape(3, 3)
    words = _in_words(axes, np.ptp(p, axis=0) > 0)
    return [Suspicion(words, share)] if words else []


def _in_words(axes: Array, moved: Mask) -> str:
    """Return a map of positions, actual from stated, as a mistake in words. moved (3,): axes that the rows determine."""
    size = np.linalg.norm(axes, axis=0)
    used = moved & (size > 1e-6)
    out = []
    for factor, name in UNITS.items():
        if used.any() and np.allclose(size[used], factor, rtol=0.03):
            out.append(f"positions in {name} (factor {factor:g})")
    if not out and moved.any() and (size[moved] < 1 - ENERGY_SHARE).all():
        out.append("readings that are deviations already, stated as positions")
    main = np.abs(axes).argmax(axis=0)
    swapped = [f"{'XYZ'[j]} and {'XYZ'[main[j]]}" for j in range(3) if size[j] > 0.5 and main[j] > j]
    if swapped:
        out.append(f"{', '.join(swapped)} exchanged")
    turned = ["XYZ"[j] for j in range(3) if size[j] > 0.5 and main[j] == j and axes[j, j] < -0.5 * size[j]]
    if turned:
        out.append(f"axis {', '.join(turned)} counted the other way")
    return " and ".join(out)


def noise_warning(scale: float) -> str | None:
    """Return the warning that observations are far quieter or louder than stated: a unit."""
    if 1 / NOISE < scale < NOISE:
        return None
    unit = "mm written as um" if scale < 1 else "nm written as um, or um written as mm"
    return (
        f"the scatter is {scale:.2g} times what was stated: check the units of the observations ({unit}) and of the noise;"
        " no name is sure until this is clear"
    )
