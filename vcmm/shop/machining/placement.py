"""Find the best place of a part on the table: compare poses of a cutting scenario by the deviations of the cut part.

The work offset moves with the part, so the tool path keeps its place in the part and the contacts stay as they are; what
changes is where in the travels of the machine everything happens. One number per pose:

    sum over characteristics of  weight x |expected deviation| / half the tolerance      (deviation where none is stated)

Turning the part would turn the program as well; only shifts are moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.answer.placing.certificate import Certificate, certify, scan_after
from vcmm.answer.placing.fixture_boxes import PoseBox
from vcmm.answer.placing.near_best import Map, Region, region, table_map
from vcmm.answer.placing.search import search
from vcmm.answer.placing.travels import EDGE
from vcmm.core.blocks import Progress
from vcmm.core.declaration import KnownRange
from vcmm.core.effect import known_range
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import Array, Run
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import Characteristic
from vcmm.shop.machining.cut_world import Cutting
from vcmm.shop.machining.job import cut, finished_part
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.result import CutResult
from vcmm.task.measuring.cut_scenario import SAME_MACHINE, CutScenario
from vcmm.task.measuring.fixture import Fixture, Freedom, pose_of, six_of

BATCH = 64  # poses at once
EVALUATIONS, SCANNED = 5000, 4096


@dataclass(frozen=True, eq=False)
class ProgramTravels:
    """Limits on shifts of the part so that the whole program stays within travels and known ranges. present (3,): its shift."""

    job: PreparedCut
    present: Array

    @cached_property
    def limits(self) -> tuple[KnownRange, ...]:
        machine = self.job.machine
        out = [
            KnownRange(f"travel of axis {a}", "XYZ".index(a), *machine.axes[a].travel)
            for a in machine.chain.letters
            if a in "XYZ"
        ]
        for effect in machine.effects:
            out += known_range(effect)
        return tuple(out)

    def intervals(self, six: Array) -> tuple[Array, Array]:
        """Return the lowest and highest shifts (m, 3); rapids to machine positions (G28, G53) do not move with the part."""
        path = self.job.path
        rewritable = np.array([m.rewritable for m in self.job.program.moves])[path.move]
        rewritable &= path.move != path.timing.moving[0]  # the way from where the machine happens to stand
        low, high = np.full(3, -np.inf), np.full(3, np.inf)
        for limit in self.limits:
            i = limit.direction
            if "XYZ"[i] not in path.axes:
                continue
            at = (path.axes["XYZ"[i]] if limit.of == "axis" else path.tip[:, i])[rewritable] - self.present[i]
            low[i], high[i] = max(low[i], limit.low - at.min()), min(high[i], limit.high - at.max())
        return np.tile(low, (len(six), 1)), np.tile(high, (len(six), 1))

    def feasible(self, poses: Array) -> np.typing.NDArray[np.bool_]:
        low, high = self.intervals(poses)
        return np.asarray(((poses[:, :3] >= low - EDGE) & (poses[:, :3] <= high + EDGE)).all(axis=1))


@dataclass(frozen=True, eq=False)
class CutDeviation:
    """The objective: values(poses (m, 6)) -> (m,), the smaller the better; deviations(poses) -> (m, C)."""

    model: LinearModel
    world: Cutting
    present: Array
    weights: Array  # (C,), already divided by half the tolerance
    unit: str = ""

    def values(self, poses: Array) -> Array:
        return np.abs(self.deviations(poses)) @ self.weights

    def deviations(self, poses: Array) -> Array:
        """Return the expected deviation of each characteristic from nominal (m, C), mm or rad; known errors, without scatter."""
        parts = [self._some(poses[i : i + BATCH]) for i in range(0, len(poses), BATCH)]
        return np.concatenate(parts) if parts else np.zeros((0, len(self.weights)))

    def _some(self, poses: Array) -> Array:
        m, tool = len(poses), self.world.tool
        many = _tile_run(tool.run, poses[:, :3] - self.present)
        jump = tool.run.n * np.arange(m)[:, None, None]
        setting = np.where(tool.setting >= 0, tool.setting + jump, -1).reshape(-1, 3)
        known_error = np.tile(tool.known_error, (m, 1))
        moved = (
            replace(tool, run=many, setting=setting, known_error=known_error)
            .errors()
            .reshape(m, tool.run.n, 3)
        )
        contacts = self.world.contacts
        height = contacts.surface(moved) - contacts.surface(self.world.tool_errors)
        q = self.model.q0 + height @ self.model.operator.T
        features = self.model.task.part.features
        nominal = np.array([gps.nominal(c, features) for c in self.model.characteristics])
        return np.asarray(self.model.values(q) - nominal)


def _tile_run(run: Run, shifts: Array) -> Run:
    """Return the run once per shift (m, 3), every axis moved by it."""
    m = len(shifts)
    position = {
        a: (v + shifts[:, "XYZ".index(a)][:, None]).ravel() if a in "XYZ" else np.tile(v, m)
        for a, v in run.position.items()
    }
    columns = {k: np.tile(v, m) for k, v in run.columns.items()}
    for i, c in enumerate("xyz"):
        columns[f"tip_{c}_mm"] = (run.columns[f"tip_{c}_mm"] + shifts[:, i][:, None]).ravel()
    labels = {k: np.tile(v, m) for k, v in run.labels.items()}
    return Run(position, np.tile(run.offset, (m, 1)), columns, labels, run.series)


@dataclass(frozen=True)
class AtPose:
    """A pose (6,), the objective, and the expected deviation of each characteristic (C,), mm or rad."""

    pose: Array
    value: float
    deviations: Array


@dataclass(frozen=True, eq=False)
class PlacedCut(Readable):
    """The outcome. before, after: the full results at the present and the best pose."""

    characteristics: tuple[Characteristic, ...]
    weights: dict[str, float]
    best: AtPose
    present: AtPose
    median: AtPose
    worst: AtPose
    certificate: Certificate
    map: Map
    region: Region
    evaluations: int
    before: CutResult
    after: CutResult
    seed: int
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        shift = ", ".join(f"{v:.1f}" for v in self.best.pose[:3])
        return f"<PlacedCut: best shift ({shift}) mm, gain {self.gain:.1%}>"

    @property
    def gain(self) -> float:
        """Share of the present value that the best pose saves."""
        return (self.present.value - self.best.value) / self.present.value if self.present.value else 0.0


def place_cut(
    scenario: CutScenario, *, seed: int | None = None, evaluations: int = EVALUATIONS, scanned: int = SCANNED,
    trials: int | None = None, progress: Progress | None = None,
) -> PlacedCut:  # fmt: skip
    """Find the shift of part and work offset with the smallest deviations. Raises ModelLimit where the program never fits."""
    report = progress or (lambda text, share: None)
    scenario.settings.with_changes(trials=trials, seed=seed)  # refused before the search, not after it
    seed = scenario.settings.seed if seed is None else seed
    report("reading and cutting the program", 0.0)
    job = set_up(scenario)
    if fixed := job.process.why_fixed(job):
        raise ModelLimit(fixed)
    if job.touched_zero is not None:
        raise ModelLimit(
            f"line {job.touched_zero.touches[0].line} of the program probes where the part lies, which the set-up states; shift [offsets] there and cut "
            "it at each place (vcmm cut)"
        )
    task, world, _ = finished_part(job)
    if scenario.inspection.kind == SAME_MACHINE:
        world = world.of_part()
    model = build(task, world)
    present = six_of(job.pose)
    weights = _weights(scenario, model.characteristics)
    scale = _scales(model)
    objective = CutDeviation(
        model, world, present[:3], np.array([weights[c.name] for c in model.characteristics]) / scale
    )
    box = _box(scenario, ProgramTravels(job, present[:3]), present)
    searched = search(objective, [box], evaluations=evaluations, seed=seed, progress=report)
    searched, last, earlier = scan_after(objective, [box], searched, scanned, seed, report)
    order = np.argsort(last.values, kind="stable")
    best = _at(objective, searched.pose)
    now = _at(objective, present)
    if now.value <= best.value:
        best = now
    report("cutting at the present and the best pose", 0.0)
    after = cut(_move_scenario(scenario, job, best.pose), seed=seed, trials=trials, progress=report)
    before = cut(scenario, seed=seed, trials=trials, progress=report)
    return PlacedCut(
        characteristics=model.characteristics,
        weights=weights,
        best=best,
        present=now,
        median=_at(objective, last.poses[order[len(order) // 2]]),
        worst=_at(objective, last.poses[order[-1]]),
        certificate=certify(objective, [box], best.pose, best.value, last, earlier),
        map=table_map(objective, searched),
        region=region(objective, searched, last.values, seed),
        evaluations=searched.evaluations,
        before=before,
        after=after,
        seed=seed,
    )


def _at(objective: CutDeviation, six: Array) -> AtPose:
    return AtPose(six, float(objective.values(six[None])[0]), objective.deviations(six[None])[0])


def _move_scenario(scenario: CutScenario, job: PreparedCut, six: Array) -> CutScenario:
    """Return the scenario with part and work offsets moved together."""
    by = six[:3] - job.pose.shift
    offsets = {n: _plus(o, by) for n, o in scenario.setup.offsets.items()}
    at = None if scenario.set_at is None else _plus(scenario.set_at, by)
    setup = replace(scenario.setup, offsets=offsets)
    return replace(scenario, setup=setup, pose=pose_of(six), set_at=at)


def _plus(point: tuple[float, float, float], by: Array) -> tuple[float, float, float]:
    return float(point[0] + by[0]), float(point[1] + by[1]), float(point[2] + by[2])


def _weights(scenario: CutScenario, characteristics: Sequence[Characteristic]) -> dict[str, float]:
    """Return the weights of the scenario, which sum to 1; else equal weights."""
    given = scenario.weights
    if not given:
        return {c.name: 1.0 / len(characteristics) for c in characteristics}
    total = sum(given.values())
    if abs(total - 1.0) > 1e-9 or min(given.values()) < 0:
        raise UsageError(f"[placement] weights must be positive and sum to 1; they sum to {total:g}")
    return {c.name: given.get(c.name, 0.0) for c in characteristics}


def _scales(model: LinearModel) -> Array:
    """Return half the tolerance of each characteristic; without limits 1 um or 1 urad."""
    out = []
    for c in model.characteristics:
        limits = gps.tolerance(c, gps.nominal(c, model.task.part.features))
        finite = limits is not None and np.isfinite(limits).all() and limits[1] > limits[0]
        one_sided = finite and gps.is_one_sided(c)
        out.append((limits[1] - limits[0]) / (1.0 if one_sided else 2.0) if finite and limits else 1e-3)
    return np.array(out)


def _box(scenario: CutScenario, travels: ProgramTravels, present: Array) -> PoseBox:
    fixture = scenario.fixture or Fixture((Freedom("x", -np.inf, np.inf), Freedom("y", -np.inf, np.inf)))
    turned = [f.name for f in fixture.freedoms if f.name.startswith("turn")]
    if turned or fixture.faces or fixture.slots:
        raise UsageError(
            f"[placement] {turned[0] if turned else 'slots and faces_down'}: a cut part can only be shifted, its program does "
            "not turn with it; give x, y or z"
        )
    (_, template), *more = fixture.orientations(present)
    if more:
        raise UsageError("[placement] of a cut part takes ranges, not lists of places")
    box = PoseBox("", template, fixture.continuous, travels)  # type: ignore[arg-type]
    middle = np.full((1, box.d), 0.5)
    if not box.poses(middle)[1].any():
        low, high = travels.intervals(template[None])
        room = ", ".join(f"{a} {lo:.6g} to {hi:.6g} mm" for a, lo, hi in zip("xyz", low[0], high[0]))
        raise ModelLimit(f"no shift of the fixture keeps the program within the travels; they allow {room}")
    return box
