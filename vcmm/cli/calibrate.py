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
    design
        Plan of set-ups (design/1): says beforehand what they identify and how well, and the cheapest ones that do.
    simulate
        Plan of set-ups (design/1): writes what they would read on the machine of --machine, as recordings in the folder --out.
    seed
        Seed of what is simulated.
    report
        File for the HTML report.
    json
        Print one JSON document.
    out
        Machine file to write; its error table and covariance stand beside it.
    """
    from vcmm.cli.calibrate_design import design_command
    from vcmm.cli.calibrate_reversal import reversal_command
    from vcmm.console.documents import print_json
    from vcmm.core.errors import UsageError
    from vcmm.files.reversal import is_reversal

    if design is not None:
        return design_command(design, json)
    if simulate is not None:
        from vcmm.cli.calibrate_simulate import simulate_command

        return simulate_command(simulate, machine, out, seed, json)
    if not recordings:
        raise UsageError(
            "calibrate needs recordings, or a plan with --design; write for example vcmm calibrate laser.toml plate.toml"
        )
    if any(is_reversal(path) for path in recordings):
        return reversal_command(list(recordings), structure, out, json, [machine, errors, report])
    if (structure is None) == (machine is None):
        raise UsageError(
            'name either --structure "w b Y X Z t" or a machine file that is known with --machine'
        )
    files = list(recordings)
    found = _calibrated(files, structure, machine, errors.split(), out)
    content = _document(found, files, machine, out)
    if report is not None:
        _report(found, report)
    if json:
        print_json(content)
    else:
        _show(found)
    return 0


def _calibrated(
    files: list[Path], structure: str | None, machine: Path | None, only: list[str], out: Path | None
) -> Any:
    """The calibration; its machine file is written where it shall be."""
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
        found = calibrate(loaded, known, certificates, only, show)
    if out is not None:
        write_files(out.parent, machine_texts(found, out, [f.name for f in files], machine))
        say(f"wrote {out}, {out.stem}_errors.csv, {out.stem}_covariance.csv")
    return found


def _document(found: Any, files: list[Path], machine: Path | None, out: Path | None) -> dict[str, Any]:
    from vcmm.console.documents import document, sources

    read = [f for path in [*files, *([machine] if machine else [])] for f in sources(path)]
    return document("vcmm.calibration/1", _body(found, out), files=read, warnings=found.warnings)


def _report(found: Any, path: Path) -> None:
    from vcmm.console.files import write_text
    from vcmm.console.terminal import say
    from vcmm.pages.calibration import calibration_page

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
