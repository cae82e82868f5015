"""The door by which effects and Inputs come to a machine."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import SCATTER, machine
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.knowledge import add_knowledge, addable, duplicate_text, merge_effects, targets
from vcmm.core.laws import Normal
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentTable

GAP = Input("backlash", "X", "gap", Normal(1e-3), evidence="ball bar")


def test_effects_of_one_name_and_place_are_added():
    one = add_knowledge(machine(Backlash("X", 2e-3)), [Backlash("X", 3e-3), Backlash("Y", 1e-3)], [GAP])
    assert [(e.id, e.gap) for e in one.effects] == [
        ("backlash[X]", pytest.approx(5e-3)),
        ("backlash[Y]", 1e-3),
    ]
    assert one.inputs == (GAP,)


def test_tables_of_other_nodes_stay_apart():
    first = ComponentTable("EXX", ("X",), (np.array([0.0, 100.0]),), np.array([0.0, 1e-3]))
    same = ComponentTable("EXX", ("X",), (np.array([0.0, 100.0]),), np.array([2e-3, 2e-3]))
    other = ComponentTable("EXX", ("X",), (np.array([0.0, 50.0, 100.0]),), np.zeros(3))
    assert addable(first, same)
    assert not addable(first, other)
    whole = merge_effects([first, same, other])
    assert len(whole) == 2
    assert whole[0].values.tolist() == pytest.approx([2e-3, 3e-3])
    assert not addable(ScaleFactor("X", 1.0), ScaleFactor("Y", 1.0))


def test_a_quantity_is_drawn_once():
    assert duplicate_text(GAP, [SCATTER]) == ""
    assert (
        duplicate_text(GAP, [SCATTER, GAP])
        == "backlash[X].gap has an input already (ball bar); keep one of the two"
    )
    with pytest.raises(UsageError, match="has an input already"):
        add_knowledge(machine(Backlash("X"), inputs=(GAP,)), inputs=[GAP])
    with pytest.raises(UsageError, match="has an input already"):
        add_knowledge(machine(Backlash("X")), inputs=[GAP, GAP])
    with pytest.raises(UsageError, match="has an input already"):
        add_knowledge(machine(Backlash("X"), inputs=(GAP, GAP)))


def test_an_effect_stands_on_an_axis_of_the_machine():
    with pytest.raises(UsageError, match="acts on axis B"):
        add_knowledge(machine(), [ScaleFactor("B", 1e-6)])


def test_what_an_input_acts_on():
    one = machine(Backlash("X", 1e-3), Backlash("Y", 1e-3))
    assert [e.id for e in targets(one, GAP)] == ["backlash[X]"]
    every = Input("backlash", "*", "gap", Normal(1e-3))
    assert [e.id for e in targets(one, every)] == ["backlash[X]", "backlash[Y]"]
    with pytest.raises(UsageError, match="no such effect"):
        targets(machine(), GAP)
    with pytest.raises(UsageError, match="acts on 2 effects"):
        targets(machine(Backlash("X", 1e-3), Backlash("X", 1e-3)), GAP)


def test_nothing_new_changes_nothing():
    one = machine(Backlash("X", 1e-3), inputs=(GAP,))
    again = add_knowledge(one)
    assert again.inputs == one.inputs
    assert np.array_equal([e.gap for e in again.effects], [1e-3])
