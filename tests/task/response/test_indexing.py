"""Large offsets of counters are taken out on the exact chain."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, nominal_tip, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.task.response.indexing import index_text, move_readings, settle_index
from vcmm.task.response.recording import Recording

AXES = {a: Axis(a, (-1e3, 1e3)) for a in "XYZ"} | {"C": Axis("C", (-7.0, 7.0))}
TABLE = Machine("m", "mill", parse_structure("w C' X' b Y Z t"), AXES)
WRONG = np.radians(5.0)  # of the counter of C


def turned_table(off: float = WRONG, kind: str = "path") -> Recording:
    """Points about 100 mm from the centre of the table, seen along x and y; C reads `off` too little."""
    angle = np.linspace(0.0, 5.0, 8)
    zero = np.zeros(8)
    read = Run(
        {"X": np.linspace(60.0, 140.0, 8), "Y": np.resize([-30.0, 40.0, 10.0], 8), "Z": zero, "C": angle},
        np.zeros((8, 3)),
    )
    truth = replace(read, position={**read.position, "C": angle + off})
    way = nominal_tip(TABLE.chain, AXES, truth) - nominal_tip(TABLE.chain, AXES, read)
    direction = np.tile(np.eye(3)[:2], (8, 1))
    row = np.repeat(np.arange(8), 2)
    value = (way[row] * direction).sum(axis=1)
    return Recording(
        name="r", kind=kind, run=read, value=value, measuring=False, row=row, direction=direction,
        other=np.full(16, -1), nuisance={"index": ""},
    )  # fmt: skip


def test_five_degrees_are_found_exactly():
    # first order would leave 100 mm x (1 - cos 5 deg) = 0.38 mm
    out = settle_index(turned_table(), TABLE)
    assert out.index["C"] == pytest.approx(WRONG, abs=1e-9)
    assert np.abs(out.value).max() < 1e-9
    assert out.run.q("C") == pytest.approx(np.linspace(0.0, 5.0, 8) + WRONG)
    assert "C 5 deg" in index_text(out)


def test_without_the_word_nothing_moves():
    one = replace(turned_table(), nuisance={})
    assert settle_index(one, TABLE) is one
    assert index_text(one) == ""


def test_a_step_is_taken_on_the_exact_chain():
    # X read 1 mm too little: of each observation what 1 mm of X does along its direction goes away
    one = turned_table(0.0)
    out = move_readings(one, TABLE, {"X": 1.0})
    way = nominal_tip(TABLE.chain, AXES, out.run) - nominal_tip(TABLE.chain, AXES, one.run)
    assert np.linalg.norm(way, axis=1) == pytest.approx(np.ones(8))
    assert out.value == pytest.approx(-(way[one.row] * one.direction).sum(axis=1))


def test_what_cannot_be_moved_is_refused():
    tip = {f"tip_{c}_mm": np.zeros(8) for c in "xyz"}
    one = turned_table()
    with pytest.raises(UsageError, match="remove these columns"):
        settle_index(replace(one, run=one.run.with_columns(tip)), TABLE)
    with pytest.raises(ModelLimit, match="cannot be moved that far exactly"):
        settle_index(turned_table(kind="length"), TABLE)
