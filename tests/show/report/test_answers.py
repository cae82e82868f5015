"""The answer lines: digits, probabilities, words; numbers by pencil."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from vcmm.show.report.answers import (
    AnswerLine,
    answer_of,
    answer_text,
    answers_block,
    percent,
    places_of,
    signed_value,
    value_and_U,
)
from vcmm.show.report.notices import notice
from vcmm.show.report.page import contents, link_headings, with_anchors
from vcmm.show.report.text import micro
from vcmm.show.report.trade_words import contributor, what_to_change


@pytest.mark.parametrize(
    ("expanded", "places"), [(0.756, 2), (12.3, 0), (1.28, 1), (0.0996, 2), (0.00123, 4)]
)
def test_two_digits_of_u(expanded: float, places: int) -> None:
    """0.0996 rounds to 0.10, so its second digit is the second decimal."""
    assert places_of(expanded) == places


def test_value_to_the_place_of_u() -> None:
    assert value_and_U(29.9999805, 0.756e-3, "mm") == ("29.99998 mm", "0.76 µm")
    assert value_and_U(30.0001234, 12.3e-3, "mm") == ("30.000 mm", "12 µm")
    assert value_and_U(0.00312, 1.28e-3, "mm", small=True) == ("3.1 µm", "1.3 µm")
    assert value_and_U(30.0, 1e-17, "mm") == ("30.00000 mm", "0.000 µm")
    assert signed_value(-0.367, 0.123, "µm") == "−0.37 ± 0.12 µm"


def test_a_probability_is_not_rounded_to_certainty() -> None:
    assert percent(0.99999) == ">\u00a099.9\u00a0%"
    assert percent(0.956) == "95.6\u00a0%"
    assert percent(0.0001) == "<\u00a00.1\u00a0%"


def test_units_as_people_write_them() -> None:
    assert micro('0.76 um of 3 urad, write "0.5 um"') == '0.76 µm of 3 µrad, write "0.5 um"'
    assert micro("11.5 um/(m K)") == "11.5 µm/(m K)"


@pytest.mark.parametrize(
    ("text", "severity", "where", "cure"),
    [
        (
            "bore: touched over 40 deg of its circle only; touch more of it",
            "warning",
            "bore",
            "touch more of it",
        ),
        ("assumed, as nothing is stated: axis C: no gain", "note", "", ""),
        (
            "servo_lag[X] jumps: left to the control's own compensation, not corrected",
            "note",
            "servo_lag[X] jumps",
            "",
        ),
        ("a.u_mm is inf", "error", "", ""),
    ],
)
def test_what_is_said_beside_a_result(text: str, severity: str, where: str, cure: str) -> None:
    found = notice(text)
    assert (found.severity, found.where, found.text, found.cure) == (severity, where, text, cure)


def line(name: str, what: str, redraw: str) -> SimpleNamespace:
    return SimpleNamespace(input=name, what=what, redraw=redraw)


def test_words_of_the_trade() -> None:
    assert (
        contributor(line("channel.temp_part_C", "temperature part, true minus reading", "machine"))
        == "temperature of the part"
    )
    assert (
        contributor(line("channel.temp_scale_x_C", "temperature scale x, true minus reading", "machine"))
        == "temperature of the X scale"
    )
    assert (
        what_to_change(line("channel.temp_part_C", "temperature part", "machine"))
        == "longer soaking, or a better thermometer"
    )
    assert contributor(line("squareness[C0Y].angle", "squareness C0Y: angle", "machine")) == "squareness C0Y"
    assert (
        contributor(line("own_effect[Z].k", "own effect Z: sag of the ram; `k` in files", "setup"))
        == "sag of the ram (own effect Z)"
    )
    assert (
        contributor(line("scatter.value", "scatter: departure", "touch")) == "repeatability of single points"
    )
    assert "pass to pass" in contributor(line("scatter.value", "scatter: departure", "pass"))


def test_lines_lead_to_their_sections() -> None:
    body, found = with_anchors("<h2>bore &lt;1&gt; (size)</h2><h2>bore 1 (size)</h2><h2>Files</h2>")
    assert list(found.values()) == ["bore-1-size", "bore-1-size-2", "files"]
    assert 'id="bore-1-size-2"' in body
    block = answers_block(
        [AnswerLine("a", "1 mm", link="bore <1> (size)"), AnswerLine("b", "2 mm", link="nowhere")]
    )
    assert '<a href="#bore-1-size">a</a>' in link_headings(block, found)
    assert "data-to" not in link_headings(block, found)
    assert contents(found).count("<li>") == 3
    assert contents({"one": "one"}) == ""


def test_the_terminal_says_the_same() -> None:
    one = AnswerLine(
        "bore",
        "30.000 mm ± 12 µm",
        "k = 2.00",
        "29.99 … 30.01 mm",
        "undecided, 80.0 %",
        because="the probe",
        change="more points",
    )
    assert answer_text([one]) == (
        "bore: 30.000 mm ± 12 µm (k = 2.00); limits 29.99 … 30.01 mm: undecided, 80.0 %\n    mostly the probe; to improve: more points"
    )


def test_the_room_is_a_temperature_and_not_an_error_of_the_machine():
    line = SimpleNamespace(
        input="environment.room", what="room temperature, common to part, scales", redraw="machine"
    )
    assert contributor(line) == "temperature of the room"
    assert what_to_change(line) == "a steadier room, longer soaking, or thermometers on part and scales"


def test_u_without_a_bound_says_why():
    line = SimpleNamespace(input="scatter.value", what="repeatability", redraw="touch", u=0.0003, share=0.84)
    c = SimpleNamespace(
        name="flat", type="flatness", unit="mm", value=0.0, nominal=0.0, u=0.0003, stated=(math.nan, math.nan), p=0.95, interval=(0.0, math.inf),
        half_width=None, bias_in_U=0.0, tolerance=(0.0, 0.005), budget=[line], decision=SimpleNamespace(text="undecided", p_conform=None),
        why_not_shown="the points hardly meet some forms; more points help",
    )  # fmt: skip
    made = answer_of(c)
    assert made.result == "0.000 µm, U unbounded"
    assert made.change == "the points hardly meet some forms; more points help"


def test_u_without_shown_coverage_is_no_claim_of_95_percent():
    """30.00027 mm +- 0.81 um of sixteen points that eight lobes would not show in: U stands, the 95 % are not claimed."""
    line = SimpleNamespace(input="form[bore]", what="form of bore", redraw="part", u=0.0004, share=0.9)
    c = SimpleNamespace(
        name="bore", type="size", unit="mm", value=30.00027, nominal=30.0, u=0.000413, stated=(0.00081, 1.96), p=0.95,
        interval=(29.99946, 30.00108), half_width=None, bias_in_U=0.0, tolerance=(29.99, 30.011), budget=[line],
        decision=SimpleNamespace(text="undecided", p_conform=None), coverage_shown=False, why_not_shown="8 lobes would not show",
    )  # fmt: skip
    made = answer_of(c)
    assert made.coverage == "k = 1.96, p = 95\u00a0%, coverage not demonstrated"
    assert made.change == "more points on the feature, all over it"
    c.coverage_shown = True
    assert answer_of(c).coverage == "k = 1.96, p = 95\u00a0%"


def test_a_value_far_outside_is_not_improved_by_a_smaller_u():
    """31.6 µm +- 1.8 of 15 allowed: the whole interval lies outside, 16.6 µm off; at 14 +- 1.8 a smaller U decides."""
    line = SimpleNamespace(input="scatter.value", what="repeatability", redraw="touch", u=0.0009, share=0.98)

    def change(value: float) -> str:
        c = SimpleNamespace(
            name="circle", type="roundness", unit="mm", value=value, nominal=0.0, u=0.0009, stated=(0.0018, 2.0), p=0.95,
            interval=(value - 0.0018, value + 0.0018), half_width=None, bias_in_U=0.0, tolerance=(0.0, 0.015), budget=[line],
            decision=SimpleNamespace(text="does not conform", p_conform=0.0),
        )  # fmt: skip
        return answer_of(c).change

    assert change(0.0316) == "the value itself, 16.6 µm outside its limits; no smaller U helps"
    assert "outside" not in change(0.014)
