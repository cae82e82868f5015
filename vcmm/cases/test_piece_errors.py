"""Which error shows in which feature: the test piece cut with one error of the machine at a time.

Numbers are those of the finished part: what each characteristic departs from nominal (form and orientation: its value),
and a scan of the circle with its second harmonics. Errors are so small that the table is linear in all but form.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.run import Array
from vcmm.papers.virtual_cut import SeenNet, departure, seen
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import Feature, normal, surface_point
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.lag import ServoLag
from vcmm.physics.catalogue.reversal import ReversalSpike
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.physics.structure.setting import ToolRadius
from vcmm.physics.structure.spindle_growth import SpindleGrowth
from vcmm.physics.structure.squareness import Squareness
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.maps import Net
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import PreparedCut
from vcmm.shop.machining.scenario import CutScenario
from vcmm.shop.machining.world import Cutting
from vcmm.task.measuring.task import Task, evaluate_all, fit_features, measured_points

UM, URAD = 1e-3, 1e-6
CIRCLE = ("circle, scan of 1°", "oval at 0°", "oval at 45°")


def bow(component: str, centre: float) -> ComponentPolynomial:
    """100 um/m2 (s - centre)^2, s in m: a straightness error without a slope in the middle of the part."""
    return ComponentPolynomial(component, 100 * UM * np.array([centre**2, -2 * centre, 1.0]))


SINGLE: tuple[tuple[str, Effect], ...] = (
    ("squareness of X and Y, C0Y 10 µrad", Squareness("C0Y", 10 * URAD)),
    ("squareness of X and Z, B0Z 10 µrad", Squareness("B0Z", 10 * URAD)),
    ("scale of X, 10 µm/m", ScaleFactor("X", 10 * UM / 1000)),
    ("scale of Y, 10 µm/m", ScaleFactor("Y", 10 * UM / 1000)),
    ("straightness EYX, bow 100 µm/m²", bow("EYX", 0.3)),
    ("straightness EXY, bow 100 µm/m²", bow("EXY", 0.25)),
    ("yaw ECX, 100 µrad/m from X = 0", ComponentPolynomial("ECX", np.array([0.0, 100 * URAD]))),
    ("backlash of X, 1 µm", Backlash("X", 1 * UM)),
    ("backlash of Y, 1 µm", Backlash("Y", 1 * UM)),
    ("reversal spike of X, 1 µm", ReversalSpike("X", 1 * UM)),
    ("reversal spike of Y, 1 µm", ReversalSpike("Y", 1 * UM)),
    ("lag of X, 0.1 ms", ServoLag("X", 1e-4)),
    ("lag of Y, 0.1 ms", ServoLag("Y", 1e-4)),
    ("spindle growth, 10 µm", SpindleGrowth("Z", 10 * UM)),
    ("cutter too large, 1 µm in radius", ToolRadius("1", 1 * UM)),
)


@dataclass(frozen=True, eq=False)
class PieceTwin:
    """um (errors, features): rows as `errors`, columns as `features`; circle (errors, angles) departures of the circle."""

    errors: tuple[str, ...]
    features: tuple[str, ...]
    um: Array
    angle: Array
    circle: Array


@dataclass(frozen=True, eq=False)
class Ready:
    """The piece cut once: what follows is one evaluation per machine."""

    job: PreparedCut
    task: Task
    world: Cutting
    circle: SeenNet


def prepared(scenario: CutScenario) -> Ready:
    """Program read, tools swept, inspection points and the circle looked at."""
    job = set_up(scenario)
    task, world, _ = finished_part(job)
    return Ready(job, task, world, seen(job, scan(scenario.part.features["circle"])))


def scan(feature: Feature) -> Net:
    """361 points round the middle of a cylinder."""
    angle, height = np.radians(np.arange(361.0)), np.array([feature.extent[0] / 2])
    points = surface_point(feature, angle, height)
    return Net(
        feature.name, points, normal(feature, points), angle, height, ("angle / deg", "along the axis / mm")
    )


def row(ready: Ready, effects: Sequence[Effect]) -> tuple[Array, Array]:
    """(deviation (um) of each characteristic and of CIRCLE, departure of the circle (angles,) um) with these errors alone."""
    machine = replace(ready.job.machine, effects=tuple(effects), inputs=())
    world = replace(ready.world, tool=replace(ready.world.tool, machine=machine, inputs=()))
    found = evaluate_all(ready.task, fit_features(ready.task, measured_points(ready.task, world.errors())))
    features = ready.task.part.features
    nominal = np.array([float(gps.nominal(c, features)) for c in ready.task.part.characteristics])
    circle = departure(ready.circle, machine)
    return np.append(found - nominal, harmonics(ready.circle.net.first, circle)) / UM, circle / UM


def harmonics(angle: Array, height: Array) -> Array:
    """Peak to valley, amplitudes of cos 2a and sin 2a (3,) of heights over a full turn whose last angle repeats the first.

    The part of a shifted circle (first harmonic) is taken off before the peak to valley.
    """
    a, h = angle[:-1], height[:-1]
    waves = [(2 * np.mean(h * np.cos(k * a)), 2 * np.mean(h * np.sin(k * a))) for k in (1, 2)]
    centred = h - waves[0][0] * np.cos(a) - waves[0][1] * np.sin(a)
    return np.array([np.ptp(centred), *waves[1]])


def run(scenario: CutScenario, progress: Callable[[str, float], None] | None = None) -> PieceTwin:
    """The table. Columns are the characteristics of the scenario and CIRCLE."""
    report = progress or (lambda text, share: None)
    report("cutting", 0.0)
    ready = prepared(scenario)
    empty, _ = row(ready, ())
    rows, circles = [], []
    for number, (name, effect) in enumerate(SINGLE):
        report(name, (number + 1) / (len(SINGLE) + 1))
        values, circle = row(ready, (effect,))
        rows.append(values - empty)
        circles.append(circle)
    names = tuple(c.name for c in scenario.part.characteristics)
    errors = tuple(name for name, _ in SINGLE)
    return PieceTwin(errors, (*names, *CIRCLE), np.array(rows), ready.circle.net.first, np.array(circles))


def figures(result: PieceTwin) -> dict[str, object]:
    """Plain numbers for JSON."""
    return {
        "errors": list(result.errors),
        "features": list(result.features),
        "deviation_um": result.um.tolist(),
    }
