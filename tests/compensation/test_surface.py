"""The finished surface corrected, not only the path: the new program read back and cut on the machine as it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import vcmm
from tests.compensation.mill import mill
from tests.shop.machining import shop
from vcmm.compensation.field import known_errors_of
from vcmm.compensation.job import compensate
from vcmm.compensation.surface import nearest_share, surface_errors
from vcmm.core.errors import UsageError
from vcmm.physics.catalogue.clamping import Clamping
from vcmm.program.moves import Move, Source
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up

SETUP = shop.SETUP.replace("[offsets]", "[control]\ncompensation = []\n[offsets]")
LARGER = '[[effects]]\neffect = "tool_radius"\ntool = "1"\ndr = "10 um"\n'
WALLS = """\
[part.features]
low = { type = "plane", point = "0 -10 -1 mm", normal = [0, 1, 0], size = "80 1 mm" }
high = { type = "plane", point = "0 10 -1 mm", normal = [0, -1, 0], size = "80 1 mm" }
[[part.characteristics]]
name = "width"
type = "distance"
between = ["low", "high"]
"""


def off_drawing(scenario, program=None) -> np.ndarray:
    """Departures of the part along its normals, mm."""
    _, world, _ = finished_part(set_up(replace(scenario, program=program or scenario.program)))
    return world.contacts.surface(world.tool_errors)


def compensated(scenario, folder, surface):
    new = folder / "new.nc"
    made = compensate(scenario.program, scenario.setup, scenario.machine, surface=surface, decimals=4)
    new.write_text(made.text)
    return new, made


def test_a_tool_10_um_too_large_in_radius_goes_round_the_boss_10_um_farther_out(tmp_path):
    """Before 10 um of material are missing all round the boss, by no error of the path; after, rounding and splits are left."""
    scenario = vcmm.load_cut(shop.write(tmp_path, LARGER, setup=SETUP))
    before = off_drawing(scenario)
    assert before.min() == pytest.approx(-10e-3, abs=1e-6)
    surface = surface_errors(scenario)
    assert surface is not None
    assert (surface.largest, surface.effects, surface.against) == (
        pytest.approx(10e-3, abs=1e-6), ("tool_radius[1]",), ()
    )  # fmt: skip
    plain, _ = compensated(scenario, tmp_path, None)
    assert np.abs(off_drawing(scenario, plain)).max() == pytest.approx(10e-3, abs=1e-6)  # the path was right
    new, made = compensated(scenario, tmp_path, surface)
    assert np.abs(off_drawing(scenario, new)).max() < 0.5e-3
    assert any("tool_radius[1]: corrected where" in w for w in made.warnings)


def test_a_second_pass_along_the_same_wall_moves_as_the_first(tmp_path):
    """Else it cuts away what the first pass was led around: 4.8 of the 10 um were left so."""
    arc = "G2 X0 Y60. I0 J-60.\n"
    scenario = vcmm.load_cut(
        shop.write(tmp_path, LARGER, program=shop.PROGRAM.replace(arc, arc + arc), setup=SETUP)
    )
    surface = surface_errors(scenario)
    assert surface is not None
    assert surface.points == 72
    new, _ = compensated(scenario, tmp_path, surface)
    assert np.abs(off_drawing(scenario, new)).max() < 0.5e-3


FLOOR = """\
[part.features]
floor = { type = "plane", point = "0 0 -2 mm", normal = [0, 0, 1], size = "140 0.5 mm" }
[[part.characteristics]]
name = "flatness"
type = "flatness"
of = "floor"
zone = "0.02 mm"
"""
# the trailing edge of the tool, 2 mm behind its middle, leaves 2 x 1 / 160 mm more
RAMP = FLOOR.replace("0 0 -2 mm", "0 0 -2.5125 mm").replace("[0, 0, 1]", "[0.00624987793, 0, 0.999980469]")
SPRUNG = (
    '[[effects]]\neffect = "clamping"\ndirection = "z"\nlength = "80 mm"\n'
    'coefficients = ["10 um", "0 um", "0 um"]\n'
)


@pytest.mark.parametrize("ramp", ["-2.", "-3."])
def test_a_second_pass_along_the_same_floor_or_ramp_moves_as_the_first(tmp_path, ramp):
    """A part that springs back by 10 P2(x / 80 mm) um, the zero set in its middle: at X 69.8 15 x 0.8725^2 = 11.4 um too deep. The second pass
    cut away what the first was led around. What is left there is the flat end of the tool on a slope of 0.32 um/mm: 2 mm of it."""
    plane = FLOOR if ramp == "-2." else RAMP
    text = shop.SCENARIO[: shop.SCENARIO.index("[part.features]")] + plane
    once = f"G1 X80. Y0. Z{ramp} F600\n"
    twice = f"{once}G0 Z5.\nX-80.\nZ-2.\n{once}"
    program = shop.SLOT.replace("G1 X80. Y0. F600\n", twice)
    scenario = vcmm.load_cut(shop.write(tmp_path, SPRUNG, text, program, SETUP.replace("20 mm", "4 mm")))
    before = off_drawing(scenario)
    assert (before.min(), before.max()) == (pytest.approx(-11.42e-3, rel=0.01), pytest.approx(0.0, abs=1e-4))
    new, _ = compensated(scenario, tmp_path, surface_errors(scenario))
    assert np.abs(off_drawing(scenario, new)).max() < 1.0e-3


def test_a_subprogram_is_written_out_where_only_the_surface_is_off(tmp_path):
    """The way round the boss at two depths, called twice: no error of the path, yet every call has its own numbers."""
    round_it = "G1 X-20. Y60. F600\nG1 X0 Y60.\nG2 X0 Y60. I0 J-60.\nG1 X20. Y60.\nG1 X20. Y90.\n"
    text = shop.PROGRAM.replace(round_it, "M98 P2\nG0 X-20. Y90. Z-11.\nM98 P2\n")
    text = text.replace("M30\n", f"M30\nO2\n{round_it}M99\n")
    scenario = vcmm.load_cut(shop.write(tmp_path, LARGER, program=text, setup=SETUP))
    new, made = compensated(scenario, tmp_path, surface_errors(scenario))
    assert made.is_met
    assert np.abs(off_drawing(scenario, new)).max() < 0.5e-3


def test_both_walls_of_a_slot_cannot_be_moved_apart_by_one_way_of_the_tool(tmp_path):
    """Each wall wants the tool to go 10 um the other way: it stays where it is, and both walls are named."""
    text = shop.SCENARIO[: shop.SCENARIO.index("[part.features]")] + WALLS
    scenario = vcmm.load_cut(shop.write(tmp_path, LARGER, text, shop.SLOT, SETUP))
    surface = surface_errors(scenario)
    assert surface is not None
    assert surface.against == ("high", "low")
    assert surface.rest_rms == pytest.approx(10e-3, rel=0.01)
    assert np.abs(surface.value).max() < 0.1e-3
    _, made = compensated(scenario, tmp_path, surface)
    assert any("high, low: what is off there stays" in w for w in made.warnings)


def test_nothing_beside_the_path_is_nothing_to_correct(tmp_path):
    assert surface_errors(vcmm.load_cut(shop.write(tmp_path, "", setup=SETUP))) is None


def test_a_surface_of_another_program_is_refused(tmp_path):
    scenario = vcmm.load_cut(shop.write(tmp_path, LARGER, setup=SETUP))
    surface = surface_errors(scenario)
    other = tmp_path / "other.nc"
    other.write_text(scenario.program.read_text().replace("Y60.", "Y61."))
    with pytest.raises(UsageError, match="the moves that were cut virtually are not those"):
        compensate(other, scenario.setup, scenario.machine, surface=surface)


def test_the_share_of_a_line_is_that_of_the_foot():
    """3 mm beside the point at a quarter of 100 mm; before its start the share is 0."""
    line = Move("line", Source(1, 1, 1), (0.0, 0.0, 0.0), (100.0, 0.0, 0.0))
    share, gap = nearest_share(line, np.array([[25.0, 3.0, 0.0], [-4.0, 3.0, 0.0]]))
    assert share.tolist() == [0.25, 0.0]
    assert gap.tolist() == [3.0, 5.0]


def test_spring_back_is_left_to_the_surface():
    """The path knows where the tool stands, and not where it cuts."""
    known = known_errors_of(mill(Clamping("z", np.array([1e-3, 0.0, 0.0]))))
    assert known.machine.effects == ()
    assert "--surface does" in known.left_out[0]
