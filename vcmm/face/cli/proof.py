"""Prove a rewritten program: cut and inspect it before it is written."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from math import sqrt
from pathlib import Path

from vcmm.compensation.result import CompensatedProgram
from vcmm.compensation.surface import SurfaceErrors, refined_surface
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.units import quantity
from vcmm.shop.machining.proof import CutProof, proof_by_cut, proof_without_inspection
from vcmm.task.measuring.cut_scenario import CutScenario

NO_PART = (
    "program and set-up do not say what part is cut: name a cutting scenario (part, stock, tools) instead of the program, or cut the new "
    "program with vcmm cut SCENARIO --inspect PROGRAM"
)


ROUNDS = 4  # of further corrections of the finished surface: at corners, where moves share a shift, each leaves about half


def in_rounds(
    scenario: CutScenario | None,
    surface: SurfaceErrors | None,
    suffix: str,
    tolerance: float,
    make: Callable[[SurfaceErrors | None], CompensatedProgram],
) -> tuple[CompensatedProgram, CutProof]:
    """Correct until the part is within tolerance, at most `ROUNDS` times; keep the best program and its proof.

    make: from surface errors (or None) to the program. scenario: None where the part is not known.
    """
    made = make(surface)
    if scenario is None:
        return made, proof_without_inspection(NO_PART)
    proof = _proof_of_made(scenario, made, suffix, tolerance)
    last = made
    for _ in range(ROUNDS):
        if surface is None or proof.after is None or proof.is_met:
            break
        surface = _refine(scenario, surface, last.data, suffix)
        last = make(surface)
        again = _proof_of_made(scenario, last, suffix, tolerance)
        if again.after is not None and again.after.largest < proof.after.largest:
            made, proof = last, again
    return made, proof


def _proof_of_made(
    scenario: CutScenario, made: CompensatedProgram, suffix: str, tolerance: float
) -> CutProof:
    digits = min(made.rounding.largest, sqrt(3.0) * made.rounding.step)
    return proof_of(scenario, made.data, suffix, tolerance + digits)


def _refine(scenario: CutScenario, surface: SurfaceErrors, data: bytes, suffix: str) -> SurfaceErrors:
    with tempfile.TemporaryDirectory() as folder:
        new = Path(folder) / f"new{suffix}"
        new.write_bytes(data)
        return refined_surface(scenario, surface, new)


def refuse_worse(program: Path, proof: CutProof) -> None:
    """Raises ModelLimit where the part comes out worse than with the program as it is."""
    if proof.worse:
        raise ModelLimit(
            f"{program}: cut and inspected, the part of the new program is worse than that of the program as it is: {proof.worse}; nothing was "
            "written. Correct the finished surface too (--surface), or leave the program as it is"
        )


def proof_of(scenario: CutScenario, data: bytes, suffix: str, allowed: float) -> CutProof:
    """Return the proof of a new program for the part of a scenario, good or bad."""
    with tempfile.TemporaryDirectory() as folder:
        new = Path(folder) / f"new{suffix}"
        new.write_bytes(data)
        return proof_by_cut(scenario, new, allowed)


def inspected_program(scenario: CutScenario, program: Path, tolerance: str) -> CutProof:
    """Prove a program of a file for --inspect. Raises UsageError for a tolerance that is none."""
    allowed = quantity(tolerance, "length", "--tolerance", "1 um")
    if not allowed > 0:
        raise UsageError(f'--tolerance "{tolerance}" must be more than nothing, for example "1 um"')
    return proof_by_cut(scenario, program, allowed)
