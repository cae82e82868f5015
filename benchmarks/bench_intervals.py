"""Do the 95 % intervals of lags, moments and periods hold the truth? One name in 150 rows of white noise, its own template.

    python -m benchmarks.bench_intervals --cases 250 --delta 7

The value is drawn evenly (lags and periods in the logarithm), the size so that delta is what is asked for; the name is searched
for by itself, at its true place. What mechanisms that are no template add to the errors is counted by the exam (docs/exam.md).
"""

from __future__ import annotations

import argparse
from dataclasses import replace

import numpy as np

from tests.learn.diagnosis import generator as make
from vcmm.learn.diagnosis.candidates import Family, build_catalogue
from vcmm.learn.diagnosis.estimates import draw_term
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.learn.diagnosis.refine import MOMENTS, Refiner, at_value, scanned_names
from vcmm.learn.diagnosis.select import Setting, select
from vcmm.learn.diagnosis.sharpen import sharpen

ROWS, DRAWS, THRESHOLD, CLIP = 150, 800, 3.5, 3.0
ASKED = {  # name of the parameter -> effect, range
    "tau": ("thermal_drift", 300.0, 9000.0),
    "t1": ("step_change", 3000.0, 25000.0),
    "period": ("screw_pitch", 12.0, 60.0),
}


def one_case(
    parameter: str, families: list[Family], problem: Problem, delta: float, rng: np.random.Generator
) -> float | None:
    """Share of the posterior below the truth; None where the name is not found, or with other values to be scanned."""
    _, low, high = ASKED[parameter]
    family = families[rng.integers(len(families))]
    options = [o for o in family.options if scanned_names(o) == [parameter]]
    if not options:
        return None
    even = parameter in MOMENTS
    true = rng.uniform(low, high) if even else float(np.exp(rng.uniform(np.log(low), np.log(high))))
    option = at_value(options[rng.integers(len(options))], parameter, true, problem)
    if option is None:
        return None
    white = problem.whitener()
    signal = option.columns @ rng.standard_normal(option.columns.shape[1])
    signal *= delta / float(np.linalg.norm(white.apply(signal)))
    made = replace(problem, residual=signal + problem.u * rng.standard_normal(problem.m))
    raw, refine = white.apply(made.residual), Refiner(made, white)
    setting = Setting(dictionary([family], white), white, raw, CLIP, THRESHOLD, refine)
    found = select(sharpen(setting, select(setting)))
    if not found.terms or scanned_names(found.terms[0].option) != [parameter]:
        return None
    return float(np.mean(draw_term(made, found, 0, refine, rng, DRAWS).values[parameter] < true))


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=100, help="per parameter")
    parser.add_argument("--delta", type=float, default=7.0)
    parser.add_argument("--seed", type=int, default=1)
    a = parser.parse_args()
    case = make.make(("thermal_drift",), a.delta, 5, replace(make.RICH, n=ROWS))
    problem = make_problem(case.recording, make.machine())
    every = build_catalogue(problem).families
    for number, (parameter, (name, *_)) in enumerate(ASKED.items()):
        rng = np.random.default_rng([a.seed, number])
        families = [f for f in every if f.name == name]
        shares = [one_case(parameter, families, problem, a.delta, rng) for _ in range(a.cases)]
        below = np.array([s for s in shares if s is not None])
        inside = int(np.sum((below > 0.025) & (below < 0.975)))
        print(
            f"{parameter}: {inside} of {len(below)} inside, {np.sum(below <= 0.025)} above, {np.sum(below >= 0.975)} below"
        )


if __name__ == "__main__":
    main()
