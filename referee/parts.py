"""Real surfaces of parts: families of form as functions of the place on the surface, so that they can be made dense.

Every form is a departure along the outward normal, mm. Round features are addressed by angle and height (-1 to 1 over
the length), planes and lines by two coordinates from -1 to 1.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Form = Callable[[Array, Array], Array]
FAMILIES = ("perfect", "lobes", "waves", "bow", "scratch", "dent", "cusps", "taper", "twist")


def amplitude(rng: np.random.Generator, noise: float) -> float:
    """Size of a form, from a third of the noise to 20 times the noise, all decades alike."""
    return float(noise * np.exp(rng.uniform(np.log(1 / 3), np.log(20))))


def _round_form(rng: np.random.Generator, family: str, size: float, radius: float, half: float) -> Form:
    """Form of a circle (half = 0) or cylinder."""
    phase, turn = rng.uniform(0, 2 * np.pi, 2)
    lobes = int(rng.integers(2, 8))
    if family == "lobes":
        return lambda a, h: size / 2 * np.cos(lobes * a + phase)
    if family == "waves":
        count = np.arange(2, 31)
        heights = rng.normal(size=29) / count
        heights *= size / 2 / np.sqrt(np.sum(heights**2))
        phases, rise = rng.uniform(0, 2 * np.pi, 29), rng.uniform(-1, 1, 29) * (half > 0)
        return lambda a, h: np.cos(a[..., None] * count + phases + h[..., None] * rise * 3) @ heights
    if family == "bow":
        return lambda a, h: size * (h**2 * np.cos(a - phase) if half else 0.5 * np.cos(2 * (a - phase)))
    if family == "scratch":  # a groove 1 mm wide across the feature, up to three times as deep as other forms
        width, lean, deep = 0.5 / radius, rng.uniform(-0.5, 0.5) * (half > 0), 3 * size * rng.random()
        return lambda a, h: -deep * np.maximum(0, 1 - (_wrap(a - turn - lean * h) / width) ** 2)
    if family == "dent":
        spread, place = rng.uniform(1.5, 5) / radius, rng.uniform(-1, 1) * (half > 0)
        reach = spread * radius / max(half, 1e-9) if half else 1.0
        return lambda a, h: (
            -size * np.exp(-0.5 * (_wrap(a - turn) / spread) ** 2 - 0.5 * ((h - place) / reach) ** 2)
        )
    if family == "cusps":
        return lambda a, h: size * (np.abs(np.cos(lobes * a / 2 + phase)) - 2 / np.pi)
    if family == "taper":
        return lambda a, h: size / 2 * (h + 0.3 * np.cos(3 * a + phase) if half else np.cos(3 * a + phase))
    if family == "twist":
        return lambda a, h: size / 2 * np.cos(lobes * a + phase + (np.pi * h if half else 0))
    return lambda a, h: np.zeros(np.broadcast(a, h).shape)


def _wrap(angle: Array) -> Array:
    """An angle as one from -pi to pi."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def _flat_form(rng: np.random.Generator, family: str, size: float, half: tuple[float, float]) -> Form:
    """Form of a plane or (second half 0) of a line."""
    phase, lean = rng.uniform(0, 2 * np.pi, 2)
    line = half[1] == 0
    cx, cy = (1.0, 0.0) if line else (np.cos(lean), np.sin(lean))
    if family == "lobes":
        count = rng.uniform(0.5, 3)
        return lambda u, v: size / 2 * np.cos(np.pi * count * (cx * u + cy * v) + phase)
    if family == "waves":
        k = rng.uniform(-6, 6, (20, 2)) * (1.0, 0.0 if line else 1.0)
        heights = rng.normal(size=20) / (1 + np.hypot(*k.T))
        heights *= size / 2 / np.sqrt(np.sum(heights**2))
        phases = rng.uniform(0, 2 * np.pi, 20)
        return lambda u, v: (
            np.cos(np.pi * (u[..., None] * k[:, 0] + v[..., None] * k[:, 1]) + phases) @ heights
        )
    if family == "bow":
        a, b = rng.uniform(-1, 1, 2)
        return lambda u, v: size * (u**2 if line else a * u**2 + b * v**2)
    if family == "scratch":
        place, deep, width = rng.uniform(-0.9, 0.9), 3 * size * rng.random(), 0.5 / half[0]
        return lambda u, v: -deep * np.maximum(0, 1 - ((u - place - 0.3 * cy * v) / width) ** 2)
    if family == "dent":
        spread, x, y = rng.uniform(1.5, 8), rng.uniform(-1, 1), rng.uniform(-1, 1) * (not line)
        return lambda u, v: (
            -size * np.exp(-0.5 * (((u - x) * half[0] / spread) ** 2 + ((v - y) * half[1] / spread) ** 2))
        )
    if family == "cusps":
        count = rng.uniform(1, 6)
        return lambda u, v: size * (np.abs(np.sin(np.pi * count * (cx * u + cy * v) / 2 + phase)) - 2 / np.pi)
    if family == "taper":
        return lambda u, v: size / 2 * (u + 0.5 * (3 * u**2 - 1))
    if family == "twist":
        return lambda u, v: size * (u**3 if line else u * v)
    return lambda u, v: np.zeros(np.broadcast(u, v).shape)


class Surface:
    """One real feature: nominal shape, a small tilt and shift, a form.

    Parameters
    ----------
    feature : dict
        `type` (circle, cylinder, plane, line), `point`, `radius`, `length` or `half`, `inside`, `normal`, `u`.
        Round features stand along drawing z.
    rng : Generator
    family : str
        One of `FAMILIES`.
    noise : float
        What the size of forms is counted in, mm.
    move : float
        Size of the drawn departure of place and (over the feature) of direction, mm.
    """

    def __init__(self, feature: dict, rng: np.random.Generator, family: str, noise: float, move: float):
        self.feature = feature
        size = amplitude(rng, noise)
        self.shift = move * rng.uniform(-1, 1, 3)
        self.lean = move * rng.uniform(-1, 1, 2)
        self.round = feature["type"] in ("circle", "cylinder")
        if self.round:
            self.half = feature.get("length", 0.0) / 2
            self.form = _round_form(rng, family, size, feature["radius"], self.half)
            self.grow = move * rng.uniform(-1, 1)
        else:
            self.form = _flat_form(rng, family, size, feature["half"])

    def _frame(self) -> tuple[Array, Array, Array]:
        normal, u = (np.array(self.feature[k], float) for k in ("normal", "u"))
        return normal, u, np.cross(normal, u)

    def at(self, first: Array, second: Array) -> tuple[Array, Array, Array]:
        """Real points, nominal points and nominal outward normals at places of the surface.

        Round: angle and height from -1 to 1. Flat: both coordinates from -1 to 1.
        """
        first, second = np.broadcast_arrays(np.asarray(first, float), np.asarray(second, float))
        point = np.array(self.feature["point"], float)
        if self.round:
            out = np.column_stack([np.cos(first), np.sin(first), np.zeros_like(first)])
            z = self.half * (1 + second)
            nominal = point + self.feature["radius"] * out + np.column_stack([0 * z, 0 * z, z])
            grow = self.grow + self.form(first, second)  # of the radius
            side = self.shift[:2] + (self.lean * second[:, None] if self.half else 0.0)
            real = nominal + out * grow[:, None]
            real[:, :2] += side
            return real, nominal, -out if self.feature["inside"] else out
        normal, u, v = self._frame()
        half = self.feature["half"]
        nominal = point + np.outer(first * half[0], u) + np.outer(second * half[1], v)
        height = self.shift[0] + self.lean[0] * first + (self.lean[1] * second if half[1] else 0.0)
        height = height + self.form(first, second)
        return nominal + np.outer(height, normal), nominal, np.broadcast_to(normal, nominal.shape)

    def dense(self) -> Array:
        """The real surface, so dense that a narrow scratch is met by several points."""
        kind = self.feature["type"]
        if kind == "circle":
            angle = np.arange(2880) * 2 * np.pi / 2880
            return self.at(angle, np.zeros(2880))[0]
        if kind == "cylinder":
            angle, height = np.meshgrid(np.arange(360) * 2 * np.pi / 360, np.linspace(-1, 1, 31))
            return self.at(angle.ravel(), height.ravel())[0]
        if kind == "line":
            place = np.linspace(-1, 1, 1601)
            return self.at(place, np.zeros(1601))[0]
        a, b = np.meshgrid(np.linspace(-1, 1, 241), np.linspace(-1, 1, 61))
        return self.at(a.ravel(), b.ravel())[0]
