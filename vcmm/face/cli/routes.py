"""vcmm routes: evaluate the same task by independent routes, and check that they agree."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vcmm.answer.routes.job import RouteData, RoutesResult, routes
from vcmm.face.cli.options import Evidence, InputFile, Json
from vcmm.face.job import Flags, Job, Pack, Progress, Record, run_job
from vcmm.files.own.routes import read_route_data
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say_warnings, show_answers, show_table
from vcmm.show.tables.answers import routes_answers
from vcmm.show.tables.routes import agreements_table, contributions_table, routes_json, routes_table
from vcmm.show.tables.table import csv_text
from vcmm.task.measuring.scenario import Scenario


def routes_command(
    scenario: InputFile,
    *,
    calibrated: InputFile | None = None,
    repeats: InputFile | None = None,
    positions: InputFile | None = None,
    standards: InputFile | None = None,
    values: InputFile | None = None,
    trials: int | None = None,
    seed: int | None = None,
    json: Json = False,
    out: Path | None = None,
    evidence: Evidence = None,
) -> int:
    """Evaluate the same task by independent routes: virtual CMM, calibrated part (ISO 15530-3), several positions; E_n between them.

    Without measured data all of it is measured on a machine and parts that are drawn and hidden from the routes.
    Exit code 1 when two routes do not agree.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    calibrated
        Certificate of a calibrated part: characteristic,value_mm,U_um,k.
    repeats
        What you measured of it, again and again: characteristic,value_mm (temp_part_C).
    positions
        The part itself in several positions: position,characteristic,value_mm.
    standards
        Standards for --positions: standard (length, centres, ring, sphere),calibrated_mm,U_um,k,reading_mm.
    values
        The part itself, measured once: characteristic,value_mm.
    trials
        Monte Carlo trials (default: the scenario's).
    seed
        Seed of the random streams and of the drawn machine (default: the scenario's).
    json
        Print one JSON document.
    out
        Folder for report.html, routes.json, routes.csv.
    evidence
        Zip with all files, versions, seed, influences covered and the document; `vcmm rerun` runs it again and compares.
    """
    files = {
        "calibrated": calibrated, "repeats": repeats, "positions": positions, "standards": standards, "values": values,
    }  # fmt: skip
    changes = {k: v for k, v in (("seed", seed), ("trials", trials)) if v is not None}
    return run_job(RoutesJob(scenario, files, changes), Flags(json, out, evidence))


class RoutedTask(NamedTuple):
    """A scenario, and the measured data; None where they are simulated on a sampled machine."""

    scenario: Scenario
    data: RouteData | None


@dataclass(frozen=True)
class RoutesJob(Job[RoutedTask, RoutesResult]):
    """One task by independent routes. files: measured data, by option; changes: of the settings."""

    scenario: Path
    files: dict[str, Path | None]
    changes: dict[str, int]
    schema = "vcmm.routes/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, ""

    def _input_files(self) -> list[Path]:
        return [f for f in self.files.values() if f is not None]

    def load(self) -> RoutedTask:
        scenario = load_scenario(self.scenario)
        return RoutedTask(scenario, read_route_data(scenario, **self.files) if self._input_files() else None)

    def run(self, loaded: RoutedTask, report: Progress) -> RoutesResult:
        settings = loaded.scenario.settings.with_changes(**self.changes)
        return routes(loaded.scenario, loaded.data, settings=settings, progress=report)

    def record(self, loaded: RoutedTask, result: RoutesResult) -> Record:
        files = [*sources(self.scenario), *self._input_files()]
        return Record(routes_json(result), files, result.seed, result.remarks)

    def pack(self, loaded: RoutedTask) -> Pack:
        return Pack("routes", self.scenario, self.files | self.changes, loaded.scenario.task())

    def texts(self, loaded: RoutedTask, result: RoutesResult, content: str, folder: Path) -> dict[str, str]:
        from vcmm.show.pages.routes import routes_page

        return {
            "report.html": routes_page(loaded.scenario, result),
            "routes.json": content,
            "routes.csv": csv_text(contributions_table(result)),
        }

    def files_sentence(
        self, loaded: RoutedTask, result: RoutesResult, folder: Path, names: Sequence[str]
    ) -> str:
        return f"wrote {', '.join(f'{folder}/{name}' for name in names)}"

    def exit_code(self, loaded: RoutedTask, result: RoutesResult) -> int:
        return int(not result.agree)

    def show(self, loaded: RoutedTask, result: RoutesResult) -> None:
        show_answers(routes_answers(result))
        show_table(routes_table(result))
        show_table(agreements_table(result))
        sentences = [
            f"{c.name}, {e.route}: {t}" for c in result.characteristics for e in c.routes for t in e.remarks
        ]
        say_warnings(dict.fromkeys((*result.remarks, *sentences)))
