"""Text with units to canonical numbers, and what is said when it is wrong."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from vcmm.core.errors import UsageError
from vcmm.core.units import (
    DIMENSIONS,
    EXAMPLES,
    channel_unit,
    dimension_of,
    in_unit,
    parse_unit,
    quantity,
    shorten,
    vector,
)


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    [
        ("0.8 um", "length", 0.8e-3),
        ("2 in", "length", 50.8),  # 2 x 25.4
        ("1.5 m", "length", 1500.0),
        ("8.0 um/(m K)", "expansion", 8e-6),  # 8e-3 mm / (1e3 mm K)
        ("8 um/m/K", "expansion", 8e-6),
        ("5 um/m", "slope", 5e-6),
        ("12 ppm", "slope", 12e-6),
        ("3 arcsec", "angle", 3 * math.pi / 648000),
        ("90 deg", "angle", math.pi / 2),
        ("10 um/m", "angle", 1e-5),  # shop practice: a slope where an angle is due
        ("50 m/s^3", "jerk", 50000.0),
        ("60 mm/min", "speed", 1.0),
        ("40 1/s", "frequency", 40.0),
        ("40 Hz", "frequency", 40.0),
        ("20.4 degC", "temperature", 20.4),
        ("20.4 °C", "temperature", 20.4),
        ("50 mK", "temperature difference", 0.05),
        ("0.5 um/h", "length per time", 0.5e-3 / 3600),
        ("0.1 um/N", "compliance", 1e-4),
        ("2 um/m^2", "curvature", 2e-9),  # 2e-3 mm / 1e6 mm^2
        ("3 %", "number", 0.03),
        ("0.5", "number", 0.5),
        ("5 um/(m/s^2)", "um/(m/s^2)", 5e-6),  # 5e-3 mm / (1e3 mm/s^2)
        ("5 um s^2/m", "um/(m/s^2)", 5e-6),  # the same dimension, written otherwise
        ("5 urad/(m/s^2)", "angle per acceleration", 5e-9),  # 5e-6 rad / (1e3 mm/s^2)
        ("30 um/(m/s)", "time", 3e-5),  # 0.03 mm / (1e3 mm/s)
        ("2 mm s/m", "time", 2e-3),  # 2 mm s / 1e3 mm
        ("7 um/(N m)", "um/(N m)", 7e-6),  # 7e-3 mm / (N 1e3 mm)
        ("4 N/um", "N/um", 4000.0),  # N / 1e-3 mm
        ("6 um/rpm", "um/rpm", 0.18 / math.pi),  # 6e-3 mm / (2 pi / 60 rad/s) = 6e-3 x 30 / pi
        ("3 um/(K h)", "um/(K h)", 3e-3 / 3600),
        ("1.5um", "length", 1.5e-3),
        ("-3e-1 mm", "length", -0.3),
    ],
)
def test_canonical_numbers(text, dimension, expected):
    assert quantity(text, dimension) == pytest.approx(expected, rel=1e-14)


def test_both_letters_mu():
    assert (
        quantity("1 µm", "length") == quantity("1 μm", "length") == 1e-3
    )  # U+00B5 micro sign, U+03BC Greek mu


def test_vectors():
    assert vector("0 0 20 mm", "length") == (0.0, 0.0, 20.0)
    assert vector("0 0 20mm", "length") == (0.0, 0.0, 20.0)
    assert vector(["0 mm", "0.02 m"], "length") == (0.0, 20.0)


@pytest.mark.parametrize("dimension", DIMENSIONS)
def test_every_example_is_right(dimension):
    quantity(EXAMPLES[dimension], dimension)


@given(st.floats(-1e6, 1e6), st.sampled_from(["um", "mm", "in", "nm"]))
def test_there_and_back(value, unit):
    assert in_unit(quantity(f"{value!r} {unit}", "length"), unit) == pytest.approx(
        value, rel=1e-12, abs=1e-300
    )


def test_values_of_a_file_on_one_line():
    assert shorten([True, "a", {"b": 1.5}, []]) == '[true, "a", { b = 1.5 }, []]'


def test_names_of_dimensions():
    assert dimension_of("um/(m K)") == "expansion"
    assert dimension_of("um/m") == "slope"
    assert dimension_of("1") == "number"
    assert [dimension_of(u) for u in ("um/(m/s)", "mm s/m", "urad/(m/s^2)")] == [
        "time", "time", "angle per acceleration",
    ]  # fmt: skip
    assert dimension_of("um/(m/s^2)") == "um/(m/s^2)"  # s^2, which has no name
    assert [channel_unit(c) for c in ("temp_part_C", "speed_X_mm_s", "time_s", "probe_angle_rad")] == [
        "K", "mm/s", "s", "rad",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("value", "dimension", "words"),
    [
        (0.6, "length", ["gap = 0.6 has no unit", 'write for example gap = "0.6 um"']),
        ("0.6", "length", ['gap = "0.6 um"']),
        ("5", "slope", ["has no unit", 'gap = "5 um/m"']),
        (True, "length", ["gap = true is not a text"]),
        ([1.0, 2.0], "length", ["gap = [1.0, 2.0] is not a text with a number and its unit"]),
        ("abc", "length", ["has no number"]),
        ("", "length", ["has no number"]),
        ("nan mm", "length", ["is not finite"]),
        ("inf mm", "length", ["is not finite"]),
        ("1e999 mm", "length", ["is not finite"]),
        ("3 kg", "length", ['is not a length: the unit "kg" does not fit']),
        ("3 kg", "angle", ["is not an angle"]),
        ("3 umm", "length", ['unknown unit "umm"', 'Did you mean "um"?']),
        ("3 MM", "length", ['unknown unit "MM"', 'Did you mean "mm"?']),
        ("1,5 mm", "length", ["has a comma; decimals take a point"]),
        ("1 2 mm", "length", ["has 2 numbers, expected one"]),
        ("5 degC", "temperature difference", ["is a temperature difference and takes K"]),
        ("5 K", "temperature", ["is a temperature and takes degC"]),
        ("5 um^x", "length", ["expected a whole number after ^"]),
        ("5 (um", "length", ["open bracket"]),
        ("5 um)", "length", ["cannot be read after"]),
        ("5 §", "length", ["cannot be read at"]),
        (
            "3 kg",
            "um/(m/s^2)",
            [
                "is not in um/(m/s^2) or another unit of that dimension",
                'the unit "kg" does not fit',
                'gap = "1 um/(m/s^2)"',
            ],
        ),
        ("3", "um/(m/s^2)", ["has no unit", 'gap = "3 um/(m/s^2)"']),
        ("3 um/(m/s^2)", "length", ["is not a length", 'the unit "um/(m/s^2)" does not fit']),
        ("9e13 um/(m/s^2)", "um/(m/s^2)", ["times what is usual"]),
        ("3.3 L/1000", "slope", ['"L" in "L/1000" is no unit: L is the measured length', "is 3.3 um/m"]),
        (
            "5 um/1000 mm",
            "slope",
            ['"1000" in "um/1000 mm" is no unit: a unit contains no number', "3.3 um/m"],
        ),
        (
            "68 degF",
            "temperature",
            ['"degF" is no unit: temperatures are written in degC', "68 degF is (68 - 32) / 1.8 = 20 degC"],
        ),
        ("68 °F", "temperature", ["written in degC"]),
        ("2 thou", "length", ["a thousandth of an inch is 25.4 um"]),
        ("2 inch", "length", ["is no unit: write in"]),
    ],
)
def test_messages(value, dimension, words):
    with pytest.raises(UsageError) as caught:
        quantity(value, dimension, "gap")
    for word in words:
        assert word in str(caught.value)


def test_messages_show_the_corrected_list():
    with pytest.raises(UsageError) as caught:
        vector([0, 0, 20], "length", "point", "0 0 20 mm")
    assert str(caught.value) == 'point = [0, 0, 20] has no unit; write for example point = "0 0 20 mm"'


def test_an_empty_unit_is_no_unit():
    with pytest.raises(UsageError, match="the unit is empty"):
        parse_unit("")
