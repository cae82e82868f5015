"""What a claim by points does not hold for: scratches between the points, and noise with a memory too long for them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.answer.inference import outside
from vcmm.answer.evaluation.not_covered import beyond_touches, spacing
from vcmm.face.cli import run
from vcmm.part.part import Feature


def document(capsys: pytest.CaptureFixture[str], folder: Path, n: int) -> tuple[dict, str]:
    """Of n points round a ring of 30 mm: the document, and what the terminal says."""
    scenario, points = folder / "s.toml", folder / "p.csv"
    scenario.write_text(outside.scenario(form=True))
    points.write_text(outside.csv(outside.rows(outside.bore(np.random.default_rng(3), n))))
    words = ["evaluate", str(scenario), "--points", str(points)]
    run([*words, "--json"])
    found = json.loads(capsys.readouterr().out)
    run([*words, "--out", str(folder / "out")])
    shown = capsys.readouterr()
    said = {c["name"]: c["true_value"]["not_covered"] for c in found["characteristics"]}
    return said, shown.out + shown.err


@pytest.mark.thorough
def test_thirty_six_points_say_what_they_do_not_see(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Chord of 10 deg on a radius of 15 mm: 2 x 15 x sin 5 deg = 2.615 mm. An outside count noticed memory of 0.95 in 2 of 60 parts."""
    found, said = document(capsys, tmp_path, 36)
    narrow, memory = found["form"]
    assert narrow == "defects narrower than the spacing of the points (2.6 mm on ring) that no point touches"
    assert memory.startswith(
        "noise that goes on from touch to touch (correlation 0.95 of neighbours): 36 points are too few"
    )
    assert (
        float(memory.split(" would in ")[1].split("%")[0]) <= 15
    )  # 2 of 60, and three standard deviations of a binomial
    assert found["diameter"] == [memory]  # a scratch hardly moves a least-squares circle
    assert "form: not covered: defects narrower" in " ".join(said.split())
    for page in ("sheet.html", "report.html"):
        assert "2.6 mm on ring" in (tmp_path / "out" / page).read_text(encoding="utf-8")


@pytest.mark.thorough
def test_eight_points_are_not_tested_for_memory(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    found, _ = document(capsys, tmp_path, 8)
    assert "no feature has the 12 points" in found["form"][-1]


def test_values_alone_show_no_memory(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario, values = tmp_path / "s.toml", tmp_path / "v.csv"
    scenario.write_text(outside.scenario(form=True))
    values.write_text("characteristic,value_mm\nform,0.002\ndiameter,30.0\n")
    run(["evaluate", str(scenario), "--values", str(values), "--json"])
    form, size = json.loads(capsys.readouterr().out)["characteristics"]
    if form["name"] != "form":
        form, size = size, form
    assert form["true_value"]["not_covered"][-1].startswith(
        "noise that goes on from touch to touch: values alone"
    )
    assert size["true_value"] is None


def test_spacing_is_that_of_the_loneliest_point() -> None:
    """At 0, 1 and 4 mm, the first touched twice: the last is 3 mm from its neighbour."""
    assert spacing(np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0], [4, 0, 0]])) == pytest.approx(3.0)
    assert spacing(np.zeros((2, 3))) == 0.0


EDGE = Feature(
    "edge",
    "line",
    np.array([-40.0, 0, 0]),
    np.array([1.0, 0, 0]),
    np.zeros(0),
    extent=(80.0,),
    u=np.array([0.0, 0, 1]),
)


def test_what_a_surface_does_beyond_the_outermost_points() -> None:
    """A line of 80 mm, touched from 4 to 76 mm: u = -0.9 to 0.9, and 0.9^3 = 0.729 of a cubic. An outside count: of 400 lines bent as u^3
    355 were held. By hand: what a line leaves of u^3 on -0.9 to 0.9 has 2 (0.9^3 - 0.6 0.9^3) = 0.5832 of range, on -1 to 1 it is 0.8.
    """
    places = np.linspace(-36, 36, 15)
    points = np.stack([places, 0 * places, 0 * places], 1)
    left, shown = beyond_touches(EDGE, points)
    assert left == pytest.approx(4.0)
    assert shown == pytest.approx(0.5832 / 0.8, rel=1e-12)
    assert beyond_touches(EDGE, points / 0.9) == pytest.approx((0.0, 1.0))
    one_side = np.concatenate([points / 0.9])[:-2]  # the last of 15 points 5.7 mm apart is at 28.57 mm
    assert beyond_touches(EDGE, one_side)[0] == pytest.approx(80 / 14 * 2)
