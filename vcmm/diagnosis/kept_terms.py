"""Which of the chosen terms hold: on rows held out, and against shapes without physics."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.diagnosis.adequacy import beaten
from vcmm.diagnosis.confusion import standing
from vcmm.diagnosis.evidence import Dictionary
from vcmm.diagnosis.holdout import Fold, gate, wins_everywhere
from vcmm.diagnosis.problem import Problem
from vcmm.diagnosis.select import Selection, Setting, joint


def that_hold(
    problem: Problem, parts: Sequence[Fold], selection: Selection, setting: Setting, generic: Dictionary
) -> Selection:
    """The terms that predict rows held out and that no shape without physics beats; what wins all its folds stays beside one."""
    selection = _through_the_gate(problem, parts, selection, setting)
    count = range(len(selection.terms))
    evidence = [standing(selection, setting, i, generic).evidence for i in count]
    doubtful = [
        i for i in count
        if beaten(generic, setting, selection, evidence[i], i) and not wins_everywhere(problem, parts, selection, i)
    ]  # fmt: skip
    if not doubtful:
        return selection
    return _still_needed(joint([selection.terms[i] for i in count if i not in doubtful], setting), setting)


def _through_the_gate(
    problem: Problem, parts: Sequence[Fold], selection: Selection, setting: Setting
) -> Selection:
    """Refuse the term that fails worst, refit the others, and look again."""
    while failed := gate(problem, parts, selection):
        selection = joint([t for i, t in enumerate(selection.terms) if i != failed[0]], setting)
    return selection


def _still_needed(selection: Selection, setting: Setting) -> Selection:
    """Without the terms that only helped another which has gone: each must pass the threshold given the others."""
    while selection.terms:
        scores = [standing(selection, setting, i).evidence for i in range(len(selection.terms))]
        worst = int(np.argmin(scores))
        if scores[worst] > setting.threshold:
            break
        selection = joint([t for i, t in enumerate(selection.terms) if i != worst], setting)
    return selection
