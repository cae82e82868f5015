"""Confusion matrix of the diagnosis on recordings with concealed effects.

The recordings come from tests/learn/diagnosis/generator.py, which shares no line with vcmm/effects. Small by default:

    python benchmarks/bench_diagnose.py [--cases 2] [--delta 10] [--nulls 40] [--noise t6] [--design rich|poor] [--seed 1000]
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from collections import Counter
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.learn.diagnosis import generator as make
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.result import Diagnosis


def first(d: Diagnosis) -> str:
    """Name that stands first, "unknown" or "nothing"."""
    if d.answer:
        return d.answer[0].effect
    return "unknown" if d.unknown else "nothing"


def bound(hits: int, n: int) -> float:
    """One-sided 95 % upper bound of a rate (Clopper-Pearson)."""
    from scipy.stats import beta

    return float(beta.ppf(0.95, hits + 1, n - hits)) if hits < n else 1.0


def effects(args: argparse.Namespace, design: make.Design) -> None:
    """Right name first, truth in the set, interval coverage is left to the tests."""
    table: dict[str, Counter[str]] = {}
    right = inside = extra = total = 0
    sizes, took = [], []
    for name in args.names.split(",") if args.names else make.NAMES:
        table[name] = Counter()
        for k in range(args.cases):
            case = make.make(
                (name,), args.delta, args.seed + 97 * k + 7 * make.NAMES.index(name), design, args.noise
            )
            start = time.perf_counter()
            d = diagnose_recording(case.recording, make.machine(), 1, args.draws)
            took.append(time.perf_counter() - start)
            table[name][first(d)] += 1
            total += 1
            right += first(d) == name
            names = {a.effect for a in d.answer} | {r for a in d.answer for r in a.cannot_be_told_from}
            inside += name in names
            extra += max(len(d.answer) - 1, 0)
            sizes.append(len(names))
    for name, row in table.items():
        print(f"{name:20s} " + ", ".join(f"{k} {v}" for k, v in row.most_common()))
    print(
        f"delta {args.delta:g}: first {right}/{total} = {right / total:.3f}, in set {inside / total:.3f}, mean set "
        f"{np.mean(sizes):.2f}, extra terms {extra / total:.3f}, {np.median(took):.1f} s each"
    )


def nothing(args: argparse.Namespace, design: make.Design) -> None:
    """False alarms: a name where nothing is concealed, or "unknown"."""
    found: Counter[str] = Counter()
    for k in range(args.nulls):
        case = make.make((), 0.0, args.seed + 5000 + k, design, args.noise)
        found[first(diagnose_recording(case.recording, make.machine(), 1, args.draws))] += 1
    alarms = args.nulls - found["nothing"]
    print(
        f"nulls ({args.noise}): {dict(found)}; alarms {alarms}/{args.nulls}, 95 % bound {bound(alarms, args.nulls):.3f}"
    )


BINS = (0.0, 0.5, 0.8, 0.95, 0.99, 1.0 + 1e-9)


def reliability(args: argparse.Namespace) -> None:
    """Stated probability of the first name against how often it is right: deltas 4 to 10, rich and poor, and nothing.

    One case in four conceals nothing; a name given there is wrong. Printed with the 95 % interval of each share.
    """
    from scipy.stats import beta

    stated, right = [], []
    for k in range(args.reliability):
        name = make.NAMES[k % len(make.NAMES)]
        design = make.RICH if k % 3 else make.POOR
        hidden: tuple[str, ...] = () if k % 4 == 3 else (name,)
        case = make.make(hidden, (4.0, 5.0, 7.0, 10.0)[(k // 2) % 4], args.seed + 31 * k, design, args.noise)
        d = diagnose_recording(case.recording, make.machine(), 1, args.draws)
        for a in d.answer[:1]:
            stated.append(a.probability)
            right.append(a.effect in hidden)
        print(f"{k + 1}/{args.reliability}", file=sys.stderr, end="\r")
    print("stated probability   answers   mean stated   right   95 % interval")
    for low, high in itertools.pairwise(BINS):
        use = [(p, r) for p, r in zip(stated, right) if low <= p < high]
        if use:
            n, hits = len(use), sum(r for _, r in use)
            bounds = beta.ppf([0.025, 0.975], [hits, hits + 1], [n - hits + 1, n - hits])
            a, b = (bounds[0] if hits else 0.0), (bounds[1] if hits < n else 1.0)
            mean = np.mean([p for p, _ in use])
            print(
                f"{low:4.2f} to {min(high, 1):4.2f}   {n:9d}   {mean:11.3f}   {hits / n:5.2f}   {a:.2f} to {b:.2f}"
            )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("--cases", type=int, default=1)
    parser.add_argument("--delta", type=float, default=10.0)
    parser.add_argument("--nulls", type=int, default=20)
    parser.add_argument("--draws", type=int, default=2000)
    parser.add_argument("--noise", default="t6")
    parser.add_argument("--names", default="")
    parser.add_argument("--design", default="rich", choices=("rich", "poor"))
    parser.add_argument("--seed", type=int, default=1000)
    parser.add_argument("--reliability", type=int, default=0, help="number of cases of the reliability table")
    args = parser.parse_args()
    if args.reliability:
        reliability(args)
        return
    design = make.RICH if args.design == "rich" else make.POOR
    if args.cases:
        effects(args, design)
    if args.nulls:
        nothing(args, design)


if __name__ == "__main__":
    main()
