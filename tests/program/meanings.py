"""Short programs and what they mean, for the tests of the G-code family."""

from __future__ import annotations

from vcmm.program.interpret import interpret
from vcmm.program.moves import Move
from vcmm.program.setup import Setup, Tool

ONE = Setup(
    offsets={"G54": (100.0, 50.0, -200.0), "G55": (10.0, 20.0, 30.0), "G54.1 P3": (1.0, 2.0, 3.0)},
    tools={1: Tool(1, 80.0, 10.0), 2: Tool(2, 100.0, 6.0)},
)


def linuxcnc(text: str, setup: Setup | None = None) -> tuple[Move, ...]:
    return interpret(f"{text}\nM2", "linuxcnc", setup).moves


def fanuc(text: str, setup: Setup | None = None) -> tuple[Move, ...]:
    return interpret(f"{text}\nM30", "fanuc", setup).moves


def ends(moves: tuple[Move, ...]) -> list[tuple[float, ...]]:
    return [m.end for m in moves]
