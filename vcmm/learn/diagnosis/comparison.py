"""Compare: simulation against recording for any machine files, side by side. Nothing is named, nothing clipped.

    residual = value - predicted(machine) - nuisance refitted by least squares, weighted by 1/u^2

The uncertainty of the machine's own calibration is left out: chi-square is that of the stated noise alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import whitener
from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.evidence import dictionary, scorer
from vcmm.learn.diagnosis.locate import Place, generic_families, locate
from vcmm.learn.diagnosis.null_recordings import Noise, draw_null_recordings
from vcmm.learn.diagnosis.problem import Problem, predecessors
from vcmm.learn.diagnosis.row_order import sort_rows
from vcmm.learn.diagnosis.sensor_gaps import rows_for_effects
from vcmm.task.response.folds import fold_masks
from vcmm.task.response.observe import Observer, known_here, left_out, noise_u, nuisance_columns
from vcmm.task.response.recording import Recording

NULLS = 500  # smallest p is 1/501


@dataclass(frozen=True, eq=False)
class Misfit:
    """Residuals of one recording under one machine: residual (m,), u (m,), mm or rad; the nuisance columns have the rank nuisance_rank.

    covariates: observations' run, prepared. exact: the transforms were multiplied (rotations above 1 mrad).
    left_out: effects of the machine that the recording has no columns for.
    """

    recording: Recording
    run: Run
    residual: Array
    u: Array
    nuisance_rank: int
    exact: bool
    left_out: tuple[str, ...]
    depends_on: tuple[Place, ...] = ()

    @property
    def chi2(self) -> float:
        """Sum of (residual / u)^2."""
        return float(np.sum((self.residual / self.u) ** 2))

    @property
    def dof(self) -> int:
        return len(self.residual) - self.nuisance_rank


@dataclass(frozen=True, eq=False)
class Comparison:
    """One machine file against all recordings; figures over all their rows, mm or rad."""

    file: str
    parts: tuple[Misfit, ...]

    @property
    def residual(self) -> Array:
        return np.concatenate([p.residual for p in self.parts])

    @property
    def u(self) -> Array:
        return np.concatenate([p.u for p in self.parts])

    @property
    def rms(self) -> float:
        """Rms of all rows as they are."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @property
    def weighted_rms(self) -> float:
        """sqrt(sum w r^2 / sum w), w = 1/u^2."""
        weight = self.u**-2.0
        return float(np.sqrt(np.sum(weight * self.residual**2) / np.sum(weight)))

    @property
    def noise(self) -> float:
        """Stated noise as an rms."""
        return float(np.sqrt(np.mean(self.u**2)))

    @property
    def chi2(self) -> float:
        return sum(p.chi2 for p in self.parts)

    @property
    def dof(self) -> int:
        return sum(p.dof for p in self.parts)

    @property
    def angle(self) -> bool:
        return self.parts[0].recording.kind == "angle"

    @property
    def folds(self) -> tuple[tuple[str, float], ...]:
        """Pairs (fold, rms of its rows); of several recordings each with its name, and each as a whole."""
        out = []
        for part in self.parts:
            before = f"{part.recording.name}: " if len(self.parts) > 1 else ""
            if before:
                out.append((part.recording.name, float(np.sqrt(np.mean(part.residual**2)))))
            for name, rows in fold_masks(part.run, part.recording.row):
                if rows.any():
                    out.append((before + name, float(np.sqrt(np.mean(part.residual[rows] ** 2)))))
        return tuple(out)


def compare_machines(file: str, pairs: Sequence[tuple[Recording, Machine]], seed: int = 0) -> Comparison:
    """Return the residuals of recordings under the machines of one file. Raises ModelLimit: rows outside the travels, noise not known, fewer
    rows than nuisance parameters, angles beside lengths.
    """
    kinds = {recording.kind == "angle" for recording, _ in pairs}
    if len(kinds) > 1:
        raise ModelLimit("recordings of angles and of lengths have no common rms; compare them one by one")
    return Comparison(file, tuple(misfit(recording, machine, seed) for recording, machine in pairs))


def misfit(recording: Recording, machine: Machine, seed: int = 0) -> Misfit:
    """Return the residuals of one recording, nuisance refitted; with the covariates on which they depend (p from simulated white noise)."""
    left = misfit_without_covariates(recording, machine)
    recording, run = left.recording, left.run
    columns = np.reshape(nuisance_columns(recording, machine)[0], (recording.m, -1))
    problem = Problem(
        recording, machine, run, left.residual, left.u, nuisance=columns, calibration=np.zeros((recording.m, 0)),
        before=predecessors(recording.row), observer=Observer(recording, machine),
    )  # fmt: skip
    return replace(left, depends_on=_places(problem, seed))


def misfit_without_covariates(recording: Recording, machine: Machine) -> Misfit:
    """Return the residuals of one recording, nuisance refitted, without a test of covariates. The rows are in the order of a
    diagnosis, for any order of the file, so that lags and neighbours are the same.
    """
    observer = Observer(sort_rows(rows_for_effects(recording, machine.effects), machine), machine)
    recording, run = observer.recording, observer.run
    u = noise_u(recording, machine)
    predicted, exact = observer.predict
    columns = np.reshape(nuisance_columns(recording, machine)[0], (recording.m, -1))
    departure = recording.value - predicted
    residual, rank = remove_nuisance(departure, columns, u, known_here(recording, machine))
    lost = tuple(name for name, _ in left_out(recording, machine))
    return Misfit(recording, run, residual, u, nuisance_rank=rank, exact=exact, left_out=lost)


def remove_nuisance(
    departure: Array, columns: Array, u: Array, shared: Array | None = None
) -> tuple[Array, int]:
    """Return the residual (m,) after weighted least squares of the nuisance columns (m, p), and their rank.

    shared (m, r): columns K of random numbers of unit variance that the rows have in common beside their noise. Then departure and columns go through
    (1 + K K'/u^2)^-1/2 first, so that the squares of the residual add up what noise and draws must be together (generalised least
    squares, Aitken 1935).
    """
    if shared is not None and shared.shape[1]:
        left, size, _ = np.linalg.svd(shared / u[:, None], full_matrices=False)
        taken = left * (1.0 - 1.0 / np.sqrt(1.0 + size**2))  # (1 + K K'/u^2)^-1/2 = 1 - taken left'
        departure = departure - u * (taken @ (left.T @ (departure / u)))
        columns = columns - u[:, None] * (taken @ (left.T @ (columns / u[:, None])))
    length = np.linalg.norm(columns / u[:, None], axis=0)
    used = columns[:, length > 0] / length[length > 0]
    if used.shape[1] == 0:
        return departure, 0
    coefficients, _, rank, _ = np.linalg.lstsq(used / u[:, None], departure / u, rcond=1e-12)
    if rank >= len(departure):
        raise ModelLimit(
            f"{len(departure)} rows do not carry {rank} nuisance parameters and leave something to compare; "
            "take nuisance out of the recording file or measure more"
        )
    return departure - used @ coefficients, int(rank)


def _places(problem: Problem, seed: int) -> tuple[Place, ...]:
    """Return the covariates of the residual; its own scatter is the scale, so that the shape counts and not the stated noise."""
    try:
        white = whitener(problem.u, problem.nuisance, problem.calibration, problem.before)
    except ModelLimit:
        return ()  # too few rows to say where
    generic = scorer(dictionary(generic_families(problem), white))
    rest = white.apply(problem.residual)
    scale = float(np.sqrt(rest @ rest / white.dof))
    if not generic.candidates.families or scale == 0.0:
        return ()
    null = draw_null_recordings(Noise(), white, seed, "compare", NULLS)
    return locate(generic, rest / scale, generic.scores(null).max(axis=0))


def comparison_json(rows: Sequence[Comparison]) -> dict[str, object]:
    """Return the body of the document vcmm.compare/1; um, or urad for angles."""
    return {"machines": [_machine_json(row) for row in rows]}


def _machine_json(row: Comparison) -> dict[str, object]:
    unit, scale = ("urad", 1e6) if row.angle else ("um", 1e3)
    several = len(row.parts) > 1
    return {
        "file": row.file,
        "engine": "exact" if any(p.exact for p in row.parts) else "first-order",
        f"rms_{unit}": scale * row.rms,
        f"weighted_rms_{unit}": scale * row.weighted_rms,
        f"noise_{unit}": scale * row.noise,
        "chi2": row.chi2,
        "dof": row.dof,
        "folds": [{"fold": name, f"rms_{unit}": scale * rms} for name, rms in row.folds],
        "depends_on": [
            ({"recording": part.recording.name} if several else {})
            | {"covariate": p.covariate, "direction": p.direction, "p": p.p, "text": p.text}
            for part in row.parts
            for p in part.depends_on
        ],
        "left_out": sorted({name for p in row.parts for name in p.left_out}),
    }
