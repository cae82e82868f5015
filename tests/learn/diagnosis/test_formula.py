"""A formula found in what the named terms leave, as text: numbers by hand."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.learn.diagnosis.unknown_shapes import Atom, _formula_text


@pytest.mark.parametrize(("kind", "first", "second"), [("angle", "-3", "+2"), ("points", "-0.003", "+0.002")])
def test_the_numbers_of_a_formula_in_um_or_urad(kind: str, first: str, second: str) -> None:
    """0.5e-6 rad x 4 = 2 urad and 0.5e-6 rad x -6 = -3 urad; in mm the same numbers are 0.002 um and -0.003 um. Largest first."""
    atoms = [Atom("x", np.zeros((3, 2)), ("a", "b"))]
    longer = SimpleNamespace(
        fit=SimpleNamespace(mean=np.array([9.0, 4.0, -6.0])), terms=[None, None], span=lambda i: slice(1, 3)
    )
    assert _formula_text(atoms, longer, "Z", 0.5e-6, kind) == f"({first} b {second} a) in Z"
