"""Errors of machines: one family of effects per file, listed here with one line each.

`structure` holds the effects that the program itself creates; modules import them directly. No module imports a file of `catalogue`: code that needs
to know something of such an effect reads its declaration, and any of those files can be deleted with its lines here.
"""

from __future__ import annotations

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError, choose_from
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.clamping import Clamping
from vcmm.physics.catalogue.cutting import ToolRunout, ToolWear
from vcmm.physics.catalogue.drift import LinearDrift, SettlingDrift, StepChange
from vcmm.physics.catalogue.drift_vector import DriftVector, StepVector, ThermalVector
from vcmm.physics.catalogue.dynamics import DynamicPitch, StructuralVibration
from vcmm.physics.catalogue.encoder import EncoderInterpolation
from vcmm.physics.catalogue.encoder_harmonics import EncoderHarmonics
from vcmm.physics.catalogue.flexure import CrossAxisFlexure, GradientBending, PartLoad
from vcmm.physics.catalogue.gravity import GravityFlexure
from vcmm.physics.catalogue.heating import ScrewHeating
from vcmm.physics.catalogue.lag import ReadoutDelay, RotaryReadoutDelay, ServoLag
from vcmm.physics.catalogue.laser import AirIndex, CosineError, DeadPath
from vcmm.physics.catalogue.learned_residual import LearnedResidual
from vcmm.physics.catalogue.map_interpolation import MapInterpolation
from vcmm.physics.catalogue.pitch import ScrewPitch
from vcmm.physics.catalogue.plate_bow import PlateBow
from vcmm.physics.catalogue.play import BacklashRamp, LoadedPlay, PlayOperator
from vcmm.physics.catalogue.play_speed import SpeedPlay
from vcmm.physics.catalogue.probe import ProbeLobing, StylusBending, TriggerDelay
from vcmm.physics.catalogue.reversal import Hysteresis, LostMotion, ReversalSpike
from vcmm.physics.catalogue.reversal_curve import LostMotionCurve
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.catalogue.spindle_load import SpindleLoadGrowth
from vcmm.physics.catalogue.tilt import AxisLean, CentreLineOffset, CentreLineTilt
from vcmm.physics.catalogue.uniform_scale import UniformScale
from vcmm.physics.catalogue.workpiece import WorkpieceHeating
from vcmm.physics.catalogue.workpiece_bending import WorkpieceBending
from vcmm.physics.structure.abbe import AbbeCountedTwice, AbbeOffset
from vcmm.physics.structure.component import (
    CalibrationModes,
    ComponentPolynomial,
    ComponentSpline,
    ComponentTable,
    ComponentWarming,
)
from vcmm.physics.structure.digits import Resolution
from vcmm.physics.structure.elastic_joint import ElasticJoint
from vcmm.physics.structure.expansion import PartExpansion, ScaleExpansion
from vcmm.physics.structure.geometric_change import GeometricChange
from vcmm.physics.structure.lost_motion_table import LostMotionTable
from vcmm.physics.structure.qualification import StylusQualification
from vcmm.physics.structure.residual import CorrelatedField, ResidualField
from vcmm.physics.structure.room import RoomDrift, RoomDriftOfScale, RoomGradient
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.physics.structure.scatter import Reindexing, Scatter
from vcmm.physics.structure.setting import ProbeTouch, ToolLength, ToolOffset, ToolRadius, WorkOffset
from vcmm.physics.structure.spindle_growth import SpindleGrowth
from vcmm.physics.structure.squareness import RotaryLocation, Squareness
from vcmm.physics.structure.thermal import ThermalDrift, ThermalDriftTwoLags
from vcmm.physics.structure.tip import TipOffset, TipRadius
from vcmm.physics.structure.tip_form import TipForm
from vcmm.physics.structure.tool_bending import ToolDeflection

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
    LearnedResidual,
    CrossAxisFlexure,
    PartLoad,
    GravityFlexure,
    ElasticJoint,
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
    SpeedPlay,
    PlayOperator,
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
    RoomDrift,
    RoomDriftOfScale,
    RoomGradient,
)
BY_NAME: dict[str, type[Effect]] = {effect.name: effect for effect in ALL}


def find(name: str) -> type[Effect]:
    """Return the effect class of a name. Raises UsageError with the closest name."""
    if name not in BY_NAME:
        raise UsageError(f'unknown effect "{name}".{choose_from(name, BY_NAME)}')
    return BY_NAME[name]
