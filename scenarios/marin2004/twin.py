"""Twin of D. Marin, Error prediction and compensation for CNC machine tools (SISOM 2004, Bucharest).

The chain "w X' Y' b Z t" multiplied out as in the paper beside vcmm's exact and first-order engines; geometric and thermal
parameters, the latter by multiple regression on temperature sensors; an NC program read, its cutter positions corrected by
the predicted error, written again, and cut virtually before and after warm-up (the scheme of the paper's figure 3).

The paper prints formulas and no numbers: machine, day, sensors, part and program are drawn here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from vcmm import Array, Axis, CutScenario, Machine, Run, machining

from ..shared.error_tables import shape, table_text
from .chain import (
    LETTERS,
    carriages,
    expanded,
    in_workpiece_axes,
    orientation,
    product,
    relation,
    volumetric_error,
)
from .day import (
    BESIDE,
    Day,
    NetworkModel,
    Regression,
    day,
    network,
    regression,
)
from .learnt import (
    METHODS,
    LearntGeometry,
    learnt_geometry,
    readings,
    smoothed,
    with_tables,
)
from .rewritten import (
    RewrittenProgram,
    along_the_axes,
    by_table,
    departures,
    held_between,
    learnt_effects,
    looked_at,
    other_programs,
    rewritten,
    sensor_log,
    steepest,
    true_effects,
    true_log,
)

TRAVEL = {"X": (0.0, 800.0), "Y": (0.0, 500.0), "Z": (-500.0, 0.0)}
LINEAR, CROSS, TURN, SQUARE = 4e-3, 2.5e-3, 10e-6, 12e-6  # mm, rad: scales of the drawn tables
LEARNED, VALIDATED = (
    (1, 2),
    3,
)  # seeds of the days on which the regression is made, and of the day that it must predict
LAGS = (0, 5)  # minutes: the regression sees the sensors of now and of before
CUT_MINUTES = 6.0  # the program, about
HALF, DEEP, RADIUS, STEP = (
    (120.0, 80.0),
    12.0,
    16.0,
    10.0,
)  # mm: half sides, depth of the contour, cutter, longest line
PLAIN, GEOMETRY, START, UPDATED = "as programmed", "geometry", "state at the start", "updated meanwhile"
MODELS = (PLAIN, GEOMETRY, START, UPDATED)
TABLE, AXES = "full table", "table of the axes"  # of the control, the paper's second route
EVERY = 2.0  # minutes between two tables
Progress = Callable[[str, float], None]
Model = Callable[[list[Day], tuple[int, ...]], Regression | NetworkModel]


@dataclass(frozen=True)
class Agreement:
    """Largest difference of one tip coordinate over the volume, nm."""

    what: str
    against: str
    nanometres: float


@dataclass(frozen=True)
class ParameterFit:
    """One thermal parameter: its range over the validation day, and what the regression leaves (rms, largest)."""

    parameter: int
    span: float
    rms: float
    largest: float


@dataclass(frozen=True, eq=False)
class PartCut:
    """Departures (um) by feature of one cut: state of the machine, model with which the program was rewritten, or table of the control."""

    state: str
    model: str
    departure: Mapping[str, Array]
    predicted: Mapping[str, Array] | None  # by the model, of the program before it was rewritten


@dataclass(frozen=True)
class Remainder:
    """rms that the regression leaves of every parameter on the unseen day, in UNITS, under one condition."""

    condition: str
    rms: tuple[float, ...]


@dataclass(frozen=True, eq=False)
class VolumeErrors:
    """Equation 26 over the middle plane in Z: x, y (9,) mm, error (9, 9) um, rows of y. Over the volume: mean, largest um.

    turned: largest rotation of the workpiece against the tool, urad, eq. 20; moved: largest difference of its translation from
    the correction vector of eq. 22, nm.
    """

    x: Array
    y: Array
    error: Array
    mean: float
    largest: float
    turned: float
    moved: float


@dataclass(frozen=True, eq=False)
class MarinTwin:
    largest_um: float  # tip error over the volume
    agreements: tuple[Agreement, ...]
    fits: tuple[ParameterFit, ...]
    remainders: tuple[Remainder, ...]
    cuts: tuple[PartCut, ...]
    today: Day
    model: Regression
    views: tuple[machining.CutNet, ...]
    learnt: tuple[LearntGeometry, ...]
    volume: VolumeErrors
    warm: int  # minute at which the warm cut begins
    programs: tuple[RewrittenProgram, ...]


def draw_tables(seed: int) -> dict[str, Array]:
    """Component -> (11,) mm or rad over the travel of each axis."""
    rng = np.random.default_rng([seed, 20040520])
    out = {}
    for axis in "XYZ":
        for d in "XYZ":
            out[f"E{d}{axis}"] = shape(rng) * (LINEAR if d == axis else CROSS)
        for d in "ABC":
            out[f"E{d}{axis}"] = shape(rng) * TURN
    return out


def errors_csv(seed: int = 1) -> str:
    """The error table of the scenario."""
    axes = {a: Axis(a, travel) for a, travel in TRAVEL.items()}
    return table_text(
        draw_tables(seed),
        axes,
        f"drawn by us, seed {seed}: mm and rad over the axis position in mm; the carriages' own motions",
    )


def path() -> list[Array]:
    """Cutter positions (n, 3) in work coordinates, tip: face milling in rows, then the contour; lines of STEP mm at most."""
    x, y = HALF[0] + RADIUS + 10, HALF[1]
    rows = np.linspace(-y, y, 8)
    face = [
        (sign * x, row, 0.0) for i, row in enumerate(rows) for sign in ((-1, 1) if i % 2 == 0 else (1, -1))
    ]
    a, b = HALF[0] + RADIUS, HALF[1] + RADIUS
    contour = [(-a, -b - 30, -DEEP), (-a, b, -DEEP), (a, b, -DEEP), (a, -b, -DEEP), (-a - 30, -b, -DEEP)]
    return [_divided(np.array(face)), _divided(np.array(contour))]


def _divided(corners: Array) -> Array:
    out = [corners[:1]]
    for start, end in pairwise(corners):
        share = np.linspace(0.0, 1.0, int(np.ceil(np.linalg.norm(end - start) / STEP)) + 1)[1:]
        out.append(start + share[:, None] * (end - start))
    return np.concatenate(out)


def program(parts: list[Array] | None = None) -> str:
    """The NC program (Fanuc dialect) through given cutter positions, 0.1 um."""
    lines = [
        "%",
        "O2004 (FACE AND CONTOUR)",
        "G21 G17 G40 G49 G80 G90 G94",
        "T1 M6",
        "G54 G0 S2000 M3",
        "G43 H1 Z50.",
    ]
    for points in parts or path():
        x, y, z = points[0]
        lines += [f"G0 X{x:.4f} Y{y:.4f}", f"G0 Z{z:.4f}"]
        lines += [f"G1 X{x:.4f} Y{y:.4f} Z{z:.4f} F800" for x, y, z in points[1:]]
        lines.append("G0 Z50.")
    return "\n".join([*lines, "M5", "G91 G28 Z0", "M30", "%"]) + "\n"


def agreements(machine: Machine, tool: Array) -> tuple[float, tuple[Agreement, ...]]:
    """(largest tip error, um; how far the paper's product, its expansion and vcmm's engines are apart) on 7 x 7 x 7 places."""
    run = places(machine, tool)
    c = carriages(machine, run)
    correction, table = product(c)
    exact, first = machine.tip_error(run, exact=True), machine.tip_error(run)
    pairs = (
        ("equations 23 to 25, derived again", "matrix product (22)", expanded(c), correction),
        ("matrix product, reference axes", "vcmm first order", correction, first),
        ("matrix product, reference axes", "vcmm exact", correction, exact),
        ("matrix product, workpiece axes", "vcmm exact", in_workpiece_axes(correction, table), exact),
        ("the same with true rotations", "vcmm exact", in_workpiece_axes(*product(c, exact=True)), exact),
    )
    found = tuple(Agreement(a, b, float(np.abs(one - other).max() * 1e6)) for a, b, one, other in pairs)
    return float(np.linalg.norm(exact, axis=1).max() * 1e3), found


def places(machine: Machine, tool: Array, nodes: tuple[int, int, int] = (7, 7, 7)) -> Run:
    """The tool's axis positions on a grid of the travels; a single node is the middle."""
    ends = [machine.axes[a].travel for a in "XYZ"]
    lines = [np.linspace(*e, n) if n > 1 else np.array([sum(e) / 2]) for e, n in zip(ends, nodes)]
    mesh = np.meshgrid(*lines, indexing="ij")
    return Run({a: m.ravel() for a, m in zip("XYZ", mesh)}, np.tile(tool, (mesh[0].size, 1)))


def volume_errors(machine: Machine, tool: Array) -> VolumeErrors:
    """Equations 20 and 26 over the volume, and the map of a plane."""
    c = carriages(machine, places(machine, tool))
    whole, related = product(c)[0], relation(c)
    plane = places(machine, tool, (9, 9, 1))
    map_ = volumetric_error(product(carriages(machine, plane))[0]).reshape(9, 9).T
    size = volumetric_error(whole)
    return VolumeErrors(
        x=np.unique(plane.q("X")),
        y=np.unique(plane.q("Y")),
        error=1e3 * map_,
        mean=1e3 * float(size.mean()),
        largest=1e3 * float(size.max()),
        turned=1e6 * float(np.abs(orientation(related)).max()),
        moved=1e6 * float(np.abs(related[:, :3, 3] + whole).max()),
    )


def remainders() -> tuple[Remainder, ...]:
    """The same days with one cause taken away, with what a reading of some minutes ago tells, and by a network."""
    drawn: tuple[tuple[str, dict[str, float], Model, tuple[int, ...]], ...] = (
        ("as drawn", {}, regression, (0,)),
        ("structure without the quadratic share", {"bent": 0.0}, regression, (0,)),
        (f"sensors without their lag of {BESIDE:g} min", {"beside": 0.0}, regression, (0,)),
        ("as drawn, readings of 5 min before beside those of now", {}, regression, (0, 5)),
        ("as drawn, network", {}, network, (0,)),
        ("as drawn, network, readings of 5 min before too", {}, network, (0, 5)),
    )
    out = []
    for words, world, learn, lags in drawn:
        model = learn([day(seed, **world) for seed in LEARNED], lags)
        out.append(Remainder(words, tuple(f.rms for f in fits(model, day(VALIDATED, **world)))))
    return tuple(out)


def fits(model: Regression | NetworkModel, today: Day) -> tuple[ParameterFit, ...]:
    """What the regression leaves on a day that it has not seen."""
    left = model.over(today) - today.parameters
    span = np.ptp(today.parameters, axis=0)
    return tuple(
        ParameterFit(
            i, float(span[i]), float(np.sqrt(np.mean(left[:, i] ** 2))), float(np.abs(left[:, i]).max())
        )
        for i in range(left.shape[1])
    )


def run(scenario: CutScenario, progress: Progress | None = None) -> MarinTwin:
    """Agreement of the engines, regression over a drawn day, and the part cut cold and warm, before and after rewriting."""
    report = progress or (lambda text, share: None)
    report("matrix products", 0.0)
    geometry = kept(scenario.machine)
    tool = -np.array(scenario.setup.tools[1].offset)
    largest, found = agreements(geometry, tool)
    report("drawn days", 0.1)
    today, model = day(VALIDATED), regression([day(seed) for seed in LEARNED])
    early = regression([day(seed) for seed in LEARNED], LAGS)
    report("programs", 0.2)
    cuts, views, warm, programs = rewritten_cuts(scenario, geometry, today, early)
    report("geometry learnt", 0.7)
    return MarinTwin(
        largest_um=largest,
        agreements=found,
        fits=fits(model, today),
        remainders=remainders(),
        cuts=tuple(cuts),
        today=today,
        model=model,
        views=views,
        learnt=learnt_geometry(geometry, places(geometry, tool)),
        volume=volume_errors(geometry, tool),
        warm=warm,
        programs=tuple(programs),
    )


def kept(machine: Machine) -> Machine:
    """The machine with the errors that the paper's chain has."""
    effects = tuple(e for e in machine.effects if e.link in LETTERS and e.place in ("motion", "travel"))
    return replace(machine, effects=effects)


def rewritten_cuts(
    scenario: CutScenario, geometry: Machine, today: Day, model: Regression
) -> tuple[list[PartCut], tuple[machining.CutNet, ...], int, list[RewrittenProgram]]:
    """The NC file cut cold and while the machine warms, before and after rewriting; the minute of the warm cut; programs of others.

    The geometry that corrects is learnt from noisy readings by the network, the thermal parameters by the regression.
    """
    truth = geometry.with_effect(*true_effects())
    known = learnt_machine(geometry)
    hot = known.with_effect(*learnt_effects(model))
    file, setup, warm = scenario.program, scenario.setup, steepest(today, CUT_MINUTES)
    first = looked_at(replace(scenario, machine=truth), true_log(today, warm))
    said, held = (sensor_log(today, warm, model.lags, held) for held in (False, True))
    texts = {
        GEOMETRY: rewritten(file, setup, known, None).data,
        START: rewritten(file, setup, hot, held).data,
        UPDATED: rewritten(file, setup, hot, said).data,
    }
    views = {PLAIN: first}
    for name, text in texts.items():
        views[name] = looked_at(replace(scenario, machine=truth), true_log(today, warm), text)
    out = []
    for minute, models in ((0, (PLAIN, GEOMETRY)), (warm, MODELS)):
        real = (truth, true_log(today, minute))
        sensed = (hot, sensor_log(today, minute, model.lags))
        guessed = {GEOMETRY: departures(first, known, real[1]), UPDATED: departures(first, *sensed)}
        out += [
            PartCut(f"minute {minute}", name, departures(views[name], *real), guessed.get(name))
            for name in models
        ]
        if minute:
            stairs = held_between(sensed[1], EVERY)
            for name, table in ((TABLE, hot), (AXES, along_the_axes(hot))):
                out.append(PartCut(f"minute {minute}", name, by_table(first, real, (table, stairs)), None))
    return out, first, warm, other_programs(hot, said)


def learnt_machine(geometry: Machine) -> Machine:
    """The geometry as one set of noisy readings and the network give it; squareness as it is."""
    rng = np.random.default_rng([0, 20040522])
    return with_tables(geometry, smoothed(geometry, readings(geometry, rng), METHODS[2], rng))


def figures(result: MarinTwin) -> dict[str, object]:
    """Plain numbers for JSON."""
    return {
        "largest_tip_error_um": result.largest_um,
        "agreements": [vars(a) for a in result.agreements],
        "regression": [vars(f) for f in result.fits],
        "remainders": [vars(r) for r in result.remainders],
        "learnt_geometry": [vars(one) for one in result.learnt],
        "programs": [vars(p) for p in result.programs],
        "volume": {"mean_um": result.volume.mean, "largest_um": result.volume.largest, "turned_urad": result.volume.turned},
        "cuts": [
            {"state": c.state, "model": c.model, "feature": name, "mean_um": float(v.mean()), "largest_um": float(np.abs(v).max()),
             "rms_um": float(np.sqrt(np.mean(v**2)))}
            for c in result.cuts for name, v in c.departure.items()
        ],
    }  # fmt: skip
