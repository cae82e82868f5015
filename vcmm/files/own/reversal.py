"""Recording files with [reversal]: readings of one artefact in several set-ups (docs/reversal.md)."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.error_names import canonical
from vcmm.core.errors import DataError, UsageError
from vcmm.core.run import Array, Run
from vcmm.core.units import quantity
from vcmm.files.columns import read_positions
from vcmm.files.own.recording_tables import RecordingFile, ReversalTable, noise_law
from vcmm.files.problems import Problems, TableProblems
from vcmm.files.schema import checked_model
from vcmm.files.toml import check_version, read_toml
from vcmm.learn.calibration.reversal import ReversalFile
from vcmm.task.instruments.reversal import ReversalTest
from vcmm.task.instruments.reversal_line import LineScan
from vcmm.task.instruments.reversal_turns import TurnGroup, turn_group

ALONG_LINE = ("straightness", "half-turn")
HALF_TURN = {
    "B0C": ("X", -1.0),
    "A0C": ("Y", 1.0),
}  # scanned along; slope of the surface per tilt of the axis
TILTS = {"EBC": -1.0, "EAC": 1.0}
ASTRAY = 0.05  # share of steps backwards that noise of the counter may make
DEFAULT = {"half-turn": "B0C", "face": "EZC"}


def is_reversal(path: str | Path) -> bool:
    """Return whether a file is a recording with [reversal]. Raises DataError for a file that is no TOML."""
    return "reversal" in read_toml(path).data


def load_reversal(path: str | Path) -> ReversalFile:
    """Read one. Raises DataError with every problem: file, line, what is allowed."""
    document = read_toml(path)
    check_version(document, "recording")
    problems = Problems(document)
    model = checked_model(RecordingFile, document.data, problems)
    reversal = None
    if model is not None and (table := model.reversal) is not None:  # a key too long takes its table out
        _check_file(model, problems)
        words = problems.attempt(("reversal",), lambda: _words(table, model.kind == "angle"))
        if words is not None and not problems.found:
            data = document.path.parent / model.data
            name = model.name or document.path.stem
            reversal = problems.attempt(("data",), lambda: _read(model, table, words, data, name))
    problems.raise_if_any()
    assert reversal is not None
    return reversal


def _check_file(model: RecordingFile, problems: Problems) -> None:
    """Check statements that a recording may make and a reversal may not."""
    if model.kind not in ("displacement", "angle"):
        problems.add(
            ("kind",), f'kind = "{model.kind}": the probe of a reversal reads a "displacement" or an "angle"'
        )
    if model.observed:
        problems.add(
            ("observed",),
            'a reversal says in [reversal] sense = "+" or "-" how its probe reads; remove observed',
        )
    for key in ("nuisance", "line", "scope", "pose", "stylus"):
        if getattr(model, key):
            problems.add(
                (key,), f"a reversal has no [{key}]: its free parameters follow from its test; remove it"
            )


def _words(table: ReversalTable, angle: bool) -> ReversalTable:
    """Return the table with its names checked and defaults filled in. Raises TableProblems."""
    problems = []
    error = table.error or DEFAULT.get(table.test, "")
    try:
        error = canonical(error) if error else ""
    except UsageError as wrong:
        raise TableProblems([("error", str(wrong))]) from None
    due, fits = _test_error(table.test, error, angle)
    if not fits:
        problems.append(("error", f'error = "{error}" does not go with test = "{table.test}"{due}'))
    if table.test != "face":
        problems += [
            (key, f'{key} belongs to test = "face"; remove it')
            for key in ("probes", "tilt")
            if getattr(table, key)
        ]
    if table.test != "half-turn" and table.axis_tilt != "0 urad":
        problems.append(("axis_tilt", 'axis_tilt belongs to test = "half-turn"; remove it'))
    if problems:
        raise TableProblems(problems)
    return table.model_copy(update={"error": error, "tilt": table.tilt or "EBC"})


def _test_error(test: str, error: str, angle: bool) -> tuple[str, bool]:
    """Return the errors that a test allows, in words, and whether the error is one of them."""
    if test == "straightness":
        fits = (
            len(error) == 3
            and error[0] == "E"
            and error[2] in "XYZ"
            and error[1] in "XYZ"
            and error[1] != error[2]
        )
        return ', which takes a straightness such as "EZX"', fits and not angle
    if test == "half-turn":
        return ', which takes "B0C" (scanned along X) or "A0C" (along Y)', error in HALF_TURN and not angle
    if test == "face":
        return ', which finds "EZC" and a tilt', error == "EZC" and not angle
    wanted = "ABC" if angle else "XYZ"
    what = 'an angle of the axis such as "ECC"' if angle else 'an error motion of the axis such as "EXC"'
    fits = len(error) >= 3 and error[0] == "E" and is_rotary(error[2:]) and error[1] in wanted
    return f", which takes {what}", fits


def _read(
    model: RecordingFile, table: ReversalTable, words: ReversalTable, data: Path, name: str
) -> ReversalFile:
    angle = model.kind == "angle"
    axis = HALF_TURN[words.error][0] if words.test == "half-turn" else words.error[2:]
    run = read_positions(data, (axis,))
    column = "d_urad" if angle else "d_um"
    at = f"{data}:1"
    if column not in run.columns:
        raise DataError(f"{at}: the column {column} is missing; it holds what the probe read")
    if "setup" not in run.labels and words.test != "direct":
        raise DataError(
            f"{at}: the column setup is missing; it says in which set-up each row was read: normal or reversed, or the angle of the "
            "artefact in degrees of a multi-step test"
        )
    value = run.columns[column] * (1e-6 if angle else 1e-3)
    u = noise_law(model.noise, angle).u if model.noise is not None else None
    sense = 1.0 if words.sense == "+" else -1.0
    reversal_file = ReversalFile(name=name, kind=words.test, error=words.error, axis=axis, sense=sense, u=u)
    if words.test in ALONG_LINE:
        lever = HALF_TURN.get(words.error, ("", -1.0))[1]
        tilt = quantity(words.axis_tilt, "angle", "axis_tilt", "0.1 urad")
        return replace(reversal_file, scans=_scans(run, axis, value), lever=lever, axis_tilt=tilt)
    groups = _groups(run, axis, value, words.harmonics, u)
    return replace(reversal_file, test=_turning(words, sense), groups=groups)


def _turning(words: ReversalTable, sense: float) -> ReversalTest:
    if words.test != "face":
        return ReversalTest(words.test, words.error, sense=sense)
    arms = {p: quantity(t, "length", f"probes {p}", "25 mm") for p, t in words.probes.items()}
    return ReversalTest(
        "face", words.error, words.tilt, arms, lever=TILTS[words.tilt], sense=sense, u_centre=words.u_centre
    )


def _label(run: Run, name: str) -> np.ndarray:
    return run.labels.get(name, np.full(run.n, "", dtype=np.str_))


def _scans(run: Run, axis: str, value: Array) -> tuple[LineScan, ...]:
    """Return one scan per set-up and run."""
    setup, number = _label(run, "setup"), _label(run, "run")
    pairs = list(dict.fromkeys(zip(setup.tolist(), number.tolist())))
    rows = [np.flatnonzero((setup == s) & (number == r)) for s, r in pairs]
    return tuple(LineScan(s, run.q(axis)[i], value[i]) for (s, _), i in zip(pairs, rows))


def _groups(run: Run, axis: str, value: Array, orders: int, u: float | None) -> tuple[TurnGroup, ...]:
    """Turns per set-up and probe; the angle must go on over the turns of one group, or every turn is a run of its own."""
    setup, probe, number = _label(run, "setup"), _label(run, "instrument"), _label(run, "run")
    out = []
    for s, p in dict.fromkeys(zip(setup.tolist(), probe.tolist())):
        rows = np.flatnonzero((setup == s) & (probe == p))
        if len(rows) < 2 * orders + 1:
            raise UsageError(
                f'set-up "{s}" {p}: {len(rows)} readings; {orders} orders need {2 * orders + 1} in every turn, or write harmonics smaller'
            )
        angle = _going_on(run.q(axis)[rows], number[rows])
        out.append(turn_group(s, p, angle, value[rows], orders, u))
    return tuple(out)


def _going_on(angle: Array, number: np.ndarray) -> Array:
    """Return the angles of runs one after the other, each a whole number of turns later; and of one run that starts anew at 0 after 360 deg."""
    turn = 2 * np.pi
    out, last = np.array(angle), None
    way = -1.0 if (np.diff(angle) < 0).mean() > 0.5 else 1.0
    for group in dict.fromkeys(number.tolist()):
        rows = np.flatnonzero(number == group)
        here = way * (np.unwrap(angle[rows]) if float(np.ptp(angle[rows])) <= turn + 1e-9 else angle[rows])
        if (np.diff(here) < 0).mean() > ASTRAY:
            raise UsageError(
                "the angles go to and fro; write the rows in the order in which they were read, the axis turning one way"
            )
        if last is not None:
            here = here + np.ceil((last - here[0]) / turn - 1e-9) * turn
        out[rows], last = way * here, float(here.max())
    return out
