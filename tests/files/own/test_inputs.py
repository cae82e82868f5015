"""Inputs from files: every law in its canonical unit, the target checked, one quantity one input."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.files.own.effects import build_effect
from vcmm.files.own.inputs import build_input
from vcmm.physics import Backlash, ComponentTable, ProbeLobing, RotaryLocation, ScaleExpansion, TipOffset

EFFECTS = (
    Backlash("X", 1e-3),
    Backlash("Y", 1e-3),
    ScaleExpansion("X", 8e-6),
    ScaleExpansion("Y", 8e-6),
    ComponentTable("EBX", ("X",), (np.array([0.0, 100.0]),), np.zeros(2)),
    TipOffset("down", np.zeros(3)),
    ProbeLobing("down", 1e-3),
    RotaryLocation("A0C", tilt=1e-6),
)
GAP = {"effect": "backlash", "axis": "X", "parameter": "gap"}


def _law(**keys: object):
    return build_input({**GAP, **keys}, EFFECTS).law


@pytest.mark.parametrize(
    ("keys", "u_um"),
    [
        ({"u": "0.2 um"}, 0.2),
        ({"law": "normal", "u": "200 nm"}, 0.2),
        ({"law": "t", "scale": "0.7 um", "dof": 6}, 0.7 * math.sqrt(1.5)),  # sqrt(6 / 4)
        ({"law": "uniform", "half_width": "0.3 um"}, 0.3 / math.sqrt(3)),
        ({"law": "uniform", "u": "0.2 um"}, 0.2),
        ({"law": "triangular", "half_width": "0.3 um"}, 0.3 / math.sqrt(6)),
        ({"law": "arcsine", "half_width": "0.3 um"}, 0.3 / math.sqrt(2)),
        # trapezoid with plateau b = 0.4 a: u^2 = a^2 (1 + 0.4^2) / 6
        ({"law": "trapezoidal", "half_width": "0.3 um", "top": 0.4}, 0.3 * math.sqrt(1.16 / 6)),
        ({"law": "trapezoidal", "u": "0.2 um", "top": 0.4}, 0.2),
        ({"law": "samples", "values": "-0.3 0.3 um"}, 0.3),
    ],
)
def test_laws_in_canonical_units(keys, u_um):
    assert _law(**keys).u == pytest.approx(u_um * 1e-3, rel=1e-12)


def test_along_a_rotary_axis_a_length_is_an_angle():
    """5 urad of C are 5e-6 rad; a file with "5 um" there once acted as 5 mrad."""
    play = build_effect({"effect": "backlash", "axis": "C", "gap": "5 urad"})
    assert play.gap == pytest.approx(5e-6, rel=1e-12)
    keys = {"effect": "backlash", "axis": "C", "parameter": "gap"}
    assert build_input({**keys, "u": "1 arcsec"}, (play,)).law.u == pytest.approx(
        math.pi / 648_000, rel=1e-12
    )
    loop = build_effect({"effect": "hysteresis", "axis": "A1", "amplitude": "1 urad", "distance": "0.5 deg"})
    assert loop.distance == pytest.approx(math.pi / 360, rel=1e-12)
    wound = build_effect(
        {"effect": "lost_motion_loaded", "axis": "C", "g0": "1 urad", "g_load": "0.2 urad/kg"}
    )
    assert wound.g_load == pytest.approx(0.2e-6, rel=1e-12)
    offset = build_effect(
        {"effect": "rotary_location", "component": "X0C", "offset": "5 um"}
    )  # a length, even so
    assert offset.offset == pytest.approx(5e-3, rel=1e-12)
    with pytest.raises(UsageError, match=r'gap = "5 um" is not an angle.*"0.5 urad"'):
        build_effect({"effect": "backlash", "axis": "C", "gap": "5 um"})
    with pytest.raises(UsageError, match=r'gap = "5 urad" is not a length.*"0.5 um"'):
        build_effect({"effect": "backlash", "axis": "X", "gap": "5 urad"})
    with pytest.raises(UsageError, match="is not an angle"):
        build_input({**keys, "u": "1 um"}, (play,))


def test_few_degrees_of_freedom_are_accepted_with_infinite_u():
    assert _law(law="t", scale="0.7 um", dof=2).u == math.inf
    assert _law(law="t", scale="0.7 um", dof=1).u == math.inf


def test_multivariate_counts_in_the_unit_of_the_parameter():
    # 4 um^2 on the diagonal: u = 2 um = 2e-3 mm
    table = {"effect": "tip_offset", "stylus": "down", "parameter": "d", "law": "multivariate"}
    one = build_input({**table, "covariance": [[4.0, 0, 0], [0, 4.0, 0], [0, 0, 1.0]]}, EFFECTS)
    assert isinstance(one.law, MultivariateNormal)
    assert one.law.u == pytest.approx([2e-3, 2e-3, 1e-3])
    with pytest.raises(UsageError, match="2 numbers for d, which has 3"):
        build_input({**table, "covariance": [[4.0, 0], [0, 4.0]]}, EFFECTS)


def test_one_spread_per_element():
    one = build_input(
        {"effect": "component_table", "component": "EBX", "parameter": "values", "u": "1 2 urad"}, EFFECTS
    )
    law, factor = one.spread(2)
    assert law.u == 1.0
    assert factor == pytest.approx(np.diag([1e-6, 2e-6]))


def test_ids_name_stream_and_budget_line():
    assert build_input({**GAP, "u": "1 um"}, EFFECTS).id == "backlash[X].gap"
    every = build_input(
        {"effect": "scale_expansion", "axis": "*", "parameter": "alpha", "u": "1 um/(m K)"}, EFFECTS
    )
    assert every.where == "*"
    channel = build_input({"channel": "temp_part_C", "u": "0.1 K"}, EFFECTS)
    assert channel.is_channel
    assert channel.law.u == 0.1
    assert channel.redraw == "machine"


def test_contract_names_of_parameters():
    one = build_input(
        {"effect": "probe_lobing", "stylus": "down", "parameter": "amplitude", "u": "0.1 um"}, EFFECTS
    )
    assert one.parameter == "cosine"


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ({}, ["names either effect"]),
        ({"effect": "backlash", "channel": "temp_part_C"}, ["names either effect"]),
        ({"efect": "backlash", "u": "1 um"}, ['"efect" is there; rename it to "effect"']),
        ({**GAP, "effect": "backlsh", "u": "1 um"}, ['unknown effect "backlsh". Did you mean "backlash"']),
        ({**GAP, "parameter": "gpa", "u": "1 um"}, ['no parameter "gpa". Did you mean "gap"']),
        ({**GAP, "axis": "Z", "u": "1 um"}, ["backlash[Z]", "Allowed: backlash[X], backlash[Y]"]),
        (
            {"effect": "backlash", "parameter": "gap", "u": "1 um"},
            ['does not say which backlash; add axis = "X"'],
        ),
        (
            {"effect": "screw_pitch", "axis": "X", "parameter": "amplitude", "u": "1 um"},
            ["there is no such effect; add it"],
        ),
        ({**GAP, "law": "nromal", "u": "1 um"}, ['unknown law "nromal". Did you mean "normal"']),
        ({**GAP, "redraw": "stilus", "u": "1 um"}, ['redraw = "stilus" is no label. Did you mean "stylus"']),
        (
            {**GAP, "evidense": "x", "u": "1 um"},
            ['unknown key "evidense" of an input. Did you mean "evidence"'],
        ),
        ({**GAP}, ['law = "normal" needs u; write for example u = "0.5 um"']),
        ({**GAP, "law": "t", "u": "1 um"}, ['law = "t" needs scale, but u is given']),
        ({**GAP, "law": "t", "scale": "1 um"}, ["needs dof"]),
        ({**GAP, "law": "t", "scale": "1 um", "dof": "6"}, ['dof = "6" must be a plain number']),
        ({**GAP, "law": "t", "scale": "1 um", "dof": 0.5}, ["dof"]),
        ({**GAP, "u": "1 um", "dof": 6}, ['dof does not belong to law = "normal"', 'law = "t"']),
        ({**GAP, "law": "uniform", "u": "1 um", "half_width": "1 um"}, ["both given"]),
        ({**GAP, "u": "-1 um"}, ["is negative"]),
        ({**GAP, "u": 1}, ["u = 1 has no unit", 'u = "1 um"']),
        ({**GAP, "u": "1 urad"}, ["is not a length"]),
        ({**GAP, "law": "trapezoidal", "u": "1 um", "top": 1.5}, ["between 0 and 1"]),
        ({**GAP, "law": "samples"}, ["needs values"]),
        ({**GAP, "law": "samples", "values": "1 um"}, ["at least 2"]),
        ({**GAP, "law": "multivariate"}, ["needs covariance"]),
        ({**GAP, "law": "multivariate", "covariance": [["1"]]}, ["square of plain numbers"]),
        ({"channel": "temp_prat", "u": "0.1 K"}, ["no column of a run", "temp_part_C"]),
        ({"channel": "temp_part_C", "u": "0.1 degC"}, ["takes K"]),
        (
            {"effect": "rotary_location", "component": "A0C", "parameter": "offset", "u": "1 um"},
            ["offset does nothing"],
        ),
    ],
)
def test_what_is_refused(table, words):
    with pytest.raises(UsageError) as caught:
        build_input(table, EFFECTS)
    for word in words:
        assert word in str(caught.value)


def test_all_that_is_wrong_in_one_table_is_said():
    with pytest.raises(UsageError) as caught:
        build_input({**GAP, "parameter": "gpa", "redraw": "tuch", "evidense": "x", "axis": "Q"}, EFFECTS)
    text = str(caught.value)
    assert all(word in text for word in ('"gap"', '"touch"', '"evidence"', "backlash[Q]"))


def test_spread_of_a_scalar_law_is_one_draw_per_element():
    law, factor = Input("tip_offset", "", "d", Normal(1e-3)).spread(3)
    assert law.u == 1e-3
    assert np.array_equal(factor, np.eye(3))


def test_a_correlated_field_is_drawn_from_its_own_kernel():
    # two nodes 100 mm apart, length 100 mm: correlation exp(-1/2) = 0.606531; the same input elsewhere is refused
    effect = build_effect({
        "effect": "correlated_field", "nodes": ["0 0 0 mm", "100 0 0 mm"], "deviation": ["1 1 1 um", "2 2 2 um"], "length": "100 mm",
    })  # fmt: skip
    one = build_input({"effect": "correlated_field", "parameter": "values", "redraw": "run"}, [effect])
    assert one.law.covariance[0, 3] == pytest.approx(0.606531, abs=1e-6)
    assert one.law.covariance[0, 0] == pytest.approx(1.0)
    with pytest.raises(UsageError, match="its nodes and length give the covariance"):
        build_input({"effect": "correlated_field", "parameter": "values", "u": "1 um"}, [effect])
