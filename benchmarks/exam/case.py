"""One case: what was concealed, with the names and parameters that count as right."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from benchmarks.exam.design import Design
from benchmarks.exam.kinema import Array
from benchmarks.exam.machines import Machine
from benchmarks.exam.observe import Hidden

Build = Callable[[float], Hidden]


@dataclass(frozen=True, eq=False)
class Concealed:
    """build(a): the effect at amplitude a (in `unit` of the catalogue where there is one parameter).

    parameters(a): name -> value in the contract's unit. where: what the answer's place must hold. nested: simpler names
    that count when the data cannot resolve more, with columns (fields of tip motion or reading) that they can mimic.
    """

    effect: str
    build: Build
    parameters: Callable[[float], Mapping[str, tuple[float, str]]] = lambda a: {}
    where: Mapping[str, str] = field(default_factory=dict)
    covariates: tuple[str, ...] = ()
    start: float = 1.0
    sign_free: bool = False
    simpler: Mapping[str, list[Build]] = field(default_factory=dict)
    also: tuple[str, ...] = ()
    note: str = ""


Maker = Callable[[Design, Machine, np.random.Generator], Concealed]


def unit_axis(letter: str) -> Array:
    return np.eye(3)["XYZ".index(letter)]
