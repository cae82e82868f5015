"""What may be wrong: one family of effects per file, one line for each in the list here.

Nobody else imports a file of this folder: who needs a certain effect asks for what it declares, or for the role it has.
"""

from __future__ import annotations

from typing import Any

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError, choose_from
from vcmm.physics.abbe import AbbeCountedTwice, AbbeOffset
from vcmm.physics.backlash import Backlash
from vcmm.physics.clamping import Clamping
from vcmm.physics.component import (
    CalibrationModes,
    ComponentPolynomial,
    ComponentSpline,
    ComponentTable,
    ComponentWarming,
)
from vcmm.physics.cutting import ToolDeflection, ToolRunout, ToolWear
from vcmm.physics.digits import Resolution
from vcmm.physics.drift import LinearDrift, SettlingDrift, StepChange, ThermalDriftTwoLags
from vcmm.physics.drift_vector import DriftVector, StepVector, ThermalVector
from vcmm.physics.dynamics import DynamicPitch, StructuralVibration
from vcmm.physics.encoder import EncoderInterpolation
from vcmm.physics.encoder_harmonics import EncoderHarmonics
from vcmm.physics.expansion import PartExpansion, ScaleExpansion
from vcmm.physics.flexure import CrossAxisFlexure, GradientBending, PartLoad
from vcmm.physics.geometric_change import GeometricChange
from vcmm.physics.gravity import GravityFlexure
from vcmm.physics.heating import ScrewHeating, SpindleGrowth
from vcmm.physics.lag import ReadoutDelay, RotaryReadoutDelay, ServoLag
from vcmm.physics.laser import AirIndex, CosineError, DeadPath
from vcmm.physics.map_interpolation import MapInterpolation
from vcmm.physics.pitch import ScrewPitch
from vcmm.physics.plate_bow import PlateBow
from vcmm.physics.play import BacklashRamp, LoadedPlay
from vcmm.physics.probe import ProbeLobing, StylusBending, TipOffset, TipRadius, TriggerDelay
from vcmm.physics.qualification import StylusQualification
from vcmm.physics.residual import CorrelatedField, ResidualField
from vcmm.physics.reversal import Hysteresis, LostMotion, ReversalSpike
from vcmm.physics.reversal_curve import LostMotionCurve, LostMotionTable
from vcmm.physics.rotary import RotaryCyclic
from vcmm.physics.scale import ScaleFactor
from vcmm.physics.scatter import Reindexing, Scatter
from vcmm.physics.setting import ProbeTouch, ToolLength, ToolOffset, ToolRadius, WorkOffset
from vcmm.physics.spindle_load import SpindleLoadGrowth
from vcmm.physics.squareness import RotaryLocation, Squareness
from vcmm.physics.thermal import ThermalDrift
from vcmm.physics.tilt import AxisLean, CentreLineOffset, CentreLineTilt
from vcmm.physics.tip_form import TipForm
from vcmm.physics.uniform_scale import UniformScale
from vcmm.physics.workpiece import WorkpieceHeating
from vcmm.physics.workpiece_bending import WorkpieceBending

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
    """The effect class that `what` of a file stands for. Raises UsageError where its file was taken out of vcmm/physics/."""
    kind = of_role(role)
    if kind is None:
        raise UsageError(
            f'{what} needs the effect with role = "{role}", and none in vcmm/physics/ has it; put its file and its line in ALL '
            f"back, or leave out {what}"
        )
    return kind


def has_role(name: str, role: str) -> bool:
    """Whether the effect of that name, such as that of an Input, has a role."""
    kind = BY_NAME.get(name)
    return kind is not None and kind.role == role
