"""The chord sag of a coarse nominal mesh is told by vcmm evaluate where it is not small."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh

from tests.answer.inference.test_nominal_points import MACHINE, SCENARIO, STEP, STEPS, write
from vcmm.face.cli import run

R = 500.0


def arc(angle: np.ndarray, y: float) -> np.ndarray:
    """Points (n, 3) of a cylinder along y, its top 30 mm above the zero."""
    return np.stack([R * np.sin(angle), np.full_like(angle, y), 30 - R + R * np.cos(angle)], axis=1)


def files(folder: Path, strips: int) -> Path:
    """A scenario whose blade is a mesh of so many strips over 54 mrad, and points of the true cylinder in the middle of strips."""
    angle = np.linspace(-0.027, 0.027, strips + 1)
    corners, i = np.concatenate([arc(angle, -20.0), arc(angle, 20.0)]), np.arange(strips)
    j, k, m = i + 1, i + strips + 1, i + strips + 2
    trimesh.Trimesh(corners, np.concatenate([np.stack([i, j, m], 1), np.stack([i, m, k], 1)])).export(
        folder / "blade.stl"
    )
    middle = (angle[1:] + angle[:-1])[:: strips // 6] / 2
    true = np.concatenate([arc(middle, y) for y in (-15.0, 1.0, 15.0)])
    sag = R * (1 - np.cos(0.027 / strips))
    flat = true - sag * (true - [0, 0, 30 - R]) * [1, 0, 1] / R
    flat[:, 1] = true[:, 1]
    write(folder / "plan.csv", "x_mm,y_mm,z_mm", flat)
    write(folder / "measured.csv", "feature,x_mm,y_mm,z_mm", true, "blade,")
    with (folder / "measured.csv").open("a") as more:
        for u in (-1, 1):
            for v in (-1, 1):
                more.write(
                    f"below,{30 * u},{20 * v},0\nleft,-40,{20 * u},{15 + 8 * v}\nfront,{30 * u},-30,{15 + 8 * v}\n"
                )
    (folder / "machine.toml").write_text(MACHINE)
    text = SCENARIO.replace('type = "points", nominal = "nominal.csv"', 'type = "mesh"')
    text = text.replace("[part.features]", '[part]\nmesh = "blade.stl"\n[part.features]', 1)
    steps = "".join(STEP.format(*step) for step in STEPS.items())
    (folder / "s.toml").write_text(text + steps.replace('{ strategy = "nominal" }', '"plan.csv"'))
    return folder / "s.toml"


def evaluated(folder: Path, strips: int, capsys: pytest.CaptureFixture[str]) -> tuple[float, list[str]]:
    argv = [
        "evaluate",
        str(files(folder, strips)),
        "--points",
        str(folder / "measured.csv"),
        "--json",
        "--trials",
        "2000",
    ]
    assert run(argv) == 0
    found = json.loads(capsys.readouterr().out)
    return found["characteristics"][0]["value_mm"], [
        w for w in found["warning_texts"] if "mesh is coarse" in w
    ]


@pytest.mark.thorough
def test_a_coarse_mesh_is_told_and_a_fine_one_is_not(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # 12 strips of 4.5 mrad: R (1 - cos 2.25 mrad) = 500 x 2.53125e-6 = 1.2656 um, c t / 8 = 2.25 x 4.5e-3 / 8 mm the same; twice 2.53 um
    value, told = evaluated(tmp_path, 12, capsys)
    assert value == pytest.approx(2.53e-3, abs=0.01e-3)  # a perfect cylinder has this profile
    assert "up to 1.27 um off its facets" in told[0]
    assert "adds up to 2.53 um to the surface_profile" in told[0]
    # 120 strips: a hundredth of it
    value, told = evaluated(tmp_path, 120, capsys)
    assert value == pytest.approx(0.0253e-3, abs=0.01e-3)
    assert told == []
