"""The physics: one family of effects per file, one line for each in the list here.

Imports core.

Nobody else imports a file of this folder: who needs a certain effect asks for what it declares, or for the role it has.
"""

from __future__ import annotations

from typing import Any

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError, choose_from
from vcmm.effects.abbe import AbbeCountedTwice, AbbeOffset
from vcmm.effects.backlash import Backlash
from vcmm.effects.clamping import Clamping
from vcmm.effects.component import (
    CalibrationModes,
    ComponentPolynomial,
    ComponentSpline,
    ComponentTable,
    ComponentWarming,
)
from vcmm.effects.cutting import ToolDeflection, ToolRunout, ToolWear
from vcmm.effects.digits import Resolution
from vcmm.effects.drift import LinearDrift, SettlingDrift, StepChange, ThermalDriftTwoLags
from vcmm.effects.drift_vector import DriftVector, StepVector, ThermalVector
from vcmm.effects.dynamics import DynamicPitch, StructuralVibration
from vcmm.effects.encoder import EncoderInterpolation
from vcmm.effects.encoder_harmonics import EncoderHarmonics
from vcmm.effects.expansion import PartExpansion, ScaleExpansion
from vcmm.effects.flexure import CrossAxisFlexure, GradientBending, PartLoad
from vcmm.effects.geometric_change import GeometricChange
from vcmm.effects.gravity import GravityFlexure
from vcmm.effects.heating import ScrewHeating, SpindleGrowth
from vcmm.effects.lag import ReadoutDelay, RotaryReadoutDelay, ServoLag
from vcmm.effects.laser import AirIndex, CosineError, DeadPath
from vcmm.effects.map_interpolation import MapInterpolation
from vcmm.effects.pitch import ScrewPitch
from vcmm.effects.plate_bow import PlateBow
from vcmm.effects.play import BacklashRamp, LoadedPlay
from vcmm.effects.probe import ProbeLobing, StylusBending, TipOffset, TipRadius, TriggerDelay
from vcmm.effects.qualification import StylusQualification
from vcmm.effects.residual import CorrelatedField, ResidualField
from vcmm.effects.reversal import Hysteresis, LostMotion, ReversalSpike
from vcmm.effects.reversal_curve import LostMotionCurve, LostMotionTable
from vcmm.effects.rotary import RotaryCyclic
from vcmm.effects.scale import ScaleFactor
from vcmm.effects.scatter import Reindexing, Scatter
from vcmm.effects.setting import ProbeTouch, ToolLength, ToolOffset, ToolRadius, WorkOffset
from vcmm.effects.spindle_load import SpindleLoadGrowth
from vcmm.effects.squareness import RotaryLocation, Squareness
from vcmm.effects.thermal import ThermalDrift
from vcmm.effects.tilt import AxisLean, CentreLineOffset, CentreLineTilt
from vcmm.effects.tip_form import TipForm
from vcmm.effects.uniform_scale import UniformScale
from vcmm.effects.workpiece import WorkpieceHeating
from vcmm.effects.workpiece_bending import WorkpieceBending

ALL: tuple[type[Effect], ...] = (
    ComponentTable,
    ComponentSpline,
    ComponentPolynomial,
    ComponentWarming,
    CalibrationModes,
    ScaleFactor,
    UniformScale,
    Squareness,
    GeometricChange,
    AbbeCountedTwice,
    AbbeOffset,
    MapInterpolation,
    CrossAxisFlexure,
    PartLoad,
    GravityFlexure,
    ScaleExpansion,
    PartExpansion,
    ThermalDrift,
    ThermalDriftTwoLags,
    LinearDrift,
    SettlingDrift,
    StepChange,
    StepVector,
    DriftVector,
    ThermalVector,
    Reindexing,
    GradientBending,
    SpindleGrowth,
    SpindleLoadGrowth,
    ScrewHeating,
    Backlash,
    BacklashRamp,
    LostMotion,
    LostMotionCurve,
    LoadedPlay,
    LostMotionTable,
    Hysteresis,
    ReversalSpike,
    ScrewPitch,
    EncoderInterpolation,
    EncoderHarmonics,
    ServoLag,
    ReadoutDelay,
    RotaryReadoutDelay,
    DynamicPitch,
    StructuralVibration,
    TriggerDelay,
    TipRadius,
    TipOffset,
    StylusQualification,
    ProbeLobing,
    StylusBending,
    TipForm,
    Clamping,
    PlateBow,
    CosineError,
    AirIndex,
    DeadPath,
    ToolDeflection,
    WorkpieceBending,
    ToolWear,
    ToolRunout,
    WorkpieceHeating,
    WorkOffset,
    ProbeTouch,
    ToolLength,
    ToolRadius,
    ToolOffset,
    AxisLean,
    RotaryLocation,
    CentreLineTilt,
    CentreLineOffset,
    RotaryCyclic,
    ResidualField,
    CorrelatedField,
    Scatter,
    Resolution,
)
BY_NAME: dict[str, type[Effect]] = {effect.name: effect for effect in ALL}


def find(name: str) -> type[Effect]:
    """The effect class of a name. Raises UsageError with the closest name."""
    if name not in BY_NAME:
        raise UsageError(f'unknown effect "{name}".{choose_from(name, BY_NAME)}')
    return BY_NAME[name]


def of_role(role: str) -> Any:
    """The effect class with a role of `vcmm.core.declaration.ROLES`, None where no effect of ALL has it."""
    return next((kind for kind in ALL if kind.role == role), None)


def made_for(role: str, what: str) -> Any:
    """The effect class that `what` of a file stands for. Raises UsageError where its file was taken out of vcmm/effects/."""
    kind = of_role(role)
    if kind is None:
        raise UsageError(
            f'{what} needs the effect with role = "{role}", and none in vcmm/effects/ has it; put its file and its line in ALL '
            f"back, or leave out {what}"
        )
    return kind


def has_role(name: str, role: str) -> bool:
    """Whether the effect of that name, such as that of an Input, has a role."""
    kind = BY_NAME.get(name)
    return kind is not None and kind.role == role
