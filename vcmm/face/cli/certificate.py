"""vcmm certificate: value of the certificate of a machine for a part."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from vcmm.answer.evaluation.at_limit import smallest
from vcmm.face.cli.options import InputFile, Json, Seed
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.learned.certificate_comparison import CertificateWorth, certificate_worth
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say_warnings, show_answers, show_table
from vcmm.show.tables.answers_parts import certificate_answers
from vcmm.show.tables.certificate import worth_json, worth_tables

LEAST_SHARE_OF_MACHINES = (
    0.94  # of machines at the limit: 95 % less what is seen by chance in some thousand of them
)


def certificate_command(
    scenario: InputFile,
    *,
    trials: int | None = 20_000,
    seed: Seed | None = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Find the value of a certificate for a part: U under three priors and with every further fact, machines at the limit counted.

    Exit code 1 when machines at the limit are covered less often than their intervals say.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1) whose machine states a [certificate] and no errors of its own.
    trials
        Monte Carlo trials of each evaluation.
    seed
        Seed of the random streams (default: the scenario's).
    json
        Print one JSON document.
    out
        Folder for certificate.json.
    """
    return run_job(CertificateJob(scenario, trials, seed), Flags(json, out))


@dataclass(frozen=True)
class CertificateJob(Job[Path, CertificateWorth]):
    """Value of a certificate for the part of a scenario. Its files are read by the comparison, once for every prior."""

    scenario: Path
    trials: int | None
    seed: int | None
    schema = "vcmm.certificate/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, "machine"

    def load(self) -> Path:
        return self.scenario

    def run(self, loaded: Path, report: Progress) -> CertificateWorth:
        return certificate_worth(loaded, trials=self.trials, seed=self.seed, progress=report)

    def record(self, loaded: Path, result: CertificateWorth) -> Record:
        return Record(worth_json(result), sources(loaded), result.seed, result.warnings)

    def texts(self, loaded: Path, result: CertificateWorth, content: str, folder: Path) -> dict[str, str]:
        return {"certificate.json": content}

    def exit_code(self, loaded: Path, result: CertificateWorth) -> int:
        return int(smallest(result.coverage) < LEAST_SHARE_OF_MACHINES)

    def show(self, loaded: Path, result: CertificateWorth) -> None:
        show_answers(certificate_answers(result, LEAST_SHARE_OF_MACHINES))
        print(result.stated)
        for table in worth_tables(result):
            show_table(table)
        say_warnings(result.warnings)
