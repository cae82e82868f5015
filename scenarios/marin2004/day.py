"""A drawn day of a machining centre: heat, temperature sensors, thermal parameters, and their regression on the sensors.

Nodes of the structure warm as first-order lags of what heats them; the thermal parameters follow the nodes, one of them
bent a little; the sensors sit beside the nodes, see their neighbours and read with noise. So the regression cannot be
exact, as on a real machine. Everything is drawn: the paper publishes neither sensors, days nor coefficients.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm import Array, Series, calibration
from vcmm.core.run import T0_DEG_C, first_order_lag

MINUTES = 480
SENSORS = ("spindle", "column", "screw X", "screw Y", "bed", "air")
LAGS = (25.0, 90.0, 40.0, 40.0, 180.0, 0.0)  # min, of the nodes
BESIDE, NEIGHBOUR, NOISE = 5.0, 0.1, 0.05  # min from node to sensor; share of the next node seen; K
PARAMETERS = ("EZZ", "EYZ", "EAZ", "EXX per m", "EYY per m", "EZZ per m")
UNITS = ("um", "um", "urad", "um/m", "um/m", "um/m")
GAINS = np.array(  # um or urad (per m) per kelvin: rows as PARAMETERS, columns as SENSORS
    [
        [-1.6, -0.6, 0.0, 0.0, 0.3, 0.2],
        [0.0, 0.9, 0.0, 0.0, -0.2, 0.0],
        [0.0, 1.2, 0.0, 0.0, -0.6, 0.0],
        [0.0, 0.0, 5.0, 0.0, 1.5, 0.0],
        [0.0, 0.0, 0.0, 5.0, 1.5, 0.0],
        [0.0, 4.0, 0.0, 0.0, 0.0, 1.0],
    ]
)
BENT = 0.015  # 1/K: quadratic share of the spindle in EZZ


@dataclass(frozen=True, eq=False)
class Day:
    """minute (m,); nodes, sensors (m, 6) degC; parameters (m, 6) in UNITS, zero at 20 degC."""

    minute: Array
    nodes: Array
    sensors: Array
    parameters: Array


@dataclass(frozen=True, eq=False)
class Regression:
    """parameters = (sensors - 20) B, least squares; B (6 lags, 6). No constant: at 20 degC all round nothing is moved.

    lags: minutes before now of the readings that are used, 0 = now; a sensor reads late, and its past tells by how much.
    """

    coefficients: Array
    lags: tuple[int, ...] = (0,)

    def at(self, sensors: Array) -> Array:
        """Parameters (..., 6) for sensor readings (..., 6 lags) degC, those of now first."""
        return (sensors - T0_DEG_C) @ self.coefficients

    def over(self, today: Day) -> Array:
        """Parameters (m, 6) for every minute of a day."""
        return self.at(read_before(today.sensors, self.lags))


def day(seed: int, beside: float = BESIDE, bent: float = BENT) -> Day:
    """One working day: the spindle and the axes run in drawn stretches, the air follows the hall.

    beside: lag of a sensor behind its node, minutes; bent: quadratic share of the spindle in the first parameter, 1/K.
    """
    rng = np.random.default_rng([seed, 20040521])
    minute = np.arange(MINUTES + 1.0)
    spindle, x, y = (_stretches(rng, minute) for _ in range(3))
    air = T0_DEG_C + rng.uniform(1.0, 3.0) * np.sin(2 * np.pi * (minute - rng.uniform(0, 60)) / 960.0)
    air = air - air[0] + T0_DEG_C
    heat = (12.0 * spindle, 4.0 * spindle, 6.0 * x, 6.0 * y, 1.0 * spindle, 0.0 * spindle)
    nodes = np.stack([lagged(minute, air + h, lag) for h, lag in zip(heat, LAGS)], axis=1)
    late = np.stack([lagged(minute, n, beside) for n in nodes.T], axis=1)
    seen = (1 - NEIGHBOUR) * late + NEIGHBOUR * np.roll(late, 1, axis=1)
    return Day(minute, nodes, seen + NOISE * rng.normal(size=seen.shape), true_parameters(nodes, bent))


def _stretches(rng: np.random.Generator, minute: Array) -> Array:
    """Load between 0 and 1, constant over drawn stretches of 20 to 90 minutes; at rest for the first ten."""
    edges = np.append(10.0, 10.0 + np.cumsum(rng.uniform(20, 90, 30)))
    level = np.append(0.0, np.where(rng.random(30) < 0.25, 0.0, rng.uniform(0.3, 1.0, 30)))
    return np.asarray(level[np.searchsorted(edges[:-1], minute, side="right")])


def lagged(minute: Array, heated: Array, lag: float) -> Array:
    """First-order lag (m,) of a temperature given every minute; lag in minutes."""
    return heated if lag == 0.0 else first_order_lag(Series(minute * 60.0, heated), lag * 60.0, minute * 60.0)


def true_parameters(nodes: Array, bent: float = BENT) -> Array:
    """What the structure really does (m, 6) at node temperatures (m, 6)."""
    warm = nodes - T0_DEG_C
    out = warm @ GAINS.T
    out[:, 0] -= bent * warm[:, 0] ** 2
    return np.asarray(out)


def read_before(sensors: Array, lags: Sequence[int]) -> Array:
    """Readings (m, 6 lags) of now and of so many minutes before; before the first minute the first one stands."""
    now = np.arange(len(sensors))
    return np.concatenate([sensors[np.maximum(now - lag, 0)] for lag in lags], axis=1)


def regression(days: Sequence[Day], lags: tuple[int, ...] = (0,)) -> Regression:
    """Least squares over all minutes of some days."""
    warm = np.concatenate([read_before(d.sensors, lags) for d in days]) - T0_DEG_C
    known = np.concatenate([d.parameters for d in days])
    return Regression(np.linalg.lstsq(warm, known, rcond=None)[0], lags)


@dataclass(frozen=True, eq=False)
class NetworkModel:
    """Parameters (m, 6) from sensor readings by a net: the paper's other choice. lags as of `Regression`."""

    net: calibration.AxisNet
    lags: tuple[int, ...]

    def over(self, today: Day) -> Array:
        """Parameters (m, 6) for every minute of a day."""
        return self.net.at(read_before(today.sensors, self.lags))


def network(days: Sequence[Day], lags: tuple[int, ...] = (0,), epochs: int = 4000) -> NetworkModel:
    """One hidden layer of 2i+1 neurons, back-propagation with momentum, on every fourth minute of some days."""
    x = np.concatenate([read_before(d.sensors, lags) for d in days])[::4]
    y = np.concatenate([d.parameters for d in days])[::4]
    return NetworkModel(
        calibration.train_net(x, y, calibration.BEST_LAYOUT, np.random.default_rng(0), epochs), lags
    )
