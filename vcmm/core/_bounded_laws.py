"""Bounded symmetric probability laws (JCGM 101:2008, 6.4.2 to 6.4.6); public names in vcmm.core.laws."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from vcmm.core._law import Array, Law, check_number
from vcmm.core.errors import UsageError


class _Symmetric(Law):
    """Laws given at unit scale by the upper tail `_tail(x)`, x >= 0, and its inverse `_flank(q)`."""

    if TYPE_CHECKING:

        @property
        def half_width(self) -> float: ...

    @property
    def scale(self) -> float:
        return self.half_width

    @property
    def reach(self) -> float:
        return self.half_width

    def _cdf(self, x: Array) -> Array:
        return np.where(x < 0, self._tail(np.abs(x)), 1 - self._tail(np.abs(x)))

    def _isf(self, p: Array) -> Array:
        x = self._flank(np.minimum(p, 1 - p))
        return np.where(p <= 0.5, x, -x)

    def _tail(self, x: Array) -> Array:
        raise NotImplementedError

    def _flank(self, q: Array) -> Array:
        raise NotImplementedError


class _Trapezium(_Symmetric):
    """Sum of two uniform laws of half widths (1 + b) / 2 and (1 - b) / 2; b = half width of the plateau."""

    if TYPE_CHECKING:

        @property
        def b(self) -> float: ...

    def __post_init__(self) -> None:
        check_number(self.name, "half_width", self.half_width)

    @property
    def u(self) -> float:
        """JCGM 101, 6.4.4: u^2 = a^2 (1 + b^2) / 6."""
        return self.half_width * math.sqrt((1 + self.b**2) / 6)

    def _tail(self, x: Array) -> Array:
        x = np.minimum(x, 1.0)
        side = (1 - x) ** 2 / max(2 * (1 - self.b**2), 1e-300)
        return np.where(x <= self.b, 0.5 - x / (1 + self.b), side)

    def _flank(self, q: Array) -> Array:
        side = 1 - np.sqrt(2 * q * (1 - self.b**2))
        return np.where(q < (1 - self.b) / (2 * (1 + self.b)), side, (0.5 - q) * (1 + self.b))

    def _cf(self, t: Array) -> Array:
        t = t / (2 * math.pi)
        return np.asarray(np.sinc((1 + self.b) * t) * np.sinc((1 - self.b) * t))

    def _bound(self, t: Array) -> Array:
        return np.asarray(1 / np.maximum(1, (1 + self.b) * t / 2) / np.maximum(1, (1 - self.b) * t / 2))


@dataclass(frozen=True)
class Uniform(_Trapezium):
    """Rectangular law on +-half_width (JCGM 101, 6.4.2): u = half_width / sqrt 3."""

    half_width: float = field()
    name, b = "uniform", 1.0
    shape = property(lambda self: Uniform(1.0))


@dataclass(frozen=True)
class Triangular(_Trapezium):
    """Triangular law on +-half_width (JCGM 101, 6.4.5): u = half_width / sqrt 6."""

    half_width: float = field()
    name, b = "triangular", 0.0
    shape = property(lambda self: Triangular(1.0))


@dataclass(frozen=True)
class Trapezoidal(_Trapezium):
    """Symmetric trapezoid (JCGM 101, 6.4.4) with base +-half_width and plateau +-top."""

    half_width: float = field()
    top: float = field()
    name = "trapezoidal"
    shape = property(lambda self: Trapezoidal(1.0, self.b))

    def __post_init__(self) -> None:
        super().__post_init__()
        check_number(self.name, "top", self.top)
        if self.top > self.half_width:
            raise UsageError(
                f"Law {self.name}: top = {self.top} must not exceed half_width = {self.half_width}."
            )

    @property
    def b(self) -> float:
        return self.top / self.half_width if self.half_width else 1.0


@dataclass(frozen=True)
class Arcsine(_Symmetric):
    """U-shaped law of a sine wave at a random phase (JCGM 101, 6.4.6): u = half_width / sqrt 2."""

    half_width: float = field()
    name = "arcsine"
    unimodal = False
    shape = property(lambda self: Arcsine(1.0))

    def __post_init__(self) -> None:
        check_number(self.name, "half_width", self.half_width)

    @property
    def u(self) -> float:
        return self.half_width / math.sqrt(2.0)

    def _tail(self, x: Array) -> Array:
        return np.asarray(np.arccos(np.minimum(x, 1.0)) / math.pi)

    def _flank(self, q: Array) -> Array:
        return np.asarray(np.cos(math.pi * q))

    def _cf(self, t: Array) -> Array:
        from scipy.special import j0

        return np.asarray(j0(t))

    def _bound(self, t: Array) -> Array:
        return np.asarray(np.minimum(1.0, np.sqrt(2 / math.pi / np.maximum(t, 0.5))))


@dataclass(frozen=True)
class CurvilinearTrapezoidal(_Symmetric):
    """Rectangular law whose half width is itself known to +-inexact only (JCGM 101, 6.4.3).

    The half width w is uniform on half_width +- inexact, then X is uniform on +-w:
    u^2 = half_width^2 / 3 + inexact^2 / 9.
    """

    half_width: float = field()
    inexact: float = field()
    name = "curvilinear trapezoidal"
    shape = property(lambda self: CurvilinearTrapezoidal(1.0, self._d))

    def __post_init__(self) -> None:
        check_number(self.name, "half_width", self.half_width)
        check_number(self.name, "inexact", self.inexact)
        if self.inexact >= self.half_width > 0:
            text = f"inexact = {self.inexact} must be smaller than half_width = {self.half_width}"
            raise UsageError(f"Law {self.name}: {text}.")

    @property
    def _d(self) -> float:
        return self.inexact / self.half_width if self.half_width else 0.0

    @property
    def u(self) -> float:
        return math.sqrt(self.half_width**2 / 3 + self.inexact**2 / 9)

    @property
    def reach(self) -> float:
        return self.half_width + self.inexact

    def _tail(self, x: Array) -> Array:
        """Return the mean of (w - x) / (2 w) over the half widths w > x."""
        d = max(self._d, 1e-5)  # below that the rectangular law, to 1e-10
        x = np.minimum(x, 1 + d)
        low = np.maximum(x, 1 - d)
        return np.asarray(((1 + d - low) - x * np.log((1 + d) / low)) / (4 * d))

    def _flank(self, q: Array) -> Array:
        low, high = np.zeros_like(q), np.full_like(q, 1 + max(self._d, 1e-5))
        for _ in range(56):  # bisection: the tail falls strictly
            middle = (low + high) / 2
            above = self._tail(middle) > q
            low, high = np.where(above, middle, low), np.where(above, high, middle)
        return (low + high) / 2

    def _cf(self, t: Array) -> Array:
        """Return the mean of sin(w t) / (w t) over w: a difference of sine integrals."""
        from scipy.special import sici

        d, t = max(self._d, 1e-5), np.maximum(t, 1e-9)
        return np.asarray((sici((1 + d) * t)[0] - sici((1 - d) * t)[0]) / (2 * d * t))

    def _bound(self, t: Array) -> Array:
        d = max(self._d, 1e-5)
        return np.asarray(1 / np.maximum(1.0, np.maximum((1 - d) * t, d * t / 0.926)))
