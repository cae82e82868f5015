"""The [placement] table and the machine of a scenario: what is read, and what is refused with a fix."""

from __future__ import annotations

import numpy as np
import pytest

from tests.answer.placing.cases import plate, written
from vcmm.core.errors import DataError
from vcmm.files.own.scenario import load_scenario


def test_placement_table_is_read(tmp_path):
    text = """
[placement]
x = ["100 mm", "500 mm"]
y = "250 mm"
turn_z = ["0 deg", "90 deg", "180 deg"]
faces_down = ["-z", "top"]
objective = { "U/T" = 0.75, "risk" = 0.25 }
weights = { "bore diameter" = 0.7, "bore square to top" = 0.3 }
process = { "bore diameter" = { mean = "0.001 mm", u = "0.003 mm" } }
"""
    found = plate(tmp_path, text).placement
    assert found is not None
    assert found.fixture is not None
    free = {f.name: f for f in found.fixture.freedoms}
    assert (free["x"].low, free["x"].high) == (100.0, 500.0)
    assert free["y"].values == (250.0,)
    assert free["turn_z"].values == pytest.approx((0.0, np.pi / 2, np.pi))
    assert len(found.fixture.orientations(np.zeros(6))) == 2 * 3  # two faces, three turns, one y
    assert found.fixture.faces["top"] == (0.0, 0.0, 1.0)
    assert found.goal.process["bore diameter"] == (0.001, 0.003)
    assert found.goal.mixture == {"U/T": 0.75, "risk": 0.25}


@pytest.mark.parametrize(
    ("lines", "text"),
    [
        ("slots = []", "slots is empty, which allows nothing; leave it out"),
        ("weights = {}", "weights is empty, which allows nothing; leave it out"),
        ('x = ["500 mm", "100 mm"]', "the range of x is empty: 500 is not below 100"),
        ("x = [100, 500]", "x"),
        ('turn_z = ["0 mm", "9 mm"]', "turn_z"),
        ('turns_z = ["0 deg", "90 deg"]', 'Did you mean "turn_z"?'),
        ('slots = ["1 2 3 mm"]\nx = ["0 mm", "9 mm"]', "slots sets x already"),
        ('faces_down = ["topp"]', 'Did you mean "top"?'),
        ('objective = "V"', 'objective = "V" is not known'),
        ('weights = { "bore diameter" = 0.7 }', 'the weights sum to 0.7, not to 1; in the same proportion: { "bore diameter" = 1 }'),
        ('weights = { "bore diametre" = 1.0 }', 'Did you mean "bore diameter"?'),
        ('objective = "cost"', "needs costs"),
        ('costs = { accept_bat = 3.0 }', 'Did you mean "accept_bad"?'),
    ],
)  # fmt: skip
def test_wrong_placements_are_refused_with_a_fix(tmp_path, lines, text):
    with pytest.raises(DataError) as error:
        plate(tmp_path, f"\n[placement]\n{lines}\n")
    assert text in str(error.value)
    assert "plate.toml:" in str(error.value)


def test_machine_of_a_scenario_is_replaced(tmp_path):
    from vcmm.files.own.library import example as shipped

    other = tmp_path / "other.toml"
    other.write_text(
        'vcmm = "machine/1"\nname = "other"\nstructure = "w b Y X Z t"\n'
        + "".join(
            f'[axes.{a}]\ntravel = ["{lo} mm", "{hi} mm"]\n'
            for a, lo, hi in (("X", 0, 700), ("Y", 0, 600), ("Z", -500, 0))
        )
        + '[repeatability]\nlaw = "normal"\nu = "0.5 um"\n'
    )
    found = load_scenario(written(tmp_path), other)
    assert found.machine.name == "other"
    assert shipped("plate").exists()
