"""Draws parts and machines of a cell and measures them: truths, what was touched, and own reference values."""

from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from referee import machines
from referee.files import CERTIFICATE, SCATTER, SHIFT, STATED, TURN
from referee.kinematics import Geometry, pose
from referee.machines import Machine
from referee.parts import Surface
from referee.tasks import TASKS, Task, value

Array = NDArray[np.float64]
FRAME = pose(np.array(SHIFT), np.array(TURN))
NOISES = {
    "exact": {},
    "t3": {"dof": 3.0},
    "ar": {"ar": 0.95},
    "dust": {"outliers": 0.02},
    "digits": {"digits": 0.001},
    "fine_digits": {"digits": 0.0001},
}
MOVE = 0.005  # mm, departure of places, directions and sizes of features
PASS = 0.9  # share of E0 tests that a machine at its limit passes


@dataclass
class Measured:
    """One part on one machine: by characteristic the truth and the reference value, and the touched points."""

    truth: dict
    value: dict
    points: dict


def stream(seed: int, cell: str, part: int) -> np.random.Generator:
    """Random numbers of one part of one cell, the same however cells and parts are shared out."""
    return np.random.default_rng([seed, crc32(cell.encode()), part])


def table(seed: int, cell: str) -> Array:
    """A known error table: five nodes over the travel of each axis, about 1 um and 2 urad."""
    rng = stream(seed, cell, 2**31)
    sizes = np.tile([1e-3] * 3 + [2e-6] * 3, 3)
    return np.column_stack([np.linspace(0, 1, 5), rng.normal(size=(5, 18)) * sizes])


def tabled(rows: Array) -> Geometry:
    """The machine of a table, with straight lines between its nodes."""
    errors = {}
    for number, (axis, (low, high)) in enumerate(machines.TRAVEL.items()):
        block = rows[:, 1 + 6 * number : 7 + 6 * number]
        nodes = low + rows[:, 0] * (high - low)
        errors[axis] = lambda q, x=nodes, b=block: np.column_stack([np.interp(q, x, c) for c in b.T])
    return Geometry(errors, np.zeros(3), np.zeros(3))


def draw_machine(rng: np.random.Generator, name: str, known: Array) -> Machine:
    """A machine of a cell: `exact` and other noises (its law is stated), or `cert_` and a family of errors."""
    if not name.startswith("cert_"):
        s = STATED
        own = machines.process(rng, s["translation"], s["rotation"], s["square"], s["length"])
        return Machine(
            machines.added(tabled(known), own),
            np.zeros((2, 1)),
            scatter=SCATTER,
            qualify=False,
            **NOISES[name],
        )
    use = float(rng.choice([0.25, 0.6, 1.0]))
    # a touch scatters so that the largest range of three in 35 lengths keeps R0 in most tests (4.6 sd of a length);
    # the tip shows what P_Form leaves beside the range of 25 touches (4 sd)
    scatter = CERTIFICATE["r0"] / 4.6 / np.sqrt(2)
    lobe = machines.tip_lobes(rng, use * (CERTIFICATE["form"] - 4 * scatter))
    radius = use * rng.choice([-1, 1]) * CERTIFICATE["size"] / 3
    drawn = Machine(machines.geometry(rng, name[5:]), lobe, float(radius), use * scatter)
    limit = machines.at_limit(rng, drawn, CERTIFICATE["fixed"], CERTIFICATE["slope"], PASS)
    return replace(limit, geometry=limit.geometry.scaled(use))


def surfaces(rng: np.random.Generator, task: Task, family: str) -> dict:
    """The real surfaces of one part; `known_lobes`: three lobes of 2 um from valley to peak, of any phase."""
    made = {}
    for name, feature in task.features.items():
        surface = Surface(feature, rng, "perfect" if family == "known_lobes" else family, SCATTER, MOVE)
        if family == "known_lobes":
            phase = rng.uniform(0, 2 * np.pi)
            surface.form = lambda a, h, p=phase: 1e-3 * np.cos(3 * a + p) + 0 * h
        made[name] = surface
    return made


def nominal(task: Task) -> dict:
    """By feature nominal points and normals of the touches."""
    rng = np.random.default_rng(0)
    return {n: Surface(f, rng, "perfect", 0.0, 0.0).at(*task.places[n])[1:] for n, f in task.features.items()}


def measure(seed: int, cell: str, part: int, task: str, family: str, machine: str, known: Array) -> Measured:
    """Make one part, measure it once, and find its true values."""
    rng = stream(seed, cell, part)
    plan = TASKS[task]
    made = surfaces(rng, plan, family)
    drawn = draw_machine(rng, machine, known)
    points, ideal = {}, {}
    names = list(made)
    touched = [made[n].at(*plan.places[n]) for n in names]
    read = machines.touch(
        rng, drawn, np.concatenate([t[0] for t in touched]), np.concatenate([t[2] for t in touched]), FRAME
    )
    for name, block in zip(names, np.split(read, np.cumsum([len(t[0]) for t in touched])[:-1])):
        points[name] = block
        ideal[name] = made[name].dense()
    lines = plan.characteristics
    return Measured(
        {c.name: value(c, plan.features, ideal) for c in lines},
        {c.name: value(c, plan.features, points) for c in lines},
        points,
    )
