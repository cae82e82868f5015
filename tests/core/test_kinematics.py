"""Tip errors of machines against an independent 40-digit product of transforms, and sums made by hand."""

from __future__ import annotations

import json

import numpy as np
import pytest

from tests.conftest import data_file
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.rigid import rotation_from_vector
from vcmm.core.run import Run
from vcmm.files.columns import read_positions
from vcmm.files.own.machine import load_machine
from vcmm.physics import BY_NAME
from vcmm.physics.structure.component import ComponentTable


def reference():
    path = data_file("reference/kinematics.json")
    return path.parent, json.loads(path.read_text())


def test_every_reference_machine_exact_and_first_order():
    root, document = reference()
    worst = {"exact": 0.0, "linear": 0.0, "first order": 0.0}
    for case in document["cases"]:
        machine = load_machine(root / case["machine"])
        run = read_positions(root / case["positions"], machine.chain.letters)
        exact = machine.tip_error(run, exact=True)
        worst["exact"] = max(worst["exact"], np.abs(exact - case["tip_error_mm"]).max())
        if not case["first_order_applies"]:
            continue
        linear = machine.tip_error(run)
        worst["linear"] = max(worst["linear"], np.abs(linear - case["first_order_tip_error_mm"]).max())
        worst["first order"] = max(worst["first order"], np.abs(linear - case["tip_error_mm"]).max())
        for row, by_hand in case.get("by_hand_mm", {}).items():
            assert linear[int(row)] == pytest.approx(by_hand, abs=1e-12), case["name"]
    assert len(document["cases"]) >= 58
    assert worst["exact"] < 1e-9
    assert worst["linear"] < 1e-12
    assert worst["first order"] < 5e-6


def test_pitch_on_a_stylus_by_hand():
    # EBX = 10 urad turns +Z towards +X; the tip hangs 150 mm below the X slide: 10e-6 x (-150) = -1.5 um in X
    machine = Machine(
        "one error", "cmm", parse_structure("w b Y X Z t"),
        {a: Axis(a, (-500.0, 500.0)) for a in "XYZ"},
        (ComponentTable("EBX", ("X",), (np.array([0.0, 400.0]),), np.array([1e-5, 1e-5])),),
    )  # fmt: skip
    run = Run(
        {"X": np.array([200.0]), "Y": np.array([0.0]), "Z": np.array([0.0])}, np.array([[0.0, 0.0, -150.0]])
    )
    assert machine.tip_error(run)[0] == pytest.approx([-0.0015, 0.0, 0.0], abs=1e-15)
    # indicated - true is the opposite
    assert machine.indication_error(run)[0] == pytest.approx([0.0015, 0.0, 0.0], abs=1e-15)


def test_rotation_vector_by_hand():
    quarter = rotation_from_vector(np.array([[0.0, 0.0, np.pi / 2]]))[0]
    assert quarter @ [1.0, 0.0, 0.0] == pytest.approx([0.0, 1.0, 0.0], abs=1e-15)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("w b Y Y Z t", "names axis Y 2 times"),
        ("X b Y Z t", "must start with w"),
        ("w X b Y Z t", "take a prime"),
        ("w b Y X' Z t", "take none"),
        ("w b Y Q Z t", 'unknown axis "Q"'),
    ],
)
def test_structure_mistakes(text, message):
    with pytest.raises(UsageError, match=message):
        parse_structure(text)


def test_structure_and_axes_must_agree():
    with pytest.raises(UsageError, match=r"no \[axes.Z\]"):
        Machine("m", "cmm", parse_structure("w b Y X Z t"), {a: Axis(a, (0.0, 1.0)) for a in "XY"})
    with pytest.raises(UsageError, match="is not in structure"):
        Machine("m", "cmm", parse_structure("w b Y X t"), {a: Axis(a, (0.0, 1.0)) for a in "XYZ"})


def test_travel_and_large_rotation_are_refused():
    axes = {a: Axis(a, (0.0, 500.0)) for a in "XYZ"}
    table = ComponentTable("EBX", ("X",), (np.array([0.0, 500.0]),), np.array([2e-3, 2e-3]))
    machine = Machine("m", "cmm", parse_structure("w b Y X Z t"), axes, (table,))
    outside = Run({a: np.array([501.0]) for a in "XYZ"}, np.zeros((1, 3)))
    with pytest.raises(ModelLimit, match="outside its travel 0 to 500 mm"):
        machine.tip_error(outside)
    inside = Run({a: np.array([100.0]) for a in "XYZ"}, np.zeros((1, 3)))
    with pytest.raises(ModelLimit, match="exceeds 1 mrad"):
        machine.tip_error(inside)
    assert machine.tip_error(inside, exact=True).shape == (1, 3)


def test_all_effects_have_distinct_names():
    assert len(BY_NAME) >= 20
