"""The stock as a closed mesh."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.shop.cutting.solid import triangles, write_stl
from vcmm.shop.cutting.stock import block, remove
from vcmm.shop.cutting.sweeps import lines
from vcmm.shop.cutting.tools import ball


def test_mesh_is_closed(tmp_path: Path) -> None:
    """Volume of the mesh of an uncut block between its outer nodes: (60 - 1) x (40 - 1) x 20 for cells of 1 mm."""
    import trimesh

    whole = block([0, 0, 0], [60, 40, 20], 1.0)
    vertices, faces = triangles(whole)
    mesh = trimesh.Trimesh(vertices, faces, process=False)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(59 * 39 * 20)
    cut = remove(whole, lines([[-10, 20, -1]], [[70, 20, 18]], (ball(5.0),))).stock
    write_stl(cut, tmp_path / "stock.stl")
    again = trimesh.load(tmp_path / "stock.stl")
    assert again.is_watertight
    assert again.volume < 59 * 39 * 20
