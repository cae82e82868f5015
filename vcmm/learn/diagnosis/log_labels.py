"""Mistakes of the log: labels that stand some rows too early or too late, and two labels exchanged.

A label says which rows share a placement, an offset or a radius. Labels that slipped by some rows give the first rows of each group the
nuisance of the one before. The same number of free nuisance numbers is fitted either way, so the evidence is the ratio of what they leave:

    ln BF = dof / 2 ln(|residual beside the labels as they stand|^2 / |residual beside the labels as meant|^2)

Two labels that are exchanged everywhere group the same rows; they are told only where the machine holds something for one of them.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.constants import CLOSING, MOST_SHAPES
from vcmm.learn.diagnosis.problem import Problem
from vcmm.task.response.observe import nuisance_columns
from vcmm.task.response.recording import ALL_ROWS

LABELS_EXCHANGED = "labels_exchanged"


@dataclass(frozen=True, eq=False)
class SlippedLabels:
    """text: which label, by how many rows; departure (m,) of the nuisance as meant; prior: ln, with the difference of the two fits."""

    text: str
    departure: Array
    prior: float


def slipped_labels(problem: Problem, white: Whitener) -> Iterator[SlippedLabels]:
    """Every label of the nuisance, some rows too early or too late. white: of the problem as it stands."""
    recording = problem.recording
    labels = sorted({w for w in recording.nuisance.values() if w not in ALL_ROWS} & set(recording.run.labels))
    labels = [n for n in labels if len(np.unique(recording.run.labels[n][recording.row])) > 1]
    steps = [k for k in range(-CLOSING, CLOSING + 1) if k]
    for label, by in itertools.product(labels, steps):
        meant = replace(recording, run=_slipped(recording.run, label, by, recording.lines))
        try:
            columns = np.reshape(nuisance_columns(meant, problem.machine)[0], (problem.m, -1))
            own = replace(problem, nuisance=columns).whitener()
        except ModelLimit:
            continue
        weight = 1.0 / problem.u[:, None]
        fit = np.linalg.lstsq(weight * columns, problem.residual / problem.u, rcond=None)[0]
        departure = columns @ fit
        left = white.apply(problem.residual - departure)  # beside both nuisances, which is too little
        alone = own.apply(problem.residual)
        too_little = 0.5 * white.dof * float(np.log((alone @ alone) / (left @ left)))
        share = -float(np.log(len(labels) * len(steps)))
        rows = "row" if abs(by) == 1 else "rows"
        text = f"{label}, {abs(by)} {rows} too {'late' if by < 0 else 'early'}"
        yield SlippedLabels(text, departure, share - max(too_little, 0.0))


def _slipped(run: Run, label: str, by: int, lines: np.ndarray | None) -> Run:
    """The run with a label taken from `by` rows before (by < 0: after) in the order of the file."""
    rows = np.arange(run.n) if lines is None or len(lines) != run.n else np.argsort(lines, kind="stable")
    values = run.labels[label].copy()
    place = np.clip(np.arange(run.n) - by, 0, run.n - 1)
    values[rows] = run.labels[label][rows[place]]
    return replace(run, labels={**run.labels, label: values})


def exchanged_labels(run: Run) -> Iterator[tuple[str, Run]]:
    """Pairs of values of one label, each taken for the other."""
    for label, values in run.labels.items():
        kinds = [str(v) for v in np.unique(values)]
        if not 1 < len(kinds) <= MOST_SHAPES:
            continue
        for a, b in itertools.combinations(kinds, 2):
            other = np.where(values == a, b, np.where(values == b, a, values)).astype(values.dtype)
            yield f"{a} and {b} of {label}", replace(run, labels={**run.labels, label: other})
