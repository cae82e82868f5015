"""Criteria of contact through measure and uncertainty: every tier evaluates them on the points, none takes another."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import scenario
from vcmm.answer.evaluation import additions, inversion
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.evaluation.virtual_measurement import measure_task
from vcmm.part.part import Characteristic
from vcmm.task.measuring.settings import Settings

SIZES = tuple(Characteristic(word, "size", of=("bore",), criterion=word) for word in ("GG", "GC", "GN", "GX"))
LOCAL = tuple(Characteristic(w, "size", of=("bore",), criterion=w) for w in ("LP SX", "LP SN", "LS SN"))
FORM = tuple(Characteristic(f"form {w}", "cylindricity", of=("bore",), criterion=w) for w in "GCNX")
TILT = tuple(
    Characteristic(
        f"tilt {w}", "parallelism", of=("left",), datums=("right",), criterion=w, datum_criterion=w
    )
    for w in "GCT"
)
ALL = (*SIZES, *LOCAL, *FORM, *TILT)


def by_name(found):
    return {c.name: c for c in found.characteristics}


def test_a_measurement_orders_the_sizes_as_their_definitions_do():
    task = scenario(characteristics=ALL).task()
    for seed in (1, 2, 3):
        v = {m.name: m.value for m in measure_task(task, seed).values}
        assert v["GX"] < v["GG"] < v["GN"]
        assert v["GX"] < v["GC"] < v["GN"]
        assert v["GX"] - 1e-6 <= v["LS SN"] <= v["LP SN"] + 1e-6
        assert v["LP SN"] < v["LP SX"] < v["GN"]
        assert v["form C"] == min(v[f"form {w}"] for w in "GCNX")
        assert v["form C"] < v["form G"]
    perfect = {m.name: m.value for m in measure_task(task).values}
    assert [perfect[w] for w in ("GG", "GC", "GN", "GX", "LP SX", "LS SN")] == pytest.approx(
        [30.0] * 6, abs=1e-9
    )


def test_an_oval_is_seen_by_each_criterion_as_they_are():
    # an oval of 5 um: cos(2 theta) is 1 and -1 at two opposite touches each of the eight of a level
    task = scenario(characteristics=(*SIZES, *FORM)).task()
    turn = np.arctan2(*(task.touches.points[task.touches.rows["bore"]].T[[1, 0]]))
    form = np.zeros(len(task.form))
    lobes = 5e-3 * np.cos(2 * turn)  # outward normal of a bore points to the axis: radius falls by it
    form[task.touches.rows["bore"]] = lobes
    v = {m.name: m.value for m in measure_task(replace(task, form=form)).values}
    assert v["GG"] == pytest.approx(30.0, abs=1e-5)
    assert v["GN"] == pytest.approx(30.0 + 2 * 5e-3, abs=1e-5)
    assert v["GX"] == pytest.approx(30.0 - 2 * 5e-3, abs=1e-5)  # within form^2 / radius
    assert v["form C"] == pytest.approx(10e-3, abs=1e-5)


@pytest.mark.thorough
def test_tiers_agree(monkeypatch):
    monkeypatch.setattr(inversion, "BY_CONTACT", (200, 200))
    monkeypatch.setattr(inversion, "COUNT_TRIALS", (60, 60))
    monkeypatch.setattr(additions, "ADDED_BY_CONTACT", 100)
    quick = Settings(trials=1000, certify=20)
    some = (*SIZES, LOCAL[0], LOCAL[2], FORM[0], FORM[1], *TILT[1:])
    task = scenario(characteristics=some).task()
    sampled, exact = by_name(evaluate(task, quick)), by_name(evaluate(task, replace(quick, engine="exact")))
    for name in (c.name for c in some):
        a, b = sampled[name], exact[name]
        assert a.value == pytest.approx(b.value, abs=1e-7), name
        assert a.mean == pytest.approx(b.mean, abs=1e-4), name
        assert a.u == pytest.approx(b.u, rel=0.15), name
        if name not in ("GG", "form G"):
            assert a.linear_error < 1e-6, name  # evaluated on the points themselves
            assert a.true_value is not None
            assert a.true_value.is_claimed == a.coverage_shown
    # extremes move one way: 16 touches of 1 um each
    assert sampled["GX"].mean < 30.0 - 1e-3 < 30.0 + 1e-3 < sampled["GN"].mean
    assert sampled["GN"].u > sampled["GG"].u
    low, high = sampled["GN"].true_value.interval
    assert low < sampled["GN"].true_value.estimate < high


@pytest.mark.thorough
def test_the_note_about_a_place_that_is_one_of_several_reaches_the_reader(monkeypatch):
    monkeypatch.setattr(inversion, "BY_CONTACT", (200, 200))
    monkeypatch.setattr(inversion, "COUNT_TRIALS", (60, 60))
    task = scenario(characteristics=(Characteristic("GX", "size", of=("bore",), criterion="GX"),)).task()
    turn = np.arctan2(*(task.touches.points[task.touches.rows["bore"]].T[[1, 0]]))
    form = np.zeros(len(task.form))
    form[task.touches.rows["bore"]] = 5e-3 * np.cos(2 * turn)
    oval = replace(task, form=form)
    assert any("is not the only one" in w for w in measure_task(oval).warnings)
    assert any("is not the only one" in w for w in evaluate(oval, Settings(trials=1000, certify=0)).warnings)
