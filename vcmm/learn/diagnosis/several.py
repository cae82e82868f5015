"""Diagnose several recordings of one machine: common effects are named from all rows together, those of one recording from its own.

1. each recording is diagnosed by itself
2. every name found is measured again in all of them, as a multiple of its size; where these contradict one another (chi-square,
   the errors of templates forgiven) the name is no property of the machine: each recording loses its own share of it
3. the residuals are joined and diagnosed as one; a name that is found now and contradicts itself goes the same way

A name with a lag, period or moment is never removed so: found in one recording its shape may be wrong for the others, and
then its sizes contradict one another although the physics is one. It is found from all rows, and its sizes are reported.

One recording given twice in one call is no second witness: every interval would come out too narrow by sqrt(2).

Two recordings are the same where all rows of the smaller are in the other: same places, same readings to the last digit, in
any order. Repeats that a coarse display shows alike are no copies: two readings of one place agree with probability
q / (2 sqrt(pi) s), q the step of the display, s the scatter; copies are rows that would all agree by chance in less than CHANCE.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm.answer.evaluation.gaussian import whitener
from vcmm.core.blocks import Progress
from vcmm.core.effect import Effect, parameter_fields
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import FALSE_ALARM, LEAST_FRACTION, MISMATCH
from vcmm.learn.diagnosis.estimates import estimates_json
from vcmm.learn.diagnosis.improve import departure_from
from vcmm.learn.diagnosis.job import diagnose
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.learn.diagnosis.result import Answer, Diagnosis, Transfer, diagnosis_json
from vcmm.learn.diagnosis.sanity import CHANCE, display_step, usual_u
from vcmm.learn.diagnosis.scans import is_change
from vcmm.learn.diagnosis.sensor_gaps import rows_with_all_readings
from vcmm.learn.diagnosis.thinning import limit_together
from vcmm.learn.diagnosis.written_machine import add_written_fit, changes_machine, rms_under, written_machine
from vcmm.task.response.folds import Mask
from vcmm.task.response.joining import join_recordings
from vcmm.task.response.recording import Ints, Recording


def refuse_copies(recordings: Sequence[Recording], machine: Machine) -> None:
    """Raises UsageError with both names where one recording holds another."""
    for first, second in itertools.combinations(recordings, 2):
        few, many = sorted((first, second), key=lambda r: r.m)
        if few.m and _rows(few) <= _rows(many) and _is_surely_copied(few, machine):
            raise UsageError(
                f"all {few.m} readings of {few.name} stand in {many.name} too, to the last digit: a copy is no second witness;"
                f" give only {many.name}"
            )


def _rows(recording: Recording) -> set[bytes]:
    """Return every observation: reading, direction, position of the machine and offset."""
    run = recording.run
    parts = [recording.value[:, None], recording.direction, run.offset[recording.row]]
    parts += [run.position[a][recording.row][:, None] for a in sorted(run.position)]
    table = np.concatenate(parts, axis=1) + 0.0  # -0 is 0
    return {row.tobytes() for row in table}


def _is_surely_copied(recording: Recording, machine: Machine) -> bool:
    """Return whether its readings would not all repeat by chance."""
    u, step = usual_u(recording, machine), display_step(recording.value)
    chance = min(step / (2.0 * np.sqrt(np.pi) * u), 1.0) if u > 0 else 1.0
    return bool(recording.m * np.log(max(chance, LEAST_FRACTION)) < np.log(CHANCE))


ROUNDS = 3  # names that are each one's own may hide behind one another
LEAST_SIZE = (
    1.0  # size of a name in a recording, in units of its noise, below which the recording does not measure it
)


@dataclass(frozen=True)
class Size:
    """A name in one recording alone: its size as a multiple of the common one; None where the recording does not show it."""

    recording: str
    times: float | None
    u: float | None


@dataclass(frozen=True, eq=False)
class SharedAnswer:
    """A name and its sizes. is_common: they agree; p of their chi-square."""

    answer: Answer
    sizes: tuple[Size, ...]
    p: float

    @property
    def is_common(self) -> bool:
        return self.p >= FALSE_ALARM


@dataclass(frozen=True, eq=False)
class Several:
    """together: the diagnosis of all rows, less the effects of single recordings; shared_answers: its names with their sizes in each, and
    those that are each one's own; alone: the diagnosis of each by itself; left_out: column -> recordings that lack it.
    """

    together: Diagnosis
    shared_answers: tuple[SharedAnswer, ...]
    alone: tuple[tuple[str, Diagnosis], ...]
    recording: Recording
    left_out: dict[str, tuple[str, ...]]


def diagnose_several(
    recordings: Sequence[Recording],
    machine: Machine,
    *,
    seed: int = 0,
    extra_effects: Sequence[type[Effect]] = (),
    progress: Progress | None = None,
) -> Several:
    """Diagnose recordings of one machine together: what is common, and what is each one's own.

    Parameters
    ----------
    recordings
        Two or more, of the same kind.
    machine
        The machine that all of them were made on.
    seed
        Seed of the null recordings that set the false-alarm threshold.
    extra_effects
        Effect classes of your own, looked for beside the list.
    progress
        Called with what is done and its share, 0 to 1.

    Returns
    -------
    Several
        The diagnosis of all rows, names with their sizes in each recording, and each recording by itself.

    Raises
    ------
    UsageError
        They cannot be joined, or one is given twice.
    """
    recordings = [_rows_with_all_readings(r) for r in limit_together(recordings)]
    refuse_copies(recordings, machine)
    whole = join_recordings(recordings, machine)

    def diagnose_one(recording: Recording) -> Diagnosis:
        return diagnose(recording, machine, seed=seed, extra_effects=extra_effects, progress=progress)

    names, rest = [r.name for r in recordings], whole.recording
    differences: tuple[SharedAnswer, ...] = ()
    alone = tuple((r.name, diagnose_one(r)) for r in recordings)
    answers: Sequence[Answer] = unique_answers([a for _, d in alone for a in d.found if not has_scan(a)])
    for turn in range(ROUNDS + 1):
        problem = make_problem(rest, machine)
        shared = measure_shared_names(answers, problem, whole.part, names)
        differing = tuple(s for s in shared if not s.is_common and not has_scan(s.answer))
        rest, differences = remove_own_shares(problem, whole.part, differing), (*differences, *differing)
        if turn and not differing:
            break
        together = diagnose_one(rest)
        answers = together.found
    agreeing = tuple(s for s in shared if s not in differing)
    together = add_written_fit(together, recordings, machine)  # of the rows as they were given
    together = replace(together, transfer=transfers(recordings, [d for _, d in alone], machine))
    return Several(together, (*agreeing, *differences), alone, rest, whole.left_out)


def _rows_with_all_readings(recording: Recording) -> Recording:
    """Return the rows at which every sensor has a reading: another recording may need a sensor that one alone does not."""
    read = rows_with_all_readings(recording)
    lost = recording.m - read.m
    remark = f"{lost} observations in which a sensor has no reading are set aside"
    return replace(read, notes=(*read.notes, remark)) if lost else read


def transfers(
    recordings: Sequence[Recording], alone: Sequence[Diagnosis], machine: Machine
) -> tuple[Transfer, ...]:
    """Return the residuals of every other recording under the machine file written from each, and under the machine before."""
    before = [rms_under([r], machine) for r in recordings]
    out = []
    for source, diagnosis in zip(recordings, alone):
        if not changes_machine(diagnosis):
            continue
        with_it = written_machine(diagnosis, machine)
        out += [
            Transfer(r.name, source.name, rms, rms_under([r], with_it))
            for r, rms in zip(recordings, before)
            if r is not source
        ]
    return tuple(out)


def has_scan(a: Answer) -> bool:
    """Return whether the name has a parameter that acts non-linearly: a lag, a period, a moment."""
    return a.fitted is not None and any(
        len(f.metadata["scan"]) > 1 or is_change(f) for f in parameter_fields(a.fitted)
    )


def unique_answers(answers: Sequence[Answer]) -> list[Answer]:
    """Return, of every name and place, the answer of highest evidence."""
    best: dict[tuple[str, tuple[tuple[str, str], ...]], Answer] = {}
    for a in sorted(answers, key=lambda a: -a.evidence):
        best.setdefault((a.effect, tuple(a.where.items())), a)
    return list(best.values())


def measure_shared_names(
    answers: Sequence[Answer], problem: Problem, part: Ints, names: Sequence[str]
) -> tuple[SharedAnswer, ...]:
    """Return the names that have a crisp number, with their sizes in every recording alone; part (m,): number of the recording."""
    named = [a for a in answers if a.fitted is not None]
    if not named:
        return ()
    templates = np.stack([answer_signal(a, problem) for a in named], axis=1)
    sizes = [_sizes(templates, problem, part == k, name) for k, name in enumerate(names)]
    return tuple(
        SharedAnswer(a, sizes_of_answer := tuple(s[i] for s in sizes), agreement(sizes_of_answer))
        for i, a in enumerate(named)
    )


def agreement(sizes: Sequence[Size]) -> float:
    """Return p of the chi-square of sizes about their weighted mean; 1 for fewer than two.

    No template is exact: MISMATCH of each size is forgiven.
    """
    from scipy.stats import chi2

    values = [(s.times, s.u) for s in sizes if s.times is not None and s.u is not None]
    if len(values) < 2:
        return 1.0
    value, u = np.array([v for v, _ in values]), np.array([v for _, v in values])
    variance = u**2 + (MISMATCH * value) ** 2
    mean = float((value / variance).sum() / (1.0 / variance).sum())
    return float(chi2.sf(float(((value - mean) ** 2 / variance).sum()), len(values) - 1))


def _sizes(templates: Array, problem: Problem, rows: Mask, name: str) -> list[Size]:
    """Fit all templates (m, k) together in the rows of one recording by least squares: return a factor for each."""
    apart = np.full(int(rows.sum()), -1, dtype=np.intp)
    white = whitener(problem.u[rows], problem.nuisance[rows], problem.calibration[rows], apart, 0.0)
    x, y = white.apply(templates[rows]), white.apply(problem.residual[rows])
    is_visible = np.linalg.norm(x, axis=0) > LEAST_SIZE
    gram = np.linalg.pinv(x[:, is_visible].T @ x[:, is_visible])
    times = gram @ (x[:, is_visible].T @ y)
    rest = y - x[:, is_visible] @ times
    spread = max(float(rest @ rest) / max(white.dof - int(is_visible.sum()), 1), 1.0)
    u, number = np.sqrt(spread * np.diag(gram)), np.cumsum(is_visible) - 1
    return [
        Size(name, float(times[number[i]]), float(u[number[i]])) if is_visible[i] else Size(name, None, None)
        for i in range(len(is_visible))
    ]


def answer_signal(a: Answer, problem: Problem) -> Array:
    """Return the effect of the common size of a name on the observations (m,)."""
    assert a.fitted is not None
    effect = departure_from(a.fitted, problem.machine)
    return problem.observer.through(effect, effect.error_motion(problem.run))


def remove_own_shares(problem: Problem, part: Ints, differing: Sequence[SharedAnswer]) -> Recording:
    """Return the recording less, in the rows of each, its share of the names `differing`, which are not common."""
    value = problem.recording.value
    for shared in differing:
        times = np.array([s.times or 0.0 for s in shared.sizes])
        value = value - times[part] * answer_signal(shared.answer, problem)
    return replace(problem.recording, value=value)


def several_json(several: Several) -> dict[str, Any]:
    """Return the keys of several recordings beside those of one: `shared` and `recordings`."""
    return {
        "shared": [
            {
                "effect": s.answer.effect,
                "where": dict(s.answer.where),
                "common": s.is_common,
                "p": s.p,
                "parameters": estimates_json(s.answer.parameters),
                "sizes": [{"recording": z.recording, "times": z.times, "u": z.u} for z in s.sizes],
            }
            for s in several.shared_answers
        ],
        "recordings": [
            {
                "recording": name,
                **{
                    k: v for k, v in diagnosis_json(d).items() if k in ("verdict", "answer", "unknown", "fit")
                },
            }
            for name, d in several.alone
        ],
    }
