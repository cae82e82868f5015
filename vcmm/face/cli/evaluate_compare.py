"""vcmm evaluate --compare: a measured part evaluated, beside the prediction of its cut.

Prediction and measurement are one model: the part is cut with the errors of the machine tool and measured with those of the
measuring machine, so the difference is judged with the covariance of both.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from vcmm.answer.inference.given_points import GivenPoints
from vcmm.answer.inference.job import EvaluatedPart
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.knowledge import add_knowledge
from vcmm.face.api import evaluate
from vcmm.face.cli.cut import measured_points
from vcmm.face.cli.cut_measured import CameBack, came_back
from vcmm.face.cli.evaluated_parts import GivenMeasurement, show_parts
from vcmm.face.job import Job, Progress, Record, decision_code
from vcmm.files.own.cut_scenario import load_cut
from vcmm.files.own.scenario import load_scenario
from vcmm.files.toml import read_toml
from vcmm.show.console.complaints import about
from vcmm.show.console.documents import sources
from vcmm.show.tables.evaluation import evaluate_json
from vcmm.task.measuring.cut_scenario import OTHER, CutScenario, Inspection
from vcmm.task.measuring.scenario import Scenario


class CutAndMeasured(NamedTuple):
    """The file of the cut, the cut scenario that is inspected as measured, the measuring scenario or None, the points and u of one."""

    file: Path
    cut: CutScenario
    measuring: Scenario | None
    points: tuple[GivenPoints, float | None]


class EvaluatedBesideCut(NamedTuple):
    """The evaluation, none where no measuring machine is stated; measured beside predicted; the exit code of the decisions."""

    parts: tuple[EvaluatedPart, ...]
    back: CameBack
    code: int


@dataclass(frozen=True)
class EvaluateCompareJob(Job[CutAndMeasured, EvaluatedBesideCut]):
    """A measured part evaluated, and compared with its cut. scenario: with [cut] and [inspection], or of the measurement, and cut: of the cut
    part. further: --export or --evidence, which a comparison does not write; folder: of --out, for the recording."""

    scenario: Path
    cut: Path | None
    measurement: GivenMeasurement
    trials: int | None
    seed: int | None
    further: Path | None
    require: str | None
    folder: Path | None
    schema = "vcmm.uncertainty/1"

    def check(self) -> None:
        """Raise UsageError for options that a comparison does not use."""
        for flag, given in (
            ("--values", self.measurement.values),
            ("--tip-centres", self.measurement.tip_centres),
        ):
            if given:
                raise UsageError(
                    f"--compare takes measured points on the surface, --points points.csv; leave {flag} out"
                )
        if self.measurement.points is None:
            raise UsageError("--compare needs the measured points; add --points points.csv")
        if self.further:
            raise UsageError(
                "--export and --evidence are of an evaluation by itself; leave --compare out for them"
            )

    def load(self) -> CutAndMeasured:
        file, cut, measuring = _both(self.scenario, self.cut)
        return CutAndMeasured(file, cut, measuring, measured_points(self.measurement.file, ""))

    def run(self, loaded: CutAndMeasured, report: Progress) -> EvaluatedBesideCut:
        measurement = self.measurement
        parts: tuple[EvaluatedPart, ...] = ()
        if loaded.measuring is not None:
            with about(self.scenario):
                parts = tuple(evaluate(
                    loaded.measuring, points=measurement.points, frame=measurement.frame or "part", trials=self.trials, seed=self.seed, progress=report,
                ))  # fmt: skip
        folder = self.folder or measurement.file.parent
        in_machine = measurement.frame == "machine"
        back = came_back(
            loaded.file, loaded.cut, loaded.points, in_machine=in_machine, seed=self.seed, folder=folder, report=report
        )  # fmt: skip
        code = decision_code((e.result for p in parts for e in p.characteristics), self.require)
        warnings = [*(w for p in parts for w in p.warnings), *_unsaid(loaded.measuring), *back.warnings]
        return EvaluatedBesideCut(parts, replace(back, warnings=tuple(dict.fromkeys(warnings))), code)

    def record(self, loaded: CutAndMeasured, result: EvaluatedBesideCut) -> Record:
        parts, back, _ = result
        body = evaluate_json(parts) if parts else {"characteristics": []}
        named = [*sources(self.scenario), *(sources(self.cut) if self.cut else ())]
        files = dict.fromkeys([*named, loaded.cut.program, self.measurement.file])
        seed = parts[0].uncertainty.seed if parts else loaded.cut.settings.seed
        return Record(body | back.json, [*files], seed, back.warnings)

    def texts(
        self, loaded: CutAndMeasured, result: EvaluatedBesideCut, content: str, folder: Path
    ) -> dict[str, str]:
        return {"evaluation.json": content}

    def exit_code(self, loaded: CutAndMeasured, result: EvaluatedBesideCut) -> int:
        return result.code

    def show(self, loaded: CutAndMeasured, result: EvaluatedBesideCut) -> None:
        if result.parts:
            show_parts(result.parts, ())
        result.back.show()


def _both(scenario: Path, cut: Path | None) -> tuple[Path, CutScenario, Scenario | None]:
    """Return (file of the cut, cut scenario that is inspected as measured, measuring scenario or None)."""
    if "cut" in read_toml(scenario).data:
        if cut is not None:
            raise UsageError(f"{scenario} holds a [cut] itself; leave --cut out")
        loaded = load_cut(scenario)
        return scenario, loaded, inspecting(loaded)
    if cut is None:
        raise UsageError(
            f"{scenario} says nothing of how the part was cut: add --cut block.toml, the scenario with the table [cut]"
        )
    measuring = load_scenario(scenario)
    return cut, inspect_cut(load_cut(cut), measuring), measuring


def inspect_cut(cut: CutScenario, measuring: Scenario) -> CutScenario:
    """Return the cut scenario, its part measured as a measuring scenario says. UsageError: features that are not of the cut part."""
    for name in measuring.part.features:
        if name not in cut.part.features:
            raise UsageError(
                f'the feature "{name}" is measured, but the part that is cut has none of that name.{choose_from(name, cut.part.features)}'
            )
    machine = add_knowledge(measuring.machine, inputs=measuring.inputs)
    how = Inspection(OTHER, machine, measuring.pose, measuring.constants)
    return replace(
        cut, part=measuring.part, plan=measuring.plan, qualifications=measuring.qualifications, inspection=how
    )


def inspecting(cut: CutScenario) -> Scenario | None:
    """Return the measuring scenario of [inspection]; None where no measuring machine is stated."""
    how = cut.inspection
    if how.kind != OTHER or how.machine is None or how.pose is None or cut.plan is None:
        return None
    return Scenario(
        cut.name, how.machine, cut.part, cut.plan, how.pose, how.constants, qualifications=cut.qualifications,
        settings=cut.settings,
    )  # fmt: skip


def _unsaid(measuring: Scenario | None) -> tuple[str, ...]:
    if measuring is not None:
        return ()
    return (
        "no measuring machine is stated ([inspection] machine and pose), so true values are not evaluated: only measured beside predicted",
    )
