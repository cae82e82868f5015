"""Python and the command line give the same documents; results are read as rows, pages and in notebooks."""

from __future__ import annotations

import inspect
import json
import math
from pathlib import Path
from typing import Any

import pytest

import vcmm
from tests.shop.machining import shop
from vcmm.core.errors import Environment, UsageError
from vcmm.core.readable import flatten_record, frame_of
from vcmm.face.cli import run as command

pytestmark = pytest.mark.usefixtures("few_parts")
PLATE, BLOCK = str(vcmm.example("plate")), str(vcmm.example("test_piece"))
TRIALS = 1000


def document(words: list[str], capsys: pytest.CaptureFixture[str]) -> dict[str, Any]:
    capsys.readouterr()
    assert command([*words, "--json"]) in (0, 1)
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def same(result: Any, words: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    """The document of a Python result is that of the command, to the last bit."""
    assert json.loads(json.dumps(result.to_dict())) == document(words, capsys)


@pytest.fixture(scope="module")
def plate() -> Any:
    return vcmm.uncertainty(PLATE, trials=TRIALS)


def test_uncertainty_is_that_of_the_command(plate: Any, capsys: pytest.CaptureFixture[str]):
    same(plate, ["uncertainty", PLATE, "--trials", str(TRIALS)], capsys)


def test_measure_is_that_of_the_command(capsys: pytest.CaptureFixture[str]):
    same(vcmm.measure(PLATE), ["measure", PLATE], capsys)
    same(vcmm.measure(PLATE, seed=3), ["measure", PLATE, "--seed", "3"], capsys)


def test_evaluate_is_that_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    values = tmp_path / "values.csv"
    values.write_text("characteristic,value_mm\nbore diameter,30.008\n", encoding="utf-8")
    (part,) = vcmm.evaluate(PLATE, values=values, trials=TRIALS)
    same(part, ["evaluate", PLATE, "--values", str(values), "--trials", str(TRIALS)], capsys)
    assert part["bore diameter"].measured == 30.008
    with pytest.raises(KeyError, match="bore diameter"):
        part["bore diametre"]
    assert "bore diameter" in part.report(tmp_path / "sheet.html").read_text(encoding="utf-8")
    assert "30.008" in part._repr_html_()


@pytest.mark.thorough
def test_cut_takes_a_path_and_is_that_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file = str(shop.write(tmp_path))
    found = vcmm.cut(file, trials=TRIALS)
    same(found, ["cut", file, "--trials", str(TRIALS)], capsys)
    assert found["diameter"].name in found._repr_html_()
    assert list(found.to_dataframe("pandas")["name"]) == ["diameter", "form"]
    assert "diameter" in found.report(tmp_path / "cut.html").read_text(encoding="utf-8")


def test_a_measuring_scenario_is_not_cut():
    with pytest.raises(UsageError, match=r"vcmm\.uncertainty"):
        vcmm.cut(PLATE)


def test_nc_is_that_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    program = tmp_path / "part.nc"
    program.write_text(
        "%\nO1\nG21 G90 G54\nG0 X0 Y0 Z5\nG1 Z-1 F200\nG2 X10 Y0 I5 J0\nM30\n%\n", encoding="utf-8"
    )
    found = vcmm.nc(program, dialect="fanuc")
    same(found, ["nc", str(program), "--dialect", "fanuc"], capsys)
    # rapid to (0, 0, 5), line down by 6 mm, half a circle of radius 5 mm
    assert [m.kind for m in found.moves] == ["rapid", "line", "arc"]
    frame = found.to_dataframe("pandas")
    assert list(frame["end_mm_z"]) == [5.0, -1.0, -1.0]
    assert (
        "data-path" in found.report(tmp_path / "path.html").read_text(encoding="utf-8")
        or found.report(tmp_path / "path.html").stat().st_size > 10_000
    )


def test_test_is_that_of_the_command(capsys: pytest.CaptureFixture[str]):
    figures = vcmm.test(PLATE, iso="230-2", limits=["A = 50 um"], trials=60)
    same(figures, ["test", PLATE, "--iso", "230-2", "--limit", "A = 50 um", "--trials", "60"], capsys)
    first = figures[0]
    assert figures[first.name] is first
    assert set(figures.to_dataframe("pandas")["name"]) == {f.name for f in figures}
    with pytest.raises(KeyError, match="Allowed"):
        figures["no such figure"]


def test_compare_is_that_of_the_command(capsys: pytest.CaptureFixture[str]):
    log = str(vcmm.example("ballbar"))
    found = vcmm.compare(log)
    same(found, ["compare", log], capsys)
    assert len(found) == 1


def test_field_is_that_of_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    import numpy as np

    machine = tmp_path / "machine.toml"
    machine.write_text(
        'vcmm = "machine/1"\nname = "m"\nkind = "cmm"\nstructure = "w b Y X Z t"\n'
        'axes.X.travel = ["0 mm", "100 mm"]\naxes.Y.travel = ["0 mm", "100 mm"]\naxes.Z.travel = ["-100 mm", "0 mm"]\n'
        '[[effects]]\neffect = "squareness"\npair = "C0Y"\nangle = "3 urad"\n',
        encoding="utf-8",
    )
    found = vcmm.field(machine, nodes=2)
    frame = found.to_dataframe("pandas")
    # C0Y = +c shifts the tip by (-c y, 0, 0): -3e-6 x 100 mm = -3e-4 mm
    at = frame[frame["Y_mm"] == 100.0]
    assert np.allclose(at["error_x_mm"], -3e-4, atol=1e-12)
    body = found.to_dict()
    shown = document(["field", str(machine), "--nodes", "2"], capsys)
    assert json.loads(json.dumps({k: v for k, v in body.items() if k != "inputs"})) == {
        k: v for k, v in shown.items() if k != "inputs"
    }
    assert repr(found).startswith("<ErrorField: 8 positions, at most 0.3 ")


def test_a_frame_has_a_row_for_each_characteristic(plate: Any):
    frame = plate.to_dataframe("pandas")
    assert list(frame["name"]) == [c.name for c in plate.characteristics]
    bore = frame[frame["name"] == "bore diameter"].iloc[0]
    c = plate["bore diameter"]
    assert (bore["U_mm"], bore["interval_mm_low"], bore["interval_mm_high"]) == (c.expanded, *c.interval)
    assert "budget" not in frame.columns


def test_a_budget_is_a_frame(plate: Any):
    frame = plate.budget.to_dataframe("pandas")
    bore = frame[frame["characteristic"] == "bore diameter"]
    assert list(bore["u"]) == [line.u for line in plate["bore diameter"].budget]
    assert list(plate["bore diameter"].budget.to_dataframe("pandas")["input"]) == list(bore["input"])


def test_flattening_by_hand():
    row = {
        "name": "a",
        "interval_mm": [1.0, 2.0],
        "at": [1.0, 2.0, 3.0],
        "true_value": {"claimed": True},
        "budget": [{"u": 1}],
    }
    assert flatten_record(row) == {
        "name": "a", "interval_mm_low": 1.0, "interval_mm_high": 2.0, "at_x": 1.0, "at_y": 2.0, "at_z": 3.0,
        "true_value.claimed": True,
    }  # fmt: skip


def test_another_library_or_none(monkeypatch: pytest.MonkeyPatch):
    with pytest.raises(UsageError, match="pandas, polars"):
        frame_of([{"a": 1}], "excel")
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(Environment, match="pip install pandas"):
        frame_of([{"a": 1}])


def test_a_report_is_one_file_of_the_same_numbers(plate: Any, tmp_path: Path):
    page = plate.report(tmp_path / "plate.html").read_text(encoding="utf-8")
    assert page.startswith("<!doctype html>")
    assert f"{1e3 * plate['bore diameter'].expanded:.2g}" in page


def test_a_notebook_shows_the_answer_and_the_table(plate: Any):
    shown = plate._repr_html_()
    assert shown.index("<strong>bore diameter</strong>") < shown.index("<table")
    assert len(repr(plate)) < 1500
    assert "\n" not in repr(plate)


def test_a_step_inside_a_job_says_why_it_has_no_document():
    from vcmm.answer.evaluation.virtual_measurement import measure_task

    inner = measure_task(vcmm.load_scenario(PLATE).task())
    assert inner._repr_html_() is None
    with pytest.raises(UsageError, match="inside a job"):
        inner.to_dict()


def test_a_job_without_a_page_says_so(tmp_path: Path):
    with pytest.raises(UsageError, match="no report"):
        vcmm.measure(PLATE).report(tmp_path / "m.html")


def test_place_refuses_what_it_does_not_use():
    with pytest.raises(UsageError, match="goal"):
        vcmm.place(BLOCK, goal=vcmm.placement.Goal())


VERBS = "measure uncertainty evaluate audit routes certificate place diagnose calibrate test compare nc cut compensate convert field"


def test_every_job_is_a_function():
    assert all(callable(getattr(vcmm, name)) for name in VERBS.split())


FUNCTIONS = [n for n in vcmm.__all__ if inspect.isfunction(getattr(vcmm, n))]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_docstrings_are_of_numpydoc(name: str):
    """Sections with their underline, and every parameter of the call in its own line, in the order of the call."""
    function = getattr(vcmm, name)
    text = inspect.getdoc(function) or ""
    lines = text.splitlines()
    assert lines[0].endswith((".", ")")), "one line that says what it does"
    called = list(inspect.signature(function).parameters)
    if called:
        start = lines.index("Parameters")
        assert set(lines[start + 1]) == {"-"}
        end = next(
            i
            for i in range(start + 2, len(lines) + 1)
            if i == len(lines) or lines[i] in ("Returns", "Raises")
        )
        told = [line for line in lines[start + 2 : end] if line and not line.startswith(" ")]
        assert told == called
    assert "Returns" in lines
    assert lines[lines.index("Returns") + 1] == "-------"


def test_options_of_jobs_are_typed():
    for name in FUNCTIONS:
        kinds = {p.kind for p in inspect.signature(getattr(vcmm, name)).parameters.values()}
        assert inspect.Parameter.VAR_KEYWORD not in kinds, name


def test_documents_hold_numbers_that_are_finite(plate: Any):
    def walk(value: Any) -> None:
        if isinstance(value, dict):
            for inner in value.values():
                walk(inner)
        elif isinstance(value, list):
            for inner in value:
                walk(inner)
        elif isinstance(value, float):
            assert math.isfinite(value)

    walk(plate.to_dict())
