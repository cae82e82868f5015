"""Laser and level on the mill, and the two models that are made of what they read, as the paper makes them.

Every component is read forward and backward by an optic of its own (`survey.toml` of the scenario: where each reflector stood);
the tables are the means of both directions, counted from the first target, straightness less its line. Then

    conventional      the readings as they are, arms of the rotations from the frames of the axes (a product of transforms)
    Abbe-consistent   d error of the tip = d reading + (rotation x (tip - reflector of d))_d, the paper's equations 8 to 10:
                      the arms of each reading begin at the reflector that took it

Squareness is found with either model from the same square, and the lost motion of an axis is half the difference of the directions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm import Array, Effect, Machine, Recording, instruments, kinematics
from vcmm import effects as fx
from vcmm.core.history import row_history
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import Observer

SECOND = "EYZ at 300 mm"  # straightness of Z once more, beside the first line in X
PAIRS = ("A0Z", "B0Z", "C0Y")
Planned = Sequence[tuple[str, tuple[Recording, ...], float, instruments.InstrumentCertificate]]


@dataclass(frozen=True, eq=False)
class ReadComponent:
    """One component error as it was read: nodes (k,) mm; value (k,): mean of both directions, actual - commanded of the axis, mm or rad;
    lost (k,): up - down of the reading, which is the lost motion.

    reflector (3,) mm, in the moving frame of the axis.
    """

    component: str
    nodes: Array
    value: Array
    lost: Array
    reflector: Array


@dataclass(frozen=True, eq=False)
class MillSurvey:
    """What was read: lines along one axis, and the squares."""

    components: Mapping[str, ReadComponent]
    squares: tuple[Recording, ...]


def read(setups: Planned, bare: Machine, truth: Machine, rng: np.random.Generator) -> list[Recording]:
    """What the instruments read on the true machine, as `vcmm calibrate --simulate` writes it."""
    out = []
    for _, recordings, _, certificate in setups:
        out += [
            instruments.simulate_reading(with_senses(one, bare), truth, rng, certificate)
            for one in recordings
        ]
    return out


def with_senses(recording: Recording, machine: Machine) -> Recording:
    """The recording with the direction from which each row was reached."""
    run = recording.run
    fresh = np.zeros(run.n, dtype=bool)
    fresh[0] = True
    columns = row_history(run, list(machine.axes), fresh, positioned=True)
    return replace(recording, run=run.with_columns(columns))


def surveyed(recordings: Sequence[Recording], machine: Machine) -> MillSurvey:
    """Tables of the component errors from lines along X, Y or Z, named by the set-up: "EXX"; the rest are squares.

    A second line, "EYZ at 300 mm", gives the roll that no level sees: difference of both over the distance of their reflectors.
    """
    lines = [component_of(r, machine) for r in recordings if "feature" not in r.run.labels]
    squares = tuple(r for r in recordings if "feature" in r.run.labels)
    found = {c.component: c for c in lines}
    second = found.pop(SECOND)
    first = found["EYZ"]
    roll = (second.value - first.value) / (second.reflector - first.reflector)[0]
    found["ECZ"] = replace(first, component="ECZ", value=roll)
    return MillSurvey(found, squares)


def component_of(recording: Recording, machine: Machine) -> ReadComponent:
    """One table. A table's own motion shows in the reading as it is, a tool's the other way (indicated - true)."""
    name, axis = recording.name, recording.name[2]
    sign = 1.0 if axis in machine.chain.work else -1.0
    q, sense = recording.run.q(axis), recording.run.column(f"sense_{axis}")
    nodes = np.unique(np.round(q, 6))
    up, down = (
        np.array([recording.value[(np.abs(q - n) < 1e-5) & (sense * way >= 0)].mean() for n in nodes])
        for way in (1, -1)
    )
    mean = sign * (up + down) / 2
    if name[1] in "XYZ" and name[1] != axis:
        mean = mean - np.polyval(np.polyfit(nodes, mean, 1), nodes)
    frames, tool_end, _ = kinematics.link_frames(machine.chain, machine.axes, recording.run)
    place = frames[axis].after.undo(tool_end.apply(recording.run.offset))[0]
    return ReadComponent(name, nodes, mean - mean[0], up - down, place)


def conventional_model(bare: Machine, survey: MillSurvey) -> Machine:
    """The readings as they are, arms from the frames of the axes."""
    axes = {a: replace(axis, measured_at=None) for a, axis in bare.axes.items()}
    tables = {n: c.value for n, c in survey.components.items()}
    return _finished(replace(bare, axes=axes), survey, tables)


def consistent_model(bare: Machine, survey: MillSurvey) -> Machine:
    """Arms from the reflector of each reading: all translations of an axis are brought to where its positioning was read.

    A reading at r is T(m) + rotation x (r - m), so T(m) is the reading less that; from m on the machine carries the arms.
    """
    c = survey.components
    tables, axes = {}, dict(bare.axes)
    for axis in bare.axes:
        at = c[f"E{axis}{axis}"].reflector
        axes[axis] = replace(axes[axis], measured_at=tuple(at.tolist()))
        turn = np.stack([c[f"E{d}{axis}"].value for d in "ABC"], axis=1)
        for i, d in enumerate("XYZ"):
            one = c[f"E{d}{axis}"]
            tables[one.component] = one.value - np.cross(turn, one.reflector - at)[:, i]
        tables |= {f"E{d}{axis}": c[f"E{d}{axis}"].value for d in "ABC"}
    return _finished(replace(bare, axes=axes), survey, tables)


def _finished(machine: Machine, survey: MillSurvey, tables: Mapping[str, Array]) -> Machine:
    """The machine with tables, lost motion, and the squareness that the squares then show."""
    nodes = {n: c.nodes for n, c in survey.components.items()}
    effects: list[Effect] = [fx.ComponentTable(n, (n[2],), (nodes[n],), v) for n, v in tables.items()]
    effects += [fx.Backlash(a, float(survey.components[f"E{a}{a}"].lost.mean())) for a in machine.axes]
    known = replace(machine, effects=tuple(effects), inputs=())
    angles = square_angles(survey.squares, known)
    return known.with_effect(*(fx.Squareness(p, v) for p, v in angles.items()))


def square_angles(squares: Sequence[Recording], known: Machine) -> dict[str, float]:
    """Pair -> rad, least squares: what the squares read beyond the tables of the model, each square lying anywhere."""
    rows, rests, placings = [], [], []
    for one in squares:
        observer = Observer(one, known)
        rows.append(np.hstack([observer.of_parameter(fx.Squareness(p), "angle") for p in PAIRS]))
        rests.append(one.value - observer.baseline())
        placings.append(nuisance_columns(one, known)[0])
    size = np.cumsum([0, *(p.shape[1] for p in placings)])
    columns = np.zeros((sum(len(r) for r in rests), size[-1]))
    first = 0
    for number, placing in enumerate(placings):
        columns[first : first + len(placing), size[number] : size[number + 1]] = placing
        first += len(placing)
    found = np.linalg.lstsq(np.hstack([np.concatenate(rows), columns]), np.concatenate(rests), rcond=None)[0]
    return dict(zip(PAIRS, found[: len(PAIRS)].tolist()))
