"""What is said of numbers in a machine file that are out of the usual range, or stand twice."""

from __future__ import annotations

import pytest

from vcmm.files.own.machine import repeatability_remarks
from vcmm.files.own.machine_tables import MachineFile

RANDOM = {"effect": "residual_field", "parameter": "random", "redraw": "touch"}
SYSTEMATIC = {**RANDOM, "parameter": "systematic", "redraw": "machine"}


def machine(**repeatability: object) -> MachineFile:
    travel = {"travel": ["0 mm", "500 mm"]}
    stated = {"repeatability": repeatability} if repeatability else {}
    return MachineFile.model_validate(
        {"vcmm": "machine/1", "structure": "w b Y X Z t", "axes": dict.fromkeys("XYZ", travel), **stated}
    )


@pytest.mark.parametrize(
    ("law", "remark"),
    [
        ({"law": "normal", "u": "0.9 um"}, ""),
        ({"law": "normal", "u": "50 um"}, ""),  # a hand-held arm
        ({"law": "normal", "u": "0.9 mm"}, '[repeatability] u = "0.9 mm"'),  # 900 um: um was meant
        ({"law": "t", "scale": "0.2 mm", "dof": 6}, '[repeatability] scale = "0.2 mm"'),
    ],
)
def test_a_scatter_out_of_the_usual_range(law: dict[str, object], remark: str) -> None:
    said = repeatability_remarks(machine(**law), [])
    assert (said == ()) if not remark else said[0].startswith(remark)


def test_scatter_that_stands_twice() -> None:
    """The random share of a field of nodes and the repeatability act on the same touches; either alone is told once."""
    assert "counted twice" in repeatability_remarks(machine(u="0.9 um"), [SYSTEMATIC, RANDOM])[0]
    assert repeatability_remarks(machine(u="0.9 um"), [SYSTEMATIC]) == ()
    assert repeatability_remarks(machine(), [SYSTEMATIC, RANDOM]) == ()
