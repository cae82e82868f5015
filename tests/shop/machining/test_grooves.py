"""Grooves of a lathe: width, place and floor by hand."""

from __future__ import annotations

import pytest

import vcmm
from tests.shop.machining import lathe
from vcmm.core.errors import DataError
from vcmm.program.setup import Tool
from vcmm.shop.machining.grooves import corners, grooves_of
from vcmm.shop.machining.preparation import set_up

# after the bar: a groove of 8 mm by two plunges of a tool of 5 mm that is led by its lower corner (orientation 3), from Z -38 to -30
GROOVE = lathe.PLAIN + "G0 X60. Z20.\nT0202\nG0 X44. Z-38.\nG1 X30. F0.05\nG0 X44.\nZ-35.\nG1 X30.\nG0 X44.\n"
TOOL = '[tools.2]\nlength = "60 mm"\noffset_x = "40 mm"\nshape = "turning"\nnose_radius = "0.2 mm"\norientation = 3\nwidth = "5 mm"\n'
SETUP = lathe.SETUP.replace("[control]", TOOL + "[control]")
LONG = lathe.effect("scale_factor", axis="Z", k="100 um/m")


def written(folder, machine="", tools="", program=GROOVE, setup=SETUP):
    path = lathe.plain(folder, machine, program=program, setup=setup)
    path.write_text(path.read_text().replace("[part.features]", tools + "[part.features]"))
    return path


def one(folder, *given, **more):
    (found,) = grooves_of(set_up(vcmm.load_cut(written(folder, *given, **more))))
    return found


def test_a_long_scale_of_z(tmp_path):
    """e_z = 100 um/m x z from the work zero: -3.8 um at Z -38 where the lower corner stands, -3.5 um at Z -35 with the upper one at -30:
    3 mm of way make the groove 0.3 um wider, and its middle lies 3.65 um further down."""
    groove = one(tmp_path, LONG)
    assert groove.lines == (15, 18)
    assert (groove.width_mm, groove.middle_mm) == pytest.approx((8.0, -34.0))
    assert groove.width_um == pytest.approx(0.3, abs=1e-3)
    assert groove.middle_um == pytest.approx(-3.65, abs=1e-3)
    assert groove.diameter_um == pytest.approx(0.0, abs=1e-6)


def test_the_width_of_the_tool_and_its_length(tmp_path):
    """u_width 4 um: U of the width 8 um, and the upper flank carries it: U of the middle 4 um, beside 2 x 3 um of u_length: 7.21 um.
    u_offset_x 2 um: U of the diameter 8 um."""
    known = '[cut.tools.2]\nu_width = "4 um"\nu_length = "3 um"\nu_offset_x = "2 um"\n'
    groove = one(tmp_path, "", known)
    assert groove.width_U_um == pytest.approx(8.0, abs=1e-6)
    assert groove.middle_U_um == pytest.approx((4.0**2 + 6.0**2) ** 0.5, abs=1e-6)
    assert groove.diameter_U_um == pytest.approx(8.0, abs=1e-6)


def test_one_plunge_repeats_with_itself_and_two_do_not(tmp_path):
    """A scatter of 0.5 um per pass: two flanks of two passes: U of the width 2 x 0.5 x sqrt 2 = 1.41 um; of one pass: none."""
    scatter = '[repeatability]\nlaw = "normal"\nu = "0.5 um"\n'
    (tmp_path / "a").mkdir()
    assert one(tmp_path, scatter).width_U_um == pytest.approx(2 * 0.5 * 2**0.5, abs=1e-6)
    single = GROOVE.replace("Z-35.\nG1 X30.\nG0 X44.\n", "")
    groove = one(tmp_path / "a", scatter, program=single)
    assert (groove.width_mm, groove.width_U_um) == pytest.approx((5.0, 0.0), abs=1e-6)


def test_which_corner_is_led():
    shares = {o: corners(Tool(1, shape="turning", orientation=o), "fanuc-lathe") for o in (3, 4, 8)}
    assert shares == {3: (0.0, 1.0), 4: (-1.0, 0.0), 8: (-0.5, 0.5)}
    assert corners(Tool(1, shape="turning", orientation=2), "linuxcnc") == (0.0, 1.0)


def test_the_cycle_of_a_fanuc_lathe_is_one_groove(tmp_path):
    """G75 X30 Z-35 from Z -38 in steps of 1 mm: four plunges, pecks of 3 mm: the same groove of 8 mm."""
    cycle = GROOVE[: GROOVE.index("G1 X30. F0.05")] + "G75 R0.5\nG75 X30. Z-35. P3000 Q1000 F0.05\n"
    groove = one(tmp_path, LONG, program=cycle)
    assert (groove.width_mm, groove.middle_mm) == pytest.approx((8.0, -34.0))
    assert groove.width_um == pytest.approx(0.3, abs=1e-3)


def test_an_uncertain_width_needs_a_width(tmp_path):
    with pytest.raises(
        DataError, match=r'u_width needs the width of tool 1 in the set-up, for example width = "3 mm"'
    ):
        vcmm.load_cut(written(tmp_path, "", '[cut.tools.1]\nu_width = "4 um"\n'))
