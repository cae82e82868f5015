"""The explicit list of effects: one physical family per file, one line here."""

from __future__ import annotations

from vcmm.effect import Effect
from vcmm.effects.backlash import Backlash
from vcmm.effects.component import ComponentPolynomial, ComponentSpline, ComponentTable
from vcmm.effects.expansion import PartExpansion, ScaleExpansion
from vcmm.effects.pitch import ScrewPitch
from vcmm.effects.probe import ProbeLobing, StylusBending, TipOffset, TipRadius, TriggerDelay
from vcmm.effects.qualification import StylusQualification
from vcmm.effects.residual import CorrelatedField, ResidualField
from vcmm.effects.scale import ScaleFactor
from vcmm.effects.scatter import Reindexing, Scatter
from vcmm.effects.squareness import RotaryLocation, Squareness
from vcmm.effects.thermal import ThermalDrift
from vcmm.errors import UsageError, choose_from

ALL: tuple[type[Effect], ...] = (
    ComponentTable,
    ComponentSpline,
    ComponentPolynomial,
    Squareness,
    RotaryLocation,
    ScaleFactor,
    Backlash,
    ScaleExpansion,
    PartExpansion,
    ThermalDrift,
    ScrewPitch,
    ProbeLobing,
    TipRadius,
    TipOffset,
    StylusQualification,
    StylusBending,
    TriggerDelay,
    ResidualField,
    CorrelatedField,
    Scatter,
    Reindexing,
)
BY_NAME: dict[str, type[Effect]] = {effect.name: effect for effect in ALL}


def find(name: str) -> type[Effect]:
    """The effect class of a name. Raises UsageError with the closest name."""
    if name not in BY_NAME:
        raise UsageError(f'unknown effect "{name}".{choose_from(name, BY_NAME)}')
    return BY_NAME[name]
