"""Compute the width of the play of the axes of a machine from the jump of its effects at a reversal.

    play     e(d = -1, far) - e(d = +1, at the reversal)                    half of it is h of history.taken_up
    band     the largest of play, of the loop far from reversals, and of what is made up on the way

An axis that comes back by less than its band has not turned: a slide that sticks up to a height has not slipped below it. Effects of one
axis share one slide, so their plays add up.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from vcmm.core.effect import Effect, required
from vcmm.core.history import NO_REVERSAL, Width, axis_unit, play_name
from vcmm.core.run import Array, Run

STRAIGHT = 0.01  # of a course that a straight one may leave and say the same in other words: a fifth of what templates err by
FORGOTTEN_TRAVEL = 1e6  # mm or rad since a reversal: nothing of it is left
AFTER = tuple(10.0 ** (k / 4) for k in range(-12, 9))  # mm or rad, 0.001 to 100: where a pulse is looked for
PLAY_COLUMNS = ("sense_", "since_reversal_", "load_kg")  # columns of effects that are play


def share_taken_up(run: Run, axis: str) -> Array:
    """Return the share of the play that is taken up (n,), between -1 and 1: play_X of a dense path; where there was none, the direction
    sense_X of the last motion."""
    share = run.columns.get(play_name(axis))
    return run.column(f"sense_{axis}") if share is None else share


def bends(run: Run, axis: str, left: Array) -> bool:
    """Return whether the remaining share `left` (n,) of a reversal is more than a slope over the position beside a step.

    What goes on in proportion to the end of every way is d_a s = q - q(reversal): a scale and a play, which have names of their own.
    False where these two leave less than STRAIGHT of it. Columns for diagnosis alone: true where a run says no direction.
    """
    sense = run.columns.get(f"sense_{axis}")
    if sense is None or axis not in run.position:
        return True
    hangs = sense * left
    simple = np.column_stack([np.ones(run.n), run.q(axis), sense])
    beside = hangs - simple @ np.linalg.lstsq(simple, hangs, rcond=None)[0]
    return float(np.linalg.norm(beside)) > STRAIGHT * float(np.linalg.norm(hangs))


def widths(effects: Iterable[Effect], position: Mapping[str, Array]) -> dict[str, Width]:
    """Return the widths of the axes of a path, position (n,) of each in mm or rad, that have play by these effects."""
    out, all_effects = {}, tuple(effects)
    for axis in position:
        plays = [e for e in all_effects if _is_play(e, axis)]
        if plays:
            out[axis] = _width(plays, axis, position)
    return out


def playing(effects: Iterable[Effect], axes: Iterable[str]) -> tuple[Effect, ...]:
    """Return the effects that cause the play of at least one of the axes."""
    letters = tuple(axes)
    return tuple(e for e in effects if any(_is_play(e, letter) for letter in letters))


def _is_play(effect: Effect, axis: str) -> bool:
    columns = required(effect)
    return (
        not effect.about.is_random
        and f"sense_{axis}" in columns
        and all(c.startswith(PLAY_COLUMNS) for c in columns)
    )


def _width(effects: Sequence[Effect], axis: str, position: Mapping[str, Array]) -> Width:
    n = len(position[axis])

    def along(sense: float, since: float) -> Array:
        columns = {
            "load_kg": np.zeros(n),
            f"sense_{axis}": np.full(n, sense),
            f"since_reversal_{axis}_{axis_unit(axis)}": np.full(n, since),
        }
        run = Run(dict(position), np.zeros((n, 3)), columns)
        return np.sum([e.error_motion(run)[:, "XYZABC".index(axis)] for e in effects], axis=0)

    settled = along(1.0, FORGOTTEN_TRAVEL)
    jump = along(-1.0, FORGOTTEN_TRAVEL) - along(1.0, 0.0)
    late = np.max([np.abs(along(1.0, s) - settled) for s in AFTER], axis=0)  # what is made up on the way
    band = np.max([np.full(n, NO_REVERSAL), jump, along(-1.0, FORGOTTEN_TRAVEL) - settled, late], axis=0)
    return Width(np.maximum(jump, 0.0) / 2.0, band)
