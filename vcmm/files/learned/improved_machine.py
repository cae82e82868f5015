"""Write an improved machine file: the original text, and the effects that were found with their uncertainty.

The owner's text does not change; additions are at the end, with the recording they come from.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.knowledge import addable
from vcmm.core.machine import Machine
from vcmm.files.foreign.isg import isg_text, with_values
from vcmm.files.learned.effect_text import effect_toml, input_toml
from vcmm.files.toml_edits import editable, move_names
from vcmm.learn.diagnosis.improve import departure_from, repair_machine, repaired_effects
from vcmm.learn.diagnosis.log_mistakes import Mistake
from vcmm.learn.diagnosis.result import Answer
from vcmm.learn.diagnosis.written_machine import answers_to_write, writing_remarks

TABLE = "errors_corrected.csv"


def improved_machine(
    original: Path, target: Path, machine: Machine, answers: Sequence[Answer], source: str
) -> str:
    """Return the text of the improved machine file.

    Of an effect that the machine has already only the departure is added: effects of one name and place are joined when
    the file is read. A quantity that has an Input keeps it. Candidates and errors of the instrument are named in a comment.
    """
    document = editable(original)
    move_names(document, original.parent, target.parent)
    text = str(document.as_string())
    ids = {i.id for i in machine.inputs}
    blocks = [f"# {note}\n" for note in writing_remarks(answers)]
    for answer in answers_to_write(answers):
        assert answer.fitted is not None
        evidence = f"found in {source}, probability {answer.probability:.3f}"
        remark = answer.fitted.diagnosis.file_note(answer.fitted)
        comment = f"# {remark}\n" if remark else ""
        blocks.append(comment + effect_toml(departure_from(answer.fitted, machine), evidence))
        # an Input names its effect by place: with a second effect of that place (another period) it would be ambiguous
        alone = all(e.id != answer.fitted.id or addable(e, answer.fitted) for e in machine.effects)
        wanted = [item for item in answer.inputs if alone and item.id not in ids]
        blocks += [input_toml(answer.fitted, item, source) for item in wanted]
    return text + "".join(f"\n{block}" for block in blocks)


def repaired_table(original: Path, machine: Machine, mistake: Mistake, source: str) -> dict[str, str]:
    """Return file name -> text of the corrected error table, beside the text `improved_machine` writes; empty where the numbers
    are not in a table file ([errors] table) or cannot be corrected there.
    """
    from vcmm.files.own.known_errors import effects_of, read_error_file
    from vcmm.files.toml import read_toml

    stated = read_toml(original).data.get("errors")
    if not isinstance(stated, dict) or not isinstance(stated.get("table"), str):
        return {}
    file = read_error_file(original.parent / stated["table"])
    effects = tuple(effects_of(file))
    axis = machine.axes.get(mistake.component)
    arm = None if axis is None or axis.measured_at is None else np.asarray(axis.measured_at, dtype=float)
    try:
        new = repaired_effects(effects, mistake, arm)
    except (UsageError, KeyError):
        return {}
    numbers = {e.where: getattr(e, e.about.table_parameter) for e in new if e.about.table_parameter}
    evidence = f"corrected after {source}: {mistake.component}, {mistake.what}"
    return {TABLE: isg_text(with_values(file, numbers), evidence)}


def repaired_in_place(machine: Machine, mistake: Mistake, source: str) -> str:
    """Return further [[effects]] that correct a mistake in numbers of the machine file itself; "" where that is not possible.

    Effects of one name and place are added when the file is read, so each holds the difference.
    """
    try:
        new = repair_machine(machine, mistake).effects
    except (UsageError, KeyError):
        return ""
    changed = [(old, two) for old, two in zip(machine.effects, new) if two is not old]
    if not changed or not all(addable(old, two) for old, two in changed):
        return ""
    evidence = f"corrects a mistake found in {source}: {mistake.component}, {mistake.what}"
    return "".join(f"\n{effect_toml(departure_from(two, machine), evidence)}" for _, two in changed)


def with_table(text: str) -> str:
    """Return the text of a machine file whose [errors] name the corrected table."""
    import tomlkit

    document: Any = tomlkit.parse(text)
    document["errors"]["table"] = TABLE
    return str(document.as_string())
