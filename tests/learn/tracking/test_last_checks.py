"""Which readings of a ball bar belong to which circle."""

import numpy as np

from vcmm.files.learned.last_checks import PLANES, _planes_of


def test_a_reading_along_an_axis_belongs_to_the_circle_that_was_run():
    """Three circles of eight readings, XY YZ ZX, each from its first axis on: the eighth of 24 is no longer XY, though +Y, where YZ begins, lies in both."""
    angles = np.radians(np.arange(0, 360, 45))
    way = np.zeros((3, 8, 3))
    for k, (i, j) in enumerate(PLANES.values()):
        way[k, :, i], way[k, :, j] = np.cos(angles), np.sin(angles)
    assert _planes_of(way.reshape(-1, 3)).tolist() == [0] * 8 + [1] * 8 + [2] * 8


def test_a_circle_that_ends_where_it_began_keeps_its_last_reading():
    """XY from +X to +X again, then YZ from +Y: the last +X lies in XY and ZX, and YZ, which comes next, does not hold it."""
    closed, angles = np.radians(np.arange(0, 361, 45)), np.radians(np.arange(0, 360, 45))
    xy = np.stack([np.cos(closed), np.sin(closed), 0 * closed], axis=1)
    yz = np.stack([0 * angles, np.cos(angles), np.sin(angles)], axis=1)
    assert _planes_of(np.concatenate([xy, yz])).tolist() == [0] * 9 + [1] * 8


def test_a_space_diagonal_is_of_no_circle():
    assert _planes_of(np.full((1, 3), 3**-0.5)).tolist() == [-1]
