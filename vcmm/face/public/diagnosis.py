"""Diagnosis: the values that `vcmm.diagnose` returns, and how an answer becomes part of a machine."""

from __future__ import annotations

from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.learn.diagnosis.improve import improve_machine
from vcmm.learn.diagnosis.result import Answer, Diagnosis
from vcmm.learn.diagnosis.written_machine import answers_to_write
from vcmm.show.pages.diagnosis import sentences
from vcmm.show.tables.diagnosis import FOLDS, FoldRow, folds
from vcmm.task.response.observe import baseline, calibration_columns

__all__ = [
    "FOLDS",
    "Answer",
    "Diagnosis",
    "Estimate",
    "FoldRow",
    "answers_to_write",
    "baseline",
    "calibration_columns",
    "folds",
    "improve_machine",
    "sentences",
]
