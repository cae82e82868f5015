"""Advice after a placement, in plain sentences: move the part or leave it, distance to the edge, and influences that no move reduces."""

from __future__ import annotations

import numpy as np

from vcmm.answer.evaluation.checks import independent_draws
from vcmm.answer.placing.result import PlacementResult
from vcmm.answer.placing.words import changes
from vcmm.task.measuring.fixture import DOFS

# U is stated with two digits: less than half of their smallest step (10 to 9.5) is not seen in it
UNSEEN_SHARE_OF_U = 0.05
SAME_INFLUENCE = 0.01  # an influence that changes less between two poses is taken as the same


def room_and_shares(placed: PlacementResult) -> list[str]:
    """Return the advice without the gain, for pages that state it above."""
    sentences = advice(placed)
    return sentences if sentences[0].startswith("No advice") else sentences[1:]


def advice(placed: PlacementResult) -> list[str]:
    """Return sentences for the person who decides: the gain, the remaining room, the share of u² that both poses have.

    None is given where U of the poses cannot be compared: a field whose nodes are drawn independently is small between its nodes
    by the interpolation alone.
    """
    scenario = placed.objective.scenario
    withheld = independent_draws((*scenario.machine.inputs, *scenario.inputs))
    if withheld:
        return [f"No advice: {text}." for text in withheld]
    return [_gain(placed), *_room(placed), *_unmoved_shares(placed)]


def _gain(placed: PlacementResult) -> str:
    gain, sure = placed.gain, placed.confirmation
    if gain is None:
        return "The present pose cannot be used: put the part where it was found best."
    if sure is not None and not sure.is_confirmed:
        return f"{gain:.1%}, not confirmed by independent trials: leave the part where it is."
    if sure is not None and sure.present:
        gain = sure.gain / sure.present  # of other draws and all laws; that of the search is an approximation
    if gain < UNSEEN_SHARE_OF_U:
        return f"{gain:.1%}: leave the part where it is; U stated with two digits would hardly change."
    return f"{gain:.1%}: worth moving the part, if the move costs less than that."


def _room(placed: PlacementResult) -> list[str]:
    """Return how far the pose is from the ends of travels and fixture, along the freedoms of the map."""
    left = []
    for name, values in zip(placed.map.names[:2], (placed.map.x, placed.map.y)):
        if name.startswith("turn") or len(values) < 2:
            continue
        at = float(placed.best.pose[DOFS.index(name)])
        left.append(
            f"{min(at - values[0], values[-1] - at):.0f} mm from the end of its range in {name} ({round(float(values[0]))} to {round(float(values[-1]))} mm)"
        )
    return [f"The pose found lies {' and '.join(left)}."] if left else []


def _unmoved_shares(placed: PlacementResult) -> list[str]:
    """Return, per characteristic that counts, the share of u² whose influences are the same at both poses."""
    out = []
    for name, _, lines, before in changes(placed):
        same = [(label, old) for label, old, new in lines if abs(new - old) <= SAME_INFLUENCE * max(old, new)]
        share = float(np.sum([u**2 for _, u in same])) / before if before else 0.0
        if same:
            largest = max(same, key=lambda line: line[1])[0]
            out.append(
                f"{name}: {share:.0%} of u² is the same at both poses, most of it from {largest}: moving the part does not help there."
            )
    return out
