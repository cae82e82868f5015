"""One part on one machine, for a first look at an uncertainty: value, U, decision, main contributor, a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vcmm.show.pages.uncertainty import characteristic_charts, scenes
from vcmm.show.report import blocks as r

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
    from vcmm.task.measuring.scenario import Scenario


def first_lines(scenario: Scenario, c: CharacteristicResult) -> list[str]:
    """Return the measurement and its place; then the answer."""
    touches = sum(len(s.points) for s in scenario.plan.steps)
    what = f"{scenario.name[:1].upper()}{scenario.name[1:]}: {touches} points on a {scenario.machine.name}, measured virtually."
    return [what, "", r.answer_text([r.answer_of(c)])]


def first_blocks(scenario: Scenario, result: UncertaintyResult) -> list[str]:
    """Return the sentences, the charts of the first characteristic and the picture of its touches."""
    c = result.characteristics[0]
    title = "The part and its touches"
    picture = r.scene(
        scenes(result)[1],
        title=title,
        caption="Ellipsoids: where each touch may really be, k = 1.",
        height=380,
    )
    what, _, _ = first_lines(scenario, c)
    return [r.paragraph(what), r.answers_block([r.answer_of(c)]), *characteristic_charts(c), picture]
