"""Inches taken for millimetres are named where the other unit would hit the part."""

from __future__ import annotations

import re

import pytest

import vcmm
from tests.shop.machining import lathe, shop
from tests.shop.machining import rotary_shop as rs
from tests.shop.machining.lathe import PLAIN, plain
from vcmm.core.errors import VcmmError
from vcmm.shop.machining.job import cut
from vcmm.shop.machining.wrong_unit import exchange_unit

INCHES = shop.PROGRAM.replace("G21", "G20")


def test_inches_by_mistake_are_named_where_the_travels_end(tmp_path):
    path = shop.write(tmp_path, program=INCHES)
    with pytest.raises(VcmmError, match=r'"G20" in line 3\); in millimetres it would cut 72 of the 72'):
        cut(vcmm.load_cut(path))


def test_inches_by_mistake_are_named_where_nothing_is_cut(tmp_path):
    machine = tmp_path / "mill.toml"
    path = shop.write(tmp_path, program=INCHES)
    long = shop.MACHINE.replace('["0 mm", "600 mm"]', '["-9000 mm", "9000 mm"]')
    long = long.replace('["0 mm", "500 mm"]', '["-9000 mm", "9000 mm"]').replace("500 mm", "2000 mm")
    machine.write_text(long.replace('"0 mm"]', '"2000 mm"]'))
    with pytest.raises(VcmmError, match=r"cuts 0 of its 72 .*in millimetres it would cut 72"):
        cut(vcmm.load_cut(path))


def test_no_unit_is_blamed_where_the_other_one_misses_as_well(tmp_path):
    path = shop.write(tmp_path, scenario=shop.SCENARIO + '[pose]\nshift = "500 250 -350 mm"\n')
    with pytest.raises(VcmmError, match="cuts 0 of its") as caught:
        cut(vcmm.load_cut(path))
    assert "inches" not in str(caught.value)


def inches(program: str) -> str:
    """The program with its lengths and feeds in inches, its code of the unit left as it is."""
    return re.sub(r"([XYZIJKRF])(-?[\d.]+)", lambda m: f"{m[1]}{float(m[2]) / 25.4:.6f}", program)


def test_the_unit_of_a_lathe_program_is_named(tmp_path):
    path = plain(tmp_path, program=inches(PLAIN))
    with pytest.raises(VcmmError, match=r"cuts 0 of its 72 .*in inches it would cut 72 of the 72"):
        cut(vcmm.load_cut(path))
    assert "G21" in lathe.HEAD


@pytest.mark.parametrize(
    ("angle", "face"), [(0, 'point = "0 0 40 mm", normal = [0, 0, 1]'), (90, 'point = "40 0 0 mm", normal = [1, 0, 0]')]
)  # fmt: skip
def test_the_unit_of_a_program_on_a_turned_pallet_is_named(tmp_path, angle, face):
    way = inches("G0 X-45. Y-10.\nG43 H1 Z60.\nZ40.\nG1 X45. F600\nG1 Y10.\nG1 X-45.\nG0 Z200.\n")
    feature = f'face = {{ type = "plane", {face}, size = "40 40 mm" }}\n'
    asked = '[[part.characteristics]]\nname = "flat"\ntype = "flatness"\nof = "face"\nzone = "0.01 mm"\n'
    mill = rs.machine("w B' Z' b X Y t", rs.axis("B"))
    path = rs.write(tmp_path, mill, f"G0 B{angle}.\n{way}", feature, 'diameter = "24 mm"\n', "", asked)
    with pytest.raises(VcmmError, match=r"in inches it would cut 49 of the 49"):
        cut(vcmm.load_cut(path))


@pytest.mark.parametrize(
    ("text", "dialect", "other"),
    [
        ("%\nO1\nG20 G90\nG1 X1. G21\n", "fanuc", ("%\nO1\nG21 G90\nG1 X1. G20\n", "G20", 3)),
        ("%\nO1 (A)\nG90\nG1 X1.\n", "fanuc", ("%\nO1 (A)\nG20\nG90\nG1 X1.\n", "G21", 0)),
        ("N1 G70\nG0 X1\n", "sinumerik", ("N1 G71\nG0 X1\n", "G70", 1)),
        ("0 BEGIN PGM A MM\n2 END PGM A MM\n", "heidenhain", ("0 BEGIN PGM A INCH\n2 END PGM A INCH\n", "MM", 1)),
        ("G70 P1 Q2\nG0 X1", "fanuc-lathe", ("G20\nG70 P1 Q2\nG0 X1", "G21", 0)),  # there G70 is a cycle
    ],
)  # fmt: skip
def test_exchange_of_the_unit(text, dialect, other):
    assert exchange_unit(text, dialect) == other
