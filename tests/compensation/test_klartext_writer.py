"""Rewritten Klartext programs against numbers worked out by hand."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.compensation.mill import SETUP, body, mill, rough, run, scale, wavy
from vcmm.core.errors import DataError
from vcmm.physics.structure.squareness import Squareness
from vcmm.program.interpret import interpret

TNC = replace(SETUP, dialect="heidenhain")
HEAD = "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S1000\n"
END = "90 END PGM A MM\n"


def go(tmp_path, text, machine, **more):
    return run(tmp_path, HEAD + text + END, machine, TNC, **more)


def test_lines_words_and_comments(tmp_path):
    # +100 um/m: 100 mm would be cut 10 um too long; IX+100 goes from 99.990 to 199.980
    found = go(tmp_path, "2 L X+100 Y+0 R0 F500 M3 ; wall (left)\n3 L IX+100.0\n", scale(100.0))
    assert body(found)[2:4] == ["2 L X+99.990 Y+0 R0 F500 M3 ; wall (left)\n", "3 L IX+99.990\n"]
    assert found.text.splitlines()[1] == "; VCMM COMPENSATED - DO NOT COMPENSATE AGAIN"
    assert found.after.largest < 1e-5


def test_decimal_commas_stay(tmp_path):
    assert body(go(tmp_path, "2 L X+100,0 F500\n", scale(100.0)))[2] == "2 L X+99,990 F500\n"


def test_a_perfect_machine_changes_nothing(tmp_path):
    text = (
        "2 Q1 = 5\n3 L X+Q1 Y+0 R0 F500\n4 CC X+0 Y+0\n5 C X-5 Y+0 DR+ ; half\n6 LP PR+20 PA+45\n7 CT X+50 Y+80\n8 CC IX+10 Y+80\n"
        "9 CP IPA-90 IZ-1 DR-\n10 CR X+100 Y+0 R+200 DR+\n11 RND R2\n12 L X+0\n"
    )
    found = go(tmp_path, text, mill())
    assert "".join(body(found)) == HEAD + text + END


@pytest.mark.parametrize("block", ["C X+50 Y+0 DR-", "C DR-", "CP IPA-360 DR-"])
def test_squareness_makes_a_circle_four_arcs(tmp_path, block):
    """20 urad on R50 leaves 20e-6 x 50 / 2 = 0.5 um across the path; four arcs leave 0.02 um, as in the other dialects."""
    text = f"2 L X+50 Y+0 Z+0 R0 FMAX\n3 CC X+0 Y+0\n4 {block} F500 ; circle\n5 L Z+10 FMAX M30\n"
    found = go(tmp_path, text, mill(Squareness("C0Y", 20e-6)), tolerance=1e-4, decimals=4)
    assert found.before.largest == pytest.approx(0.5e-3, rel=1e-3)
    assert found.after.largest < 0.03e-3
    arcs = [m for m in interpret(found.text, "heidenhain", TNC).moves if m.kind == "arc"]
    assert len(arcs) == 4
    assert arcs[0].end == pytest.approx((-0.001, -50.0, 0.0))  # x = c y = 20e-6 x -50 mm = -1 um


def test_increments_do_not_drift(tmp_path):
    # 1000 steps of 0.1 mm at +300 um/m: 100 mm become 100.030 mm, so the steps add up to 99.970 mm
    found = go(tmp_path, "2 L X+0 F500\n" + "L IX+0.1\n" * 1000, scale(300.0))
    steps = [float(line[4:]) for line in body(found)[3:1003]]
    assert sum(steps) == pytest.approx(99.970, abs=6e-4)
    assert found.after.largest < 1.1e-3


def test_a_pole_of_two_arcs_is_not_moved_for_both(tmp_path):
    """The first arc moves the CC of the program; the second gets one of its own where its centre is another."""
    text = "2 L X+50 Y+0 R0 F500\n3 CC X+0 Y+0\n4 C X+0 Y+50 DR+\n5 C X-50 Y+0 DR+\n6 L X-60\n"
    found = go(tmp_path, text, rough())
    lines = body(found)
    assert lines[3] != "3 CC X+0 Y+0\n"
    assert sum(line.lstrip("0123456789 ").startswith("CC") for line in lines) >= 2
    assert found.is_met


def test_polar_and_tangential_blocks_become_plain_ones(tmp_path):
    text = "2 L X+0 Y+0 R0 F500\n3 CC X+100 Y+0\n4 LP PR+100 PA+90\n5 CT X+150 Y+120\n6 L X+200\n"
    found = go(tmp_path, text, mill(Squareness("C0Y", 60e-6), wavy("EYX", 4.0, 300.0)))
    assert found.is_met
    lines = body(found)
    assert lines[4].startswith("4 L X+")
    assert any(line.startswith("5 C X+") and " DR" in line for line in lines)


def test_a_helix_stays_a_helix(tmp_path):
    text = "2 L X+50 Y+0 Z+0 R0 F500\n3 CC X+0 Y+0\n4 CP IPA+720 IZ-10 DR+\n5 L Z+50 FMAX M30\n"
    found = go(tmp_path, text, rough())
    assert found.is_met
    assert sum("CP IPA" in line for line in body(found)) >= 2


def test_radius_compensation_and_approach(tmp_path):
    text = (
        "2 L X-30 Y-30 Z-5 R0 FMAX M3\n3 APPR LT X+0 Y+0 LEN12 RL F300\n4 L Y+80\n5 RND R8\n6 L X+120\n7 L Y+0\n8 L X+0\n"
        "9 DEP LT LEN12\n10 L Z+50 FMAX M30\n"
    )
    found = go(tmp_path, text, rough())
    assert found.after.largest < 2e-3 < found.before.largest
    assert " RL F300" in found.text
    assert "DEP LT LEN12" in found.text
    assert "RND R8" in found.text


CYCLE = (
    "2 CYCL DEF 200 DRILLING ~\n  Q200=+2 ;SET-UP CLEARANCE ~\n  Q201=-15 ;DEPTH ~\n  Q206=+150 ~\n  Q202=+5 ~\n  Q210=+0 ~\n"
    "  Q203=+0 ;SURFACE ~\n  Q204=+50 ~\n  Q211=+0\n"
)


def test_holes_one_by_one(tmp_path):
    text = CYCLE + "3 L X+100 Y+0 Z+50 R0 FMAX M99\n4 L X+200 FMAX\n5 CYCL CALL\n6 M30\n"
    lines = body(go(tmp_path, text, scale(100.0)))
    assert lines[11:13] == ["3 L X+99.990 Y+0 Z+50 R0 FMAX M99\n", "4 L X+199.980 FMAX\n"]
    # Z +1000 um/m: at -15 mm the tip is 15 um too low: the surface, and with it all heights, goes up
    lines = body(go(tmp_path, text, scale(1000.0, "Z")))
    assert lines[8] == "  Q203=+0.015 ;SURFACE ~\n"
    assert sum("CYCL DEF" in line for line in lines) == 1


def test_a_cycle_is_defined_again_where_holes_differ(tmp_path):
    text = CYCLE + "3 L X+100 Y+0 Z+50 R0 FMAX M99\n4 L X+300 FMAX M99\n5 M30\n"
    found = go(tmp_path, text, rough())
    lines = body(found)
    assert sum("CYCL DEF 200" in line for line in lines) == 2
    assert "".join(lines).count(";SURFACE") == 1


def test_machine_positions_and_inch(tmp_path):
    assert body(go(tmp_path, "2 L X+100 F500\n3 L X+0 FMAX M91\n4 L X+100\n", scale(100.0)))[2:5] == [
        "2 L X+99.990 F500\n", "3 L X+0 FMAX M91\n", "4 L X+99.990\n",
    ]  # fmt: skip
    # 4 in = 101.6 mm: 10.16 um too far = 0.0004 in
    text = "0 BEGIN PGM A INCH\n1 L X+4 F50\n2 END PGM A INCH\n"
    assert body(run(tmp_path, text, scale(100.0), TNC))[1] == "1 L X+3.9996 F50\n"


def test_modal_calls(tmp_path):
    """M89 calls the cycle after every positioning: no block is added there."""
    text = (
        CYCLE
        + "3 L X+0 Y+0 Z+50 R0 FMAX\n4 L X+100 FMAX M89\n5 L X+200 F500\n6 L X+300 FMAX M99\n7 L Z+60 FMAX M30\n"
    )
    lines = body(go(tmp_path, text, scale(100.0)))
    assert lines[12:15] == ["4 L X+99.990 FMAX M89\n", "5 L X+199.980 F500\n", "6 L X+299.970 FMAX M99\n"]


def test_a_compensated_program_is_refused(tmp_path):
    done = go(tmp_path, "2 L X+100 F500\n", scale(100.0)).text
    with pytest.raises(DataError, match="compensated already"):
        run(tmp_path, done, scale(100.0), TNC)


def test_a_free_contour_is_refused_by_its_line(tmp_path):
    with pytest.raises(
        DataError, match=r"4:1: the free contour .FK. is not rewritten; write its elements with L, C and CR"
    ):
        go(tmp_path, "2 L X+0 Y+0 F500\n3 FL AN+30 LEN20\n4 L X+50\n", scale(100.0))
