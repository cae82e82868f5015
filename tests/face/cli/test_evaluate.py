"""vcmm evaluate: every part keeps its sheet."""

from __future__ import annotations

from vcmm.face.cli import run
from vcmm.face.cli.evaluate import _sheet_name
from vcmm.files.own.library import example


def test_parts_with_names_that_look_alike_keep_their_sheets() -> None:
    names: list[str] = []
    for part in ("a", "a/b", "a?b", "A_B", ""):
        names.append(_sheet_name(part, names))
    assert names == ["sheet-a.html", "sheet-a_b.html", "sheet-a_b-2.html", "sheet-A_B-3.html", "sheet.html"]


def test_what_is_asked_wrongly_is_no_fault_of_a_line_of_the_scenario(capsys, tmp_path, monkeypatch) -> None:
    """Nothing was measured, or two things: said before the scenario is read, without a line of it."""
    monkeypatch.chdir(tmp_path)
    for name in ("plate.toml", "p.csv", "v.csv"):
        (tmp_path / name).write_text("")
    for words in ([], ["--points", "p.csv", "--values", "v.csv"]):
        assert run(["evaluate", "plate.toml", *words]) == 2
        assert capsys.readouterr().err.startswith("vcmm: give what was measured")
    assert run(["evaluate", "plate.toml", "--values", "v.csv", "--tip-centres"]) == 2
    assert capsys.readouterr().err.startswith("vcmm: --frame and --tip-centres are about points")


def test_a_table_of_values_is_printed_with_the_warnings_of_its_parts_alone(tmp_path, capsys) -> None:
    # places of the JSON document that are null are no business of who reads the table
    values = tmp_path / "values.csv"
    values.write_text("characteristic,value_mm\nbore diameter,30.004\n")
    assert run(["evaluate", str(example("plate")), "--values", str(values), "--trials", "2000"]) == 0
    said = capsys.readouterr()
    assert "bore diameter" in said.out
    assert "].bias_mm" not in said.out + said.err
