"""vcmm calibrate program: the touches of a plan as a program of the control, its recording file and its set-up file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from vcmm.core.errors import VcmmError
from vcmm.face.cli.calibrate_poses import in_order_of_angles
from vcmm.face.job import Job, Progress, Record
from vcmm.files.own.touch_plan import TouchPlan, load_touch_plan, probing_job, recording_text, setup_text
from vcmm.learn.calibration.design import PlannedSetup
from vcmm.learn.calibration.pose_design import best_poses, pose_plan
from vcmm.program.interpret import interpret
from vcmm.program.probing_program import LOG, ProbingJob, probing_texts
from vcmm.program.setup import Setup, Tool
from vcmm.show.console.documents import sources

SAME_TOUCH_MM = 1e-3  # mm: touches read back lie this near to those of the plan; programs state 0.1 um
ABOVE = 30.0  # mm: from the highest that a turning sphere reaches to where rotary axes may turn
STANDOFF = 10.0  # mm


class ProbingProgram(NamedTuple):
    """Files by name, how many rotary positions, how long (minutes), and how far (mm) the program reads back beside the plan."""

    job: ProbingJob
    texts: dict[str, str]
    poses: int
    minutes: float
    farthest: float


@dataclass(frozen=True)
class ProgramJob(Job[TouchPlan, ProbingProgram]):
    """The program written and read back by what `vcmm nc` understands, and the recording file for its log. folder: of --out."""

    plan: Path
    control: str
    folder: Path
    tool: int
    schema, names_files_last = "vcmm.probing_program/1", True

    def load(self) -> TouchPlan:
        return load_touch_plan(self.plan)

    def run(self, loaded: TouchPlan, report: Progress) -> ProbingProgram:
        """Raises VcmmError where the program reads back beside its plan."""
        chosen, minutes = _poses(loaded)
        job = probing_job(loaded, chosen, STANDOFF, ABOVE, self.tool)
        texts = probing_texts(job, self.control)
        texts["touch.toml"] = recording_text(loaded, LOG, self.folder)
        texts["setup.toml"] = setup_text(loaded, job, self.control, self.folder)
        farthest = _read_back(job, texts, self.control)
        if farthest > SAME_TOUCH_MM:
            raise VcmmError(f"the program reads back {farthest:.4f} mm beside its plan; nothing is written")
        return ProbingProgram(job, texts, len(chosen), minutes, farthest)

    def record(self, loaded: TouchPlan, result: ProbingProgram) -> Record:
        job = result.job
        body = {
            "control": self.control,
            "files": [str(self.folder / name) for name in result.texts],
            "poses": result.poses,
            "touches": len(job.touches),
            "minutes": result.minutes,
            "clear_mm": job.clear,
            "read_back": {"touches": len(job.touches), "farthest_mm": result.farthest},
        }
        return Record(body, sources(self.plan))

    def texts(self, loaded: TouchPlan, result: ProbingProgram, content: str, folder: Path) -> dict[str, str]:
        return result.texts

    def files_sentence(
        self, loaded: TouchPlan, result: ProbingProgram, folder: Path, names: Sequence[str]
    ) -> str:
        return (
            f"wrote {', '.join(str(folder / name) for name in names)}\n"
            "collisions are not looked for: run it first above the table, with reduced rapids\n"
            f"next: copy {LOG} of the control beside touch.toml, then vcmm calibrate fit {folder / 'touch.toml'} --machine machine.toml --out found.toml"
        )

    def show(self, loaded: TouchPlan, result: ProbingProgram) -> None:
        job = result.job
        print(
            f"{len(job.touches)} touches at {result.poses} rotary positions, about {result.minutes:.3g} min; rotary axes turn at Z {job.clear:g} mm"
        )
        print(f"read back: {len(job.touches)} touches, farthest {result.farthest * 1e3:.2f} um from the plan")


def _poses(given: TouchPlan) -> tuple[list[dict[str, float]], float]:
    """Return rotary positions (rad): within the budget of the plan, else all."""
    if given.budget is None or not any(len(q) > 1 for q in given.table.rotary.values()):
        return given.poses, given.table.minutes
    plan = pose_plan([PlannedSetup(*given.setup)], given.machine)
    chosen = best_poses(plan, given.budget)
    return [plan.candidates[i].angles for i in in_order_of_angles(plan, chosen)], plan.minutes(chosen)


def _read_back(job: ProbingJob, texts: dict[str, str], control: str) -> float:
    """Return the mm by which a touch of the program, read as `vcmm nc` reads it, lies farthest beside the plan. Raises VcmmError where
    one is missing."""
    probe = Tool(job.tool, length=100.0, diameter=2 * job.ball, shape="probe")
    setup = Setup(tools={job.tool: probe}, offsets={job.offset: (0.0, 0.0, 0.0)}, strict=False)
    read = interpret(next(iter(texts.values())), control, setup, job.name)
    if len(read.touches) != len(job.touches):
        raise VcmmError(
            f"the program reads back with {len(read.touches)} touches of {len(job.touches)}; nothing is written"
        )
    farthest = 0.0
    for touch, met in zip(job.touches, read.touches):
        middle = np.array(met.tip) + [0.0, 0.0, job.ball]
        surface = middle + job.ball * np.array(touch.way)
        turned = [float(np.radians(touch.rotary.get(a, 0.0))) for a in "ABC"]
        beside = float(np.abs(surface - touch.surface).max())
        arm = float(np.linalg.norm(touch.surface)) * float(np.abs(np.array(met.rotary) - turned).max())
        farthest = max(farthest, beside, arm, 1e3 * float(np.abs(np.array(met.along) - touch.way).max()))
    return farthest
