"""The diagnosis as a Python call; the command line calls the same function.

The diagnosis of a recording whose sensors have gaps (see sensor_gaps).

Physics without a name that was found when the recording was made: it is part of the known uncertainty.

A part that comes back measured is searched for waves in time down to two points per period, along all directions at once, which is
beyond the shapes that are searched here. It is passed on as a covariance called "unknown ...", so that no name takes
its place, and the verdict has to say it.

A possible opposite sign of all readings is reported, never decided: only the operator knows the sense of `observed`.

A recording of the other sign holds minus what the machine's file predicts, so that its residual holds minus twice:

    c = d . r / d . d -> -2,    u(c) = sigma / |d|      d: white prediction of all known effects, r: white residual
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.blocks import Progress
from vcmm.core.effect import Effect
from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.learn.diagnosis.constants import FAR_SIGMAS, OUTLYING, VANISHING_SHARE
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.result import Diagnosis, NextStep, Unknown
from vcmm.learn.diagnosis.sensor_gaps import rows_for_effects, rows_with_all_readings, sensors_of
from vcmm.learn.diagnosis.thinning import limit_observations, thinning_notes
from vcmm.learn.diagnosis.verdict import verdict
from vcmm.physics import ALL
from vcmm.task.response.observe import baseline
from vcmm.task.response.recording import UNKNOWN, Recording

LOOK = 'look at `observed` ("indicated - true" against "actual - commanded")'


def opposite_sign_remarks(recording: Recording, machine: Machine, d: Diagnosis) -> tuple[str, ...]:
    """Return the sentences about a sign over everything; none where a mistake of the table says so already."""
    if d.mistake is not None and d.mistake.what == "sign":
        return ()
    c, u = multiple_of_prediction(recording, machine)
    if abs(c) > OUTLYING * u and abs(c + 2.0) < FAR_SIGMAS * u:
        return (
            f"the residual holds {c:.1f} times what the machine file predicts (standard uncertainty {u:.1f}; -2 where all"
            f" readings have the opposite sign): `observed` may be the wrong way round; {LOOK}",
        )
    for kind in ALL:
        opposite = kind.about.words.opposite if kind.about.words else None
        if opposite is None or not opposite.rare:
            continue
        answers = [a for a in d.answer if a.effect == kind.name]
        places = [
            str(v)
            for a in answers
            if _is_negative(a.parameters.get(opposite.parameter))
            for v in a.where.values()
        ]
        if places:
            return (
                f"{', '.join(places)} {opposite.rare}, which is rare: if all readings had the opposite sign, it would be an"
                f" ordinary {kind.name}, and every other sign of the answers would turn too; {LOOK}",
            )
    return ()


def _is_negative(number: object) -> bool:
    return float(getattr(number, "value", 0.0)) < 0.0


def multiple_of_prediction(recording: Recording, machine: Machine) -> tuple[float, float]:
    """Return c and u(c) of the docstring of this module; (0, inf) where the machine file predicts nothing that is seen."""
    try:
        problem = make_problem(recording, machine)
        blank = baseline(problem.recording, replace(machine, effects=(), inputs=()))
        stored = baseline(problem.recording, machine) - blank
        white = problem.whitener()
    except ModelLimit:
        return 0.0, float("inf")
    d, r = white.apply(stored[:, None])[:, 0], white.apply(problem.residual)
    size = float(np.linalg.norm(d))
    if size < VANISHING_SHARE:
        return 0.0, float("inf")
    sigma = float(np.sqrt(r @ r / white.dof))
    return float(d @ r) / size**2, sigma / size


WAVES = 10  # that are watched: their period is known to a hundredth then


def describe_unknown(diagnosis: Diagnosis, recording: Recording) -> Diagnosis:
    """Return the diagnosis with the unknown of the recording reported: verdict, reason, what to measure next."""
    unknowns = [(name.removeprefix(UNKNOWN), k) for name, k in recording.known if name.startswith(UNKNOWN)]
    if not unknowns:
        return diagnosis
    rests = [
        Unknown(("time",), f"a {what}, which no effect of the catalogue does", _rms(k), is_drawable=False)
        for what, k in unknowns
    ]
    why = tuple(f"something without a name is in the recording: {rest.description}" for rest in rests)
    steps = tuple(step for what, _ in unknowns if (step := _watch_wave(what)) is not None)
    return replace(
        diagnosis,
        verdict=verdict(bool(diagnosis.found), (*diagnosis.reasons, *why)),
        reasons=(*diagnosis.reasons, *why),
        unknown=diagnosis.unknown or rests[0],
        next_measurement=(*steps, *diagnosis.next_measurement),
    )


def _rms(columns: np.ndarray) -> float:
    """Return the rms of the shape to which columns (m, r) are scaled."""
    return float(np.sqrt(np.mean(columns**2)))


def _watch_wave(what: str) -> NextStep | None:
    """Return how to see a wave of time by itself: nothing moves, so that no axis and no cutting causes it."""
    match = re.search(r"wave of ([\d.e+]+) s", what)
    if match is None:
        return None
    period = float(match[1])
    do = (
        f"Leave the axes standing with the spindle, pumps and cooling switched on as in the cut, and log an indicator from the spindle to the "
        f"table in X, Y and Z for {WAVES * period:.3g} s, at least every {period / 10:.2g} s: what swings with {period:.3g} s comes from beside the "
        "axes; switch the units off one by one. If nothing swings, it comes with the motion: log the axes' actual positions over the same program."
    )
    return NextStep((what,), do, 3 * WAVES * period / 60.0, 0.0)


def diagnose_with_gaps(
    recording: Recording, machine: Machine, ask: Callable[[Recording], Diagnosis]
) -> Diagnosis:
    """Diagnose a recording whose sensors have gaps. ask: the diagnosis of one without."""
    first = ask(rows_with_all_readings(recording))
    fitted = [a.fitted for a in first.found if a.fitted is not None]
    needed = sensors_of(recording, (*machine.effects, *fitted))
    whole = rows_for_effects(recording, (*machine.effects, *fitted))
    remarks = _gap_remarks(recording, whole, needed)
    if whole.m == rows_with_all_readings(recording).m:
        return replace(first, warnings=(*first.warnings, *remarks))
    second = ask(whole)
    untested = {n: c for n, c in second.not_testable.items() if n in first.not_testable}
    return replace(second, not_testable=untested, warnings=(*second.warnings, *remarks))


def _gap_remarks(recording: Recording, whole: Recording, needed: tuple[str, ...]) -> tuple[str, ...]:
    read = rows_with_all_readings(recording).m
    out = []
    for name, rows in recording.unread:
        lost = int(recording.touching(rows).sum())
        if name in needed:
            out.append(
                f"{lost} observations without a reading of {name} are not used: an effect of the machine file or a found one depends on it"
            )
        else:
            out.append(
                f"what depends on {name} was looked for in the {read} observations that have its reading and was not found; all other"
                f" names were looked for in {whole.m}"
            )
    return tuple(out)


def diagnose(
    recording: Recording,
    machine: Machine,
    *,
    seed: int = 0,
    extra_effects: Sequence[type[Effect]] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Find the physics in a recording that the machine lacks: causes, rivals, held-out improvement, next measurement.

    Of more than 100 000 observations some are taken, with a note (see vcmm.learn.diagnosis.thinning).
    """
    recording = limit_observations(recording)

    def ask(rows: Recording) -> Diagnosis:
        return diagnose_recording(rows, machine, seed=seed, extra_effects=extra_effects, progress=progress)

    diagnosis = diagnose_with_gaps(recording, machine, ask) if recording.unread else ask(recording)
    diagnosis = describe_unknown(diagnosis, recording)
    warnings = (
        *recording.notes,
        *thinning_notes(recording),
        *diagnosis.warnings,
        *opposite_sign_remarks(recording, machine, diagnosis),
    )
    return replace(diagnosis, warnings=warnings)
