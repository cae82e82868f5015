"""STEP shapes, read by Open CASCADE: a generated part of fifty features, and a public test part with its tolerances."""

from __future__ import annotations

import os
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.conftest import data_file
from vcmm.face.cli import run
from vcmm.files.foreign.step import read_step
from vcmm.files.foreign.step_faces import _spread

pytest.importorskip("OCP", reason='Open CASCADE is missing: pip install "vcmm[step]"')
pytestmark = pytest.mark.thorough
HOLES = [
    (20.0 + 30.0 * i, 20.0 + 30.0 * j, 2.0 + 0.1 * i + 0.5 * j) for i in range(8) for j in range(5)
]  # x, y, radius


def written(shape: Any, path: Path) -> Path:
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    writer = STEPControl_Writer()
    writer.Transfer(shape, STEPControl_StepModelType.STEPControl_AsIs)
    assert writer.Write(str(path)) == IFSelect_ReturnStatus.IFSelect_RetDone
    return path


def at(x: float, y: float, z: float, direction: tuple[float, float, float] = (0.0, 0.0, 1.0)) -> Any:
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    return gp_Ax2(gp_Pnt(x, y, z), gp_Dir(*direction))


@pytest.fixture(scope="module")
def block(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """240 x 160 x 40 with 40 bores, a countersink, half a ball's seat, a ring groove and a boss on a side: 53 features."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut, BRepAlgoAPI_Fuse
    from OCP.BRepPrimAPI import (
        BRepPrimAPI_MakeBox,
        BRepPrimAPI_MakeCone,
        BRepPrimAPI_MakeCylinder,
        BRepPrimAPI_MakeSphere,
        BRepPrimAPI_MakeTorus,
    )  # fmt: skip

    shape = BRepPrimAPI_MakeBox(250.0, 160.0, 40.0).Shape()
    tools = [BRepPrimAPI_MakeCylinder(at(x, y, -1.0), r, 42.0).Shape() for x, y, r in HOLES]
    tools.append(BRepPrimAPI_MakeCone(at(35.0, 35.0, 30.0), 3.0, 8.0, 10.0).Shape())
    tools.append(BRepPrimAPI_MakeSphere(at(65.0, 35.0, 40.0), 6.0).Shape())
    tools.append(BRepPrimAPI_MakeTorus(at(125.0, 95.0, 40.0), 10.0, 2.0).Shape())
    for tool in tools:
        shape = BRepAlgoAPI_Cut(shape, tool).Shape()
    boss = BRepPrimAPI_MakeCylinder(at(249.0, 80.0, 20.0, (1.0, 0.0, 0.0)), 12.0, 16.0).Shape()
    return written(BRepAlgoAPI_Fuse(shape, boss).Shape(), tmp_path_factory.mktemp("step") / "block.step")


def test_every_surface_is_a_feature_in_its_place(block: Path) -> None:
    features = read_step(block).features
    bores = [f for f in features.values() if f["type"] == "cylinder" and f.get("inside")]
    found = sorted((*map(float, f["point"].split()[:2]), float(f["diameter"].split()[0]) / 2) for f in bores)
    assert np.allclose(found, sorted(HOLES), atol=1e-9)
    assert {f["length"] for f in bores} == {"40 mm"}
    kinds = [f["type"] for f in features.values()]
    assert {k: kinds.count(k) for k in set(kinds)} == {
        "plane": 9,
        "cylinder": 41,
        "cone": 1,
        "sphere": 1,
        "torus": 1,
    }
    one = {f["type"]: f for f in features.values()}
    assert one["sphere"] == {"type": "sphere", "point": "65 35 40 mm", "diameter": "12 mm", "inside": True}
    assert one["torus"] | {"axis": 0} == {
        "type": "torus",
        "point": "125 95 40 mm",
        "axis": 0,
        "diameter": "20 mm",
        "tube": "4 mm",
        "inside": True,
    }
    cone = one["cone"]  # from 3 mm to 8 mm radius over 10 mm: half angle atan(0.5), opening upwards
    assert (cone["point"], cone["axis"], cone["diameter"], cone["length"], cone["inside"]) == (
        "35 35 30 mm",
        [0.0, 0.0, 1.0],
        "6 mm",
        "10 mm",
        True,
    )
    assert float(cone["angle"].split()[0]) == pytest.approx(2 * np.degrees(np.arctan(0.5)), abs=1e-9)
    shaft = features["shaft_1"]
    assert (shaft["diameter"], shaft["length"]) == ("24 mm", "15 mm")


def test_planes_look_out_and_are_touched_where_they_are(block: Path) -> None:
    drawn = read_step(block)
    (top,) = (
        n
        for n, f in drawn.features.items()
        if f.get("size") in ("250 160 mm", "160 250 mm") and f["normal"][2] > 0
    )
    touches = drawn.targets[top]
    assert touches.shape == (9, 6)
    assert np.allclose(touches[:, 2:], [40.0, 0.0, 0.0, 1.0])
    for x, y, r in HOLES:
        assert np.hypot(touches[:, 0] - x, touches[:, 1] - y).min() > r
    normals = {tuple(f["normal"]) for f in drawn.features.values() if f["type"] == "plane"}
    assert normals == {(0, 0, 1), (0, 0, -1), (1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)}


def test_fifty_features_become_a_checked_scenario_within_30_seconds(block: Path, tmp_path: Path) -> None:
    began = sum(
        os.times()[:4]
    )  # of this process and of its children, as other work on the machine is none of ours
    assert run(["convert", str(block), "--out", str(tmp_path / "made")]) == 0
    assert run(["check", str(tmp_path / "made/scenario.toml")]) == 0
    assert sum(os.times()[:4]) - began < 30.0
    part = tomllib.loads((tmp_path / "made/part.toml").read_text())
    assert len(part["features"]) == 53
    assert len(part["characteristics"]) == 41 + 1 + 9


def test_a_public_part_with_tolerances(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """NIST CTC-01: seven diameters, an angle, two squareness and form tolerances, profiles with datums A, B, C; the rest is said."""
    assert (
        run(
            [
                "convert",
                str(data_file("data/formats/nist_ctc_01_asme1_ap242-e1.stp")),
                "--out",
                str(tmp_path / "ctc"),
            ]
        )
        == 0
    )
    part = tomllib.loads((tmp_path / "ctc/part.toml").read_text())
    found = {c["name"]: c for c in part["characteristics"]}
    assert sorted(c["limits"][0] + c["limits"][1] for c in found.values() if c["type"] == "size") == [
        "-0.05 mm0.1 mm", "-0.1 mm0.05 mm", "-0.15 mm0.15 mm", "-0.2 mm0 mm", "-0.2 mm0.2 mm", "-0.2 mm0.2 mm", "0 mm0.2 mm",
    ]  # fmt: skip
    diameters = [part["features"][c["of"]]["diameter"] for c in found.values() if c["type"] == "size"]
    assert sorted(diameters) == ["20 mm", "20 mm", "25 mm", "35 mm", "35 mm", "35 mm", "35 mm"]
    flat, square = found["Flatness.1"], found["Perpendicularity.1"]
    assert (flat["zone"], square["zone"], square["datums"]) == ("0.2 mm", "1.5 mm", [flat["of"]])
    assert len(found["Position surfacic profile.3"]["datums"]) == 3
    said = capsys.readouterr().err
    assert "Position.1" in said
    assert "4 dimensions without limits" in said


def test_places_on_a_plane_with_a_bore_keep_a_tenth_of_the_narrow_side() -> None:
    """u from 100 to 110, v from 0 to 40, a bore in the middle: a tenth of 10 is 1 mm, so places lie between u 101 and 109; the finest grid goes by
    10 / 20 = 0.5 mm along u and 2 mm along v, so the outer ones lie on u = 101 and 109, v = 2 and 38.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.gp import gp_Circ, gp_Dir, gp_Pln, gp_Pnt

    reach = (100.0, 110.0, 0.0, 40.0)
    plate = BRepBuilderAPI_MakeFace(gp_Pln(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(0.0, 0.0, 1.0)), *reach)
    assert _spread(plate.Face(), reach) is None
    circle = gp_Circ(at(105.0, 20.0, 0.0, (0.0, 0.0, -1.0)), 2.0)
    edge = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire()
    places = _spread(BRepBuilderAPI_MakeFace(plate.Face(), edge).Face(), reach)
    assert places is not None
    assert [*places.min(axis=0), *places.max(axis=0)] == pytest.approx([101.0, 2.0, 109.0, 38.0], abs=1e-9)
    assert np.hypot(*(places - [105.0, 20.0]).T).min() > 2.0
