"""Write the renewed tables as files: errors_renewed.csv, its joint covariance, and the machine file that names them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.effect import own_nodes
from vcmm.core.errors import UsageError
from vcmm.core.inputs import JointCovariance
from vcmm.core.machine import Machine
from vcmm.files.foreign.isg import ErrorFile, ErrorTable, isg_text
from vcmm.files.own.joint_covariance import covariance_text
from vcmm.files.own.known_errors import read_error_file
from vcmm.files.toml import read_toml
from vcmm.learn.diagnosis.table_renewal import RenewedTables, with_tables

TABLE, COVARIANCE = "errors_renewed.csv", "errors_renewed_covariance.csv"


def renewed_files(original: Path, machine: Machine, new: RenewedTables, source: str) -> dict[str, str]:
    """Return the file name -> text of table and covariance. Raises UsageError where the numbers do not stand in a table file."""
    stated = read_toml(original).data.get("errors")
    if not isinstance(stated, dict) or not isinstance(stated.get("table"), str):
        raise UsageError(f"{original}: no [errors] table, so there is none to write anew")
    old = read_error_file(original.parent / stated["table"])
    evidence = f"stored tables moved to what {source} says of them"
    joint = JointCovariance(new.errors, new.position, new.covariance)
    return {TABLE: isg_text(_refine_file(old, machine, new), evidence), COVARIANCE: covariance_text(joint)}


def _refine_file(old: ErrorFile, machine: Machine, new: RenewedTables) -> ErrorFile:
    """Return the tables at the nodes that their covariance has: those of the file, or finer ones where the machine was refined."""
    effects = {e.where: e for e in with_tables(machine, new).effects if e.about.table_parameter}
    tables = []
    for table in old.tables:
        same: dict[bytes, tuple[Any, dict[str, Any]]] = {}
        for name, values in table.values.items():
            nodes = own_nodes(effects[name]) if name in effects else None
            if nodes is None or not len(new.of(name)):
                same.setdefault(b"", (table.grids, {}))[1][name] = values
                continue
            table_values = np.asarray(getattr(effects[name], "values"), dtype=float)  # noqa: B009 - tables and splines have it
            same.setdefault(np.asarray(nodes).tobytes(), ((nodes,), {}))[1][name] = table_values
        tables += [ErrorTable(table.arguments, grids, values, table.line) for grids, values in same.values()]
    constants = {
        n: float(getattr(effects[n], effects[n].about.table_parameter))
        if len(new.of(n)) and n in effects
        else v
        for n, v in old.constants.items()
    }
    return ErrorFile(tuple(tables), constants)


def name_tables(text: str, source: str) -> str:
    """Return the text of a machine file whose [errors] name the renewed tables, with their covariance in place of the stated one."""
    import tomlkit

    document: Any = tomlkit.parse(text)
    errors = document["errors"]
    errors["table"] = TABLE
    errors.pop("uncertainty", None)
    errors["covariance"] = COVARIANCE
    errors["evidence"] = f"diagnosed from {source}"
    return str(document.as_string())
