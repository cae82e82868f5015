"""How often the 95 % bands of a calibration hold the truth, and what is left of a compensated machine beside an oracle.

    python tools/calibrate_oracle.py 200 [laser|tracer]

Drawn machines, two complete designs. Left over: rms of the tip error over the volume, a placement of the part fitted, of the
machine less what was found; the oracle knows of every curve the size and correlation length that it was drawn with.
"""

from __future__ import annotations

import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from tests.learn.calibration.drawn import TRAVEL, bare, draw, laser_and_plates, recorded, tracers, truth
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.learn.calibration.evidence import append_identity
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.model import ErrorModel
from vcmm.learn.calibration.prior import widest_pairs
from vcmm.learn.calibration.result import Calibration
from vcmm.learn.calibration.solve import condition_on_prior

DESIGNS = {"laser": laser_and_plates, "tracer": tracers}
PLACES = 400  # of the tip, in the volume


def drawn_with(seed: list[int]) -> dict[str, tuple[float, float]]:
    """Component -> size and correlation length as `draw` takes them from the same seed."""
    rng, out = np.random.default_rng(seed), {}
    for axis in TRAVEL:
        for kind in "XYZABC":
            size = rng.uniform(2e-6, 10e-6) if kind in "ABC" else rng.uniform(1e-3, 5e-3)
            out[f"E{kind}{axis}"] = (size, rng.uniform(100.0, 250.0))
            rng.standard_normal(61)
    return out


def oracle(found: Calibration, known: dict[str, tuple[float, float]]) -> Array:
    """theta (size,) by the readings of a calibration under the law that the curves were drawn from."""
    model, told = found.posterior.model, found.posterior.information
    factor = np.zeros((model.size, 0))
    for curve in model.curves:
        size, length = known[curve.component]
        gap = curve.nodes[:, None] - curve.nodes
        kernel = curve.free.T @ (size**2 * np.exp(-((gap / length) ** 2) / 2)) @ curve.free
        kernel += 1e-9 * np.trace(kernel) * np.eye(len(kernel))
        block = np.zeros((model.size, len(kernel)))
        block[model.slices[curve.component]] = curve.free @ np.linalg.cholesky(kernel)
        factor = np.concatenate([factor, block], axis=1)
    pairs = np.zeros((model.size, len(model.pairs)))
    for k, pair in enumerate(model.pairs):
        pairs[model.slices[pair], k] = widest_pairs(model)[k]
    whole = append_identity(np.concatenate([factor, pairs], axis=1), len(told.b))
    return condition_on_prior(told, whole)[0][: model.size]


def left_over(machine: Machine, model: ErrorModel, theta: Array, rng: np.random.Generator) -> float:
    """rms (mm) over the volume of the tip errors that a compensation by theta leaves, a rigid motion of the part taken out."""
    position = {a: rng.uniform(low, high, PLACES) for a, (low, high) in TRAVEL.items()}
    run = Run(position, np.tile([0.0, 0.0, -100.0], (PLACES, 1)))
    away = machine.tip_error(run) - bare().with_effect(*model.effects(theta)).tip_error(run)
    tip = np.stack([position[a] for a in "XYZ"], axis=1) - tip_middle()
    turns = [np.cross(axis, tip).ravel() for axis in np.eye(3)]
    rigid = np.concatenate([np.tile(np.eye(3), (PLACES, 1)), np.stack(turns, axis=1)], axis=1)
    rest = away.ravel() - rigid @ np.linalg.lstsq(rigid, away.ravel(), rcond=None)[0]
    return float(np.sqrt((rest**2).sum() / PLACES))


def tip_middle() -> Array:
    return np.array([(low + high) / 2 for low, high in TRAVEL.values()])


def main(machines: int, design: str) -> None:
    inside: dict[str, list[float]] = defaultdict(list)
    ours, best, raw = [], [], []
    for number in range(machines):
        seed = [number, len(design)]
        rng = np.random.default_rng(seed)
        machine = draw(rng)
        found = calibrate(recorded(machine, DESIGNS[design](bare()), rng), bare())
        model, post = found.posterior.model, found.posterior
        for theta, out in (
            (post.theta, ours),
            (oracle(found, drawn_with(seed)), best),
            (0 * post.theta, raw),
        ):
            out.append(left_over(machine, model, theta, np.random.default_rng([number, 99])))
        for curve in found.kept_model.curves:
            nodes, value, u = found.band(curve.component)
            inside[curve.component].append(
                float((np.abs(value - truth(machine, curve.component, nodes)) < 1.96 * u).mean())
            )
    for name, shares in inside.items():
        print(f"{name} {np.mean(shares):.3f}")
    pooled = np.array(list(inside.values()))
    error = pooled.mean(axis=0).std(ddof=1) / np.sqrt(machines)
    print(f"{design}: pooled over {machines} machines {pooled.mean():.4f} +- {error:.4f}")
    a, b, c = (1e3 * float(np.sqrt(np.mean(np.square(x)))) for x in (ours, best, raw))
    ratios = np.array(ours) / np.array(best)
    print(
        f"tip error over the volume {c:.2f} um, compensated {a:.3f} um, by the oracle {b:.3f} um: {a / b:.3f} times"
    )
    print(f"largest ratio of a machine {ratios.max():.2f}, 90 % of them below {np.quantile(ratios, 0.9):.2f}")
    if abs(pooled.mean() - 0.95) > 0.02 + 3 * error:
        sys.exit(f"{design}: the 95 % bands hold {pooled.mean():.1%} of the truth")
    if a > 1.2 * b:
        sys.exit(f"{design}: {a / b:.2f} times what the oracle leaves")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200, sys.argv[2] if len(sys.argv) > 2 else "laser")
