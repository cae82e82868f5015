"""nu in every law: what it draws, what the budget says of it, and nu_eff of the sheet by Welch and Satterthwaite."""

from __future__ import annotations

import json
import math
import re
from pathlib import Path

import pytest

from vcmm.face.cli import run

MACHINE = """vcmm = "machine/1"
kind = "cmm"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[repeatability]
{repeat}
[[effects]]
effect = "scale_factor"
axis = "X"
k = "0 um/m"
[[inputs]]
effect = "scale_factor"
axis = "X"
parameter = "k"
{law}
"""
SCENARIO = """vcmm = "scenario/1"
machine = "machine.toml"
[pose]
shift = "100 250 -200 mm"
[part.features.a]
type = "point"
point = "0 0 0 mm"
normal = [-1, 0, 0]
[part.features.b]
type = "point"
point = "100 0 0 mm"
normal = [1, 0, 0]
[[part.characteristics]]
name = "apart"
type = "distance"
between = ["a", "b"]
limits = ["-0.01 mm", "0.01 mm"]
[plan]
styli.down = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
steps = [{ feature = "a", stylus = "down" }, { feature = "b", stylus = "down" }]
"""


def ask(folder: Path, *words: str, law: str, repeat: str = 'u = "0.1 um"') -> int:
    (folder / "machine.toml").write_text(MACHINE.format(law=law, repeat=repeat))
    (folder / "scenario.toml").write_text(SCENARIO)
    (folder / "values.csv").write_text("characteristic,value_mm\napart,100.0001\n")
    return run([words[0], str(folder / "scenario.toml"), *words[1:]])


def lines(folder: Path, capsys: pytest.CaptureFixture[str], law: str, repeat: str = 'u = "0.1 um"') -> dict:
    ask(folder, "uncertainty", "--json", law=law, repeat=repeat)
    (one,) = json.loads(capsys.readouterr().out)["characteristics"]
    return {line["input"]: line for line in one["budget"]}


def test_a_normal_law_with_nu_is_the_t_law_of_a_certificate(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The centre of a tip of 2 mm travels 102 mm: 4 um/m are 0.408 um. JCGM 101, 6.4.9.7: t of scale 0.408 um and 9 degrees of
    freedom, sd 0.408 sqrt(9 / 7) = 0.4626 um.
    """
    found = lines(tmp_path, capsys, 'u = "4 um/m"\nnu = 9')["scale_factor[X].k"]
    assert found["dof"] == 9
    assert found["u_mm"] == pytest.approx(0.408e-3 * math.sqrt(9 / 7), rel=1e-6)
    same = lines(tmp_path, capsys, 'law = "t"\nscale = "4 um/m"\nnu = 9')["scale_factor[X].k"]
    assert same["u_mm"] == pytest.approx(found["u_mm"], rel=1e-12)


def test_other_laws_keep_their_draws(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Half width 6 um/m on 102 mm: 0.612 / sqrt(3) = 0.3533 um, with nu or without."""
    for law, due in (
        ('law = "uniform"\nhalf_width = "6 um/m"', None),
        ('law = "uniform"\nhalf_width = "6 um/m"\nnu = 4', 4),
    ):
        found = lines(tmp_path, capsys, law)["scale_factor[X].k"]
        assert found["dof"] == due
        assert found["u_mm"] == pytest.approx(0.612e-3 / math.sqrt(3), rel=1e-6)


def test_effective_degrees_on_the_sheet(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """u1 = 0.3533 um with nu 4, scatter of two touches 0.1 sqrt(12 / 10) sqrt(2) = 0.1549 um with nu 12 (a t-law):
    u^2 = 0.1248 + 0.024 = 0.1488, nu_eff = 0.1488^2 / (0.1248^2 / 4 + 0.024^2 / 12) = 0.02214 / 0.003942 = 5.62.
    """
    law = 'law = "uniform"\nhalf_width = "6 um/m"\nnu = 4'
    words = ("evaluate", "--values", str(tmp_path / "values.csv"), "--out", str(tmp_path / "out"))
    ask(tmp_path, *words, law=law, repeat='u = "0.1 um"\nnu = 12')
    capsys.readouterr()
    sheet = (tmp_path / "out" / "sheet.html").read_text()
    (nu,) = re.findall(r"ν_eff = (\S+?),", sheet)
    assert nu == "6"


def test_known_together(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    both = 'u = "4 um/m"\n[[inputs]]\nnames = ["backlash[X].gap", "scale_factor[Y].k"]\n'
    both += "covariance = [[1.0, 0.5], [0.5, 1.0]]\nnu = 7\n"
    both += '[[effects]]\neffect = "backlash"\naxis = "X"\ngap = "0 um"\n'
    both += '[[effects]]\neffect = "scale_factor"\naxis = "Y"\nk = "0 um/m"\n'
    found = lines(tmp_path, capsys, both)
    assert [line["dof"] for name, line in found.items() if "backlash" in name] == [7]


@pytest.mark.parametrize(
    ("law", "repeat", "said"),
    [
        ('u = "4 um/m"\nnu = 0.5', 'u = "0.1 um"', "nu = 0.5 must be a plain number of at least 1"),
        ('u = "4 um/m"\nnu = "9"', 'u = "0.1 um"', "must be a plain number of at least 1"),
        ('law = "t"\nscale = "4 um/m"\nnu = 9\ndof = 9', 'u = "0.1 um"', "nu and dof both state"),
        ('u = "4 um/m"', 'law = "t"\nscale = "0.1 um"\nnu = 9\ndof = 9', "nu and dof both state"),
    ],
)
def test_what_is_refused(
    law: str, repeat: str, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ask(tmp_path, "uncertainty", law=law, repeat=repeat) == 2
    assert said in capsys.readouterr().err
