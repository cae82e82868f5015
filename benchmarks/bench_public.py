"""The public API against the programs people use for Monte Carlo, on one task in one run.

    python benchmarks/bench_public.py [--python PEERS/bin/python] [--trials 100000]

Task: the radius of a 25-point circle with 28 normal inputs: a common scale factor, two coordinates of the centre, and one radial
error per touch. Closed form beside it. Peers run in an environment of their own (--python), which has numpy and any of suncal,
openturns, astropy, punpy, metrolopy, mcerp; one that is not there is said to be missing. Seconds of the processor, median of rounds.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
import subprocess
import sys
import time
from collections.abc import Callable

R, POINTS = 25.0, 25
U_SCALE, U_CENTRE, U_TOUCH = 1e-6, 1e-3, 0.4e-3  # 1, mm, mm
BARS = {"numpy": 7, "suncal": 10, "astropy": 10, "openturns": 20, "punpy": 70, "metrolopy": 400, "mcerp": 60}
SCENARIO = """vcmm = "scenario/1"
[machine]
name = "CMM"
structure = "w b Y X Z t"
[machine.axes.X]
travel = ["0 mm", "600 mm"]
[machine.axes.Y]
travel = ["0 mm", "500 mm"]
[machine.axes.Z]
travel = ["-400 mm", "0 mm"]
[machine.repeatability]
law = "normal"
u = "0.4 um"
[[machine.effects]]
effect = "scale_factor"
axis = "X"
k = "0 um/m"
[[machine.inputs]]
effect = "scale_factor"
axis = "X"
parameter = "k"
u = "1 um/m"
[pose]
shift = "300 250 -200 mm"
[part.features]
ring = { type = "circle", point = "0 0 10 mm", axis = [0, 0, 1], diameter = "50 mm", inside = true }
[[part.characteristics]]
name = "diameter"
type = "size"
of = "ring"
[plan]
styli.down = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
[[plan.steps]]
feature = "ring"
stylus = "down"
points = { strategy = "even", n = 25 }
"""
PEERS = r'''
import json, math, statistics, sys, time
import numpy as np
R, N, US, UC, UT = 25.0, 25, 1e-6, 1e-3, 0.4e-3
trials = int(sys.argv[1])
turn = 2 * math.pi * np.arange(N) / N
C, S = np.cos(turn), np.sin(turn)
A = np.linalg.pinv(np.stack([2 * R * C, 2 * R * S, np.ones(N)], axis=1))

def radius(scale, cx, cy, *touch):
    """Kasa fit of points whose radii are known but for their errors; arrays or numbers."""
    d = np.stack(np.broadcast_arrays(*touch), axis=-1)
    x, y = (1 + np.asarray(scale)[..., None]) * (R + d) * C + np.asarray(cx)[..., None], (R + d) * S + np.asarray(cy)[..., None]
    z = x * x + y * y
    B = np.linalg.pinv(np.stack([2 * R * C, 2 * R * S, np.ones(N)], axis=1))
    p = z @ B.T
    return np.sqrt(p[..., 2] + p[..., 0] ** 2 + p[..., 1] ** 2)

SIZES = [US, UC, UC] + [UT] * N

def with_numpy():
    rng = np.random.default_rng(0)
    out = radius(*(rng.standard_normal(trials) * s for s in SIZES))
    return out.std(), np.quantile(out, [0.025, 0.975])

def with_astropy():
    from astropy import uncertainty as unc
    draws = [unc.normal(0.0, std=s, n_samples=trials).distribution for s in SIZES]
    return (radius(*draws).std(),)

def with_openturns():
    import openturns as ot
    joint = (ot.JointDistribution if hasattr(ot, "JointDistribution") else ot.ComposedDistribution)([ot.Normal(0.0, s) for s in SIZES])
    f = ot.PythonFunction(len(SIZES), 1, func_sample=lambda x: radius(*np.asarray(x).T)[:, None])
    y = ot.CompositeRandomVector(f, ot.RandomVector(joint)).getSample(trials)
    return (y.computeStandardDeviation()[0],)

def with_suncal():
    import suncal
    names = ["scale", "cx", "cy"] + [f"t{i}" for i in range(N)]
    code = "def f(" + ", ".join(names) + "): return radius(" + ", ".join(names) + ")"
    space = {"radius": radius}
    exec(code, space)
    from suncal.uncertainty import ModelCallable
    model = ModelCallable(space["f"])
    for n, s in zip(names, SIZES):
        model.var(n).measure(0.0).typeb(std=s)
    return (float(list(model.monte_carlo(samples=trials).uncertainty.values())[0]),)

def with_punpy():
    import punpy
    prop = punpy.MCPropagation(trials)
    return (float(prop.propagate_random(radius, [np.array(0.0)] * len(SIZES), [np.array(s) for s in SIZES])),)

def with_metrolopy():
    import metrolopy as uc
    g = [uc.gummy(0.0, u=s) for s in SIZES]
    x = [((1 + g[0]) * (R + t) * float(c) + g[1]) for t, c in zip(g[3:], C)]
    w = [((R + t) * float(s) + g[2]) for t, s in zip(g[3:], S)]
    q = [a * a + b * b for a, b in zip(x, w)]
    p = [sum(float(k) * v for k, v in zip(row, q)) for row in A]
    y = uc.sqrt(p[2] + p[0] ** 2 + p[1] ** 2)
    y.sim(n=trials)
    return (float(y.usim),)

def with_mcerp():
    import mcerp
    mcerp.npts = trials
    g = [mcerp.N(0.0, s) for s in SIZES]
    x = [((1 + g[0]) * (R + t) * float(c) + g[1]) for t, c in zip(g[3:], C)]
    w = [((R + t) * float(s) + g[2]) for t, s in zip(g[3:], S)]
    q = [a * a + b * b for a, b in zip(x, w)]
    p = [sum(float(k) * v for k, v in zip(row, q)) for row in A]
    y = mcerp.umath.sqrt(p[2] + p[0] ** 2 + p[1] ** 2)
    return (y.std,)

out = {}
for name in sys.argv[2].split(","):
    try:
        work = globals()["with_" + name]
        work()
        rounds = []
        for _ in range(3):
            start = time.process_time(); u = float(work()[0]); rounds.append(time.process_time() - start)
        out[name] = [statistics.median(rounds), u]
    except Exception as error:
        out[name] = f"{type(error).__name__}: {error}"[:120]
print(json.dumps(out))
'''


def timed(work: Callable[[], object], rounds: int = 25) -> float:
    found = []
    for _ in range(rounds):
        start = time.process_time()
        work()
        found.append(time.process_time() - start)
    return statistics.median(found)


def ours(trials: int) -> tuple[float, float, float]:
    """Seconds of a call, seconds where all outputs are sampled, u of the radius in mm."""
    import tempfile
    from pathlib import Path

    import vcmm

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ring.toml"
        path.write_text(SCENARIO)
        scenario = vcmm.load_scenario(path)
    found = vcmm.uncertainty(scenario, trials=trials, engine="montecarlo")
    auto = timed(lambda: vcmm.uncertainty(scenario, trials=trials))
    sampled = timed(lambda: vcmm.uncertainty(scenario, trials=trials, engine="montecarlo"))
    return auto, sampled, found.characteristics[0].u / 2


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--python", default=sys.executable, help="of the environment with the peers")
    parser.add_argument("--trials", type=int, default=100_000)
    parser.add_argument("--only", default=",".join(BARS), help="peers that are asked")
    given = parser.parse_args()
    auto, sampled, u = ours(given.trials)
    asked = [given.python, "-c", PEERS, str(given.trials), given.only]
    done = subprocess.run(asked, capture_output=True, text=True, check=True)
    peers = json.loads(done.stdout)
    closed = math.hypot(U_TOUCH / math.sqrt(POINTS), R * U_SCALE / 2)
    print(f"u of the radius: closed form {closed * 1e6:.2f} nm, vcmm {u * 1e6:.2f} nm")
    print("| tool | s | u nm | x vcmm | x vcmm, all sampled | bar |\n|---|---|---|---|---|---|")
    print(
        f"| vcmm | {auto:.4f} | {u * 1e6:.2f} | 1 | | |\n| vcmm, all sampled | {sampled:.4f} | {u * 1e6:.2f} | | 1 | |"
    )
    for name in given.only.split(","):
        one, bar = peers[name], BARS[name]
        if isinstance(one, str):
            print(f"| {name} | not timed: {one} | | | | {bar} |")
        else:
            print(
                f"| {name} | {one[0]:.4f} | {one[1] * 1e6:.2f} | {one[0] / auto:.1f} | {one[0] / sampled:.1f} | {bar} |"
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
