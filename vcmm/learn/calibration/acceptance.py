"""Predict the figures of an acceptance test with uncertainty from a machine file.

The test is simulated on sampled machines: every Input is sampled anew by its law, scatter per touch. value = mean of the figure over the
draws (the expected result of the test), u = its standard deviation, p_pass = share of draws within the limit.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import required
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import EVERY
from vcmm.core.laws import MultivariateSamples
from vcmm.core.machine import Machine
from vcmm.core.run import T0_DEG_C, Array, Run
from vcmm.learn.calibration import standards
from vcmm.learn.calibration.prior_knowledge import known_ranges
from vcmm.physics.structure.scatter import Scatter
from vcmm.task.certification.lines import (
    RAM,
    REPEATS,
    corners,
    face_diagonals,
    length_run,
    ram_lines,
    seven_lines,
    travels,
)
from vcmm.task.certification.machines import half_sphere
from vcmm.task.measuring.plan import probe_angles
from vcmm.task.response.influence import influences
from vcmm.task.response.volumetric import with_defaults

TRIALS = 1000
TESTS = ("230-2", "230-4", "230-6", "230-7", "10360-2")
RUNS = 5
FORM, SIZE = "P_Form_Sph_1x25", "P_Size_Sph_1x25"
Limit = Callable[[float], float]  # length mm -> mm
UNTOLD = {  # figures that may be nothing but rounding, and why
    **dict.fromkeys(("R", "R+", "R-", "R0", "asynchronous"), "the machine file states no repeatability"),
    "fundamental": "errors of the axis average line have no once-per-turn part",
}
LEAST_LIMIT = 1e-6  # um, urad: no machine is so good
VOLUME_TRIALS, VOLUME_NODES = 200, 4  # of the figures of the volume: trials, nodes along each axis


@dataclass(frozen=True)
class Figure:
    """One figure of a test, um (None: the machine file does not tell it); limit and p_pass where a limit was stated.

    Where the limit grows with the length: ratio (with u_ratio) is the largest |E| / MPE of all lengths, p_pass the probability that it is
    at most 1, at_mm the length where it is most often the largest, and limit_um the MPE there.
    """

    name: str
    value_um: float | None
    u_um: float | None
    limit_um: float | None = None
    p_pass: float | None = None
    ratio: float | None = None
    u_ratio: float | None = None
    at_mm: float | None = None


def predict_figures(
    machine: Machine,
    test: str,
    limits: Mapping[str, Limit] | None = None,
    seed: int = 0,
    trials: int = TRIALS,
) -> list[Figure]:
    """Predict the figures of a test ("230-2", "230-4", "230-6", "10360-2"; "230-7" is `predicted_spindle`). Raises UsageError for another one."""
    makers: Mapping[str, Callable[..., list[Figure]]] = {
        "230-2": _positioning, "230-4": _circles, "230-6": _diagonals, "10360-2": _lengths,
    }  # fmt: skip
    if test not in makers:
        raise UsageError(f'there is no test "{test}" here.{choose_from(test, TESTS)}')
    return makers[test](machine, limits or {}, np.random.default_rng(seed), trials)


def without_rounding(figures: Sequence[Figure]) -> tuple[list[Figure], list[str]]:
    """Return the figures without value and chance to pass where the machine file does not determine them; and sentences that say why."""
    out, why = [], dict[str, list[str]]()
    for row in figures:
        reason = UNTOLD.get(row.name.split(" ")[0])
        if reason is None or row.value_um is None or row.value_um > LEAST_LIMIT:
            out.append(row)
            continue
        why.setdefault(reason, []).append(row.name)
        out.append(replace(row, value_um=None, u_um=None, p_pass=None))
    return out, [f"{reason}: {', '.join(names)} cannot be predicted" for reason, names in why.items()]


def tip_errors(machine: Machine, run: Run, rng: np.random.Generator, trials: int) -> Array:
    """Return the tip errors (trials, n, 3) mm, actual - nominal, of sampled machines, scatter along nx ny nz included; workpiece axes."""
    run = machine.prepare(_run_with_tip(machine, with_defaults(machine, run)))
    total = np.broadcast_to(machine.indication_error(run), (trials, run.n, 3)).copy()
    for influence in influences(machine, run, machine.inputs):
        law, factor = influence.input.spread(influence.response.shape[2])
        shape = (trials, len(influence.copies), factor.shape[1])
        if isinstance(law, MultivariateSamples):
            raw = law.values[rng.integers(len(law.values), size=shape[:2])]
        else:
            raw = np.reshape(law.isf(rng.uniform(1e-12, 1.0, size=int(np.prod(shape)))), shape)
        moved = influence.response @ factor
        for copy in range(len(influence.copies)):
            rows = influence.codes == copy
            total[:, rows] += np.einsum("nik,tk->tni", moved[rows], raw[:, copy])
    return -total


def _run_with_tip(machine: Machine, run: Run) -> Run:
    """Return the run with columns and label that probe and stylus need: touched along nx ny nz with a stylus along its offset (down without one).

    Where effects name one stylus, the test is made with it; what else they need is that of a machine at rest at 20 degC.
    """
    reading = [e for e in machine.effects if e.link == "reading"]
    named = {str(getattr(e, "stylus", "")) for e in reading} - {"", EVERY}
    size = np.linalg.norm(run.offset, axis=1)
    direction = np.where(size[:, None] > 0, run.offset / np.maximum(size, 1e-12)[:, None], [[0.0, 0.0, -1.0]])
    columns = probe_angles(direction, size, run.normal) if reading and "nx" in run.columns else {}
    for name in {c for e in reading for c in required(e)} - set(columns) - set(run.columns):
        columns[name] = np.full(run.n, T0_DEG_C if name.startswith("temp_") else 0.0)
    run = run.with_columns(columns)
    return (
        replace(run, labels={**run.labels, "stylus": np.full(run.n, named.pop())}) if len(named) == 1 else run
    )


def summary(name: str, drawn: Array, limit: float | None = None) -> Figure:
    """Return a figure from its draws (trials,) in mm."""
    passed = None if limit is None else float((drawn <= limit).mean())
    return Figure(
        name,
        float(drawn.mean()) * 1e3,
        float(drawn.std()) * 1e3,
        None if limit is None else limit * 1e3,
        passed,
    )


def _middle(machine: Machine) -> dict[str, float]:
    return {a: (x.travel[0] + x.travel[1]) / 2 if a in "XYZ" else 0.0 for a, x in machine.axes.items()}


def _moving(
    machine: Machine, positions: Mapping[str, Array], senses: Mapping[str, Array], directions: Array
) -> Run:
    """Return rows at axis positions, the axes not named in their middle; directions (3,) or (n, 3): direction of measurement."""
    n = len(next(iter(positions.values())))
    at = {a: np.asarray(positions.get(a, np.full(n, q))) for a, q in _middle(machine).items()}
    columns = {f"sense_{a}": senses.get(a, np.zeros(n)) for a in machine.axes}
    direction = np.broadcast_to(directions, (n, 3))
    columns |= {f"n{c}": direction[:, i].copy() for i, c in enumerate("xyz")}
    return Run(at, np.zeros((n, 3)), columns)


def targets_of(travel: tuple[float, float]) -> Array:
    """Return five targets per metre, five or more, not evenly spaced (ISO 230-2:2014, 4.3.2: p + r), within the travel."""
    low, high = travel
    n = max(5, int(np.ceil(5 * (high - low) / 1000.0)))
    even = np.linspace(low, high, n)
    step = (high - low) / (n - 1)
    shift = 0.1 * step * np.sin(2.3 * np.arange(n))
    shift[[0, -1]] = 0.0
    return even + shift


def _both_ways(machine: Machine, start: Array, end: Array, senses: Mapping[str, float]) -> tuple[Run, int]:
    """Run along a line of axis positions from start to end (letters in order X Y Z), forward and back, RUNS times."""
    letters = [a for a in "XYZ" if a in machine.axes]
    length = float(np.linalg.norm(end - start))
    share = (targets_of((0.0, length)) / length)[:, None]
    line = start + share * (end - start)
    n = len(line)
    once = np.concatenate([line, line[::-1]])
    sense = np.concatenate([np.ones(n), -np.ones(n)])
    rows = np.tile(once, (RUNS, 1))
    ways = {a: np.tile(sense, RUNS) * s for a, s in senses.items()}
    direction = np.zeros(3)
    direction[["XYZ".index(a) for a in letters]] = (end - start) / length
    return _moving(machine, {a: rows[:, i] for i, a in enumerate(letters)}, ways, direction), n


def _split(values: Array, n: int) -> tuple[Array, Array]:
    """Split (trials, 2 n RUNS) in measuring order into up and down (trials, n, RUNS)."""
    shaped = values.reshape(len(values), RUNS, 2, n)
    return np.moveaxis(shaped[:, :, 0], 1, 2), np.moveaxis(shaped[:, :, 1, ::-1], 1, 2)


def _positioning(
    machine: Machine, limits: Mapping[str, Limit], rng: np.random.Generator, trials: int
) -> list[Figure]:
    out = []
    letters = [a for a in "XYZ" if a in machine.axes]
    middle = np.array([_middle(machine)[a] for a in letters])
    for i, axis in enumerate(letters):
        start, end = middle.copy(), middle.copy()
        start[i], end[i] = machine.axes[axis].travel
        run, n = _both_ways(machine, start, end, {axis: 1.0})
        errors = tip_errors(machine, run, rng, trials)[:, :, "XYZ".index(axis)]
        for name, drawn in standards.positioning(*_split(errors, n)).items():
            out.append(summary(f"{name} {axis}", drawn, _limit(limits, name, axis, float(end[i] - start[i]))))
    return out


def _limit(limits: Mapping[str, Limit], name: str, where: str, length: float) -> float | None:
    limit = limits.get(f"{name} {where}", limits.get(name))
    return None if limit is None else limit(length)


def _circles(
    machine: Machine, limits: Mapping[str, Limit], rng: np.random.Generator, trials: int
) -> list[Figure]:
    out = []
    angle = np.arange(0, 360, 5) * np.pi / 180
    centre = _middle(machine)
    for plane in ("XY", "YZ", "ZX"):
        if not set(plane) <= set(machine.axes):
            continue
        radius = 0.4 * min(float(np.ptp(machine.axes[a].travel)) for a in plane)
        i, j = ("XYZ".index(a) for a in plane)
        both = np.concatenate([angle, angle])
        turn = np.repeat([1.0, -1.0], len(angle))
        positions = {
            plane[0]: centre[plane[0]] + radius * np.cos(both),
            plane[1]: centre[plane[1]] + radius * np.sin(both),
        }
        senses = {plane[0]: np.sign(-turn * np.sin(both)), plane[1]: np.sign(turn * np.cos(both))}
        out_of = np.zeros((len(both), 3))
        out_of[:, i], out_of[:, j] = np.cos(both), np.sin(both)
        errors = tip_errors(machine, _moving(machine, positions, senses, out_of), rng, trials)
        radial = np.einsum("tni,ni->tn", errors, out_of)
        figures = standards.circular(angle, radial[:, : len(angle)], radial[:, len(angle) :])
        out += [summary(f"{n} {plane}", d, _limit(limits, n, plane, radius)) for n, d in figures.items()]
    return out


def _diagonals(
    machine: Machine, limits: Mapping[str, Limit], rng: np.random.Generator, trials: int
) -> list[Figure]:
    """Return the figures of body diagonals (Ed the largest E), then of face diagonals in the middle planes (Ef)."""
    out, largest = [], {"Ed": np.zeros(trials), "Ef": np.zeros(trials)}
    for name, start, end in [*corners(machine), *face_diagonals(machine)]:
        way = (end - start) / np.linalg.norm(end - start)
        run, n = _both_ways(machine, start, end, dict(zip("XYZ", np.sign(way))))
        errors = tip_errors(machine, run, rng, trials) @ way
        figures = standards.diagonal(*_split(errors, n))
        length = float(np.linalg.norm(end - start))
        out += [summary(f"{f} {name}", d, _limit(limits, f, name, length)) for f, d in figures.items()]
        which = "Ef" if "0" in name else "Ed"
        largest[which] = np.maximum(largest[which], figures["E"])
    return [*out, *(summary(n, d, _limit(limits, n, "", 0.0)) for n, d in largest.items())]


def _lengths(
    machine: Machine, limits: Mapping[str, Limit], rng: np.random.Generator, trials: int
) -> list[Figure]:
    """Return the figures of seven lines, five lengths each three times (E0, R0); two diagonals with an offset stylus (E150); 25 points on
    a sphere."""
    errors, length = _measured_lengths(machine, seven_lines(machine), rng, trials)
    figures = standards.lengths(errors)
    out = [_length_figure(limits, "E0", figures["E0"], np.abs(errors), length)]
    out.append(summary("R0", figures["R0"], _limit(limits, "R0", "", 0.0)))
    sides = [
        _measured_lengths(machine, ram_lines(machine), rng, trials, np.array([0.0, side, 0.0]))
        for side in (-RAM, RAM)
    ]
    ram, far = np.concatenate([e for e, _ in sides], axis=1), np.concatenate([n for _, n in sides])
    out.append(_length_figure(limits, "E150", np.abs(ram).max(axis=(1, 2)), np.abs(ram), far))
    form, size = sphere_figures(machine, rng, trials)
    out.append(summary(FORM, form, _limit(limits, FORM, "", 0.0)))
    return [*out, summary(SIZE, size, _limit(limits, SIZE, "", 0.0))]


def _measured_lengths(
    machine: Machine,
    lines: list[tuple[Array, Array]],
    rng: np.random.Generator,
    trials: int,
    offset: Array | None = None,
) -> tuple[Array, Array]:
    """Return (errors (trials, lengths, repeats) mm, indicated - true, lengths (lengths,) mm)."""
    run, length = length_run(machine, lines, offset, REPEATS)
    lengths = np.einsum("tni,ni->tn", -tip_errors(machine, run, rng, trials), run.normal)
    half = lengths.shape[1] // 2
    return (lengths[:, :half] + lengths[:, half:]).reshape(trials, -1, REPEATS), length[::REPEATS]


def sphere_figures(machine: Machine, rng: np.random.Generator, trials: int) -> tuple[Array, Array]:
    """Return the form and |size error| (trials,) mm of a sphere of 25 mm in the middle, touched at 25 points (ISO 10360-5:2020, 6.2)."""
    normals = half_sphere()
    middle = travels(machine).mean(axis=1)
    places = {a: middle[i] + 12.5 * normals[:, i] for i, a in enumerate("XYZ")}
    run = _moving(machine, places, {}, normals)
    radial = np.einsum("tni,ni->tn", -tip_errors(machine, run, rng, trials), normals)
    columns = np.column_stack([np.ones(len(normals)), normals])
    fitted = radial @ np.linalg.pinv(columns).T
    return np.ptp(radial - fitted @ columns.T, axis=1), np.abs(2.0 * fitted[:, 0])


def _length_figure(
    limits: Mapping[str, Limit], name: str, drawn: Array, errors: Array, length: Array
) -> Figure:
    """Return E0 or E150 with a limit that may grow with the length: passed where every length is within its own.

    errors (trials, lengths, repeats) mm.
    """
    if name not in limits:
        return summary(name, drawn)
    allowed = np.array([limits[name](float(v)) for v in length])
    return replace(
        against_limits(name, errors.max(axis=2), allowed, length),
        value_um=float(drawn.mean()) * 1e3, u_um=float(drawn.std()) * 1e3,
    )  # fmt: skip


def against_limits(name: str, errors: Array, allowed: Array, length: Array) -> Figure:
    """Return the figure of |E| (trials, lengths) mm against the limit (lengths,) mm of each length (lengths,) mm; value and u are left out.

    ISO 10360-2:2009, 7.1: every single error is compared with the MPE of its own length.
    """
    ratios = errors / allowed
    largest = ratios.max(axis=1)
    at = int(np.bincount(ratios.argmax(axis=1), minlength=len(length)).argmax())
    return Figure(
        name, None, None, float(allowed[at]) * 1e3, float((largest <= 1.0).mean()),
        float(largest.mean()), float(largest.std()), float(length[at]),
    )  # fmt: skip


def volume_figures(machine: Machine) -> list[Figure]:
    """Return the largest and mean tip error on a grid of the travels, as far as the tables reach, and the length errors of the body diagonals."""
    from vcmm.task.response.volumetric import grid

    letters = [a for a in "XYZ" if a in machine.axes]
    rng = np.random.default_rng(0)
    machine = _where_known(machine)
    still = without_scatter(machine)
    size = np.linalg.norm(
        tip_errors(still, _looked_at(grid(machine, VOLUME_NODES)), rng, VOLUME_TRIALS), axis=2
    )
    out = [summary("largest tip error", size.max(axis=1)), summary("mean tip error", size.mean(axis=1))]
    if len(letters) < 3:
        return out
    for name, start, end in corners(machine):
        way = (end - start) / np.linalg.norm(end - start)
        run = _moving(machine, {a: np.array([start[i], end[i]]) for i, a in enumerate("XYZ")}, {}, way)
        error = tip_errors(still, run, rng, VOLUME_TRIALS)
        out.append(summary(f"body diagonal {name}", (error[:, 1] - error[:, 0]) @ way))
    return out


def _where_known(machine: Machine) -> Machine:
    """Return the machine with travels no longer than the error tables."""
    ranges = known_ranges(machine)
    axes = {
        a: replace(x, travel=(max(x.travel[0], ranges[a][0]), min(x.travel[1], ranges[a][1])))
        if a in ranges
        else x
        for a, x in machine.axes.items()
    }
    return replace(machine, axes=axes)


def _looked_at(run: Run) -> Run:
    """Return the run with a normal, which effects of a probe need; here nothing is touched."""
    return run.with_columns({"nx": np.zeros(run.n), "ny": np.zeros(run.n), "nz": np.ones(run.n)})


def without_scatter(machine: Machine) -> Machine:
    return replace(machine, inputs=tuple(i for i in machine.inputs if i.effect != Scatter.name))
