"""The paper's headline: slots milled for real, measured on a CMM, against what both models predict of them.

    truth      a mill of rigid slides with lost motion (drawn); its slots scatter from pass to pass
    readings   laser and level, a reflector per component, forward and backward     (survey.read)
    models     conventional and Abbe-consistent, both from the readings             (survey.conventional_model, consistent_model)
    slots      centre, near and far corner, measured by a virtual CMM               (measured)

A CMM does not know where the mill's zero was: both what it measured and what a model predicts are aligned by best fit, each slot
by itself, or the three slots of one plate together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.papers.abbe_milling.survey import (
    Planned,
    consistent_model,
    conventional_model,
    read,
    surveyed,
)
from vcmm.papers.virtual_cut import SeenNet, departure
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.measuring.plan import Plan, Step, Stylus, touches

CENTRE, NEAR, FAR = "centre", "corner X- Y-", "corner X+ Y+"
ZEROS = {
    CENTRE: (750.0, 450.0, -560.0),
    NEAR: (150.0, 100.0, -560.0),
    FAR: (1350.0, 800.0, -560.0),
}  # mm, of the tip
BY_ITSELF, ONE_PLATE = "each slot by itself", "one plate"
LOST, PASS, TOUCH = (
    3e-3,
    0.8e-3,
    0.4e-3,
)  # mm: scale of lost motions, scatter of a pass, of a touch of the CMM
CMM_SCALE, CMM_SQUARE = 1e-6, 2e-6  # what is left of the CMM's errors: per mm, rad
CONVENTIONAL, CONSISTENT = "conventional", "Abbe-consistent"


@dataclass(frozen=True)
class SlotPrediction:
    """One slot of one drawn machine, rms in um after alignment: real (measured), predicted by model, missed = prediction - real."""

    place: str
    alignment: str
    real: float
    predicted: Mapping[str, float]
    missed: Mapping[str, float]

    def over(self, model: str) -> float:
        """By how much the prediction is larger than what was measured."""
        return self.predicted[model] / self.real - 1.0


Slots = Mapping[str, tuple[SeenNet, ...]]  # place -> nets of its slot


def true_mill(rigid: Machine, rng: np.random.Generator) -> Machine:
    """The drawn rigid-slide machine with drawn lost motions."""
    gaps = (Backlash(a, abs(LOST * rng.standard_normal())) for a in "XYZ")
    return rigid.with_effect(*gaps)


def virtual_cmm(rng: np.random.Generator) -> Machine:
    """A bridge CMM with what its compensation leaves, drawn: scales and squareness (U of some 1 um over a slot)."""
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    left: list[Effect] = [ScaleFactor(a, CMM_SCALE * rng.standard_normal()) for a in "XYZ"]
    left += [Squareness(p, CMM_SQUARE * rng.standard_normal()) for p in ("A0Z", "B0Z", "C0Y")]
    return Machine("CMM", "cmm", parse_structure("w b Y X Z t"), axes, tuple(left))


def measured(
    nets: Sequence[SeenNet], truth: Machine, cmm: Machine, rng: np.random.Generator, at: Array
) -> Array:
    """What the CMM finds of one slot (n,) mm, along the normals: the surface as it was cut, and the CMM's own errors.

    at (3,): where the slot lies on the plate, mm, which is where it lies on the CMM.
    """
    scatter = PASS * rng.standard_normal(3)  # the slot is finished in one pass
    styli = {"ball": Stylus("ball", np.array([0.0, 0.0, -100.0]), 1.0)}
    out = []
    for one in nets:
        net = one.net
        plan = Plan((Step(net.feature, "ball", net.points, net.normals),), styli)
        run = touches(plan, Pose(np.eye(3), at), cmm).run
        own = np.einsum("ni,ni->n", cmm.indication_error(run), net.normals)
        cut = departure(one, truth, zero_set_here=False) + net.normals @ scatter
        out.append(cut + own + TOUCH * rng.standard_normal(len(own)))
    return np.concatenate(out)


def predicted(nets: Sequence[SeenNet], model: Machine) -> Array:
    """Departures (n,) mm of one slot that a model predicts."""
    return np.concatenate([departure(one, model, zero_set_here=False) for one in nets])


def motions(nets: Sequence[SeenNet], at: Array) -> Array:
    """(n, 6): departures of unit shifts and turns of the plate, the slot lying at `at` (3,) mm."""
    points, normals = (np.concatenate([getattr(one.net, k) for one in nets]) for k in ("points", "normals"))
    return np.hstack([normals, np.cross(points + at, normals)])


def aligned(values: Array, columns: Array) -> Array:
    """Less the best rigid motion."""
    return np.asarray(values - columns @ np.linalg.lstsq(columns, values, rcond=None)[0])


@dataclass(frozen=True, eq=False)
class ShownSlot:
    """A slot along its left wall at middle depth, after alignment by itself: along (k,) mm; measured and predicted (k,) um."""

    along: Array
    measured: Array
    predicted: Mapping[str, Array]


def shown_slots(slots: Slots, setups: Planned, rigid: Machine, seed: int) -> dict[str, ShownSlot]:
    """The slots of one drawn mill as the paper draws them (its figures 8 and 9)."""
    truth, models, rng = surveyed_mill(setups, rigid, seed)
    cmm, out = virtual_cmm(rng), {}
    for place, nets in slots.items():
        at = np.array(ZEROS[place]) - np.array(ZEROS[CENTRE])
        columns, left = motions(nets, at), nets[0].net
        k = len(left.first)
        middle = slice(k, 2 * k)  # of the heights, the second
        found = {n: 1e3 * aligned(predicted(nets, m), columns)[middle] for n, m in models.items()}
        real = 1e3 * aligned(measured(nets, truth, cmm, rng, at), columns)[middle]
        out[place] = ShownSlot(left.first, real, found)
    return out


def predictions(
    slots: Slots, truth: Machine, models: Mapping[str, Machine], rng: np.random.Generator
) -> list[SlotPrediction]:
    """Every slot measured and predicted, in both alignments."""
    cmm = virtual_cmm(rng)
    at = {p: np.array(ZEROS[p]) - np.array(ZEROS[CENTRE]) for p in slots}
    real = {p: measured(nets, truth, cmm, rng, at[p]) for p, nets in slots.items()}
    said = {name: {p: predicted(nets, one) for p, nets in slots.items()} for name, one in models.items()}
    columns = {p: motions(nets, at[p]) for p, nets in slots.items()}
    out = []
    for how, align in ((BY_ITSELF, _each), (ONE_PLATE, _together)):
        true, others = align(real, columns), {name: align(v, columns) for name, v in said.items()}
        for p in slots:
            out.append(
                SlotPrediction(
                    p,
                    how,
                    1e3 * rms(true[p]),
                    {n: 1e3 * rms(v[p]) for n, v in others.items()},
                    {n: 1e3 * rms(v[p] - true[p]) for n, v in others.items()},
                )
            )
    return out


def _each(values: Mapping[str, Array], columns: Mapping[str, Array]) -> dict[str, Array]:
    return {p: aligned(v, columns[p]) for p, v in values.items()}


def _together(values: Mapping[str, Array], columns: Mapping[str, Array]) -> dict[str, Array]:
    left = aligned(np.concatenate(list(values.values())), np.concatenate([columns[p] for p in values]))
    ends = np.cumsum([len(v) for v in values.values()])
    return dict(zip(values, np.split(left, ends[:-1])))


def validated(slots: Slots, setups: Planned, rigid: Machine, seed: int) -> list[SlotPrediction]:
    """One drawn mill: read, modelled, its slots milled, measured and predicted."""
    truth, models, rng = surveyed_mill(setups, rigid, seed)
    return predictions(slots, truth, models, rng)


def surveyed_mill(
    setups: Planned, rigid: Machine, seed: int
) -> tuple[Machine, dict[str, Machine], np.random.Generator]:
    """The true mill, both models of it by what laser and level read, and the generator behind them."""
    rng = np.random.default_rng([seed, 24071])
    truth, bare = true_mill(rigid, rng), replace(rigid, effects=(), inputs=())
    found = surveyed(read(setups, bare, truth, rng), bare)
    return (
        truth,
        {CONVENTIONAL: conventional_model(bare, found), CONSISTENT: consistent_model(bare, found)},
        rng,
    )


def rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
