"""Measuring instruments for machines: what each observes, its own errors, how its recording is written down.

Imports core, response.
"""

from __future__ import annotations

from vcmm.core.errors import UsageError, choose_from
from vcmm.instruments.artefact import BALL_PLATE, BAR, HOLE_PLATE, SPHERE, STEP_GAUGE
from vcmm.instruments.ball_bar import BALL_BAR
from vcmm.instruments.circular import GRID_PLATE
from vcmm.instruments.instrument import Instrument
from vcmm.instruments.laser import LASER_ANGLE, LASER_LINEAR, LASER_STRAIGHTNESS, SIX_D
from vcmm.instruments.level import LEVEL
from vcmm.instruments.rotary import INDEXER, R_TEST
from vcmm.instruments.straight import CAPACITANCE, OPTICAL, SQUARE, STRAIGHTEDGE
from vcmm.instruments.tracker import LASER_TRACER, TRACKER

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
)


def find(name: str) -> Instrument:
    """The instrument of a name. Raises UsageError with the closest one."""
    known = {i.name: i for i in ALL}
    if name not in known:
        raise UsageError(f'unknown instrument "{name}".{choose_from(name, known)}')
    return known[name]
