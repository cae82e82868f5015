"""vcmm calibrate: the errors of a machine from what instruments read on it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.cli.options import Seed


def calibrate_command(
    *recordings: Path,
    structure: str | None = None,
    machine: Path | None = None,
    errors: str = "",
    growth: str | None = None,
    months: float = 1.0,
    design: Path | None = None,
    simulate: Path | None = None,
    seed: Seed = 0,
    report: Path | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Find the errors of a machine, with their joint covariance, from recordings of any instruments in any mixture.

    Parameters
    ----------
    recordings
        Recording files (recording/1). Files with [reversal] are separated by themselves (docs/reversal.md).
    structure
        Structure of the machine, such as "w b Y X Z t"; not needed with --machine.
    machine
        Machine file that holds what is known already: it is the prior of a recalibration.
    errors
        Errors to look for, such as "EXX EYX C0Y"; all others are then taken as zero. Default: all of the axes that moved.
    growth
        With --machine: by how much errors may change in a month, such as "0.5 um" (u; rotations: over 1 m).
    months
        Since the machine file was found; growth is a random walk, so that 4 months are twice one.
    design
        Plan of set-ups (design/1): says beforehand what they identify and how well, and the cheapest ones that do.
    simulate
        Plan of set-ups (design/1): writes what they would read on --machine (seed: --seed), as recordings in the folder --out.
    report
        File for the HTML report.
    json
        Print one JSON document.
    out
        Machine file to write; its error table and covariance stand beside it.
    """
    from vcmm.cli.calibrate_design import design_command
    from vcmm.cli.calibrate_reversal import reversal_command
    from vcmm.cli.calibrate_simulate import simulate_command
    from vcmm.files.reversal import is_reversal

    if design is not None:
        return design_command(design, json)
    if simulate is not None:
        return simulate_command(simulate, machine, out, seed, json)
    grown = _growth(growth, months, machine)
    if any(path.is_file() and is_reversal(path) for path in recordings):
        return reversal_command(list(recordings), structure, out, json, [machine, errors, report])
    _check_words(recordings, structure, machine)
    found = _calibrated(list(recordings), structure, machine, (errors.split(), grown), out)
    _report(found, report)
    return _told(found, _document(found, list(recordings), machine, out) if json else None)


def _told(found: Any, content: dict[str, Any] | None) -> int:
    """Print the document, or without one the tables."""
    from vcmm.console.documents import print_json

    if content is None:
        _show(found)
    else:
        print_json(content)
    return 0


def _check_words(recordings: tuple[Path, ...], structure: str | None, machine: Path | None) -> None:
    from vcmm.core.errors import UsageError

    if not recordings:
        raise UsageError(
            "calibrate needs recordings, or a plan with --design; write for example vcmm calibrate laser.toml plate.toml"
        )
    if (structure is None) == (machine is None):
        raise UsageError(
            'name either --structure "w b Y X Z t" or, with --machine, a machine file that is known'
        )


def _growth(text: str | None, months: float, machine: Path | None) -> float:
    """u in mm of what errors have changed by since the machine file was found. Raises UsageError."""
    from vcmm.core.errors import UsageError
    from vcmm.core.units import quantity

    if text is None:
        return 0.0
    rate = quantity(text, "length", "--growth", "0.5 um")
    if machine is None or not (rate > 0 and 0 < months < 1e4):
        raise UsageError(
            f'--growth "{text}" --months {months:g}: a length above zero per month, months above zero, and a machine file with --machine'
        )
    return float(rate * months**0.5)


def _calibrated(
    files: list[Path],
    structure: str | None,
    machine: Path | None,
    asked: tuple[list[str], float],
    out: Path | None,
) -> Any:
    """The calibration; its machine file is written where it shall be. asked: names of errors, growth in mm."""
    from vcmm.calibrating.job import bare_machine, calibrate
    from vcmm.calibrating.machine_file import machine_texts
    from vcmm.console.files import output_folder, write_files
    from vcmm.console.terminal import progress, say
    from vcmm.files.instruments import load_certificate
    from vcmm.files.machine import load_machine
    from vcmm.files.recording import load_recording

    if out is not None:
        output_folder(out.parent)
    known = load_machine(machine) if machine is not None else bare_machine(str(structure))
    loaded = [load_recording(path, known)[0] for path in files]
    stated = {r.name: load_certificate(path, r) for path, r in zip(files, loaded)}
    certificates = {name: one for name, one in stated.items() if one is not None}
    with progress() as show:
        found = calibrate(loaded, known, certificates, asked[0], show, growth=asked[1])
    if out is not None:
        write_files(out.parent, machine_texts(found, out, [f.name for f in files], machine))
        say(f"wrote {out}, {out.stem}_errors.csv, {out.stem}_covariance.csv")
    return found


def _document(found: Any, files: list[Path], machine: Path | None, out: Path | None) -> dict[str, Any]:
    from vcmm.console.documents import document, sources

    read = [f for path in [*files, *([machine] if machine else [])] for f in sources(path)]
    return document("vcmm.calibration/1", _body(found, out), files=read, warnings=found.warnings)


def _report(found: Any, path: Path | None) -> None:
    from vcmm.console.files import write_text
    from vcmm.console.terminal import say
    from vcmm.pages.calibration import calibration_page

    if path is not None:
        write_text(path, calibration_page(found))
        say(f"wrote {path}")


def _body(found: Any, out: Path | None) -> dict[str, Any]:
    """The JSON document without its frame; its figures are those of the file that was written, read back."""
    from vcmm.calibrating.acceptance import volume_figures
    from vcmm.calibrating.result import rms
    from vcmm.files.machine import load_machine
    from vcmm.tables.calibrated import FIGURES, RESIDUALS, residuals
    from vcmm.tables.table import records

    pulls = zip(found.posterior.own_names, found.posterior.own)
    return {
        "machine": None if out is None else str(out),
        "identified": found.figures(),
        "not_identified": found.identified.document(),
        "condition": found.identified.condition,
        "residual_um": rms(found.residual) * 1e3,
        "residuals": records(RESIDUALS, residuals(found).rows),
        "instruments": [{"input": name, "pull": float(v)} for name, v in pulls],
        "nodes": {c.axis: len(c.nodes) for c in found.kept.curves},
        "figures": records(FIGURES, volume_figures(load_machine(out))) if out is not None else [],
    }


def _show(found: Any) -> None:
    from vcmm.calibrating.result import rms
    from vcmm.console.terminal import say, show_table
    from vcmm.tables.calibrated import errors

    show_table(errors(found))
    print(f"residuals: {rms(found.residual) * 1e3:.3f} um rms; condition {found.identified.condition:.3g}")
    for c in found.identified.combinations:
        print(f"not identified: {c.text}")
    for warning in found.warnings:
        say(f"note: {warning}")
