"""A program rewritten block by block: its mark, the source of its lines, and what is not rewritten."""

from __future__ import annotations

from dataclasses import replace

import pytest

from tests.compensation.mill import SETUP, body, mill, run, scale, wavy
from tests.compensation.mill import mill as machine
from vcmm.compensation.job import prepare
from vcmm.compensation.rewriting import rewrite
from vcmm.core.errors import DataError
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.squareness import Squareness

HEAD = "%\nO1\nG21 G17 G40 G80 G90 G94 G54\nG0 X0 Y0 Z0\n"


def test_every_line_says_where_it_comes_from(tmp_path) -> None:
    found = run(tmp_path, f"{HEAD}G1 X100. F500\nM30\n%\n", scale(100.0), SETUP)
    assert found.source_lines == (1, 2, 0, 0, 0, 0, 3, 4, 5, 6, 7)
    assert found.text.splitlines()[2] == "(VCMM COMPENSATED - DO NOT COMPENSATE AGAIN)"
    assert found.text.splitlines()[6] == "G21 G17 G40 G80 G90 G94 G54"


def test_a_bow_makes_blocks_behind_the_one_that_it_splits(tmp_path) -> None:
    """8 um of a sine of 400 mm over 400 mm: more than one chord holds 1 um, so blocks are added, all of line 5."""
    text = f"{HEAD}G1 X400. F500\nM30\n%\n"
    found = run(tmp_path, text, machine(wavy("EYX", 8.0, 400.0)), SETUP)
    lines = [n for n in found.source_lines if n == 5]
    assert len(lines) == found.blocks.additions + 1 > 2
    assert found.after.largest < 1.5e-3 < found.before.largest


def test_a_position_of_the_machine_stays(tmp_path) -> None:
    """G53 names a place of the machine: nothing is corrected, and the next block counts from where it leads."""
    found = run(tmp_path, f"{HEAD}G53 G0 Z0\nG1 X100. F500\nM30\n%\n", scale(100.0), SETUP)
    assert "G53 G0 Z0\n" in body(found)
    assert "G1 X99.990 F500\n" in body(found)


def test_a_block_that_runs_twice_is_refused_by_its_line(tmp_path) -> None:
    text = f"{HEAD}M98 P2 L2\nM30\nO2\nG1 X100. F500\nG0 X0\nM99\n%\n"
    with pytest.raises(DataError, match="the block is executed 2 times") as caught:
        run(tmp_path, text, scale(100.0), SETUP, inline=0.0)
    assert caught.value.line == 8


class Looked(tuple):
    """Traces that count how many of them are looked at."""

    count = 0

    def __getitem__(self, at):
        found = super().__getitem__(at)
        Looked.count += len(found) if isinstance(at, slice) else 1
        return found

    def __iter__(self):
        for one in super().__iter__():
            Looked.count += 1
            yield one


def test_every_block_is_looked_at_so_often_however_long_the_program_is(tmp_path) -> None:
    """Twice as many blocks, twice the looks: no block goes through the whole program."""
    looks = []
    for count in (200, 400):
        file = tmp_path / f"long{count}.nc"
        file.write_text(HEAD + "".join(f"G1 X{k % 7}. Y{k % 5}. F500\n" for k in range(count)) + "M30\n%\n")
        work = prepare(
            program=file, setup=SETUP, machine=scale(100.0), dialect="fanuc", decimals=None, set_here=True, constants=None
        )  # fmt: skip
        work = replace(work, program=replace(work.program, traces=Looked(work.program.traces)))
        Looked.count = 0
        rewrite(work, 1e-3)
        looks.append(Looked.count)
    assert looks[1] < 2.1 * looks[0]


SINUMERIK = (
    "G54 G90 G17 S1000 M3 F100\nG0 X0 Y0 Z50\nMCALL CYCLE81(50,0,2,-30)\nX100 Y0\nMCALL\nG0 Z50\nM30\n"
)


def test_a_scale_moves_the_hole(tmp_path) -> None:
    """100 um/m at X 100: the hole is drilled at X 99.990."""
    found = run(tmp_path, SINUMERIK, mill(ScaleFactor("X", 100e-6)), replace(SETUP, dialect="sinumerik"))
    assert "X99.990 Y0\n" in body(found)


def test_a_lean_is_met_half_way(tmp_path) -> None:
    """1 mrad between X and Z: from R 2 to -30 the tool leans by 32 um; the hole stands over the mean, at -14: 14 um beside."""
    lean = mill(Squareness("B0Z", 1e-3))
    found = run(tmp_path, SINUMERIK, lean, replace(SETUP, dialect="sinumerik"))
    (line,) = [text for text in body(found) if "X99.9" in text or "X100.0" in text]
    value = float(line.split()[0].removeprefix("X"))
    assert abs(value - 100.0) == pytest.approx(0.014, abs=0.0011)


def test_depth_follows_the_scale_of_z(tmp_path) -> None:
    """100 um/m along Z: at -30 the tool errs by -3 um, so the definition says 3 um less; the retract plane stays."""
    found = run(tmp_path, SINUMERIK, mill(ScaleFactor("Z", 100e-6)), replace(SETUP, dialect="sinumerik"))
    (cycle,) = [text for text in body(found) if "CYCLE81" in text]
    assert "-29.997" in cycle


def test_an_expression_in_a_definition_is_refused_by_its_line(tmp_path) -> None:
    text = SINUMERIK.replace("-30)", "R1)").replace("G54", "R1=-30\nG54", 1)
    with pytest.raises(DataError, match="is an expression; write it as a number") as caught:
        run(tmp_path, text, mill(ScaleFactor("Z", 100e-6)), replace(SETUP, dialect="sinumerik"), inline=0.0)
    assert caught.value.line == 4
