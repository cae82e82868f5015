"""Cuts that cannot be right: what is said when the unit, the tool length, the forces or the program itself are wrong."""

from __future__ import annotations

import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.face.cli import run as command
from vcmm.program.interpret import interpret
from vcmm.shop.cutting.solid import thinning
from vcmm.shop.machining.job import cut
from vcmm.shop.machining.preparation import set_up
from vcmm.show.pages.cut import MOST_FACES


def test_a_tool_length_that_is_not_in_force_is_refused(tmp_path):
    path = shop.write(tmp_path, program=shop.PROGRAM.replace("G43 H1 ", ""))
    with pytest.raises(UsageError, match=r"line 8 .*would cut 100 mm too deep; add G43 H1"):
        cut(vcmm.load_cut(path))


def test_every_missing_number_is_named_with_its_key(tmp_path):
    text = shop.PROGRAM.replace("M30", "G41 D7 G1 X0. F100.\nX-5.\nG40 X-20.\nM98 P5001\nM30")
    with pytest.raises(DataError) as caught:
        cut(vcmm.load_cut(shop.write(tmp_path, program=text)))
    tool, diameter, subprogram = caught.value.problems
    assert "cut needs tool 7: write [tools.7] length" in tool
    assert "cut needs the diameter of tool 7: write [tools.7] diameter" in diameter
    assert "cut needs the subprogram O5001 (O5001.nc)" in subprogram
    assert "put it into the program, or add the file that has it" in subprogram


def test_a_tool_that_stays_in_the_changer_is_remarked():
    found = interpret("G21 T5\nG0 X1.\nG1 X2. F100\nM30\n", "fanuc")
    assert [(w.line, "M6" in w.text) for w in found.warnings if "T5" in w.text] == [(3, True)]
    called = interpret("G21 T5 M6\nG1 X2. F100\nT6\nM30\n", "fanuc")  # T6 is made ready for the next part
    assert not [w for w in called.warnings if "changer" in w.text or "M6" in w.text]


def test_deflection_without_forces_says_what_the_set_up_lacks(tmp_path):
    bends = '[[effects]]\neffect = "tool_deflection"\ncompliance = "0.1 um/N"\n'
    with pytest.raises(UsageError, match=r"add \[stock\] with box \(or bar\) and material"):
        cut(vcmm.load_cut(shop.write(tmp_path, bends)))


def test_both_counts_of_gouges_say_of_what(tmp_path, capsys):
    path = shop.write(tmp_path, program=shop.PROGRAM.replace("X20. Y60.", "X20. Y50."))
    assert command(["cut", str(path)]) == 1
    out, err = capsys.readouterr()
    assert "of its 72 inspection points deeper than 10 µm" in err
    assert "points of the nets on all features; 0 uncut" in out
    # gouged points lie in walls of the gouge, which move by more than any error: they are not cut again
    assert "cut again with the tools really displaced, " not in err


@pytest.mark.thorough
def test_a_square_stock_has_a_picture(tmp_path, monkeypatch):
    """A coarser map of heights and fewer faces than usual; the numbers of faces as usual are counted below."""
    from vcmm.shop.machining import blank
    from vcmm.show.pages import cut as page

    monkeypatch.setattr(blank, "NODES", 150)
    monkeypatch.setattr(page, "MOST_FACES", 6000)
    stock = shop.SETUP + '[stock]\nbox = ["150 mm", "150 mm", "20 mm"]\n'
    path = shop.write(tmp_path, setup=stock)
    assert command(["cut", str(path), "--out", str(tmp_path / "out"), "--json"]) == 0
    assert "What is left of the stock" in (tmp_path / "out" / "report.html").read_text()
    assert (tmp_path / "out" / "stock.stl").stat().st_size > 1000
    for nx, ny in ((601, 601), (601, 2), (90, 600)):  # 2 triangles per cell above and below
        every = thinning(nx, ny, MOST_FACES)
        assert 4 * -(-nx // every) * -(-ny // every) <= MOST_FACES


def test_g1_before_the_length_is_in_force_only_positions(tmp_path):
    program = shop.PROGRAM.replace("G54 G0 X-20. Y90. S3000 M3", "G54 G1 X-20. Y90. F2000 S3000 M3")
    plain = set_up(vcmm.load_cut(shop.write(tmp_path)))
    job = set_up(vcmm.load_cut(shop.write(tmp_path, program=program)))
    assert [m.end for m in job.program.moves] == [m.end for m in plain.program.moves]


def test_the_tool_that_is_in_the_spindle_cuts(tmp_path):
    program = shop.PROGRAM.replace("T1 M6\n", "").replace("G43 H1 ", "G0 ")
    with pytest.raises(UsageError, match=r"none has been called; add \[tools.spindle\]"):
        set_up(vcmm.load_cut(shop.write(tmp_path, program=program)))
    setup = shop.SETUP.replace("[tools.1]", "[tools.spindle]").replace('"100 mm"', '"0 mm"')
    scenario = shop.SCENARIO + '[cut.tools.spindle]\nu_radius = "2 um"\n'
    job = set_up(vcmm.load_cut(shop.write(tmp_path, program=program, setup=setup, scenario=scenario)))
    assert {m.tool for m in job.program.moves} == {0}
    assert "tool_radius[0].dr" in [one.id for one in job.scenario.inputs]


def test_a_work_offset_that_the_set_up_lacks_is_named_where_the_travels_are_left(tmp_path):
    """X-20 counts from machine zero then, 20 mm outside; it said no more than "check work offset and tool length"."""
    setup = shop.SETUP.replace("G54 =", "G55 =")
    with pytest.raises(
        ModelLimit,
        match=r"out of travel: .* work offset G54 is not in the set-up, and machine zero is taken: add it",
    ):
        set_up(vcmm.load_cut(shop.write(tmp_path, setup=setup)))
