"""The tables of a machine file (machine/1) as pydantic models, and [record], which scenarios and recordings have too: keys, units, defaults."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field, WithJsonSchema

from vcmm.core.errors import DataError
from vcmm.files.own.certificate_keys import OLDER_KEYS
from vcmm.files.schema import (
    AngleSpread,
    AxisAcceleration,
    AxisJerk,
    AxisSpeed,
    Direction,
    Expansion,
    ExpansionSpread,
    Frequency,
    KelvinSpread,
    Mass,
    Point,
    Size,
    Spread,
    Table,
    pair_of,
)
from vcmm.files.toml import Document, Location, check_version, read_toml


class RecordTable(Table):
    by: str = Field(default="", examples=['"A. Person"'])
    date: str = Field(default="", examples=['"2026-11-22"'])
    laboratory: str = ""
    machine_serial: str = ""
    machine_certificate: str = ""
    probe: str = ""
    reference_sphere: str = Field(default="", examples=['"25 mm, SN 7; certificate 2026-118"'])
    standards: str = Field(default="", examples=['"step gauge SN 3; certificate 2026-031"'])
    thermometers: str = Field(default="", examples=['"part sensor SN 9; certificate 2026-204"'])
    part_serial: str = ""
    drawing: str = Field(default="", examples=['"D-1234 rev. B"'])
    order: str = ""
    remarks: str = ""

    @property
    def entries(self) -> dict[str, str]:
        """Entries that are not empty."""
        return {k: v for k, v in self.model_dump().items() if v}


def _travel(value: object) -> list[str]:
    """Return two ends, or "endless", kept as a list of one."""
    if value == ["endless"] or value == "endless":
        return ["endless"]
    try:
        return pair_of('["0 mm", "600 mm"]', value)
    except ValueError as error:
        raise ValueError(f'{error}; a rotary axis that turns on and on has travel = "endless"') from None


AxisTravel = Annotated[
    list[str],
    BeforeValidator(_travel),
    WithJsonSchema(
        {
            "anyOf": [
                {"type": "array", "items": {"type": "string"}, "minItems": 2, "maxItems": 2},
                {"type": "string", "const": "endless"},
            ],
            "examples": ['["0 mm", "600 mm"]', '"endless"'],
        }
    ),
]


class Dynamics(Table):
    speed: AxisSpeed | None = None
    acceleration: AxisAcceleration | None = None
    jerk: AxisJerk | None = None
    gain: Frequency | None = None
    feed_forward: float | None = Field(default=None, ge=0, le=1, allow_inf_nan=False, examples=["0.9"])


class AxisTable(Table):
    travel: AxisTravel
    centre: Point = (0.0, 0.0, 0.0)
    measured_at: Point | None = None
    error_frame: Literal["moving", "fixed"] = "moving"
    direction: Direction | None = None
    dynamics: Dynamics = Field(default_factory=Dynamics)


class Uncertainty(Table):
    translation: Spread = 0.0
    rotation: AngleSpread = 0.0
    squareness: AngleSpread = 0.0
    correlation_length: Size | None = None


class Errors(Table):
    table: str = Field(examples=['"errors.csv"'])
    state: Literal["residual", "raw"] = "residual"
    compensation: list[str] = Field(default_factory=list)
    interpolation: Literal["linear", "cubic"] = "linear"
    uncertainty: Uncertainty | None = None
    covariance: str | None = Field(default=None, examples=['"errors_covariance.csv"'])
    evidence: str = "calibration of the error table"


class Repeatability(Table):
    law: Literal["normal", "t"] = "normal"
    u: Spread | None = None
    scale: Spread | None = None
    dof: float | None = Field(default=None, ge=1, allow_inf_nan=False, examples=["6"])
    nu: float | None = Field(default=None, ge=1, allow_inf_nan=False, examples=["6"])


class Scales(Table):
    expansion: Expansion
    u_expansion: ExpansionSpread = 0.0
    compensated: bool = True
    u_sensor: KelvinSpread = 0.0


class MachineEnvironment(Table):
    scales: Scales | None = None


class CertificateTable(Table):
    other_names: ClassVar[Mapping[str, str]] = OLDER_KEYS
    E0_MPE: str | None = Field(default=None, examples=['"1.8 um + L/350"'])
    E150_MPE: str | None = Field(default=None, examples=['"2.2 um + L/350"'])
    R0_MPL: str | None = Field(default=None, examples=['"1.5 um"'])
    P_Form_Sph_1x25: str | None = Field(default=None, examples=['"1.8 um"'])
    P_Size_Sph_1x25: str | None = Field(default=None, examples=['"1.5 um"'])
    R0_MPE: str | None = (
        None  # the same limits as data sheets and editions of ISO 10360-5 name them: certificate_keys.py
    )
    P_Form_Sph_1x25_MPE: str | None = None
    P_Size_Sph_1x25_MPE: str | None = None
    PFTU_MPE: str | None = None
    PSTU_MPE: str | None = None
    P_Form_Sph_5x25_MPE: str | None = None
    P_Size_Sph_5x25_MPE: str | None = None
    L_Dia_5x25_MPE: str | None = None
    PFTE_MPE: str | None = None
    PSTE_MPE: str | None = None
    PLTE_MPE: str | None = None
    PFTM_MPE: str | None = None
    PSTM_MPE: str | None = None
    PLTM_MPE: str | None = None
    THP_MPE: str | None = None
    iso230_2: dict[str, str] | None = Field(default=None, examples=['{ A = "8 um", R = "4 um" }'])
    prior: str = Field(default="limit", examples=['"limit"'])
    measured: dict[str, Any] | None = Field(
        default=None,
        examples=['{ R0 = "0.8 um", P_Form = "0.9 um", E0_largest = { error = "1.1 um", u = "0.15 um" } }'],
    )


class Tracked(Table):
    at: str = Field(examples=['"2026-12-01"'])
    last_check: str = Field(examples=['"2026-11-20"'])
    covariance: str = Field(examples=['"machine_state.csv"'])
    since: str | None = Field(default=None, examples=['"machine_since.csv"'])


class MachineFile(Table):
    """machine/1"""

    vcmm: str
    name: str = ""
    kind: Literal["cmm", "machine-tool", "lathe"] = "cmm"
    structure: str = Field(examples=['"w b Y X Z t"'])
    axes: dict[str, AxisTable] = Field(examples=['{ X = { travel = ["0 mm", "600 mm"] } }'])
    errors: Errors | None = None
    tracked: Tracked | None = None
    repeatability: Repeatability | None = None
    environment: MachineEnvironment | None = None
    effects: list[dict[str, Any]] = Field(default_factory=list)
    inputs: list[dict[str, Any]] = Field(default_factory=list)
    load_limit: Mass | None = None
    large_errors: bool = False
    certificate: CertificateTable | None = None
    record: RecordTable = Field(default_factory=RecordTable)


def found_machine(path: str | Path) -> tuple[Document, dict[str, Any], Location]:
    """Return the table of a machine file, or of the machine of a scenario, which may name a file."""
    document = read_toml(path)
    stated = document.data.get("machine")
    if not str(document.data.get("vcmm", "")).startswith("scenario/"):
        check_version(document, "machine")
        return document, document.data, ()
    if isinstance(stated, str):
        return found_machine(document.path.parent / stated)
    if not isinstance(stated, dict):
        raise DataError(
            f"{document.path}: the scenario states no machine; add [machine], or name a machine file"
        )
    return document, stated, ("machine",)
