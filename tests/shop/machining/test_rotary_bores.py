"""Bores that face each other, cut from both sides on a pallet whose axis leans; the shipped scenario of such a block."""

from __future__ import annotations

import numpy as np
import pytest

import vcmm
from tests.shop.machining import rotary_shop as rs
from vcmm.face.cli import run as command
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.rotary_milling import RotaryMillingProcess

BORE = "G0 B{b}. \nG0 X0 Y0\nG43 H1 Z200.\nZ110.\nG1 Z70. F400\nG3 X10. Y0 I5. J0\nG3 X10. Y0 I-10. J0\nG3 X0 Y0 I-5. J0\nG0 Z200.\n"
FRONT = 'front = { type = "cylinder", point = "0 0 72 mm", axis = [0, 0, 1], diameter = "40 mm", length = "26 mm", inside = true }\n'
BACK = 'back = { type = "cylinder", point = "0 0 -98 mm", axis = [0, 0, 1], diameter = "40 mm", length = "26 mm", inside = true }\n'
COAXIAL = '[[part.characteristics]]\nname = "line"\ntype = "coaxiality"\nof = "back"\ndatums = ["front"]\nzone = "0.03 mm"\n'
LEANS = '[[effects]]\neffect = "rotary_location"\ncomponent = "A0B"\ntilt = "20 urad"\n'


@pytest.mark.thorough
def test_a_leaning_pallet_inclines_bores_that_face_each_other(tmp_path):
    mill = rs.machine("w B' Z' b X Y t", rs.axis("B") + LEANS)
    program = BORE.format(b=0) + BORE.format(b=180)
    path = rs.write(
        tmp_path, mill, program, FRONT + BACK, 'diameter = "20 mm"\n', 'work_offset = { u = "1 um" }', COAXIAL
    )
    task, world, _ = finished_part(rs.shop_of(path))
    # the table leans by +a about X: seen from it the tool is turned by -a, at a height z over the pallet's axis it lies a z too
    # high (nothing at the zero, which was set there). At B = 0 that is z of the part, at 180 deg -z: e_y = a z and -a z
    touches = task.touches
    y, z = touches.points[:, 1], touches.points[:, 2]
    assert len(touches.rows["front"]) == len(touches.rows["back"]) > 30
    # in a bore n = (-x, -y) / 20: the surface moves by n . e
    expected = 20e-6 * np.abs(z) * -y / 20.0
    found = np.einsum("ni,ni->n", world.errors(), touches.run.normal)
    assert found == pytest.approx(
        expected, abs=2e-6
    )  # to second order, (2 um)^2 / 20 mm and its like, 0.2 nm

    # so both axes rise towards their mouths: from the axis of the front bore, prolonged, the back bore stands off by 2 a |z|,
    # most at z = -98: 2 x 20e-6 x 98 = 3.92 um, a zone of 7.84 um
    from vcmm.answer.evaluation.linear import build

    model = build(task, world)
    assert model.values(model.q0)[0] == pytest.approx(7.84e-3, rel=2e-3)


@pytest.mark.thorough
def test_the_shipped_block(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert command(["new", "block", "--from", "pallet_block"]) == 0
    assert (tmp_path / "block" / "part.nc").is_file()
    scenario = vcmm.load_cut(tmp_path / "block.toml")
    shop = set_up(scenario)
    assert isinstance(shop.process, RotaryMillingProcess)
    assert set(np.degrees(shop.process.motion.angles[:, 1, 1]).round(9)) >= {0.0, 90.0, 180.0, 270.0}
    _, world, notes = finished_part(shop)
    assert notes == ()  # nothing uncut, nothing gouged
    # 250 um of the pallet's axis are in the zero: what is left are the other errors
    assert 1e-3 < np.abs(world.errors()).max() < 10e-3
    assert (
        np.abs(world.level).max() < 1e-4
    )  # the program alone leaves the nominal block, but for rounded corners
