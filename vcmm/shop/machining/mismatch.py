"""Departures of a measured part from its prediction: by feature, line of the program and covariate, with their significance.

    rest = measured - predicted = B b + X c + scatter      cov(rest) = C + s^2 1

C holds everything that is known to be uncertain, B the alignment of the part (a nuisance). Each covariate is a
small set of columns X: what moves the tool (along X, Y or Z, in proportion to position, direction, time ...) shows along the
normal of each point, what changes the tool shows across its axis. A covariate is tested by the F of its columns against the
residual of all covariates together; s is found so that this rest has its expected size. The best one is taken into B and the
others are tested again. p counts all that were tested (Bonferroni). Source: Rao, Linear Statistical Inference (1973), ch. 4.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError
from vcmm.core.run import FORCE_COLUMNS, Array, Run
from vcmm.shop.machining.significance import log_p, p_in_words
from vcmm.shop.machining.waves import Wave, largest_wave, slow_courses

Ints = npt.NDArray[np.intp]
Words = npt.NDArray[np.str_]
FALSE = 1e-3  # share of parts as predicted in which any entry is reported
MOST_ENTRIES = 6  # entries
# times the least p: such covariates cannot be told apart, and the first of the list is named
SAME_P_FACTOR = 1e2
LEAST_SCATTER, MOST_SCATTER = 2e-5, 1.0  # mm: of a measured point
LEAST_FREEDOM = 8  # degrees of freedom that must be left beside all covariates
SAME_VALUE_SHARE = 1e-9
AXES = "XYZ"
WAVE, NOTHING_ASKED = "wave in time", "nothing that was asked"


@dataclass(frozen=True, eq=False)
class ObservedPoints:
    """n measured points: rest (n,) mm outwards, its covariance (n, n), normals and place in the part (n, 3), workpiece axes.

    feature (n,), line (n,) of the program that cut it; run: the machine at that moment.
    """

    rest: Array
    covariance: Array
    normals: Array
    place: Array
    feature: Words
    line: Ints
    run: Run


@dataclass(frozen=True, eq=False)
class Covariate:
    """A possible cause: name, description ("grows with time"), columns (n, m) along the normals."""

    name: str
    words: str
    columns: Array


@dataclass(frozen=True)
class MismatchEntry:
    """An entry: where it is largest (feature, line), its covariate, p of that among all that were tested, rms in mm."""

    feature: str
    line: int
    covariate: str
    p: float
    rms: float
    text: str


@dataclass(frozen=True, eq=False)
class Mismatch:
    """Covariates of the rest in `entries`; scatter: of one point, mm; wave: where the best covariate is a wave of no known cause."""

    entries: tuple[MismatchEntry, ...]
    scatter: float
    wave: Wave | None = None


def locate_mismatch(points: ObservedPoints, *, rigid: bool = True, u_point: float | None = None) -> Mismatch:
    """Return the covariates of the rest. rigid: the part may lie anywhere (drawing frame).

    Raises UsageError for fewer points than the covariates need.
    """
    possible = _fitting(list(covariates(points)), points, rigid)
    base = _nuisance(points, rigid)
    every = np.hstack([base, *(c.columns for c in possible)])
    white, scatter, left = _whiten(points, every, u_point)
    out: list[MismatchEntry] = []
    taken, wave, tied = base, None, False
    for _ in range(MOST_ENTRIES):
        tested = [(_p(white, taken, c.columns, points.rest, left), c) for c in possible]
        waving = None if wave else _waving(points, white, taken, left)
        count = len(possible) + (waving is not None)
        tested += [(waving[0], waving[1])] if waving else []
        least = min(p for p, _ in tested)  # logarithms: far beyond chance all p are 0
        if not least + math.log(count) < math.log(FALSE):
            break
        alike = [(math.exp(p), c) for p, c in tested if p <= math.log(SAME_P_FACTOR) + least]
        p, best = alike[0]
        if waving and best is waving[1]:
            wave = waving[2]
        rivals = [c.name for _, c in alike[1:]]
        tied = tied or (bool(rivals) and not out)
        out.append(_entry(points, white, taken, best, p=min(p * count, 1.0), rivals=rivals))
        taken = np.hstack([taken, best.columns])
        possible = [c for c in possible if c is not best]
        if not possible:
            break
    leads = bool(out) and out[0].covariate == WAVE and not tied
    out += _left_over(points, white, taken) if left is None and len(out) < MOST_ENTRIES else []
    return Mismatch(tuple(out), scatter, wave if leads else None)


def _left_over(points: ObservedPoints, white: Array, taken: Array) -> list[MismatchEntry]:
    """Return an entry where the residual after everything taken exceeds the known uncertainty (chi-square)."""
    from scipy import stats

    q = _directions(white @ taken)
    y = np.asarray(white @ points.rest)
    y = np.asarray(y - q @ (q.T @ y))
    freedom = len(y) - q.shape[1]
    p = float(stats.chi2.sf(y @ y, freedom))
    if p >= FALSE:
        return []
    features, code = np.unique(points.feature, return_inverse=True)
    at = int(np.argmax(np.bincount(code, y * y)))
    line = _line_of_most(points.line[code == at], y[code == at] ** 2)
    text = (
        f"{features[at]}: {math.sqrt(y @ y / freedom):.3g} times what is known to be uncertain is left, most where line {line} cuts, and it "
        f"goes with nothing that was asked ({p_in_words(p)})"
    )
    return [
        MismatchEntry(
            str(features[at]), line, NOTHING_ASKED, p, float(np.sqrt((points.rest**2).mean())), text
        )
    ]


def _waving(
    points: ObservedPoints, white: Array, taken: Array, left: tuple[float, int] | None
) -> tuple[float, Covariate, Wave] | None:
    """Return (logarithm of the significance, corrected for every period; the covariate; the wave) of the largest wave in time."""
    time = points.run.columns.get("time_s")
    if time is None:
        return None
    base = _directions(white @ np.hstack([taken, slow_courses(points.normals, time)]))
    wave = largest_wave(white, base, points.rest, points.normals, time)
    if wave is None:
        return None
    alone, _ = _gain(white, taken, wave.columns, points.rest)
    gain = alone if wave.gain > alone / 2 else wave.gain  # else more of it is a slow course than a wave
    p = log_p(gain, wave.freedom, left) + math.log(wave.periods_tried)
    words = f"comes and goes every {wave.period:.3g} s, which no effect that is known does"
    return min(p, 0.0), Covariate(WAVE, words, wave.columns), wave


# -- what may explain it ----------------------------------------------------------------------------------------------
def covariates(points: ObservedPoints) -> Iterator[Covariate]:
    """Yield everything that may explain the rest, from the state of the machine when the points were cut."""
    run, n = points.run, points.normals
    across = run.columns.get("across_tool", np.ones(run.n))
    yield Covariate("tool radius", "is the same wherever the side of the tool cuts", across[:, None])
    yield Covariate("where the part lies", "is a shift or a turn of the whole part", rigid_columns(points))
    for i, letter in enumerate(AXES):
        if letter in run.position:
            yield Covariate(
                letter,
                f"goes with the position of axis {letter}",
                n * _centre(run.position[letter])[:, None],
            )
        yield from _of_axis(run, letter, n[:, i])
    for letter in "ABC":
        if letter in run.position and _varies(run.position[letter]):
            turn = [n * f(run.position[letter])[:, None] for f in (np.cos, np.sin)]
            yield Covariate(letter, f"goes with the angle of axis {letter}", np.hstack(turn))
    yield from _running(points, across)
    if FORCE_COLUMNS[0] in run.columns:
        force = run.vector(*FORCE_COLUMNS)
        yield Covariate("cutting force", "goes with the cutting force", (n * force).sum(axis=1)[:, None])
    yield Covariate("place in the part", "is a bend of the part", _bends(points))
    yield from _label_covariates(points, across)


def machine_shapes(points: ObservedPoints, rigid: bool) -> Array:
    """Return columns (n, k) of machine, tools or a bend of the part: covariates but features and lines, and squares of positions."""
    place, n = points.run.position, points.normals
    columns = [c.columns for c in covariates(points) if c.name not in ("feature", "NC line")]
    squares = [n * _centre(place[a])[:, None] ** 2 for a in AXES if a in place]
    return _scale_columns(np.hstack([_nuisance(points, rigid), *columns, *squares]))


def _label_covariates(points: ObservedPoints, across: Array) -> Iterator[Covariate]:
    """Yield one feature, one tool, one line of the program."""
    for name in np.unique(points.feature):
        yield Covariate(
            "feature", f"belongs to {name} alone", (points.feature == name).astype(float)[:, None]
        )
    tools = points.run.labels["tool"]
    if len(np.unique(tools)) > 1:
        for name in np.unique(tools):
            mine = (tools == name).astype(float)
            yield Covariate(
                "tool", f"belongs to tool {name}", np.column_stack([mine * across, mine * (1 - across)])
            )
    for number in np.unique(points.line):
        mine = points.line == number
        if mine.sum() >= 3 and len(np.unique(points.line)) > 1:
            yield Covariate("NC line", f"belongs to line {number}", mine.astype(float)[:, None])


def _of_axis(run: Run, letter: str, along: Array) -> Iterator[Covariate]:
    """Yield direction, speed and acceleration of one linear axis, along it."""
    for column, name, words in (
        (f"sense_{letter}", "direction", f"turns its sign with the direction of axis {letter}"),
        (f"speed_{letter}_mm_s", "speed", f"goes with the speed of axis {letter}"),
        (f"accel_{letter}_mm_s2", "acceleration", f"goes with the acceleration of axis {letter}"),
    ):
        if column in run.columns and _varies(run.columns[column]):
            yield Covariate(f"{name} {letter}", words, (along * run.columns[column])[:, None])


def _running(points: ObservedPoints, across: Array) -> Iterator[Covariate]:
    """Yield time, temperatures, wear and feed: drifts in any direction, wear across the tool."""
    run, n = points.run, points.normals
    for column, name, words in [
        ("time_s", "time", "grows with time"),
        *((c, c.removesuffix("_C").removeprefix("temp_") + " temperature", "goes with this temperature")
          for c in run.columns if c.startswith("temp_")),
    ]:  # fmt: skip
        if column in run.columns and _varies(run.columns[column]):
            yield Covariate(name, words, n * _centre(run.columns[column])[:, None])
    for tool in np.unique(run.labels["tool"]):
        worn = across * run.columns.get("cut_length_mm", np.zeros(run.n)) * (run.labels["tool"] == tool)
        if _varies(worn):
            yield Covariate("cut length", f"grows with what tool {tool} has cut", worn[:, None])
    if "feed_mm_min" in run.columns and _varies(run.columns["feed_mm_min"]):
        yield Covariate("feed", "goes with the feed", (across * _centre(run.columns["feed_mm_min"]))[:, None])


def _bends(points: ObservedPoints) -> Array:
    """Return second-order surfaces of the part, per face: the bend after a clamp is released."""
    x, y, z = (points.place - points.place.mean(axis=0)).T
    n = points.normals
    columns = [n[:, 2] * f for f in (x * x, x * y, y * y)] + [n[:, i] * z * z for i in (0, 1)]
    return np.stack(columns, axis=1)


def _varies(values: Array) -> bool:
    return bool(np.ptp(values) > SAME_VALUE_SHARE * max(1.0, float(np.abs(values).max())))


def _centre(values: Array) -> Array:
    out = values - values.mean()
    return np.asarray(out / max(float(np.abs(out).max()), 1e-300))


# -- the test ---------------------------------------------------------------------------------------------------------
def _nuisance(points: ObservedPoints, rigid: bool) -> Array:
    """Return the columns of the alignment of the part, which is a nuisance in the drawing frame."""
    return rigid_columns(points) if rigid else np.zeros((len(points.rest), 0))


def rigid_columns(points: ObservedPoints) -> Array:
    """Return three shifts and three turns (rad x 100 mm) of the part, as they show along the normals (n, 6)."""
    arm = (points.place - points.place.mean(axis=0)) / 100.0
    return np.hstack([points.normals, np.cross(arm, points.normals)])


def _fitting(possible: list[Covariate], points: ObservedPoints, rigid: bool) -> list[Covariate]:
    """Return covariates whose columns are no alignment of the part, and few enough for the points."""
    base = _nuisance(points, rigid)
    kept = []
    for covariate in possible:
        beyond = _beyond(base, _scale_columns(covariate.columns))
        if beyond.shape[1]:
            kept.append(Covariate(covariate.name, covariate.words, _scale_columns(covariate.columns)))
    while kept and len(points.rest) < _rank(base, kept) + LEAST_FREEDOM:
        single = [c for c in kept if c.name == "NC line"] or [
            c for c in kept if c.name == "place in the part"
        ]
        if not single:
            raise UsageError(
                f"{len(points.rest)} measured points are too few to say where they depart from the prediction; measure at least "
                f"{_rank(base, kept) + LEAST_FREEDOM}"
            )
        kept = [c for c in kept if c.name != single[0].name]
    return kept


def _rank(base: Array, kept: list[Covariate]) -> int:
    return int(np.linalg.matrix_rank(np.hstack([base, *(c.columns for c in kept)]), tol=1e-8))


def _scale_columns(columns: Array) -> Array:
    size = np.sqrt((columns**2).mean(axis=0))
    return np.asarray(columns[:, size > SAME_VALUE_SHARE] / size[size > SAME_VALUE_SHARE])


def _beyond(base: Array, columns: Array) -> Array:
    """Return the orthonormal directions (n, r) that columns add to those of the base."""
    q = _directions(base)
    rest = columns - q @ (q.T @ columns)
    u, s, _ = np.linalg.svd(rest, full_matrices=False)
    return np.asarray(u[:, s > 1e-6 * max(1.0, float(np.linalg.norm(columns)))])


def _directions(columns: Array) -> Array:
    if not columns.shape[1]:
        return columns
    u, s, _ = np.linalg.svd(columns, full_matrices=False)
    return np.asarray(u[:, s > 1e-9 * s[0]])


def _whiten(
    points: ObservedPoints, every: Array, u_point: float | None
) -> tuple[Array, float, tuple[float, int] | None]:
    """Return (W with W cov W^T = 1, scatter mm, (sum of squares, freedom) of the residual after everything).

    None for the last where the scatter is given, and where the residual is smaller than C alone predicts: then C is complete, its size is
    known, and a sum of squares that the least scatter makes small must not replace it.
    """
    values, vectors = np.linalg.eigh(points.covariance)
    values = np.maximum(values, 0.0)

    def white(scatter: float) -> Array:
        return np.asarray((vectors / np.sqrt(values + scatter**2)) @ vectors.T)

    if u_point is not None:
        return white(u_point), u_point, None

    def rest(scatter: float) -> tuple[float, int]:
        w = white(scatter)
        q = _directions(w @ every)
        y = w @ points.rest
        return float(y @ y - ((q.T @ y) ** 2).sum()), len(y) - q.shape[1]

    low, high = np.log(LEAST_SCATTER), np.log(MOST_SCATTER)
    square, freedom = rest(LEAST_SCATTER)
    if square <= freedom:
        return white(LEAST_SCATTER), LEAST_SCATTER, None
    for _ in range(40):  # the sum of squares falls with the scatter
        middle = 0.5 * (low + high)
        square, freedom = rest(np.exp(middle))
        low, high = (middle, high) if square > freedom else (low, middle)
    scatter = float(np.exp(low))
    return white(scatter), scatter, rest(scatter)


def _p(white: Array, taken: Array, columns: Array, rest: Array, left: tuple[float, int] | None) -> float:
    """Return the logarithm of the significance of columns beside those already taken."""
    gain, m = _gain(white, taken, columns, rest)
    return log_p(gain, m, left) if m else 0.0


def _gain(white: Array, taken: Array, columns: Array, rest: Array) -> tuple[float, int]:
    """Return what columns explain beside those already taken: the sum of squares, and the number of parameters."""
    q = _beyond(white @ taken, white @ columns)
    return float(((q.T @ (white @ rest)) ** 2).sum()), q.shape[1]


def _entry(
    points: ObservedPoints, white: Array, taken: Array, best: Covariate, *, p: float, rivals: list[str]
) -> MismatchEntry:
    """Return the place where measured departure and fitted columns agree most, in words; the amount is measured less predicted."""
    every = np.hstack([taken, best.columns])
    c = np.linalg.lstsq(white @ every, white @ points.rest, rcond=None)[0]
    shape = best.columns @ c[taken.shape[1] :]
    features, code = np.unique(points.feature, return_inverse=True)
    both = np.abs(shape * points.rest)
    size = np.bincount(code, both) / np.bincount(code)
    feature = str(features[int(np.argmax(size))])
    mine = points.feature == feature
    line = _line_of_most(points.line[mine], both[mine])
    worst = float(points.rest[mine][int(np.argmax(both[mine]))])
    what = "more material than" if worst > 0 else "less material than"
    text = (
        f"{feature}: up to {abs(worst) * 1e3:.2f} um {what} predicted, most where line {line} cuts; it {best.words} "
        f"({p_in_words(p)}){f'; {_join_names(rivals)} would do as well' if rivals else ''}"
    )
    return MismatchEntry(feature, line, best.name, p, float(np.sqrt((shape**2).mean())), text)


def _line_of_most(line: Ints, amount: Array) -> int:
    """Return the line of the program that has most of an amount."""
    lines, which = np.unique(line, return_inverse=True)
    return int(lines[int(np.argmax(np.bincount(which, amount)))])


def _join_names(names: list[str]) -> str:
    """Return a, b or c; the first few."""
    names = list(dict.fromkeys(names))
    shown = [*names[:4], *(["others"] if len(names) > 4 else [])]
    return shown[0] if len(shown) == 1 else f"{', '.join(shown[:-1])} or {shown[-1]}"
