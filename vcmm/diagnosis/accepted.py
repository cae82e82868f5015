"""Which answers of a diagnosis go into the machine's file, and what must be said beside them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.effect import Effect
from vcmm.diagnosis.result import Answer

CLOCK = {
    "linear_drift": "acts with time_s of a job, counted as in the recording; at time_s = 0 it is zero",
    "settling_drift": "acts with time_s of a job, counted as in the recording",
    "step_change": "acts from t1 on the clock of the recording; a job whose time_s begins at 0 stands before it",
    "screw_heating": "acts with the distance travelled since the start of a job (travel_..._mm); a job without it is refused",
}


def written(answers: Sequence[Answer]) -> tuple[Answer, ...]:
    """Answers with a crisp number that belong to the machine and are more probable than not, their rivals included."""
    return tuple(a for a in answers if a.fitted is not None and not _why_not(a))


def notes(answers: Sequence[Answer]) -> tuple[str, ...]:
    """One sentence per answer that is not written, and why."""
    out = []
    for a in answers:
        why = _why_not(a)
        if a.fitted is not None and why:
            place = ", ".join(str(v) for v in a.where.values() if v)
            out.append(
                f"{a.effect}{f' {place}' if place else ''} is not written into the machine file: {why}"
            )
    return tuple(out)


def _why_not(a: Answer) -> str:
    if a.fitted is not None and a.fitted.per == "instrument":
        return "it is an error of the instrument that recorded, not of the machine"
    if a.doubtful:
        return f"a candidate only, probability {a.probability:.3f}"
    return ""


def remarks(effect: Effect) -> tuple[str, ...]:
    """What a reader of the file must know: the range that was recorded, the clock of what changes with time."""
    out = [CLOCK[effect.name]] if effect.name in CLOCK else []
    if effect.name == "geometric_change":
        nodes = np.asarray(getattr(effect, "nodes"), dtype=float)  # noqa: B009
        turn = str(getattr(effect, "component", ""))[-1:] in tuple("ABC")
        low, high = (np.degrees(nodes) if turn else nodes)[[0, -1]]
        out.append(
            f"recorded from {low:.1f} to {high:.1f} {'deg' if turn else 'mm'}; beyond these ends the value of the end is kept"
        )
    return tuple(out)
