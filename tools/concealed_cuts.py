"""Concealed cutting effects: does `vcmm diagnose` name what is wrong with the machine from a part that came back measured?

    python tools/concealed_cuts.py              64 concealed cases at delta 10 and 60 parts as predicted: the table of docs/cut.md
    python tools/concealed_cuts.py --cases 6 --nulls 0 --only wear

Each case draws what the machine file says is uncertain, adds one effect by a formula of its own (nothing of vcmm/physics is asked),
draws some points of every feature with their scatter, and goes the way of a user: `measured_cut`, the recording written and
read back, `diagnose`. delta: norm of the departure in units of everything that is uncertain, alignment and zeros taken out.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np

import vcmm
from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.answer.inference.given_points import GivenPoints
from vcmm.core.run import Array, Run
from vcmm.files.columns import run_columns
from vcmm.files.own.library import example as example
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.shop.machining.cut_world import Cutting
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.measured_part import MeasuredCut, known_columns, measured_cut
from vcmm.shop.machining.part_recording import part_recording
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import PreparedCut

DELTA = 10.0
NOISE = 0.3e-3  # mm, of a measured point
OF_PLANE, OF_BORE = 8, 14  # points of a feature


def _moved(run: Run, x: Array | float = 0.0, y: Array | float = 0.0, z: Array | float = 0.0) -> Array:
    return np.stack(np.broadcast_arrays(x, y, z, np.zeros(run.n))[:3], axis=1)


def deflection(run: Run, rng: np.random.Generator) -> Array:
    """The tool is pushed away in proportion to the force on it."""
    return np.column_stack([run.columns[f"force_{c}_N"] for c in "xyz"]) / 100.0


def wear(run: Run, rng: np.random.Generator) -> Array:
    """Tool 1 is smaller by so much per metre that it has cut; floors do not feel it."""
    return run.normal * (_uses(run, "1") * run.columns["cut_length_mm"] / 1e3)[:, None] * _side(run)


def runout(run: Run, rng: np.random.Generator) -> Array:
    """Tool 2 turns about an axis beside its own: its longest tooth cuts a larger circle."""
    return -run.normal * _uses(run, "2")[:, None] * _side(run)


def wrong_radius(run: Run, rng: np.random.Generator) -> Array:
    """Tool 1 is larger than its table entry."""
    return -run.normal * _uses(run, "1")[:, None] * _side(run)


def servo_lag(run: Run, rng: np.random.Generator) -> Array:
    """One axis follows later than the other."""
    axis = "XY"[rng.integers(2)]
    late = -run.columns[f"speed_{axis}_mm_s"]
    return _moved(run, **{axis.lower(): late})


def thermal_growth(run: Run, rng: np.random.Generator) -> Array:
    """The spindle pushes the tool down while it warms up."""
    tau = rng.uniform(300.0, 1200.0)
    return _moved(run, z=-(1.0 - np.exp(-run.columns["time_s"] / tau)))


def clamping(run: Run, rng: np.random.Generator) -> Array:
    """Held in a vice along X or Y the block was bent; free, its floors are so again."""
    c = "xy"[rng.integers(2)]
    u = run.columns[f"part_{c}_mm"] / 75.0
    return _moved(run, z=rng.choice([-1.0, 1.0]) * 0.5 * (3 * u * u - 1))


def not_in_the_catalogue(run: Run, rng: np.random.Generator) -> Array:
    """A pump shakes the column: every 25 s to and fro."""
    wave = np.sin(2 * np.pi * run.columns["time_s"] / 25.0 + rng.uniform(0, 2 * np.pi))
    return _moved(run, x=0.6 * wave, y=0.8 * wave)


def _uses(run: Run, tool: str) -> Array:
    return (run.labels["tool"] == tool).astype(float)


def _side(run: Run) -> Array:
    return np.hypot(run.columns["nx"], run.columns["ny"])[:, None]


@dataclass(frozen=True)
class Effect:
    build: Callable[[Run, np.random.Generator], Array]
    names: tuple[str, ...]  # that are right; "" = no name, but an unknown


EFFECTS = {
    "deflection": Effect(deflection, ("tool_deflection",)),
    "wear": Effect(wear, ("tool_wear",)),
    "runout": Effect(runout, ("tool_runout", "tool_radius")),
    "servo lag": Effect(servo_lag, ("servo_lag",)),
    "thermal growth": Effect(thermal_growth, ("spindle_growth",)),
    "wrong tool radius": Effect(wrong_radius, ("tool_radius", "tool_runout")),
    "clamping": Effect(clamping, ("clamping",)),
    "unknown": Effect(not_in_the_catalogue, ("",)),
}


@dataclass(frozen=True, eq=False)
class Points:
    """Points of one part, as they are predicted: the task of measuring them, the world they are cut in, what is uncertain."""

    world: Cutting
    model: LinearModel

    @classmethod
    def some(cls, job: PreparedCut, rng: np.random.Generator) -> Points:
        """A few of the net of every feature."""
        part = job.scenario.part
        plan = gauge_plan(part, None)
        steps = []
        for step in plan.steps:
            count = OF_BORE if part.features[step.feature].kind == "cylinder" else OF_PLANE
            rows = np.sort(rng.choice(len(step.points), count, replace=False))
            steps.append(replace(step, points=step.points[rows], normals=step.normals[rows]))
        scenario = replace(job.scenario, plan=replace(plan, steps=tuple(steps)))
        task, world, _ = finished_part(replace(job, scenario=scenario))
        return cls(world, build(task, world))

    def concealed(self, effect: Effect | None, rng: np.random.Generator, delta: float) -> GivenPoints:
        """What is measured of a part: a draw of all that is uncertain, the effect, scatter."""
        touches = self.model.task.touches
        surface = self.world.contacts.surface(self.world.tool_errors)
        known = known_columns(self.model)
        out = surface + sum(c @ rng.standard_normal(c.shape[1]) for _, c in known.common)
        if effect is not None:
            shape = effect.build(self.world.tool.run, rng)
            row, gain = self.world.contacts.deepest(self.world.tool_errors)
            a = delta / self.strength(np.einsum("pi,pi->p", gain, shape[row]))
            out += self.world.contacts.surface(self.world.tool_errors + a * shape) - surface
        out = out + NOISE * rng.standard_normal(len(out))
        points = touches.points + out[:, None] * touches.normals
        where = tuple(f"points.csv:{i + 2}" for i in range(len(points)))
        return GivenPoints("", points, where, tuple(touches.run.labels["feature"].tolist()))

    def strength(self, linear: Array) -> float:
        """delta of departures (P,)."""
        touches = self.model.task.touches
        known = known_columns(self.model).covariance + NOISE**2 * np.eye(len(linear))
        arm = (touches.points - touches.points.mean(axis=0)) / 100.0
        rigid = np.hstack([touches.normals, np.cross(arm, touches.normals)])
        lower = np.linalg.cholesky(known)
        white, base = np.linalg.solve(lower, linear), np.linalg.qr(np.linalg.solve(lower, rigid))[0]
        return float(np.linalg.norm(white - base @ (base.T @ white)))


def asked(job: PreparedCut, machine: Path, given: GivenPoints, folder: Path) -> tuple[MeasuredCut, Diagnosis]:
    """(comparison, diagnosis) of measured points, by way of the files that a user has."""
    cut = measured_cut(job.scenario, given, u_point=NOISE, job=job)
    recording = part_recording("part", cut, load_machine(machine), frozenset(run_columns()))
    save_recording(recording, folder / "part.toml", str(machine), apart=True)
    recording, known = load_recording(folder / "part.toml")
    return cut, vcmm.diagnose(recording, known)


@dataclass(frozen=True)
class Counted:
    """One case: what was concealed ("" = nothing), the answers, whether something without a name was told, and of the comparison
    the covariate that was named first.
    """

    effect: str
    answers: tuple[str, ...]
    rivals: tuple[str, ...]
    verdict: str
    unknown: bool
    covariate: str

    @property
    def right(self) -> bool:
        """The right name first; of what the catalogue lacks: told as not explained, and no name found."""
        if not self.effect:
            return self.silent
        names = EFFECTS[self.effect].names
        if names == ("",):
            return self.verdict == "unexplained"  # whatever is named then is a candidate and no finding
        return bool(self.answers) and self.answers[0].split("[")[0] in names

    @property
    def silent(self) -> bool:
        return not self.answers and not self.unknown and self.verdict == "nothing missing"


def counted(word: str, cut: MeasuredCut, found: Diagnosis) -> Counted:
    first = found.answer[0].cannot_be_told_from if found.answer else ()
    covariate = cut.mismatch[0].covariate if cut.mismatch else ""
    names = tuple(a.id for a in found.answer if not a.doubtful) or tuple(a.id for a in found.answer)
    return Counted(word, names, tuple(first), found.verdict, found.unknown is not None, covariate)


def kept(path: Path | None) -> dict[int, Counted]:
    """Cases of an earlier run by their number."""
    if path is None or not path.exists():
        return {}
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    return {
        r["case"]: Counted(**{k: tuple(v) if isinstance(v, list) else v for k, v in r.items() if k != "case"})
        for r in rows
    }


def table(cases: list[Counted]) -> str:
    """The table of docs/cut.md."""
    out = ["| concealed | right name first | explained | `--measured` names first |", "|---|---|---|---|"]
    for word in dict.fromkeys(c.effect for c in cases if c.effect):
        mine = [c for c in cases if c.effect == word]
        told = Counter(c.covariate or "nothing" for c in mine).most_common(2)
        explained = sum(c.verdict == "explained" for c in mine)
        out.append(
            f"| {word} | {sum(c.right for c in mine)} of {len(mine)} | {explained} | {', '.join(f'{w} {n}' for w, n in told)} |"
        )
    concealed, nulls = [c for c in cases if c.effect], [c for c in cases if not c.effect]
    out.append(f"| all | {sum(c.right for c in concealed)} of {len(concealed)} | | |")
    named = sum(bool(c.answers) for c in nulls)
    told = sum(not c.silent for c in nulls)
    accused = sum(bool(c.covariate) for c in nulls)
    out.append(
        f"Nothing concealed, {len(nulls)} parts: a name in {named}, anything at all in {told}; `--measured` accuses {accused}."
    )
    return "\n".join(out)


def example_points(job: PreparedCut) -> str:
    """The points.csv of the example measured_block: a spindle that grows by 14 um with 900 s is concealed in it."""
    rng = np.random.default_rng(2026)
    points = Points.some(job, rng)

    def growth(run: Run, rng: np.random.Generator) -> Array:
        return _moved(run, z=-14e-3 * (1.0 - np.exp(-run.columns["time_s"] / 900.0)))

    row, gain = points.world.contacts.deepest(points.world.tool_errors)
    linear = np.einsum("pi,pi->p", gain, growth(points.world.tool.run, rng)[row])
    given = points.concealed(Effect(growth, ()), rng, points.strength(linear))
    rows = [f"{f},{x:.5f},{y:.5f},{z:.5f}" for f, (x, y, z) in zip(given.features or (), given.points)]
    return "\n".join(["feature,x_mm,y_mm,z_mm", *rows]) + "\n"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=64)
    parser.add_argument("--nulls", type=int, default=60)
    parser.add_argument("--only", choices=list(EFFECTS))
    parser.add_argument("--seed", type=int, default=17)
    parser.add_argument(
        "--example", action="store_true", help="write the points of the example measured_block, and no count"
    )
    parser.add_argument("--results", type=Path, help="lines of cases that are done; they are not done again")
    parser.add_argument("--most", type=int, default=0, help="stop when so many are done")
    parser.add_argument("--delta", type=float, default=DELTA)
    options = parser.parse_args()
    scenario = example("measured_block")
    job, machine = set_up(vcmm.load_cut(scenario)), scenario.parent / "measured_block" / "mill.toml"
    if options.example:
        (machine.parent / "points.csv").write_text(example_points(job))
        return
    words = [options.only] if options.only else list(EFFECTS)
    plan = [(i, words[i % len(words)]) for i in range(options.cases)]
    plan += [(options.cases + i, "") for i in range(options.nulls)]
    done = kept(options.results)
    cases = []
    with tempfile.TemporaryDirectory() as folder:
        for i, word in sorted(plan, key=lambda one: one[0] % max(options.cases, 1)):  # both kinds in turn
            if i in done:
                cases.append(done[i])
                continue
            if options.most and len(cases) >= options.most:
                break
            rng = np.random.default_rng([options.seed, i])
            given = Points.some(job, rng).concealed(EFFECTS.get(word), rng, options.delta)
            cut, found = asked(job, machine, given, Path(folder))
            cases.append(counted(word, cut, found))
            print(i, cases[-1], *found.reasons, file=sys.stderr, flush=True)
            if options.results:
                with options.results.open("a") as file:
                    file.write(json.dumps({"case": i, **asdict(cases[-1])}) + "\n")
    print(table(cases))


if __name__ == "__main__":
    main()
