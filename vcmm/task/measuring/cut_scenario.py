"""CutScenario: a part that is cut and then measured, as data: program, machine tool, set-up, part and inspection."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from vcmm.core.inputs import Input
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Series
from vcmm.part.part import Part
from vcmm.program.setup import Setup
from vcmm.task.measuring.fixture import Fixture
from vcmm.task.measuring.plan import Plan
from vcmm.task.measuring.qualification import Qualification
from vcmm.task.measuring.settings import Settings

IDEAL, SAME_MACHINE, OTHER = "ideal", "same", "machine"


@dataclass(frozen=True, eq=False)
class Inspection:
    """Measurement of the finished part: kind "ideal" (no errors), "same" (on the machine tool) or "machine" (on a CMM)."""

    kind: str = IDEAL
    machine: Machine | None = None
    pose: Pose | None = None
    constants: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class CutScenario:
    """program: NC file. pose: machine_from_part in the machine tool, workpiece axes.

    set_here: the work offset was set on this very machine, at `set_at` (mm, workpiece axes; None = the work zero), so
    that its error there is subtracted; with the rotary axes at zero, or set_as_cut: at their angles while it is used. step: longest
    stretch of path between two states of the machine, mm.
    """

    name: str
    machine: Machine
    program: Path
    setup: Setup
    part: Part
    plan: Plan | None = None
    pose: Pose | None = None
    dialect: str | None = None
    constants: Mapping[str, float] = field(default_factory=dict)
    inputs: tuple[Input, ...] = ()
    qualifications: Mapping[str, Qualification] = field(default_factory=dict)
    inspection: Inspection = field(default_factory=Inspection)
    settings: Settings = field(default_factory=Settings)
    set_here: bool = True
    set_at: tuple[float, float, float] | None = None
    set_as_cut: bool = False
    step: float = 1.0
    work_spindle: int = (
        1  # of a lathe with two: the part in this one is cut, what is cut in the other is left out
    )
    batch_part: int = 1  # which part in a row: wear and warmth of those before it count
    force_log: Mapping[str, Series] = field(
        default_factory=dict
    )  # measured forces, by column; instead of the model
    u_width: Mapping[int, float] = field(default_factory=dict)  # of groove tools, mm
    load_log: Series | None = None  # measured cutting power, W
    touch_scatter: Mapping[int, float] = field(
        default_factory=dict
    )  # u (mm) of one touch of the program, by the tool that probes
    fixture: Fixture | None = None  # what `place` may move
    weights: Mapping[str, float] = field(default_factory=dict)  # of the characteristics in `place`, sum 1
    found_since: Mapping[str, str] = field(
        default_factory=dict
    )  # id of an Input of setting up -> evidence in the machine file, which holds instead
    record: Mapping[str, str] = field(default_factory=dict)  # who, when, serial numbers: words for the report

    def __repr__(self) -> str:
        names = ", ".join(c.name for c in self.part.characteristics)
        return f"<CutScenario {self.name}: {self.program.name} on {self.machine.name}; {names}>"
