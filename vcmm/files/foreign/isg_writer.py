"""Write tables of component errors as ISG volumetric CSV, the format that `read_isg` reads."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.run import Array
from vcmm.files.foreign.isg import ErrorFile, ErrorTable


def isg_text(file: ErrorFile, comment: str = "") -> str:
    """Return the text of a file; numbers with ten digits, mm and rad."""
    parts = [_table(t) for t in file.tables]
    if file.constants:
        names = list(file.constants)
        parts.append(" ".join(names) + "\n" + " ".join(f"{file.constants[n]:.10g}" for n in names) + "\n")
    head = f"// {comment}\n" if comment else ""
    return head + "#\n".join(parts)


def _table(table: ErrorTable) -> str:
    mesh = np.meshgrid(*table.grids, indexing="ij")
    columns = [m.ravel() for m in mesh] + [np.ravel(v) for v in table.values.values()]
    rows = [" ".join(f"{v:.10g}" for v in row) for row in np.stack(columns, axis=1)]
    return "\n".join([" ".join([*table.arguments, *table.values]), *rows]) + "\n"


def with_values(file: ErrorFile, values: Mapping[str, Array | float]) -> ErrorFile:
    """Return the same tables with other numbers: component name -> values in the shape of its grids, or one number."""
    tables = tuple(
        ErrorTable(
            t.arguments,
            t.grids,
            {
                n: np.reshape(np.asarray(values.get(n, v), dtype=float), np.shape(v))
                for n, v in t.values.items()
            },
            t.line,
        )
        for t in file.tables
    )
    return ErrorFile(tables, {n: float(values.get(n, v)) for n, v in file.constants.items()})
