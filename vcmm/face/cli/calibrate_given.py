"""Inputs of `vcmm calibrate`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vcmm.core.errors import UsageError, choose_from, did_you_mean
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.files.own.instruments import load_certificate
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.reversal import is_reversal, load_reversal
from vcmm.learn.calibration.job import bare_machine
from vcmm.learn.calibration.reversal_readings import reversed_recordings
from vcmm.learn.calibration.verification import IndependentTest, check_independent, put_to_test
from vcmm.show.console.documents import sources
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.response.recording import Recording

JOB_NAMES = (
    "fit",
    "design",
    "program",
    "simulate",
    "thermal",
    "nodes",
    "face",
    "compare",
)  # of vcmm.face.cli.calibrate_jobs


@dataclass(frozen=True)
class CalibrationInput:
    """Recordings, the machine as far as known, the certificates of the instruments, and joint covariances of readings."""

    recordings: Sequence[Recording]
    machine: Machine
    certificates: dict[str, InstrumentCertificate]
    covariances: dict[str, Array]


@dataclass(frozen=True)
class CalibrationFiles:
    """Files of the command line: recordings, structure or machine file, machine file to write, recordings of tests."""

    files: list[Path]
    structure: str | None
    machine: Path | None
    out: Path | None
    test: list[Path]

    def check_recordings(self) -> None:
        """Raises UsageError where no recording is named."""
        if not self.files:
            raise UsageError(
                'calibrate needs recordings, for example vcmm calibrate fit laser.toml plate.toml --structure "w b Y X Z t" --out machine.toml, '
                "or a plan: vcmm calibrate design plan.toml"
            )
        first = self.files[0]
        if not first.suffix and not first.exists() and did_you_mean(str(first), JOB_NAMES):
            raise UsageError(f'"{first}" is no job of calibrate.{choose_from(str(first), JOB_NAMES)}')

    def reversals(self) -> list[Path]:
        """Return the files that are reversals."""
        return [path for path in self.files if path.is_file() and is_reversal(path)]

    def check(self, thermal: bool, sensors: str, compare: bool) -> None:
        """Raises UsageError for words that are missing or do not go together."""
        if (self.structure is None) == (self.machine is None):
            raise UsageError(
                'name either --structure "w b Y X Z t" or a machine file that is known with --machine'
            )
        if sensors and not thermal:
            raise UsageError("--sensors goes with --thermal: it names the temperatures of a thermal model")
        if thermal and self.machine is None:
            raise UsageError("--thermal adds to a machine file; name it with --machine machine.toml")
        if compare and (self.out or self.test):
            raise UsageError(
                "--compare-interpolations writes no machine file; leave out --out and --test, then calibrate with --interpolation NAME"
            )
        if thermal and compare:
            raise UsageError("--thermal and --compare-interpolations are two jobs; give one of them")
        if self.test and self.out is None:
            raise UsageError("--test asks the file that is written; name it with --out machine.toml")

    def without(self, job: str, **others: object) -> None:
        """Raises UsageError for options that a job does not take."""
        given = [f"--{name.replace('_', '-')}" for name, value in others.items() if value]
        if given:
            raise UsageError(
                f"{job} takes no {' and no '.join(given)}; leave {'it' if len(given) == 1 else 'them'} out"
            )

    def load(self) -> CalibrationInput:
        """Read the recordings. Raises UsageError where a test holds the same readings as one of them."""
        machine = (
            load_machine(self.machine) if self.machine is not None else bare_machine(str(self.structure))
        )
        turned = self.reversals()
        others = [path for path in self.files if path not in turned]
        loaded = [load_recording(path, machine)[0] for path in others]
        for path in self.test:
            check_independent(load_recording(path, machine)[0], loaded)
        stated = {r.name: load_certificate(path, r) for path, r in zip(others, loaded)}
        separated, correlated = reversed_recordings([load_reversal(path) for path in turned], machine)
        certificates = {name: certificate for name, certificate in stated.items() if certificate is not None}
        return CalibrationInput([*loaded, *separated], machine, certificates, correlated)

    def read(self) -> list[Path]:
        """Return all files that were read."""
        named = [*self.files, *([self.machine] if self.machine else []), *self.test]
        return [f for path in named for f in sources(path)]

    def tests(self) -> list[IndependentTest]:
        """Return the predictions of the written machine file for the recordings of --test, read back."""
        if not self.test or self.out is None:
            return []
        before, after = self.load().machine, load_machine(self.out)
        return [put_to_test(load_recording(path, after)[0], before, after) for path in self.test]
