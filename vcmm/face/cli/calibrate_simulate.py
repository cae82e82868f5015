"""vcmm calibrate --simulate: what the instruments of a plan would read on a machine, as recordings."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any


def simulate_command(plan: Path, machine: Path | None, out: Path | None, seed: int, json: bool) -> int:
    """Write one recording per set-up into a folder: errors of the machine, set-up, instrument, noise, all drawn."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.design import load_design
    from vcmm.files.own.machine import load_machine
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import output_folder
    from vcmm.show.console.terminal import say

    if machine is None or out is None:
        raise UsageError(
            "--simulate needs the machine on which is measured and a folder: "
            "vcmm calibrate --simulate plan.toml --machine truth.toml --out readings"
        )
    setups, planned, _ = load_design(plan)
    truth = load_machine(machine)
    _check_same(planned, truth, plan, machine)
    output_folder(out)
    rows = _all_or_nothing(setups, planned, truth, out, seed)
    body = {"machine": str(out / BARE), "recordings": rows}
    if json:
        print_json(document("vcmm.simulated/1", body, seed=seed, files=[*sources(plan), *sources(machine)]))
    else:
        for row in rows:
            print(f"{row['file']}: {row['instrument']}, {row['observations']} readings")
        say(f"next: vcmm calibrate {out}/*.toml --machine {out / BARE} --out machine.toml")
    return 0


BARE = "machine/bare.toml"


def _check_same(planned: Any, truth: Any, plan: Path, machine: Path) -> None:
    from vcmm.core.errors import UsageError

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


def _with_dynamics(planned: Any, truth: Any) -> Any:
    """The planned machine; an axis whose dynamics it does not state has those of the machine that is measured."""
    from dataclasses import replace

    axes = {a: replace(x, dynamics=x.dynamics or truth.axes[a].dynamics) for a, x in planned.axes.items()}
    return replace(planned, axes=axes)


def _all_or_nothing(setups: Any, planned: Any, truth: Any, out: Path, seed: int) -> list[dict[str, Any]]:
    """As `_write_recordings`, in a folder beside, whose files are moved once all of them stand."""
    from tempfile import TemporaryDirectory

    above = next(p for p in out.absolute().parents if p.is_dir())
    with TemporaryDirectory(prefix=".vcmm-", dir=above) as made:
        folder = Path(made)
        rows = _write_recordings(setups, planned, truth, folder, seed)
        for path in sorted(p for p in folder.rglob("*") if p.is_file()):
            target = out / path.relative_to(folder)
            target.parent.mkdir(parents=True, exist_ok=True)
            path.replace(target)
    return [row | {"file": str(out / row["file"])} for row in rows]


def _write_recordings(setups: Any, planned: Any, truth: Any, out: Path, seed: int) -> list[dict[str, Any]]:
    """One row per recording. What the instruments read follows from the file as it was written: order of the rows and all."""
    import numpy as np

    from vcmm.core.errors import UsageError
    from vcmm.files.learned.calibrated_machine import bare_text, stated_repeatability
    from vcmm.files.own.instruments import instrument_text
    from vcmm.files.own.recording import load_recording
    from vcmm.files.own.recording_writer import save_recording
    from vcmm.show.console.files import write_text
    from vcmm.task.instruments.laying import simulate_reading

    rng, rows, seen = np.random.default_rng(seed), [], set()
    drawn: dict[str, Any] = {}
    output = out / BARE
    output.parent.mkdir(parents=True, exist_ok=True)
    write_text(output, bare_text(_with_dynamics(planned, truth)) + stated_repeatability(truth))
    for name, recordings, _, certificate in setups:
        for recording in recordings:
            stem = re.sub(r"[^\w-]+", "_", recording.name).strip("_")
            if stem in seen:
                raise UsageError(f'two set-ups would be written as {stem}.toml; give "{name}" another name')
            seen.add(stem)
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
