"""What every effect must obey, today's and tomorrow's: one test over vcmm.physics.ALL."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from tests.physics.factory import INSTANCES, scaled, some_run
from vcmm.core.effect import (
    FREE_LINKS,
    Effect,
    basis,
    parameter_fields,
    place_fields,
    required,
    stepped_basis,
    with_parameter,
)
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.core.units import dimension_of, in_unit, quantity
from vcmm.files.own.effects import build_effect
from vcmm.physics import ALL, BY_NAME, find
from vcmm.physics.structure.component import CalibrationModes

RUN = some_run()
each = pytest.mark.parametrize("effect", INSTANCES, ids=lambda e: e.id)
LINKS = (*FREE_LINKS, *"XYZABC")


def test_the_factory_covers_the_catalogue():
    assert {type(e) for e in INSTANCES} == set(ALL)
    assert len({e.name for e in ALL}) == len(ALL) == len(BY_NAME)


@each
def test_says_what_it_is(effect: Effect):
    kind = type(effect)
    assert kind.name
    assert (kind.__doc__ or "").strip()
    assert kind.about.cites
    assert kind.per
    assert effect.link in LINKS
    assert effect.place in ("motion", "travel", "location")
    for f in parameter_fields(kind):
        assert f.metadata["doc"]
        assert f.metadata["unit"] == "mm or rad" or dimension_of(f.metadata["unit"])
    for f in place_fields(kind):
        assert f.metadata["doc"]


@each
def test_is_frozen(effect: Effect):
    name = dataclasses.fields(effect)[0].name
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(effect, name, getattr(effect, name))


@each
def test_default_instance_does_nothing(effect: Effect):
    if any(f.name == "nodes" or f.name == "grids" for f in dataclasses.fields(effect)):
        return  # defaults of tables do not fit this run; zero values are covered below
    still = type(effect)()
    assert np.all(still.error_motion(RUN) == 0.0)


@each
def test_zero_parameters_give_zero_motion(effect: Effect):
    motion = scaled(effect, 0.0).error_motion(RUN)
    assert motion.shape == (RUN.n, 6)
    assert np.all(motion == 0.0)


@each
def test_moves_something_and_stays_finite(effect: Effect):
    motion = effect.error_motion(RUN)
    assert np.isfinite(motion).all()
    assert np.abs(motion).max() > 1e-8


@each
def test_is_linear_in_all_parameters_that_are_not_scanned(effect: Effect):
    one, three = effect.error_motion(RUN), scaled(effect, 3.0).error_motion(RUN)
    assert three == pytest.approx(3.0 * one, rel=1e-12, abs=1e-18)


@each
def test_is_additive_in_each_parameter(effect: Effect):
    # f(p) = f(p with q = 0) + basis(q) q: the basis is the whole of what the parameter does
    whole = effect.error_motion(RUN)
    for f in parameter_fields(effect):
        if f.metadata["scan"]:
            continue
        value = np.asarray(getattr(effect, f.name), dtype=float)
        without = with_parameter(effect, f.name, 0.0 if value.ndim == 0 else np.zeros_like(value))
        part = basis(effect, f.name, RUN) @ value.reshape(-1)
        assert without.error_motion(RUN) + part == pytest.approx(whole, rel=1e-12, abs=1e-15), f.name


@each
def test_rows_do_not_know_of_each_other(effect: Effect):
    whole = effect.error_motion(RUN)
    order = np.array([7, 3, 11, 0, 5, 2, 9, 1, 10, 4, 8, 6])
    assert effect.error_motion(RUN.take(order)) == pytest.approx(whole[order], rel=1e-12, abs=1e-18)
    halves = [effect.error_motion(RUN.take(slice(a, b))) for a, b in ((0, 5), (5, 12))]
    assert np.concatenate(halves) == pytest.approx(whole, rel=1e-12, abs=1e-18)
    assert effect.error_motion(RUN.take(slice(0, 12, 3))) == pytest.approx(whole[::3], rel=1e-12, abs=1e-18)


@each
def test_does_not_change_the_run(effect: Effect):
    before = {k: v.copy() for k, v in RUN.columns.items()}
    effect.error_motion(RUN)
    assert all(np.array_equal(before[k], v) for k, v in RUN.columns.items())


@each
def test_shortcut_response_equals_unit_steps(effect: Effect):
    for f in parameter_fields(effect):
        stepped, known = stepped_basis(effect, f.name, RUN), basis(effect, f.name, RUN)
        size = np.size(getattr(effect, f.name))
        assert stepped.shape == known.shape == (RUN.n, 6, size)
        assert known == pytest.approx(stepped, rel=1e-9, abs=1e-12), f.name


@each
def test_scanned_parameters_have_trial_values_and_a_slope(effect: Effect):
    for f in parameter_fields(effect):
        if f.metadata["scan"]:
            assert all(v > 0 for v in f.metadata["scan"])
            assert np.abs(basis(effect, f.name, RUN)).max() > 0


@each
def test_a_missing_column_is_named(effect: Effect):
    machine = Machine(
        "m", "cmm", parse_structure("w b Y X Z C t"),
        {**{a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}, "C": Axis("C", (-4.0, 4.0))}, (effect,),
    )  # fmt: skip
    assert machine.checked_motion(effect, RUN).shape == (RUN.n, 6)
    for column in required(effect):
        without = {k: v for k, v in RUN.columns.items() if k != column}
        bare = Run(RUN.position, RUN.offset, without, RUN.labels)
        with pytest.raises(ModelLimit, match=f"needs the column {column}, which this run lacks"):
            machine.checked_motion(effect, bare)


def test_axis_effects_need_their_axis():
    bare = Run({"X": np.zeros(2)}, np.zeros((2, 3)))
    with pytest.raises(ModelLimit, match="no position of axis Y"):
        find("scale_factor")("Y", 1e-6).error_motion(bare)


def test_unknown_names_show_the_closest():
    with pytest.raises(UsageError, match='Did you mean "backlash"'):
        find("backlsh")
    with pytest.raises(UsageError, match=r"has no parameter gpa.*gap"):
        with_parameter(find("backlash")("X"), "gpa", 1.0)


CONTRACT = {  # section 6: the parameter that a report and a file must know, with a value in its unit
    "scale_factor": ("k", "5 um/m"), "squareness": ("angle", "3 urad"), "backlash": ("gap", "1.2 um"),
    "scale_expansion": ("alpha", "8 um/(m K)"), "part_expansion": ("alpha", "11.5 um/(m K)"),
    "thermal_drift": ("k", "0.4 um/K"), "screw_pitch": ("amplitude", "0.5 um"),
    "trigger_delay": ("delay", "2 ms"), "tip_radius": ("dr", "0.3 um"), "probe_lobing": ("amplitude", "0.4 um"),
    "stylus_bending": ("c", "0.6 um"), "rotary_location": ("offset", "1.5 um"),
}  # fmt: skip


@pytest.mark.parametrize("name", CONTRACT)
def test_file_takes_the_contract_name_and_unit(name: str):
    parameter, text = CONTRACT[name]
    instance = next(e for e in INSTANCES if e.name == name)
    table = {"effect": name, parameter: text}
    table |= {f.name: getattr(instance, f.name) for f in place_fields(instance)}
    built = build_effect(table)
    inside = type(built).about.aliases.get(parameter, parameter)
    assert getattr(built, inside) == quantity(text, dimension_of(text.split(" ", 1)[1]))
    assert built.id == instance.id


@pytest.mark.parametrize(
    ("name", "parameter", "text"), [("thermal_drift", "tau", "300 s"), ("screw_pitch", "period", "5 mm")]
)
def test_file_takes_the_scanned_parameters(name: str, parameter: str, text: str):
    instance = next(e for e in INSTANCES if e.name == name)
    table = {"effect": name, parameter: text} | {
        f.name: getattr(instance, f.name) for f in place_fields(instance)
    }
    assert getattr(build_effect(table), parameter) == float(text.split()[0])


@each
def test_round_trip_through_a_toml_table(effect: Effect):
    """Every number written in its show unit and read again gives the same motion."""
    if isinstance(effect, CalibrationModes):  # they stand in a file, tests/files/own/test_joint_covariance.py
        with pytest.raises(UsageError, match=re.escape(effect.made_by)):
            build_effect({"effect": effect.name, "component": "EXX"})
        return
    component = str(getattr(effect, "component", ""))
    back = {v: k for k, v in type(effect).about.aliases.items()}
    table: dict[str, object] = {"effect": effect.name}
    table |= {f.name: getattr(effect, f.name) for f in place_fields(effect)}
    for f in parameter_fields(effect):
        if f.metadata["only"] and component[:1] not in tuple(f.metadata["only"]):
            continue
        unit = f.metadata["show"]
        if unit == "mm or rad":
            unit = "rad" if component[1] in "ABC" else "mm"
        values = np.asarray(getattr(effect, f.name), dtype=float)
        rows = values.reshape(-1, 3) if f.metadata["shape"] == "(nodes, 3)" else values.reshape(1, -1)
        ending = "" if unit == "1" else f" {unit}"
        text = [" ".join(repr(in_unit(float(v), unit)) for v in row) + ending for row in rows]
        table[back.get(f.name, f.name)] = text if len(text) > 1 else text[0]
    for key in ("nodes", "deviation", "grids", "arguments", "length", "interpolation"):
        if hasattr(effect, key):
            table[key] = _as_text(key, getattr(effect, key))
    if getattr(effect, "process", None) is not None:
        table |= {key: _as_text(key, getattr(effect, key)) for key in ("scatter", "reading_u")}
        table["process"] = effect.process  # type: ignore[attr-defined]
    again = build_effect(table)
    assert again.id == effect.id
    assert again.error_motion(RUN) == pytest.approx(effect.error_motion(RUN), rel=1e-12, abs=1e-15)


def _as_text(key: str, value: object) -> object:
    if key in ("interpolation", "arguments"):
        return list(value) if isinstance(value, tuple) else value
    if key == "length":
        return f"{value} mm"
    if key == "grids":
        return [" ".join(repr(float(v)) for v in grid) + " mm" for grid in value]  # type: ignore[attr-defined]
    array = np.asarray(value)
    if array.ndim == 1:
        return " ".join(repr(float(v)) for v in array) + " mm"
    return [" ".join(repr(float(v)) for v in row) + " mm" for row in array]
