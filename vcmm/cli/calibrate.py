"""vcmm calibrate: the errors of a machine from what instruments read on it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def calibrate_command(
    *recordings: Path,
    structure: str | None = None,
    machine: Path | None = None,
    errors: str = "",
    design: Path | None = None,
    report: Path | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Find the errors of a machine, with their joint covariance, from recordings of any instruments in any mixture.

    Parameters
    ----------
    recordings
        Recording files (recording/1).
    structure
        Structure of the machine, such as "w b Y X Z t"; not needed with --machine.
    machine
        Machine file that holds what is known already: it is the prior of a recalibration.
    errors
        Errors to look for, such as "EXX EYX C0Y"; all others are then taken as zero. Default: all of the axes that moved.
    design
        Plan of set-ups (design/1): says beforehand what they identify and how well, and the cheapest ones that do.
    report
        File for the HTML report.
    json
        Print one JSON document.
    out
        Machine file to write; its error table and covariance stand beside it.
    """
    from vcmm.core.errors import UsageError

    if design is not None:
        from vcmm.cli.calibrate_design import design_command

        return design_command(design, json)
    if not recordings:
        raise UsageError(
            "calibrate needs recordings, or a plan with --design; write for example vcmm calibrate laser.toml plate.toml"
        )
    if (structure is None) == (machine is None):
        raise UsageError(
            'name either --structure "w b Y X Z t" or a machine file that is known with --machine'
        )
    return _calibrate(list(recordings), structure, machine, errors.split(), report, json, out)


def _calibrate(
    files: list[Path],
    structure: str | None,
    machine: Path | None,
    only: list[str],
    report: Path | None,
    json: bool,
    out: Path | None,
) -> int:
    from vcmm.calibrating.job import bare_machine, calibrate
    from vcmm.calibrating.machine_file import machine_texts
    from vcmm.console.documents import document, print_json, sources
    from vcmm.console.files import output_folder, write_files, write_text
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
    content = document(
        "vcmm.calibration/1",
        _body(found, out),
        files=[f for path in [*files, *([machine] if machine else [])] for f in sources(path)],
        warnings=found.warnings,
    )
    if report is not None:
        from vcmm.pages.calibration import calibration_page

        write_text(report, calibration_page(found))
        say(f"wrote {report}")
    if json:
        print_json(content)
    else:
        _show(found)
    return 0


def _body(found: Any, out: Path | None) -> dict[str, Any]:
    """The JSON document without its frame."""
    from vcmm.calibrating.result import rms
    from vcmm.cli.calibrate_figures import field_figures

    residuals = [
        {
            "recording": r.recording.name,
            "kind": r.recording.kind,
            "observations": int(r.m),
            "rms": rms(e) * (1e6 if r.recording.kind == "angle" else 1e3),
            "unit": "urad" if r.recording.kind == "angle" else "um",
            "noise_ratio": noise.scale,
            "dof": noise.dof if noise.dof < 1e6 else None,
            "outliers": int(noise.outliers.sum()),
            "station_moved_mm": dict(r.moved),
        }
        for r, e, noise in zip(found.readings, found.posterior.residual, found.posterior.noise)
    ]
    return {
        "machine": None if out is None else str(out),
        "identified": found.figures(),
        "not_identified": [
            {"combination": list(c.names), "text": c.text} for c in found.identified.combinations
        ],
        "condition": found.identified.condition,
        "residual_um": rms(found.residual) * 1e3,
        "residuals": residuals,
        "instruments": [
            {"input": name, "pull": float(v)}
            for name, v in zip(found.posterior.own_names, found.posterior.own)
        ],
        "nodes": {c.axis: len(c.nodes) for c in found.kept.curves},
        "figures": field_figures(out) if out is not None else [],
    }


def _show(found: Any) -> None:
    from vcmm.calibrating.result import rms
    from vcmm.console.terminal import say, show_table

    rows = []
    for f in found.figures():
        size = f"{f['value']:+.3f}" if "value" in f else f"{f['low']:+.3f} to {f['high']:+.3f}"
        rows.append([str(f["error"]), f"{size} {f['unit']}", f"{f['u']:.2g} {f['unit']}"])
    show_table("errors of the machine", ["error", "from ... to", "u (rms over the travel)"], rows)
    print(f"residuals: {rms(found.residual) * 1e3:.3f} um rms; condition {found.identified.condition:.3g}")
    for c in found.identified.combinations:
        print(f"not identified: {c.text}")
    for warning in found.warnings:
        say(f"note: {warning}")
