"""Rewritten Sinumerik programs against numbers worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.compensation.mill import SETUP, body, mill, rough, run, scale
from vcmm.core.errors import DataError
from vcmm.physics.structure.squareness import Squareness
from vcmm.program.interpret import interpret

SIEMENS = replace(SETUP, dialect="sinumerik")


def go(tmp_path, text, machine, **more):
    return run(tmp_path, text, machine, SIEMENS, **more)


def test_lines_words_and_comments(tmp_path):
    # +100 um/m: 100 mm would be cut 10 um too long; IC(100) goes from 99.990 to 199.980, a step of 99.990
    text = "%_N_PART_MPF\n;$PATH=/_N_WKS_DIR\nN10 G54 G90 ; start\nN20 G1 X=100 F500 ; wall (left)\nN30 X=IC(100.0)\nN40 M30\n"
    found = go(tmp_path, text, scale(100.0))
    assert body(found)[3:5] == ["N20 G1 X=99.990 F500 ; wall (left)\n", "N30 X=IC(99.990)\n"]
    assert found.text.splitlines()[2] == "; VCMM COMPENSATED - DO NOT COMPENSATE AGAIN"
    assert found.after.largest < 1e-5


def test_a_perfect_machine_changes_nothing(tmp_path):
    text = "N1 G54 G90 R1=5\nG1 x+10. Y=R1 F500 ; \xe9\nG2 X20 I=AC(15) J0\nG3 AR=90 I5 J0\nG1 G91 X=AC(3)\n\nCIP X5 Y0 I1=2 J1=2\nM30\n"
    found = go(tmp_path, text, mill())
    assert "".join(body(found)) == text


@pytest.mark.parametrize("words", ["I-50 J0", "I=AC(0) J=AC(0)", "X50 Y0 I-50 J0"])
def test_squareness_makes_a_circle_four_arcs(tmp_path, words):
    """20 urad on R50 leaves 20e-6 x 50 / 2 = 0.5 um across the path; four arcs leave 0.02 um, as in the other dialects."""
    text = f"G54 G90 G17\nG0 X50 Y0 Z0\nG2 {words} F500 ; circle\nM30\n"
    found = go(tmp_path, text, mill(Squareness("C0Y", 20e-6)), tolerance=1e-4, decimals=4)
    assert found.before.largest == pytest.approx(0.5e-3, rel=1e-3)
    assert found.after.largest < 0.03e-3
    assert found.blocks.additions == 3
    arcs = [m for m in interpret(found.text, "sinumerik", SIEMENS).moves if m.kind == "arc"]
    assert arcs[0].end == pytest.approx((-0.001, -50.0, 0.0))  # x = c y = 20e-6 x -50 mm = -1 um


def test_increments_do_not_drift(tmp_path):
    # 1000 steps of 0.1 mm at +300 um/m: 100 mm become 100.030 mm, so the steps add up to 99.970 mm
    text = "G54 G90\nG1 F500\n" + "X=IC(0.1)\n" * 1000 + "M30\n"
    found = go(tmp_path, text, scale(300.0))
    steps = [float(line[5:-2]) for line in body(found)[2:1002]]
    assert sum(steps) == pytest.approx(99.970, abs=6e-4)
    assert found.after.largest < 1.1e-3


def test_arcs_by_radius_angle_and_a_point_between(tmp_path):
    text = "G54 G90 G17\nG1 X0 Y0 F500\nG3 X100 Y100 CR=100\nG2 AR=90 I50 J0\nG1 X0\nCIP X100 Y50 I1=50 J1=80\nG1 Y0\nM30\n"
    planar = mill(*[e for e in rough().effects if "EZX" not in e.id])
    found = go(tmp_path, text, planar)
    assert found.is_met
    assert "CR=" in found.text
    assert "AR=" not in found.text  # the end point and the centre take its place
    assert "I1=" in found.text


def test_a_scaled_and_mirrored_frame(tmp_path):
    # MIRROR X, SCALE X2 Y2: X50 is machine -100 mm: cut 10 um too far, so 50 mm must be 49.995
    text = "G54 G90\nMIRROR X0\nASCALE X2 Y2\nG1 X50 F500\nG2 X60 Y10 CR=10\nM30\n"
    found = go(tmp_path, text, scale(100.0))
    assert body(found)[3] == "G1 X49.995 F500\n"
    assert found.is_met


def test_corners_stay_at_the_corner(tmp_path):
    """RND= of a line that is split goes to its last block; what acts behind the motion as well."""
    text = "G54 G90\nG1 X0 Y0 F500\nX300 RND=10 M8\nY200 M5\nM30\n"
    found = go(tmp_path, text, rough())
    lines = [line.strip() for line in body(found)]
    rounded = next(i for i, line in enumerate(lines) if "RND=10" in line)
    assert lines[rounded + 1].startswith(("X", "Y"))
    assert lines[2].endswith("M8")
    assert rounded > 2
    assert sum("M5" in line for line in lines) == 1
    assert lines[-2].endswith("M5")
    assert found.is_met


def test_holes_one_by_one(tmp_path):
    # Z +1000 um/m: at -15 mm 15 um too low. X +100 um/m alone leaves the cycle as it is
    text = "G54 G90\nG0 X0 Y0 Z50\nF100\nMCALL CYCLE81(50,0,2,-15) ; drill\nX100\nX200 Y10\nMCALL\nM30\n"
    lines = body(go(tmp_path, text, scale(100.0)))
    assert lines[3:6] == ["MCALL CYCLE81(50,0,2,-15) ; drill\n", "X99.990\n", "X199.980 Y10\n"]
    lines = body(go(tmp_path, text, scale(1000.0, "Z")))
    assert lines[3] == "MCALL CYCLE81(50,0.015,2,-14.985) ; drill\n"


def test_a_cycle_is_defined_again_where_holes_differ(tmp_path):
    # B0Z-like lean of Z with X by a table is not needed: squareness of Z to X as EZX, 3 um wave: depths differ hole by hole
    text = "G54 G90\nG0 X0 Y0 Z50\nF100\nMCALL CYCLE82(50,0,2,-15,,0.5) ; drill\nX100\nX300\nMCALL\nM30\n"
    lines = body(go(tmp_path, text, rough()))
    again = [line for line in lines if line.startswith("MCALL CYCLE82")]
    assert len(again) == 2
    assert "drill" not in again[1]
    assert lines.index(again[1]) + 1 == next(i for i, line in enumerate(lines) if line.startswith("X299"))


def test_a_cycle_defined_again_ends_with_its_bracket(tmp_path):
    """What is written right behind the bracket, here M8, is another word: the coolant is on already."""
    text = "G54 G90\nG0 X0 Y0 Z50\nF100\nMCALL CYCLE82(50,0,2,-15,,0.5)M8 ; drill\nX100\nX300\nMCALL\nM30\n"
    again = [line for line in body(go(tmp_path, text, rough())) if line.startswith("MCALL CYCLE82")]
    assert [line[line.index(")") :] for line in again] == [")M8 ; drill\n", ")\n"]


def test_machine_positions_are_left_alone(tmp_path):
    text = "G54 G90\nG1 X100 F500\nG0 SUPA Z0\nG53 G0 X0\nG1 X100\nM30\n"
    assert body(go(tmp_path, text, scale(100.0)))[1:5] == [
        "G1 X99.990 F500\n", "G0 SUPA Z0\n", "G53 G0 X0\n", "G1 X99.990\n",
    ]  # fmt: skip


def test_a_cycle_with_expressions_is_written_out(tmp_path):
    text = "G54 G90 R1=-15\nG0 X100 Y0 Z50\nF100\nCYCLE81(50,0,2,R1)\nM30\n"
    found = go(tmp_path, text, scale(1000.0, "Z"))
    assert "CYCLE81(50,0.015,2,-14.985)" in found.text
    with pytest.raises(DataError, match="expression"):
        go(tmp_path, text, scale(1000.0, "Z"), inline=0)


def test_diameters(tmp_path):
    # DIAMON: X200 is 100 mm from the axis, cut 10 um too far: the diameter must be 20 um less; steps are diameters too
    text = "G54 G90 G18 DIAMON\nG0 X0 Z0\nG1 X200 F200\nX=IC(20)\nM30\n"
    assert body(go(tmp_path, text, scale(100.0)))[2:4] == ["G1 X199.980 F200\n", "X=IC(19.998)\n"]


def test_a_compensated_program_is_refused(tmp_path):
    done = go(tmp_path, "G54 G90\nG1 X100 F500\nM30\n", scale(100.0)).text
    with pytest.raises(DataError, match="compensated already"):
        go(tmp_path, done, scale(100.0))


def test_a_dwell_between_rapid_and_cut(tmp_path):
    """A rapid corrects the axes that it does not name where a cut follows, also behind a dwell."""
    # 200 urad: at X 100 the tip is 20 um off in Y where the cut begins, at X 200 40 um
    found = go(tmp_path, "G54 G90\nG0 X100\nG4 F1\nG1 X200 F500\nM30\n", mill(Squareness("C0X", 200e-6)))
    assert found.before.largest == pytest.approx(0.040, rel=1e-3)
    assert found.is_met


def test_inverse_time_is_shared_out(tmp_path):
    found = go(tmp_path, "G54 G90\nG93\nG1 X300 F2\nG94\nM30\n", rough())
    feeds = [m.feed for m in interpret(found.text, "sinumerik", SIEMENS).moves]
    assert len(feeds) > 1
    assert feeds == pytest.approx([600.0] * len(feeds), rel=1e-3)  # 300 mm in 1/2 min


@pytest.mark.parametrize("centre", ["I=AC(60) K=AC(0)", "I10 K0"])
def test_a_turned_arc_about_a_centre_in_diameters_reads_its_own_output(tmp_path, centre):
    """A quarter of R10 about X 60 (30 mm from the axis) on a lathe whose X runs 100 um/m too far: X 60 is cut at 30.003 mm, written 59.994.

    The centre goes with it: 30 / 1.0001 = 29.997 mm from the axis, 59.994 in diameters; a way of 10 mm is one of 9.999."""
    text = f"G54 G90 G18 DIAMON\nG0 X40 Z0\nG1 F200 X40 Z0\nG2 X60 Z-10 {centre}\nM30\n"
    found = go(tmp_path, text, scale(100.0), tolerance=2e-4, decimals=4)
    assert found.before.largest == pytest.approx(3e-3, rel=1e-2)
    assert found.after.largest < 0.3e-3
    arcs = [m for m in interpret(found.text, "sinumerik", SIEMENS).moves if m.kind == "arc"]
    assert arcs[-1].end[0] == pytest.approx(29.997, abs=1e-4)
    assert arcs[-1].centre[0] == pytest.approx(29.997, abs=2e-3)
    written = next(line for line in body(found) if "G2" in line)
    assert ("I=AC(59.99" in written) is ("AC" in centre)


def test_a_point_between_in_diameters_reads_its_own_output(tmp_path):
    text = "G54 G90 G18 DIAMON\nG0 X40 Z0\nG1 F200 X40 Z0\nCIP X40 Z-20 I1=60 K1=-10\nCIP X40 Z-40 I1=IC(10) K1=IC(-10)\nM30\n"
    found = go(tmp_path, text, scale(100.0), tolerance=2e-4, decimals=4)
    assert found.before.largest == pytest.approx(3e-3, rel=1e-2)
    assert found.after.largest < 0.3e-3
