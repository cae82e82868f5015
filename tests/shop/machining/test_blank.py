"""The stock of a job: kept as heights or as rays, rapids and shanks that run through it; numbers by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import VcmmError
from vcmm.program.interpret import read_program
from vcmm.program.setup import Setup, Tool
from vcmm.shop.cutting.dexels import Dexels
from vcmm.shop.cutting.solid import picture, triangles, write_stl
from vcmm.shop.cutting.stock import Stock
from vcmm.shop.cutting.sweeps import Sweep, join, lines
from vcmm.shop.cutting.tools import flat
from vcmm.shop.machining.blank import Blank, machined_blank, notes
from vcmm.shop.machining.preparation import set_up

PROGRAM = (
    "%\nG21 G17 G90 G94 G40 G49\nT1 M6\nG0 X-10. Y10. Z6. S3000 M3\nG1 X40. F600\nG1 X50.\nG0 X60.\nM30\n%\n"
)
TOOLS = (flat(5.0), flat(2.0))


def cut(tmp_path, sweep: Sweep, kinds: list[int], **more) -> Blank:
    """A block of 30 x 20 x 10 mm from the zero on; kinds: move of the program that each row of the sweep belongs to."""
    from dataclasses import replace

    (tmp_path / "part.nc").write_text(PROGRAM)
    setup = Setup(stock=(30.0, 20.0, 10.0), stock_corner=(0.0, 0.0, 0.0), **more)
    program = read_program(tmp_path / "part.nc", "fanuc", setup)
    moves = [next(i for i, m in enumerate(program.moves) if m.source.line == line) for line in kinds]
    found = machined_blank(setup, program, replace(sweep, move=np.array(moves)), np.zeros(3))
    assert found is not None
    return found


@pytest.mark.thorough
def test_a_tool_from_another_side_makes_an_undercut(tmp_path):
    """Slot along x, 10 wide and 4 deep, and a bore D 4 along x by a tool that lies along x.

    Removed 30 x 10 x 4 + 30 pi 2^2 = 1200 + 376.99 = 1576.99 mm3; a map of heights would have no roof over the bore.
    """
    slot = lines([[-10, 10, 6]], [[40, 10, 6]], TOOLS)
    bore = lines([[40, 10, 3]], [[-5, 10, 3]], TOOLS, tool=1, axis=[1.0, 0, 0])
    found = cut(tmp_path, join([slot, bore]), [5, 6])
    assert isinstance(found.after, Dexels)
    assert found.removed_volume == pytest.approx(1200 + 30 * math.pi * 4, rel=0.01)
    (said,) = notes(found)
    assert "several sides" in said
    import trimesh

    mesh = trimesh.Trimesh(*triangles(found.after), process=False)
    assert mesh.is_watertight
    assert mesh.euler_number == 0  # the tunnel is there
    write_stl(found.after, tmp_path / "stock.stl")
    assert trimesh.load(tmp_path / "stock.stl").volume == pytest.approx(6000 - found.removed_volume, rel=0.02)


def test_pictures_hold_few_enough_triangles(tmp_path):
    """A square map of 600 x 600 nodes and rays of a cube would give hundreds of thousands; a scene draws 30 000."""
    blank = set_up(vcmm.load_cut(shop.write(tmp_path, setup=shop.SETUP + STOCK))).blank
    vertices, faces = picture(blank.after, 28_000)
    assert 10_000 < len(faces) <= 28_000
    assert np.ptp(vertices, axis=0) == pytest.approx([140, 140, 20], rel=0.03)
    slot = lines([[-10, 10, 6]], [[40, 10, 6]], TOOLS)
    bore = lines([[40, 10, 3]], [[-5, 10, 3]], TOOLS, tool=1, axis=[1.0, 0, 0])
    rays = cut(tmp_path, join([slot, bore]), [5, 6]).after
    assert 2_000 < len(picture(rays, 28_000)[1]) <= 28_000


def test_one_side_stays_a_map_of_heights(tmp_path):
    found = cut(tmp_path, lines([[-10, 10, 6]], [[40, 10, 6]], TOOLS), [5])
    assert isinstance(found.after, Stock)
    assert found.removed_volume == pytest.approx(1200, rel=0.01)


def test_a_rapid_through_what_no_feed_move_removes(tmp_path):
    """The bore of the test above run as a rapid: 377 mm3 that no feed move would remove."""
    slot = lines([[-10, 10, 6]], [[40, 10, 6]], TOOLS)
    bore = lines([[40, 10, 3]], [[-5, 10, 3]], TOOLS, tool=1, axis=[1.0, 0, 0])
    text = " ".join(notes(cut(tmp_path, join([slot, bore]), [5, 7])))
    amount = float(text.split("remove ")[-1].split(" mm")[0])
    assert amount == pytest.approx(30 * math.pi * 4, rel=0.02)


def test_a_slot_cut_from_the_side_by_pencil(tmp_path):
    """A mill D 4 with 2 teeth lies along +X and runs along +Y, 15 mm deep in the block, all of its diameter in it; 600 mm/min, 3000/min: 0.1 mm per tooth.

    N a / 2 pi = 4.775 mm; along the feed 4.775 (-0.025 168.8 2 pi - 2 30.8) = -420.7 N, left of it (X x Y = Z) 4.775 (0.025 796.1 2 pi + 2 27.7) = 861.6 N.
    """
    slot = lines([[15, -5, 3]], [[15, 25, 3]], TOOLS, tool=1, axis=[1.0, 0, 0])
    found = cut(tmp_path, slot, [5], material="Al7075", tools={1: Tool(1, diameter=4.0, teeth=2)})
    assert found.forces is not None
    assert "no cutting forces" not in notes(found)[0]
    within = np.abs(found.pieces.sweep.start[:, 1] - 10.0) < 5.0
    assert found.forces[within].mean(axis=0)[1:] == pytest.approx([-420.7, 861.6], rel=0.02)


SHANK = 'cutting_length = "6 mm"\nshank_diameter = "26 mm"\n'
STOCK = '[stock]\nbox = ["140 mm", "140 mm", "20 mm"]\n'


def test_a_shank_wider_than_the_cutter_runs_into_the_wall(tmp_path):
    """The boss is 10 mm high, the edges of the cutter 6 mm: the shank of D 26 stands 3 mm over it, 4 mm deep.

    Heights are those of the whole program: what stands beside the cutter outside of the slot is 10 mm high as well.
    """
    setup = shop.SETUP + SHANK + STOCK
    blank = set_up(vcmm.load_cut(shop.write(tmp_path, setup=setup))).blank
    lines_hit = {line: depth for line, _, depth in blank.shanks}
    assert lines_hit[10] == pytest.approx(4.0, abs=1e-9)  # G2 around the boss
    assert any("shank of tool 1" in text and "4.00 mm deep" in text for text in notes(blank))
    lines_told = [line for line, _, _ in blank.shanks]
    assert len(lines_told) == len(set(lines_told))
    long = shop.SETUP + SHANK.replace('"6 mm"', '"10.5 mm"') + STOCK
    assert not set_up(vcmm.load_cut(shop.write(tmp_path, setup=long))).blank.shanks


def test_a_shank_is_stated_whole(tmp_path):
    setup = shop.SETUP + 'shank_diameter = "26 mm"\n'
    with pytest.raises(VcmmError, match="cutting_length"):
        set_up(vcmm.load_cut(shop.write(tmp_path, setup=setup)))


SLOT = """%
O1
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-60. Y0 S3000 M3
G43 H1 Z-4.
G1 X60. F600
G0 Z50.
M30
%
"""


def test_forces_follow_the_engagement_along_one_move(tmp_path):
    """One move through a block from X -30 to 30, radius 10 mm: nothing in the air, all of it in the slot, a part at the entry.

    In the middle half the circle is at work. When the axis is 6 mm before the face its tip reaches 4 mm into the block: the arc
    at work is 2 acos(0.6) = 106 deg instead of 180 deg.
    """
    setup = shop.SETUP + 'teeth = 4\n[stock]\nbox = ["60 mm", "60 mm", "20 mm"]\nmaterial = "42CrMo4"\n'
    ready = set_up(vcmm.load_cut(shop.write(tmp_path, program=SLOT, setup=setup)))
    blank = ready.blank
    row = int(np.flatnonzero([ready.line_of(i) == 7 for i in range(len(ready.sweep))])[0])

    def force(x: float) -> float:
        piece, _ = blank.pieces.at(np.array([row]), np.array([(x + 60.0) / 120.0]))
        return float(np.linalg.norm(blank.forces[piece[0]]))

    assert force(-50.0) == 0.0
    assert force(0.0) == pytest.approx(force(15.0), rel=0.02)
    assert 0.3 * force(0.0) < force(-36.0) < 0.9 * force(0.0)
    assert force(50.0) == 0.0
