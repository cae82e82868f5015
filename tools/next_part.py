"""The next part: does the program that is compensated with what was found cut a better part on the machine as it really is?

    python tools/next_part.py                    all effects of the table of docs/cut.md, about 40 s each
    python tools/next_part.py wear clamping --delta 20

One effect is concealed in the measured block (formulas of tools/concealed_cuts.py, which share nothing with vcmm/physics), its points come
back, `measured_cut` and `diagnose` say what it is, `compensate --surface` writes the next program, and both programs are cut by the
concealed formula: what of the part is off the drawing before and after.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent))
from concealed_cuts import EFFECTS, Effect, Points, asked

import vcmm
from vcmm.compensation.job import compensate
from vcmm.compensation.surface import surface_errors
from vcmm.core.run import Array
from vcmm.files.own.library import example as example
from vcmm.learn.diagnosis.written_machine import written_machine
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.measured_part import known_columns
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import PreparedCut

WORDS = ("deflection", "wear", "wrong tool radius", "runout", "servo lag", "thermal growth", "clamping")
NOTCH = "notch_"  # walls that one way of the tool makes together


@dataclass(frozen=True)
class Part:
    """Departures of a finished part from the drawing, mm: all points, and those on walls of slots."""

    all: Array
    slot: np.ndarray

    @property
    def told(self) -> str:
        free = self.all[~self.slot]
        return f"{_um(self.all)} (without walls of slots {_um(free)})"


def _um(values: Array) -> str:
    return f"{np.abs(values).max() * 1e3:.2f} um, rms {np.sqrt(np.mean(values**2)) * 1e3:.2f}"


def truly_cut(job: PreparedCut, program: Path, effect: Effect, size: float, state: dict) -> Part:
    """The part that a program leaves on the machine with the concealed effect."""
    task, world, _ = finished_part(set_up(replace(job.scenario, program=program)))
    rng = np.random.default_rng()
    rng.bit_generator.state = state
    moved = world.tool_errors + size * effect.build(world.tool.run, rng)
    feature = task.touches.run.labels["feature"]
    wall = np.array([str(f).startswith(NOTCH) and str(f).endswith(("left", "right")) for f in feature])
    return Part(world.contacts.surface(moved), wall)


def next_part(job: PreparedCut, machine: Path, word: str, *, seed: int, delta: float, folder: Path) -> str:
    """One line of the table."""
    rng, effect = np.random.default_rng([seed, WORDS.index(word)]), EFFECTS[word]
    points = Points.some(job, rng)
    state = rng.bit_generator.state
    given = points.concealed(effect, rng, delta)
    again = np.random.default_rng()
    again.bit_generator.state = state
    row, gain = points.world.contacts.deepest(points.world.tool_errors)
    # concealed() draws what is known to be uncertain before the effect: the same order here
    for _, columns in known_columns(points.model).common:
        again.standard_normal(columns.shape[1])
    state = again.bit_generator.state
    shape = effect.build(points.world.tool.run, again)
    size = delta / points.strength(np.einsum("pi,pi->p", gain, shape[row]))
    _, found = asked(job, machine, given, folder)
    known = written_machine(found, vcmm.load_machine(machine))
    surface = surface_errors(replace(job.scenario, machine=known))
    result = compensate(job.scenario.program, job.scenario.setup, known, surface=surface)
    program = folder / "next.nc"
    program.write_text(result.text)
    before, after = (truly_cut(job, p, effect, size, state) for p in (job.scenario.program, program))
    names = ", ".join(a.id for a in found.found) or "nothing"
    for note in result.warnings:
        print(f"  {note}", file=sys.stderr)
    return f"| {word} | {names} | {before.told} | {after.told} |"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("words", nargs="*", choices=[*WORDS, []], default=[])
    parser.add_argument("--seed", type=int, default=5)
    parser.add_argument("--delta", type=float, default=20.0)
    options = parser.parse_args()
    scenario = example("measured_block")
    job, machine = set_up(vcmm.load_cut(scenario)), scenario.parent / "measured_block" / "mill.toml"
    print("| concealed | found | part of the first program | part of the next program |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for word in options.words or WORDS:
            print(
                next_part(job, machine, word, seed=options.seed, delta=options.delta, folder=Path(folder)),
                flush=True,
            )


if __name__ == "__main__":
    main()
