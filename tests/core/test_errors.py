"""What exceptions carry besides their sentence."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError, Environment, ModelLimit, VcmmError, choose_from, did_you_mean


def test_the_place_is_data_beside_an_unchanged_sentence():
    error = ModelLimit("row 3: too far", row=2, line=12, column=5)
    assert (str(error), error.row, error.line, error.column) == ("row 3: too far", 2, 12, 5)
    assert (VcmmError("x").row, VcmmError("x").line, VcmmError("x").column) == (None, None, None)


def test_a_file_reports_all_its_problems():
    error = DataError(["first", "second"], line=7)
    assert str(error) == "first\nsecond"
    assert error.problems == ("first", "second")
    assert error.line == 7
    assert DataError("only").problems == ("only",)


def test_exit_codes_tell_the_computer_from_the_user():
    assert (DataError("x").exit_code, Environment("x").exit_code) == (2, 3)


@pytest.mark.parametrize(
    ("word", "said"),
    [("travl", ' Did you mean "travel"?'), ("TRAVEL", ' Did you mean "travel"?'), ("qq", "")],
)
def test_the_closest_word(word, said):
    assert did_you_mean(word, ["travel", "speed"]) == said


def test_the_allowed_words_follow():
    assert choose_from("speeed", ["travel", "speed"]) == ' Did you mean "speed"? Allowed: travel, speed.'
