"""What a drawing asks for in vain, from the file and from the user's chair."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.plate import edited
from vcmm.face.cli import run
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.part.gps.contradictions import always_kept, free_words, left_free
from vcmm.part.part import Characteristic

MORE = "[pose]\n"


def told(
    capsys: pytest.CaptureFixture[str], folder: Path, table: str, verb: str = "check"
) -> tuple[int, str]:
    """Exit code and all that is said of the plate with one more characteristic."""
    code = run([verb, str(edited(folder, (MORE, f"[[part.characteristics]]\n{table}\n{MORE}"))), "--json"])
    out, err = capsys.readouterr()
    return code, out + err


def test_limits_that_no_part_keeps(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """30 mm from 30.000 to 30.021 and from 30.030 to 30.040: nothing is both; from 30.020 on there is."""
    second = 'name = "again"\ntype = "size"\nof = "bore"\nlimits = ["{} mm", "0.040 mm"]'
    code, said = told(capsys, tmp_path, second.format("0.030"))
    assert code == 2
    assert '"again" and "bore diameter" are limits of the same thing, and no part keeps both' in said
    assert told(capsys, tmp_path, second.format("0.020"))[0] == 0
    other = second.format("0.030").replace('of = "bore"', 'of = "bore"\ncriterion = "GN"')
    assert told(capsys, tmp_path, other)[0] == 0  # another size of the same bore


def test_no_size_is_below_zero(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    code, said = told(
        capsys, tmp_path, 'name = "n"\ntype = "size"\nof = "bore"\nlimits = ["-40 mm", "0.02 mm"]'
    )
    assert code == 2
    assert "a size of -10 mm, and no size is below zero" in said


def test_a_zone_that_asks_for_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Square to the top within 0.01 mm, but in place within 0.005 mm; and flat within more than parallel."""
    place = 'name = "place"\ntype = "position"\nof = "bore"\ndatums = ["top", "front"]\nzone = "{} mm"'
    assert '"bore square to top" (0.01 mm) asks for nothing' in told(capsys, tmp_path, place.format(0.005))[
        1
    ].replace('\\"', '"')
    assert "asks for nothing" not in told(capsys, tmp_path, place.format(0.02))[1]


def test_datums_that_leave_a_feature_free(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A bore along z: the top holds z and two turns; what moves the bore is then x and y, with the front x alone."""
    place = 'name = "place"\ntype = "position"\nof = "bore"\n{}zone = "0.05 mm"'
    for datums, free in (
        ('datums = ["top"]\n', "shift along x, shift along y"),
        ('datums = ["top", "front"]\n', "shift along x)"),
    ):
        code, said = told(capsys, tmp_path, place.format(datums))
        assert code == 0
        assert f"leave bore free to move ({free}" in said
        assert "its zone moves with it there (ISO 5459), and its value is the smallest so" in said
    said = told(capsys, tmp_path, place.format(""))[1]
    assert "without datums bore is free to move" in said
    assert "follows the alignment of the plan" in said
    features = load_scenario(example("plate")).part.features
    both = Characteristic("p", "position", of=("bore",), datums=("top", "front"), zone=0.05)
    assert left_free(both, features) == pytest.approx(
        np.array([[1.0, 0, 0, 0, 0, 0]]) * np.sign(left_free(both, features)[0, 0])
    )
    assert free_words(left_free(both, features)) == "shift along x"
    assert not always_kept(both, features)
    rim = features | {"bore": replace(features["bore"], kind="circle", extent=())}  # no axis that could lean
    assert always_kept(replace(both, datums=("top",)), rim)
    assert not always_kept(replace(both, datums=("top", "front")), rim)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('part = "21.2 degC"', 'part = "90 degC"', "the temperature part = 90 degC is not that of a measuring room"),
        ('expansion = "11.5 um/(m K)"', 'expansion = "11500 um/(m K)"', "the part expands by 11500 um/(m K)"),
        ('strategy = "levels", at = ["5 mm", "15 mm"], n = 8', 'strategy = "levels", at = ["5 mm", "15 mm"], n = 8, sweep = "60 deg"', "bore: touched over "),
    ],
)  # fmt: skip
def test_what_may_be_a_slip(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    assert run(["check", str(edited(tmp_path, (old, new))), "--json"]) == 0
    assert message in capsys.readouterr().out


def test_planned_points_beside_their_feature(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A face that ends at x = 40 mm: 60 mm lies 20 mm beyond, 40.4 mm is a broken edge."""
    rows = [
        "x_mm,y_mm,z_mm,nx,ny,nz",
        *(f"{x},-40,{z},0,-1,0" for x, z in ((60, 10), (-30, 10), (40.4, 15), (30, 5))),
    ]
    (tmp_path / "front.csv").write_text("\n".join(rows))
    scenario = edited(
        tmp_path, ('points = { strategy = "grid", n = [3, 2], margin = "4 mm" }', 'points = "front.csv"')
    )
    assert run(["check", str(scenario), "--json"]) == 0
    assert "front: 1 planned point(s) lie up to 20 mm beyond the feature" in capsys.readouterr().out


def test_points_that_determine_nothing_are_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["check", str(edited(tmp_path, ('at = ["5 mm", "15 mm"]', 'at = ["5 mm"]')))]) == 2
    said = capsys.readouterr().err
    assert 'points of "bore": cylinder: the points do not determine the tilt' in said
    assert "fits)" not in said
