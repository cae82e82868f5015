"""G70 to G73: roughing along a contour, hand-computed."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup

CONTOUR = "N10 G0 X20.\nG1 Z-10. F0.2\nX30.\nN20 Z-20.\n"


def tips(text: str, dialect: str = "fanuc-lathe") -> list[tuple[str, float, float]]:
    program = interpret(f"O1\nG21 G99 G97 S1000 M3\n{text}M30\n", dialect, Setup(strict=False))
    return [(m.kind, round(m.end[0], 6), round(m.end[2], 6)) for m in program.moves]


def test_g71_in_two_blocks():
    # from X40 Z2 (radius 20): levels 18, 16, 14, 12 (depth 2, 10.5 being the contour with 0.5 left on the radius), Z ends where the
    # contour with its allowance (0.5, 0.1) is met: at radius 15.5 the step Z-9.9; 45 degrees back by 1 each time
    found = tips(f"G0 X40. Z2.\nG71 U2. R1.\nG71 P10 Q20 U1. W0.1 F0.3\n{CONTOUR}")
    assert found[:6] == [
        ("rapid", 20, 2), ("rapid", 20.5, 2.1), ("rapid", 18.5, 2.1), ("line", 18.5, -19.9), ("line", 19.5, -18.9), ("rapid", 19.5, 2.1),
    ]  # fmt: skip
    cuts = [(x, z) for kind, x, z in found if kind == "line"]
    assert [c for c in cuts if c[1] == -19.9][:2] == [(18.5, -19.9), (16.5, -19.9)]
    assert (14.5, -9.9) in cuts
    assert (12.5, -9.9) in cuts
    assert found[-5:] == [
        ("rapid", 10.5, 2.1), ("line", 10.5, -9.9), ("line", 15.5, -9.9), ("line", 15.5, -19.9), ("rapid", 20, 2),
    ]  # fmt: skip


def test_passes_end_on_the_arc_itself():
    # a quarter of radius 10 from radius 10, Z-10 to radius 20, Z-20, its centre with the allowance (0.5, 0.1) at (20.5, -9.9): at the
    # level of radius 16.5 that is Z -9.9 - sqrt(10^2 - 4^2) = -19.065151
    contour = "N10 G0 X20.\nG1 Z-10. F0.2\nG2 X40. Z-20. R10.\nN20 X46.\n"
    found = tips(f"G0 X44. Z2.\nG71 U2. R1.\nG71 P10 Q20 U1. W0.1 F0.3\n{contour}")
    ends = {x: z for kind, x, z in found if kind == "line" and x in (18.5, 16.5, 14.5, 12.5)}
    assert ends == {18.5: -19.697959, 16.5: -19.065151, 14.5: -17.9, 12.5: -15.9}


def test_one_block_is_the_same_with_its_own_words():
    two = tips(f"G0 X40. Z2.\nG71 U2. R0.\nG71 P10 Q20 U1. W0.1 F0.3\n{CONTOUR}")
    one = tips(f"G0 X40. Z2.\nG71 P10 Q20 U1. W0.1 D2. F0.3\n{CONTOUR}", "haas-lathe")
    assert one == two


def test_g70_follows_the_contour_and_goes_back():
    found = tips(f"G0 X40. Z2.\nG71 U5. R0.\nG71 P10 Q20 U0 W0 F0.3\n{CONTOUR}G70 P10 Q20\n")
    assert found[-5:] == [
        ("rapid", 10, 2), ("line", 10, -10), ("line", 15, -10), ("line", 15, -20), ("rapid", 20, 2),
    ]  # fmt: skip


def test_g72_cuts_across():
    # facing from Z1 in steps of 1: contour X20 at Z-3 out to X30 at Z-3 (radius 10 to 15)
    found = tips("G0 X40. Z1.\nG72 W1. R0.5\nG72 P10 Q20 U0 W0 F0.2\nN10 G0 Z-3.\nG1 X20.\nN20 Z0.\n")
    assert ("line", 10, 0) in found
    assert ("line", 10, -1) in found
    assert ("line", 10, -2) in found
    assert found[-4:] == [("rapid", 20, -3), ("line", 10, -3), ("line", 10, 0), ("rapid", 20, 1)]


def test_g73_moves_the_contour_nearer():
    # three passes, 4 mm of radius and 2 of Z on the way: shifts 4, 2, 0
    found = tips(f"G0 X40. Z2.\nG73 U4. W2. R3\nG73 P10 Q20 U0 W0 F0.3\n{CONTOUR}")
    assert [x for kind, x, z in found if kind == "line" and z in (-8, -9, -10)] == [14, 19, 12, 17, 10, 15]


def test_an_inside_contour_is_cut_outward():
    found = tips("G0 X10. Z2.\nG71 U2. R0.\nG71 P10 Q20 U-1. W0 F0.3\nN10 G0 X20.\nG1 Z-10.\nN20 X10.\n")
    levels = [x for kind, x, z in found if kind == "line" and z == -10]
    assert levels[:2] == [6.5, 8.5]  # from radius 5 less 0.5, by 2


def test_what_a_contour_needs():
    with pytest.raises(DataError, match="no block N99"):
        tips("G0 X40. Z2.\nG71 U2. R1.\nG71 P10 Q99 U1. W0.1\nN10 G0 X1.\n")
    with pytest.raises(DataError, match="no depth of cut"):
        tips(f"G0 X40. Z2.\nG71 P10 Q20 U1. W0.1\n{CONTOUR}")


def test_g70_without_its_blocks_is_refused_and_a_word_without_use_is_told():
    """U0.5 beside G70 finishes nothing; W of the first block of G71 is no word of it (U and R are)."""
    with pytest.raises(DataError, match="4:1: G70 needs P and Q"):
        interpret(
            "O1\nG21 G99 G97 S1000 M3\nG0 X40. Z2.\nG70 U0.5\nM30\n", "fanuc-lathe", Setup(strict=False)
        )
    text = (
        f"O1\nG21 G99 G97 S1000 M3\nG0 X40. Z2.\nG71 U2. W5. R1.\nG71 P10 Q20 U1. W0.1 F0.3\n{CONTOUR}M30\n"
    )
    read = interpret(text, "fanuc-lathe", Setup(strict=False))
    assert [(u.line, u.word) for u in read.unused] == [(4, "W5.")]
    with pytest.raises(DataError, match='4:9: nothing in this block uses the word "W"'):
        interpret(text, "fanuc-lathe", Setup(strict=True))


def test_the_number_of_passes_of_g73_is_no_length():
    for text in ("G73 U4. W2. R3\nG73 P10 Q20 U0 W0 F0.3\n", "G73 P10 Q20 I4. K2. U0 W0 D3 F0.3\n"):
        whole = f"O1\nG21 G99 G97 S1000 M3\nG0 X40. Z2.\n{text}{CONTOUR}M30\n"
        program = interpret(whole, "haas-lathe", Setup(strict=False))
        assert not [r.text for r in program.warnings if "decimal point" in r.text]
        assert len([m for m in program.moves if m.kind == "line" and m.end[2] in (-8, -9, -10)]) == 6


def test_a_contour_that_comes_back_is_told_and_refused_by_strict():
    """X30 and back to X24: a pass at X26 ends at the first wall, and the pocket behind it is cut by the last way alone (type II would clear it)."""
    text = "O1\nG21 G99 G97 S1000 M3\nG0 X62. Z2.\nG71 U2. R0.5\nG71 P10 Q20 U0. W0. F0.25\nN10 G0 X20. Z1.\nG1 X30. Z-30.\nX{:g}. Z-40.\nN20 X62.\nM30\n"
    found = interpret(text.format(24), "fanuc-lathe", Setup(strict=False)).assumed
    assert [(a.line, a.what) for a in found if "G71" in a.what] == [
        (5, "G71 along a contour that comes back in X")
    ]
    assert not any(
        "G71" in a.what for a in interpret(text.format(30), "fanuc-lathe", Setup(strict=False)).assumed
    )
    with pytest.raises(DataError, match=r"comes back in X \(type II\)"):
        interpret(text.format(24), "fanuc-lathe", Setup(strict=True, unit=1.0))


def test_drilling_from_the_side_behind_drilling_from_the_front_has_levels_of_its_own():
    """G83 ends at Z2, X40. G87 X10 R-2 begins at radius 20: to 18, in to 5, back to 20 (it took the Z levels of G83 and was refused)."""
    found = tips("G0 X40. Z2.\nG83 Z-10. R-1. F0.1\nG87 X10. R-2. F0.1\nG80\n")
    assert found[-3:] == [("rapid", 18, 2), ("line", 5, 2), ("rapid", 20, 2)]
