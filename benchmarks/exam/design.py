"""A measuring design: where the machine stood and all that was logged, before anything is observed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from benchmarks.exam.kinema import Array, Errors, tip
from benchmarks.exam.machines import Kind


@dataclass(frozen=True, eq=False)
class Design:
    """q: axis positions (mm, rad) per row. n: outward normals or sensitive directions, None for x y z observations.
    columns: what the file holds beyond positions; labels likewise. hidden: facts that the file does not hold.
    nodes: positions (k, 3) of X Y Z that the machine passed, and `row_node`, the node of each row."""

    name: str
    machine: Kind
    kind: str
    observed: str
    q: Mapping[str, Array]
    offset: Array
    normal: Array | None
    columns: Mapping[str, Array] = field(default_factory=dict)
    labels: Mapping[str, Sequence[str]] = field(default_factory=dict)
    nuisance: Mapping[str, str] = field(default_factory=dict)
    series: Mapping[str, Array] = field(default_factory=dict)
    hidden: Mapping[str, Array] = field(default_factory=dict)
    nodes: Array | None = None
    row_node: Array | None = None
    dead: tuple[str, ...] = ()

    @property
    def rows(self) -> int:
        return len(self.offset)

    @property
    def sign(self) -> float:
        return -1.0 if self.observed == "indicated - true" else 1.0

    def nominal_tip(self) -> Array:
        return tip(self.machine.chain, self.q, self.offset, Errors())

    def codes(self, label: str) -> Array:
        if label == "":
            return np.zeros(self.rows, dtype=int)
        return np.unique(np.array(self.labels[label]), return_inverse=True)[1]

    def get(self, name: str) -> Array:
        """A column, a hidden fact, or a logged series at the rows' times."""
        for place in (self.columns, self.hidden):
            if name in place:
                return np.asarray(place[name], dtype=float)
        return np.interp(self.columns["time_s"], self.series["time_s"], self.series[name])


def since_reversal(nodes: Array) -> tuple[Array, Array]:
    """Sense and distance since the last reversal of each axis at each node of a straight-line path, (k, 3) each."""
    sense, since = np.ones(nodes.shape), np.zeros(nodes.shape)
    for i in range(1, len(nodes)):
        step = nodes[i] - nodes[i - 1]
        now = np.where(step == 0, sense[i - 1], np.sign(step))
        sense[i] = now
        since[i] = np.where(now == sense[i - 1], since[i - 1], 0.0) + np.abs(step)
    sense[0] = sense[1] if len(nodes) > 1 else 1.0
    return sense, since


def motion_columns(sense: Array, since: Array, speed: Array, accel: Array) -> dict[str, Array]:
    out = {}
    for i, a in enumerate("XYZ"):
        out[f"sense_{a}"] = sense[:, i]
        out[f"since_reversal_{a}_mm"] = since[:, i]
        out[f"speed_{a}_mm_s"] = speed[:, i]
        out[f"accel_{a}_mm_s2"] = accel[:, i]
    return out


def unit(v: Array) -> Array:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def room(
    rng: np.random.Generator, seconds: float, names: Sequence[str], swing: float = 1.6
) -> dict[str, Array]:
    """A log of temperatures each 60 s: steps and slow waves of the hall, followed by each sensor with its own lag."""
    t = np.arange(0.0, seconds + 61.0, 60.0)
    hall = 21.0 + swing * np.sin(2 * np.pi * t / (seconds * rng.uniform(0.35, 0.8)) + rng.uniform(0, 6.28))
    for _ in range(3):
        hall = hall + rng.normal(0, 0.8 * swing) * (t > rng.uniform(0.05, 0.9) * seconds)
    out = {"time_s": t}
    for name in names:
        lag, wave = rng.uniform(900, 7200), np.zeros(len(t))
        own = (
            hall
            + rng.normal(0, 0.3)
            + 0.5 * swing * np.sin(2 * np.pi * t / rng.uniform(4e3, 2e4) + rng.uniform(0, 6.28))
        )
        wave[0] = own[0]
        for i in range(1, len(t)):
            wave[i] = wave[i - 1] + (own[i] - wave[i - 1]) * (1 - np.exp(-60.0 / lag))
        out[name] = wave
    if "temp_gradient_C" in out:
        out["temp_gradient_C"] = out["temp_gradient_C"] - out["temp_gradient_C"].mean()
    return out
