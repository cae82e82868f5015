"""Values out of their usual range are refused or told by name; limits as data sheets write them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.plate import edited
from vcmm.core.errors import DataError, UsageError
from vcmm.face.cli import run
from vcmm.files.own.machine import load_machine
from vcmm.task.certification.certificate import length_limit, short_limit

MACHINE = """vcmm = "machine/1"
structure = "w b Y X Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
"""


def said(capsys: pytest.CaptureFixture[str], file: Path) -> tuple[int, str]:
    code = run(["check", str(file), "--json"])
    out, err = capsys.readouterr()
    return code, (" ".join(json.loads(out)["understood"].values()) if code == 0 else err)


def machine_file(folder: Path, text: str) -> Path:
    path = folder / "m.toml"
    path.write_text(MACHINE + text)
    return path


@pytest.mark.parametrize(("text", "fixed", "slope"), [
    ("1.9 um + L/300", 1.9, 1000 / 300), ("1.9 + L/300", 1.9, 1000 / 300), ("1.9 + 3L/1000", 1.9, 3.0), ("1.9 + 3.3 L/1000", 1.9, 3.3),
    ("1.9 um + 3.3 L / 1000", 1.9, 3.3), ("1.9 um + 3.3 um/m", 1.9, 3.3), ("1.9 µm + 3.3 µm/m", 1.9, 3.3), ("(1.9 + 3*L/1000) um", 1.9, 3.0),
    ("±1.9 um", 1.9, 0.0), ("1.9 um + L/300 um", 1.9, 1000 / 300), ("L/250", 0.0, 4.0), ("0.0019 mm + 3.3L/1000", 1.9, 3.3), ("0.5 um + 2 ppm", 0.5, 2.0),
])  # fmt: skip
def test_limits_as_data_sheets_write_them(text: str, fixed: float, slope: float) -> None:
    """um at 0 and at 1000 mm."""
    found = length_limit(text, "E0_MPE")
    assert 1e3 * found(0.0) == pytest.approx(fixed)
    assert 1e3 * found(1000.0) == pytest.approx(fixed + slope)


@pytest.mark.parametrize(
    "text",
    [
        "1.8 um + L/350 <= 4 um",
        "min(1.8 um + L/350, 4 um)",
        "1.8 + L/350 ≤ 4 um",
        "1.8 um + L/350 < 0.004 mm",
    ],
)
def test_a_limit_grows_as_far_as_its_cap(text: str) -> None:
    """1.8 um + L/350 is 2.8 um at 350 mm and reaches 4 um at 350 * 2.2 = 770 mm (the third form of ISO 10360-2)."""
    found = length_limit(text, "E0_MPE")
    assert [1e3 * found(at) for at in (0.0, 350.0, 770.0, 2000.0)] == pytest.approx([1.8, 2.8, 4.0, 4.0])
    assert 1e3 * found.at(np.array([350.0, 2000.0])) == pytest.approx([2.8, 4.0])
    assert found.corner == pytest.approx(770.0)
    assert str(found) == "1.8 um + L/350 <= 4 um"


@pytest.mark.parametrize(("text", "words"), [
    ("1.9 um + L/300 <= 1.5 um", "begins below it"), ("1.9 um <= 4 um", "bounds a limit that grows"), ("1.9 um + L/300 <= L/200", "does not grow with a length"),
    ("1.9 um + 3 furlongs", 'write "1.9 um + L/300"'), ("1.9 um + L/0.3", "grows by 3333 um per metre; usual are L/50 to L/1500"),
    ("1.9", 'E0_MPE = "1.9 um'), ("1.9 um + L", 'write "1.9 um + L/300"'), ("1.9 um + 0L/1000", "grows by more than nothing"),
])  # fmt: skip
def test_limits_that_are_refused_say_what_to_write(text: str, words: str) -> None:
    with pytest.raises(UsageError) as error:
        length_limit(text, "E0_MPE")
    assert words in str(error.value)


def test_a_short_limit_does_not_grow() -> None:
    with pytest.raises(UsageError, match="does not grow"):
        short_limit("1.9 um + L/300", "R0_MPL")


def test_keys_as_data_sheets_have_them(tmp_path: Path) -> None:
    """The same machines whichever edition names the limit."""
    keys = (
        ("R0_MPL", "P_Form_Sph_1x25", "P_Size_Sph_1x25"),
        ("R0_MPE", "P_Form_Sph_1x25_MPE", "P_Size_Sph_1x25_MPE"),
        ("R0_MPE", "PFTU_MPE", "PSTU_MPE"),
    )
    found = []
    for r0, form, size in keys:
        text = f'[certificate]\nE0_MPE = "1.9 + 3.3L/1000"\n{r0} = "1.5 um"\n{form} = "1.9 um"\n{size} = "1.2 um"\n'
        found.append(load_machine(machine_file(tmp_path, text)))
    assert found[0].inputs[0].evidence == found[1].inputs[0].evidence == found[2].inputs[0].evidence
    assert "P_Form 1.9 um" in found[0].inputs[0].evidence


@pytest.mark.parametrize(("old", "new"), [("MPEP", "PFTU_MPE"), ("MPE_P", "PFTU_MPE"), ("MPE_E", "E0_MPE")])
def test_symbols_of_earlier_editions_lead_to_those_of_today(tmp_path: Path, old: str, new: str) -> None:
    """ISO 10360-2:2001 has MPE_P for the probing error and MPE_E for lengths; R0_MPE is a repeatability range, neither of them."""
    text = f'[certificate]\nE150_MPE = "1.9 um + L/300"\n{old} = "1.8 um"\n'
    with pytest.raises(DataError, match=f'unknown key "{old}". Did you mean "{new}"'):
        load_machine(machine_file(tmp_path, text))


CERTIFICATE = '[certificate]\nE0_MPE = "1.9 um + L/300"\n'


@pytest.mark.parametrize(("text", "words"), [
    ('R0_MPL = "15 um"\nP_Form_Sph_1x25 = "1.9 um"\n', "R0_MPL (15 um) is more than twice P_Form_Sph_1x25 (1.9 um)"),
    ('R0_MPE = "4 um"\n', "R0_MPE (4 um) is more than twice E0_MPE of the shortest length (1.9 um)"),
    ('E150_MPE = "1.5 um + L/300"\n', "E150_MPE (1.5 um at 0 mm) is below E0_MPE (1.9 um)"),
    ('E150_MPE = "1.9 um + L/400"\n', "E150_MPE (4.4 um at 1000 mm) is below E0_MPE (5.233 um)"),
    ('PFTU_MPE = "0.19 um"\n', "PFTU_MPE (0.19 um) is 0.1 times E0_MPE"),
    ('PSTE_MPE = "2 um"\n', "PSTE_MPE has no effect: machines are drawn with one stylus"),
])  # fmt: skip
def test_limits_that_do_not_go_together(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, words: str
) -> None:
    code, found = said(capsys, machine_file(tmp_path, CERTIFICATE + text))
    assert code == 0
    assert words in found


def test_limits_that_do_go_together_have_no_remark(tmp_path: Path) -> None:
    text = 'E150_MPE = "2.2 um + L/300"\nR0_MPL = "1.5 um"\nP_Form_Sph_1x25 = "1.9 um"\n'
    assert load_machine(machine_file(tmp_path, CERTIFICATE + text)).remarks == ()


def test_one_limit_by_two_keys(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = 'PFTU_MPE = "1.9 um"\nP_Form_Sph_1x25 = "1.9 um"\n'
    code, found = said(capsys, machine_file(tmp_path, CERTIFICATE + text))
    assert code == 2
    assert "PFTU_MPE and P_Form_Sph_1x25 state the same limit; keep one of them" in found


@pytest.mark.parametrize(("value", "code"), [("-23.2", 2), ("2.32", 0), ("0.0232", 0), ("232", 0)])
def test_expansions_that_no_usual_part_has(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], value: str, code: int
) -> None:
    part = edited(tmp_path, ('expansion = "11.5 um/(m K)"', f'expansion = "{value} um/(m K)"'))
    got, found = said(capsys, part)
    assert got == code
    assert ("usual are 4 to 30" in found) or value == "232"
    assert value in found
    assert "steel" in found
    scales = f'[environment]\nscales = {{ expansion = "{value} um/(m K)" }}\n'
    got, found = said(capsys, machine_file(tmp_path, scales))
    assert got == code
    assert "usual are 4 to 30" in found


def test_a_sphere_with_a_slip_of_the_unit(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """0.1 mm in place of 0.1 um: U of the bore was 196 um without a word; certificates state 0.02 to 2 um."""
    for value, is_remarked in (("0.1 mm", True), ("2 um", False)):
        sphere = f'qualification = {{ sphere_diameter = "25 mm", u_diameter = "{value}" }}'
        code, words = said(
            capsys, edited(tmp_path, ('tip_diameter = "4 mm"', f'tip_diameter = "4 mm", {sphere}'))
        )
        assert code == 0
        assert ("certificates of reference spheres state 0.02 to 2 um" in words) is is_remarked
