"""The tables of a cutting scenario (scenario/1 with [cut]) as pydantic models: keys, units, defaults."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field

from vcmm.files.own.environment import (
    Temperatures,
)
from vcmm.files.own.placement import PlacementTable
from vcmm.files.own.record import RecordTable
from vcmm.files.own.scenario import (
    PoseTable,
)
from vcmm.files.own.setup import by_number
from vcmm.files.schema import Compliance, Point, Size, Spread, Table
from vcmm.task.measuring.cut_scenario import IDEAL


class OffsetTable(Table):
    """Setting of the work offset. rotary: positions of the rotary axes during it."""

    set_on: Literal["this machine", "elsewhere"] = "this machine"
    at: Point | None = None
    rotary: Literal["zero", "as cut"] = "zero"
    u: Spread = 0.0


class ToolKnowledge(Table):
    """Uncertainties of the tool setter. u_offset_x (radius) and u_offset_y (height of the tip): of turning and driven tools;
    u_width: of the edge of groove tools; u_touch: scatter of one touch of a program that probes with
    this tool.

    compliance: of the tool across its axis; where it is not said, that of a rod of the stick-out of the set-up.
    """

    u_length: Spread = 0.0
    u_radius: Spread = 0.0
    u_offset_x: Spread = 0.0
    u_offset_y: Spread = 0.0
    u_width: Spread = 0.0
    u_touch: Spread = 0.0
    compliance: Compliance | None = None
    u_compliance: Compliance = 0.0


class CutTable(Table):
    """batch_part: which part in a row, without pauses; tools are worn and spindle and screws warm from those before."""

    program: str = Field(examples=['"part.nc"'])
    setup: str = Field(examples=['"setup.toml"'])
    dialect: str | None = None
    work_offset: OffsetTable = Field(default_factory=OffsetTable)
    tools: Annotated[dict[str, ToolKnowledge], BeforeValidator(by_number)] = Field(
        default_factory=dict, examples=['{ 1 = { u_radius = "3 um" } }']
    )
    step: Size = 1.0
    work_spindle: Annotated[int, Field(ge=1, le=9)] = 1
    batch_part: Annotated[int, Field(ge=1)] = Field(default=1, examples=["20"])
    force_log: str | None = Field(default=None, examples=['"forces.csv"'])
    load_log: str | None = Field(default=None, examples=['"load.csv"'])


class InspectionTable(Table):
    """machine: "ideal", "same", a machine file or table. temperature: of a measuring machine, 20 degC unless stated."""

    machine: str | dict[str, Any] = IDEAL
    pose: PoseTable | None = None
    temperature: Temperatures = Field(default_factory=Temperatures)


class CutFile(Table):
    """scenario/1 with [cut]"""

    vcmm: str
    name: str = ""
    machine: str | dict[str, Any] | None = Field(default=None, examples=['"mill.toml"'])
    cut: CutTable
    part: str | dict[str, Any] = Field(examples=['"part.toml"'])
    plan: str | dict[str, Any] | None = None
    inspection: InspectionTable = Field(default_factory=InspectionTable)
    pose: PoseTable | None = None
    environment: str | dict[str, Any] = Field(default_factory=dict, examples=['"environment.toml"'])
    job: str | dict[str, Any] = Field(default_factory=dict, examples=['"job.toml"'])
    effects: list[dict[str, Any]] = Field(default_factory=list)
    inputs: list[dict[str, Any]] = Field(default_factory=list)
    placement: PlacementTable = Field(default_factory=PlacementTable)
    record: RecordTable = Field(default_factory=RecordTable)
