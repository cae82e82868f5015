"""vcmm.track/1, the document of `vcmm track` (track.json): its keys with their types, for the JSON Schema.

Lengths in mm and angles in rad, but where a `unit` is given beside the number. A number that is not finite is null, and the document warns of it.
"""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

NAME = "vcmm.track/1"
Number = float | None
Unit = Literal["mm", "rad"]
Share = float


class DocumentTable(BaseModel):
    """A part of a document: every key is named here."""

    model_config = ConfigDict(extra="forbid", defer_build=True)


class ReadFile(DocumentTable):
    file: str
    sha256: str = Field(pattern="^[0-9a-f]{64}$")


class DocumentWarning(DocumentTable):
    severity: Literal["note", "warning", "error"]
    where: str
    text: str
    cure: str


class LearntRate(DocumentTable):
    """Random change of a group of numbers, in words: usual sizes of the parameter, per year."""

    group: str
    model: str
    log_prior: float


class FollowedParameter(DocumentTable):
    """A number after every recording: `time` its dates, value and standard uncertainty in `unit`; of a table its end less its start."""

    input: str
    unit: str
    of: str = Field(description='"number", or what of a table')
    time: list[str]
    value: list[Number]
    u: list[Number]


class ProbableChange(DocumentTable):
    name: str
    probability: Share = Field(ge=0, le=1.000001)


class CheckOfRecording(DocumentTable):
    """A recording as it was predicted; rms in units of the noise of a reading."""

    recording: str
    date: str
    rows: int = Field(ge=0)
    combinations_seen: int = Field(ge=0)
    noise_scale: Number
    outliers: int = Field(ge=0)
    chance: Number = Field(description="of an innovation as large, had nothing changed")
    level: float = Field(gt=0, description="below this chance the recording is an alarm")
    alarm: bool
    rms_predicted: Number
    rms_unchanged: Number
    innovation_over_u: Number
    probability_of_change: Number
    changed: list[ProbableChange]


class Alarm(DocumentTable):
    recording: str
    date: str
    since: str | None = Field(description="date of the last recording before it that was as predicted")
    chance: Number
    level: float
    probability_of_change: Number
    changed: list[ProbableChange]
    diagnosis: str | None = Field(
        description="what diagnose says of the recording; null where it did not run"
    )


class ForecastOfNumber(DocumentTable):
    """A number so many days after the last recording."""

    input: str
    days: float
    value: Number
    u: Number
    unit: str


class LimitOfTask(DocumentTable):
    """limit of U = 2 u; u_rest: standard uncertainty of everything but the machine.

    can_be_kept: false where 2 u_rest is above the limit, so that no check of the machine keeps it.
    """

    name: str
    limit: float
    u_rest: float
    unit: Unit
    can_be_kept: bool


class CheckToDo(DocumentTable):
    """holds_days: until a limit is reached again; null: a year and more, negative: not met."""

    check: str
    when: str
    U_after: dict[str, float]
    holds_days: int | None
    cost: float
    minutes: float


class FixedInterval(DocumentTable):
    check: str
    days: int
    cost: float


class PlanOfChecks(DocumentTable):
    days: int
    cost: float
    kept: bool
    because: str | None = Field(description="why the limits are not kept; null where they are")
    checks: list[CheckToDo]
    fixed_interval: FixedInterval | None


class PartInDoubt(DocumentTable):
    part: str
    date: str


class ShiftInDoubt(DocumentTable):
    characteristic: str
    shift: float
    u: float
    unit: Unit


class PartsInDoubt(DocumentTable):
    """Parts after the last good check (`since`) until an alarm, and by how much their characteristics are shifted, if the machine had changed by then."""

    alarm: str
    since: str | None
    parts: list[PartInDoubt]
    shifts: list[ShiftInDoubt]


class LearnedResidualOfTrack(DocumentTable):
    """Missing physics without a name; written to machine_learned.toml where it passed."""

    passed: bool
    said: str
    input: str
    component: str
    column: str | None
    kernel: str
    gain: Number
    foretold: Number
    rms_before: Number
    rms_after: Number
    earlier: list[str]
    later: list[str]
    nodes: list[float]
    levels: str | None
    values: list[Number]
    u: list[Number]


class TrackDocument(DocumentTable):
    """State of a machine that is followed in time."""

    schema_: Literal["vcmm.track/1"] = Field(alias="schema")
    version: str
    seed: int | None
    inputs: list[ReadFile]
    warnings: list[DocumentWarning]
    warning_texts: list[str]
    machine: str = Field(description="file of the machine as it is at `at`")
    name: str = Field(description="name of the machine")
    at: str
    last_check: str
    added: int = Field(ge=0, description="recordings that were new")
    alpha: float = Field(gt=0, lt=1)
    rates: list[LearntRate]
    parameters: list[FollowedParameter]
    checks: list[CheckOfRecording]
    alarms: list[Alarm]
    forecast: list[ForecastOfNumber]
    not_followed: list[str]
    limits: list[LimitOfTask] | None = None
    next_checks: list[CheckToDo] | None = None
    plan: PlanOfChecks | None = None
    doubtful: list[PartsInDoubt] | None = None
    learned: LearnedResidualOfTrack | None = None
