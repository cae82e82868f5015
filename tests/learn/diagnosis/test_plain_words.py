"""Every family has words for the operator, with its numbers in them."""

from __future__ import annotations

from vcmm.core.declaration import reported_name
from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.learn.diagnosis.plain_words import plain_words
from vcmm.physics import ALL, BY_NAME
from vcmm.show.tables.diagnosis import with_interval


def test_every_family_has_words():
    due = {reported_name(kind) for kind in ALL if kind.diagnosis.is_named} & set(BY_NAME)
    assert [name for name in due if BY_NAME[name].about.words is None] == []
    assert plain_words("map_mistake", {"component": "EXX"}, {}).startswith("The stored table of EXX is not")


def test_words_hold_the_numbers():
    gap = Estimate(1.21, 0.08, (1.05, 1.37), "um")
    said = plain_words("backlash", {"axis": "Y"}, {"gap": gap})
    assert said.startswith("Y stops 1.21 um short after reversing; usually wear of the Y nut or belt")
    assert "confirm by" in said
    other = plain_words("backlash", {"axis": "Y"}, {"gap": Estimate(-1.21, 0.08, (-1.37, -1.05), "um")})
    assert "too far" in other  # a compensation that overdoes it
    assert plain_words("my_own", {}, {}) == ""
    bare = plain_words("thermal_drift", {"direction": "z", "sensor": "air"}, {})
    assert "{" not in bare
    assert "()" not in bare


def test_every_sign_is_said():
    def said(effect, where, **numbers):
        found = {
            n.replace("Kv", "1/Kv"): Estimate(v, 0.1, (v - 0.2, v + 0.2), unit)
            for n, (v, unit) in numbers.items()
        }
        return plain_words(effect, where, found)

    x, z = {"axis": "X"}, {"direction": "z", "sensor": "air"}
    assert "too short in proportion to the distance (-9 um/m)" in said("scale_factor", x, k=(-9.0, "um/m"))
    assert "too far in proportion" in said("scale_factor", x, k=(9.0, "um/m"))
    lost = said("lost_motion", x, g0=(-2.17, "um"), g1=(-9.35, "um/m"))
    assert lost.startswith("X stops too far after reversing")
    assert "(-2.17 um at zero, -9.35 um/m)" in lost
    down = said("thermal_drift", z, k=(-1.33, "um/K"), tau=(3750.0, "s"))
    assert down.startswith("The tip moves towards -z as the temperature air rises (-1.33 um/K, after 3750 s)")
    assert "(-0.979 times the full correction)" in said("air_index", {}, scale=(-0.979, "1"))
    assert "(-420 mm)" in said("dead_path", {}, length=(-420.0, "mm"))
    assert "1/Kv longer by 0.2 ms" in said("servo_lag", x, Kv=(0.2, "ms"))
    assert "smaller than qualified" in said("tip_radius", {}, dr=(-1.0, "um"))
    assert "towards -z by 3 um" in said("step_change", {"direction": "z"}, a=(-3.0, "um"))


def test_values_have_the_digits_of_their_uncertainty():
    assert with_interval(Estimate(1.5, 0.19, (1.12, 1.871), "um")) == "1.50 µm (95 %: 1.12 to 1.87)"
    assert (
        with_interval(Estimate(0.2, 0.0021, (0.1959, 0.2041), "ms")) == "0.2000 ms (95 %: 0.1959 to 0.2041)"
    )
    assert with_interval(Estimate(3749.98, 1260.0, (1934.81, 7268.07), "s")) == "3750 s (95 %: 1935 to 7268)"
    assert with_interval(Estimate(0.979, 0.022, (0.936, 1.022), "1")) == "0.979 (95 %: 0.936 to 1.022)"
