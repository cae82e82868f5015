"""One part on one machine, for who sees an uncertainty for the first time: value, U, decision, who owns U, a picture."""

from __future__ import annotations

from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.show import report as r
from vcmm.show.pages.uncertainty import characteristic_charts, scenes
from vcmm.task.measuring.scenario import Scenario

OWNERS = 3  # lines of a budget that are named


def sentences(scenario: Scenario, c: CharacteristicResult) -> list[str]:
    """What was measured, with which uncertainty, what follows for the limits, and whose uncertainty it is. Lengths only."""
    touches = sum(len(s.points) for s in scenario.plan.steps)
    out = [
        f"{scenario.name[:1].upper()}{scenario.name[1:]}, {touches} touches on a {scenario.machine.name}: {c.name} = {c.value:.5f} mm, "
        f"U = {c.expanded * 1e3:.2f} µm. With a probability of {c.p:.0%} the true value lies within ± U of it."
    ]
    if c.decision is not None and c.tolerance is not None:
        low, high = c.tolerance
        out.append(f"Limits {low:.6g} to {high:.6g} mm: {c.decision.text} (ISO 14253-1, {c.decision.rule}).")
    owners = "; ".join(f"{line.share:.0%} {line.what}" for line in c.budget[:OWNERS])
    return [*out, f"Who owns U (shares of u²): {owners}."]


def first_blocks(scenario: Scenario, result: UncertaintyResult) -> list[str]:
    """The sentences, the charts of the first characteristic and the picture of its touches."""
    c = result.characteristics[0]
    title = "The part and its touches"
    picture = r.scene(
        scenes(result)[1],
        title=title,
        caption="Ellipsoids: where each touch may really be, k = 1.",
        height=380,
    )
    return [*map(r.paragraph, sentences(scenario, c)), *characteristic_charts(c), picture]
