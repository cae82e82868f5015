"""Names of axes with a number, and arms of several rotary axes against positions made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.axes import axis_of, in_order, is_axis, is_component, is_location, unit_vector
from vcmm.core.error_names import canonical
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, nominal_tip, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.physics.structure.squareness import RotaryLocation


def arm() -> Machine:
    """A column of 400 mm, a link of 600 mm, a tool of 300 mm: two axes about Y above one about Z."""
    turn = (-np.pi, np.pi)
    axes = {
        "C1": Axis("C1", turn),
        "B2": Axis("B2", turn, centre=(0.0, 0.0, 400.0)),
        "B3": Axis("B3", turn, centre=(0.0, 0.0, 1000.0)),
    }
    return Machine("arm", "machine-tool", parse_structure("w b C1 B2 B3 t"), axes)


def at(**degrees: float) -> Run:
    position = {a: np.radians([degrees.get(a, 0.0)]) for a in ("C1", "B2", "B3")}
    return Run(position, np.array([[0.0, 0.0, 1300.0]]))


@pytest.mark.parametrize(
    ("degrees", "tip"),
    [
        ({}, [0, 0, 1300]),
        ({"B2": 90}, [900, 0, 400]),  # both links lie along +X, 400 mm up
        ({"B2": 90, "B3": 90}, [600, 0, 100]),  # the second hangs down 300 mm from the end of the first
        ({"C1": 90, "B2": 90}, [0, 900, 400]),
    ],
)
def test_an_arm_stands_where_its_links_say(degrees, tip):
    machine = arm()
    assert nominal_tip(machine.chain, machine.axes, at(**degrees))[0] == pytest.approx(tip, abs=1e-9)


def test_a_longer_link_and_a_joint_offset_are_location_errors():
    # the link to B3 is 1 mm longer; with B2 at 90 degrees it lies along X
    longer = arm().with_effect(RotaryLocation("Z0B3", offset=1.0))
    assert longer.tip_error(at(B2=90), exact=True)[0] == pytest.approx([1.0, 0.0, 0.0], abs=1e-9)
    # B3 stands 1 mrad further than its counter says: 300 mm x 1e-3 = 0.3 mm along X when all is upright
    offset = arm().with_effect(RotaryLocation("B0B3", tilt=1e-3))
    assert offset.tip_error(at(), exact=True)[0] == pytest.approx([0.3, 0.0, -0.00015], abs=1e-7)
    assert offset.tip_error(at())[0] == pytest.approx([0.3, 0.0, 0.0], abs=1e-12)


def test_harmonics_of_a_numbered_axis_by_hand():
    # EBB2 = 10 urad cos q: at 0 the arm of 900 mm above B2 leans 900e3 um x 1e-5 = 9 um in X
    machine = arm().with_effect(RotaryCyclic("EBB2", np.array([1e-5, 0.0])))
    assert machine.tip_error(at())[0] == pytest.approx([0.009, 0.0, 0.0], abs=1e-12)


def test_names():
    assert [is_axis(a) for a in ("X", "C", "A1", "C10", "A0", "X2", "D", "AB", "")] == [True] * 4 + [
        False
    ] * 5
    assert [axis_of(c) for c in ("EXX", "EXA1", "C0Y", "X0C10", "EX", "A1")] == [
        "X",
        "A1",
        "Y",
        "C10",
        "",
        "",
    ]
    assert [is_component(c) for c in ("EBC2", "B0C2")] == [True, False]
    assert [is_location(c) for c in ("B0C2", "C0Y")] == [True, False]
    assert in_order(["A1", "C", "X", "B3", "B2", "Z", "A10"]) == ["X", "Z", "A1", "A10", "B2", "B3", "C"]
    assert unit_vector("B3").tolist() == [0.0, 1.0, 0.0]
    assert canonical("E_{XA1}") == "EXA1"
    assert canonical("X0B3") == "X0B3"


def test_an_axis_that_is_none_is_refused():
    for structure in ("w b A0 t", "w b X2 t", "w b A1 A1 t", "w A1 b t"):
        with pytest.raises(UsageError, match=r"A1|A0|X2"):
            parse_structure(structure)
