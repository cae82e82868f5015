"""Collapsed Monte Carlo against the two programs people write first, on one plan, in one run.

    python benchmarks/bench_montecarlo.py

Plan: 100 points on a plane, a circle, a cylinder and a sphere; outputs: their 15 fitted parameters. Uncertain:
18 error curves of 16 spline coefficients and 3 squareness angles (normal), a 4 x 4 x 4 grid of residual errors
(192 t-laws, nu = 4), 10 lobing harmonics, 8 thermal terms, repeatability of every point: 601 inputs.

    loop         per trial: draw, displace the points, four scipy.optimize.least_squares
    vectorised   numpy: all 601 raw inputs, one matrix product, one linear fit for all trials
    collapsed    vcmm.answer.evaluation.montecarlo.simulate: the same linear fit folded into a 15-row gain
    two threads  the same by two threads of one process, half of the trials each (kernels hold no interpreter lock), and beside it by
                 two processes, which share nothing: what they gain is what this computer has to give
    closed form  sqrt(diag(G S G^T)), and vcmm.answer.evaluation.interval for the exact coverage intervals

Rounds are interleaved and the best of each taken, since other work may share the processor; the ratios are the result.
"""

from __future__ import annotations

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one core for everybody

import math
import sys
import time
from collections.abc import Callable
from concurrent.futures import Executor, ProcessPoolExecutor, ThreadPoolExecutor
from functools import cache
from itertools import pairwise
from multiprocessing import get_context
from types import ModuleType

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline
from scipy.optimize import least_squares

from vcmm.answer.evaluation import streams
from vcmm.answer.evaluation.montecarlo import Accumulator, Term, marginal, simulate, uncertainty
from vcmm.core.laws import Normal, StudentT

Array = NDArray[np.float64]
TRAVEL = np.array([800.0, 1000.0, 600.0])
COEFFICIENTS, NODES, DOF = 16, 4, 4.0
CENTRES = {
    "circle": (300.0, 350.0, 250.0),
    "cylinder": (420.0, 380.0, 230.0),
    "sphere": (350.0, 520.0, 260.0),
}
BARS = {"collapsed / vectorised": 100.0, "collapsed / loop": 10_000.0}
THREADS_AIM = 1.8


def points() -> tuple[Array, Array, list[slice]]:
    """Nominal points (100, 3), outward normals (100, 3), rows of plane, circle, cylinder, sphere."""
    x, y = np.meshgrid(np.linspace(280, 480, 5), np.linspace(300, 560, 5))
    plane = np.stack([x.ravel(), y.ravel(), np.full(25, 200.0)], axis=1)
    sets, normals = [plane], [np.tile([0.0, 0.0, 1.0], (25, 1))]
    angle = np.arange(15) * 2 * math.pi / 15
    sets.append(CENTRES["circle"] + 25 * (n := np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)))
    normals.append(n)
    angle = np.arange(32) * 2 * math.pi / 8 + 0.1 * (np.arange(32) // 8)
    n = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    sets.append(CENTRES["cylinder"] + 20 * n + np.outer(np.repeat([-20, -7, 7, 20], 8), [0, 0, 1]))
    normals.append(n)
    polar, angle = np.repeat([0.1, 0.5, 0.9, 1.3], 7), np.arange(28) * 2 * math.pi / 7
    n = np.stack([np.sin(polar) * np.cos(angle), np.sin(polar) * np.sin(angle), np.cos(polar)], axis=1)
    sets.append(CENTRES["sphere"] + 15 * n)
    normals.append(n)
    ends = np.cumsum([0, *map(len, sets)])
    return np.concatenate(sets), np.concatenate(normals), [slice(a, b) for a, b in pairwise(ends)]


def curves(p: Array, n: Array) -> Array:
    """(100, 291): deviation along the normal per unit of spline coefficients (0.4 um, 0.8 urad) and squareness."""
    knots = np.concatenate([[0.0] * 3, np.linspace(0, 1, COEFFICIENTS - 2), [1.0] * 3])
    columns = []
    for axis in range(3):
        basis = BSpline.design_matrix(p[:, axis] / TRAVEL[axis], knots, 3).toarray()
        for k in range(3):
            columns.append(0.4e-3 * basis * n[:, k, None])
        for turn in np.eye(3):
            columns.append(0.8e-6 * basis * np.sum(np.cross(turn, p) * n, axis=1)[:, None])
    square = 1e-6 * np.stack([p[:, 1] * n[:, 0], p[:, 2] * n[:, 0], p[:, 2] * n[:, 1]], axis=1)
    return np.concatenate([*columns, square], axis=1)


def grid(p: Array, n: Array) -> Array:
    """(100, 192): trilinear shares of the 64 nodes in x, y, z, times the scale 0.5 um."""
    place = p / TRAVEL * (NODES - 1)
    hat = [np.clip(1 - np.abs(place[:, k, None] - np.arange(NODES)), 0, None) for k in range(3)]
    share = np.einsum("ni,nj,nk->nijk", *hat).reshape(len(p), -1)
    return np.concatenate([0.5e-3 * share * n[:, k, None] for k in range(3)], axis=1)


def rest(p: Array, n: Array) -> Array:
    """(100, 18): ten lobing harmonics (0.2 um), eight thermal terms (expansion and drift, 1 um per metre)."""
    angle = np.arctan2(n[:, 1], n[:, 0])[:, None]
    lateral = 0.2e-3 * np.hypot(n[:, 0], n[:, 1])[:, None]
    waves = [f(k * angle) * lateral for k in range(3, 8) for f in (np.cos, np.sin)]
    thermal = [
        1e-6 * p * n,
        0.5e-3 * n,
        np.stack([1e-9 * p[:, 0] ** 2, 1e-9 * p[:, 1] ** 2], axis=1) * n[:, 2:],
    ]
    return np.concatenate([*waves, *thermal], axis=1)


def jacobian(p: Array, n: Array, rows: list[slice]) -> Array:
    """(100, 15): change of the residual along the normal per unit of each fit parameter, block by feature."""
    j = np.zeros((len(p), 15))
    plane, circle, cylinder, sphere = rows
    j[plane, 0], j[plane, 1:3] = 1, p[plane, :2] - p[plane, :2].mean(axis=0)
    j[circle, 3:5], j[circle, 5] = n[circle, :2], 1
    z = p[cylinder, 2] - CENTRES["cylinder"][2]
    j[cylinder, 6:8], j[cylinder, 8:10], j[cylinder, 10] = n[cylinder, :2], z[:, None] * n[cylinder, :2], 1
    j[sphere, 11:14], j[sphere, 14] = n[sphere], 1
    return j


def exact_fit(q: Array, rows: list[slice]) -> Array:
    """The 15 parameters as departures from nominal, by four calls of scipy.optimize.least_squares."""
    plane, circle, cylinder, sphere = (q[r] for r in rows)
    mean = points()[0][rows[0], :2].mean(axis=0)

    def flat(v: Array) -> Array:
        return (plane[:, 2] - 200 - v[0] - (plane[:, :2] - mean) @ v[1:]) / math.sqrt(1 + v[1:] @ v[1:])

    def ring(v: Array) -> Array:
        return np.hypot(*(circle[:, :2] - CENTRES["circle"][:2] - v[:2]).T) - 25 - v[2]

    def tube(v: Array) -> Array:
        d = cylinder - CENTRES["cylinder"] - [v[0], v[1], 0]
        axis = np.array([v[2], v[3], 1]) / math.sqrt(1 + v[2] ** 2 + v[3] ** 2)
        return np.linalg.norm(np.cross(d, axis), axis=1) - 20 - v[4]

    def ball(v: Array) -> Array:
        return np.linalg.norm(sphere - CENTRES["sphere"] - v[:3], axis=1) - 15 - v[3]

    fits = ((flat, 3), (ring, 3), (tube, 5), (ball, 4))
    return np.concatenate([least_squares(f, np.zeros(k), x_scale="jac", xtol=1e-12).x for f, k in fits])


class Scenario:
    """The linear model of the plan and the three ways to sample it."""

    def __init__(self) -> None:
        self.p, self.n, self.rows = points()
        repeat = 0.3e-3 * np.eye(len(self.p))
        self.normal = np.concatenate([curves(self.p, self.n), rest(self.p, self.n), repeat], axis=1)
        self.heavy = grid(self.p, self.n)
        self.fit = np.linalg.pinv(jacobian(self.p, self.n, self.rows))
        self.rng = np.random.default_rng(1)

    @property
    def inputs(self) -> int:
        return self.normal.shape[1] + self.heavy.shape[1]

    def terms(self) -> list[Term]:
        """The model as vcmm sees it: a gain of 15 rows."""
        parts = [("machine", Normal(1.0), self.normal), ("grid", StudentT(1.0, DOF), self.heavy)]
        lanes = [np.stack([np.arange(a.shape[1]), np.zeros(a.shape[1])], axis=1) for _, _, a in parts]
        return [Term(name, law, self.fit @ a, lane) for (name, law, a), lane in zip(parts, lanes)]

    def loop(self, trials: int) -> Array:
        out = []
        for _ in range(trials):
            z = self.rng.standard_normal(self.normal.shape[1]), self.rng.standard_t(DOF, self.heavy.shape[1])
            deviation = self.normal @ z[0] + self.heavy @ z[1]
            out.append(exact_fit(self.p + self.n * deviation[:, None], self.rows))
        return np.array(out)

    def vectorised(self, trials: int) -> Array:
        z = self.rng.standard_normal((trials, self.normal.shape[1]))
        t = self.rng.standard_t(DOF, (trials, self.heavy.shape[1]))
        return (z @ self.normal.T + t @ self.heavy.T) @ self.fit.T

    def collapsed(self, trials: int, first: int = 0) -> Array:
        """Moments only, block by block: constant memory."""
        total, square = np.zeros(15), np.zeros(15)
        for block in simulate(np.zeros(15), self.terms(), seed=1, trials=trials, first=first):
            total += block.sum(axis=0)
            square += [column @ column for column in block.T]
        return np.sqrt(square / trials - (total / trials) ** 2)

    def streamed(self, trials: int) -> list[Accumulator]:
        """As `collapsed`, with a histogram of every output."""
        terms = self.terms()
        kept = [Accumulator(0.0, u) for u in uncertainty(terms)]
        for block in simulate(np.zeros(15), terms, seed=1, trials=trials):
            for k, one in enumerate(kept):
                one.add(block[:, k])
        return kept


@cache
def scenario() -> Scenario:
    """That of this process."""
    return Scenario()


def half(trials: int, first: int) -> float:
    """Seconds of the processor that these trials take this thread."""
    start = time.thread_time()
    scenario().collapsed(trials, first)
    return time.thread_time() - start


def two_at_once(trials: int = 1_000_000, rounds: int = 15) -> dict[str, tuple[float, float]]:
    """Gain of two threads and of two processes over one thread: (in seconds to wait, in those of the busier's processor).

    Rounds are interleaved and the best of each taken.
    """

    def shared(pool: Executor) -> float:
        return max(pool.map(half, (trials // 2, trials // 2), (0, trials // 2)))

    waits: dict[str, list[float]] = {"one": [], "threads": [], "processes": []}
    spent: dict[str, list[float]] = {name: [] for name in waits}
    with ThreadPoolExecutor(2) as threads, ProcessPoolExecutor(2, get_context("spawn")) as processes:
        jobs: dict[str, Callable[[], float]] = {
            "one": lambda: half(trials, 0),
            "threads": lambda: shared(threads),
            "processes": lambda: shared(processes),
        }
        for i in range(rounds + 1):  # the first loads what is needed
            for name, job in jobs.items():
                start = time.perf_counter()
                used = job()
                if i:
                    waits[name].append(time.perf_counter() - start)
                    spent[name].append(used)
    best = {name: (min(waits[name]), min(spent[name])) for name in waits}
    return {
        name: (best["one"][0] / best[name][0], best["one"][1] / best[name][1])
        for name in ("threads", "processes")
    }


def threads_told() -> bool:
    """Print what two threads gain beside two processes; whether that is what the computer has to give, or the aim."""
    gain = two_at_once()
    for name, (wait, used) in gain.items():
        print(f"  two {name:9s} against one: {wait:.2f} x to wait, {used:.2f} x of the processor")
    share = gain["threads"][0] / gain["processes"][0]
    print(f"  threads have {100 * share:.0f} % of what processes gain (aim {THREADS_AIM} x to wait)")
    return gain["threads"][0] >= THREADS_AIM or share >= 0.95


def seconds(run: Callable[[], object]) -> float:
    start = time.perf_counter()
    run()
    return time.perf_counter() - start


def rates_of(jobs: dict[str, tuple[Callable[[], object], int]], rounds: int) -> dict[str, float]:
    """Units per second of each job (function, units of work), rounds interleaved: the best round, others shared the processor."""
    rates: dict[str, list[float]] = {name: [] for name in jobs}
    for _ in range(rounds):
        for name, (run, units) in jobs.items():
            rates[name].append(units / seconds(run))
    return {name: max(rate) for name, rate in rates.items()}


def random_numbers() -> dict[str, float]:
    """t-distributed numbers per second (nu = 4): numpy's generator, and the stream with both backends."""
    shape, out = StudentT(1.0, DOF), np.empty((32, streams.BLOCK))
    lanes = np.stack([np.arange(32), np.zeros(32)], axis=1).astype(np.uint32)
    rng, fast = np.random.default_rng(1), streams.kernels(10**9)
    many = 20

    def stream(backend: ModuleType | None, blocks: int) -> None:
        for i in range(blocks):
            streams.standard(shape, lanes, lanes, i * streams.BLOCK, out, backend)

    jobs: dict[str, tuple[Callable[[], object], int]] = {
        "Generator.standard_t": (lambda: rng.standard_t(DOF, out.size), out.size),
        "Generator.standard_normal": (lambda: rng.standard_normal(out.size), out.size),
        "vcmm stream, numpy": (lambda: stream(None, 1), out.size),
    }
    if fast:
        jobs["vcmm stream, numba"] = (lambda: stream(fast, many), many * out.size)
    for run, _ in jobs.values():
        run()
    return rates_of(jobs, 15)


def main() -> int:
    plan = scenario()
    terms = plan.terms()
    acting = sum(np.count_nonzero(t.gain.any(axis=0)) for t in terms if isinstance(t.law, StudentT))
    print(f"{len(plan.p)} points, 15 outputs, {plan.inputs} inputs")
    print(f"of {plan.heavy.shape[1]} t-distributed ones {acting} act on an output")
    rates = random_numbers()
    print("\nt-distributed random numbers (nu = 4), one core")
    for name, rate in rates.items():
        print(f"  {name:28s} {rate / 1e6:9.1f} M/s {rate / rates['Generator.standard_t']:9.1f} x")

    plan.collapsed(1_000_000)  # compiles or loads the kernels
    speed = rates_of(
        {
            "loop": (lambda: plan.loop(20), 20),
            "vectorised": (lambda: plan.vectorised(4000), 4000),
            "collapsed": (lambda: plan.collapsed(1_000_000), 1_000_000),
            "collapsed, histograms": (lambda: plan.streamed(1_000_000), 1_000_000),
        },
        7,
    )
    print("\ntrials per second, one core")
    for name, rate in speed.items():
        print(f"  {name:28s} {rate:12.0f} {rate / speed['vectorised']:9.1f} x {rate / speed['loop']:11.0f} x")
    exact = min(seconds(lambda: [marginal(0.0, terms, k).interval() for k in range(15)]) for _ in range(5))
    print(f"  exact 95 % intervals of 15 outputs: {1e3 * exact:.1f} ms")
    print(f"\ntwo at once, at a load of {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")
    threads_told()
    return verdict(speed, rates, agreement(plan, terms))


def agreement(plan: Scenario, terms: list[Term]) -> bool:
    """u of every output by all ways, each within 5 of its standard errors of the closed form."""
    closed, loop, many = uncertainty(terms), 400, 40_000
    found = {
        "loop": (plan.loop(loop).std(axis=0), loop),
        "vectorised": (plan.vectorised(many).std(axis=0), many),
        "collapsed": (plan.collapsed(10**6), 10**6),
    }
    print("\nlargest departure of u from the closed form, in standard errors of u (about u / sqrt(2 trials))")
    good = True
    for name, (u, trials) in found.items():
        worst = float(np.max(np.abs(u / closed - 1) * math.sqrt(2 * trials)))
        good &= worst < 5
        print(f"  {name:28s} {worst:9.2f}")
    return good


def verdict(speed: dict[str, float], rates: dict[str, float], same: bool) -> int:
    ratios = {name: speed["collapsed"] / speed[name.split(" / ")[1]] for name in BARS}
    print()
    for name, bar in BARS.items():
        print(f"  {name:28s} {ratios[name]:9.0f} x, bar {bar:.0f} x")
    good = same and all(ratios[name] >= bar for name, bar in BARS.items())
    print("  same numbers" if same else "  DIFFERENT numbers")
    print("  good" if good else "  BELOW THE BAR")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
