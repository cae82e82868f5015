"""vcmm test: figures of acceptance tests, predicted for a machine or evaluated from a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter
from cyclopts.validators import Number

from vcmm.face.cli.options import Seed

DrawsOption = Annotated[
    int, Parameter(validator=Number(gte=40, lte=10**6))
]  # 40: one draw in either tail of 2.5 %


def test_command(
    file: Path,
    *more: Path,
    iso: str,
    limit: Annotated[list[str] | None, Parameter(name="--limit", negative=())] = None,
    seed: Seed = 0,
    trials: DrawsOption = 1000,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Predict the figures of an acceptance test with uncertainty, or evaluate a recorded one.

    Parameters
    ----------
    file
        Machine file (machine/1), or a scenario with its machine: predict. Recording file (recording/1): evaluate what was recorded (230-7: with [reversal]).
    more
        Further recordings of the same test: axes, planes, diagonals.
    iso
        The test: 230-2, 230-4, 230-6, 230-7 or 10360-2.
    limit
        A limit: "A = 8 um", "B X = 2 um", "E0 = 1.9 um + L/300" (L in mm gives um), "synchronous tilt B = 1 urad"; may be repeated.
    seed
        Seed of the drawn machines.
    trials
        Number of drawn machines.
    json
        Print one JSON document.
    """
    from vcmm.files.own.machine import load_machine_of
    from vcmm.files.toml import read_toml
    from vcmm.learn.calibration.acceptance import predict_figures
    from vcmm.learn.calibration.limits import limits_of
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.terminal import show_table
    from vcmm.show.tables.calibration import FIGURES
    from vcmm.show.tables.table import records

    warnings: list[str] = []
    drawn = False
    limits = limits_of(limit or [], angles=iso == "230-7")
    if iso == "230-7":
        figures = _spindle(_only_file([file, *more]), limits, warnings, seed=seed, trials=trials)
    elif more or str(read_toml(file).data.get("vcmm", "")).startswith("recording/"):
        figures = _evaluate_recordings([file, *more], iso, limits, warnings)
    else:
        machine = load_machine_of(file)
        stated, drawn = _stated_limits(file, machine, iso, warnings)
        limits = {**stated, **limits}
        figures = _drop_rounding(predict_figures(machine, iso, limits, seed, trials), warnings)
    _refuse_unused_limits(limits, figures, parts=iso == "230-7")
    read = [f for one in (file, *more) for f in sources(one)]
    body = {"test": f"ISO {iso}", "figures": records(FIGURES, figures)}
    content = document("vcmm.test/1", body, seed=seed, files=read, warnings=warnings)
    if json:
        print_json(content)
    else:
        show_table(_table(iso, figures))
        for warning in warnings:
            print(f"note: {warning}")
    return int(not drawn and any(f.p_pass is not None and f.p_pass < 0.5 for f in figures))


def _table(iso: str, figures: Any) -> Any:
    from vcmm.show.tables.calibration import figures as figures_table
    from vcmm.show.tables.reversal import spindle_figures

    return spindle_figures(figures) if iso == "230-7" else figures_table(iso, figures)


def _stated_limits(file: Path, machine: Any, iso: str, warnings: list[str]) -> tuple[dict[str, Any], bool]:
    """Limits of the file's own [certificate] by figure, and whether its errors were drawn from it."""
    from vcmm.files.own.certificate import stated_certificate

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


def _refuse_unused_limits(limits: Any, figures: Any, parts: bool) -> None:
    """parts: the beginning of a name stands for all figures that begin so."""
    from vcmm.core.errors import UsageError, choose_from
    from vcmm.learn.calibration.spindle import ANGLE, is_of

    names = [f.name.removesuffix(ANGLE) for f in figures]
    known = list(dict.fromkeys([*names, *(n.split(" ")[0] for n in names)]))
    for name in limits:
        if parts and any(is_of(name, n) for n in names):
            continue
        if (parts or name not in known) and not any(n.rpartition(" ")[0] == name for n in names):
            raise UsageError(
                f'--limit "{name} = ...": the test has no such figure.{choose_from(name, known)}'
            )


def _spindle(file: Path, limits: Any, warnings: list[str], *, seed: int, trials: int) -> Any:
    """ISO 230-7 of a test with [reversal], or predicted from a machine file."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.reversal import is_reversal, load_reversal
    from vcmm.files.toml import read_toml
    from vcmm.learn.calibration.reversal import separate
    from vcmm.learn.calibration.spindle import predicted_spindle, recorded_spindle

    if is_reversal(file):
        found = separate(load_reversal(file))
        warnings += [f"not identified: {c.text}" for c in found.combinations]
        return recorded_spindle(found, limits, seed, trials)
    if str(read_toml(file).data.get("vcmm", "")).startswith("recording/"):
        raise UsageError(
            f'{file}: a spindle test says in [reversal] how artefact and probe were turned; test = "direct" where the artefact is '
            "taken as perfect (docs/reversal.md)"
        )
    return _drop_rounding(predicted_spindle(load_machine(file), limits, seed, trials), warnings)


def _drop_rounding(figures: Any, warnings: list[str]) -> Any:
    """Figures without those that are rounding, and a warning of these."""
    from vcmm.learn.calibration.acceptance import without_rounding

    figures, untold = without_rounding(figures)
    warnings += untold
    return figures


def _only_file(files: list[Path]) -> Path:
    """A spindle test is one file. UsageError for several."""
    from vcmm.core.errors import UsageError

    if len(files) > 1:
        raise UsageError(
            f"{files[1]}: a spindle test of ISO 230-7 is one recording; test the others by themselves"
        )
    return files[0]


def _evaluate_recordings(files: list[Path], iso: str, limits: Any, warnings: list[str]) -> Any:
    from vcmm.files.own.instruments import load_certificate
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.calibration.deviations import RecordedTest
    from vcmm.learn.calibration.standard_figures import evaluate_recordings

    tests = []
    for file in files:
        recording, machine = load_recording(file)
        certificate = load_certificate(file, recording)
        if certificate is None:
            warnings.append(
                f"{file.name} names no [instrument]; its uncertainty is not known, so u is left out"
            )
        tests.append(RecordedTest(recording, machine, certificate))
    figures, notes = evaluate_recordings(tests, iso, limits)
    warnings += notes
    return figures
