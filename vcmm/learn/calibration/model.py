"""The numbers that a calibration looks for: error curves over their axes, and squareness.

Every curve is a natural cubic spline through equally spaced nodes. Combinations that no relative measurement can separate are fixed
by convention (the gauge):

    a rotation EAX ...        its mean over the travel is zero
    a positioning error EXX   its mean over the travel is zero
    a straightness EYX ...    its least-squares line over the travel is zero: direction of travel is squareness
    lost motion BX ...        as it is: half of it is added in one sense of motion and taken in the other
    squareness C0Y B0Z A0Z    as in ISO 230-1: X is the primary axis, Y the secondary
    a rotary axis EXC ...     the mean over a turn is zero; of EXC and EAC (EXB EAB, EYA EBA) the once-per-turn part too
    location X0C Y0C A0C B0C  as in ISO 230-1; `rotary.average_line` moves it to the axis average line (ISO 230-7)

The means and lines taken away are a rigid motion of the workpiece, a turn of the tool in its holder, and squareness;
`gauge` says how much squareness. With three linear axes 18 curves and 3 angles remain, and nothing among them is free. A centre
line that is shifted or tilted is a once-per-turn motion of the axis in two directions; that of the first direction is left to it.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from vcmm.core.axes import axis_of, in_order, is_location, is_rotary, whole_turn
from vcmm.core.effect import Effect, basis, parameter_fields
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.grid import node_weights
from vcmm.core.kinematics import Axis, Chain, Motion, tip_motion
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.physics.structure.component import ComponentSpline, ComponentTable
from vcmm.physics.structure.lost_motion_table import LostMotionTable
from vcmm.physics.structure.squareness import RotaryLocation, Squareness

SIZE, TURN = 3e-3, 5e-6  # mm, rad: usual rms of a component
PAIR_AXES = {"C0Y": "XY", "B0Z": "XZ", "A0Z": "YZ"}
LOCATIONS = {"A": ("Y0", "Z0", "B0", "C0"), "B": ("X0", "Z0", "A0", "C0"), "C": ("X0", "Y0", "A0", "B0")}
OFFSET, ANGLE = 1e-2, 1e-5  # mm, rad: usual location error, usual squareness
LINEAR = "table"  # the kind of curve that is linear between its nodes; all others are cubic
SPANS = ((0.0, 0.0, 0.0), (100.0, 0.0, 0.0), (0.0, 100.0, 0.0), (0.0, 0.0, 100.0))  # mm, tips for the gauge


@dataclass(frozen=True, eq=False)
class Curve:
    """One error over its axis: component such as EYX, nodes (k,) mm or rad. is_centred: its once-per-turn part is location.

    kind: what runs between the nodes (vcmm.learn.calibration.prior). has_file_nodes: its nodes are those of the machine file, and stay.
    """

    component: str
    nodes: Array
    is_centred: bool = False
    kind: str = "spline"
    has_file_nodes: bool = False

    @property
    def axis(self) -> str:
        return self.component[1:] if self.reversal else axis_of(self.component)

    @property
    def rotary(self) -> bool:
        return is_rotary(self.axis)

    @property
    def periodic(self) -> bool:
        return whole_turn(self.axis, self.nodes)

    @property
    def usual(self) -> float:
        """Usual rms, mm or rad: the start of a search, and the unit of a broad prior."""
        return TURN if self.turns else SIZE

    @property
    def reversal(self) -> bool:
        """Whether it is BX: lost motion of axis X over its travel, half of it with the sense of motion; without any convention."""
        return self.component[0] == "B"

    @property
    def travel(self) -> float:
        return float(self.nodes[-1] - self.nodes[0])

    @property
    def turns(self) -> bool:
        """Whether it is a rotation (rad) and not a translation (mm)."""
        return not self.reversal and self.component[1] in "ABC"

    @property
    def straightness(self) -> bool:
        return not self.turns and not self.reversal and not self.rotary and self.component[1] != self.axis

    def weights(self, q: Array) -> Array:
        """Return weights (n, k): the curve at q (n,) = weights @ values, as the machine file interpolates."""
        straight = self.reversal or self.kind == LINEAR
        return node_weights(self.nodes, q, "linear" if straight else "periodic" if self.periodic else "cubic")

    def _convention(self, q: Array) -> Array:
        """Return the functions at q (n,) that the convention removes, (n, 0 to 3): a constant, for a straightness the position from the middle, of a
        centred curve once per turn.
        """
        ones = np.ones(len(q))
        if self.reversal:
            return np.zeros((len(ones), 0))
        if self.rotary:
            return np.stack([ones, *([np.cos(q), np.sin(q)] if self.is_centred else [])], axis=1)
        return np.stack([ones, q - self.nodes[[0, -1]].mean()] if self.straightness else [ones], axis=1)

    @cached_property
    def convention(self) -> Array:
        """Functions that the convention removes, at the nodes (k, c); c is 0 to 3."""
        return self._convention(self.nodes)

    @cached_property
    def share(self) -> Array:
        """(c, k): how much of each column of `taken` is in a curve: least squares over the travel, of the curve as it runs between
        the nodes. So the least-squares line of ISO 230-1 and squareness do not depend on the places of the nodes. Three points of
        Gauss between two nodes integrate a cubic times a line exactly; over whole turns equal steps do.
        """
        if self.periodic:
            return np.pad(np.linalg.pinv(self.convention[:-1]), ((0, 0), (0, 1)))
        at, weight = np.polynomial.legendre.leggauss(3)
        half = np.diff(self.nodes)[:, None] / 2
        q = (self.nodes[:-1, None] + half * (1 + at)).ravel()
        product = (self._convention(q) * (half * weight).ravel()[:, None]).T @ self.weights(q)
        return np.asarray(np.linalg.solve(product @ self.convention, product))

    @cached_property
    def projector(self) -> Array:
        """Projector (k, k) of a curve to the same curve without its mean or line."""
        return self.free @ self.coordinates

    @cached_property
    def free(self) -> Array:
        """Orthonormal shapes that the convention leaves (k, g); of a whole turn the last node has the value of the first."""
        share = self.share[:, :-1] if self.periodic else self.share
        shapes = np.linalg.qr(share.T, mode="complete")[0][:, len(share) :]
        return np.concatenate([shapes, shapes[:1]]) if self.periodic else np.asarray(shapes)

    @cached_property
    def coordinates(self) -> Array:
        """Matrix (g, k) from values at the nodes to the amounts of the shapes of `free`."""
        kept = np.eye(len(self.nodes)) - self.convention @ self.share
        shapes = self.free.copy()
        if self.periodic:
            shapes[-1] = 0.0
        return np.asarray(shapes.T @ kept)


@dataclass(frozen=True, eq=False)
class ErrorModel:
    """The curves and the pairs, in this order the numbers theta (size,), mm and rad."""

    curves: tuple[Curve, ...]
    pairs: tuple[str, ...]

    @property
    def names(self) -> tuple[str, ...]:
        return (*(c.component for c in self.curves), *self.pairs)

    @cached_property
    def slices(self) -> Mapping[str, slice]:
        """Slice of each error in theta."""
        out, at = {}, 0
        for name, k in zip(self.names, [*(len(c.nodes) for c in self.curves), *(1 for _ in self.pairs)]):
            out[name] = slice(at, at + k)
            at += k
        return out

    @property
    def size(self) -> int:
        return max((s.stop for s in self.slices.values()), default=0)

    @property
    def labels(self) -> tuple[tuple[str, ...], Array]:
        """Name and position of each number; nan for squareness."""
        names = [c.component for c in self.curves for _ in c.nodes] + list(self.pairs)
        nodes = [c.nodes for c in self.curves] + [np.full(len(self.pairs), np.nan)]
        return tuple(names), np.concatenate(nodes)

    def effects(self, theta: Array | None = None) -> list[Effect]:
        """Return the errors as effects of a machine; without theta all zero."""
        theta = np.zeros(self.size) if theta is None else theta
        splines = [curve_effect(c, theta[self.slices[c.component]]) for c in self.curves]
        return [*splines, *(angle_effect(p, float(theta[self.slices[p]][0])) for p in self.pairs)]

    def coarser(self, step: int) -> tuple[ErrorModel, Array]:
        """Return the model with every step-th node only, and the matrix (size, fewer) from its numbers to these: both describe one spline."""
        fewer = (c if c.has_file_nodes else replace(c, nodes=c.nodes[::step]) for c in self.curves)
        model = ErrorModel(tuple(fewer), self.pairs)
        lift = np.zeros((self.size, model.size))
        for new, old in zip(model.curves, self.curves):
            block = new.weights(old.nodes)
            lift[self.slices[old.component], model.slices[new.component]] = block
        for pair in self.pairs:
            lift[self.slices[pair], model.slices[pair]] = 1.0
        return model, lift


def curve_effect(curve: Curve, values: Array) -> Effect:
    """Return one curve as an effect of a machine."""
    if curve.kind == LINEAR and not curve.reversal:
        return ComponentTable(curve.component, (curve.axis,), (curve.nodes,), values)
    if curve.reversal:
        return LostMotionTable(curve.axis, curve.nodes, values)
    return ComponentSpline(curve.component, curve.nodes, values)


def angle_effect(pair: str, angle: float) -> Effect:
    """Return one squareness, rad, or location error of a rotary axis, mm or rad, as an effect of a machine."""
    if is_location(pair):
        shift = "offset" if pair[0] in "XYZ" else "tilt"
        return RotaryLocation(pair, **{shift: angle})
    return Squareness(pair, angle)


def usual_pairs(model: ErrorModel) -> Array:
    """Return (pairs,): usual size of squareness and location errors, rad or mm."""
    return np.array([OFFSET if p[0] in "XYZ" else ANGLE for p in model.pairs])


def error_model(
    ranges: Mapping[str, tuple[float, float]],
    nodes: int,
    only: Sequence[str] = (),
    both_ways: Sequence[str] = (),
    stated: Sequence[str] = (),
) -> ErrorModel:
    """Return all errors of the axes that moved; ranges: axis -> (low, high) mm or rad. only: names of the errors to look for.

    both_ways: axes that were approached from both sides, whose lost motion is looked for too. stated: errors of the machine
    file; a squareness among them is kept, whether or not both axes moved.

    Raises UsageError for a name that is no error of these axes.
    """
    axes = [a for a in "XYZ" if a in ranges]
    curves = [Curve(f"E{kind}{a}", np.linspace(*ranges[a], nodes)) for a in axes for kind in "XYZABC"]
    curves += [Curve(f"B{a}", np.linspace(*ranges[a], nodes)) for a in axes if a in both_ways]
    pairs = [p for p, needed in PAIR_AXES.items() if set(needed) <= set(axes) or p in stated]
    for axis in in_order(a for a in ranges if is_rotary(a)):
        curves += [Curve(f"E{kind}{axis}", np.linspace(*ranges[axis], 2 * nodes - 1)) for kind in "XYZABC"]
        pairs += [f"{where}{axis}" for where in LOCATIONS[axis[0]]]
    names = [*(c.component for c in curves), *pairs]
    for name in only:
        if name not in names:
            raise UsageError(
                f'--errors names "{name}", no error of the axes that moved.{choose_from(name, names)}'
            )
    wanted = set(only or names)
    kept = [replace(c, is_centred=_is_centred(c, wanted)) for c in curves if c.component in wanted]
    return ErrorModel(tuple(kept), tuple(p for p in pairs if p in wanted))


def _is_centred(curve: Curve, wanted: Collection[str]) -> bool:
    """Return whether a curve is the first of two directions across a rotary axis, whose location errors are looked for too."""
    if not curve.rotary:
        return False
    places = LOCATIONS[curve.axis[0]]
    pair = places[2:] if curve.turns else places[:2]
    return curve.component[1] == pair[0][0] and all(f"{p}{curve.axis}" in wanted for p in pair)


def gauge(model: ErrorModel, machine: Machine) -> Array:
    """Return the matrix (size, size) from any theta to the one of the convention that describes the same machine.

    The part removed from the curves is a rigid motion, a turn of the tool in its holder and squareness, by least squares on a
    grid of the volume; the rest is rounding where all pairs of the axes are in the model.
    """
    out = np.zeros((model.size, model.size))
    for curve in model.curves:
        here = model.slices[curve.component]
        out[here, here] = curve.projector
    for pair in model.pairs:
        out[model.slices[pair], model.slices[pair]] = 1.0
    if model.pairs:
        rows = [model.slices[p].start for p in model.pairs]
        for curve in (c for c in model.curves if not c.reversal and not c.rotary):
            share = _as_squareness(model, curve, machine)
            out[rows, model.slices[curve.component]] += share @ curve.share
    return out


def _as_squareness(model: ErrorModel, curve: Curve, machine: Machine) -> Array:
    """Return the squareness that replaces the constant and the line of a curve, (pairs, 1 or 2)."""
    run = _grid(model, machine)
    field = _columns(machine.chain, machine.axes, run, curve_effect(curve, curve.nodes))
    taken = field @ curve.convention
    pairs = [_columns(machine.chain, machine.axes, run, angle_effect(p, 0.0)) for p in model.pairs]
    free = np.concatenate([*pairs, _rigid(machine.prepare(run).tip), _tool_turns(machine, run)], axis=1)
    scale = np.linalg.norm(free, axis=0)
    scale[scale == 0] = 1.0
    solution = np.linalg.lstsq(free / scale, taken, rcond=1e-9)[0] / scale[:, None]
    return np.asarray(solution[: len(model.pairs)])


def number_of(effect: Effect) -> str:
    """Return the only parameter of an error that a calibration finds: "values", "angle", and of a location "offset" or "tilt"."""
    specs = [
        s
        for s in parameter_fields(effect)
        if effect.where[0] in s.metadata.get("only", "") or not s.metadata.get("only")
    ]
    (spec,) = specs
    return spec.name


def _columns(chain: Chain, axes: Mapping[str, Axis], run: Run, effect: Effect) -> Array:
    """Return the tip error x y z of every row per unit of each element of the parameter, as (3 n, k)."""
    six = basis(effect, number_of(effect), run)
    sign = -1.0 if effect.own and effect.link in chain.work else 1.0
    moved = [
        tip_motion(chain, axes, run, [Motion(effect.link, effect.place, sign * six[:, :, k])])[:, :3].ravel()
        for k in range(six.shape[2])
    ]
    return np.stack(moved, axis=1)


def _grid(model: ErrorModel, machine: Machine) -> Run:
    """Return corners and middles of the volume, each with four tips."""
    grids = {c.axis: np.linspace(c.nodes[0], c.nodes[-1], 4 if c.rotary else 3) for c in model.curves}
    letters = machine.chain.letters
    steps: list[Any] = [grids.get(a, np.zeros(1)) for a in letters]
    mesh = np.stack([m.ravel() for m in np.meshgrid(*steps, indexing="ij")], axis=1)
    offset = np.repeat(np.array(SPANS), len(mesh), axis=0)
    mesh = np.tile(mesh, (len(SPANS), 1))
    return Run({a: mesh[:, i] for i, a in enumerate(letters)}, offset)


def _rigid(tip: Array) -> Array:
    """Return shifts, and turns about the origin, (3 n, 6)."""
    shift = np.tile(np.eye(3), (len(tip), 1))
    turn = np.stack([np.cross(axis, tip).ravel() for axis in np.eye(3)], axis=1)
    return np.concatenate([shift, turn], axis=1)


def _tool_turns(machine: Machine, run: Run) -> Array:
    """Return the tip motion when the tool turns in its holder, (3 n, 3)."""
    out = []
    for axis in np.eye(3):
        six = np.zeros((run.n, 6))
        six[:, :3] = np.cross(axis, run.offset)
        moved = tip_motion(machine.chain, machine.axes, run, [Motion("tool", "motion", six)])
        out.append(moved[:, :3].ravel())
    return np.stack(out, axis=1)
