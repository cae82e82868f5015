"""Machines of known families, at or below the limit of their acceptance test (ISO 10360-2:2009, E0).

A machine is 18 curves over its axes, three squarenesses and play of three axes. A family says what the curves look
like; a machine is scaled until it passes a simulated E0 test as often as stated, then it uses a share of that.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from referee.kinematics import Geometry, tip_error

Array = NDArray[np.float64]
TRAVEL = {"X": (0.0, 600.0), "Y": (0.0, 500.0), "Z": (-400.0, 0.0)}
OFFSET = np.array([0.0, 0.0, -120.0])
FAMILIES = ("smooth", "short", "periodic", "roll", "hysteresis", "kinks")
ROLL = {"X": 3, "Y": 4, "Z": 5}  # column of the turn about the axis' own direction


@dataclass
class Machine:
    """A measuring machine: geometry, form and size of its tip, scatter of a touch.

    Attributes
    ----------
    geometry : Geometry
    lobe : array, shape (2, k)
        Heights (mm) and phases of the tip's lobes 2, 3, ... over the angle of the touch.
    radius : float
        Error of the tip's radius, mm: found too small by so much in every touch.
    scatter : float
        Scale of the scatter of one touch, mm.
    dof : float
        Degrees of freedom of a t-law; infinite is normal.
    ar : float
        Correlation of the scatter from one touch to the next.
    outliers : float
        Share of touches with dust below the tip.
    digits : float
        Last digit of what is written, mm; 0 for all digits.
    qualify : bool
        The tip was qualified on this machine, and what its geometry did there is in the tip's radius; else the radius
        is exact.
    """

    geometry: Geometry
    lobe: Array
    radius: float = 0.0
    scatter: float = 0.0003
    dof: float = np.inf
    ar: float = 0.0
    outliers: float = 0.0
    digits: float = 0.0
    qualify: bool = True


def _curve(rng: np.random.Generator, kind: str, low: float, high: float) -> Callable[[Array], Array]:
    """One random function of height about 1 over an axis."""
    if kind == "kinks":
        nodes = np.sort(rng.uniform(low, high, 5))
        nodes = np.concatenate([[low], nodes, [high]])
        heights = rng.normal(size=7)
        return lambda q: np.interp(q, nodes, heights)
    waves = {"smooth": (300, 1500), "roll": (300, 1500), "hysteresis": (300, 1500), "short": (20, 60)}
    lengths = rng.uniform(*waves.get(kind, (2, 10)), 3)
    phases = rng.uniform(0, 2 * np.pi, 3)
    heights = rng.normal(size=3) / np.sqrt(1.5)
    return lambda q: np.sin(2 * np.pi * np.asarray(q)[:, None] / lengths + phases) @ heights


def geometry(rng: np.random.Generator, family: str) -> Geometry:
    """A drawn machine of a family, of no particular size (translations about 1 um, rotations about 2 urad)."""
    errors = {}
    for axis, (low, high) in TRAVEL.items():
        sizes = np.concatenate([rng.lognormal(0, 0.5, 3) * 1e-3, rng.lognormal(0, 0.5, 3) * 2e-6])
        if family == "roll":
            sizes *= 0.1
            sizes[ROLL[axis]] = 1e-5
        if family in ("short", "periodic"):
            sizes[3:] *= 0.3
        curves = [_curve(rng, family, low, high) for _ in range(6)]
        errors[axis] = lambda q, c=curves, s=sizes: np.column_stack([f(q) for f in c]) * s
    squareness = rng.normal(size=3) * (2e-7 if family == "roll" else 2e-6)
    gap = np.abs(rng.normal(size=3)) * 2e-3 if family == "hysteresis" else np.zeros(3)
    return Geometry(errors, squareness, gap)


@cache
def _root(low: float, high: float, length: float) -> tuple[Array, Array]:
    """Nodes 10 mm apart and a square root of their covariance."""
    nodes = np.arange(low, high + 5, 10.0)
    covariance = np.exp(-0.5 * ((nodes[:, None] - nodes) / length) ** 2)
    values, vectors = np.linalg.eigh(covariance)
    return nodes, vectors * np.sqrt(np.maximum(values, 0))


def process(
    rng: np.random.Generator, translation: float, rotation: float, square: float, length: float
) -> Geometry:
    """A machine from the law that a machine file states: Gaussian processes over the axes (mm, rad, rad, mm).

    Every component is independent with covariance u^2 exp(-d^2 / (2 l^2)); the exact law on nodes 10 mm apart, with
    straight lines between them.
    """
    errors = {}
    for axis, (low, high) in TRAVEL.items():
        nodes, root = _root(low, high, length)
        table = (root @ rng.normal(size=(len(nodes), 6))) * np.array([translation] * 3 + [rotation] * 3)
        errors[axis] = lambda q, x=nodes, t=table: np.column_stack([np.interp(q, x, c) for c in t.T])
    return Geometry(errors, square * rng.normal(size=3), np.zeros(3))


def added(first: Geometry, second: Geometry) -> Geometry:
    """Both machines' errors at once."""
    errors = {a: (lambda q, f=first.errors[a], g=second.errors[a]: f(q) + g(q)) for a in TRAVEL}
    return Geometry(errors, first.squareness + second.squareness, first.gap + second.gap)


def e0_lines() -> list[tuple[Array, Array]]:
    """Both ends of the longest length on seven lines: four space diagonals and one along each axis."""
    low, high = np.array([v[0] for v in TRAVEL.values()]), np.array([v[1] for v in TRAVEL.values()])
    margin = 0.05 * (high - low)
    low, high = low + margin, high - margin
    middle = (low + high) / 2
    lines = []
    for sx, sy in ((0, 0), (0, 1), (1, 0), (1, 1)):
        start = np.array([(low, high)[sx][0], (low, high)[sy][1], low[2]])
        lines.append((start, low + high - start))
    for axis in range(3):
        start, end = middle.copy(), middle.copy()
        start[axis], end[axis] = low[axis], high[axis]
        lines.append((start, end))
    return lines


def e0_errors(machine: Geometry) -> tuple[Array, Array, Array]:
    """Errors of indication (mm), lengths (mm) and outward normals of both ends of 35 bidirectional lengths, five on each line, without scatter."""
    places, directions, lengths = [], [], []
    for start, end in e0_lines():
        total = np.linalg.norm(end - start)
        unit = (end - start) / total
        for share in (0.2, 0.4, 0.6, 0.8, 1.0):
            places += [start, start + unit * share * total]
            directions += [-unit, unit]  # outward normals of both faces
            lengths.append(share * total)
    normals = np.array(directions)
    error = -tip_error(machine, np.array(places), OFFSET, -np.sign(np.round(normals, 9)))
    along = np.einsum("ni,ni->n", error, normals)
    return along.reshape(-1, 2).sum(axis=1), np.array(lengths), normals


def qualified(machine: Geometry) -> float:
    """What the geometry alone looks like as an error of radius on a reference sphere (25 mm, half a sphere), mm.

    A probe is qualified before it measures; this constant is taken off every touch, as the fitted centre is.
    """
    polar, around = np.meshgrid(np.deg2rad([22.5, 45, 67.5, 90]), np.arange(6) * np.pi / 3)
    normals = np.column_stack(
        [
            np.sin(polar.ravel()) * np.cos(around.ravel()),
            np.sin(polar.ravel()) * np.sin(around.ravel()),
            np.cos(polar.ravel()),
        ]
    )
    centres = np.array([100.0, 100.0, -250.0]) + 12.5 * normals
    error = -tip_error(machine, centres - OFFSET, OFFSET, -np.sign(np.round(normals, 9)))
    design = np.column_stack([np.ones(len(normals)), normals])
    return float(np.linalg.lstsq(design, np.einsum("ni,ni->n", error, normals), rcond=None)[0][0])


def lobing(lobe: Array, normals: Array) -> Array:
    """Reading of the tip's form: lobes over the angle about z, times the lateral share of the normal."""
    heights, phases = lobe
    angle = np.arctan2(normals[:, 1], normals[:, 0])
    waves = np.cos(angle[:, None] * np.arange(2, 2 + len(heights)) + phases)
    return np.hypot(normals[:, 0], normals[:, 1]) * (waves @ heights)


def at_limit(rng: np.random.Generator, machine: Machine, fixed: float, slope: float, share: float) -> Machine:
    """Scale a machine's geometry until it passes the E0 test as often as `share` says, tip and scatter included.

    Parameters
    ----------
    machine : Machine
        Its tip and scatter stay as they are.
    fixed, slope : float
        The limit is fixed + slope * length, mm. Each of 35 lengths is measured three times.
    """
    error, length, normals = e0_errors(machine.geometry)
    limit = fixed + slope * length
    form = lobing(machine.lobe, normals).reshape(-1, 2).sum(axis=1) + 2 * machine.radius
    noise = form + machine.scatter * np.sqrt(2) * rng.normal(size=(200, 3, len(length)))
    error = error - 2 * qualified(machine.geometry)
    low, high = 0.0, 50.0
    for _ in range(40):
        middle = (low + high) / 2
        passed = np.mean(np.all(np.abs(middle * error + noise) <= limit, axis=(1, 2)))
        low, high = (middle, high) if passed >= share else (low, middle)
    return replace(machine, geometry=machine.geometry.scaled(low))


def tip_lobes(rng: np.random.Generator, peak_to_valley: float) -> Array:
    """Heights and phases of lobes 2 to 5 with the given height from valley to peak (mm)."""
    heights, phases = rng.normal(size=4), rng.uniform(0, 2 * np.pi, 4)
    angle = np.linspace(0, 2 * np.pi, 360)
    form = np.cos(angle[:, None] * np.arange(2, 6) + phases) @ heights
    return np.array([heights * peak_to_valley / np.ptp(form), phases])


def touch(
    rng: np.random.Generator, machine: Machine, points: Array, normals: Array, frame: tuple[Array, Array]
) -> Array:
    """What a machine indicates of surface points, compensated for the tip, in the drawing frame.

    Parameters
    ----------
    points, normals : array, shape (n, 3)
        True surface points and outward normals, drawing frame.
    frame : tuple
        Turn matrix and shift of the part in the machine.
    """
    matrix, shift = frame
    outward = normals @ matrix.T
    centres = points @ matrix.T + shift + 2.0 * outward
    sense = -np.sign(np.round(outward, 9))
    error = -tip_error(machine.geometry, centres - OFFSET, OFFSET, sense) @ matrix
    form = lobing(machine.lobe, outward)
    if machine.qualify:
        form = form - qualified(machine.geometry)
    count = len(points)
    noise = rng.normal(size=count) if np.isinf(machine.dof) else rng.standard_t(machine.dof, count)
    if machine.ar:
        for i in range(1, count):
            noise[i] = machine.ar * noise[i - 1] + np.sqrt(1 - machine.ar**2) * noise[i]
    noise = machine.scatter * noise
    if machine.outliers:
        dirty = rng.random(count) < machine.outliers
        noise = noise + dirty * rng.uniform(15, 60, count) * machine.scatter
    read = points + error + (form + noise + machine.radius)[:, None] * normals
    return np.round(read / machine.digits) * machine.digits if machine.digits else read
