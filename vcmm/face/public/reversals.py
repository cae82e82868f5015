"""Reversals: simulated readings, separation of machine and artefact."""

from __future__ import annotations

from vcmm.task.instruments.reversal import NORMAL, REVERSED, ReversalTest, SeparationResult, separate_errors
from vcmm.task.instruments.reversal_line import (
    LineScan,
    SquarenessReversal,
    StraightnessReversal,
    squareness_reversal,
    straightness_reversal,
)
from vcmm.task.instruments.reversal_simulation import Sampling, reading, simulated_values
from vcmm.task.instruments.reversal_turns import TurnGroup, turn_group

__all__ = [
    "NORMAL",
    "REVERSED",
    "LineScan",
    "ReversalTest",
    "Sampling",
    "SeparationResult",
    "SquarenessReversal",
    "StraightnessReversal",
    "TurnGroup",
    "reading",
    "separate_errors",
    "simulated_values",
    "squareness_reversal",
    "straightness_reversal",
    "turn_group",
]
