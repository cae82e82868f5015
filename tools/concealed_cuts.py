"""Concealed cutting effects: does `vcmm diagnose` name what is wrong with the machine from a part that came back measured?

    python tools/concealed_cuts.py              64 concealed cases at delta 10 and 60 parts as predicted: the table of docs/cut.md
    python tools/concealed_cuts.py --cases 6 --nulls 0 --only wear

Each case draws what the machine file says is uncertain, adds one effect by a formula of its own (nothing of vcmm/effects is asked),
draws some points of every feature with their scatter, and goes the way of a user: `measured_cut`, the recording written and
read back, `diagnose`. delta: norm of the departure in units of everything that is uncertain, alignment and zeros taken out.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import vcmm
from vcmm.core.run import Array, Run
from vcmm.diagnosis.result import Diagnosis
from vcmm.evaluation.linear import LinearModel, build
from vcmm.files.columns import run_columns
from vcmm.files.machine import load_machine
from vcmm.files.recording import load_recording
from vcmm.files.recording_writer import save_recording
from vcmm.inference.given import GivenPoints
from vcmm.library import path as example
from vcmm.machining.job import finished_part
from vcmm.machining.measured import MeasuredCut, known_columns, measured_cut
from vcmm.machining.part_recording import part_recording
from vcmm.machining.preparation import set_up
from vcmm.machining.process import PreparedCut
from vcmm.machining.world import Cutting

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
class Shop:
    """The job made ready once, with a dense net of points on every feature."""

    job: PreparedCut
    world: Cutting
    model: LinearModel
    file: Path

    @classmethod
    def ready(cls, scenario: Path) -> Shop:
        job = set_up(vcmm.load_cut(scenario))
        task, world, _ = finished_part(job)
        return cls(job, world, build(task, world), scenario)

    def concealed(self, effect: Effect | None, rng: np.random.Generator, delta: float) -> GivenPoints:
        """The measured points of a part."""
        touches = self.model.task.touches
        some = self._chosen(rng)
        surface = self.world.contacts.surface(self.world.moved)
        out = surface + self._drawn(rng)
        if effect is not None:
            shape = effect.build(self.world.tool.run, rng)
            row, gain = self.world.contacts.deepest(self.world.moved)
            linear = np.einsum("pi,pi->p", gain, shape[row])
            a = delta / self.strength(linear, some)
            out += self.world.contacts.surface(self.world.moved + a * shape) - surface
        out = out + NOISE * rng.standard_normal(len(out))
        points = touches.points + out[:, None] * touches.normals
        where = tuple(f"points.csv:{i + 2}" for i in range(len(some)))
        features = tuple(touches.run.labels["feature"][some])
        return GivenPoints("", points[some], where, features)

    def _chosen(self, rng: np.random.Generator) -> Array:
        out = []
        for name, rows in self.model.task.touches.rows.items():
            count = OF_BORE if self.model.task.part.features[name].kind == "cylinder" else OF_PLANE
            out.append(np.sort(rng.choice(rows, count, replace=False)))
        return np.concatenate(out)

    def _drawn(self, rng: np.random.Generator) -> Array:
        """A draw (P,) of everything that is uncertain."""
        n = len(self.model.points)
        along = replace(self.model, operator=np.eye(n), q0=np.zeros(n))
        out = np.zeros(n)
        for term in along.terms():
            out += term.gain @ (term.law.u * rng.standard_normal(term.gain.shape[1]))
        return out

    def strength(self, linear: Array, some: Array) -> float:
        """delta of departures (P,) at the points `some`."""
        known = known_columns(self.model).covariance[np.ix_(some, some)] + NOISE**2 * np.eye(len(some))
        t = self.model.task.touches
        place = t.run.part_point[some]
        arm = (place - place.mean(axis=0)) / 100.0
        rigid = np.hstack([t.normals[some], np.cross(arm, t.normals[some])])
        lower = np.linalg.cholesky(known)
        white, base = np.linalg.solve(lower, linear[some]), np.linalg.qr(np.linalg.solve(lower, rigid))[0]
        return float(np.linalg.norm(white - base @ (base.T @ white)))


def asked(shop: Shop, given: GivenPoints, folder: Path) -> tuple[MeasuredCut, Diagnosis]:
    """(comparison, diagnosis) of measured points, by way of the files that a user has."""
    cut = measured_cut(shop.job.scenario, given, u_point=NOISE, job=shop.job)
    machine = shop.file.parent / "measured_block" / "mill.toml"
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
        """The right name first; of what the catalogue lacks: told as unknown, or as not explained, and no name found."""
        if not self.effect:
            return self.silent
        names = EFFECTS[self.effect].names
        if names == ("",):
            return self.unknown or self.verdict in ("unexplained", "partly explained")
        return bool(self.answers) and self.answers[0].split("[")[0] in names

    @property
    def silent(self) -> bool:
        return not self.answers and not self.unknown and self.verdict == "nothing missing"


def counted(word: str, cut: MeasuredCut, found: Diagnosis) -> Counted:
    first = found.answer[0].cannot_be_told_from if found.answer else ()
    covariate = cut.mismatch[0].covariate if cut.mismatch else ""
    names = tuple(a.id for a in found.answer if not a.doubtful) or tuple(a.id for a in found.answer)
    return Counted(word, names, tuple(first), found.verdict, found.unknown is not None, covariate)


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


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--cases", type=int, default=64)
    parser.add_argument("--nulls", type=int, default=60)
    parser.add_argument("--only", choices=list(EFFECTS))
    parser.add_argument("--seed", type=int, default=17)
    parser.add_argument("--delta", type=float, default=DELTA)
    options = parser.parse_args()
    shop = Shop.ready(example("measured_block"))
    words = [options.only] if options.only else list(EFFECTS)
    plan = [(i, words[i % len(words)]) for i in range(options.cases)]
    plan += [(options.cases + i, "") for i in range(options.nulls)]
    cases = []
    with tempfile.TemporaryDirectory() as folder:
        for i, word in sorted(plan, key=lambda one: one[0] % max(options.cases, 1)):  # both kinds in turn
            rng = np.random.default_rng([options.seed, i])
            cut, found = asked(shop, shop.concealed(EFFECTS.get(word), rng, options.delta), Path(folder))
            cases.append(counted(word, cut, found))
            print(i, cases[-1], *found.reasons, file=sys.stderr, flush=True)
    print(table(cases))


if __name__ == "__main__":
    main()
