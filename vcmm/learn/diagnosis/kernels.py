"""Free shapes over all columns of a recording, and the strength with which a residual follows each.

    t = |X' r|^2,   X: bumps about places, white, outside some chosen terms;   r: white residual

is the score of a Gaussian process with the kernel X X' (a variance component; Lin, Biometrika 84 (1997) 309). It needs no
shape: a stair, a swirl or a waviness of changing period raise it alike. Its law is that of the simulated null recordings:
z is ln t in standard deviations of theirs.

The residual and the nulls are pulled back to the observations once, X' r = F' (A' r), and never the bumps F made white.

Courses of time without a name: a smooth vector of time, the scale of an axis that changes with time, the size of the part.

    d(t) e            the tip moves along e; all three directions together are one test
    s(t) (q - q0) e   the scale of an axis: held at its zero, or anywhere (then d(t) e is a part of it)
    g(t) p            the part grows about its middle, p the place on it

d, s and g are sums of bumps over the clock, as wide as SMOOTH of the recording's duration: heating and cooling by a
source that nothing logs. A name that follows a thermometer, or several together, may mimic such a course; with these the
unknown competes in the same freedom.

A kernel of free shapes as a proposal in words: where, in which direction, and whether its shape can be drawn.

Neighbours that agree in the residual of the names are no scatter, for any shape. Two tests:

shape   over the axis and in the component of a named term: few kernels, so little is overlooked. A name that fits the
        coarse part of something else leaves the fine part there.
rest    over all columns of the recording.

The largest z of all kernels is compared with the largest of every null recording. Errors of templates are forgiven as in
the selection: what they leave may lie wholly in the strongest direction of a kernel.
"""

from __future__ import annotations

import heapq
import itertools
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, best_width, without_span
from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect, motion
from vcmm.core.run import Array, Run
from vcmm.learn.diagnosis.constants import FALSE_ALARM, LEAST_FRACTION, UNSEEN, VANISHING_SHARE
from vcmm.learn.diagnosis.evidence import orthonormal
from vcmm.learn.diagnosis.locate import direction_factors, direction_text
from vcmm.learn.diagnosis.neighbourhoods import component_shapes, neighbourhoods, observe_component
from vcmm.learn.diagnosis.null_recordings import upper_quantile
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, mismatch

SMOOTH = (0.06, 0.15, 0.4)  # of the duration: half an hour, an hour, half of a shift
WITH_A_PART = ("probe", "path")  # kinds that know where on the part a row is


@dataclass(frozen=True, eq=False)
class Course:
    """Effect of a smooth course of time on the observations, columns (m, k). names: covariates; what: in words."""

    names: tuple[str, ...]
    columns: Array
    what: str


def clock_times(problem: Problem) -> Array | None:
    """Return time_s (n,) where the recording has a clock that moves."""
    time = problem.run.columns.get("time_s")
    return time if time is not None and np.ptp(time) > 0 else None


def clock_bumps(time: Array, width: float) -> Array:
    """Return the bumps (n, k) over the clock, `width` of its range wide and half as far apart: their sum is as smooth everywhere."""
    z = (time - time.min()) / np.ptp(time)
    centres = np.linspace(0.0, 1.0, round(2.0 / width) + 1)
    return np.asarray(np.exp(-0.5 * ((z[:, None] - centres) / width) ** 2))


def time_bumps(problem: Problem) -> Iterator[Array]:
    """Yield bumps (m, k) over the clock, for any direction."""
    time = clock_times(problem)
    if time is not None:
        yield from (problem.per_observation(clock_bumps(time, width)) for width in SMOOTH)


def scale_courses(problem: Problem) -> Iterator[Course]:
    """Yield scales of axes and the size of the part that change with time."""
    time = clock_times(problem)
    if time is None:
        return
    grown = _growth_column(problem)
    for width in SMOOTH:
        bumps = clock_bumps(time, width)
        for axis, q in problem.run.position.items():
            if not is_rotary(axis) and np.ptp(q) > 0:
                yield from _of_scale(problem, axis, bumps)
        if grown is not None:
            what = "a size of the part that changes with time"
            yield Course(("time",), problem.per_observation(bumps) * grown[:, None], what)


def _of_scale(problem: Problem, axis: str, bumps: Array) -> Iterator[Course]:
    """Yield the scale of an axis held at its zero, and held anywhere; the largest factor is 1."""
    q = problem.run.position[axis]
    middle = q - q.mean()
    zero, spread = (v[:, None] / np.abs(v).max() for v in (q, middle))
    for shapes in (bumps * zero, np.concatenate([bumps, bumps * spread], axis=1)):
        moved = observe_component(problem, f"E{axis}{axis}", shapes)
        yield Course(("time", axis), moved, f"a scale of {axis} that changes with time")


def _growth_column(problem: Problem) -> Array | None:
    """Return the effect of a larger part on the observations (m,), 1 at its largest; None for machines that measure no part."""
    run = problem.run
    if problem.recording.kind not in WITH_A_PART or "part_x_mm" not in run.columns:
        return None
    x, y, z = run.part_point.T
    grown = problem.observer.through(_PartGrowth(), motion(run, X=x, Y=y, Z=z))
    largest = float(np.abs(grown).max())
    return grown / largest if largest > 0 else None


@dataclass(frozen=True, eq=False)
class _PartGrowth(Effect):
    """The part, which is indicated larger."""

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        return motion(run)


@dataclass(frozen=True, eq=False)
class Kernel:
    """Bumps (m, k) times a component of the sensitive direction, factor (m,). names: covariates; direction: "x", "y", "z" or
    "normal"; component: of a free shape over its axis, or ""; what: of a shape that no curve over the covariates draws, in words.
    """

    names: tuple[str, ...]
    direction: str
    bumps: Array
    factor: Array
    component: str = ""
    what: str = ""


@dataclass(frozen=True, eq=False)
class KernelTest:
    """One test: kernels that are added, the clearest of them, t and z of the residual and of every null (1 + M,)."""

    kernels: tuple[Kernel, ...]
    clearest: Kernel
    t: Array
    z: Array


@dataclass(frozen=True, eq=False)
class PulledResiduals:
    """Residual and nulls (m, 1 + M), white, outside `basis` and of length 1, pulled back to the observations up to a common
    factor; residual (m,): white, of length 1.
    """

    white: Whitener
    basis: Array
    residual: Array
    rows: Array
    _cache: dict[str, Array] = field(default_factory=dict)

    def times(self, kernel: Kernel) -> Array:
        """Return the rows times the kernel's factor; once per direction."""
        if kernel.component or kernel.what:
            return self.rows
        if kernel.direction not in self._cache:
            self._cache[kernel.direction] = self.rows * kernel.factor[:, None].astype(np.float32)
        return self._cache[kernel.direction]

    def columns(self, kernels: Sequence[Kernel]) -> Array:
        """Return white columns (m, k) of kernels, outside the basis; (m, 0) where nothing of them is seen."""
        columns = np.concatenate([k.bumps * k.factor[:, None] for k in kernels], axis=1)
        x = without_span(self.white.apply(columns), self.basis)
        before = float(np.linalg.norm((self.white.weight * columns.T).T))
        return x if float(np.linalg.norm(x)) > VANISHING_SHARE * before else x[:, :0]


def pull_back(white: Whitener, basis: Array, rows: Array) -> PulledResiduals:
    """Pull back rows (m, 1 + M): white residual and nulls."""
    rows = without_span(rows, basis)
    rows = rows / np.maximum(np.linalg.norm(rows, axis=0), LEAST_FRACTION)
    back = white.adjoint(rows)
    return PulledResiduals(white, basis, rows[:, 0], (back / np.abs(back).max()).astype(np.float32))


def component_kernels(problem: Problem, components: Iterable[str]) -> Iterator[list[Kernel]]:
    """Yield free shapes of component errors over their axes."""
    alone = np.ones(problem.m)
    for c in (c for c in components if np.ptp(problem.run.q(c[2])) > 0):
        for moved in component_shapes(problem, c):
            yield [Kernel((c[2],), "normal", moved, alone, c)]


def all_kernels(problem: Problem) -> Iterator[list[Kernel]]:
    """Yield groups of kernels that differ by their direction only."""
    for near in neighbourhoods(problem):
        yield [Kernel(near.names, d, near.bumps, f) for d, f in direction_factors(problem).items()]
    yield from time_kernels(problem)


def time_kernels(problem: Problem) -> Iterator[list[Kernel]]:
    """Yield the smooth courses of time among them."""
    for bumps in time_bumps(problem):
        yield [Kernel(("time",), d, bumps, f) for d, f in direction_factors(problem).items()]
    alone = np.ones(problem.m)
    for course in scale_courses(problem):
        yield [Kernel(course.names, "normal", course.columns, alone, what=course.what)]


def kernel_tests(groups: Iterable[list[Kernel]], rows: PulledResiduals) -> Iterator[KernelTest]:
    """Yield every kernel by itself, and those of x, y and z together: a swirl turns."""
    return itertools.chain.from_iterable(_of_group(group, rows) for group in groups)


def _of_group(group: list[Kernel], rows: PulledResiduals) -> Iterator[KernelTest]:
    bumps = group[0].bumps.T.astype(np.float32)
    alone = []
    for k in group:
        t = ((bumps @ rows.times(k)) ** 2).sum(axis=0).astype(float)
        alone.append(KernelTest((k,), k, t, normal_scores(t)))
    yield from alone
    turned = [a for a in alone if a.clearest.direction in tuple("xyz")]
    if len(turned) > 1:
        total = np.sum([a.t for a in turned], axis=0)
        clearest = max(turned, key=lambda a: float(a.z[0])).clearest
        yield KernelTest(tuple(a.clearest for a in turned), clearest, total, normal_scores(total))


def normal_scores(t: Array, forgiven: float = 0.0) -> Array:
    """Return z (1 + M,) of t; a share `forgiven` of the residual's own t, the first, may come from errors of templates."""
    of_data = t[0] * max(1.0 - np.sqrt(forgiven), UNSEEN) ** 2
    logs = np.log(np.maximum(np.r_[of_data, t[1:]], LEAST_FRACTION))
    return np.asarray((logs - logs[1:].mean()) / max(float(logs[1:].std()), UNSEEN**2))


def largest_gain(x: Array) -> float:
    """Return the largest of |X' e|^2 over unit vectors e."""
    small = x.T @ x if x.shape[1] < len(x) else x @ x.T
    return float(np.linalg.eigvalsh(small)[-1])


def principal_functions(x: Array, count: int) -> Array:
    """Return the first principal functions (m, count at most) of bumps x (m, k), the first of rms 1."""
    turn = principal_coefficients(x, count)
    return x[:, :0] if turn is None else np.asarray(x @ turn)


def principal_coefficients(x: Array, count: int) -> Array | None:
    """Return the coefficients (k, count at most) that make bumps x (m, k) their first principal functions; None where x is nothing."""
    value, vector = np.linalg.eigh(x.T @ x)
    first = np.argsort(-value)[:count]
    if not x.shape[1] or value[first[0]] <= 0:
        return None
    return np.asarray(vector[:, first] * np.sqrt(len(x) / float(value[first[0]])))


def components_of(terms: Sequence[SelectedTerm]) -> tuple[str, ...]:
    """Return the component errors in which terms move their axes: of their places, or the positioning errors of their axes."""
    components = {c for t in terms for c in (t.family.where.get("component", ""), _positioning(t))}
    return tuple(sorted(c for c in components if len(c) == 3 and c[0] == "E" and c[2] in "XYZ"))


def _positioning(term: SelectedTerm) -> str:
    axis = term.family.where.get("axis", "")
    return f"E{axis}{axis}"


def propose_unknown(kernel: Kernel, problem: Problem, rms: float, says: str) -> Unknown:
    """Return the unknown over the covariates of a kernel; `says` with {} for the names.

    A translation of a component is drawn in its own direction; the effect of a rotation depends on the arm, so that no curve
    over the axis can show it.
    """
    over = " and ".join(kernel.names)
    letter = kernel.component[1:2].lower()
    direction = letter if letter in direction_factors(problem) else kernel.direction
    if kernel.what:
        what = kernel.what
    elif kernel.component:
        what = f"a shape of {kernel.component} over {over}"
    else:
        what = f"a dependence on {over} {direction_text(direction)} without a name"
    is_drawable = kernel.component[1:2] not in tuple("ABC") and not kernel.what
    text = f"{what} {says.format('the names' if kernel.component == '' else 'its names')}"
    return Unknown(kernel.names[:3], text, rms, direction, len(kernel.names) > 1, is_drawable=is_drawable)


NOTHING_NAMED = (
    FALSE_ALARM / 3
)  # a null recording has paid 1 % to the catalogue and 1 % to the shapes already
BEYOND = 10  # null recordings beyond the threshold, where there are so many
MOST_QUESTIONS = 20  # of the clearest questions: where templates explain them all, there is none to ask
FUNCTIONS = MOST_QUESTIONS  # in which the size of a departure is estimated


def find_departure(problem: Problem, selection: Selection, white: Whitener, null: Array) -> Unknown | None:
    """Return the clearest departure from white, None where chance explains it. null (m, M): prepared null recordings, white."""
    basis = orthonormal(np.concatenate([null[:, :0], *(t.white for t in selection.terms)], axis=1))
    alarm = FALSE_ALARM if selection.terms else NOTHING_NAMED
    rows = pull_back(white, basis, np.column_stack([selection.rest, null[:, : round(BEYOND / alarm)]]))
    forgiven = (
        2.0
        * mismatch(selection)
        * _variance(selection)
        / max(float(selection.rest @ selection.rest), LEAST_FRACTION)
    )
    question = _clearest(component_kernels(problem, components_of(selection.terms)), rows, forgiven, alarm)
    question = question or _clearest(all_kernels(problem), rows, forgiven, alarm)
    return (
        None if question is None else _measure_departure(question[0], problem, question[1], selection, white)
    )


def _variance(selection: Selection) -> float:
    """Return the variance of the noise found, in units of the one stated: `mismatch` counts in the former, residuals in the latter."""
    return selection.fit.sigma**2 if selection.fit else 1.0


def _clearest(
    groups: Iterable[list[Kernel]], rows: PulledResiduals, forgiven: float, alarm: float
) -> tuple[Kernel, Array] | None:
    """Return the kernel of the largest departure and its white columns, where it exceeds what a share `alarm` of the null
    recordings reaches.
    """
    largest = np.full(rows.rows.shape[1] - 1, -np.inf)
    clearest = heapq.nlargest(
        MOST_QUESTIONS, _track_largest(kernel_tests(groups, rows), largest), key=lambda a: float(a.z[0])
    )
    limit = upper_quantile(largest, alarm)
    for question in (a for a in clearest if a.z[0] > limit):
        x = rows.columns(question.kernels)
        if x.shape[1] and normal_scores(question.t, _template_share(x, rows, forgiven))[0] > limit:
            return question.clearest, rows.columns([question.clearest])
    return None


def _track_largest(trials: Iterable[KernelTest], largest: Array) -> Iterator[KernelTest]:
    """Yield the same, while `largest` (M,) takes the largest z of every null recording."""
    for question in trials:
        np.maximum(largest, question.z[1:], out=largest)
        yield question


def _template_share(x: Array, rows: PulledResiduals, forgiven: float) -> float:
    """Return the share of t that errors of templates of energy `forgiven` (over that of the residual) may bring, at their worst."""
    return largest_gain(x) * forgiven / max(float(np.sum((x.T @ rows.residual) ** 2)), LEAST_FRACTION)


def _measure_departure(
    kernel: Kernel, problem: Problem, columns: Array, selection: Selection, white: Whitener
) -> Unknown:
    """Return the departure with its size, from the principal functions of the kernel."""
    functions = principal_functions(columns, FUNCTIONS)
    fit = best_width(functions, selection.rest, white.dof)
    rms = float(np.sqrt(np.mean((functions @ fit.mean / white.weight) ** 2)))
    return propose_unknown(kernel, problem, rms, "is left that no name explains: neighbours agree")
