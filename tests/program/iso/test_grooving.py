"""G74 to G76 and the single cuts G90, G92, G94 of a lathe, hand-computed."""

from __future__ import annotations

import itertools

import pytest

from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup


def tips(text: str, dialect: str = "fanuc-lathe") -> list[tuple[str, float, float]]:
    program = interpret(f"O1\nG21 G99 G97 S1000 M3 F0.2\n{text}\nM30\n", dialect, Setup(strict=False))
    return [(m.kind, round(m.end[0], 6), round(m.end[2], 6)) for m in program.moves]


def test_g90_is_a_box_and_stays_in_force():
    found = tips("G0 X40. Z2.\nG90 X36. Z-20.\nX32.\nG0 Z5.")
    assert found[1:5] == [("rapid", 18, 2), ("line", 18, -20), ("line", 20, -20), ("rapid", 20, 2)]
    assert found[5:9] == [("rapid", 16, 2), ("line", 16, -20), ("line", 20, -20), ("rapid", 20, 2)]
    assert found[9] == ("rapid", 20, 5)


def test_g90_with_a_taper_and_g94_and_system_b():
    assert tips("G0 X40. Z2.\nG90 X36. Z-20. R-2.")[1:3] == [("rapid", 16, 2), ("line", 18, -20)]
    face = [("rapid", 20, -1), ("line", 5, -1), ("line", 5, 2), ("rapid", 20, 2)]
    assert tips("G0 X40. Z2.\nG94 X10. Z-1.")[1:] == face
    assert tips("G90 G0 X40. Z2.\nG79 X10. Z-1.", "fanuc-lathe-b")[1:] == face


def test_g92_is_a_thread_of_its_lead():
    program = interpret("O1\nG21 G97 S500 M3\nG0 X24. Z5.\nG92 X19.4 Z-20. F1.5\nX19.\nM30\n", "fanuc-lathe")
    threads = [m for m in program.moves if m.kind == "thread"]
    assert [(m.end[0], m.feed) for m in threads] == [(pytest.approx(9.7), 750), (pytest.approx(9.5), 750)]


def test_g74_pecks_along_z():
    # 10 mm in pecks of 4000 increments, back 0.5 mm each
    found = tips("G0 X0. Z1.\nG74 R0.5\nG74 Z-9. Q4000 F0.1")
    assert found[1:] == [
        ("line", 0, -3), ("rapid", 0, -2.5), ("line", 0, -7), ("rapid", 0, -6.5), ("line", 0, -9), ("rapid", 0, 1),
    ]  # fmt: skip


def test_g75_makes_grooves_side_by_side():
    # X from 40 to 30 (radius 20 to 15), Z -10 and -13 in steps of 3
    found = tips("G0 X40. Z-10.\nG75 R0.1\nG75 X30. Z-13. P5000 Q3000 F0.1")
    assert [f for f in found if f[0] == "line"] == [("line", 15, -10), ("line", 15, -13)]
    assert tips("G0 X40. Z-10.\nG75 X30. Z-13. I5. K3. F0.1", "haas-lathe")[1:] == found[1:]


def test_g76_divides_its_depth_by_equal_areas():
    # height 0.9, first 0.4: 0.4, 0.4 sqrt 2 = 0.5657, 0.4 sqrt 3 = 0.6928, 0.8, then the allowance 0.1 in one finishing pass
    found = tips("G0 X24. Z5.\nG76 P010060 Q50 R0.1\nG76 X18.2 Z-20. P900 Q400 F1.5")
    depths = [round(10 - x, 4) for kind, x, _ in found if kind == "thread"]
    assert depths == [0.4, 0.5657, 0.6928, 0.8, 0.9]
    starts = [
        z
        for (kind, _, z), (after, _, _) in itertools.pairwise(found)
        if after == "thread" and kind == "rapid"
    ]
    assert starts[0] == pytest.approx(5 - 0.4 * 0.57735, abs=1e-5)  # along the flank, half of 60 degrees
