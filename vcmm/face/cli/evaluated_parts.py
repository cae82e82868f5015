"""Measured parts of vcmm evaluate: their data and the output for the terminal."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

from vcmm.answer.inference.job import EvaluatedPart
from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
from vcmm.show.tables.answers_parts import parts_answers
from vcmm.show.tables.evaluation import batch, joint_words, part_table, told_once, wholes
from vcmm.show.tables.stated import how_well_known
from vcmm.show.tables.uncertainty import (
    budget_table,
    not_added_up,
    not_covered,
    stated_with,
    undecided_because,
)


def show_parts(parts: Sequence[EvaluatedPart], warnings: Collection[str]) -> None:
    """Show values, true values and decisions; of one part contributions too, of several one table."""
    several = len(parts) > 1
    results = [(p.part, [e.result for e in p.characteristics]) for p in parts]
    show_answers(parts_answers(parts))
    show_table(batch(parts) if several else part_table(parts[0]))
    sentences = told_once(
        [
            (n, [*stated_with(part), *undecided_because(part), *not_covered(part), *how_well_known(part)])
            for n, part in results
        ]
    )
    for sentence in (*sentences, *(wholes(parts) if several else joint_words(parts[0].joint))):
        say(sentence)
    if not several:
        show_table(budget_table(results[0][1]))
        for sentence in not_added_up(results[0][1]):
            say(sentence)
    say_warnings(warnings)


@dataclass(frozen=True)
class GivenMeasurement:
    """Measured data: a file of points or of values. frame: of the points; None for the usual one, that of the part."""

    points: Path | None
    values: Path | None
    frame: str | None
    tip_centres: bool

    @property
    def file(self) -> Path:
        file = self.points or self.values
        assert file is not None  # check_inputs refuses it
        return file

    def options(self) -> dict[str, object]:
        """Return the data by the names of the options."""
        return {
            "points": self.points, "values": self.values, "frame": self.frame, "tip_centres": self.tip_centres,
        }  # fmt: skip
