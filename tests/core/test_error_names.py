"""Names of component errors in other literatures, against a table written by hand."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.error_names import canonical, is_known, table
from vcmm.core.errors import DataError, UsageError
from vcmm.files.foreign.isg import read_isg

# Error of axis X in direction Y: ISO EYX (direction, axis), δy(x) (direction, axis), xty (axis, direction).
BY_HAND = [
    # ISO    VDI    delta/epsilon  ascii        compact
    ("EXX", "xtx", "δx(x)", "delta_x(x)", "Txx"),
    ("EYX", "xty", "δy(x)", "delta_y(x)", "Txy"),
    ("EZX", "xtz", "δz(x)", "dzx", "Txz"),
    ("EAX", "xrx", "εx(x)", "eps_x(x)", "Rxx"),
    ("EBX", "xry", "εy(x)", "eps_y(x)", "Rxy"),
    ("ECX", "xrz", "εz(x)", "epsilon_z(x)", "Rxz"),
    ("EXY", "ytx", "δx(y)", "dxy", "Tyx"),
    ("EYY", "yty", "δy(y)", "dyy", "Tyy"),
    ("EZY", "ytz", "δz(y)", "delta_zy", "Tyz"),
    ("EAY", "yrx", "εx(y)", "eps_x(y)", "Ryx"),
    ("EBY", "yry", "εy(y)", "eps_yy", "Ryy"),
    ("ECY", "yrz", "εz(y)", "eps_z(y)", "Ryz"),
    ("EXZ", "ztx", "δx(z)", "dx(z)", "Tzx"),
    ("EYZ", "zty", "δy(z)", "delta_y(z)", "Tzy"),
    ("EZZ", "ztz", "δz(z)", "dzz", "Tzz"),
    ("EAZ", "zrx", "εx(z)", "eps_xz", "Rzx"),
    ("EBZ", "zry", "εy(z)", "eps_y(z)", "Rzy"),
    ("ECZ", "zrz", "εz(z)", "eps_z(z)", "Rzz"),
    ("C0Y", "xwy", "sxy", "EC0Y", "Wxy"),
    ("B0Z", "xwz", "sxz", "E_B0Z", "Wxz"),
    ("A0Z", "ywz", "syz", "AOZ", "Wyz"),
]


@pytest.mark.parametrize("names", BY_HAND, ids=lambda names: names[0])
def test_every_name_means_the_same(names):
    assert [canonical(name) for name in names] == [names[0]] * 5


def test_the_printed_table_agrees_with_the_one_by_hand():
    printed = {row[0]: row for row in table()}
    assert list(printed)[:21] == [row[0] for row in BY_HAND]
    for iso, vdi, delta, _, _ in BY_HAND:
        assert vdi in printed[iso][1].split(", ")
        assert printed[iso][2] == delta
    # 18 component errors, 3 squareness, 4 for each of three rotary axes
    assert len(table()) == 18 + 3 + 12


def test_every_printed_name_is_understood():
    for iso, vdi, delta, words in table():
        for name in [iso, *vdi.split(", "), delta, words, words.upper()]:
            assert name == "–" or canonical(name) == iso, name


def test_order_of_the_letters_is_not_mixed_up():
    assert canonical("xty") != canonical("ytx")
    assert canonical("xty") == canonical("δy(x)") == canonical("Txy") == "EYX"
    assert canonical("xry") == canonical("εy(x)") == canonical("Rxy") == "EBX"


def test_plain_words():
    assert canonical("positioning of X") == canonical("xpx") == "EXX"
    assert canonical("straightness of X in Y") == "EYX"
    assert canonical("roll of Z") == "ECZ"
    assert canonical("tilt of X about Y") == "EBX"
    assert canonical("squareness X-Y") == canonical("squareness of Y to X") == "C0Y"


def test_rotary_axes():
    assert [canonical(n) for n in ("X0C", "XOC", "EA0C", "E_B0A", "EXC", "ECC", "δx(c)", "εz(c)")] == [
        "X0C", "X0C", "A0C", "B0A", "EXC", "ECC", "EXC", "ECC",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("wrong", "closest"),
    [
        ("exx", "EXX"),
        ("xtq", "xt"),
        ("xpy", "y"),
        ("EXQ", "EX"),
        ("A0X", "EAX"),
        ("rol of X", "EXX"),
        ("XX", "EXX"),
    ],
)
def test_others_are_refused_with_the_choice(wrong, closest):
    assert not is_known(wrong)
    with pytest.raises(UsageError, match=f'unknown error name "{wrong}".*{closest}'):
        canonical(wrong)


def test_error_files_take_the_aliases(tmp_path):
    path = tmp_path / "errors.csv"
    path.write_text(
        "X xty δz(x) Rxy\n0 0 0 0\n500 0.001 0.002 0.000003\n#\nxwy ywz\n1e-6 2e-6\n", encoding="utf-8"
    )
    read = read_isg(path)
    assert {n: v.tolist() for n, v in read.tables[0].values.items()} == {
        "EYX": [0.0, 0.001], "EZX": [0.0, 0.002], "EBX": [0.0, 3e-6],
    }  # fmt: skip
    assert read.constants == {"C0Y": 1e-6, "A0Z": 2e-6}
    assert np.array_equal(read.tables[0].grids[0], [0.0, 500.0])


def test_one_error_under_two_names_is_noticed(tmp_path):
    path = tmp_path / "errors.csv"
    path.write_text("X EYX xty\n0 0 0\n500 0 0\n")
    with pytest.raises(DataError, match=r"errors.csv:1: EYX is given twice"):
        read_isg(path)
