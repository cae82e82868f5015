"""The length by which a tool wears: chips on a lathe, the way of the tip in the part where only rotary axes move."""

from __future__ import annotations

import numpy as np
import pytest

from tests.shop.machining import lathe
from tests.shop.machining import rotary_shop as rs
from tests.shop.machining.lathe import plain
from vcmm.shop.machining.contact_path import surface_at, tool_side

TABLE = "w C' X' Y' b Z t"
BOSS = 'boss = { type = "cylinder", point = "0 0 -8 mm", axis = [0, 0, 1], diameter = "20 mm", length = "6 mm" }\n'
ROUND = '[[part.characteristics]]\nname = "form"\ntype = "cylindricity"\nof = "boss"\nzone = "0.1 mm"\n'
CALLED = "G0 X15. Y-30.\nG43 H1 Z5.\nZ-10.\nG1 Y0. F500\n"
WAYS = {
    "the table turns": "G1 C-360. F3600\n",
    "the tool goes round": "G2 X15. Y0. I-15. J0. F471\n",
}


def test_the_second_part_of_a_batch_starts_with_the_chips_of_the_first(tmp_path):
    wear = lathe.effect("tool_wear", rate="1 um/m")
    path = plain(tmp_path, wear)
    first, _ = lathe.moved(lathe.shop(path), "seat")
    path.write_text(path.read_text().replace("[cut]", "[cut]\nbatch_part = 2"))
    later, _ = lathe.moved(lathe.shop(path), "seat")
    # 62 mm at 0.1 mm per turn: 620 turns of pi 40 mm = 77.91 m; the shoulder from 40 to 52 mm, 6 mm of radius, 60 turns of
    # pi 46 mm = 8.67 m: 86.58 m x 1 um/m of radius; the time law adds turns where it slows at the corner
    assert (later - first).mean() == pytest.approx(86.58e-3, rel=0.002)
    assert np.ptp(later - first) < 1e-6


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("part", [1, 3])
def test_a_tool_wears_while_only_the_table_turns(tmp_path, way, part):
    cut = f"batch_part = {part}\n"
    program = CALLED + WAYS[way] + "G0 Z50.\n"
    path = rs.write(
        tmp_path, rs.machine(TABLE, rs.axis("C")), program, BOSS, 'diameter = "10 mm"\n', cut, ROUND
    )
    shop = rs.shop_of(path)
    angle = np.radians([90.0, 180.0, 270.0])
    normals = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(3)])
    found = surface_at(shop, 10.0 * normals + [0, 0, -11.0 + 3.0], normals)
    run = tool_side(shop, found, np.array(["1", "2", "3"]), np.full(3, "boss"))[0].run
    rows = [np.flatnonzero(run.labels["touch"] == n)[0] for n in ("1", "2", "3")]
    # 30 mm in, then 15 mm x the angle run through, clockwise from +X: 270, 180 and 90 deg: 70.686, 47.124, 23.562 mm;
    # a whole part: 30 + 2 pi 15 = 124.248 mm
    expected = 30 + 15 * np.radians([270.0, 180.0, 90.0]) + (part - 1) * 124.2478
    assert run.column("cut_length_mm")[rows] == pytest.approx(expected, abs=0.02)
