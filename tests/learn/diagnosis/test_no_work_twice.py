"""What is computed once, or not at all, must be what it would be; counted by pencil and by numpy alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from tests.learn.diagnosis.test_log_mistakes import MACHINE, RECORDING
from tests.learn.diagnosis.test_spectrum import problem_of, uneven
from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.files.own.recording import load_recording
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.cross_checks import second_opinion
from vcmm.learn.diagnosis.evidence import detectable_effects, dictionary
from vcmm.learn.diagnosis.log_mistakes import changed_names, log_hypotheses, names_read
from vcmm.learn.diagnosis.mistakes import hypotheses
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.select import SelectedTerm, Selection
from vcmm.learn.diagnosis.sharpen import spectrum_of
from vcmm.physics.catalogue.encoder import EncoderInterpolation
from vcmm.task.response.observe import Observer

N = 40


def recorded(folder: Path, machine: str = MACHINE) -> Path:
    """Frame and table warm up, the carriage stands at 10 mm; nothing depends on the third thermometer."""
    t = np.arange(N) * 60.0
    rows = [f"10,0,0,1,0,{s:g},{20 + s / 600:.4f},{20 + s / 900:.4f},{20 - s / 900:.4f}" for s in t]
    head = "Z_mm,nx,ny,nz,d_um,time_s,temp_frame_C,temp_table_C,temp_oil_C"
    (folder / "data.csv").write_text("\n".join([head, *rows]) + "\n")
    (folder / "machine.toml").write_text(machine)
    (folder / "recording.toml").write_text(RECORDING)
    return folder / "recording.toml"


def test_a_prediction_is_made_again_only_where_what_it_reads_changed(tmp_path):
    recording, machine = load_recording(recorded(tmp_path))
    read = names_read(Observer(recording, machine))
    run = recording.run
    swapped = run.with_columns({"temp_frame_C": run.column("temp_table_C")})
    oil = run.with_columns({"temp_oil_C": run.column("temp_table_C")})
    assert changed_names(run, run) == set()
    assert changed_names(run, swapped) & read
    assert changed_names(run, oil) == {("columns", "temp_oil_C"), ("series", "oil")}
    assert not changed_names(run, oil) & read
    mirrored = replace(run, position={**run.position, "Z": -run.q("Z")})
    assert changed_names(run, mirrored) & read


def test_mistakes_of_the_log_are_those_of_whole_predictions(tmp_path):
    """Every departure is the prediction of the corrected run less that of the run as it stands; oil, which nothing follows, is not asked."""
    recording, machine = load_recording(recorded(tmp_path))
    before = Observer(recording, machine).baseline()
    found = list(log_hypotheses(recording, machine))
    exchanged = {h.component: h.departure for h in found if h.what == "columns_exchanged"}
    assert set(exchanged) == {
        "temp_frame_C and temp_oil_C",
        "temp_frame_C and temp_table_C",
        "temp_oil_C and temp_table_C",
    }
    run = recording.run
    frame, table = run.column("temp_frame_C"), run.column("temp_table_C")
    other = replace(recording, run=run.with_columns({"temp_frame_C": table, "temp_table_C": frame}))
    due = Observer(other, machine).baseline() - before
    assert exchanged["temp_frame_C and temp_table_C"] == pytest.approx(due, abs=1e-15)
    assert np.any(due)
    assert not any(
        h.component == "temp_oil_C" and h.what == "unit" for h in found
    )  # it stands in the unit of all together


def test_mistakes_are_listed_once_for_a_recording(tmp_path):
    """The same list whatever has been found; that of another recording is its own."""
    problem = make_problem(*load_recording(recorded(tmp_path)))
    again = replace(problem, residual=problem.residual + 1.0)
    assert hypotheses(again) is hypotheses(problem)
    other = make_problem(*load_recording(recorded(tmp_path)))
    assert hypotheses(other) is not hypotheses(problem)
    assert [h.what for h in hypotheses(other)] == [h.what for h in hypotheses(problem)]


def test_the_price_of_a_wide_spectrum_is_the_ln_of_its_lines(tmp_path):
    """590 mm down to 4.5 um are 131072 waves: between one and four lines each, ln 131072 = 11.8 and ln 524288 = 13.2."""
    problem = problem_of(uneven(tmp_path, 7.493, 0.0, 400))
    spectrum = spectrum_of(EncoderInterpolation("X", 0.0, 0.0, 0.02), problem, problem.whitener())
    assert spectrum is not None
    assert len(spectrum.frequency) == pytest.approx(2**19, rel=1e-3)
    assert 4096 <= len(spectrum.lowest().frequency) < 8192
    assert 11.8 - 0.6 < spectrum.price < 13.2 + 0.6  # 0.3 of the simulation twice


def family(name: str, *columns: np.ndarray) -> Family:
    options = tuple(
        Option(None, c[:, None], np.ones(1), ("",), -float(np.log(len(columns)))) for c in columns
    )
    return Family(name, {}, options)


def test_a_second_opinion_has_every_name_of_a_column(tmp_path):
    """Two names of one column to the last digit but one: whichever stands first, ours is no name that the criterion lacks."""
    rng = np.random.default_rng(0)
    x = rng.standard_normal(60)
    y = 3.0 * x + rng.standard_normal(60)
    plain = Whitener(np.ones(60), np.zeros((60, 0)), np.zeros((60, 0)), np.zeros(0), np.full(60, -1))
    first, second = family("first", x), family("second", x * (1 + 1e-15))
    found = dictionary([first, second], plain)
    for mine in (first, second):
        term = SelectedTerm(mine, mine.options[0], mine.options[0].columns)
        fit = SimpleNamespace(mean=np.array([0.0]), sigma=1.0)  # its size is not what is asked
        one = Selection((term,), cast(Any, fit), y, y)
        opinion = second_opinion(found, one, [cast(Any, SimpleNamespace(names=()))], 60)
        assert opinion.lacks == (False,)


def test_of_shapes_of_one_size_the_list_decides_which_is_in_the_middle():
    """Three shapes of one white size; the middle of the list has rms 1, however the sizes are rounded."""
    weight = np.repeat([1.0, 0.5], 8)
    white = Whitener(weight, np.zeros((16, 0)), np.zeros((16, 0)), np.zeros(0), np.full(16, -1))
    even, odd = np.repeat([1.0, 0.0], 8), np.repeat([0.0, 2.0], 8)  # both white: sqrt(8)
    for tilt in (1 - 1e-15, 1 + 1e-15):
        shown, _ = detectable_effects(dictionary([family("one", odd, even * tilt, odd / tilt)], white), 1.0)
        assert shown[0].amplitude == pytest.approx(7.0 / np.sqrt(8) * np.sqrt(0.5), rel=1e-9)
