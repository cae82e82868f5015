"""Parts, noise and files from outside: nothing of vcmm is imported here, so that nothing of its assumptions is shared."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

SCENARIO = """vcmm = "scenario/1"
[machine]
structure = "w b Y X Z t"
[machine.axes.X]
travel = ["0 mm", "600 mm"]
[machine.axes.Y]
travel = ["0 mm", "500 mm"]
[machine.axes.Z]
travel = ["-400 mm", "0 mm"]
[machine.repeatability]
{law}
[pose]
shift = "300 250 -200 mm"
[part.features]
{features}
{characteristics}
[plan]
styli.down = {{ offset = "0 0 -100 mm", tip_diameter = "2 mm" }}
[[plan.steps]]
feature = "{first}"
stylus = "down"
points = {points}
[job]
trials = 2000
"""
NORMAL, T3 = 'law = "normal"\nu = "1 um"', 'law = "t"\nscale = "0.6 um"\ndof = 3'
RING = (
    '{name} = {{ type = "circle", point = "0 0 0 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true }}'
)
BORE = (
    '{name} = {{ type = "cylinder", point = "0 0 -20 mm", axis = [0, 0, 1], diameter = "30 mm", length = "20 mm", '
    "inside = true }}"
)


def scenario(kind: str = RING, law: str = NORMAL, name: str = "ring", form: bool = False) -> str:
    wanted = [("diameter", "size", 'limits = ["-0.02 mm", "0.02 mm"]')]
    if form:
        wanted.append(("form", "roundness" if kind == RING else "cylindricity", 'zone = "0.03 mm"'))
    table = [
        f'[[part.characteristics]]\nname = "{n}"\ntype = "{t}"\nof = "{name}"\n{z}' for n, t, z in wanted
    ]
    return SCENARIO.format(
        law=law, features=kind.format(name=name), characteristics="\n".join(table), first=name,
        points='{ strategy = "even", n = 24 }' if kind == RING else '{ strategy = "levels", at = ["5 mm", "15 mm"], n = 8 }',
    )  # fmt: skip


def normal(rng: np.random.Generator, n: int) -> np.ndarray:
    return 1e-3 * rng.normal(size=n)


def student3(rng: np.random.Generator, n: int) -> np.ndarray:
    return 0.6e-3 * rng.standard_t(3, size=n)


def remembered(rho: float) -> Callable[[np.random.Generator, int], np.ndarray]:
    """Noise of 1 um with e_t = rho e_(t-1) + a_t."""

    def noise(rng: np.random.Generator, n: int) -> np.ndarray:
        out = rng.normal(size=n)
        for i in range(1, n):
            out[i] = rho * out[i - 1] + np.sqrt(1 - rho**2) * out[i]
        return 1e-3 * out

    return noise


def lobed(
    lobes: int, amplitude: float
) -> Callable[[np.ndarray, np.ndarray, np.random.Generator], np.ndarray]:
    def form(a: np.ndarray, z: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        return amplitude * np.cos(lobes * a + rng.uniform(0, 2 * np.pi))

    return form


def perfect(a: np.ndarray, z: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    return np.zeros_like(a)


def bowed(a: np.ndarray, z: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A barrel of 2 um with three lobes of 1 um."""
    return 2e-3 * ((z + 10) / 10) ** 2 + 1e-3 * np.cos(3 * a + rng.uniform(0, 6))


def bore(
    rng: np.random.Generator, n: int, levels: int = 1, form: Callable = perfect, noise: Callable = normal
) -> np.ndarray:
    """Points (n, 3) of a bore of 30 mm, level after level; shift and size of the part are unknown to the machine."""
    around = n // levels
    a = np.tile(np.arange(around) * 2 * np.pi / around + rng.uniform(0, 6), levels)
    z = np.repeat(np.linspace(-18, -2, levels) if levels > 1 else np.zeros(1), around)
    material = form(a, z, rng) + noise(rng, n)  # outwards of the material: towards the axis
    r = 15.0 + rng.uniform(-0.005, 0.005) - material
    x, y = rng.uniform(-0.01, 0.01, 2)
    return np.stack([x + r * np.cos(a), y + r * np.sin(a), z], axis=1)


def rows(points: np.ndarray, name: str = "ring", part: str = "", digits: int = 7) -> list[str]:
    first = f"{part}," if part else ""
    return [f"{first}{name}," + ",".join(f"{c:.{digits}f}" for c in p) for p in points]


def csv(lines: list[str], part: bool = False) -> str:
    return "\n".join([f"{'part,' if part else ''}feature,x_mm,y_mm,z_mm", *lines]) + "\n"
