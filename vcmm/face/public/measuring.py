"""Measuring tasks: plans and touches, virtual measurement, uncertainty of a task in steps."""

from __future__ import annotations

from vcmm.answer.evaluation.indication import at_indication
from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.evaluation.virtual_measurement import measure_task
from vcmm.part.gps.decision import no_decision
from vcmm.part.part import Feature, normal, surface_point
from vcmm.task.measuring.plan import Plan, Step, Stylus, touches
from vcmm.task.measuring.strategies import Grid, Levels, plan_points
from vcmm.task.measuring.task import Task, evaluate_all, fit_features, measured_points
from vcmm.task.response.volumetric import grid

__all__ = [
    "CharacteristicResult",
    "Feature",
    "Grid",
    "Levels",
    "Plan",
    "Step",
    "Stylus",
    "Task",
    "UncertaintyResult",
    "at_indication",
    "evaluate",
    "evaluate_all",
    "fit_features",
    "grid",
    "measure_task",
    "measured_points",
    "no_decision",
    "normal",
    "plan_points",
    "surface_point",
    "touches",
]
