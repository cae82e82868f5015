"""Base of the scalar probability laws; the laws themselves and their description are in vcmm.core.laws."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from vcmm.core.errors import UsageError

Array = NDArray[Any]


def check_number(law: str, key: str, value: float, least: float = 0.0) -> None:
    """Refuse a parameter that is not a finite number >= least."""
    if not (math.isfinite(value) and value >= least):
        raise UsageError(f"Law {law}: {key} = {value} must be a finite number, at least {least:g}.")


class Law:
    """Base of the scalar laws. Subclasses give `_cdf`, `_isf`, `_cf`, `_bound` of their shape (t >= 0)."""

    unimodal = True  # symmetric about zero with one peak: the shortest coverage interval is the symmetric one
    if TYPE_CHECKING:  # a field of some laws, computed by others

        @property
        def name(self) -> str: ...
        @property
        def scale(self) -> float: ...
        @property
        def shape(self) -> Law: ...
        @property
        def u(self) -> float: ...
        @property
        def mean(self) -> float: ...
        @property
        def dof(self) -> float: ...
        @property
        def reach(self) -> float: ...
    else:
        mean, dof, reach = 0.0, math.inf, math.inf

    def cdf(self, x: ArrayLike) -> Array:
        """Return P(X <= x), elementwise."""
        x = np.asarray(x, float)
        return self._cdf(x / self.scale) if self.scale else np.where(x >= 0, 1.0, 0.0)

    def isf(self, p: ArrayLike) -> Array:
        """Return the value exceeded with probability p in (0, 1), elementwise; keeps its accuracy for tiny p."""
        return self.scale * self._isf(np.asarray(p, float))

    def quantile(self, p: ArrayLike) -> Array:
        """Return the value not exceeded with probability p, elementwise."""
        return -self.isf(p)

    def cf(self, t: ArrayLike) -> Array:
        """Return the characteristic function E exp(i t X), elementwise; t in 1 / unit of X."""
        return self._cf(np.abs(self.scale * np.asarray(t, float)))

    def bound(self, t: ArrayLike) -> Array:
        """Return a bound on |cf| that falls with |t|, elementwise."""
        return self._bound(np.abs(self.scale * np.asarray(t, float)))

    def _cdf(self, x: Array) -> Array:
        raise NotImplementedError

    def _isf(self, p: Array) -> Array:
        raise NotImplementedError

    def _cf(self, t: Array) -> Array:
        raise NotImplementedError

    def _bound(self, t: Array) -> Array:
        return self._cf(t)
