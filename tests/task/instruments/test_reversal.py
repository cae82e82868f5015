"""Reversals against numbers computed by hand, and their simulators against the kinematics."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import cache

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.physics.structure.squareness import RotaryLocation
from vcmm.task.instruments.reversal import ReversalTest, separate_errors
from vcmm.task.instruments.reversal_line import LineScan, squareness_reversal, straightness_reversal
from vcmm.task.instruments.reversal_simulation import (
    Form,
    Sampling,
    axis_motion,
    simulated_values,
)
from vcmm.task.instruments.reversal_turns import TurnGroup, turn_group

NM = 1e-6  # mm
FACE = ReversalTest("face", "EZC", "EBC", {"centre": 0.0, "outer": 25.0})


def simulated_turns(
    test: ReversalTest,
    machine: Machine,
    artefact: Form,
    setups: Sequence[str],
    orders: int,
    sampling: Sampling,
    rng: np.random.Generator,
    axis: str = "C",
) -> list[TurnGroup]:
    """Simulate the groups of a whole test. artefact: its form under the outer (or only) probe, mm over its own angle."""
    read = simulated_values(test, machine, artefact, setups, sampling, rng=rng, axis=axis)
    return [turn_group(setup, probe, angle, value, orders) for setup, probe, angle, value in read]


def simulated_straightness(
    machine: Machine,
    axis: str,
    direction: str,
    straightedge: Form,
    places: Array,
    scans: int,
    u: float,
    rng: np.random.Generator,
    lying: float = 1e-5,
    at: Mapping[str, float] | None = None,
    height: Sequence[float] = (0.0, 0.0, 0.0),
) -> list[LineScan]:
    """Simulate scans along a linear axis, `scans` in either set-up; the straightedge lies along it within `lying` rad in every scan.

    height (3,) mm: the place of the probe from the axis frame (a carried probe) or of the tip offset. The straightness is the
    axis's own motion: that of the table for an axis that carries the workpiece.
    """
    n, carried = len(places), axis in machine.chain.work
    position = {a: np.full(n, (at or {}).get(a, 0.0)) for a in machine.chain.letters} | {axis: places}
    offset = np.tile(np.asarray(height, dtype=float), (n, 1))
    if carried:  # the probe is on the table, the straightedge on the tool's side: the place on it moves on
        offset[:, "XYZ".index(axis)] -= places
    moved = machine.tip_error(Run(position, offset), exact=True)[:, "XYZ".index(direction)]
    motion = -moved if carried else moved
    form, out = straightedge(places), []
    for setup, sense in (("normal", 1.0), ("reversed", -1.0)):
        for _ in range(scans):
            line = lying * rng.standard_normal() * places
            out.append(LineScan(setup, places, form + sense * motion + line + u * rng.standard_normal(n)))
    return out


def simulated_half_turn(
    machine: Machine,
    flat: Callable[[Array], Array],
    places: Array,
    scans: int,
    u: float,
    rng: np.random.Generator,
    axis: str = "X",
    turning: str = "C",
    at: Mapping[str, float] | None = None,
) -> list[LineScan]:
    """Simulate scans of a flat on the turning axis, at 0 and 180 deg; flat: its height (n,) mm over its own x (n,) mm, tilt included."""
    out = []
    for setup, angle in (("normal", 0.0), ("reversed", np.pi)):
        position = {a: np.full(len(places), (at or {}).get(a, 0.0)) for a in machine.chain.letters}
        position |= {axis: places, turning: np.full(len(places), angle)}
        moved = machine.tip_error(Run(position, np.zeros((len(places), 3))), exact=True)[:, 2]
        indication = flat(places * (1.0 if setup == "normal" else -1.0)) - moved
        out += [
            LineScan(setup, places, indication + u * rng.standard_normal(len(places))) for _ in range(scans)
        ]
    return out


def group(setup, probe, *turns):
    """Turns of given orders, in nm."""
    return TurnGroup(setup, probe, np.array(turns, dtype=complex) * NM, np.zeros((len(turns), 360)))


def lathe(*effects, frame="fixed"):
    axes = {
        "X": Axis("X", (-50, 50)),
        "C": Axis("C", (-1e3, 1e3), error_frame=frame),
        "Z": Axis("Z", (-10, 10)),
    }
    return Machine("lathe", "lathe", parse_structure("w C' X' b Z t"), axes, effects)


def test_face_reversal_by_hand():
    """Two per turn: EZC 2 nm, EBC 0.4 urad, artefact 5 nm, arm 25 mm, z = -x EBC. Outer: 2 - 10 + 5 = -3, turned over 2 + 10 + 5 = 17
    nm; so EBC = (17 + 3) / 50 = 0.4 urad and the artefact (17 - 3) / 2 - 2 = 5 nm. Turns +-1 nm about these: 4 nm^2 over 4 degrees
    (cosine and sine, two set-ups) is 1 nm^2 a turn, 0.5 nm^2 a mean. EZC is the mean of two means, u = 0.5 nm; EBC their difference
    over 50 mm, u = 1 nm / 50 mm = 0.02 urad.
    """
    groups = [
        group("normal", "centre", [0, 3], [0, 1]), group("normal", "outer", [0, -2], [0, -4]),
        group("reversed", "centre", [0, 3], [0, 1]), group("reversed", "outer", [0, 18], [0, 16]),
    ]  # fmt: skip
    found = separate_errors(FACE, groups)
    assert found.value[:, 1] == pytest.approx([2 * NM, 0.4e-6, 5 * NM])
    assert np.sqrt(np.diag(found.covariance[1]))[:2] == pytest.approx([0.5 * NM, 0.02e-6])
    assert found.dof == 4.0
    assert found.curve("EBC", np.array([0.0, np.pi / 2])) == pytest.approx([0.4e-6, -0.4e-6])


def test_face_reversal_does_not_tell_once_per_turn():
    """A flat that lies slantwise moves the outer probe once per turn, anew in every set-up: EBC has no first order, EZC has."""
    groups = [
        group("normal", "centre", [2, 0], [2.1, 0.1]), group("normal", "outer", [40, 0], [40.1, 0.1]),
        group("reversed", "centre", [2, 0], [2.1, 0.1]), group("reversed", "outer", [-7, 0], [-7.1, 0.1]),
    ]  # fmt: skip
    found = separate_errors(FACE, groups)
    assert (found.blind("EBC"), found.blind("EZC")) == ([1], [])
    assert found.value[0, 0] == pytest.approx(2.05 * NM)
    assert found.value[1, 0] == 0.0
    off = ReversalTest(
        "face", "EZC", "EBC", FACE.arms, u_centre=0.05
    )  # the flat leans by 40 nm / 25 mm = 1.6 urad
    assert separate_errors(off, groups).covariance[0, 0, 0] - found.covariance[0, 0, 0] == pytest.approx(
        (40.05 * NM / 25 * 0.05) ** 2, rel=1e-6
    )


@pytest.mark.parametrize(
    ("setups", "blind"),
    [(("0", "90", "180", "270"), [1, 4, 8]), (("0", "45"), [1, 8]), (("0", "30", "90"), [1])],
    ids=["four steps", "one step", "three unequal steps"],
)
def test_blind_orders_of_a_multi_step_test(setups, blind):
    """Orders k with exp(-i k phi) = 1 in every position: 4 and 8 for steps of 90 deg, 8 for 45 deg, 12 for 30 and 90 deg."""
    machine, form = (
        lathe(RotaryCyclic("EXC", np.array([0, 0, 2, 1, 0, 3]) * NM)),
        lambda q: 5 * NM * np.cos(3 * q),
    )
    test = ReversalTest("multi-step", "EXC")
    groups = simulated_turns(
        test, machine, form, setups, 8, Sampling(4, 90, 1e-9, 1e-3), np.random.default_rng(0)
    )
    found = separate_errors(test, groups)
    assert found.blind("EXC") == found.blind("artefact") == blind
    assert found.value[0, 1:3] == pytest.approx(np.array([2 - 1j, -3j]) * NM, abs=0.01 * NM)
    assert found.value[1, 2] == pytest.approx(5 * NM, abs=0.01 * NM)


def test_donaldson_separates_all_but_the_centring():
    machine = lathe(RotaryCyclic("EXC", np.array([7, 0, 2, 1]) * NM))
    test = ReversalTest("donaldson", "EXC", sense=-1.0)
    setups = ("normal", "reversed")
    rng = np.random.default_rng(0)
    groups = simulated_turns(
        test, machine, lambda q: 5 * NM * np.cos(2 * q), setups, 3, Sampling(4, 90, 1e-9, 1e-3), rng
    )
    found = separate_errors(test, groups)
    assert found.blind("EXC") == [1]
    assert found.value[:, 1] == pytest.approx([(2 - 1j) * NM, 5 * NM], abs=0.01 * NM)


def test_what_is_read_on_the_axis_has_its_first_order():
    """Axial motion is read on the axis, where no centring counts; a radial one once per turn is the centring."""
    for error, blind in (("EZC", []), ("EXC", [1]), ("ECC", [])):
        groups = [group("", "", [3, 1], [3.1, 1])]
        assert separate_errors(ReversalTest("direct", error), groups).blind(error) == blind


def test_simulated_motion_is_that_of_the_fixed_frame():
    """EBC = 1 urad cos 2q, fixed frame: at x = 25 mm the face goes down by 25 nm at q = 0. In the moving frame a constant EBC of the
    part is seen as cos q from outside.
    """
    q = np.array([0.0, np.pi / 4, np.pi / 2])
    fixed = lathe(RotaryCyclic("EBC", np.array([0, 0, 1e-6, 0])))
    assert axis_motion(fixed, "C", q, (25, 0, 0))[:, 2] == pytest.approx(
        np.array([-25, 0, 25]) * NM, abs=1e-12
    )
    moving = lathe(ComponentPolynomial("EBC", np.array([1e-6])), frame="moving")
    assert axis_motion(moving, "C", q, (25, 0, 0))[:, 2] == pytest.approx(-25 * NM * np.cos(q), abs=1e-11)
    with pytest.raises(UsageError, match="does not turn about Z"):
        axis_motion(fixed, "X", q, (0, 0, 0))


def test_straightness_by_hand():
    """Straightedge (0, 4, 0) nm, machine (0, 1, 0) nm at 0, 10, 20 mm, a slope in the second scan: readings (0, 5, 0) and (0, 3 + 2, 4).

    Less its line (0, 1, 0) is (-1/3, 2/3, -1/3).
    """
    x = np.array([0.0, 10.0, 20.0])
    scans = [
        LineScan("normal", x, np.array([0, 5.0, 0]) * NM),
        LineScan("reversed", x, np.array([0, 5.0, 4]) * NM),
    ]
    found = straightness_reversal(scans, u=1 * NM)
    assert found.machine == pytest.approx(np.array([-1, 2, -1]) / 3 * NM)
    assert found.artefact == pytest.approx(np.array([-1, 2, -1]) * 4 / 3 * NM)
    assert straightness_reversal(scans, -1.0, 1 * NM).machine == pytest.approx(-found.machine)
    # u: half of each scan: variance 1/2, less a line: 1 - 1/3 (middle), 1 - 5/6 (ends)
    assert found.u == pytest.approx(np.sqrt(np.array([1 / 6, 2 / 3, 1 / 6]) / 2) * NM)
    with pytest.raises(UsageError, match="shows no scatter"):
        straightness_reversal(scans)
    with pytest.raises(UsageError, match="there are normal"):
        straightness_reversal(scans[:1], u=NM)


def test_half_turn_by_hand():
    """Slopes 3 and -2.2 urad: B0C = -(3 - 2.2) / 2 = -0.4 urad, the flat leans (3 + 2.2) / 2 = 2.6 urad; a tilt motion of 0.1 urad
    at both angles is in it. Slopes scatter +-0.1: s^2 = 4 * 0.01 / 2, u = sqrt(0.02 * (1/2 + 1/2) / 4) = 0.0707.
    """
    x = np.array([-10.0, 0.0, 10.0])
    scans = [
        LineScan(s, x, slope * 1e-6 * x)
        for s, slope in (("normal", 3.1), ("normal", 2.9), ("reversed", -2.1), ("reversed", -2.3))
    ]
    found = squareness_reversal(scans)
    assert (found.angle, found.flat, found.u) == pytest.approx((-0.4e-6, 2.6e-6, 0.0707107e-6))
    assert squareness_reversal(scans, tilt=0.1e-6).angle == pytest.approx(-0.5e-6)


def test_simulated_line_tests_find_what_was_put_in():
    """EZX = 0.1 mm/m^2: 36.1 nm over 38 mm; B0C = 0.4 urad. The probe 5 mm lower sees 5 mm * EAX more (Abbe)."""
    machine = lathe(ComponentPolynomial("EZX", np.array([0, 0, 0.1])), RotaryLocation("B0C", tilt=0.4e-6))
    x, rng = np.linspace(-19, 19, 77), np.random.default_rng(0)
    scans = simulated_straightness(
        machine, "X", "Z", lambda p: 100 * NM * np.sin(p / 5), x, 3, 0.01 * NM, rng
    )
    assert np.ptp(straightness_reversal(scans).machine) == pytest.approx(36.1 * NM, abs=0.1 * NM)
    flat = simulated_half_turn(machine, lambda p: 2e-6 * p + 1e-6 * p**2, x, 3, 0.01 * NM, rng)
    assert squareness_reversal(flat).angle == pytest.approx(0.4e-6, abs=1e-9)
    rolling = machine.with_effect(
        ComponentPolynomial("EAX", np.array([0, 0, 20e-3]))
    )  # 7.22 urad at both ends
    low = simulated_straightness(
        rolling, "X", "Z", lambda p: 0 * p, x, 2, 0.01 * NM, rng, height=(0.0, -5.0, 0.0)
    )
    assert np.ptp(straightness_reversal(low).machine) == pytest.approx(0.0, abs=0.3 * NM)  # 36.1 - 5 * 7.22


def test_turns_lose_drift_and_what_is_not_complete():
    q = np.radians(np.arange(0, 3.5 * 360, 10.0))
    value = NM * (3 * np.cos(2 * q) + 4 * q)
    found = turn_group("normal", "", q, value, 3)
    assert (len(found.coefficients), found.incomplete) == (3, 1)
    assert found.coefficients.mean(axis=0) == pytest.approx(np.array([0, 3, 0]) * NM, abs=1e-12)
    with pytest.raises(UsageError, match="shows no scatter"):
        turn_group("normal", "", q[:36], value[:36], 3)
    with pytest.raises(UsageError, match=r"closer than 5 deg"):
        turn_group("normal", "", q, value, 36)


@cache
def pulls():
    """(trials, orders) of EBC over its stated u."""
    rng, truth = np.random.default_rng(5), 0.4e-6
    machine, out = lathe(RotaryCyclic("EBC", np.array([0, 0, truth, 0]))), []
    for _ in range(150):
        groups = simulated_turns(
            FACE,
            machine,
            lambda q: 5 * NM * np.cos(2 * q),
            ("normal", "reversed"),
            4,
            Sampling(5, 24, NM, 1e-6),
            rng,
        )
        found = separate_errors(FACE, groups)
        left = found.value[1] - truth * (np.arange(4) == 1)
        out.append(left[1:].real / np.sqrt(found.covariance[1:, 1, 1]))
    return np.concatenate(out)


def test_stated_uncertainty_holds():
    """450 pulls of Student's law with 16 degrees: 95 % within +-2.120; binomial 0.95 +- 3 * 0.0103."""
    assert 0.919 <= (np.abs(pulls()) < 2.120).mean() <= 0.981


def test_the_band_of_a_straightness_holds():
    """60 tests of 3 + 3 scans at 39 places, white noise and a walk: 95 % within Student's law, pooled; places of one test err alike, so
    that the 2340 count as some hundred: 0.95 +- 3 * 0.02.
    """
    from scipy.stats import t

    rng, x, inside = np.random.default_rng(9), np.linspace(0, 38, 39), []
    truth = 26 * NM * np.cos(x / 6)
    level = truth - np.polyval(np.polyfit(x, truth, 1), x)
    for _ in range(60):
        scans = [
            LineScan(s, x, g * truth + 80 * NM * np.sin(x / 4) + rng.normal() * x + NM * (rng.normal(size=39) + 0.2 * np.cumsum(rng.normal(size=39))))
            for s, g in (("normal", 1), ("reversed", -1)) for _ in range(3)
        ]  # fmt: skip
        found = straightness_reversal(scans)
        inside.append(np.abs(found.machine - level) / found.u < t.ppf(0.975, found.dof))
    assert 0.89 <= np.mean(inside) <= 0.99


def test_wrong_set_ups_are_named():
    with pytest.raises(UsageError, match='there are "normal"'):
        separate_errors(FACE, [group("normal", "centre", [1]), group("normal", "outer", [1])])
    with pytest.raises(UsageError, match="two or more of them"):
        separate_errors(ReversalTest("multi-step", "EXC"), [group("left", "", [1]), group("0", "", [1])])
    with pytest.raises(UsageError, match="needs a probe on the axis"):
        ReversalTest("face", "EZC", "EBC", {"outer": 25.0})
    with pytest.raises(UsageError, match="they must agree"):
        separate_errors(FACE, [group("normal", "inner", [1]), group("reversed", "outer", [1])])
    with pytest.raises(UsageError, match='Did you mean "donaldson"'):
        ReversalTest("donaldsen", "EXC")
