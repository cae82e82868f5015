"""Stock: volumes, engagement, collisions by hand; the nodes against the exact envelope; a closed mesh."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit
from vcmm.shop.cutting.envelope import surface_left
from vcmm.shop.cutting.stock import block, remove
from vcmm.shop.cutting.sweeps import arcs, join, lines
from vcmm.shop.cutting.tools import ball, bull, cone, flat


def test_slot_by_hand() -> None:
    """A slot 10 wide, 2 deep, through 60 mm: 1200 mm3. Full engagement: 0 to pi, ap 2, ae 10."""
    stock = block([0, 0, 0], [60, 40, 20], 0.1)
    done = remove(stock, lines([[-10, 20, 18]], [[70, 20, 18]], (flat(5.0),)))
    assert stock.volume == pytest.approx(48000.0)
    assert done.volume[0] == pytest.approx(1200.0, rel=1e-9)
    assert done.stock.volume == pytest.approx(46800.0)
    assert done.axial[0] == pytest.approx(2.0)
    assert done.radial[0] == pytest.approx(10.0)
    assert (done.enter[0], done.leave[0]) == pytest.approx((0.0, math.pi))
    assert not len(done.idle)


def test_side_cut_by_hand() -> None:
    """Material on the right up to 2 mm inside a tool of R 5: cos(enter) = -(1 - 2/5) = -0.6, climb, ae 2 to one step of phi."""
    done = remove(block([0, 0, 0], [60, 17, 20], 0.05), lines([[-10, 20, 15]], [[70, 20, 15]], (flat(5.0),)))
    assert done.leave[0] == pytest.approx(math.pi)
    assert done.enter[0] == pytest.approx(math.acos(-0.6), abs=math.pi / 72)
    assert done.radial[0] == pytest.approx(2.0, abs=0.2)
    assert done.axial[0] == pytest.approx(5.0)
    assert done.volume[0] == pytest.approx(60 * 2 * 5, rel=1e-9)


def test_rapids_and_idle_moves_are_named() -> None:
    """A rapid at z = 18 through a block of height 20: 2 mm deep; one at 21 is free; a feed move in air is idle."""
    moves = lines(
        [[-10, 20, 21], [70, 20, 18], [-10, 20, 25]],
        [[70, 20, 21], [-10, 20, 18], [70, 20, 25]],
        (flat(5.0),),
    )
    done = remove(block([0, 0, 0], [60, 40, 20], 0.5), moves, rapid=np.array([True, True, False]))
    assert done.collisions.tolist() == [1]
    assert done.collision_depth == pytest.approx([2.0])
    assert done.idle.tolist() == [2]
    assert done.stock.volume == pytest.approx(48000.0)  # rapids are reported, not cut


@pytest.mark.thorough
def test_nodes_are_exact() -> None:
    """All tools on ramps, level moves and a helix: the heights equal the envelope along +Z to 1e-9 mm."""
    tools = (flat(3.0), ball(3.0), bull(3.0, 1.0), cone(3.0, 1.6, 0.5))
    rng = np.random.default_rng(4)
    start, end = rng.uniform(5, 35, (2, 16, 3))
    start[:, 2], end[:, 2] = rng.uniform(6, 9, (2, 16))
    end[::3, 2] = start[::3, 2]
    which = np.arange(16) % 4
    ring = arcs([[28, 20, 9]], [[28, 20, 7]], [[20, 20, 9]], 4 * np.pi, tools, tool=2)
    sweep = join([lines(start, end, tools, which), ring])
    done = remove(block([0, 0, 0], [40, 40, 10], 2.0), sweep).stock
    x, y = np.meshgrid(done.x0 + 2.0 * np.arange(20), done.y0 + 2.0 * np.arange(20), indexing="ij")
    p = np.stack([x, y, np.full_like(x, 0.0)], -1).reshape(-1, 3)
    left = surface_left(p, np.tile([0, 0, 1.0], (400, 1)), sweep, height=10.0)
    want = np.where(np.isnan(left.s), 10.0, left.s)
    assert np.abs(done.height.ravel() - want).max() < 1e-9
    assert (want < 10.0).mean() > 0.4


def test_an_inclined_tool_is_refused() -> None:
    with pytest.raises(ModelLimit, match="three-axis"):
        remove(
            block([0, 0, 0], [9, 9, 9], 1.0), lines([[0, 0, 0]], [[1, 0, 0]], (flat(5.0),), axis=[1.0, 0, 0])
        )


def test_an_arc_whose_rounded_end_lies_on_another_radius_cuts_as_a_circle() -> None:
    """A quarter of 7 mm whose end is 0.03 um farther out, as in a program of three decimals: it was searched column by column, for minutes."""
    before = block(np.array([-15.0, -15.0, -5.0]), np.array([15.0, 15.0, 0.0]), 0.2)
    cut = [
        remove(
            before,
            arcs(
                [[7.0, 0.0, -2.0]], [[0.0, 7.0 + off, -2.0]], [[0.0, 0.0, -2.0]], [math.pi / 2], (flat(3.0),)
            ),
        )
        for off in (0.0, 3e-5)
    ]
    assert cut[1].volume == pytest.approx(cut[0].volume, rel=1e-3)
    assert cut[0].volume[0] > 0.9 * (math.pi / 4 * (10.0**2 - 4.0**2) + math.pi * 3.0**2) * 2.0
