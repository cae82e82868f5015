"""The errors of the tool in the rows of a cut by hand: what setting takes off errors, responses, products and draws."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.catalogue.workpiece import WorkpieceHeating
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.physics.structure.scatter import Scatter
from vcmm.shop.machining.tool_errors import ToolSide, cutting_effects
from vcmm.shop.machining.zero_setting import SETTING
from vcmm.task.response.trials import Draws

ALPHA = Input("scale_expansion", "X", "alpha", Normal(1e-6))


def each_axis(*first: int) -> np.ndarray:
    return np.repeat(np.array(first, dtype=np.intp)[:, None], 3, axis=1)


def side(*effects, inputs=(), setting=(1, -1), **more) -> ToolSide:
    """A point cut at X 400, its zero set at X 300, 5 K above 20 degC both times."""
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    machine = Machine("mill", "machine-tool", parse_structure("w X' Y' b Z t"), axes, effects, inputs)
    position = {"X": np.array([400.0, 300.0]), "Y": np.zeros(2), "Z": np.zeros(2)}
    columns = {"temp_scale_x_C": np.full(2, 25.0), "nx": np.ones(2), "ny": np.zeros(2), "nz": np.zeros(2)}
    run = Run(position, np.zeros((2, 3)), columns, {"touch": np.array(["p", SETTING])})
    return ToolSide(machine, machine.prepare(run), each_axis(*setting), np.zeros((2, 3)), inputs, **more)


def test_errors_count_from_where_the_zero_was_set():
    """k = 10 um/m: 4 um at X 400, 3 um at X 300, so 1 um is left of the first; of the row of setting all 3 um."""
    long = side(ScaleFactor(axis="X", k=10e-6))
    assert long.errors() == pytest.approx(np.array([[1e-3, 0, 0], [3e-3, 0, 0]]), abs=1e-12)
    elsewhere = replace(long, setting=each_axis(-1, -1))
    assert elsewhere.errors()[:, 0] == pytest.approx([4e-3, 3e-3], abs=1e-12)


@pytest.mark.parametrize(
    ("redraw", "first"), [("machine", 100.0), ("touch", 400.0)], ids=["one draw", "a draw for each row"]
)
def test_products_count_from_where_the_zero_was_set(redraw, first):
    """moved = alpha (T - 20 degC) X: d2 / d alpha dT = X, less that of setting, 400 - 300 mm, where both are one draw."""
    warm = Input("channel", "", "temp_scale_x_C", Normal(1.0), redraw)
    tool = side(ScaleExpansion(axis="X", alpha=0.0), inputs=(ALPHA, warm))
    given = tool.influences()
    (product,) = tool.products(given)
    assert {given[product.first].input, given[product.second].input} == {ALPHA, warm}
    assert product.response == pytest.approx(np.array([[first, 0, 0], [300.0, 0, 0]]), abs=1e-6)


def test_products_stay_whole_where_the_offset_is_from_elsewhere():
    warm = Input("channel", "", "temp_scale_x_C", Normal(1.0))
    tool = side(ScaleExpansion(axis="X", alpha=0.0), inputs=(ALPHA, warm), setting=(-1, -1))
    (product,) = tool.products(tool.influences())
    assert product.response[:, 0] == pytest.approx([400.0, 300.0], abs=1e-6)


def test_influences_hold_all_and_relative_ones_what_is_left():
    """5 K: d moved / d alpha = 5 X, 2000 and 1500 mm; 500 mm is left of the first."""
    tool = side(ScaleExpansion(axis="X", alpha=0.0), inputs=(ALPHA,))
    (one,) = tool.influences()
    assert one.response[:, 0, 0] == pytest.approx([2000.0, 1500.0])
    assert tool.relative(one).response[:, 0, 0] == pytest.approx([500.0, 1500.0])


def test_exact_trials_are_those_of_the_influences():
    """alpha 2e-6 too large in one trial: 2e-6 x 5 K x 100 mm = 1 um between the place of setting and X 400."""
    tool = side(ScaleExpansion(axis="X", alpha=0.0), inputs=(ALPHA,))
    (one,) = tool.influences()
    drawn = np.full((1, len(one.copies), 1), 2e-6)
    assert tool.exact([Draws(one, drawn, drawn)])[0, 0] == pytest.approx([1e-3, 0, 0], abs=1e-9)


def test_errors_of_a_lathe_stand_in_the_frame_of_the_pass():
    """At C 90 deg the tool stands on +Y of the work: an error along +X of the work is one along -y of the meridian frame."""
    turned = side(
        ScaleFactor(axis="X", k=10e-6), setting=(-1, -1), phi=np.array([np.pi / 2, 0.0]), rows_per_zero=1
    )
    assert turned.errors()[0] == pytest.approx([0.0, -4e-3, 0.0], abs=1e-12)
    assert turned.errors()[1] == pytest.approx([3e-3, 0.0, 0.0], abs=1e-12)


def test_which_effects_cut():
    machine = side(ScaleFactor(axis="X", k=1e-6), Scatter(), WorkpieceHeating()).machine
    moves, stated, idle = cutting_effects(machine)
    assert [e.name for e in moves.effects] == ["scale_factor", "scatter"]
    assert [e.name for e in stated.effects] == ["workpiece_heating"]
    assert idle == ()


def test_a_direction_of_the_meridian_is_one_of_the_workpiece():
    """The tool meets the part at 90 deg: outwards in the meridian is +Y of the workpiece, the way of the surface is -X."""
    turned = side(phi=np.array([np.pi / 2, 0.0]))
    found = turned.in_workpiece(
        np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 2.0], [1.0, 0.0, 0.0]]), np.array([0, 0, 1])
    )
    assert found == pytest.approx(np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 2.0], [1.0, 0.0, 0.0]]), abs=1e-12)
    assert side().in_workpiece(np.ones((1, 3)), np.array([0])).tolist() == [[1.0, 1.0, 1.0]]
