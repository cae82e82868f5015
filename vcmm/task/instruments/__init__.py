"""Measuring instruments for machines: their observations, their own errors, and the form of their recordings."""

from __future__ import annotations

from vcmm.core.errors import UsageError, choose_from
from vcmm.task.instruments.artefact import BALL_PLATE, BAR, HOLE_PLATE, SPHERE, STEP_GAUGE
from vcmm.task.instruments.ball_bar import BALL_BAR
from vcmm.task.instruments.circular import GRID_PLATE
from vcmm.task.instruments.instrument import Instrument
from vcmm.task.instruments.laser import LASER_ANGLE, LASER_LINEAR, LASER_STRAIGHTNESS, SIX_D
from vcmm.task.instruments.level import LEVEL
from vcmm.task.instruments.rotary import INDEXER, R_TEST
from vcmm.task.instruments.straight import CAPACITANCE, OPTICAL, SQUARE, STRAIGHTEDGE
from vcmm.task.instruments.touch_probe import TOUCH_PROBE
from vcmm.task.instruments.tracker import LASER_TRACER, TRACKER

ALL: tuple[Instrument, ...] = (
    LASER_LINEAR,
    LASER_STRAIGHTNESS,
    LASER_ANGLE,
    SIX_D,
    LEVEL,
    STRAIGHTEDGE,
    SQUARE,
    CAPACITANCE,
    OPTICAL,
    BALL_BAR,
    GRID_PLATE,
    TRACKER,
    LASER_TRACER,
    BALL_PLATE,
    HOLE_PLATE,
    STEP_GAUGE,
    BAR,
    SPHERE,
    R_TEST,
    INDEXER,
    TOUCH_PROBE,
)


def find(name: str) -> Instrument:
    """Return the instrument of a name. Raises UsageError with the closest one."""
    by_name = {i.name: i for i in ALL}
    if name not in by_name:
        raise UsageError(f'unknown instrument "{name}".{choose_from(name, by_name)}')
    return by_name[name]
