"""vcmm evaluate: from measured points or values to true values, decisions and budgets."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from vcmm.answer.inference.job import EvaluatedPart
from vcmm.face.api import check_inputs, evaluate
from vcmm.face.cli.evaluated_parts import GivenMeasurement, show_parts
from vcmm.face.cli.options import Evidence, InputFile, Json, Require
from vcmm.face.job import Flags, Job, Pack, Progress, Record, decision_code, run_job
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.documents import sources
from vcmm.show.console.files import output_folder, write_text
from vcmm.show.console.terminal import say
from vcmm.show.tables.evaluation import evaluate_json, values_csv, warnings_of_parts
from vcmm.show.tables.uncertainty import budget_csv
from vcmm.task.measuring.scenario import Scenario


def evaluate_command(
    scenario: InputFile,
    *,
    points: InputFile | None = None,
    values: InputFile | None = None,
    frame: Literal["part", "machine"] = "part",
    tip_centres: Annotated[bool, Parameter(name="--tip-centres", negative=())] = False,
    trials: int | None = None,
    seed: int | None = None,
    json: Json = False,
    out: Path | None = None,
    export: Path | None = None,
    evidence: Evidence = None,
    compare: Annotated[bool, Parameter(name="--compare", negative=())] = False,
    cut: InputFile | None = None,
    require: Require = None,
) -> int:
    """Evaluate what was measured: values, intervals of the true values, decisions, budgets. Exit code 1: one does not conform.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1): machine, part, plan, what is known.
    points
        Measured points: feature,x_mm,y_mm,z_mm (nx,ny,nz, part, stylus; without feature: in the order of the plan), or a QIF file.
    values
        Measured values: characteristic,value_mm (deviation_um, value_deg; part).
    frame
        Where the points are: part, the drawing frame after alignment; machine, the axes of the machine.
    tip_centres
        The points are centres of the tip, not compensated for its radius.
    trials
        Monte Carlo trials (default: the scenario's).
    seed
        Seed of the random streams (default: the scenario's).
    json
        Print one JSON document.
    out
        Folder for evaluation.json, values.csv, a sheet per part, and of one part report.html and budget.csv.
    export
        File for another system, by its ending: .qif (QIF 3.0 with combinedUncertainty), .dfq (Q-DAS), .xml (results of a DCC).
    evidence
        Zip with all files, versions, seed, influences covered and the document; `vcmm rerun` runs it again and compares.
    compare
        Say also where the part departs from what was predicted when it was cut; the scenario holds [cut], or --cut names it.
    cut
        With --compare, of a scenario of the measurement: the scenario with the table [cut].
    require
        conforms: exit code 1 also where a characteristic is undecided, not only where one does not conform.
    """
    given = GivenMeasurement(points, values, None if values and frame == "part" else frame, tip_centres)
    flags = Flags(json, out, evidence)
    if compare or cut:
        from vcmm.face.cli.evaluate_compare import EvaluateCompareJob

        further = export or evidence
        job = EvaluateCompareJob(
            scenario, cut, given, trials=trials, seed=seed, further=further, require=require, folder=out
        )
        return run_job(job, Flags(json, out))
    return run_job(EvaluateJob(scenario, given, trials, seed, export, require), flags)


@dataclass(frozen=True)
class EvaluateJob(Job[Scenario, tuple[EvaluatedPart, ...]]):
    """The true values of parts that were measured."""

    scenario: Path
    measured: GivenMeasurement
    trials: int | None
    seed: int | None
    export_file: Path | None
    require: str | None
    schema = "vcmm.uncertainty/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, ""

    def check(self) -> None:
        """Check the options before the scenario is read: no line of it is wrong."""
        given = self.measured
        check_inputs(given.points, given.values, given.frame or "part", given.tip_centres)
        if self.export_file:
            from vcmm.files.foreign.export import check_ending

            check_ending(self.export_file)

    def load(self) -> Scenario:
        return load_scenario(self.scenario)

    def run(self, loaded: Scenario, report: Progress) -> tuple[EvaluatedPart, ...]:
        given = self.measured
        return evaluate(
            loaded, points=given.points, values=given.values, frame=given.frame or "part", tip_centres=given.tip_centres,
            trials=self.trials, seed=self.seed, progress=report,
        )  # fmt: skip

    def files(self) -> list[Path]:
        return [*sources(self.scenario), self.measured.file]

    def record(self, loaded: Scenario, result: tuple[EvaluatedPart, ...]) -> Record:
        seed = result[0].uncertainty.seed
        return Record(evaluate_json(result), self.files(), seed, warnings_of_parts(result))

    def pack(self, loaded: Scenario) -> Pack:
        options = {**self.measured.options(), "trials": self.trials, "seed": self.seed}
        return Pack("evaluate", self.scenario, options, loaded.task())

    def texts(
        self, loaded: Scenario, result: tuple[EvaluatedPart, ...], content: str, folder: Path
    ) -> dict[str, str]:
        from vcmm.show.pages.sheet import sheet_page
        from vcmm.show.pages.uncertainty import MEASURED, uncertainty_page

        texts = {"evaluation.json": content, "values.csv": values_csv(result)}
        if len(result) == 1:
            (part,) = result
            results = tuple(e.result for e in part.characteristics)
            whole = replace(part.uncertainty, characteristics=results, warnings=part.warnings)
            texts["report.html"] = uncertainty_page(loaded, whole, self.files(), MEASURED)
            texts["budget.csv"] = budget_csv(whole)
        for p in result:
            texts[_sheet_name(p.part, texts)] = sheet_page(loaded, p, self.files())
        return texts

    def files_sentence(
        self, loaded: Scenario, result: tuple[EvaluatedPart, ...], folder: Path, names: Sequence[str]
    ) -> str:
        return f"wrote {', '.join(f'{folder}/{name}' for name in names)}"

    def export(self, loaded: Scenario, result: tuple[EvaluatedPart, ...], content: dict[str, Any]) -> None:
        """Write the file for another system, from the displayed document."""
        if self.export_file is None:
            return
        from vcmm.files.foreign.export import export_text

        output_folder(self.export_file.parent)
        text, notes = export_text(self.export_file, loaded.name or "part", loaded.part, content)
        write_text(self.export_file, text)
        for note in notes:
            say(f"note: {note}")
        say(f"wrote {self.export_file}")

    def exit_code(self, loaded: Scenario, result: tuple[EvaluatedPart, ...]) -> int:
        return decision_code((e.result for p in result for e in p.characteristics), self.require)

    def show(self, loaded: Scenario, result: tuple[EvaluatedPart, ...]) -> None:
        show_parts(result, warnings_of_parts(result))


def _sheet_name(part: str, taken: Collection[str]) -> str:
    """Return a plain file name for the sheet of a part; numbered where another part has it already (a/b and a?b)."""
    plain = "".join(c if c.isalnum() or c in "-_." else "_" for c in part)
    names = (
        f"sheet{f'-{plain}' if plain else ''}{f'-{n}' if n > 1 else ''}.html"
        for n in range(1, len(taken) + 2)
    )
    lower_names = {name.lower() for name in taken}
    return next(name for name in names if name.lower() not in lower_names)
