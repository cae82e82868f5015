"""Slices and hull of a machine's volume: places and values by hand, and colours that are those of the bar."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.hostile.bench_corpus import OURS
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.face.cli import run
from vcmm.files.own.machine import load_machine
from vcmm.show.pages.volume import NODES, volume_hull, volume_slices
from vcmm.show.report.blocks import SceneMesh

# +10 um per metre in X alone: at X = 600 mm the tip is 6 um too far, at 300 mm 3 um
STRETCHED = OURS + '[[effects]]\neffect = "scale_factor"\naxis = "X"\nk = "10 um/m"\n'


@pytest.fixture
def machine(tmp_path: Path) -> Machine:
    (tmp_path / "m.toml").write_text(STRETCHED)
    return load_machine(tmp_path / "m.toml")


def mesh_of(items: list[object]) -> SceneMesh:
    (mesh,) = [i for i in items if isinstance(i, SceneMesh)]
    return mesh


def test_slices_hold_the_error_at_their_places(machine: Machine) -> None:
    mesh = mesh_of(list(volume_slices(machine)))
    places, values = np.asarray(mesh.vertices), np.asarray(mesh.values)
    assert len(places) == 3 * NODES**2
    middles = places[np.asarray(mesh.faces)][..., 0]
    middles = (middles.min(axis=1) + middles.max(axis=1)) / 2  # of the square that a triangle is half of
    assert values == pytest.approx(np.abs(middles) * 10e-3, abs=1e-9)  # um
    assert (places[: NODES**2, 0] == 300.0).all()
    assert len(np.asarray(mesh.faces)) == 3 * 2 * (NODES - 1) ** 2


def test_the_hull_is_bent_by_what_its_name_says(machine: Machine) -> None:
    mesh = mesh_of(list(volume_hull(machine)))
    # 12 % of 600 mm over 6 um is 12 000; the next lower of 1, 2, 5 is 10 000: 60 mm at the far end
    assert mesh.name == "bent, 10,000 ×"
    places = np.asarray(mesh.vertices)
    assert abs(abs(places[:, 0]).max() - 660.0) < 1e-6 or abs(abs(places[:, 0]).max() - 540.0) < 1e-6
    assert np.asarray(mesh.values).max() == pytest.approx(6.0)  # the side at 600 mm


def test_a_machine_without_errors_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "m.toml").write_text(OURS)
    with pytest.raises(UsageError, match="no error of it is known"):
        volume_slices(load_machine(tmp_path / "m.toml"))


def test_words_that_belong_to_the_other_file_are_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "m.toml").write_text(STRETCHED)
    assert run(["view", str(tmp_path / "m.toml"), "--close", "--png", str(tmp_path / "x.png")]) == 2
    assert "--close is for the part" in capsys.readouterr().err


@pytest.mark.thorough
def test_colours_of_the_picture_are_those_of_the_bar(tmp_path: Path) -> None:
    """No light falls on colours that mean numbers: nearly all coloured pixels are one of the bands, however a plane is turned."""
    pytest.importorskip("pyvista", reason="pyvista is missing: pip install vcmm[view]")
    image = pytest.importorskip("PIL.Image")
    from vcmm.show.report.colormap import bands

    (tmp_path / "m.toml").write_text(STRETCHED)
    assert run(["view", str(tmp_path / "m.toml"), "--look", "slices", "--png", str(tmp_path / "x.png")]) == 0
    pixels = np.asarray(image.open(tmp_path / "x.png").convert("RGB")).reshape(-1, 3).astype(int)
    coloured = pixels[np.ptp(pixels, axis=1) > 60]
    known = np.array(
        [
            [int(c[i : i + 2], 16) for i in (1, 3, 5)]
            for c in bands(np.linspace(0.0, 6.0, 50), symmetric=False).colours
        ]
    )
    far = np.abs(coloured[:, None] - known).max(axis=2).min(axis=1)
    assert (far <= 3).mean() > 0.9
