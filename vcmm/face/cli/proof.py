"""The proof of a rewritten program: it is cut and inspected before it is written."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

NO_PART = (
    "program and set-up do not say what part is cut: name a cutting scenario (part, stock, tools) instead of the program, or cut the new "
    "program with vcmm cut SCENARIO --inspect PROGRAM"
)


def proved_by_cut(scenario: Any, data: bytes, suffix: str, allowed: float) -> Any:
    """The proof (vcmm.shop.machining.proof) of a new program that is not written yet. scenario: None where the part is not known.

    Raises ModelLimit where the part comes out worse than with the program as it is.
    """
    from vcmm.core.errors import ModelLimit
    from vcmm.shop.machining.proof import proof_without_inspection

    if scenario is None:
        return proof_without_inspection(NO_PART)
    proof = proof_of(scenario, data, suffix, allowed)
    if proof.worse:
        raise ModelLimit(
            f"{scenario.program}: cut and inspected, the part of the new program is worse than that of the program as it is: {proof.worse}; nothing was "
            "written. Correct the finished surface too (--surface), or leave the program as it is"
        )
    return proof


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
