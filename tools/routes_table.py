"""Count the routes on drawn machines: how often the true value is within U of each, and how often E_n says that they agree.

    python tools/routes_table.py 60
    python tools/routes_table.py --shared      what the machine leaves in the mean of the positions, and in the model

Writes nothing; prints the table of docs/routes.md.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.linear import build
from vcmm.answer.routes import hidden_machine
from vcmm.answer.routes.job import routes
from vcmm.answer.routes.positions import LENGTH, PER_TIP, RING, StandardReadings, corrections
from vcmm.core.laws import Law
from vcmm.core.run import Array
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import normal
from vcmm.physics.structure.expansion import PartExpansion
from vcmm.task.measuring.plan import Step
from vcmm.task.measuring.task import Task

SCENARIOS = ("ring_gauge", "plate", "certificate")


def counted(name: str, machines: int) -> list[str]:
    """Rows of one scenario: characteristic, share held by every route, share of agreement of every pair."""
    scenario = load_scenario(example(name))
    held: dict[str, dict[str, list[bool]]] = defaultdict(lambda: defaultdict(list))
    for seed in range(machines):
        found = routes(scenario, settings=replace(scenario.settings, trials=2000, seed=seed))
        for c in found.characteristics:
            for r in c.routes:
                held[c.name][r.route].append(abs(c.error(r) or 0.0) <= 1)
            for a in c.agreements:
                held[c.name][f"{a.first} - {a.second}"].append(a.agrees)
    return [
        f"| {name}: {c} | " + " | ".join(f"{sum(v)}" for v in shares.values()) + " |"
        for c, shares in held.items()
        if len(shares) > 1
    ]


Lanes = dict[
    tuple[str, str, int], Array
]  # (Input, copy, element): change of every characteristic per standard uncertainty


def lanes(task: Task) -> Lanes:
    """Of the errors that stay with the machine."""
    model = build(task)
    out: Lanes = {}
    gradient = model.gradient()
    for f in model.influences:
        if hidden_machine.anew(f.input) or f.input.effect == PartExpansion.name:
            continue
        law, factor = f.input.spread(f.response.shape[2])
        factor = factor * law.u if isinstance(law, Law) else np.linalg.cholesky(law.covariance)
        for copy, label in enumerate(f.copies):
            rows = np.flatnonzero(f.codes == copy)
            gain = gradient @ model.operator[:, rows] @ model.along_normal(f)[rows] @ factor
            out |= {(f.input.id, label, k): gain[:, k] for k in range(gain.shape[1])}
    return out


def shared(name: str) -> list[str]:
    """Per characteristic: u of the machine's part in the model and in the positions, um, and their correlation."""
    scenario = load_scenario(example(name))
    features = scenario.part.features
    smooth = tuple(c for c in scenario.part.characteristics if gps.is_linear(c, features))
    scenario = replace(scenario, part=replace(scenario.part, characteristics=smooth))
    places = hidden_machine.usable_positions(scenario)
    found = [lanes(scenario.at(p).task()) for p in places.values()]
    keys = sorted(set().union(*found))
    each = np.array([[one.get(k, np.zeros(len(smooth))) for k in keys] for one in found])
    rings = [
        (
            hidden_machine._ring(hidden_machine.RING_DIAMETER),
            RING,
            hidden_machine.RING_DIAMETER,
            hidden_machine.U_RING,
        )
    ]
    length = max(
        [hidden_machine.SHORTEST_STANDARD, *(abs(f.extent[0]) for f in features.values() if f.extent)]
    )
    u = hidden_machine.U_LENGTH + hidden_machine.U_PER_LENGTH * length
    gauges = [(hidden_machine._length_standard(length, way), LENGTH, length, u) for way in np.eye(3)[:2]]
    errors, standards = [], []
    for (part, touched), kind, size, u_size in gauges + rings:
        stylus = scenario.plan.steps[0].stylus
        steps = tuple(Step(n, stylus, p, normal(part.features[n], p)) for n, p in touched)
        job = replace(scenario, part=part, plan=replace(scenario.plan, steps=steps, alignment=None), forms={})
        seen = [lanes(job.at(p).task()) for p in places.values() if hidden_machine._within_reach(job.at(p))]
        errors.append(np.mean([[float(one.get(k, [0.0])[0]) for k in keys] for one in seen], axis=0))
        standards.append(StandardReadings(kind, size, u_size, np.array([size])))
    design = np.array([[s.calibrated, PER_TIP[s.kind]] for s in standards])
    weights = np.array([1.0 / s.u**2 for s in standards])
    taken = corrections(standards).covariance @ (design.T * weights) @ np.array(errors)
    left = each.mean(axis=0) - (hidden_machine.shows(scenario.task()) @ taken).T
    rows = []
    for i, c in enumerate(smooth):
        model, positions = each[0][:, i], left[:, i]
        us = float(np.linalg.norm(model)), float(np.linalg.norm(positions))
        rows.append(
            f"| {name}: {c.name} | {1e3 * us[0]:.3f} um | {1e3 * us[1]:.3f} um | {model @ positions / max(us[0] * us[1], 1e-15):+.2f} |"
        )
    return rows


if __name__ == "__main__":
    if "--shared" in sys.argv:
        print("| task | machine in the model | machine in the positions | correlation |\n|---|---|---|---|")
        for one in (*SCENARIOS, "gaska2014"):
            print("\n".join(shared(one)), flush=True)
        sys.exit()
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 60
    print(
        "| task | model | calibrated part | positions | E_n model - part | model - positions | part - positions |"
    )
    print("|---|---|---|---|---|---|---|")
    for one in SCENARIOS:
        print("\n".join(counted(one, count)), flush=True)
