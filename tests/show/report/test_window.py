"""Windows of pyvista: a picture without a display, or the sentence that says what is missing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.show.report.test_scene import everything
from vcmm.core.errors import Environment
from vcmm.face.cli import run
from vcmm.show.report.scene_items import Label, Lines
from vcmm.show.report.window import keys_of, show


@pytest.mark.thorough
def test_a_picture_holds_every_kind_of_item(tmp_path: Path) -> None:
    target = tmp_path / "scene.png"
    try:
        show(everything(), "t", target)
    except Environment:  # what is said then: see below
        pytest.skip("no off-screen OpenGL here")
    from matplotlib.image import imread

    picture = imread(target)
    assert picture.shape[:2] == (800, 1100)
    assert (
        len(np.unique((255 * picture[..., :3]).astype(int).reshape(-1, 3), axis=0)) > 20
    )  # something is drawn


def test_without_a_display_a_window_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr("sys.platform", "linux")
    with pytest.raises(Environment, match=r"--png picture\.png"):
        show(everything(), "t")


@pytest.mark.thorough
def test_a_child_that_fails_is_said(tmp_path: Path) -> None:
    with pytest.raises(Environment, match=r"does not work here \(.*\); install libegl1"):
        show(everything(), "t", tmp_path / "no" / "such" / "folder.png")


def test_only_machines_and_measurements_are_viewed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "part.toml").write_text('vcmm = "part/1"\n')
    assert run(["view", str(tmp_path / "part.toml"), "--png", str(tmp_path / "a.png")]) == 2
    assert "a scenario/1 or machine/1 is shown" in capsys.readouterr().err
    assert run(["view", str(tmp_path / "part.toml"), "--png", str(tmp_path / "a.jpg")]) == 2
    assert "name it picture.png" in capsys.readouterr().err


def test_keys_are_names_and_colours_each_once() -> None:
    line = np.zeros((2, 3))
    items = [
        Lines(line, "accent", name="touches"),
        Lines(line, "accent", name="touches"),
        Lines(line),
        Label([0, 0, 0], "no key"),
    ]
    assert keys_of(items) == [["touches", "#2a63a5"]]  # of the light palette
