"""Find columns with the same effect: numbers that others can replace, and the share of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array

SAME_COLUMN_SHARE = 1e-6  # of a column that those before it leave: then they do the same


@dataclass(frozen=True)
class Redundant:
    """A number that others can replace: its name, and the names of the others (with the share of each per unit, mm and rad)."""

    name: str
    by: tuple[tuple[str, float], ...]

    @property
    def text(self) -> str:
        partners = ", ".join(n for n, _ in self.by)
        return f"{self.name}: {partners} do the same, it is left at zero"


def beside(column: Array, basis: Sequence[Array]) -> Array | None:
    """Return the part of a column beside a basis, of unit length; None where nothing remains."""
    size = float(np.linalg.norm(column))
    if size == 0.0:
        return None
    left = column / size
    for _ in range(2):  # twice is enough (Kahan)
        if basis:
            q = np.column_stack(basis)
            left = left - q @ (q.T @ left)
    rest = float(np.linalg.norm(left))
    return None if rest < SAME_COLUMN_SHARE else left / rest


def same_as(column: Array, columns: Array, labels: Sequence[str]) -> tuple[tuple[str, float], ...]:
    """Return the names whose columns add up to this one, by their share; small ones are left out."""
    if not np.any(column):
        return (("nothing that these poses show", 0.0),)
    amounts = np.linalg.lstsq(columns, column, rcond=1e-10)[0]
    share = np.abs(amounts) * np.linalg.norm(columns, axis=0) / np.linalg.norm(column)
    by: dict[str, tuple[float, float]] = {}
    for name, amount, part in zip(labels, amounts, share):
        if part > 1e-3 and part > by.get(name, (0.0, 0.0))[1]:
            by[name] = (float(amount), float(part))
    return tuple((n, v) for n, (v, _) in sorted(by.items(), key=lambda item: -item[1][1]))


def orthonormal(columns: Array) -> Array:
    """Return an orthonormal basis of the span of columns."""
    size = np.linalg.norm(columns, axis=0)
    left, values, _ = np.linalg.svd(columns / np.where(size > 0, size, 1.0), full_matrices=False)
    return np.asarray(left[:, values > 1e-9 * values[0]])
