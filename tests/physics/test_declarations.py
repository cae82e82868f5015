"""What single effects say of themselves beside their formula: where they can sit, how they are tried, shown and remarked."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.physics.ask import ask
from vcmm.core.declaration import About, KnownRange, SeenByQualification, Site, reported_name
from vcmm.core.effect import Effect, key_fields, known_range, motion, param
from vcmm.core.errors import UsageError
from vcmm.core.run import Array, Run
from vcmm.files.own.effects import build_effect
from vcmm.files.problems import TableProblems
from vcmm.physics import BY_NAME
from vcmm.physics.catalogue.clamping import Clamping
from vcmm.physics.catalogue.dynamics import StructuralVibration
from vcmm.physics.catalogue.encoder import EncoderInterpolation
from vcmm.physics.catalogue.flexure import GradientBending
from vcmm.physics.catalogue.gravity import GravityFlexure
from vcmm.physics.catalogue.laser import CosineError
from vcmm.physics.catalogue.map_interpolation import MapInterpolation
from vcmm.physics.catalogue.probe import ProbeLobing
from vcmm.physics.catalogue.reversal_curve import LostMotionCurve
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.component import ComponentSpline, ComponentTable
from vcmm.physics.structure.geometric_change import GeometricChange
from vcmm.physics.structure.residual import CorrelatedField
from vcmm.physics.structure.tip import TipRadius


@dataclass(frozen=True, eq=False)
class Yielding(Effect):
    """A frame that gives way under acceleration: a parameter whose dimension, s^2, has no name."""

    name = "yielding"
    link = "X"
    give: float = param(0.0, "um/(m/s^2)", "displacement per acceleration")

    def error_motion(self, run: Run) -> Array:
        return motion(run, X=-self.give * run.column("acceleration_X_mm_s2"))


CUBE = np.array([[x, y, z] for x in (0.0, 400.0) for y in (0.0, 300.0) for z in (-200.0, 0.0)])


def run(**positions: list[float]) -> Run:
    n = len(next(iter(positions.values())))
    return Run({a: np.array(q) for a, q in positions.items()}, np.zeros((n, 3)))


def site(rows: Run, *effects: object, work: str = "", tool: str = "XYZ") -> Site:
    return Site(effects, tuple(work), tuple(tool), rows)


def test_a_change_spans_the_recorded_travel_but_no_full_turn():
    change = GeometricChange.diagnosis.make_at(
        GeometricChange, {"component": "EXX"}, site(run(X=[30.0, 10.0, 70.0]))
    )
    assert change.nodes.tolist() == [10.0, 70.0]
    with pytest.raises(UsageError, match="after a full turn"):
        GeometricChange.diagnosis.make_at(
            GeometricChange, {"component": "ECC"}, site(run(C=[0.0, 6.1]))
        )  # 350 deg; 345 are a full turn
    assert (
        GeometricChange.diagnosis.make_at(GeometricChange, {"component": "ECC"}, site(run(C=[0.0, 6.0]))).link
        == "C"
    )  # 344 deg


def test_a_curve_of_lost_motion_needs_four_places():
    assert LostMotionCurve.diagnosis.make_at(
        LostMotionCurve, {"axis": "X"}, site(run(X=[1.0, 2.0, 3.0, 4.0, 4.0]))
    ).nodes.tolist() == [
        1.0,
        4.0,
    ]
    with pytest.raises(UsageError, match="four places"):
        LostMotionCurve.diagnosis.make_at(LostMotionCurve, {"axis": "X"}, site(run(X=[1.0, 2.0, 4.0, 4.0])))


def test_a_guide_knows_on_which_side_it_is():
    place = {"axis": "Y", "direction": "z"}
    assert (
        GradientBending.diagnosis.make_at(
            GradientBending, place, site(run(Y=[0.0]), work="Y", tool="XZ")
        ).carries
        == "workpiece"
    )
    assert GradientBending.diagnosis.make_at(GradientBending, place, site(run(Y=[0.0]))).carries == "tool"


def test_only_a_head_that_turns_has_attitudes():
    assert (
        GravityFlexure.diagnosis.make_at(GravityFlexure, {}, site(run(X=[0.0]), tool="XYZA")).name
        == "gravity_flexure"
    )
    with pytest.raises(UsageError, match="without a head"):
        GravityFlexure.diagnosis.make_at(GravityFlexure, {}, site(run(X=[0.0]), work="C"))


def test_a_clamped_part_is_as_long_as_it_was_touched():
    rows = run(X=[0.0, 0.0]).with_columns(
        {f"part_{c}_mm": np.array(v) for c, v in zip("xyz", ([3, -80.0], [1, 2.0], [0, 60.0]))}
    )
    assert Clamping.diagnosis.make_at(Clamping, {"direction": "z"}, site(rows)).length == 80.0


def test_a_table_between_its_nodes_stands_on_the_table_of_the_machine():
    table = ComponentTable("EXX", ("X",), (np.array([0.0, 50.0, 100.0]),), np.zeros(3))
    made = MapInterpolation.diagnosis.make_at(
        MapInterpolation, {"component": "EXX"}, site(run(X=[0.0]), table)
    )
    assert made.nodes.tolist() == [0.0, 50.0, 100.0]
    with pytest.raises(UsageError, match="no table of EYX"):
        MapInterpolation.diagnosis.make_at(MapInterpolation, {"component": "EYX"}, site(run(X=[0.0]), table))
    trials = ask(made, "trials", "shape")
    assert trials is not None
    # half the weight for smooth and ripple together, half for one height in each of the two meshes
    assert [c["shape"] for c, _ in trials] == ["smooth", "ripple", "cells"]
    assert np.exp([w for _, w in trials]) == pytest.approx([0.25, 0.25, 0.5])
    assert ask(made, "trials", "nodes") is None


def test_tables_and_fields_are_known_within_their_nodes():
    grids = (np.array([-200.0, 0.0]), np.array([0.0, 150.0, 400.0]))
    table = ComponentTable("EBX", ("Z", "X"), grids, np.zeros((2, 3)))
    what = "range of the table EBX"
    assert table.known_range() == (KnownRange(what, 2, -200.0, 0.0), KnownRange(what, 0, 0.0, 400.0))
    assert table.own_nodes() is None
    spline = ComponentSpline("EYX", np.array([0.0, 10.0, 30.0]), np.zeros(3))
    assert spline.known_range() == (KnownRange("range of the table EYX", 0, 0.0, 30.0),)
    assert spline.own_nodes().tolist() == [0.0, 10.0, 30.0]
    field = CorrelatedField(CUBE, np.full((8, 3), 1e-3))
    assert field.known_range()[2] == KnownRange("range of correlated_field", 2, -200.0, 0.0, "tip")
    assert known_range(ScaleFactor("X")) == ()
    assert ComponentTable("ECC", ("C",), (np.array([0.0, 1.0]),), np.zeros(2)).known_range() == ()


def test_only_a_field_fixes_its_own_covariance():
    # K = exp(-d^2 / (2 length^2)): one for a node with itself, exp(-200^2 / (2 150^2)) = 0.4111 for two 200 mm apart
    covariance = CorrelatedField(CUBE, np.full((8, 3), 1e-3), 150.0).covariance()
    assert covariance[0, 0] == pytest.approx(1.0)
    assert covariance[0, 3] == pytest.approx(0.4111, abs=1e-4)


def test_an_amplitude_of_a_square_is_reported_as_an_angle():
    # share 4 of theta^2 is an angle of 2 theta; a negative share is no angle
    name, values, unit = ask(CosineError(1e-3), "report", np.array([4.0, -1.0]))
    assert (name, unit) == ("theta", "mrad")
    assert values == pytest.approx([2e-3, 0.0])
    assert ask(ScaleFactor("X"), "report", np.array([4.0])) is None


def test_remarks():
    turn = run(C=[0.0, 6.2], X=[0.0, 6.2])
    assert "a saw over a full turn of C" in ask(ScaleFactor("C"), "remark", turn)
    assert ask(ScaleFactor("X"), "remark", turn) == ""
    assert ask(ScaleFactor("C"), "remark", run(C=[0.0, 3.0])) == ""
    assert ask(EncoderInterpolation("X", period=0.02, harmonic=2), "remark", turn).startswith(
        "a wave of 0.01 mm"
    )
    assert ask(EncoderInterpolation("X", period=0.02), "remark", turn) == ""


def test_ringing_is_told_after_the_acceleration_only():
    ringing = StructuralVibration("X")
    late = run(X=[0.0, 1.0]).with_columns({"time_since_accel_s": np.array([0.0, 0.1])})
    never = run(X=[0.0, 1.0]).with_columns({"time_since_accel_s": np.zeros(2)})
    assert ask(ringing, "shows_in", late)
    assert not ask(ringing, "shows_in", never)
    assert ask(StructuralVibration("X", follows=1), "shows_in", never)
    assert ask(ringing, "shows_in", run(X=[0.0]))


def test_qualification_is_seen_by_what_it_touches_with():
    spheres = {"down": object(), "side": object()}
    assert set(ProbeLobing("").after_qualification(spheres).spheres) == {"down", "side"}
    assert set(ProbeLobing("down").after_qualification(spheres).spheres) == {"down"}
    assert not isinstance(TipRadius("down"), SeenByQualification)  # a radius is what qualification finds


def test_who_answers_for_what():
    owners = {
        name: BY_NAME[name].about.belongs_to for name in ("backlash", "tool_wear", "work_offset", "clamping")
    }
    assert owners == {
        "backlash": "machine",
        "tool_wear": "tool",
        "work_offset": "setup",
        "clamping": "part",
    }
    assert reported_name(BY_NAME["settling_drift"]) == "linear_drift"
    assert reported_name(BY_NAME["linear_drift"]) == "linear_drift"


def test_every_further_key_declares_what_it_holds():
    """A key whose default is neither a number nor a text must say so: files could not read it."""
    for kind in BY_NAME.values():
        for f in key_fields(kind):
            assert "kind" in f.metadata or isinstance(f.default, float | str | int), f"{kind.name}.{f.name}"


def test_what_the_program_fills_in_is_no_key():
    with pytest.raises(TableProblems, match='unknown key "measured"'):
        build_effect({"effect": "component_table", "component": "EXX", "measured": "0 100 mm"})


def test_a_declaration_beside_diagnosis_is_refused():
    """Nothing would read it."""
    with pytest.raises(UsageError, match=r"Own: special_case_of belongs into diagnosis"):
        type("Own", (ScaleFactor,), {"special_case_of": ("geometric_change",)})


def test_a_parameter_may_have_any_unit_that_can_be_read(monkeypatch):
    monkeypatch.setitem(BY_NAME, "yielding", Yielding)
    # 5e-3 mm / (1e3 mm/s^2) = 5e-6 s^2; 2 mm / (1e3 mm/s^2) = 2e-3 s^2
    assert build_effect({"effect": "yielding", "give": "5 um/(m/s^2)"}).give == pytest.approx(5e-6, rel=1e-14)
    rows = replace(run(X=[0.0]), columns={"acceleration_X_mm_s2": np.array([1000.0])})
    five = build_effect({"effect": "yielding", "give": "5 um/(m/s^2)"})
    assert five.error_motion(rows)[0, 0] == pytest.approx(-5e-3, rel=1e-14)  # at 1 m/s^2
    assert build_effect({"effect": "yielding", "give": "2 mm s^2/m"}).give == pytest.approx(2e-3, rel=1e-14)
    with pytest.raises(TableProblems) as caught:
        build_effect({"effect": "yielding", "give": "5 um/m"})
    assert "is not in um/(m/s^2) or another unit of that dimension" in str(caught.value.found[0][1])


def test_a_declaration_that_nothing_reads_is_refused():
    """A word that is misspelt, or of an older version, was passed over."""
    with pytest.raises(UsageError, match=r"Own: nothing reads 'belongs_too'.*belongs_to"):
        type("Own", (ScaleFactor,), {"belongs_too": "tool"})
    own = type(
        "Own",
        (ScaleFactor,),
        {
            "about": About(belongs_to="tool"),
            "_letters": "XY",
            "__annotations__": {"LEAST": "ClassVar[int]"},
            "LEAST": 3,
        },
    )
    assert own.about.belongs_to == "tool"
