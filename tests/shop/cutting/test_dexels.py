"""Tri-dexels: volumes and ray ends by hand, tool along X and Z, a closed surface."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.shop.cutting.dexels import both, carve, sparser, surface
from vcmm.shop.cutting.solid import picture
from vcmm.shop.cutting.sweeps import arcs, join, lines
from vcmm.shop.cutting.tools import flat

TOOLS = (flat(5.0),)


def test_uncut_block() -> None:
    import trimesh

    block = carve([0, 0, 0], [30, 20, 10], 1.0, lines([[0, 0, 50]], [[1, 0, 50]], TOOLS))
    assert [block.volume(d) for d in range(3)] == pytest.approx([6000.0] * 3)
    mesh = trimesh.Trimesh(*surface(block), process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(6000.0, rel=0.01)  # edges are bevelled by half a cell
    assert mesh.volume > 0


def test_every_third_ray_of_an_uncut_block_is_the_block() -> None:
    """30 x 20 x 10 rays of 1 mm: 10 x 7 x 4 of 3 mm; along X the seventh strip of Y and the fourth of Z stand over."""
    block = carve([0, 0, 0], [30, 20, 10], 1.0, lines([[0, 0, 50]], [[1, 0, 50]], TOOLS))
    few = sparser(block, 3)
    assert few.nodes.tolist() == [10, 7, 4]
    assert few.volume(0) == pytest.approx(30 * 21 * 12)
    assert len(picture(block, 500)[1]) <= 500 < len(surface(block)[1])
    assert sparser(block, 1) is block


def test_slot_and_cross_hole_by_hand() -> None:
    """Slot along x, 10 wide, 4 deep, and a bore D 10 along x through the block by a tool that lies along x.

    Rays along y at z = 8 end at the slot's walls 5 and 15 exactly; at z = 3.25 (0.25 above the axis of the bore at
    z = 3) on its circle of radius 2: y = 10 -+ sqrt(4 - 0.0625) = 10 -+ 1.984313.
    """
    slot = lines([[-10, 10, 6]], [[40, 10, 6]], (flat(5.0), flat(2.0)))
    bore = lines([[40, 10, 3]], [[-5, 10, 3]], (flat(5.0), flat(2.0)), tool=1, axis=[1.0, 0, 0])
    left = carve([0, 0, 0], [30, 20, 10], 0.5, join([slot, bore]))
    high, low = left.ends[1][30, 16], left.ends[1][30, 6]  # z = 8.25 and 3.25
    assert high[:2] == pytest.approx(np.array([[0.0, 5.0], [15.0, 20.0]]), abs=1e-12)
    assert low[:2] == pytest.approx(np.array([[0.0, 10 - 1.9843134833], [11.9843134833, 20.0]]), abs=1e-9)
    want = 6000 - 30 * 10 * 4 - 30 * np.pi * 4
    assert [left.volume(d) for d in range(3)] == pytest.approx([want] * 3, rel=0.01)
    import trimesh

    mesh = trimesh.Trimesh(*surface(left), process=False)
    assert mesh.is_watertight
    assert mesh.euler_number == 0  # one tunnel
    assert mesh.volume == pytest.approx(want, rel=0.02)


def test_ring_groove_of_an_arc() -> None:
    """Circle of radius 8 with a tool of R 2, 3 deep: pi (10^2 - 6^2) 3 = 603.19 mm3; a ray through the centre meets it twice."""
    ring = arcs([[18, 10, 7]], [[18, 10, 7]], [[10, 10, 7]], 2 * np.pi, (flat(2.0),))
    left = carve([-5, -5, 0], [25, 25, 10], 0.5, ring)
    assert 9000 - left.volume(0) == pytest.approx(603.19, rel=0.02)
    ends = left.ends[0][30, 16]  # y = 10.25, z = 8.25: circles 10 and 6 at x = 15 -+ sqrt(r^2 - 0.0625)
    outer, inner = (100 - 0.0625) ** 0.5, (36 - 0.0625) ** 0.5
    assert ends[:3].ravel() == pytest.approx(
        [0, 15 - outer, 15 - inner, 15 + inner, 15 + outer, 30], abs=1e-6
    )


def test_what_two_carvings_share_is_what_both_tools_leave():
    # a block of 10 mm with a slot along x 4 deep and 4 wide at y = 3 and one at y = 7 by another tool: carved one by one and together
    low, high = np.zeros(3), np.full(3, 10.0)
    first = lines([[-5, 3, 6]], [[15, 3, 6]], (flat(2.0),))
    second = lines([[-5, 7, 6]], [[15, 7, 6]], (flat(2.0),))
    shared = both(carve(low, high, 0.5, first), carve(low, high, 0.5, second))
    whole = carve(low, high, 0.5, join([first, second]))
    assert shared.volume(2) == pytest.approx(1000 - 2 * 4 * 4 * 10)
    for one, other in zip(shared.ends, whole.ends, strict=True):
        assert np.array_equal(one, other, equal_nan=True)
