"""Twin of a paper on Abbe's principle in the kinematic error model of three-axis mills (Droop & Rein, laser and level).

The laser sees the translation of its reflector, and a rotation of the axis moves the reflector as well. A product of
transforms whose arms count from the axis frame adds that share a second time. The arms that count it once lead from the
reflector to the tool: `measured_at`. The paper finds a mean volumetric error 24.7 % smaller. That is a smaller
prediction, not a more accurate machine, nor by itself a more accurate prediction.

The text gives neither error tables, axes, travels, places of the reflectors nor the spline; all of them are drawn here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.kinematics import Axis, link_frames, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.files.own.design import load_design
from vcmm.files.own.library import folder
from vcmm.papers.abbe_milling.spline_slot import Slot, nets
from vcmm.papers.abbe_milling.validation import (
    FAR as FAR,
)
from vcmm.papers.abbe_milling.validation import (
    ZEROS,
    ShownSlot,
    SlotPrediction,
    rms,
    shown_slots,
    validated,
)
from vcmm.papers.error_tables import effects_of, shape, table_text
from vcmm.papers.virtual_cut import SeenNet, departure, placed, seen, thinned
from vcmm.physics.structure.component import ComponentTable
from vcmm.physics.structure.squareness import Squareness
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.scenario import CutScenario
from vcmm.task.response.volumetric import grid

PAPER_REDUCTION = 0.247
LENGTH = {"X": 1500.0, "Y": 900.0, "Z": 600.0}  # mm, travels
TOOL = np.array([0.0, 0.0, -150.0])  # mm, from the spindle nose to the tip
TABLE = np.array(
    [750.0, 450.0, -650.0]
)  # reflector on the table, tool-relative mm, machine zero in the corner
STRUCTURES = {  # the paper's groups: single axis carrying the tool, several carrying the tool, several the workpiece
    "w X' Y' b Z t": "Z alone carries the tool, X and Y the workpiece",
    "w X' b Y Z t": "Y and Z carry the tool, X the workpiece",
    "w b X Y Z t": "all carry the tool",
}
DRAWS = 100  # machines
ORIGINS = {"corner": (0.0, 0.0, -1.0), "middle": (-0.5, -0.5, -0.5)}  # low end of the travels, in lengths
POSITIONING, STRAIGHTNESS, TILT, ROLL, SQUARE = (
    6e-3,
    4e-3,
    20e-6,
    12e-6,
    15e-6,
)  # mm, rad: scales of the draws
GUIDE = 250.0  # mm from the reflector to the point about which a slide turns
PLACES = {  # work zero in machine coordinates of the tip
    "centre": (750.0, 450.0, -560.0), "corner X- Y-": (150.0, 100.0, -560.0), "corner X+ Y-": (1350.0, 100.0, -560.0),
    "corner X- Y+": (150.0, 800.0, -560.0), "corner X+ Y+": (1350.0, 800.0, -560.0),
}  # fmt: skip
RIGID, APART = "rigid slide", "independent"  # how translations and rotations of the draws belong together
Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class Reduction:
    """How much smaller the mean volumetric error becomes, over draws: 1 - Abbe-consistent / conventional."""

    structure: str
    zero: str
    draws_of: str
    median: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class SlotCut:
    """Departures (um) of one slot: both models at the same points; rms and largest by surface are made from them."""

    place: str
    zero_set_here: bool
    conventional: Mapping[str, Array]
    consistent: Mapping[str, Array]


@dataclass(frozen=True)
class CornerEffect:
    """The effect (rms difference of the two models over the walls) against that at the centre, over draws."""

    place: str
    zero_set_here: bool
    effect_um: float  # median
    ratio: float  # median of corner / centre
    larger: float  # share of the draws in which the corner shows more
    over: float  # median of conventional / Abbe-consistent - 1, rms of the walls
    over_share: float  # share of the draws in which the conventional prediction is the larger one


@dataclass(frozen=True, eq=False)
class AbbeTwin:
    reductions: tuple[Reduction, ...]
    slots: tuple[SlotCut, ...]
    corners: tuple[CornerEffect, ...]
    draws: int
    seen: Mapping[str, tuple[SeenNet, ...]]
    validation: tuple[tuple[SlotPrediction, ...], ...]  # per draw
    shown: Mapping[str, ShownSlot]  # of the first draw, by place


def axes_of(zero: str) -> dict[str, Axis]:
    """Axes without reflectors; zero: machine zero in the corner of the travels, or in their middle."""
    low = dict(zip("XYZ", ORIGINS[zero]))
    return {a: Axis(a, (low[a] * LENGTH[a], (low[a] + 1) * LENGTH[a])) for a in "XYZ"}


def reflectors(
    structure: str, axes: Mapping[str, Axis], table: Array, tool: Array = TOOL
) -> dict[str, Array]:
    """Where the reflector stood, in the moving frame of each axis, by the paper's groups: on the tool for an axis that
    carries the tool, on the table for one that carries the workpiece; the other axes stood in the middle of their travels.

    table (3,): the place on the table in workpiece axes. A single axis with the tool gets arms of zero, as in the paper.
    """
    chain = parse_structure(structure)
    stand = Run({a: np.array([np.mean(axes[a].travel)]) for a in chain.letters}, tool[None, :])
    frames, tool_end, work_end = link_frames(chain, axes, stand)
    place = {"tool": tool_end.apply(tool[None, :]), "work": work_end.apply(np.asarray(table)[None, :])}
    side = {a: "tool" if a in chain.tool else "work" for a in chain.letters}
    return {a: frames[a].after.undo(place[side[a]])[0] for a in chain.letters}


def table_point(axes: Mapping[str, Axis]) -> Array:
    """TABLE for these zeros of the axes (mm, workpiece axes)."""
    shift = [axes[a].travel[0] - low for a, low in zip("XYZ", (0.0, 0.0, -LENGTH["Z"]))]
    return TABLE + np.array(shift)


def draw_tables(seed: int, structure: str, draws_of: str = RIGID) -> dict[str, Array]:
    """Error tables as a laser with its reflector reads them: component -> (NODES,), mm or rad; squareness: one number.

    rigid slide: the slide turns about a point GUIDE mm below the reflector on a table, above it on a tool-carrying axis,
    and the reflector sees its share of the rotations (rotation x arm);   independent: what the reflector sees is drawn apart from the rotations.
    """
    rng = np.random.default_rng([seed, 24070])
    work = parse_structure(structure).work
    out: dict[str, Array] = {}
    for axis in "XYZ":
        shift = np.stack([shape(rng) * (POSITIONING if d == axis else STRAIGHTNESS) for d in "XYZ"], axis=1)
        turn = np.stack([shape(rng) * (ROLL if d == axis else TILT) for d in "XYZ"], axis=1)
        if draws_of == RIGID:
            arm = [0.0, 0.0, GUIDE if axis in work else -GUIDE]
            shift = shift + np.cross(turn, arm)
        out |= {f"E{d}{axis}": shift[:, i] for i, d in enumerate("XYZ")}
        out |= {f"E{d}{axis}": turn[:, i] for i, d in enumerate("ABC")}
    return out | {pair: np.array([rng.normal() * SQUARE]) for pair in ("A0Z", "B0Z", "C0Y")}


def machine(
    seed: int, structure: str = "w X' Y' b Z t", zero: str = "corner", draws_of: str = RIGID
) -> Machine:
    """A drawn machine, Abbe-consistent: `measured_at` is where the reflector stood."""
    axes = axes_of(zero)
    place = reflectors(structure, axes, table_point(axes))
    effects = effects_of(draw_tables(seed, structure, draws_of), axes)
    known = {a: replace(axis, measured_at=tuple(place[a].tolist())) for a, axis in axes.items()}
    return Machine(f"drawn mill {seed}", "machine-tool", parse_structure(structure), known, effects)


def conventional(consistent: Machine) -> Machine:
    """The same tables with the arms of the rotations counted from the axis frames: Abbe counted twice."""
    axes = {a: replace(axis, measured_at=None) for a, axis in consistent.axes.items()}
    return replace(consistent, axes=axes)


def mean_error(one: Machine, nodes: int = 5) -> float:
    """Mean size of the tip error (mm) on a grid over the travels, tool in the spindle."""
    run = grid(one, nodes)
    run = Run(run.position, np.tile(TOOL, (run.n, 1)))
    return float(np.linalg.norm(one.tip_error(run), axis=1).mean())


def reduction(seed: int, structure: str, zero: str, draws_of: str) -> float:
    """1 - mean(Abbe-consistent) / mean(conventional) of one draw."""
    one = machine(seed, structure, zero, draws_of)
    return 1.0 - mean_error(one) / mean_error(conventional(one))


def reductions(draws: int, report: Progress) -> tuple[Reduction, ...]:
    """Over the structures, both machine zeros and both ways of drawing."""
    cases = [(s, z, d) for s in STRUCTURES for z in ORIGINS for d in (RIGID, APART)]
    out = []
    for number, (structure, zero, kind) in enumerate(cases):
        report(f"mean volumetric error, {structure}", 0.6 * number / len(cases))
        found = np.array([reduction(seed, structure, zero, kind) for seed in range(1, draws + 1)])
        out.append(
            Reduction(structure, zero, kind, float(np.median(found)), float(found.min()), float(found.max()))
        )
    return tuple(out)


def run(scenario: CutScenario, draws: int = DRAWS, progress: Progress | None = None) -> AbbeTwin:
    """Mean volumetric errors over draws, and the slots of the scenario's machine at the centre and in four corners."""
    report = progress or (lambda text, share: None)
    means = reductions(draws, report)
    views = {}
    for number, (place, zero) in enumerate(PLACES.items()):
        report(f"slot, {place}", 0.6 + 0.25 * number / len(PLACES))
        views[place] = look_at(scenario, zero)
    slots = tuple(
        slot_cut(place, views[place], scenario.machine, here) for here in (False, True) for place in PLACES
    )
    walls = {
        place: tuple(thinned(v) for v in seen_ if "wall" in v.net.feature) for place, seen_ in views.items()
    }
    report("slots milled and measured", 0.85)
    structure = scenario.machine.chain.structure
    mills = [machine(seed, structure) for seed in range(1, draws + 1)]
    setups = load_design(folder() / "abbe_milling" / "survey.toml")[0]
    three = {place: walls[place] for place in ZEROS}
    found = tuple(tuple(validated(three, setups, one, seed)) for seed, one in enumerate(mills, 1))
    report("slots of further draws", 0.95)
    effects = corners(scenario, walls, mills)
    return AbbeTwin(
        reductions=means,
        slots=slots,
        corners=effects,
        draws=draws,
        seen=views,
        validation=found,
        shown=shown_slots(three, setups, mills[0], 1),
    )


def look_at(scenario: CutScenario, zero: tuple[float, float, float]) -> tuple[SeenNet, ...]:
    """Walls and floor of the slot cut with the work zero at machine position `zero` of the tip, mm."""
    shop = set_up(replace(scenario, setup=placed(scenario.setup, zero)))
    return tuple(seen(shop, one) for one in nets(Slot(), 61))


def slot_cut(place: str, views: tuple[SeenNet, ...], consistent: Machine, here: bool) -> SlotCut:
    def of(one: Machine) -> dict[str, Array]:
        return {v.net.feature: departure(v, one, here) * 1e3 for v in views}

    return SlotCut(place, here, of(conventional(consistent)), of(consistent))


def with_tables(one: Machine, other: Machine) -> Machine:
    """The machine of the scenario with the error tables of another draw."""
    kept = tuple(e for e in one.effects if not isinstance(e, ComponentTable | Squareness))
    return replace(one, effects=(*kept, *other.effects))


def corners(
    scenario: CutScenario, walls: Mapping[str, tuple[SeenNet, ...]], mills: Sequence[Machine]
) -> tuple[CornerEffect, ...]:
    """Effect of the arms in every corner against the centre, over draws of the scenario's structure, the consistent model as truth."""
    out = []
    machines = [with_tables(scenario.machine, one) for one in mills]
    for here in (False, True):
        # (draws, 3): rms of both models and of their difference, um
        found = {p: np.array([both(walls[p], one, here) for one in machines]) for p in PLACES}
        for place, sizes in found.items():
            ratio, over = sizes[:, 2] / found["centre"][:, 2], sizes[:, 0] / sizes[:, 1] - 1.0
            out.append(
                CornerEffect(
                    place=place,
                    zero_set_here=here,
                    effect_um=float(np.median(sizes[:, 2])),
                    ratio=float(np.median(ratio)),
                    larger=float((ratio > 1).mean()),
                    over=float(np.median(over)),
                    over_share=float((over > 0).mean()),
                )
            )
    return tuple(out)


def both(walls: tuple[SeenNet, ...], consistent: Machine, here: bool) -> tuple[float, float, float]:
    """rms over the walls, um: conventional, Abbe-consistent, their difference."""
    of = [
        np.concatenate([departure(v, one, here) for v in walls])
        for one in (conventional(consistent), consistent)
    ]
    return rms(of[0]) * 1e3, rms(of[1]) * 1e3, rms(of[0] - of[1]) * 1e3


def errors_csv(seed: int = 1, structure: str = "w X' Y' b Z t", zero: str = "corner") -> str:
    """The error table of the scenario (ISG volumetric CSV): the draw of one seed."""
    said = f"drawn by us, seed {seed}: mm and rad over the axis position in mm, as a laser with its reflector reads them"
    return table_text(draw_tables(seed, structure), axes_of(zero), said)


def figures(result: AbbeTwin) -> dict[str, object]:
    """Plain numbers for JSON: shares as fractions, departures in um."""
    return {
        "draws": result.draws,
        "paper_reduction": PAPER_REDUCTION,
        "reductions": [vars(one) for one in result.reductions],
        "corners": [vars(one) for one in result.corners],
        "validation": [
            {"draw": draw, "place": one.place, "alignment": one.alignment, "measured_rms_um": one.real,
             "predicted_rms_um": dict(one.predicted), "missed_rms_um": dict(one.missed)}
            for draw, several in enumerate(result.validation, 1) for one in several
        ],
        "slots": [
            {"place": s.place, "zero_set_here": s.zero_set_here, "model": model, "surface": name,
             "rms_um": rms(values), "largest_um": float(np.abs(values).max())}
            for s in result.slots
            for model, found in (("conventional", s.conventional), ("Abbe-consistent", s.consistent))
            for name, values in found.items()
        ],
    }  # fmt: skip
