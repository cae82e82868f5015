"""Figures of an acceptance test: predicted for a machine file, or evaluated from recordings."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any


def find_figures(
    files: Sequence[Path], iso: str, limit: Sequence[str], seed: int, trials: int
) -> tuple[Any, list[str], bool]:
    """Return (figures, warnings, whether the errors of the machine are sampled from its certificate). files: one machine file, or recordings."""
    from vcmm.files.own.machine import load_machine_of
    from vcmm.files.toml import read_toml
    from vcmm.learn.calibration.acceptance import predict_figures
    from vcmm.learn.calibration.spindle import limits_of

    file, warnings, drawn = files[0], list[str](), False
    limits = limits_of(limit, angles=iso == "230-7")
    if iso == "230-7":
        figures = _spindle(_only_file(list(files)), limits, warnings, seed=seed, trials=trials)
    elif len(files) > 1 or str(read_toml(file).data.get("vcmm", "")).startswith("recording/"):
        figures = _evaluate_recordings(list(files), iso, limits, warnings)
    else:
        machine = load_machine_of(file)
        stated, drawn = _stated_limits(file, machine, iso, warnings)
        limits = {**stated, **limits}
        figures = _drop_rounding(predict_figures(machine, iso, limits, seed, trials), warnings)
    _refuse_unused_limits(limits, figures, parts=iso == "230-7")
    return figures, warnings, drawn


def table_of_figures(iso: str, figures: Any) -> Any:
    """Return the figures as a table."""
    from vcmm.show.tables.calibration import figures as figures_table
    from vcmm.show.tables.calibration import spindle_figures

    return spindle_figures(figures) if iso == "230-7" else figures_table(iso, figures)


def _stated_limits(file: Path, machine: Any, iso: str, warnings: list[str]) -> tuple[dict[str, Any], bool]:
    """Return limits of the file's own [certificate] by figure, and whether its errors were sampled from it."""
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
    """Refuse limits that no figure uses. parts: beginnings of names, each for all figures that begin so."""
    from vcmm.core.errors import UsageError, choose_from
    from vcmm.learn.calibration.spindle import ANGLE, is_of

    names = [f.name.removesuffix(ANGLE) for f in figures]
    names_of_figures = list(dict.fromkeys([*names, *(n.split(" ")[0] for n in names)]))
    for name in limits:
        if parts and any(is_of(name, n) for n in names):
            continue
        if (parts or name not in names_of_figures) and not any(n.rpartition(" ")[0] == name for n in names):
            raise UsageError(
                f'--limit "{name} = ...": the test has no such figure.{choose_from(name, names_of_figures)}'
            )


def _spindle(file: Path, limits: Any, warnings: list[str], *, seed: int, trials: int) -> Any:
    """Return ISO 230-7 figures of a test with [reversal], or predicted from a machine file."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.reversal import is_reversal, load_reversal
    from vcmm.files.toml import read_toml
    from vcmm.learn.calibration.reversal import separate
    from vcmm.learn.calibration.spindle import predicted_spindle, recorded_spindle

    if is_reversal(file):
        reversal_result = separate(load_reversal(file))
        warnings += [f"not identified: {c.text}" for c in reversal_result.combinations]
        return recorded_spindle(reversal_result, limits, seed, trials)
    if str(read_toml(file).data.get("vcmm", "")).startswith("recording/"):
        raise UsageError(
            f'{file}: a spindle test says in [reversal] how artefact and probe were turned; test = "direct" where the artefact is '
            "taken as perfect (docs/reversal.md)"
        )
    return _drop_rounding(predicted_spindle(load_machine(file), limits, seed, trials), warnings)


def _drop_rounding(figures: Any, warnings: list[str]) -> Any:
    """Return the figures without those that are rounding, and a warning about them."""
    from vcmm.learn.calibration.acceptance import without_rounding

    figures, untold = without_rounding(figures)
    warnings += untold
    return figures


def _only_file(files: list[Path]) -> Path:
    """Return the file of a spindle test, which is one. UsageError for several."""
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
