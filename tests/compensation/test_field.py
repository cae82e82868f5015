"""The known error along a program by hand, and how a command follows from it."""

from __future__ import annotations

import numpy as np
import pytest

from tests.compensation.mill import mill, scale
from tests.compensation.test_contours import HEAD
from vcmm.compensation.field import field_of, known_errors_of
from vcmm.core.errors import ModelLimit
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.scatter import Scatter
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup

SETUP = Setup(dialect="fanuc", offsets={"G54": (100.0, 0.0, -100.0)})


def field(machine, set_here=True, block="G1 X50."):
    moves = interpret(f"{HEAD}{block} F100\nM30\n%\n", "fanuc", SETUP, "part.nc").moves
    return field_of(known_errors_of(machine), SETUP, moves, set_here=set_here)


def errors(of, x: float) -> np.ndarray:
    move, tip = np.array([1]), np.array([[x, 0.0, -100.0]])
    return of.errors(of.run(move, np.ones(1), tip), move)[0]


def test_a_scale_counts_from_the_zero() -> None:
    """100 um/m: 15 um at X 150 of the machine, less 10 um where the offset at X 100 was set; all 15 um if set elsewhere."""
    assert errors(field(scale(100.0)), 150.0) == pytest.approx([5e-3, 0.0, 0.0], abs=1e-12)
    assert errors(field(scale(100.0), set_here=False), 150.0) == pytest.approx([15e-3, 0.0, 0.0], abs=1e-12)


def test_the_command_makes_the_error_good() -> None:
    """T + 1e-4 (T - 100) = 150: T = 150.01 / 1.0001 = 149.995000... , where T + e(T) is nominal to the last step."""
    of, one = field(scale(100.0)), np.ones(1)
    nominal = np.array([[150.0, 0.0, -100.0]])
    found = of.correct(np.array([1]), one, nominal, np.zeros((1, 3)))[0]
    assert found[0] == pytest.approx(150.01 / 1.0001, abs=1e-9)
    assert found[1:] == pytest.approx([0.0, -100.0])


def test_what_a_path_cannot_correct_is_left_and_said() -> None:
    machine = mill(Scatter(value=1e-3), Backlash(axis="X", gap=5e-3), ScaleFactor("X", 1e-4))
    known = known_errors_of(machine)
    assert [e.name for e in known.machine.effects] == ["scale_factor"]
    assert [e.name for e in known.full.effects] == ["scale_factor", "backlash"]
    assert known.dynamic
    assert len(known.left_out) == 1
    assert known.left_out[0].startswith("backlash[X] jumps at reversals")
    assert [e.name for e in known.whole().machine.effects] == ["scale_factor", "backlash"]


def test_a_move_beyond_the_travel_is_named_by_its_line() -> None:
    of = field(mill(ScaleFactor("X", 1e-4), travel=120.0))
    with pytest.raises(ModelLimit, match="line 5 is out of travel: row 1: axis X = 150 mm") as caught:
        errors(of, 150.0)
    assert caught.value.line == 5
