"""The machine of a day as files: the owner's machine file with new tables, new numbers, and [tracked] with both covariances."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.effect import Effect, parameter_fields, place_fields
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.files.foreign.isg import ErrorFile, ErrorTable, isg_text
from vcmm.files.learned.effect_text import effect_toml
from vcmm.files.own.joint_covariance import covariance_text
from vcmm.files.own.known_errors import effects_of, read_error_file, refine_tables
from vcmm.files.own.machine_tables import Uncertainty
from vcmm.files.toml_edits import editable, move_names, without_table
from vcmm.learn.tracking.machine_at import DatedMachine
from vcmm.physics import BY_NAME
from vcmm.physics.structure.component import ComponentSpline, ComponentTable


def machine_files(dated: DatedMachine, original: Path, target: Path, at: str, last: str) -> dict[str, str]:
    """Return file name -> text: STEM.toml, STEM_errors.csv where the original has a table, STEM_state.csv and STEM_since.csv.

    Raises UsageError where a number that was followed cannot be written so that it is read back.
    """
    stem, document = target.stem, editable(original)
    evidence = f"followed until {last}, as of {at}"
    files: dict[str, str] = {}
    in_table = _renew_table(dated, document, original, evidence, files, f"{stem}_errors.csv")
    _take_out_inputs(dated, document)
    without_table(document, "tracked")
    move_names(document, original.parent, target.parent)
    if in_table:
        document["errors"]["table"] = f"{stem}_errors.csv"
    text = str(document.as_string()).rstrip() + "\n" + _departures(dated, in_table, evidence)
    if dated.uncertain:
        files[f"{stem}_state.csv"] = covariance_text(dated.joint(dated.state))
        text += f'\n[tracked]\nat = "{at}"\nlast_check = "{last}"\ncovariance = "{stem}_state.csv"\n'
        if dated.since.any():
            files[f"{stem}_since.csv"] = covariance_text(dated.joint(dated.since))
            text += f'since = "{stem}_since.csv"\n'
    return {f"{stem}.toml": text, **files}


def _departure_of(dated: DatedMachine, effect: Effect) -> dict[str, Array]:
    """Return parameter -> departure, in the shape of the parameter."""
    rows = dated.history.tracked.rows
    return {
        q.parameter: np.reshape(dated.departure[rows[q.id]], np.shape(getattr(q.effect, q.parameter)))
        for q in dated.history.tracked.quantities
        if q.effect.id == effect.id
    }


def _renew_table(
    dated: DatedMachine, document: Any, original: Path, evidence: str, files: dict[str, str], name: str
) -> set[str]:
    """Put the error table with the numbers of the day into `files`; [errors] without its statements about their uncertainty. Return the
    ids in the table."""
    errors = document.get("errors")
    if errors is None:
        return set()
    file = read_error_file(original.parent / str(errors["table"]))
    stated = Uncertainty(**errors["uncertainty"]) if "uncertainty" in errors else None
    effects = refine_tables(effects_of(file, errors.get("interpolation") == "cubic"), stated)
    tables, constants = [], {}
    for effect in effects:
        moved = _departure_of(dated, effect)
        if isinstance(effect, ComponentTable | ComponentSpline):
            values = np.asarray(effect.values, dtype=float) + moved.get("values", 0.0)
            arguments, grids = _over(effect)
            tables.append(ErrorTable(arguments, grids, {effect.component: values}, 0))
        else:
            constants[effect.where] = _constant(file, effect.where) + sum(float(v) for v in moved.values())
    files[name] = isg_text(ErrorFile(_together(tables), constants), evidence)
    for key in ("uncertainty", "covariance"):
        if key in errors:
            del errors[key]
    return {e.id for e in effects}


def _over(effect: ComponentTable | ComponentSpline) -> tuple[tuple[str, ...], tuple[Array, ...]]:
    """Return the letters of the axes over which a table or spline is defined, and its nodes."""
    if isinstance(effect, ComponentSpline):
        return (effect.link,), (np.asarray(effect.nodes, dtype=float),)
    return tuple(effect.arguments), tuple(effect.grids)


def _constant(file: ErrorFile, name: str) -> float:
    return float(file.constants[name])


def _together(tables: list[ErrorTable]) -> tuple[ErrorTable, ...]:
    """Join tables over the same positions into one."""
    out: list[ErrorTable] = []
    for table in tables:
        k = next((i for i, t in enumerate(out) if _same_grids(t, table)), None)
        if k is None:
            out.append(table)
        else:
            out[k] = replace(out[k], values={**out[k].values, **table.values})
    return tuple(out)


def _same_grids(table: ErrorTable, other: ErrorTable) -> bool:
    same = table.arguments == other.arguments and len(table.grids) == len(other.grids)
    return same and all(np.array_equal(a, b) for a, b in zip(table.grids, other.grids))


def _departures(dated: DatedMachine, in_table: set[str], evidence: str) -> str:
    """Return [[effects]] of the differences from the original file; the reader adds effects of one name and place."""
    blocks = []
    for effect in {q.effect.id: q.effect for q in dated.history.tracked.quantities}.values():
        moved = {n: v for n, v in _departure_of(dated, effect).items() if np.any(v)}
        if effect.id in in_table or not moved:
            continue
        linear = [f.name for f in parameter_fields(effect) if not f.metadata["scan"]]
        changes: dict[str, Any] = {}
        for name in linear:
            value = np.asarray(moved.get(name, np.zeros(np.shape(getattr(effect, name)))), dtype=float)
            changes[name] = float(value) if value.ndim == 0 else value
        blocks.append("\n" + effect_toml(replace(effect, **changes), evidence))
    return "".join(blocks)


def _take_out_inputs(dated: DatedMachine, document: Any) -> None:
    """Remove [[inputs]] that [tracked] replaces. Raises UsageError for scales whose coefficient was followed."""
    ids = {q.id for q in dated.uncertain}
    stated = document.get("inputs", [])
    for i in reversed(range(len(stated))):
        if _names_of(stated[i]) & ids:
            if not _names_of(stated[i]) <= ids:
                raise UsageError(
                    f"[[inputs]] {', '.join(sorted(_names_of(stated[i])))}: some of these were followed and some not; state them apart"
                )
            del stated[i]
    if "inputs" in document and not len(stated):
        document.remove("inputs")


def _names_of(table: Mapping[str, Any]) -> set[str]:
    """Return the ids of the quantities of an [[inputs]] table with one draw for the machine."""
    if table.get("redraw", "machine") != "machine":
        return set()
    if "names" in table:
        return {str(n) for n in table["names"]}
    kind = BY_NAME.get(str(table.get("effect")))
    if kind is None:
        return set()
    places = [
        str(table.get(f.name, f.default))
        for f in place_fields(kind)
        if not (f.metadata["quiet"] and table.get(f.name, f.default) == f.default)
    ]
    where = ",".join(p for p in places if p)
    name = str(table.get("parameter"))
    head = f"{kind.name}[{where}]" if where else kind.name
    return {f"{head}.{kind.about.aliases.get(name, name)}"}
