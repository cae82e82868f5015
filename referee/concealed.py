"""What is concealed in a cut part: effects that have a name, and mechanisms that have none, as shapes of the tip or of the tool."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from referee.cutter import Moment

Array = NDArray[np.float64]
TEETH = {1: 4, 2: 3}  # of the mills of `vcmm new measured_block`
Shape = Callable[[Moment, Array], tuple[Array, Array]]


def _along(
    direction: tuple[float, float, float], amount: Callable[[Moment, np.random.Generator], Array]
) -> Callable:
    """An effect that moves the tip along a direction of the workpiece."""

    def draw(rng: np.random.Generator) -> Shape:
        seed = int(rng.integers(2**31))
        return lambda m, n: (
            np.outer(amount(m, np.random.default_rng(seed)), direction),
            np.zeros(len(m.time)),
        )

    return draw


def _pushed(amount: Callable[[Moment, np.random.Generator], Array]) -> Callable:
    """An effect that moves the tip by a vector of the workpiece."""

    def draw(rng: np.random.Generator) -> Shape:
        seed = int(rng.integers(2**31))
        return lambda m, n: (amount(m, np.random.default_rng(seed)), np.zeros(len(m.time)))

    return draw


def _grown(amount: Callable[[Moment, np.random.Generator], Array]) -> Callable:
    """An effect that makes the tool larger (it cuts deeper into walls)."""

    def draw(rng: np.random.Generator) -> Shape:
        seed = int(rng.integers(2**31))
        return lambda m, n: (np.zeros_like(m.q), amount(m, np.random.default_rng(seed)))

    return draw


def _bends(m: Moment, rng: np.random.Generator) -> Array:
    """Both mills give way alike to the force across their axis."""
    return m.force


def _chip(m: Moment) -> Array:
    """Feed per tooth, mm."""
    teeth = np.array([TEETH[int(t)] for t in m.tool])
    return m.feed / np.maximum(m.speed, 1) / teeth


def _creep(m: Moment, rng: np.random.Generator) -> Array:
    """A clamp that yields twice, in stretches of the logarithm of time."""
    first, second = np.sort(rng.uniform(200, 2000, 2))
    after = lambda start: np.log1p(np.clip(m.time - start, 0, None) / 20)  # noqa: E731
    return after(first) - 1.5 * after(second)


def _wander(m: Moment, rng: np.random.Generator) -> Array:
    """A drive that settles anew at every move and remembers little."""
    steps = np.zeros(1000)
    for i, shock in enumerate(rng.normal(size=1000)):
        steps[i] = 0.6 * steps[i - 1] + shock
    return steps[m.block]


def _gusts(m: Moment, rng: np.random.Generator) -> Array:
    """Draughts at an open door: pulses of some minutes."""
    begins, lasts = rng.uniform(0, 2400, 4), rng.uniform(60, 200, 4)
    return np.sum([np.exp(-(((m.time - b) / w) ** 2)) for b, w in zip(begins, lasts, strict=True)], axis=0)


def _dent(m: Moment, rng: np.random.Generator) -> Array:
    """A guideway with a local bruise, over X and Y."""
    x, y = rng.uniform(-60, 60), rng.uniform(-45, 45)
    return np.exp(-(((m.q[:, 0] - x) / 12) ** 2 + ((m.q[:, 1] - y) / 12) ** 2))


@dataclass(frozen=True)
class Concealed:
    """One effect: how it is drawn, and the starts of names (effect[place]) that are right; none for what has no name."""

    draw: Callable[[np.random.Generator], Shape]
    names: tuple[str, ...] = ()


NAMED = {
    "growth": Concealed(
        _along((0, 0, -1), lambda m, r: 1 - np.exp(-m.time / r.uniform(500, 1500))), ("spindle_growth",)
    ),
    "scale_y": Concealed(
        _along((0, 1, 0), lambda m, r: m.q[:, 1]), ("scale_factor[Y]", "geometric_change[EYY]")
    ),
    "square": Concealed(
        _along((1, 0, 0), lambda m, r: -m.q[:, 1]),
        ("squareness[C0Y]", "geometric_change[C0Y]", "geometric_change[EXY]"),
    ),
    "play_x": Concealed(_along((1, 0, 0), lambda m, r: m.sense[:, 0] / 2), ("backlash[X", "lost_motion[X")),
    "play_y": Concealed(_along((0, 1, 0), lambda m, r: m.sense[:, 1] / 2), ("backlash[Y", "lost_motion[Y")),
    "lag_y": Concealed(_along((0, 1, 0), lambda m, r: -m.velocity[:, 1]), ("servo_lag[Y",)),
    "radius": Concealed(_grown(lambda m, r: np.where(m.tool == 1, 1.0, 0.0)), ("tool_radius[1",)),
    "wear": Concealed(_grown(lambda m, r: np.where(m.tool == 1, -m.way, 0.0)), ("tool_wear",)),
    "bending": Concealed(_pushed(_bends), ("tool_deflection",)),
    "bow": Concealed(
        _along((0, 1, 0), lambda m, r: (m.q[:, 0] / 75) ** 2), ("straightness[EYX]", "geometric_change[EYX]")
    ),
    "drift_x": Concealed(_along((1, 0, 0), lambda m, r: m.time), ("linear_drift[x", "linear_drift[X")),
    "length": Concealed(_along((0, 0, -1), lambda m, r: np.where(m.tool == 2, 1.0, 0.0)), ("tool_length[2",)),
}
UNNAMED = {
    "creep": Concealed(_along((0.6, 0.8, 0), _creep)),
    "wander": Concealed(_along((0, 1, 0), _wander)),
    "gusts": Concealed(_along((0.5, -0.2, 0.84), _gusts)),
    "dent": Concealed(_along((0.7, 0.7, 0), _dent)),
    "shrinking": Concealed(_grown(lambda m, r: -(_chip(m) ** 0.75))),
}
