"""vcmm test: figures of acceptance tests, predicted for a machine or evaluated from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.cli.options import Seed


def test_command(
    file: Path,
    *,
    iso: str,
    limit: Annotated[list[str] | None, Parameter(name="--limit", negative=())] = None,
    seed: Seed = 0,
    trials: int = 1000,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Predict the figures of an acceptance test with uncertainty, or evaluate a recorded one.

    Parameters
    ----------
    file
        Machine file (machine/1), or a scenario with its machine: predict. Recording file (recording/1): evaluate what was recorded (230-2).
    iso
        The test: 230-2, 230-4, 230-6 or 10360-2.
    limit
        A limit such as "A = 8 um", "B X = 2 um" or "E0 = 1.9 um + L/300" (L in mm gives um); may be repeated.
    seed
        Seed of the drawn machines.
    trials
        Number of drawn machines.
    json
        Print one JSON document.
    """
    from vcmm.calibrating.acceptance import predicted
    from vcmm.calibrating.limits import limits_of
    from vcmm.console.documents import document, print_json, sources
    from vcmm.console.terminal import show_table
    from vcmm.files.machine import machine_from
    from vcmm.files.machine_tables import machine_table
    from vcmm.files.toml import read_toml
    from vcmm.tables.calibrated import FIGURES
    from vcmm.tables.calibrated import figures as figures_table
    from vcmm.tables.table import records

    limits = limits_of(limit or [])
    warnings: list[str] = []
    drawn = False
    if str(read_toml(file).data.get("vcmm", "")).startswith("recording/"):
        figures = _recorded(file, iso, limits, warnings)
    else:
        machine = machine_from(*machine_table(file))
        stated, drawn = _stated(file, machine, iso, warnings)
        limits = {**stated, **limits}
        figures = predicted(machine, iso, limits, seed, trials)
    _refuse_unused(limits, figures)
    content = document(
        "vcmm.test/1",
        {"test": f"ISO {iso}", "figures": records(FIGURES, figures)},
        seed=seed, files=sources(file), warnings=warnings,
    )  # fmt: skip
    if json:
        print_json(content)
    else:
        show_table(figures_table(iso, figures))
        for warning in warnings:
            print(f"note: {warning}")
    return int(not drawn and any(f.p_pass is not None and f.p_pass < 0.5 for f in figures))


def _stated(file: Path, machine: Any, iso: str, warnings: list[str]) -> tuple[dict[str, Any], bool]:
    """Limits of the file's own [certificate] by figure, and whether its errors were drawn from it."""
    from vcmm.files.certificate import stated_certificate

    certificate = stated_certificate(file)
    if certificate is None:
        return {}, False
    drawn = any(i.evidence == certificate.words() for i in machine.inputs)
    if drawn:
        warnings.append(
            f"the errors of this machine are drawn from its certificate (prior {certificate.prior}): p_pass says how often a machine that "
            "has passed would pass again"
        )
    return dict(certificate.limits(iso)), drawn


def _refuse_unused(limits: Any, figures: Any) -> None:
    from vcmm.core.errors import UsageError, choose_from

    names = [f.name for f in figures]
    known = list(dict.fromkeys([*names, *(n.split(" ")[0] for n in names)]))
    for name in limits:
        if name not in known and not any(n.rpartition(" ")[0] == name for n in names):
            raise UsageError(
                f'--limit "{name} = ...": the test has no such figure.{choose_from(name, known)}'
            )


def _recorded(file: Path, iso: str, limits: Any, warnings: list[str]) -> Any:
    from vcmm.calibrating.recorded import recorded_positioning
    from vcmm.core.errors import UsageError
    from vcmm.files.instruments import load_certificate
    from vcmm.files.recording import load_recording

    if iso != "230-2":
        raise UsageError(f"a recording is evaluated by ISO 230-2; predict ISO {iso} from a machine file")
    recording, machine = load_recording(file)
    certificate = load_certificate(file, recording)
    if certificate is None:
        warnings.append("the recording names no [instrument]; its uncertainty is not known, so u is left out")
    return recorded_positioning(recording, machine, certificate, limits)
