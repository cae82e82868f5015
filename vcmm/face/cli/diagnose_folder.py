"""vcmm diagnose FOLDER: every recording of a folder by itself, and the changes from one to the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from vcmm.core.blocks import Sharing, key_of
from vcmm.face.job import Progress, Record, SharedJob
from vcmm.files.learned.fleet import Change, FolderJob, changes, diagnosed_folder, in_time
from vcmm.files.learned.fleet import Record as DiagnosedRecording
from vcmm.files.own.recording_data import recordings_in
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say, show_answers, show_table
from vcmm.show.tables import fleet as tables
from vcmm.show.tables.answers_runs import folder_answers
from vcmm.show.tables.table import csv_text
from vcmm.show.tables.table import records as as_records


class DiagnosedFolder(NamedTuple):
    """A record of every recording in the order of time, and the changes between them."""

    records: list[DiagnosedRecording]
    changes: list[Change]


@dataclass(frozen=True)
class DiagnoseFolderJob(SharedJob[list[Path], DiagnosedFolder]):
    """Every recording of a folder. Exit code 0: a recording that cannot be read is named in its row; 70 where one met an internal error."""

    scenario: Path  # the folder, under the key by which shards hold it
    seed: int
    machine: Path | None
    verb, schema = "diagnose", "vcmm.diagnosis-folder/1"

    @property
    def stem(self) -> str:
        return self.scenario.name

    def count_options(self) -> dict[str, Any]:
        return {"seed": self.seed, "machine": str(self.machine) if self.machine else None}

    def options(self) -> dict[str, object]:
        return {"scenario": str(self.scenario), **self.count_options()}

    def inputs(self) -> list[Path]:
        return self.files_of(recordings_in(self.scenario))

    def files_of(self, paths: Sequence[Path]) -> list[Path]:
        """Return every file once."""
        named = [*paths, *([self.machine] if self.machine else [])]
        return list(dict.fromkeys(f for p in named for f in sources(p)))

    @classmethod
    def of_shards(cls, options: dict[str, Any], sharing: Sharing) -> DiagnoseFolderJob:
        machine = Path(options["machine"]) if options["machine"] else None
        return cls(Path(options["scenario"]), options["seed"], machine, sharing=sharing)

    def load(self) -> list[Path]:
        return recordings_in(self.scenario)

    def run(self, loaded: list[Path], report: Progress) -> DiagnosedFolder:
        """Raises ShardDone where a share is wanted."""
        count = len(loaded)
        report(f"0 of {count} recordings", 0.0)
        records = diagnosed_folder(
            FolderJob(self.scenario, self.seed, self.machine), loaded,
            key_of("diagnose", self.count_options(), self.files_of(loaded)), self.sharing,
            lambda share: report(f"{round(share * count)} of {count} recordings", share),
        )  # fmt: skip
        return DiagnosedFolder(in_time(records), changes(records))

    def record(self, loaded: list[Path], result: DiagnosedFolder) -> Record:
        rows = [{k: v for k, v in r.items() if k != "ours"} for r in result.records]
        body = {"recordings": rows, "changes": as_records(tables.CHANGES, result.changes)}
        return Record(body, self.files_of(loaded), self.seed)

    def texts(
        self, loaded: list[Path], result: DiagnosedFolder, content: str, folder: Path
    ) -> dict[str, str]:
        from vcmm.show.pages.diagnosis import fleet_page

        return {
            "diagnosis.json": content,
            "recordings.csv": csv_text(tables.numbers(result.records)),
            "changes.csv": csv_text(tables.changes_table(result.changes)),
            "report.html": fleet_page(self.scenario.name, result.records, result.changes),
        }

    def exit_code(self, loaded: list[Path], result: DiagnosedFolder) -> int:
        return 70 if any(r["ours"] for r in result.records) else 0

    def show(self, loaded: list[Path], result: DiagnosedFolder) -> None:
        show_answers(folder_answers(result.records, result.changes))
        show_table(tables.recordings(self.scenario.name, result.records))
        if result.changes:
            show_table(tables.changes_table(result.changes))
        bad = [r for r in result.records if r["problem"]]
        if bad:
            say(
                f"note: {len(bad)} of {len(result.records)} recordings were not diagnosed; the table says why"
            )
