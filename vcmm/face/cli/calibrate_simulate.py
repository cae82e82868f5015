"""vcmm calibrate --simulate: readings of the instruments of a plan on a machine, as recordings."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.face.job import Job, Progress, Record
from vcmm.files.learned.calibrated_machine import bare_text, stated_repeatability
from vcmm.files.own.design import load_design
from vcmm.files.own.instruments import instrument_text
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_writer import save_recording
from vcmm.show.console.documents import sources
from vcmm.show.console.files import output_folder, write_text
from vcmm.show.console.terminal import say
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.laying import simulate_reading
from vcmm.task.response.recording import Recording

BARE = "machine/bare.toml"
Setups = Sequence[tuple[str, tuple[Recording, ...], float, InstrumentCertificate]]
Row = dict[str, Any]  # of one recording, as the document has it


class Survey(NamedTuple):
    """The set-ups of a plan, the machine that they are planned for, and the one that is measured."""

    setups: Setups
    machine: Machine
    truth: Machine


@dataclass(frozen=True)
class SimulateJob(Job[Survey, list[Row]]):
    """One recording per set-up in the folder --out: errors of the machine, set-up, instrument, noise, all sampled. Each is written before it
    is read, since the readings of an instrument follow from the file."""

    plan: Path
    machine: Path | None
    out: Path | None
    seed: int
    schema = "vcmm.simulated/1"

    def machine_and_folder(self) -> tuple[Path, Path]:
        """Return machine file and folder. Raises UsageError where one of them is missing."""
        if self.machine is None or self.out is None:
            raise UsageError(
                "--simulate needs the machine on which is measured and a folder: "
                "vcmm calibrate --simulate plan.toml --machine truth.toml --out readings"
            )
        return self.machine, self.out

    def check(self) -> None:
        self.machine_and_folder()

    def load(self) -> Survey:
        machine, out = self.machine_and_folder()
        setups, planned, _ = load_design(self.plan)
        truth = load_machine(machine)
        _check_same(planned, truth, self.plan, machine)
        output_folder(out)
        return Survey(setups, planned, truth)

    def run(self, loaded: Survey, report: Progress) -> list[Row]:
        return _all_or_nothing(loaded, self.machine_and_folder()[1], self.seed)

    def record(self, loaded: Survey, result: list[Row]) -> Record:
        machine, out = self.machine_and_folder()
        body = {"machine": str(out / BARE), "recordings": result}
        return Record(body, [*sources(self.plan), *sources(machine)], self.seed)

    def show(self, loaded: Survey, result: list[Row]) -> None:
        _, out = self.machine_and_folder()
        for row in result:
            print(f"{row['file']}: {row['instrument']}, {row['observations']} readings")
        say(f"next: vcmm calibrate {out}/*.toml --machine {out / BARE} --out machine.toml")


def _check_same(planned: Machine, truth: Machine, plan: Path, machine: Path) -> None:
    if planned.chain.structure != truth.chain.structure:
        raise UsageError(
            f'{plan} plans for "{planned.chain.structure}", {machine} is "{truth.chain.structure}"; plan for that machine: machine = "..."'
        )
    for letter, axis in planned.axes.items():
        if axis.centre != truth.axes[letter].centre:
            raise UsageError(
                f"the axis {letter} turns about {axis.centre} in {plan} and about {truth.axes[letter].centre} in {machine}; write machine = "
                f'"{machine.name}" in the plan'
            )


def _with_dynamics(planned: Machine, truth: Machine) -> Machine:
    """Return the planned machine; an axis whose dynamics it does not state has those of the machine that is measured."""
    axes = {a: replace(x, dynamics=x.dynamics or truth.axes[a].dynamics) for a, x in planned.axes.items()}
    return replace(planned, axes=axes)


def _all_or_nothing(survey: Survey, out: Path, seed: int) -> list[Row]:
    """Write the recordings in a folder beside, and move the files once all of them are there."""
    above = next(p for p in out.absolute().parents if p.is_dir())
    with TemporaryDirectory(prefix=".vcmm-", dir=above) as made:
        folder = Path(made)
        rows = _write_recordings(survey, folder, seed)
        for path in sorted(p for p in folder.rglob("*") if p.is_file()):
            target = out / path.relative_to(folder)
            target.parent.mkdir(parents=True, exist_ok=True)
            path.replace(target)
    return [row | {"file": str(out / row["file"])} for row in rows]


def _write_recordings(survey: Survey, out: Path, seed: int) -> list[Row]:
    """Return one row per recording. The readings follow from the written file, including the order of its rows."""
    setups, planned, truth = survey
    rng, rows, names = np.random.default_rng(seed), [], set()
    drawn: dict[str, Any] = {}
    output = out / BARE
    output.parent.mkdir(parents=True, exist_ok=True)
    write_text(output, bare_text(_with_dynamics(planned, truth)) + stated_repeatability(truth))
    for name, recordings, _, certificate in setups:
        for recording in recordings:
            stem = re.sub(r"[^\w-]+", "_", recording.name).strip("_")
            if stem in names:
                raise UsageError(f'two set-ups would be written as {stem}.toml; give "{name}" another name')
            names.add(stem)
            path = out / f"{stem}.toml"
            save_recording(recording, path, BARE)
            meant, _ = load_recording(path, truth)
            read = simulate_reading(meant, truth, rng, certificate, drawn)
            save_recording(read, path, BARE)
            write_text(path, path.read_text(encoding="utf-8") + instrument_text(certificate))
            rows.append(
                {"file": path.name, "instrument": certificate.instrument.name, "observations": read.m}
            )
    return rows
