"""The proof of a rewritten program: it is cut and inspected before it is written."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from math import sqrt
from pathlib import Path
from typing import Any

NO_PART = (
    "program and set-up do not say what part is cut: name a cutting scenario (part, stock, tools) instead of the program, or cut the new "
    "program with vcmm cut SCENARIO --inspect PROGRAM"
)


ROUNDS = 4  # of further corrections of the finished surface: at corners, where moves share a shift, each leaves about half


def in_rounds(
    scenario: Any, surface: Any, suffix: str, tolerance: float, make: Callable[[Any], Any]
) -> tuple[Any, Any]:
    """The new program and its proof: where the finished surface is corrected and the part is not yet within what is allowed, what it still
    departs by is corrected once more, up to `ROUNDS` times; the best of these is kept. make: from surface errors (or None) to the program; scenario: None where the part is not
    known."""
    from vcmm.shop.machining.proof import proof_without_inspection

    made = make(surface)
    if scenario is None:
        return made, proof_without_inspection(NO_PART)
    proof = _proof_of_made(scenario, made, suffix, tolerance)
    last = made
    for _ in range(ROUNDS):
        if surface is None or proof.after is None or proof.met:
            break
        surface = _refine(scenario, surface, last.data, suffix)
        last = make(surface)
        again = _proof_of_made(scenario, last, suffix, tolerance)
        if again.after is not None and again.after.largest < proof.after.largest:
            made, proof = last, again
    return made, proof


def _proof_of_made(scenario: Any, made: Any, suffix: str, tolerance: float) -> Any:
    digits = min(made.rounding.largest, sqrt(3.0) * made.rounding.step)
    return proof_of(scenario, made.data, suffix, tolerance + digits)


def _refine(scenario: Any, surface: Any, data: bytes, suffix: str) -> Any:
    from vcmm.compensation.surface import refined_surface

    with tempfile.TemporaryDirectory() as folder:
        new = Path(folder) / f"new{suffix}"
        new.write_bytes(data)
        return refined_surface(scenario, surface, new)


def refuse_worse(scenario: Any, proof: Any) -> None:
    """Raises ModelLimit where the part comes out worse than with the program as it is."""
    from vcmm.core.errors import ModelLimit

    if proof.worse:
        raise ModelLimit(
            f"{scenario.program}: cut and inspected, the part of the new program is worse than that of the program as it is: {proof.worse}; nothing was "
            "written. Correct the finished surface too (--surface), or leave the program as it is"
        )


def proof_of(scenario: Any, data: bytes, suffix: str, allowed: float) -> Any:
    """The proof of a new program for the part of a scenario, good or bad."""
    from vcmm.shop.machining.proof import proof_by_cut

    with tempfile.TemporaryDirectory() as folder:
        new = Path(folder) / f"new{suffix}"
        new.write_bytes(data)
        return proof_by_cut(scenario, new, allowed)


def inspected_program(scenario: Any, program: Path, tolerance: str) -> Any:
    """--inspect: the proof of a program that stands in a file. Raises UsageError for a tolerance that is none."""
    from vcmm.core.errors import UsageError
    from vcmm.core.units import quantity
    from vcmm.shop.machining.proof import proof_by_cut

    allowed = quantity(tolerance, "length", "--tolerance", "1 um")
    if not allowed > 0:
        raise UsageError(f'--tolerance "{tolerance}" must be more than nothing, for example "1 um"')
    return proof_by_cut(scenario, program, allowed)
