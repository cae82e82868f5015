"""The next measurement of the exam: rows taken again with one thing changed, and readings of the same machine."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from benchmarks.exam import addon, blocks
from benchmarks.exam.addon_rows import NotPossible, taken
from benchmarks.exam.blocks import Setting, effect_of
from benchmarks.exam.kinema import Errors
from benchmarks.exam.observe import Hidden, observed, tip_motion
from benchmarks.exam.strength import whitener

OLD = 500
BACKLASH, SCALE, BAR = 0, 1, 2  # cases of block F: probe, probe, ball bar


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> blocks.Case:
    return blocks.build("F", 4, BACKLASH, tmp_path_factory.mktemp("poor"))


def _both(case: blocks.Case, change: str):
    return addon.longer(case.design, change, np.random.default_rng(1))


def test_sentences_of_the_command_are_understood() -> None:
    from vcmm.learn.diagnosis.addons import ADDONS

    assert [addon.change_of(a.do) for a in ADDONS[:7]] == [
        "faster", "other side", "after a reversal", "longer stylus", "turned", "warmer", "longer log"
    ]  # fmt: skip
    assert addon.change_of("ask the machine builder") is None


def test_faster_touches_differ_in_speed_and_come_later(case: blocks.Case) -> None:
    both = _both(case, "faster")
    picks = np.unique(np.linspace(0, OLD - 1, 80).astype(int))
    assert both.rows == OLD + 80
    speed = both.columns["speed_X_mm_s"]
    assert speed[OLD:] == pytest.approx(2.5 * speed[:OLD][picks])
    assert both.q["Y"][OLD:] == pytest.approx(both.q["Y"][:OLD][picks])
    assert both.columns["time_s"][OLD] == pytest.approx(both.columns["time_s"][OLD - 1] + 600.0)
    assert both.series["time_s"][-1] >= both.columns["time_s"][-1]


def test_a_touch_goes_inwards_from_either_side(case: blocks.Case) -> None:
    # touched along -n: an axis along n keeps its sense, an axis across it turns its sense round
    both, old = _both(case, "other side"), case.design
    picks = np.unique(np.linspace(0, OLD - 1, 80).astype(int))
    for i, a in enumerate("XYZ"):
        along = np.abs(old.normal[picks, i]) > 0.5
        was, now = old.columns[f"sense_{a}"][picks], both.columns[f"sense_{a}"][OLD:]
        assert (now[along] == was[along]).all()
        assert (now[~along] == -was[~along]).all()


def test_way_since_the_reversal_is_a_tenth(case: blocks.Case) -> None:
    both, old = _both(case, "after a reversal"), case.design
    first = taken(old).legs[0]
    n = old.normal[0]
    axis = "XYZ"[int(np.abs(n).argmax())]
    far = abs(float((first[0] - first[-1]) @ n))
    assert both.columns[f"since_reversal_{axis}_mm"][OLD] == pytest.approx(0.1 * far)


def test_longer_stylus_and_turned_artefact(case: blocks.Case) -> None:
    stylus, old = _both(case, "longer stylus"), case.design
    assert set(stylus.labels["stylus"]) == {"s0", "s0 long"}
    assert stylus.columns["stylus_length_mm"][OLD] == pytest.approx(2 * old.columns["stylus_length_mm"][0])
    assert stylus.nominal_tip()[OLD] == pytest.approx(old.nominal_tip()[0])  # the same place is touched
    turned = _both(case, "turned")
    assert turned.labels["pose"][-1] == "p0 turned"
    assert turned.normal[OLD] == pytest.approx([-old.normal[0, 1], old.normal[0, 0], old.normal[0, 2]])
    picks = np.unique(np.linspace(0, OLD - 1, 80).astype(int))
    a, b = old.nominal_tip()[picks], turned.nominal_tip()[OLD:]
    assert np.linalg.norm(b - b.mean(axis=0), axis=1) == pytest.approx(
        np.linalg.norm(a - a.mean(axis=0), axis=1)
    )


def test_what_cannot_be_done_is_said(case: blocks.Case, tmp_path: Path) -> None:
    bar = blocks.build("F", 4, BAR, tmp_path)
    with pytest.raises(NotPossible, match="one distance"):
        _both(bar, "after a reversal")
    with pytest.raises(NotPossible, match="no artefact"):
        _both(bar, "turned")
    assert (_both(bar, "other side").columns["sense_X"][bar.design.rows :] != 0).all()


@pytest.mark.parametrize("change", ["other side", "longer stylus", "turned", "warmer"])
def test_first_readings_stay_and_the_rest_is_the_same_machine(case: blocks.Case, change: str) -> None:
    both = _both(case, change)
    values = addon.measured(case, both, np.random.default_rng(2))
    assert (values[:OLD] == case.values).all()
    d, m = both, case.machine
    six = {a: m.stored(a, d.q[a]) for a in m.kind.linear}
    known = observed(d, tip_motion(d, Errors(six, m.square)), Hidden())
    white = whitener(both)
    hidden = addon.hidden_on(case, both)
    left = white.apply(values - known - effect_of(Setting(both, m, white), hidden))
    # nothing but scatter is left: chi-square over degrees of freedom, 580 rows of kurtosis 6: 1 +- sqrt(5 / 580) = 0.09
    assert left @ left / (len(left) - white.basis.shape[1]) == pytest.approx(1.0, abs=0.25)
