"""Probabilities, held-out folds, result files, plans and the printed tables of the exam."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from benchmarks.exam import asking, blocks, calibration, folds, plans, results
from benchmarks.exam.bars import figures, relative_errors
from benchmarks.exam.calibration import Claim
from benchmarks.exam.run import main
from benchmarks.exam.tables import bars_table, confusion_table, pages, set_table

RIGHT = [Claim(0.9, True, "A"), Claim(0.9, False, "A"), Claim(0.6, True, "F")]


def _row(block: str = "A", case: int = 0, **more):
    row = {
        "block": block, "seed": 1, "case": case, "delta_asked": 10.0, "rows_asked": None, "design": "probe rich", "world": "t6",
        "concealed": [{"effect": "backlash", "where": {"axis": "X"}, "counts_too": [], "delta": 10.0, "note": ""}],
        "answered": ["backlash"], "where": [{"axis": "X"}], "probabilities": [0.999], "sets": [["backlash", "hysteresis"]], "set_size": 2,
        "verdict": "explained", "unknown": None, "mistake": None, "anything": True, "right": True, "in_set": True, "exact": True,
        "all_in_sets": True, "extra": 0, "place_right": True, "wrong_confident": False, "seconds": 4.0, "processor_s": 4.5,
        "intervals": [{"inside": True, "ratio": 1.05}], "stale": 1.0, "stale_delta": 0.0, "invisible": False,
    }  # fmt: skip
    return row | more


def test_the_exam_knows_the_product_by_its_command_only() -> None:
    allowed = {
        "asking.py": {"vcmm.face.cli"},
        "heldout.py": {"vcmm.files.own.machine", "vcmm.files.own.recording", "vcmm.task.response.observe"},
        "run.py": {
            "vcmm.face.job",
            "vcmm.core.crew",
        },  # how many workers there are, nothing of a diagnosis
    }
    for path in Path(calibration.__file__).parent.glob("*.py"):
        named = set(re.findall(r"^\s*(?:from|import) (vcmm[\w.]*)", path.read_text(), re.MULTILINE))
        assert named == allowed.get(path.name, set()), path.name


def test_calibration_error_by_hand() -> None:
    # bin 0.8-0.95: two answers, stated 0.9 each, one right: |1.8 - 1| = 0.8; bin 0.5-0.8: |0.6 - 1| = 0.4; 1.2 / 3 = 0.4
    assert calibration.error_of(calibration.bins(RIGHT)) == pytest.approx(0.4)
    assert calibration.table(RIGHT)[1][:4] == ["0.80 to 0.95", "2", "0.900", "0.50"]


def test_calibration_error_that_chance_alone_gives() -> None:
    # 400 answers of 0.9 in one bin: the share right has sd sqrt(0.09/400) = 0.015, mean of its size 0.015 sqrt(2/pi) = 0.012
    mean, most = calibration.by_chance([Claim(0.9, True, "A")] * 400)
    assert mean == pytest.approx(0.012, abs=0.001)
    assert most == pytest.approx(1.96 * 0.015, abs=0.003)


def test_claims_on_nulls_and_foreign_physics_are_wrong() -> None:
    rows = [_row(), _row("B", concealed=[]), _row("E"), _row("C", answered=["squareness"], concealed=[])]
    assert [c.right for c in calibration.claims(rows)] == [True, False, False, True]
    assert calibration.sure(calibration.claims(rows))[:2] == (2, 4)


def test_relative_error_is_in_units_of_one_over_delta() -> None:
    assert relative_errors([_row()]) == pytest.approx([0.5])  # |1.05 - 1| * 10


def test_rows_of_folds(tmp_path: Path) -> None:
    case = blocks.build("A", 3, 0, tmp_path, rows=200)
    pose = folds.rows_of("pose p4", case.design)
    assert pose.sum() == 40  # five poses of 40 rows
    assert folds.rows_of("later time", case.design).tolist() == [False] * 140 + [True] * 60
    assert folds.rows_of("a fold of another kind", case.design) is None
    effect = folds.true_effect(case)
    everywhere = folds.strength_in(case, effect, np.ones(200, dtype=bool))
    assert everywhere == pytest.approx(case.truth.deltas[0], rel=1e-6)
    assert folds.strength_in(case, effect, pose) < everywhere


def test_result_lines_are_read_back_and_not_run_again(tmp_path: Path) -> None:
    path = tmp_path / "results.jsonl"
    results.append(path, _row())
    results.append(path, _row(case=1, error="exit 70"))
    assert results.done(path) == {("A", 1, 0, 10.0, None)}
    results.append(path, _row(case=1))
    assert len(results.read([path])) == 2
    path.write_text(path.read_text() + "half a li")
    with pytest.raises(ValueError, match="line 4"):
        results.read([path])


def test_a_plan_goes_on_in_rounds() -> None:
    first = list(plans.asked("hour"))[: sum(e.count for e in plans.ROUND)]
    assert {block for block, *_ in first} == set("ABCDEFGH")
    every = [one[:3] for one in plans.asked("overnight")]
    assert len(set(every)) == len(every) == plans.size("overnight")
    assert sum(block == "A" and delta == 10 for block, _, delta in every) == 960


def test_bars_and_tables_from_rows() -> None:
    rows = [_row(), _row(case=1, answered=["hysteresis"], right=False, in_set=False, exact=False)]
    first = figures(rows)[0]
    assert (first.what, first.hits, first.n, first.met) == ("right name first", 1, 2, False)
    assert "| `backlash` | 2 | `backlash` 1, `hysteresis` 1 |" in confusion_table(rows)
    text = pages(rows)
    assert (
        "| A, delta 10 | right name first | 1 of 2 | 0.500 | at least 0.025 | at least 0.985 | **missed** |"
        in text
    )
    assert "A 10 1" in text.split("## What failed")[1]


def test_a_case_that_failed_counts_as_missed() -> None:
    first = figures(
        [
            _row(),
            {"block": "A", "seed": 1, "case": 1, "delta_asked": 10.0, "rows_asked": None, "error": "exit 70"},
        ]
    )[0]
    assert (first.hits, first.n) == (1, 2)


@pytest.mark.thorough
def test_the_page_holds_what_the_command_prints() -> None:
    folder = Path(calibration.__file__).parent
    page = (folder.parents[1] / "docs" / "exam.md").read_text(encoding="utf-8")
    complete = (folder / "tables.md").read_text(encoding="utf-8")
    assert pages(results.read([folder / "results.jsonl.gz"])) in complete
    fresh = results.read([folder / "results_fresh.jsonl.gz"])
    assert bars_table(fresh) in page
    assert set_table(fresh) in page


def test_next_measurement_is_printed() -> None:
    step = {
        "status": "taken", "do": "turn the artefact", "minutes": 30, "separates": ["backlash", "hysteresis"], "answered": ["backlash"],
        "sets": [["backlash"]], "set_size": 1, "right": True, "in_set": True,
    }  # fmt: skip
    text = pages([_row("F", next=step), _row("F", 1, next={"status": "none proposed"})])
    assert "Sets with rivals: 2; taken 1, none proposed 1." in text
    assert "set smaller 1 of 1" in text
    assert "told apart 1 of 1" in text


@pytest.mark.thorough
def test_the_report_of_a_ringing_trace_follows_its_accelerations(tmp_path: Path) -> None:
    case = blocks.build(
        "A", 3, 33, tmp_path
    )  # servo trace, a structure that rings after every change of acceleration
    found, _ = asking.diagnose(case.recording, 3, tmp_path / "out")
    assert found["answer"][0]["effect"] == "structural_vibration"
    assert "Residual before and after" in (tmp_path / "out" / "report.html").read_text(encoding="utf-8")
    assert "follows = 1" in (tmp_path / "out" / "machine.toml").read_text(encoding="utf-8")


@pytest.mark.thorough
def test_a_process_of_its_own_gives_the_same_document(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = blocks.build("A", 3, 5, tmp_path, rows=120)
    here, _ = asking.diagnose(case.recording, 3)
    there, _ = asking.diagnose(case.recording, 3, fresh=True)
    assert here == there
    with pytest.raises(RuntimeError, match="exit 2"):
        asking.diagnose(tmp_path / "absent.toml", 3)
    with pytest.raises(RuntimeError, match=r"within 0\.05 s"):
        asking.diagnose(case.recording, 3, limit=0.05)
    out = tmp_path / "r.jsonl"
    words = ["--block", "F", "--cases", "3-3", "--seed", "3", "--no-next", "--out", str(out)]
    assert main(words) == 0
    assert json.loads(out.read_text())["case"] == 3
    assert main(words) == 0
    assert len(out.read_text().splitlines()) == 1
    assert main(["summarise", str(out)]) == 0
    assert "## Sample" in capsys.readouterr().out
