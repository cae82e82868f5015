"""What a QIF file leaves open: the criterion of its forms, names, characteristics without points; and what its own axes say."""

from __future__ import annotations

import tomllib
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import data_file
from tests.files.foreign.test_qif import SAMPLE
from vcmm.answer.inference.points import task_and_rows
from vcmm.files.foreign.convert import convert
from vcmm.files.foreign.qif_part import read_qif_part
from vcmm.files.foreign.qif_points import read_qif_points
from vcmm.files.own.scenario import load_scenario


def test_the_files_own_values_decide_the_criterion() -> None:
    """RND: 0.023337199995 and 0.081326375416 mm stand in the file, minimum zones of its 219 points."""
    drawn = read_qif_part(data_file(SAMPLE))
    criteria = {c["name"]: c.get("criterion") for c in drawn.characteristics}
    assert (criteria["RND_CIRCLE1"], criteria["RND_2"], criteria["FLATA"]) == ("C", "C", None)
    said = "\n".join(drawn.notes)
    assert (
        "RND_CIRCLE1: criterion C (minimum zone) is taken: of the file's own points G gives 0.025203 mm, C 0.0233372 mm"
        in said
    )
    assert (
        "FLATA: the file names no criterion; G (least squares) is assumed: of the file's own points" in said
    )


@pytest.mark.parametrize(
    ("stated", "taken", "says"),
    [("0.025203", None, "G (least squares), as its value says"), ("0.05", None, "is assumed: of")],
)
def test_another_value_decides_otherwise(tmp_path: Path, stated: str, taken: str | None, says: str) -> None:
    text = Path(data_file(SAMPLE)).read_text(encoding="utf-8")
    assert text.count("<Value>0.023337199995</Value>") == 1
    path = tmp_path / "other.qif"
    path.write_text(text.replace("0.023337199995", stated), encoding="utf-8")
    drawn = read_qif_part(path)
    assert next(c for c in drawn.characteristics if c["name"] == "RND_CIRCLE1").get("criterion") is taken
    assert any("RND_CIRCLE1: " in n and says in n for n in drawn.notes)


def test_what_convert_writes_can_be_evaluated(tmp_path: Path) -> None:
    """CPLANE was constructed of points and has none of its own: its angle stands as a comment, which is whole TOML without the #."""
    path = data_file(SAMPLE)
    made = convert(path)
    part = made.texts["part.toml"]
    assert any(n.startswith("ANGLE_CPLANE: CPLANE has no measured points; left out") for n in made.notes)
    head, commented = part.split("# CPLANE has no measured points:\n")
    again = tomllib.loads(head + "\n".join(line.removeprefix("# ") for line in commented.splitlines()))
    assert again["characteristics"][-1]["name"] == "ANGLE_CPLANE"
    assert "ANGLE_CPLANE" not in [c["name"] for c in tomllib.loads(part)["characteristics"]]
    for name, text in made.texts.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    task = task_and_rows(
        load_scenario(tmp_path / "scenario.toml"), read_qif_points(path).parts[0], tip_centres=True
    )[0]
    assert "PERP1" in [c.name for c in task.part.characteristics]


def test_without_points_nothing_is_left_out_and_a_name_that_is_none_is_told() -> None:
    drawn = read_qif_part(data_file("data/formats/simplePlan.QIF"))
    assert any(n.endswith('the file calls a size "-NONE-"; give it a name') for n in drawn.notes)
    assert "# [[characteristics]]" not in convert(data_file("data/formats/simplePlan.QIF")).texts["part.toml"]


def test_the_perpendicularity_of_the_sample_is_no_width_of_a_zone() -> None:
    """Directions of CYL_1 and DATUMA as the file states them: 1.22 mrad, 2.47 um over the bore; L (1 - cos) is what it states."""
    bore, plane = (
        (-0.00027596187700008, 0.00120213638300035, 0.99999923935629),
        (7.64415200000037e-6, 1.45420590000007e-5, 0.999999999865048),
    )
    apart = float(np.linalg.norm(np.cross(bore, plane)))
    assert apart == pytest.approx(1.2211e-3, rel=1e-3)
    assert 2.01982 * apart == pytest.approx(0.002466, rel=1e-3)
    assert 2.01982 * (1 - np.sqrt(1 - apart**2)) == pytest.approx(1.541919e-6, rel=0.05)
