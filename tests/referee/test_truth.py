"""True values of parts, machines at their limit, and files, by pencil."""

from dataclasses import replace

import numpy as np
import pytest

from referee import machines, simulate
from referee.kinematics import Geometry, perfect
from referee.parts import FAMILIES, Surface
from referee.tasks import BORE, FRONT, LEDGE, SIDE, TASKS, TOP, Characteristic, value


def surface(feature, form=None, **moves):
    made = Surface(feature, np.random.default_rng(0), "perfect", 0.0, 0.0)
    if form:
        made.form = form
    for key, item in moves.items():
        setattr(made, key, item)
    return made


def test_three_points_on_three_lobes_miss_the_size():
    # lobes of 1 um half height met at their peaks: the diameter reads 2 um more, the dense one is nominal
    ring = surface(TASKS["three"].features["ring"], lambda a, h: 0.001 * np.cos(3 * a))
    line = TASKS["three"].characteristics[0]
    features = TASKS["three"].features
    assert value(line, features, {"ring": ring.dense()}) == pytest.approx(30, abs=1e-6)
    touched = ring.at(*TASKS["three"].places["ring"])[0]
    assert value(line, features, {"ring": touched}) == pytest.approx(30.002, abs=1e-7)


def test_a_bowed_ledge_is_not_parallel():
    # ISO 1101: the extracted surface lies between the planes, so a bow of 15 um counts in full
    points = {
        "top": surface(TOP).dense(),
        "ledge": surface(LEDGE, lambda u, v: 0.015 * u**2).dense(),
    }
    features = TASKS["ledge"].features
    parallel, step = TASKS["ledge"].characteristics
    assert value(parallel, features, points) == pytest.approx(0.015, abs=1e-9)
    # the mean of u^2 over 241 even places is 1/3 (1 + 1/120): the least-squares ledge lies higher by 5.04 um
    assert value(step, features, points) == pytest.approx(20 - 0.015 * (1 + 1 / 120) / 3, abs=1e-8)


def test_a_leaning_axis_over_its_length():
    # +-3 um over half the length of 20 mm: the ends lie 6 um apart
    points = {"top": surface(TOP).dense(), "bore": surface(BORE, lean=np.array([0.003, 0.0])).dense()}
    square = TASKS["square"]
    assert value(square.characteristics[0], square.features, points) == pytest.approx(0.006, abs=1e-8)


def test_a_wall_may_turn_about_the_datum_and_not_lean():
    wall = TASKS["wall"]
    points = {"top": surface(TOP).dense()}
    for lean, wanted in ((np.array([0.004, 0.0]), 0.0), (np.array([0.0, 0.004]), 0.008)):
        points["front"] = surface(FRONT, lean=lean).dense()
        assert value(wall.characteristics[0], wall.features, points) == pytest.approx(wanted, abs=2e-8)


def test_position_is_twice_the_departure():
    # the axis stands 3 um in x and 4 um in y beside its place: 2 * 5 um; datums that lie wrong take it with them
    place = TASKS["place"]
    points = {"top": surface(TOP).dense(), "front": surface(FRONT).dense(), "side": surface(SIDE).dense()}
    points["bore"] = surface(BORE, shift=np.array([0.003, 0.004, 0.0])).dense()
    line = place.characteristics[0]
    assert value(line, place.features, points) == pytest.approx(0.010, abs=1e-8)
    # the side's outward normal is -x: it lies 3 um further in x when its height is -3 um
    points["side"] = surface(SIDE, shift=np.array([-0.003, 0, 0])).dense()
    assert value(line, place.features, points) == pytest.approx(0.008, abs=1e-8)


@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("name", ["ring", "bore", "top", "edge"])
def test_every_form_is_small_finite_and_drawn_again_alike(family, name):
    task = next(t for t in TASKS.values() if name in t.features)
    made = [Surface(task.features[name], np.random.default_rng(4), family, 3e-4, 0.0) for _ in range(2)]
    real, nominal, normal = made[0].at(*task.places[name])
    height = np.einsum("ni,ni->n", real - nominal, normal)
    assert np.isfinite(height).all()
    assert np.abs(height).max() < 0.03
    assert (family == "perfect") == (np.ptp(made[0].dense() @ normal[0]) == 0) or name in ("ring", "bore")
    assert np.array_equal(real, made[1].at(*task.places[name])[0])


def test_a_scale_error_at_its_limit():
    # X too long by 1 um/m, no scatter: the length of 540 mm on the X line errs by -0.54 um, its limit is 1.9 + 1.8 um;
    # diagonals err less (the share of x squared over the length), so the scaled machine errs by 3.7 um there
    plain = perfect().errors

    def scale(q):
        table = np.zeros((len(q), 6))
        table[:, 0] = 1e-6 * q
        return table

    geometry = Geometry({**plain, "X": scale}, np.zeros(3), np.zeros(3))
    error, length, _ = machines.e0_errors(geometry)
    along = np.argmin(np.abs(length - 540) + np.abs(error + 0.54e-3))
    assert error[along] == pytest.approx(-0.54e-3, abs=1e-9)
    bare = machines.Machine(geometry, np.zeros((2, 1)), scatter=0.0)
    at_limit = machines.at_limit(np.random.default_rng(0), bare, 1.9e-3, 1 / 300e3, 0.9)
    # the reference sphere has shown the same scale as a radius, which has been taken off both ends
    found = machines.e0_errors(at_limit.geometry)[0][along] - 2 * machines.qualified(at_limit.geometry)
    assert found == pytest.approx(-3.7e-3, abs=2e-6)


def test_play_is_a_radius_on_the_reference_sphere():
    # play g in all axes reads half of it times the sum of |n| too little, for any n; the constant is taken off
    machine = Geometry(perfect().errors, np.zeros(3), np.full(3, 0.002))
    assert -0.001 * np.sqrt(3) < machines.qualified(machine) < -0.001
    assert machines.qualified(perfect()) == pytest.approx(0, abs=1e-12)


def test_a_bore_on_a_machine_with_a_long_scale_reads_small():
    # the machine travels 10 um/m too far in x: error = indicated - true = -tip error; 30 mm read 0.3 um less along x
    errors = {**perfect().errors, "X": lambda q: np.column_stack([1e-5 * q, *[0 * q] * 5])}
    machine = machines.Machine(Geometry(errors, np.zeros(3), np.zeros(3)), np.zeros((2, 1)), scatter=0.0)
    points = np.array([[15.0, 0, 0], [-15.0, 0, 0]])
    normals = -points / 15  # a bore: into the hole
    frame = (np.eye(3), np.array([300.0, 250, -250]))
    read = machines.touch(np.random.default_rng(0), machine, points, normals, frame)
    # the tip's centre is 2 mm nearer to the axis on both sides: 26 mm of travel; the reference sphere read small,
    # so the qualified tip counts as smaller, and a bore as smaller once more
    small = 2 * machines.qualified(machine.geometry)
    assert small < 0
    assert read[0, 0] - read[1, 0] == pytest.approx(30 - 26e-5 + small, abs=1e-8)
    exact = replace(machine, qualify=False)
    read = machines.touch(np.random.default_rng(0), exact, points, normals, frame)
    assert read[0, 0] - read[1, 0] == pytest.approx(30 - 26e-5, abs=1e-8)


def test_shares_and_orders_do_not_matter():
    cell = "evaluate/circle8/lobes/exact"
    known = simulate.table(1, cell)
    one = simulate.measure(1, cell, 7, "circle8", "lobes", "exact", known)
    simulate.measure(1, cell, 3, "circle8", "lobes", "exact", known)
    again = simulate.measure(1, cell, 7, "circle8", "lobes", "exact", known)
    assert one.truth == again.truth
    assert one.value == again.value


def test_what_has_no_definition_is_refused():
    with pytest.raises(ValueError, match="no definition of runout"):
        value(
            Characteristic("x", {"type": "runout", "of": "top", "datums": ("top",)}),
            {"top": TOP},
            {"top": surface(TOP).dense()},
        )
