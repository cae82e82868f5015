"""Run: rows of positions, columns and labels; what is refused; redraw labels."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Run, Series, encode_labels, first_order_lag


def _run(n: int = 4, **columns: object) -> Run:
    values = {k: np.asarray(v, dtype=float) for k, v in columns.items()}
    labels = {"stylus": np.array(["a", "b", "a", "b"][:n]), "pose": np.array(["1"] * n)}
    return Run({"X": np.arange(float(n))}, np.zeros((n, 3)), values, labels)


def test_shapes_are_checked():
    with pytest.raises(UsageError, match=r"offset must have shape \(n, 3\)"):
        Run({}, np.zeros(3))
    with pytest.raises(UsageError, match=r"position X has shape \(2,\), but the run has 1 rows"):
        Run({"X": np.zeros(2)}, np.zeros((1, 3)))
    with pytest.raises(UsageError, match=r"label stylus has shape"):
        Run({}, np.zeros((1, 3)), {}, {"stylus": np.array(["a", "b"])})


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_are_named(bad):
    with pytest.raises(ModelLimit, match="column temp_part_C is not a finite number in row 3"):
        _run(temp_part_C=[20.0, 20.0, bad, 20.0])


def test_absent_columns_show_the_closest():
    run = _run(temp_part_C=[20.0] * 4)
    with pytest.raises(ModelLimit, match=r'no column temp_prat_C. Did you mean "temp_part_C"'):
        run.column("temp_prat_C")
    with pytest.raises(ModelLimit, match=r"no position of axis Y.*Allowed: X"):
        run.q("Y")


def test_copies_of_redraw_labels():
    run = _run()
    assert run.copies("machine") == (["machine"], pytest.approx(np.zeros(4)))
    values, codes = run.copies("touch")
    assert values == ["0", "1", "2", "3"]
    assert codes.tolist() == [0, 1, 2, 3]
    values, codes = run.copies("stylus")
    assert values == ["a", "b"]
    assert codes.tolist() == [0, 1, 0, 1]
    with pytest.raises(
        UsageError, match=r'redraw = "stilus" names no label of this run. Did you mean "stylus"'
    ):
        run.copies("stilus")


def test_take_keeps_rows_together():
    run = _run(time_s=[1.0, 2.0, 3.0, 4.0]).take(np.array([2, 0]))
    assert run.q("X").tolist() == [2.0, 0.0]
    assert run.column("time_s").tolist() == [3.0, 1.0]
    assert run.labels["stylus"].tolist() == ["a", "a"]
    assert run.n == 2


def test_part_point_falls_back_to_the_tip():
    tip = {f"tip_{c}_mm": [1.0, 2.0, 3.0, 4.0] for c in "xyz"}
    assert _run(**tip).part_point[1].tolist() == [2.0, 2.0, 2.0]
    part = {f"part_{c}_mm": [9.0, 9.0, 9.0, 9.0] for c in "xyz"}
    assert _run(**tip, **part).part_point[1].tolist() == [9.0, 9.0, 9.0]


def test_lag_before_and_after_the_log():
    # steady before the log; held after it: from 20.5 towards 21 with exp(-100 / 100)
    log = Series(np.array([0.0, 100.0]), np.array([20.0, 21.0]))
    before, at_end, after = first_order_lag(log, 100.0, np.array([-50.0, 100.0, 200.0]))
    assert before == 20.0
    # 1 K in 100 s: y = 21 - 1 x (1 - 1/e) / 1 = 20 + 1/e = 20.367879
    assert at_end == pytest.approx(20.367879, abs=1e-6)
    assert after == pytest.approx(21 + (at_end - 21) * np.exp(-1.0), abs=1e-12)


def test_lag_of_zero_is_the_log():
    log = Series(np.array([0.0, 100.0]), np.array([20.0, 21.0]))
    assert first_order_lag(log, 0.0, np.array([25.0]))[0] == pytest.approx(20.25)


def test_an_added_column_is_looked_at():
    run = _run()
    with pytest.raises(UsageError, match="column time_s has shape"):
        run.with_columns({"time_s": np.zeros(3)})
    with pytest.raises(ModelLimit, match="time_s is not a finite number in row 2"):
        run.with_columns({"time_s": np.array([0.0, np.nan, 0.0, 0.0])})
    assert "time_s" not in run.columns


@pytest.mark.parametrize("labels", [[], ["b"], ["b", "b", "a", "b", "c", "c", ""], list("abcabc")])
def test_codes_of_labels_are_those_of_unique(labels):
    values, codes = encode_labels(np.array(labels, dtype=np.str_))
    due, own = np.unique(np.array(labels, dtype=np.str_), return_inverse=True)
    assert values.tolist() == due.tolist()
    assert codes.tolist() == own.tolist()
