"""What the catalogue says confirms a name, in words that fit the machine at hand."""

from __future__ import annotations

from collections import defaultdict

from vcmm.core.axes import is_rotary
from vcmm.core.run import Run
from vcmm.learn.diagnosis.select import Term
from vcmm.physics import BY_NAME


def confirming(term: Term, rival: str, run: Run) -> str:
    """What confirms the name, or, where the axes of a run cannot do that, what confirms its rival; "" where there is neither."""
    effect = term.option.effect
    words = [
        effect.about.words if effect is not None else None,
        BY_NAME[rival].about.words if rival in BY_NAME else None,
    ]
    sentences = [w.confirm for w in words if w is not None and _is_possible(w.confirm, run)]
    if effect is None or not sentences:
        return ""
    known = defaultdict(str, {k: str(v) for k, v in term.family.where.items()})
    known["where"] = " ".join(term.family.where.values())
    return sentences[0].format_map(known)


def _is_possible(confirm: str, run: Run) -> bool:
    """A circle takes two linear axes."""
    return "circular test" not in confirm or sum(not is_rotary(a) for a in run.position) > 1
