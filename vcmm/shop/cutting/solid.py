"""The stock as a closed triangle mesh, for pictures and STL files: from a map of heights, or from rays along X, Y and Z."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.laws import Array
from vcmm.shop.cutting.dexels import Dexels, sparser, surface
from vcmm.shop.cutting.stock import Stock


def triangles(stock: Stock | Dexels) -> tuple[Array, Array]:
    """Return the vertices (v, 3) mm and triangles (f, 3), watertight, outward."""
    return surface(stock) if isinstance(stock, Dexels) else _of_heights(stock)


def picture(stock: Stock | Dexels, most: int) -> tuple[Array, Array]:
    """Return the mesh with at most so many triangles: only every second, third ... node or ray."""
    if isinstance(stock, Dexels):
        every = 1
        while len((mesh := surface(sparser(stock, every)))[1]) > most:
            every += 2
        return mesh
    nx, ny = stock.height.shape
    every = thinning(nx, ny, most)
    return _of_heights(replace(stock, height=stock.height[::every, ::every], cell=stock.cell * every))


def thinning(nx: int, ny: int, most: int) -> int:
    """Return the step of the nodes of a map of heights to be drawn, so that top and bottom (2 triangles per cell each) and sides fit."""
    every = max(1, int(np.sqrt(4.0 * nx * ny / most)))
    while 4 * (-(-nx // every)) * (-(-ny // every)) > most:
        every += 1
    return every


def _of_heights(stock: Stock) -> tuple[Array, Array]:
    """Return the nodes as top, the underside, four walls.

    Where a node is cut down to the underside, a skin of a thousandth of the cell remains, so that the mesh stays closed.
    """
    nx, ny = stock.height.shape
    if nx < 2 or ny < 2:
        raise UsageError(
            "triangles: the stock needs at least two nodes along x and along y; choose a smaller cell"
        )
    x, y = stock.x0 + stock.cell * np.arange(nx), stock.y0 + stock.cell * np.arange(ny)
    gx, gy = np.meshgrid(x, y, indexing="ij")
    top = np.maximum(stock.height, stock.bottom + 1e-3 * stock.cell)
    number = np.arange(nx * ny).reshape(nx, ny)
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[1:, 1:], number[:-1, 1:]
    upper = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    lower = upper[:, ::-1] + nx * ny
    rim = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    after = np.roll(rim, -1)
    walls = np.concatenate(
        [np.stack([rim, rim + nx * ny, after + nx * ny], -1), np.stack([rim, after + nx * ny, after], -1)]
    )
    vertices = np.concatenate(
        [
            np.stack([gx, gy, top], -1).reshape(-1, 3),
            np.stack([gx, gy, np.full_like(gx, stock.bottom)], -1).reshape(-1, 3),
        ]
    )
    return vertices, np.concatenate([upper, lower, walls])


def write_stl(stock: Stock | Dexels, path: str | Path) -> None:
    """Write a binary STL of the stock, mm."""
    import trimesh

    vertices, faces = triangles(stock)
    trimesh.Trimesh(vertices, faces, process=False).export(str(path), file_type="stl")
