"""Write an improved machine file: the original text, and the effects that were found with their uncertainty.

The owner's text does not change; additions are at the end, with the recording they come from.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect, parameter_fields, place_fields, unit_of
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.knowledge import addable
from vcmm.core.laws import MultivariateNormal
from vcmm.core.machine import Machine
from vcmm.core.units import in_unit
from vcmm.files.foreign.isg_writer import isg_text, with_values
from vcmm.files.toml_edits import editable, move_names
from vcmm.learn.diagnosis.acceptance import answers_to_write, notes
from vcmm.learn.diagnosis.improve import departure
from vcmm.learn.diagnosis.log_mistakes import Mistake
from vcmm.learn.diagnosis.repair import repair_machine, repaired_effects
from vcmm.learn.diagnosis.result import Answer

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
    known = {i.id for i in machine.inputs}
    blocks = [f"# {note}\n" for note in notes(answers)]
    for answer in answers_to_write(answers):
        assert answer.fitted is not None
        said = f"found in {source}, probability {answer.probability:.3f}"
        remark = answer.fitted.diagnosis.file_note(answer.fitted)
        told = f"# {remark}\n" if remark else ""
        blocks.append(told + effect_toml(departure(answer.fitted, machine), said))
        # an Input names its effect by place: with a second effect of that place (another period) it would be ambiguous
        alone = all(e.id != answer.fitted.id or addable(e, answer.fitted) for e in machine.effects)
        wanted = [one for one in answer.inputs if alone and one.id not in known]
        blocks += [input_toml(answer.fitted, one, source) for one in wanted]
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
    own = tuple(effects_of(file))
    axis = machine.axes.get(mistake.component)
    arm = None if axis is None or axis.measured_at is None else np.asarray(axis.measured_at, dtype=float)
    try:
        new = repaired_effects(own, mistake, arm)
    except (UsageError, KeyError):
        return {}
    numbers = {e.where: getattr(e, e.about.table_parameter) for e in new if e.about.table_parameter}
    said = f"corrected after {source}: {mistake.component}, {mistake.what}"
    return {TABLE: isg_text(with_values(file, numbers), said)}


def repaired_in_place(machine: Machine, mistake: Mistake, source: str) -> str:
    """Return further [[effects]] that correct a mistake in numbers of the machine file itself; "" where that is not possible.

    Effects of one name and place are added when the file is read, so each holds the difference.
    """
    try:
        new = repair_machine(machine, mistake).effects
    except (UsageError, KeyError):
        return ""
    changed = [(one, two) for one, two in zip(machine.effects, new) if two is not one]
    if not changed or not all(addable(one, two) for one, two in changed):
        return ""
    said = f"corrects a mistake found in {source}: {mistake.component}, {mistake.what}"
    return "".join(f"\n{effect_toml(departure(two, machine), said)}" for _, two in changed)


def with_table(text: str) -> str:
    """Return the text of a machine file whose [errors] name the corrected table."""
    import tomlkit

    document: Any = tomlkit.parse(text)
    document["errors"]["table"] = TABLE
    return str(document.as_string())


def effect_toml(effect: Effect, comment: str = "") -> str:
    """Return one [[effects]] table with all places, parameters and further keys of the effect."""
    lines = [
        f"[[effects]]{f'                                # {comment}' if comment else ''}",
        f'effect = "{effect.name}"',
    ]
    back = {name: word for word, name in effect.about.aliases.items() if re.fullmatch(r"[\w-]+", word)}
    for place in place_fields(effect):
        value = getattr(effect, place.name)
        if value != "" and not (place.metadata["quiet"] and value == place.default):
            lines.append(f"{place.name} = {_plain(value)}")
    letter = str(getattr(effect, "component", ""))[:1]
    for spec in parameter_fields(effect):
        if spec.metadata["only"] and letter not in spec.metadata["only"]:
            continue  # a shift has no tilt
        lines.append(f"{back.get(spec.name, spec.name)} = {_quantity(effect, spec)}")
    done = {f.name for f in (*place_fields(effect), *parameter_fields(effect))}
    for name, value in vars(effect).items():
        if name not in done and isinstance(value, str | int) and value != "" and not name.startswith("_"):
            lines.append(f"{name} = {_plain(value)}")
        elif name not in done and isinstance(value, float) and value != 0.0:
            lines.append(f'{name} = "{value:.10g} mm"')
    return "\n".join([*lines, *_array_lines(effect)]) + "\n"


def _array_lines(effect: Effect) -> list[str]:
    """Return the keys of an effect that are no parameters: ends or nodes of a travel, grids and table, points."""
    lines = []
    letters = tuple(getattr(effect, "arguments", ()))
    if letters and vars(effect).get("grids"):
        grids = [_positions(a, g) for a, g in zip(letters, vars(effect)["grids"])]
        lines += [f"arguments = [{', '.join(_plain(a) for a in letters)}]", f"grids = [{', '.join(grids)}]"]
    if isinstance(process := vars(effect).get("process"), Mapping):
        lines.append(f"process = {{ {', '.join(f'{k} = {_word(v)}' for k, v in process.items())} }}")
    for name in ("nodes", "deviation", "scatter", "reading_u"):
        value = np.asarray(vars(effect).get(name, ()), dtype=float)
        if not value.size or name in {f.name for f in parameter_fields(effect)}:
            continue
        if value.ndim == 1:
            lines.append(f"{name} = {_positions(effect.link, value)}")
        else:
            points = (f'"{" ".join(f"{v:.10g}" for v in row)} mm"' for row in value)
            lines.append(f"{name} = [{', '.join(points)}]")
    return lines


def _word(value: Any) -> str:
    """Return a text, a number or a list of them, as TOML writes it."""
    if isinstance(value, str):
        return f'"{value}"'
    return f"[{', '.join(_word(v) for v in value)}]" if isinstance(value, list | tuple) else f"{value:.10g}"


def _positions(letter: str, values: Any) -> str:
    unit = "rad" if is_rotary(letter) else "mm"
    return f'"{" ".join(f"{v:.10g}" for v in np.asarray(values, dtype=float))} {unit}"'


def _quantity(effect: Effect, spec: Any) -> str:
    """Return one text for a number or a row of them, a list of texts for a table."""
    unit = unit_of(effect, spec.name)
    numbers = np.asarray(getattr(effect, spec.name), dtype=float) / _factor(unit)
    end = f" {unit}" if unit not in ("", "1") else ""
    rows = numbers if numbers.ndim == 2 else np.ravel(numbers)[None]
    texts = [f'"{" ".join(f"{n:.10g}" for n in row)}{end}"' for row in rows]
    return f"[{', '.join(texts)}]" if numbers.ndim == 2 else texts[0]


def _factor(unit: str) -> float:
    return 1.0 if unit in ("", "1") else 1.0 / in_unit(1.0, unit)


def _plain(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


def input_toml(effect: Effect, one: Input, source: str) -> str:
    """Return one [[inputs]] table for a parameter of the effect: u for a number, a covariance for an array."""
    spec = next(f for f in parameter_fields(effect) if f.name == one.parameter)
    unit = unit_of(effect, spec.name)
    lines = ["[[inputs]]", f'effect = "{effect.name}"']
    for place in place_fields(effect):
        value = getattr(effect, place.name)
        if value != "" and not (place.metadata["quiet"] and value == place.default):
            lines.append(f"{place.name} = {_plain(value)}")
    lines.append(f'parameter = "{one.parameter}"')
    if isinstance(one.law, MultivariateNormal):
        rows = one.law.covariance / _factor(unit) ** 2
        lines += [
            'law = "multivariate"',
            "covariance = [" + ", ".join(f"[{', '.join(f'{v:.6g}' for v in row)}]" for row in rows) + "]",
        ]
    else:
        spread = f"{float(np.ravel(one.law.u)[0]) / _factor(unit):.6g}"
        lines += ['law = "normal"', f'u = "{spread} {unit}"' if unit not in ("", "1") else f'u = "{spread}"']
    lines.append(f'evidence = "diagnosed from {source}"')
    return "\n".join(lines) + "\n"
