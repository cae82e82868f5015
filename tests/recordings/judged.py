"""What a diagnosis leaves of the rows as they are, and of rows that it was not given."""

from __future__ import annotations

import numpy as np

from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.learn.diagnosis.written_machine import answers_to_write


def left(problem: Problem, d: Diagnosis) -> np.ndarray:
    """The residual (m,) with the machine that is written."""
    eye = problem.observer
    gone = [eye.through(a.fitted, a.fitted.error_motion(eye.run)) for a in answers_to_write(d.answer)]
    own = {e.id: e for e in problem.machine.effects}
    assert not any(a.fitted.id in own for a in answers_to_write(d.answer))  # these machines have no errors
    return np.asarray(problem.residual - np.sum(gone, axis=0) if gone else problem.residual)


def without_nuisance(rest: np.ndarray, problem: Problem, fitted: np.ndarray) -> np.ndarray:
    """rest (m,) less the nuisance as fitted to the rows `fitted`."""
    length = np.linalg.norm(problem.nuisance[fitted], axis=0)
    columns = problem.nuisance / np.where(length > 0, length, 1.0)
    return np.asarray(rest - columns @ np.linalg.lstsq(columns[fitted], rest[fitted], rcond=1e-9)[0])


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
